"""``make held-out``: the errors of every method of the report at what it has not seen, over all sets at hand.

`sets` says which sets there are and which half judges, `judging` fits and measures one, and `harness` goes through
them. `summary` writes the tables; `views` computes, beside the errors of a few telling sets, what `pictures` draws,
with `ridge` and `lamps`. `bench` has all of it together.

    python -m benchmarks.held_out [--sets NAME...] [--half judged|chosen|all] [--jobs N] [--resume] [--out FOLDER]
"""
