"""What the watched folder holds, and the pictures of it: listed and drawn without Blender, cached on disk."""

import importlib
import os
import sys
import time
from functools import partial

import numpy as np
import pytest
from measured_brdf.addon.starter import shelf
from measured_brdf.addon.starter.thumbnails import FolderEntry
from measured_brdf.addon.work import process
from measured_brdf.addon.work.job import Job

import fitter
from support import panel_work


@pytest.fixture
def thumbnails():
    """The module as a worker loads it."""
    tasks = panel_work.load()
    found = importlib.import_module(tasks.__name__.replace(".work.tasks", ".starter.thumbnails"))
    found._known.clear()
    return found


@pytest.fixture
def folder(tmp_path, glossy, write_astm):
    path = tmp_path / "data"
    path.mkdir()
    write_astm(path / "b.astm", glossy, "b")
    write_astm(path / "a.astm", glossy, "a")
    (path / "notes.txt").write_text("Tuesday: measured the blue one again.")
    (path / "picture.png").write_bytes(b"\x89PNG")
    return path


def labels(found):
    return [each.label for each in found]


def test_new_changed_and_removed_files_are_noticed(thumbnails, folder, glossy, write_astm):
    first = thumbnails.scan(str(folder))
    assert labels(first) == ["a.astm", "b.astm"]        # and no notes, nor pictures
    write_astm(folder / "c.astm", glossy, "c")
    assert labels(thumbnails.scan(str(folder))) == ["a.astm", "b.astm", "c.astm"]
    (folder / "a.astm").unlink()
    assert labels(thumbnails.scan(str(folder))) == ["b.astm", "c.astm"]
    (folder / "b.astm").write_text("broken")
    changed = thumbnails.scan(str(folder))
    assert labels(changed) == ["b.astm", "c.astm"]
    assert changed[0].stamp != first[1].stamp
    assert "b.astm" in changed[0].error
    assert not changed[0].has_picture
    assert not changed[1].error


def test_files_that_stay_the_same_are_not_read_again(thumbnails, folder, monkeypatch):
    before = thumbnails.scan(str(folder))
    monkeypatch.setattr(thumbnails.discovery, "list_samples", None)        # calling it would fail
    assert thumbnails.scan(str(folder)) == before


def test_a_folder_that_is_gone_is_an_error(thumbnails, folder):
    with pytest.raises(OSError, match="nowhere"):
        thumbnails.scan(str(folder / "nowhere"))


def test_names_that_are_not_unicode_are_listed_as_text(thumbnails, folder):
    os.rename(folder / "a.astm", os.fsencode(folder) + b"/caf\xe9.astm")
    with open(os.fsencode(folder) + b"/no\xe9.astm", "wb") as stream:
        stream.write(b"broken")
    _, readable, broken = thumbnails.scan(str(folder))
    assert readable.label.encode() == b"caf?.astm"
    assert os.path.samefile(readable.path, os.fsencode(folder) + b"/caf\xe9.astm")
    assert rb"no\udce9.astm" in broken.error.encode()


def test_the_files_of_a_folder_are_gathered_once(thumbnails, folder, monkeypatch):
    """A list of them for each file would take minutes in a folder of ten thousand."""
    given = []
    monkeypatch.setattr(thumbnails.discovery, "is_read_with_another",
                        lambda path, others: given.append(others) or True)
    thumbnails.scan(str(folder))
    assert len(given) == 3
    assert all(others is given[0] for others in given)
    assert folder / "a.astm" in given[0]


def test_links_that_lead_nowhere_or_to_themselves_are_passed_over(thumbnails, folder):
    before = thumbnails.scan(str(folder))
    try:
        (folder / "broken.astm").symlink_to("nothing")
        (folder / "loop.astm").symlink_to("loop.astm")
        (folder / "one.astm").symlink_to("other.astm")
        (folder / "other.astm").symlink_to("one.astm")
        (folder / "up.astm").symlink_to("..", target_is_directory=True)
        (folder / "up").symlink_to(".", target_is_directory=True)
    except OSError:
        pytest.skip("this system lets nobody make links")
    assert thumbnails.scan(str(folder)) == before


def test_folders_in_the_folder_are_listed_after_it_and_each_once(thumbnails, folder, glossy, write_astm, monkeypatch):
    (folder / "below" / "deep").mkdir(parents=True)
    (folder / ".hidden").mkdir()
    for name in ("below/deep/d.astm", "below/c.astm", ".hidden/e.astm"):
        write_astm(folder / name, glossy, "c")
    try:
        (folder / "below" / "up").symlink_to(folder, target_is_directory=True)
        (folder / "z").symlink_to("below", target_is_directory=True)
    except OSError:
        pytest.skip("this system lets nobody make links")
    assert labels(thumbnails.scan(str(folder))) == ["a.astm", "b.astm", "c.astm", "d.astm"]
    monkeypatch.setattr(thumbnails.discovery, "_MOST", 8)       # seven in the folder
    assert labels(thumbnails.scan(str(folder))) == ["a.astm", "b.astm", "c.astm"]


def test_each_input_of_a_picture_on_the_disk_is_in_its_name(thumbnails, folder, tmp_path, monkeypatch):
    def is_drawn_anew(measurement, how):
        before = len(reads)
        thumbnails.measurement_picture(measurement, str(tmp_path / "cache"), how)
        return len(reads) > before

    reads, samples = [], fitter.load(folder / "a.astm")
    monkeypatch.setattr(thumbnails.fitter, "load", lambda *_, **__: reads.append(1) or samples)
    found, how = thumbnails.scan(str(folder))[0], {"colours": "Rec.709"}
    assert is_drawn_anew(found, how)
    assert not is_drawn_anew(found, how)
    for change in ({"path": str(folder / "b.astm")}, {"sample": "2"}, {"stamp": (1, 2)}):
        assert is_drawn_anew(found._replace(**change), how), change
    assert is_drawn_anew(found, {"colours": "ACEScg"})
    monkeypatch.setattr(thumbnails.versions, "CURRENT", "0.0.0")
    assert is_drawn_anew(found, how)


def test_a_measurement_in_three_files_is_another_where_one_of_them_has_changed(thumbnails, tmp_path):
    row = " ".join(["1", *["0.1"] * 205])
    for name in ("rbrdf.dat", "gbrdf.dat", "bbrdf.dat"):
        (tmp_path / name).write_text(row)
    before, = thumbnails.scan(str(tmp_path))
    for name in ("gbrdf.dat", "bbrdf.dat"):
        (tmp_path / name).write_text(row.replace("0.1", "0.25"))
        after, = thumbnails.scan(str(tmp_path))
        assert after.path == before.path
        assert after.stamp != before.stamp
        before = after


def test_a_table_without_units_is_listed_because_the_import_asks(thumbnails, folder):
    (folder / "unknown.csv").write_text("theta_i,theta_o,phi,BRDF\n0.5,0.5,1,1\n0.2,0.3,1,1\n")
    found = next(each for each in thumbnails.scan(str(folder)) if each.label == "unknown.csv")
    assert found.error == ""


def test_a_curet_file_lists_its_samples(thumbnails, data):
    found = thumbnails.scan(str(data / "curet"))
    assert len(found) == 61
    assert {each.path for each in found} == {str(data / "curet" / "abrdf.dat")}
    assert "velvet" in [each.label.lower() for each in found]


def test_a_large_file_is_listed_without_being_read_or_drawn(thumbnails, folder, monkeypatch):
    monkeypatch.setattr(thumbnails, "LARGEST_FITTED", 100)
    monkeypatch.setattr(thumbnails.discovery, "list_samples", None)
    found = thumbnails.scan(str(folder))
    assert labels(found) == ["a.astm", "b.astm"]
    assert not any(each.has_picture for each in found)


def test_a_picture_of_a_measurement_is_drawn_once(thumbnails, folder, tmp_path, monkeypatch):
    found = thumbnails.scan(str(folder))[0]
    cache, how = tmp_path / "cache", {"colours": "Rec.709"}
    drawn = thumbnails.measurement_picture(found, str(cache), how)
    assert drawn.shape == (thumbnails.SIZE, thumbnails.SIZE, 4)
    assert drawn[64, 64, 2] > drawn[64, 64, 0]           # it is blue
    assert drawn[0, 0, 3] == 0
    original = thumbnails.lit_sphere
    monkeypatch.setattr(thumbnails, "lit_sphere", None)
    np.testing.assert_array_equal(thumbnails.measurement_picture(found, str(cache), how), drawn)
    stored, = cache.glob("*.npy")
    stored.write_bytes(stored.read_bytes()[:100])        # damaged: drawn anew
    monkeypatch.setattr(thumbnails, "lit_sphere", original)
    np.testing.assert_array_equal(thumbnails.measurement_picture(found, str(cache), how), drawn)


def test_a_cache_that_cannot_be_written_is_done_without(thumbnails, folder, tmp_path):
    (tmp_path / "cache").write_text("a file, where the folder should be")
    picture = thumbnails.measurement_picture(thumbnails.scan(str(folder))[0], str(tmp_path / "cache"), {})
    assert picture[64, 64, 2] > picture[64, 64, 0]


def test_only_so_many_pictures_are_kept(thumbnails, folder, tmp_path, monkeypatch):
    monkeypatch.setattr(thumbnails, "_KEPT_PICTURES", 2)
    found, cache = thumbnails.scan(str(folder))[0], tmp_path / "cache"
    for stamp in ((1, 1), (2, 1), (3, 1)):
        thumbnails.measurement_picture(found._replace(stamp=stamp), str(cache), {})
    assert len(list(cache.glob("*.npy"))) == 2


def test_the_picture_of_an_unreadable_measurement_is_an_error(thumbnails, folder, tmp_path):
    found = thumbnails.scan(str(folder))[0]
    (folder / "a.astm").write_text("broken since")
    with pytest.raises(ValueError, match=r"a\.astm"):
        thumbnails.measurement_picture(found, str(tmp_path / "cache"), {})


def test_a_picture_that_cannot_be_drawn_is_not_tried_for_ever(extension, monkeypatch):
    """The queue keeps few answers: with more broken files than that in a folder, each would be asked for again."""
    asked = []

    def ask(key, _work, _lane, then):
        asked.append(key)
        job = Job(None)
        job.error = RuntimeError("the worker was killed") if len(asked) == 1 else ValueError("no units")
        return job

    monkeypatch.setattr(shelf.queue, "ask", ask)
    file = FolderEntry("broken.csv", "", (1, 2))
    shown = [shelf.measurement_icon(file, {}) for _ in range(4)]
    assert [str(error) for _, error in shown] == ["the worker was killed", *["no units"] * 3]
    assert len(asked) == 2
    shelf.measurement_icon(file._replace(stamp=(3, 2)), {})
    assert len(asked) == 3                  # it has changed: tried again
    shelf._failed.clear()


def test_a_worker_lists_a_folder(extension, folder):
    from measured_brdf.addon.starter import thumbnails

    worker = process.Worker()
    try:
        for work in (partial(thumbnails.scan, str(folder)), partial(thumbnails.library_pictures, ["white-paint"])):
            job = Job(work)
            worker.begin(job)
            while not job.poll():
                time.sleep(0.02)
            assert job.error is None, job.error
            assert len(job.result) in (1, 2)
    finally:
        worker.kill()
    assert "bpy" in sys.modules
