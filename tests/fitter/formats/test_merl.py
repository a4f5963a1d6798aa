"""MERL's .binary: cells worked out by hand, and the nets that stand for the real files."""

import struct

import numpy as np
import pytest

import fitter
from fitter import DatasetError, cli
from support import merl_files
from support.anisotropic import unit

FILE = "gold-paint.binary"
RIGHT = np.pi / 2


def half_and_difference(samples):
    """theta_h, theta_d and phi_d of directions, by vectors."""
    wi, wo = unit(samples.theta_i, samples.phi_i).T, unit(samples.theta_o, samples.phi_o).T
    half = (wi + wo) / np.linalg.norm(wi + wo, axis=1, keepdims=True)
    # the frame of the half vector: y is horizontal, x is away from the normal and down
    y = np.cross([0.0, 0.0, 1.0], half)
    level = np.linalg.norm(y, axis=1) < 1e-9
    y[level] = [0, 1, 0]
    y /= np.linalg.norm(y, axis=1, keepdims=True)
    x = np.cross(y, half)
    turn = np.arctan2((wi * y).sum(axis=1), (wi * x).sum(axis=1))
    return np.arccos(np.clip(half[:, 2], -1, 1)), np.arctan2(np.linalg.norm(np.cross(wi, half), axis=1),
                                                             (wi * half).sum(axis=1)), turn


def cosines(size):
    """Of theta_i and of theta_o, at the cells."""
    i, j, k = np.mgrid[:size, :size, :2 * size] / size
    theta_h, theta_d, phi_d = i ** 2 * RIGHT, j * RIGHT, k * RIGHT
    up, down = np.cos(theta_d) * np.cos(theta_h), np.sin(theta_d) * np.cos(phi_d) * np.sin(theta_h)
    return up - down, up + down


def test_cells_worked_out_by_hand(load):
    """2 x 2 x 4 cells: theta_h 0 or 22.5, theta_d 0 or 45, phi_d 0, 45, 90 or 135 degrees."""
    values = np.arange(48).reshape(2, 2, 4, 3) + 1.0
    samples = load(merl_files.pack(values))
    np.testing.assert_allclose(samples.values, values.reshape(16, 3), rtol=1e-12)
    theta_i, phi_i, theta_o, phi_o = (np.degrees(angle).reshape(2, 2, 4) for angle in samples.directions)
    np.testing.assert_allclose([theta_i[0, 0], theta_o[0, 0]], 0, atol=1e-9)
    np.testing.assert_allclose([theta_i[0, 1], theta_o[0, 1]], 45)              # about the normal: mirrored
    np.testing.assert_allclose(phi_i[0, 1], [0, 45, 90, 135])
    np.testing.assert_allclose((phi_o[0, 1] - phi_i[0, 1]) % 360, 180)
    np.testing.assert_allclose([theta_i[1, 0], theta_o[1, 0]], 22.5)            # back to the light
    np.testing.assert_allclose((phi_o - phi_i)[1, 0], 0, atol=1e-9)
    np.testing.assert_allclose([theta_i[1, 1, 0], theta_o[1, 1, 0]], [67.5, 22.5])     # in the plane of incidence
    np.testing.assert_allclose((phi_o - phi_i)[1, 1, 0] % 360, 180)
    across = np.degrees(np.arccos(np.cos(np.pi / 4) * np.cos(np.pi / 8)))       # and across it
    np.testing.assert_allclose([theta_i[1, 1, 2], theta_o[1, 1, 2]], across)


def test_scales_and_order_of_the_numbers(load):
    """All red, then all green, then all blue; phi_d changes fastest, theta_h slowest and by the square."""
    planes = np.arange(3 * 4 * 4 * 8, dtype=float)
    samples = load(struct.pack("<3i", 4, 4, 8) + planes.astype("<f8").tobytes())
    theta_h, theta_d, phi_d = half_and_difference(samples)
    i, j = np.round(4 * np.sqrt(theta_h / RIGHT)).astype(int), np.round(4 * theta_d / RIGHT).astype(int)
    k = np.round(8 * phi_d / np.pi).astype(int)
    k[j == 0] = np.round(samples.values[j == 0, 0] * 1500).astype(int) % 8      # means nothing at theta_d = 0
    cell = k + 8 * (j + 4 * i)
    np.testing.assert_allclose(theta_h, (i / 4) ** 2 * RIGHT, atol=1e-7)
    expected = np.stack([cell, 1.15 * (cell + 128), 1.66 * (cell + 256)], axis=1) / 1500
    np.testing.assert_allclose(samples.values, expected, rtol=1e-12, atol=1e-12)


def test_what_was_not_measured_is_left_out(load):
    values = np.ones((3, 3, 6, 3))
    everything = load(merl_files.pack(values))
    values[1, 1, 2, 1] = -1e-9
    values[0, 2, 5] = -1
    values[0, 0, 0] = 0
    samples = load(merl_files.pack(values))
    assert len(samples) == len(everything) - 2
    assert (samples.values >= 0).all()
    assert not samples.values[0].any()                  # zero was measured


def test_cells_below_the_horizon_are_left_out(load):
    samples = load(merl_files.pack(np.ones((9, 9, 18, 3))))
    assert len(samples) == np.count_nonzero(np.minimum(*cosines(9)) > 1e-12)
    assert max(samples.theta_i.max(), samples.theta_o.max()) < RIGHT


@pytest.mark.parametrize("kind", ["<f4", "<f2"])
def test_other_types_of_numbers(load, kind):
    values = merl_files.random_cells(3, 5)
    expected, found = load(merl_files.pack(values)), load(merl_files.pack(values, kind))
    np.testing.assert_array_equal(found.directions, expected.directions)
    np.testing.assert_allclose(found.values, expected.values, rtol=1e-6 if kind == "<f4" else 1e-3)


def test_a_file_of_the_tool_is_read_whole(tmp_path, monkeypatch):
    net = merl_files.nets()
    if net is None:
        pytest.skip("the nets that stand for MERL's files are absent")
    path = tmp_path / "gold-paint.binary"
    monkeypatch.setattr("sys.argv", ["merl_binary.py", "gold-paint", str(path)])
    net.main()
    samples = fitter.load(path)
    stored = np.fromfile(path, "<f8", offset=12).reshape(3, -1).T
    measured = (stored >= 0).all(axis=1)
    lower = np.minimum(*(cosine.ravel() for cosine in cosines(90)))
    np.testing.assert_array_equal(samples.values, stored[measured & (lower > 1e-12)] * merl_files.SCALE)
    assert (samples.name, len(samples)) == ("gold-paint", 1111430)
    assert np.count_nonzero(measured) == 1111432        # two on the horizon, where rounding decides


@pytest.mark.parametrize(("content", "expected"), [
    (merl_files.pack(np.ones((2, 2, 4, 3)))[:-1], "395 bytes found for 2 x 2 x 4 cells of three channels, expected"),
    (merl_files.pack(np.ones((2, 2, 4, 3))) + b"\0", "397 bytes found"),
    (struct.pack("<3i", 90, 90, 180), r"12 bytes found for 90 x 90 x 180 cells .*, expected 34,992,012 \(float64\)"),
    (struct.pack(">3i", 2, 2, 4) + np.ones(48).astype(">f8").tobytes(), "big-endian"),
    (merl_files.pack(-np.ones((2, 2, 4, 3))), "no cell was measured"),
    (merl_files.pack(np.full((2, 2, 4, 3), np.nan)), "not finite"),
    (merl_files.pack(np.full((2, 2, 4, 3), 1e40)), "a value of 1e"),
])
def test_a_damaged_file_is_refused(load, content, expected):
    with pytest.raises(DatasetError, match=r"broken\.binary: .*" + expected):
        load(content, "broken.binary")


@pytest.mark.parametrize("cells", [(90, 90, 360), (91, 91, 182), (1, 1, 2), (90, 90, -180)])
def test_other_headers_are_no_merl_files(load, cells):
    with pytest.raises(DatasetError, match="binary"):
        load(struct.pack("<3i", *cells) + bytes(96))


@pytest.mark.parametrize(("cells", "kind"), [((90, 90, 360), "<f8"), ((6, 6, 24), "<f4"), ((6, 8, 12), "<f8")])
def test_other_numbers_of_cells_are_told_as_those_of_merl(tmp_path, capsys, cells, kind):
    """Of a full turn of phi_d, for example: 70 MB, more than the largest text."""
    path = tmp_path / "full.binary"
    path.write_bytes(struct.pack("<3i", *cells) + np.ones(3 * np.prod(cells), kind).tobytes())
    assert cli.main(["info", str(path)]) == 1
    said = capsys.readouterr().err
    assert f"full.binary: MERL's layout with {' x '.join(map(str, cells))} cells" in said
    assert "expected n x n x 2n, as in MERL's files of 90 x 90 x 180: phi_d over half a turn" in said
