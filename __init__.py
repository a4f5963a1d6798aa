"""Measured BRDF: renders measured reflectance in Cycles."""


def register():
    from . import addon

    addon.register()


def unregister():
    from . import addon

    addon.unregister()
