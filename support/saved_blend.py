"""A small .blend for the versions to come: a material as this version saves it.

`python -m support.saved_blend` writes it anew, with the command `zstd`. Run it in the oldest Blender that the tests
run in: older ones do not open what newer ones write. It holds no bytecode and no picture of the material, which would
be a quarter of it: until it is updated, its closure nodes render.
"""

import subprocess
import tempfile
from pathlib import Path

import bpy

from support import checkout

PATH = checkout.ROOT / "tests" / "data" / "saved-0.3.0.blend"
NAME = "Pink felt"
INPUTS = {"Tint": (0.5, 0.25, 1.0, 1.0), "Strength": 0.5}


def main():
    extension = checkout.extension()
    extension.register()
    try:
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        bpy.ops.mesh.primitive_plane_add()
        bpy.ops.measured_brdf.import_data(filepath="published:pink-felt", preset="Paper", diffuse_level=1,
                                          specular_level=-1)
        material = bpy.data.materials[NAME]
        node = extension.addon.core.shading.material.group_node(material)
        for name, value in INPUTS.items():
            node.inputs[name].default_value = value
        normal = material.node_tree.nodes.new("ShaderNodeNormalMap")
        normal.name, normal.inputs["Strength"].default_value = "Mine", 0
        material.node_tree.links.new(normal.outputs["Normal"], node.inputs["Normal"])
        script = extension.addon.core.shading.node_group.script_node(node.node_tree)
        script.bytecode = material.measured_brdf.sphere = ""
        with tempfile.TemporaryDirectory() as folder:
            plain = Path(folder, "plain.blend")
            bpy.data.libraries.write(str(plain), {material})
            subprocess.run(["zstd", "--ultra", "-22", "--force", "--quiet", plain, "-o", PATH], check=True)
    finally:
        extension.unregister()


if __name__ == "__main__":
    main()
