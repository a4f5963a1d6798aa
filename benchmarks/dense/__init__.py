"""Standard and its rivals on dense measurements, RGL's files and materials of MERL made of nets (docs/results.md).

`materials` says which they are, what is true of them and which published models there are; `judging` fits and measures
one; `sphere` integrates pictures under the `sky`, and `image_errors` compares them.
"""
