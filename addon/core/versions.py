"""The version of the extension. Nothing here imports bpy."""

import tomllib
from pathlib import Path

CURRENT: str = tomllib.loads((Path(__file__).parents[2] / "blender_manifest.toml").read_text("utf-8"))["version"]
