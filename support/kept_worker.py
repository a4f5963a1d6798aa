"""A worker process that makes fits once (`support.kept`): what tests start in the place of addon/work/worker.py."""

import importlib.util
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]

if __name__ == "__main__":
    sys.path.insert(0, str(ROOT))
    spec = importlib.util.spec_from_file_location("worker", ROOT / "addon" / "work" / "worker.py")
    worker = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(worker)
    worker.install_packages(sys.argv[1], Path(sys.argv[2]))

    from support import kept

    kept.keep(f"{sys.argv[1]}.fitter")
    worker.serve(sys.argv[1], Path(sys.argv[3]))
