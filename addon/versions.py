"""Which version of the extension made a material or a library."""

import tomllib
from pathlib import Path

CURRENT = tomllib.loads((Path(__file__).parents[1] / "blender_manifest.toml").read_text("utf-8"))["version"]
_FIRST = "0.1.0"            # the one that did not say


def made_by(material):
    """The version of the extension that made a measured material."""
    return material.measured_brdf.version or _FIRST
