"""Operators of Blender, driven by tests instead of by a window, and what users choose in them."""

from types import SimpleNamespace


def methods(operator):
    """What an operator's class defines itself, for a class that Blender need not make: {name: function}."""
    return {name: value for name, value in vars(operator).items() if callable(value) and not name.startswith("bl_")}


def default_choices():
    """The settings of a fit that nobody has changed, of no file yet: a namespace."""
    import bpy
    from measured_brdf.addon.core.storage.properties import CHOICES

    settings = bpy.types.Material.bl_rna.properties["measured_brdf"].fixed_type.properties
    return SimpleNamespace(**{name: settings[name].default for name in CHOICES})
