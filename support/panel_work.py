"""The background tasks of the panel, loaded without Blender as the extension's background process loads them."""

import importlib
import importlib.util
import sys

from support.checkout import ROOT

_PACKAGE = "measured_brdf_without_blender"


def load():
    """The module `addon/work/tasks.py`."""
    if _PACKAGE not in sys.modules:
        spec = importlib.util.spec_from_file_location("worker", ROOT / "addon" / "work" / "worker.py")
        worker = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(worker)
        worker.install_packages(_PACKAGE, ROOT)
    return importlib.import_module(f"{_PACKAGE}.addon.work.tasks")


def main(path):
    """Read and describe a file as the panel does: 0, or 1 with a message on standard error."""
    try:
        data = load().read(path, None)
    except ValueError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    print("\n".join(f"{label} {text}" for label, text, _ in data.description.rows()))
    return 0
