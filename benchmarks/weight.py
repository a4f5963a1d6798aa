"""What a material weighs: ``python -m benchmarks.weight`` prints the growth of a .blend by eight materials, by part.

Each part is what the file shrinks by when it is taken away. An undo step is `ed.undo_push` with the materials less that
without, the median of REPEATS; a lamp's move is the extension's update of its lamps and the dependency graph's.
"""

import statistics
import tempfile
import time
from pathlib import Path

import bpy

from support import checkout, stage, synthetic
from support.evidence import show_table

CURET, CORNELL = ("1", "5", "7", "12", "15"), ("krylon_blue_RGB", "garnet_red_RGB", "cayman")
REPEATS = 11
SCRIPT_NODE = "Measured BRDF Shader"


def main():
    checkout.extension().register()
    folder = synthetic.measurements_or_synthetic()[0]
    files = [(folder / "curet" / "abrdf.dat", number) for number in CURET]
    files += [(path, "") for name in CORNELL for path in (folder / "cornell").glob(f"{name}.*")]
    stage.black_scene(8, 8, 1, span=1)
    lamp = stage.add_lamp("POINT", 1, (0, 0, 1))
    empty, before = _sizes(), _milliseconds(lamp)
    for path, sample in files:
        bpy.ops.measured_brdf.import_data(filepath=str(path), sample=sample, preset="Standard")
    bpy.ops.mesh.primitive_plane_add()
    for material in bpy.data.materials:
        bpy.context.object.data.materials.append(material)
    count, full, after = len(files), _sizes(), _milliseconds(lamp)
    rows = [(f"{count} materials, Standard, kB each", round((full[0] - empty[0]) / count / 1e3)),
            ("the same, compressed", round((full[1] - empty[1]) / count / 1e3))]
    for part, remove in (("bytecode", _no_bytecode), ("fit", _no_fit), ("nodes", _no_nodes)):
        remove()
        less = _sizes()
        rows.append((f"of it {part}", round((full[0] - less[0]) / count / 1e3)))
        full = less
    for what, one, other in zip(("an undo step", "a lamp's move"), before, after, strict=True):
        rows.append((f"{what}, ms for each material", f"{(other - one) / count:.2f}"))
    show_table("weight", ("", "kB or ms"), rows)


def _sizes():
    """Bytes of the .blend, and of the compressed one."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "weight.blend")
        found = []
        for compress in (False, True):
            bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=compress, copy=True)
            found.append(path.stat().st_size)
    return found


def _milliseconds(lamp):
    """Of an undo step, and of a lamp's move."""
    steps, moves = [], []
    for number in range(REPEATS):
        start = time.process_time()
        bpy.ops.ed.undo_push(message="weight")
        steps.append(time.process_time() - start)
        lamp.location.x = number
        start = time.process_time()
        bpy.context.view_layer.update()
        moves.append(time.process_time() - start)
    return 1e3 * statistics.median(steps), 1e3 * statistics.median(moves)


def _groups():
    return [tree for tree in bpy.data.node_groups if SCRIPT_NODE in tree.nodes]


def _no_bytecode():
    for tree in _groups():
        tree.nodes[SCRIPT_NODE].bytecode = ""


def _no_fit():
    for tree in _groups():
        del tree["fit"]


def _no_nodes():
    for tree in _groups():
        tree.nodes.clear()


if __name__ == "__main__":
    main()
