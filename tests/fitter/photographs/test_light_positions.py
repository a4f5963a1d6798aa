"""Light positions (.lp) as museums' programs write them."""

import numpy as np
import pytest

import fitter
from fitter.photographs.description import light_positions


def read(folder, text, **how):
    (folder / "dome.lp").write_bytes(text.encode(**how))
    return light_positions.read(folder / "dome.lp")


@pytest.mark.parametrize("text", [
    "2\nfirst 1.png 0.6 0.0 0.8\nb.png 0 -1 0\n",
    "\ufeff2\r\nfirst 1.png\t0,6\t0,0\t0,8\r\nb.png\t-0\t-1,0\t0,\r\n\r\n",
    "2\nfirst 1.png, 0.6, 0.0, 0.8\nb.png,0.0,-1.0,0.0",
    "2\n\"first 1.png\";0,6;0,0;0,8\nb.png;0;-1;0e0",
    "2\nfirst 1.png 0.5999 1e-5 0.8002\nb.png 0 -.99 0",
], ids=["blanks", "commas", "separated", "semicolons", "rounded"])
def test_names_and_unit_vectors(tmp_path, text):
    found = read(tmp_path, text)
    assert found.names == ("first 1.png", "b.png")
    np.testing.assert_allclose(found.directions, [[0.6, 0, 0.8], [0, -1, 0]], atol=2e-4)
    np.testing.assert_allclose(np.linalg.norm(found.directions, axis=1), 1)


@pytest.mark.parametrize(("text", "message"), [
    ("", "dome.lp: empty"),
    ("a.png 0 0 1", "line 1: 'a.png 0 0 1' found, expected the number of photographs"),
    ("3\na.png 0 0 1\n", "line 1: 3 photographs are promised, 1 lines follow"),
    ("0\n", "0 photographs"),
    ("1\n\na.png 0 0\n", "line 3: 'a.png 0 0' found, expected the name of a file and three numbers"),
    ("1\na.png 0 nan 1\n", "line 2: .* three numbers"),
    ("1\na.png 0 0x1 1\n", "line 2: .* three numbers"),
    ("1\na.png 0 0 0\n", "no light was found for any"),
    ("1\na.png 12 40 80\n", "line 2: a vector of the length 90.2"),
    ("1\na.png 1e400 0 1\n", "line 2: a vector of the length inf"),
], ids=str)
def test_what_is_wrong_is_named_by_its_line(tmp_path, text, message):
    with pytest.raises(fitter.DatasetError, match=message):
        read(tmp_path, text)


def test_a_long_line_takes_no_time(tmp_path):
    for text in ("1\n" + "a " * 400_000, "1\n" + "1 0 0 " * 150_000 + "x"):
        with pytest.raises(fitter.DatasetError, match="line 2"):
            read(tmp_path, text)


@pytest.mark.parametrize(("name", "text", "names"), [
    ("dome.lp", "3\na.png 0.6 0 0.8\nb.png 0 0 0\nc.png 0 -1 0\n", ("a.png", "b.png", "c.png")),
    ("info.json", '{"width": 9, "lights": [0.6, 0, 0.8, 0, 0, 0, 0, -1, 0], "type": "ptm"}', ("", "", "")),
    ("coin.relight", '{"folder": "jpg", "images": [{"filename": "a.png", "direction": [0.6, 0, 0.8]}, {"filename": '
     '"b.png", "skip": true, "direction": [1, 0, 0]}, {"filename": "c.png", "direction": {"x": 0, "y": -1, "z": 0}}]}',
     ("jpg/a.png", "jpg/b.png", "jpg/c.png"))])
def test_projects_and_lights_that_were_not_found(tmp_path, name, text, names):
    (tmp_path / name).write_text(text, "utf-8")
    found = light_positions.read(tmp_path / name)
    assert found.names == names
    np.testing.assert_allclose(found.directions, [[0.6, 0, 0.8], [0, 0, 0], [0, -1, 0]], atol=1e-12)


@pytest.mark.parametrize(("text", "message"), [
    ("{", "not JSON"), ("[1]", "project without images"), ('{"lights": [1, 0]}', "three numbers each"),
    ('{"lights": [1, 0, "a"]}', "light 1: .*expected three numbers"), ('{"lights": [9, 0, 0]}', "length 9")])
def test_what_is_wrong_with_a_project_is_named(tmp_path, text, message):
    (tmp_path / "info.json").write_text(text, "utf-8")
    with pytest.raises(fitter.DatasetError, match=message):
        light_positions.read(tmp_path / "info.json")
