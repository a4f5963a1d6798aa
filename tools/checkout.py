"""A checkout as the extension that Blender makes of it, without building and installing it."""

import importlib.util
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]


def extension():
    """The checkout as the package `measured_brdf`, loaded once; call its `register`."""
    if "measured_brdf" not in sys.modules:
        spec = importlib.util.spec_from_file_location("measured_brdf", ROOT / "__init__.py",
                                                      submodule_search_locations=[str(ROOT)])
        package = importlib.util.module_from_spec(spec)
        sys.modules["measured_brdf"] = package
        spec.loader.exec_module(package)
    return sys.modules["measured_brdf"]
