"""Shards of a library, when measurements are damaged or few."""

import bpy
import pytest

from support.cases import release
from support.command import convert
from support.synthetic import make_files

SHARDS = 2


@pytest.fixture
def measurements(tmp_path):
    """A file of four samples and three files of one."""
    folder = tmp_path / "measurements"
    folder.mkdir()
    files = make_files(folder, 7)
    (folder / "four.dat").write_text("\n".join(path.read_text() for path in files[:4]))
    for path in files[:4]:
        path.unlink()
    return folder


def convert_shards(folder, library):
    """Convert all shards: exit codes, and the names of the materials in each."""
    codes, names = [], []
    for part in range(1, SHARDS + 1):
        codes.append(convert(folder, library, "--shard", f"{part}/{SHARDS}").returncode)
        with bpy.data.libraries.load(str(library.with_name(f"{library.stem}-{part}of{SHARDS}.blend"))) as (source, _):
            names.append(sorted(source.materials))
    return codes, names


@release
def test_what_was_made_of_a_file_of_many_samples_stays_when_the_file_is_damaged(blender, measurements, tmp_path):
    library = tmp_path / "library.blend"
    assert convert(measurements, library).returncode == 0
    codes, before = convert_shards(measurements, library)
    assert codes == [0] * SHARDS
    (measurements / "four.dat").write_text("nonsense")
    said = convert(measurements, library)
    assert said.returncode == 1
    assert "removed" not in said.stdout
    codes, after = convert_shards(measurements, library)
    assert codes == [1] * SHARDS                    # each may hold what was made of it, and says that it is damaged
    with blender.data.libraries.load(str(library)) as (source, _):
        assert len(source.materials) == 7
        assert set(source.materials) == set().union(*before) == set().union(*after)


def test_a_damaged_file_moves_no_other_to_another_shard(blender, measurements, tmp_path):
    (measurements / "four.dat").unlink()
    _, before = convert_shards(measurements, tmp_path / "library.blend")
    min(measurements.iterdir()).write_text("nonsense")
    _, after = convert_shards(measurements, tmp_path / "library.blend")
    assert after == before


def test_more_shards_than_measurements_is_no_failure_but_no_measurements_is(measurements, tmp_path):
    done = convert(measurements, tmp_path / "library.blend", "--shard", "8/8")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "0 done, 0 failed" in done.stdout
    (tmp_path / "empty").mkdir()
    for more in ((), ("--shard", "8/8")):
        assert convert(tmp_path / "empty", tmp_path / "library.blend", *more).returncode == 1
    assert not list(tmp_path.glob("*.blend"))
