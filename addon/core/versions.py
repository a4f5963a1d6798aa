"""The version of the extension, and the one that made a material. Nothing here imports bpy."""

import tomllib
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import bpy

CURRENT: str = tomllib.loads((Path(__file__).parents[2] / "blender_manifest.toml").read_text("utf-8"))["version"]
_FIRST = "0.1.0"            # materials of this version do not name it


def made_by(material: "bpy.types.Material") -> str:
    """The version of the extension that made a measured material."""
    return material.measured_brdf.version or _FIRST
