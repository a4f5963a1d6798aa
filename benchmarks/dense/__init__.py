"""Standard and its rivals on dense measurements, RGL's files and materials of MERL made of nets.

`materials` says which they are, what is true of them and which published models there are, `judging` fits and measures
one, and `harness` goes through them. `sphere` integrates pictures under the `sky`, and `image_errors` compares them.
`summary` writes the tables, `sheet` draws the pictures. `bench` has all of it together.

    python -m benchmarks.dense [--materials NAME...] [--jobs N] [--resume] [--out FOLDER]
"""
