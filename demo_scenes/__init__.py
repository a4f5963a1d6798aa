import sys
from pathlib import Path

from support.checkout import ROOT, extension


def run(draw, name):
    """Draw with the extension, to the path that the command line gives or to build/demo/NAME."""
    extension().register()
    path = Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else ROOT / "build" / "demo" / name
    draw(path)
    print(path)
