"""What `held_out` and `dense` share: `judging` measures a model, and `running` many things by several processes."""
