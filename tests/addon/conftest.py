"""What the tests of the add-on share: the extension, whose modules they import, and what several of them begin with."""

import pytest

from support import checkout
from support.stage import black_scene

checkout.extension()


@pytest.fixture(autouse=True)
def nothing_left(extension):
    """After each test no panel asks anything, and no worker runs."""
    yield
    extension.addon.work.queue.unregister()
    extension.addon.work.process.unregister()


@pytest.fixture
def file(tmp_path, glossy, write_astm):
    """A file of the synthetic measurement."""
    return write_astm(tmp_path / "glossy.astm", glossy)


@pytest.fixture
def cube(blender):
    """The active object of a black scene."""
    black_scene(16, 16, samples=8, span=1)
    blender.ops.mesh.primitive_cube_add()
    return blender.context.object


@pytest.fixture
def from_library(blender, tmp_path):
    """Save the open file, begin another with a cube, and take a material of the saved one for that: the material."""
    def take(name, link=True):
        blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
        black_scene(16, 16, samples=8, span=1)
        with blender.data.libraries.load(str(tmp_path / "library.blend"), link=link) as (_, target):
            target.materials = [name]
        blender.ops.mesh.primitive_cube_add()
        blender.context.object.data.materials.append(target.materials[0])
        return target.materials[0]
    return take
