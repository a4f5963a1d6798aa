"""Measured BRDF: fits measured reflectance and renders it in Cycles."""


def register() -> None:
    from . import addon

    addon.register()


def unregister() -> None:
    from . import addon

    addon.unregister()
