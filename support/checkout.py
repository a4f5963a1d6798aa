"""What demos, tests and benchmarks share: the checkout as the extension that Blender makes of it, and the real data."""

import importlib.util
import os
import subprocess
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


def run_python(*arguments, **options):
    """This Python, by default in the checkout: a CompletedProcess with what it printed."""
    return subprocess.run([sys.executable, *arguments], **{
        "cwd": ROOT, "capture_output": True, "text": True, "check": False, "timeout": 300, **options})


def measurements():
    """The folder of real measurements, which the project may not distribute; it may be absent."""
    return Path(os.environ.get("MEASURED_BRDF_DATA") or ROOT.parent / "shared" / "data")


def has_measurements(folder):
    return (folder / "curet" / "abrdf.dat").is_file() and (folder / "cornell" / "krylon_blue.astm").is_file()
