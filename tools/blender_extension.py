"""Blender's own `extension` command (build, validate, ...), run by the Python of this environment's bpy.

python tools/blender_extension.py build --source-dir . --output-filepath build/measured_brdf.zip
"""

import importlib.util
import runpy
import sys
from pathlib import Path

if __name__ == "__main__":
    bpy = Path(importlib.util.find_spec("bpy").origin).parent
    program = next(bpy.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py"))
    sys.argv[0] = str(program)
    runpy.run_path(str(program), run_name="__main__")
