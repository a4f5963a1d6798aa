"""What `held_out` and `dense` share.

`judging` measures a model; `running` judges many things by several processes, continues an interrupted run, and makes
a command of it. A `running.Bench` says what is judged.
"""
