"""RGL's .bsdf: the authors' reader, whose values are in files of the shared data, and tables known in closed form."""

import numpy as np
import pytest

import fitter
from fitter import DatasetError
from fitter.formats import rgl
from support import checkout, tensor_files
from support.anisotropic import unit

FOLDER = checkout.measurements() / "rgl"
GOLDEN = sorted(path for path in FOLDER.glob("*_rgb.bsdf") if "aniso" not in path.name)
real = pytest.mark.skipif(not GOLDEN, reason=f"no RGL measurements in {FOLDER}")
every_file = pytest.mark.parametrize("path", GOLDEN, ids=lambda path: path.stem)
ROUNDING = 1.2e-7       # radians: the authors' reader computes in single precision


def table_of(path):
    return rgl.read_table(path.read_bytes())


def directions(count, random):
    """Random directions above the horizon."""
    cosines = random.uniform(0.05, 1, (2, count))
    phi = random.uniform(-np.pi, np.pi, (2, count))
    return np.arccos(cosines[0]), phi[0], np.arccos(cosines[1]), phi[1]


@real
@every_file
def test_between_the_nodes_it_is_what_the_authors_reader_finds(path):
    golden = np.loadtxt(FOLDER / f"golden_{path.stem}.csv", delimiter=",")
    table = table_of(path)

    def with_cosine(theta_i, phi_i, theta_o, phi_o):
        return np.maximum(table.evaluate(theta_i, phi_i, theta_o, phi_o) * np.cos(theta_o)[:, None], 0)

    expected, angles = golden[:, 4:7], golden[:, :4]
    found = with_cosine(*angles.T)
    # in the steepest highlight (one pair of chm_mint) single precision alone makes more than the bound
    shaken = [np.abs(with_cosine(*(angles + np.array(shift) * ROUNDING).T) - found)
              for shift in ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))]
    assert np.count_nonzero(expected > 1e-3) > 300
    bright = expected > 1e-3
    error = np.abs(found - expected)
    assert (error <= 1e-4 * expected + np.sum(shaken, axis=0))[bright].all()
    assert np.quantile(error[bright] / expected[bright], 0.99) < 3e-5
    assert (error[~bright] < 1e-6).all()


@real
@every_file
def test_samples_are_the_function_at_its_nodes(path):
    table, samples = table_of(path), fitter.load(path)
    values = table.evaluate(*samples.directions)
    close = np.isclose(values, samples.values, rtol=1e-9, atol=1e-9).all(axis=1)
    assert 0 < np.count_nonzero(~close) <= len(table.theta_i)       # the means of a column
    mirrored = np.abs(samples.theta_i - samples.theta_o) + np.abs(np.cos(samples.phi_o - samples.phi_i) + 1)
    assert (mirrored[~close & (samples.theta_i > 0)] < 1e-6).all()
    assert samples.channels == ("R", "G", "B")


@real
@every_file
def test_nodes_above_the_horizon_are_those_that_the_file_marks(path):
    """`valid` has a bit for each node, set for those above the horizon in some files, below it in others."""
    table = table_of(path)
    fields = rgl.read_arrays(path.read_bytes())
    size = table.values.shape[1]
    marked = np.unpackbits(fields["valid"])[:table.values.size // 3].reshape(-1, size, size)[:-1, :-1]
    marked = marked if marked.mean() > 0.5 else 1 - marked
    theta_i = table.nodes()[0]
    for angle, above in zip(table.theta_i, marked, strict=False):       # but for the last, at 90 degrees
        expected = np.count_nonzero(above[:, 1:]) + above[0, 0]
        assert np.count_nonzero(theta_i == angle) == pytest.approx(expected, abs=2)


@real
@every_file
def test_between_the_nodes_samples_are_the_files_own_interpolation(path):
    table, samples = table_of(path), fitter.load(path)
    nodes = len(table.nodes()[0])
    assert f"{nodes:,} nodes at {len(table.theta_i)} angles" in samples.notes[0]
    assert f"{len(samples) - nodes:,} between" in samples.notes[0]
    assert f"beyond {np.degrees(table.theta_i[-2]):.0f} degrees it is the authors' extrapolation" in samples.notes[0]
    others = [angle[nodes:] for angle in samples.directions]
    assert 20_000 < len(others[0]) <= 24_000
    np.testing.assert_allclose(samples.values[nodes:], table.evaluate(*others))


@real
def test_their_names_and_numbers_are_the_files():
    names = {path.stem: fitter.load(path).name for path in GOLDEN}
    assert names["chm_mint_rgb"] == "Mint CHM16E"
    notes = fitter.load(FOLDER / "chm_mint_rgb.bsdf").notes
    assert "TeckWrap vinyl wrapping film (Mint CHM16E)" in notes
    assert names["ilm_solo_m_68_rgb"] == "Blue metallic m68-speeder material"
    assert names["irid_flake_paint1_rgb"] == "Iridescent flake car paint"
    counts = {path.stem: len(table_of(path).nodes()[0]) for path in GOLDEN}
    assert all(6800 < count < 7500 for count in counts.values())
    assert (table_of(FOLDER / "chm_mint_rgb.bsdf").nodes()[-1] < 0).mean() == pytest.approx(0.217, abs=0.001)


def test_a_table_in_closed_form_is_evaluated_exactly(written, random):
    path = written(tensor_files.material())
    theta_i, phi_i, theta_o, phi_o = directions(500, random)
    wi, wo = unit(theta_i, phi_i), unit(theta_o, phi_o)
    half = (wi + wo) / np.linalg.norm(wi + wo, axis=0)
    x = np.sqrt(2 / np.pi * np.arccos(half[2]))
    y = (np.arctan2(half[1], half[0]) - phi_i + np.pi) / (2 * np.pi) % 1
    angle = np.clip(theta_i, 0.1, 1.3)                          # beyond the tabulated angles: the nearest one
    rgb = np.stack([0.5 + 0.25 * x + 0.125 * y, 1 + angle, np.full_like(x, 0.75)], axis=1)
    expected = rgb * 2 / (4 * 1) / np.cos(theta_o)[:, None]     # ndf is 2 and sigma 1
    np.testing.assert_allclose(table_of(path).evaluate(theta_i, phi_i, theta_o, phi_o), expected, rtol=1e-6)


def test_samples_of_a_table_in_closed_form(written):
    """Of the 3 x 4 half vectors of a slice, the normal is one direction; those that mirror below the horizon go."""
    path = written(tensor_files.material())
    samples = fitter.load(path)
    assert samples.name == "Made of lead"
    nodes = len(table_of(path).nodes()[0])
    for angle in np.float32([0.1, 0.7, 1.3]).astype(float):
        here = (samples.theta_i == angle) & (np.arange(len(samples)) < nodes)
        expected = [(angle, np.pi, 0.5 + 0.125 * np.mean([0, 1 / 3, 2 / 3]))]
        for x in (1 / 3, 2 / 3, 1):
            for y in (0, 1 / 3, 2 / 3):
                theta, phi = x * x * np.pi / 2, (2 * y - 1) * np.pi
                half, wi = unit(theta, phi), unit(angle, 0)
                wo = 2 * (half @ wi) * half - wi
                if wo[2] > 0:
                    expected.append((np.arccos(wo[2]), np.arctan2(wo[1], wo[0]), 0.5 + 0.25 * x + 0.125 * y))
        assert np.count_nonzero(here) == len(expected)
        theta_o, phi_o, red = np.transpose(sorted(expected, key=lambda row: (round(row[0], 6), round(row[1], 6))))
        order = np.lexsort([samples.phi_o[here].round(6), samples.theta_o[here].round(6)])
        np.testing.assert_allclose(samples.theta_o[here][order], theta_o, atol=1e-6)
        np.testing.assert_allclose(np.exp(1j * samples.phi_o[here][order]), np.exp(1j * phi_o), atol=1e-6)
        np.testing.assert_allclose(samples.values[here][order, 0], red / 2 / np.cos(theta_o), rtol=1e-5)
        np.testing.assert_allclose(samples.values[here][order, 1], (1 + angle) / 2 / np.cos(theta_o), rtol=1e-5)


def test_the_grid_is_fine_where_the_density_is_high(written):
    """A density of 4 x^3, sampled in 60 cells: half of the grid's columns are beyond x = (1/2)^(1/4)."""
    arrays = tensor_files.material(size=3)
    arrays["vndf"] = np.broadcast_to(np.linspace(0, 1, 61) ** 3, (1, 3, 5, 61)).astype("<f4")
    table = table_of(written(arrays))
    u_x, u_y = rgl.rgl_warp.from_grid(table.warp, 1, np.array([0, 0.5, 1]), np.array([0, 0.5]))
    np.testing.assert_allclose(u_x, [[0, 0.5 ** 0.25, 1]] * 2, atol=2e-4)
    np.testing.assert_allclose(u_y, [0, 0.5], atol=1e-6)


def test_to_the_grid_and_back(written, random):
    table = table_of(written(tensor_files.material(seed=3)))
    s_x, s_y = random.random(7), random.random(6)
    u_x, u_y = rgl.rgl_warp.from_grid(table.warp, 2, s_x, s_y)
    back = rgl.rgl_warp.to_grid(table.warp, [(np.full(u_x.size, 2), 1.0)], u_x.ravel(), np.repeat(u_y, 7))
    np.testing.assert_allclose(back, [np.tile(s_x, 6), np.repeat(s_y, 7)], atol=1e-9)


def test_without_a_jacobian_the_table_is_f_cos(written, random):
    arrays = tensor_files.material() | {"jacobian": np.zeros(1, "u1")}
    theta_i, phi_i, theta_o, phi_o = directions(20, random)
    values = table_of(written(arrays)).evaluate(theta_i, phi_i, theta_o, phi_o)
    np.testing.assert_allclose(values[:, 2], 0.75 / np.cos(theta_o), rtol=1e-6)


def test_below_the_horizon_it_is_zero(written):
    table = table_of(written(tensor_files.material()))
    assert not table.evaluate([0.3, 1.6, 0.3], 0, [1.6, 0.3, np.pi / 2], 1).any()


def test_wavelengths_may_be_in_any_order(written, random):
    arrays = tensor_files.spectral(tensor_files.material(), np.linspace(400, 700, 31))
    arrays["spectra"] = arrays["spectra"] * np.linspace(0.2, 1, 31, dtype="<f4")[:, None, None]
    order = random.permutation(31)
    other = arrays | {"wavelengths": arrays["wavelengths"][order], "spectra": arrays["spectra"][:, :, order]}
    expected, found = (fitter.load(written(some)).values for some in (arrays, other))
    np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_negative_values_are_kept(written):
    arrays = tensor_files.material()
    """Of two channels: a file without a value above 0 is refused."""
    arrays = arrays | {"rgb": arrays["rgb"] * np.float32([-1, -1, 1])[:, None, None]}
    assert (fitter.load(written(arrays)).values * (-1, -1, 1) > 0).all()


def test_a_name_that_cannot_be_shown_is_the_files(written):
    arrays = tensor_files.material() | {"description": np.frombuffer(b"\1\2", "u1")}
    assert fitter.load(written(arrays, "gold leaf.bsdf")).name == "gold leaf"


@pytest.mark.parametrize(("change", "expected"), [
    ({"vndf": None}, "no array vndf; expected those of an RGL material"),
    ({"rgb": None, "spectra": np.ones((1, 3, 5, 4, 4), "f4")}, "no array wavelengths"),
    ({"theta_i": np.array([0.1, 0.7], "f4")}, r"vndf has the shape \(1, 3, 5, 6\), expected \(1, 2, 2 or more"),
    ({"theta_i": np.array([0.7, 0.1, 0.8], "f4")}, "theta_i must hold at least two rising angles"),
    ({"theta_i": np.array([0.1, 0.7, 90], "f4")}, "theta_i must hold at least two rising angles"),
    ({"sigma": np.zeros((2, 5), "f4")}, "nor sigma or a slice of vndf zero"),
    ({"vndf": np.zeros((1, 3, 5, 6), "f4")}, "nor sigma or a slice of vndf zero"),
    ({"ndf": -np.ones((2, 5), "f4")}, "must not be negative"),
    ({"ndf": np.full((2, 5), np.nan, "f4")}, "ndf holds numbers that are not finite"),
    ({"ndf": np.full((2, 5), 1e300)}, "ndf holds numbers that are not finite, or larger than 1e"),
    ({"rgb": np.full((1, 3, 3, 4, 4), np.inf, "f4")}, "rgb holds numbers that are not finite"),
    ({"rgb": np.ones((1, 3, 4, 4, 4), "f4")}, "rgb has 4 channels, expected 3"),
    ({"rgb": np.ones((1, 3, 3, 4, 5), "f4")}, "expected square tables"),
    ({"rgb": np.ones((1, 3, 3, 1, 1), "f4")}, "rgb has the shape"),
    ({"rgb": np.ones((1, 3, 3, 0, 0), "f4")}, "rgb has the shape"),
    ({"phi_i": np.zeros(5, "f4")}, r"vndf has the shape \(1, 3, 5, 6\), expected \(5, 3, 2 or more"),
])
def test_a_malformed_file_is_refused(written, change, expected):
    arrays = {name: array for name, array in (tensor_files.material() | change).items() if array is not None}
    with pytest.raises(DatasetError, match=r"made\.bsdf: .*" + expected):
        fitter.load(written(arrays))


def test_two_different_azimuths_are_anisotropic(written):
    arrays = tensor_files.material()
    arrays["phi_i"] = np.array([0, 1], "f4")
    for name in ("vndf", "luminance", "rgb"):
        arrays[name] = np.repeat(arrays[name], 2, axis=0)
    assert len(fitter.load(written(arrays))) == len(fitter.load(written(tensor_files.material())))
    arrays["rgb"][1] += 1
    with pytest.raises(DatasetError, match="anisotropic material"):
        fitter.load(written(arrays))


@pytest.mark.parametrize(("place", "number", "expected"), [
    (12, b"\2", r"version \(2, 0\), expected \(1, 0\)"),
    (14, b"\xff\xff", "should end at byte"),
    (18, b"\xff\xff", "within the table of its arrays"),
    (29, b"\x77", "is of the type 119"),
    (30, b"\xff\xff\xff\xff", r"'version' should end at byte 4,294,967,303"),
    (38, b"\0\0\0\0\0\1", r"'version' should end at byte 4,398,046,5"),
])
def test_a_damaged_container_is_refused(tmp_path, place, number, expected):
    content = bytearray(tensor_files.pack(tensor_files.material()))
    content[place:place + len(number)] = number
    path = tmp_path / "damaged.bsdf"
    path.write_bytes(content)
    with pytest.raises(DatasetError, match=r"damaged\.bsdf: .*" + expected):
        fitter.load(path)
