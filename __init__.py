"""Measured BRDF: fits measured reflectance and renders it in Cycles."""


def register() -> None:
    from . import addon

    addon.register()


def __getattr__(name: str) -> object:
    """The exporter of glTF looks for this name in the add-ons."""
    if name != "glTF2ExportUserExtension":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from .addon.core.shading.export_follow import GltfHook

    return GltfHook


def unregister() -> None:
    from . import addon

    addon.unregister()
