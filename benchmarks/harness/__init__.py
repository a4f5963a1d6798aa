"""What `held_out` and `dense` share.

`judging` measures a model, `running` judges many things by several processes and continues an interrupted run,
`summary` compares errors, and `command` makes of it a command and a part of the report. A `running.Bench` says what is
judged.
"""
