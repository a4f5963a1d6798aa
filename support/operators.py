"""Operators of Blender, driven by tests instead of by a window."""


def methods(operator):
    """What an operator's class defines itself, for a class that Blender need not make: {name: function}."""
    return {name: value for name, value in vars(operator).items() if callable(value) and not name.startswith("bl_")}
