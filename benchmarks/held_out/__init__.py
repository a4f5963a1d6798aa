"""``make held-out``: the errors of every method of the report at what it has not seen, over all sets at hand.

`sets` says which there are and which half judges, `judging` fits and measures one.
"""
