import importlib.util
import sys
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def openimageio():
    """OpenImageIO, which Blender as a Python module has in a folder that is not on the path: that folder, or None."""
    if importlib.util.find_spec("OpenImageIO") is not None:
        return None
    bpy = pytest.importorskip("bpy")
    folders = sorted(Path(bpy.utils.resource_path("LOCAL")).glob("python/lib/python3.*/site-packages"))
    found = [folder for folder in folders if (folder / "OpenImageIO").exists()]
    if not found:
        pytest.skip("OpenImageIO is absent")
    sys.path.append(str(found[0]))
    return found[0]
