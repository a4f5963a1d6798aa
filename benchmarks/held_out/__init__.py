"""``make held-out``: the errors of every method of the report at what it has not seen, over all sets at hand.

`sets` says which sets there are and which half judges, `judging` fits and measures one, `summary` makes the tables, and
`pictures` the spheres of a few telling sets.

    python -m benchmarks.held_out [--sets NAME...] [--half judged|chosen|all] [--jobs N] [--resume] [--out FOLDER]
"""
