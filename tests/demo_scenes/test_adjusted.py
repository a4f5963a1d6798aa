import json

import bpy

from demo_scenes import adjusted
from support.cases import release


@release
def test_each_caption_of_the_picture_changes_the_material(extension, glossy, write_astm, tmp_path):
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.mesh.primitive_cube_add()
    path = write_astm(tmp_path / "glossy.astm", glossy)
    bpy.ops.measured_brdf.import_data(filepath=str(path), preset="Draft")
    material = bpy.context.object.active_material
    edits = set()
    for _, _, settings in adjusted.ADJUSTED:
        bpy.ops.measured_brdf.adjust(reset=True)
        adjusted.adjust(material, settings)
        edits.add(material.measured_brdf.adjusted)
    assert len(edits) == len({json.dumps(settings) for *_, settings in adjusted.ADJUSTED})
