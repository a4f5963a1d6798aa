"""The command line on the bpy module, without Blender's executable: ``python -m measured_brdf convert|render|info``.

In a checkout, whatever its folder is called: ``python . convert ...``.
"""

import importlib.util
import sys
from pathlib import Path


def main():
    """Load this folder as the package that Blender makes of it, and run one command."""
    root = Path(__file__).resolve().parent
    spec = importlib.util.spec_from_file_location("measured_brdf", root / "__init__.py",
                                                  submodule_search_locations=[str(root)])
    package = sys.modules["measured_brdf"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(package)
    package.register()
    try:
        from measured_brdf.addon import command

        return command.main(_arguments())
    finally:
        package.unregister()


def _arguments():
    """What is meant for the command: of Blender's own executable what follows on "--"."""
    if "--python" in sys.argv:
        return sys.argv[sys.argv.index("--") + 1:]
    return sys.argv[1:]


if __name__ == "__main__":
    raise SystemExit(main())
