import json
import math
import re
import tracemalloc
import zipfile
from dataclasses import replace

import numpy as np
import pytest

import fitter
from fitter.cycles.bake import bake
from fitter.model import fit_file
from fitter.model.transform import LogRelative
from fitter.samples import subset
from support import hostile_fits
from support.made_fits import MADE_FITS
from support.mixtures import any_mixture

DAMPED = MADE_FITS["Rusinkiewicz, stretched by 33, all lobes, damped"]


@pytest.fixture(params=[{"specular_level": None, "diffuse_level": 3}, {"diffuse_level": 2, "specular_level": 4}])
def fit(request, glossy):
    return fitter.fit(glossy, **request.param)


def test_a_saved_fit_comes_back_whole(fit, tmp_path):
    fit.save(tmp_path / "glossy.npz")
    back = fitter.Fit.load(tmp_path / "glossy.npz")
    directions = np.meshgrid(np.linspace(0, 1.5, 8), [0.3], np.linspace(0, 1.5, 8), np.linspace(0, 6, 9))
    assert (back.evaluate(*directions) == fit.evaluate(*directions)).all()
    for name in ("name", "source", "channels", "compression", "coefficient_count", "nbytes", "specular_level"):
        assert getattr(back, name) == getattr(fit, name), name
    assert [path.name for path in tmp_path.iterdir()] == ["glossy.npz"]


def test_equal_fits_have_equal_bytes_which_come_back_whole(fit, tmp_path):
    content = fit.to_bytes()
    fit.save(tmp_path / "glossy.npz")
    assert (tmp_path / "glossy.npz").read_bytes() == content
    back = fitter.Fit.from_bytes(content)
    assert back.to_bytes() == content
    assert (back.name, back.source) == (fit.name, fit.source)
    for damaged in (b"", content[:-1], b"\0" + content, content[:100] + b"\0" + content[101:]):
        with pytest.raises(fitter.DatasetError, match="fit"):
            fitter.Fit.from_bytes(damaged)


def tampered(fit, path, header=None, **arrays):
    fit.save(path)
    with np.load(path) as file:
        tamper(path, dict(file), header, **arrays)


def tamper(path, entries, header=None, **arrays):
    """Write the entries of a saved fit, some of them replaced."""
    if header:
        entries = entries | {"header": np.array(json.dumps(json.loads(str(entries["header"])) | header))}
    np.savez(path, **(entries | arrays))


@pytest.mark.parametrize("change", [
    {"header": {"version": 99}}, {"header": {"diffuse_level": 4}}, {"header": {"diffuse_level": "4"}},
    {"header": {"channels": []}}, {"header": {"specular_level": 3}}, {"header": {"multiplier": 3}},
    {"header": {"compression": float("nan")}}, {"header": {"format": "something else"}},
    {"diffuse": np.zeros(3, np.float32)}, {"keys": np.zeros(5, np.uint32)}, {"displacement": np.zeros(0, np.uint16)},
    {"displacement": np.full(40, 60_000, np.uint16)},
    {"coefficients": np.full((5, 3), np.nan, np.float32)}, {"diffuse": np.array([object()])},
    {"header": {"specular_level": True}}])
def test_a_file_whose_parts_contradict_each_other_is_refused(glossy, tmp_path, change):
    path = tmp_path / "bad.npz"
    tampered(fitter.fit(glossy, 2, 4), path, **change)
    with pytest.raises(fitter.DatasetError, match=r"bad\.npz"):
        fitter.Fit.load(path)


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 no zip", b"\x93NUMPY", b"1 2 3"])
def test_any_other_file_is_refused(tmp_path, content):
    (tmp_path / "x.npz").write_bytes(content)
    with pytest.raises(fitter.DatasetError, match=r"x\.npz"):
        fitter.Fit.load(tmp_path / "x.npz")


def test_damage_anywhere_in_the_file_is_refused_or_harmless(glossy, tmp_path, random):
    path = tmp_path / "fit.npz"
    fit = fitter.fit(glossy, 1, 2)
    fit.save(path)
    whole = path.read_bytes()
    refused = 0
    for place in random.integers(0, len(whole), 400):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << int(random.integers(8))
        path.write_bytes(damaged)
        try:
            back = fitter.Fit.load(path)
            np.testing.assert_array_equal(back.evaluate(0.5, 0, 1, 2), fit.evaluate(0.5, 0, 1, 2))
        except fitter.DatasetError:
            refused += 1
    assert refused > 300


def test_a_missing_file_is_said_to_be_missing(tmp_path):
    with pytest.raises(fitter.DatasetError, match="No such file"):
        fitter.Fit.load(tmp_path / "none.npz")


def test_a_failing_save_leaves_the_old_file(glossy, tmp_path, monkeypatch):
    path = tmp_path / "fit.npz"
    fit = fitter.fit(glossy, 2, None)
    fit.save(path)
    before = path.read_bytes()

    def fail(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np.lib.format, "write_array", fail)
    with pytest.raises(OSError, match="No space"):
        fit.save(path)
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["fit.npz"]


def npy(dtype, shape, data=b""):
    """An array file with an arbitrary header."""
    header = repr({"descr": dtype, "fortran_order": False, "shape": shape}).encode().ljust(117) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + data


@pytest.mark.parametrize(("member", "expected"), [
    (npy("<f4", (1 << 40,)), "claims 4,398,046,511,104 bytes"),
    (npy("<f4", (0, -1)), "expected plain numbers"),
    (npy("|O", (1,), b"cos\nsystem\n(S'true'\ntR."), "expected plain numbers"),
    (npy("<f4", (3,), bytes(40 << 20)), "shorter or longer"),
    (npy("|V1", (3,), b"abc"), "expected plain numbers"),
    (npy("<f4", (10**30,)), "claims"),
    (b"\x93NUMPY\x03\x00" + bytes(99), "expected a short header of version 1.0"),
    (b"\x93NUMPY\x01\x00\xff\xff{'descr': __import__('os').system('true')}", "")])
def test_a_hostile_array_is_refused_before_it_is_read(glossy, tmp_path, member, expected):
    path = tmp_path / "hostile.npz"
    fitter.fit(glossy, 1, None).save(path)
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as file:
        file.writestr("keys.npy", member)
    del member
    tracemalloc.start()
    with pytest.raises(fitter.DatasetError, match=r"hostile\.npz: not a fit") as refused:
        fitter.Fit.load(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert expected in str(refused.value.__cause__)
    assert peak < 4 << 20


@pytest.mark.parametrize("name", hostile_fits.CONTENTS)
def test_a_hostile_fit_is_refused_before_it_takes_memory(tmp_path, name):
    path = tmp_path / "hostile.npz"
    path.write_bytes(hostile_fits.CONTENTS[name]())
    tracemalloc.start()
    with pytest.raises(fitter.DatasetError, match=r"hostile\.npz"):
        fitter.Fit.load(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    inflated = 240_000_000 if name == "60,000,000 keys" else 0         # as many bytes as a fit of level 8 may have
    assert peak < inflated + 2 * path.stat().st_size + (4 << 20)


def test_the_fit_that_hostile_ones_are_made_from_is_read(tmp_path):
    (tmp_path / "fit.npz").write_bytes(hostile_fits.in_order())
    assert fitter.Fit.load(tmp_path / "fit.npz").channels == ("R", "G", "B")


@pytest.fixture(scope="module")
def with_lobes():
    """A small fit with a prior of all lobes, and a mixture."""
    return DAMPED, any_mixture(DAMPED)


@pytest.mark.parametrize("number", [1e300, 3.5e38, np.inf, np.nan])
@pytest.mark.parametrize(("field", "constant"), [
    ("offset", "PRIOR_OFFSET"), ("ceiling", "PRIOR_CEILING"), ("kd", "PRIOR_KD"), ("ks", "PRIOR_LOBES"),
    ("gamma", "PRIOR_LOBES"), ("f0", "PRIOR_LOBES"), ("diffuse", "DIFFUSE"), ("damping", "DAMPING"),
    ("stretch", "STRETCH"), ("colour", "MIXTURE"), ("turn", "PRINCIPAL_AZIMUTH")])
def test_the_baker_writes_no_number_that_is_none_in_single_precision(with_lobes, field, constant, number):
    fit, mixture = with_lobes
    if field == "diffuse":
        points = np.full_like(fit.diffuse.control_points, number, dtype=float)
        fit = replace(fit, diffuse=replace(fit.diffuse, control_points=points))
    elif field in mixture._fields:
        mixture = mixture._replace(**{field: np.full_like(getattr(mixture, field), number, dtype=float)})
    elif field == "stretch":
        fit = replace(fit, coordinates=replace(fit.coordinates, stretch=number))
    elif field in ("offset", "ceiling", "damping"):
        numbers = np.full_like(getattr(fit.transform, field), number)[()]
        fit = replace(fit, transform=replace(fit.transform, **{field: numbers}))
    else:
        prior = replace(fit.transform.prior, **{field: np.full_like(getattr(fit.transform.prior, field), number)})
        fit = replace(fit, transform=replace(fit.transform, prior=prior))
    with pytest.raises(ValueError, match=rf"\b{constant}\b.* finite in single precision"):
        bake(fit, mixture=mixture)


def test_a_lobe_so_narrow_that_its_slope_overflows_is_not_baked(with_lobes):
    fit, mixture = with_lobes
    prior = replace(fit.transform.prior, alpha=np.full(len(fit.transform.prior.alpha), 1e-20))
    with pytest.raises(ValueError, match="PRIOR_LOBES"):
        bake(replace(fit, transform=replace(fit.transform, prior=prior)), mixture=mixture)


@pytest.mark.parametrize("depth", [10, 100_000])
def test_a_header_of_nothing_but_brackets_is_refused(tmp_path, depth):
    np.savez(tmp_path / "deep.npz", header=np.array("[" * depth + "]" * depth))
    with pytest.raises(fitter.DatasetError, match="not a fit"):
        fitter.Fit.load(tmp_path / "deep.npz")


def test_a_fit_of_another_version_says_which_and_what_to_do(glossy, tmp_path):
    path = tmp_path / "later.npz"
    for version in (fit_file.VERSION - 1, fit_file.VERSION + 1):
        tampered(fitter.fit(glossy, 2, None), path, header={"version": version})
        with pytest.raises(fitter.DatasetError, match=rf"version {version}, expected .*fit the data again"):
            fitter.Fit.load(path)


def assert_same(back, fit):
    """Every number and word of two fits is the same, to the last bit."""
    assert back.coordinates == fit.coordinates
    for name in ("compression", "channels", "columns", "changes", "name", "source", "nbytes", "coefficient_count"):
        assert getattr(back, name) == getattr(fit, name), name
    assert type(back.transform) is type(fit.transform)
    if isinstance(fit.transform, LogRelative):
        assert (back.transform.offset, back.transform.floor) == (fit.transform.offset, fit.transform.floor)
        assert back.transform.prior.kinds == fit.transform.prior.kinds
        for name in ("kd", "ks", "alpha", "gamma", "f0"):
            np.testing.assert_array_equal(getattr(back.transform.prior, name), getattr(fit.transform.prior, name))
        np.testing.assert_array_equal(back.transform.damping, fit.transform.damping)
        np.testing.assert_array_equal(back.transform.ceiling, fit.transform.ceiling)
    np.testing.assert_array_equal(back.diffuse.control_points, fit.diffuse.control_points)
    assert (back.specular is None) == (fit.specular is None)
    directions = np.random.default_rng(4).random((4, 500)) * [[1.57], [6.3], [1.57], [6.3]]
    np.testing.assert_array_equal(back.evaluate(*directions), fit.evaluate(*directions))


@pytest.mark.parametrize("plausible", [True, False])
@pytest.mark.parametrize("name", MADE_FITS)
def test_every_part_of_a_fit_comes_back(name, plausible, tmp_path):
    fit = MADE_FITS[name]
    fit = replace(fit, changes=("lowered",), transform=replace(fit.transform, floor=0.0 if plausible else -np.inf))
    fit.save(tmp_path / "fit.npz")
    assert_same(fitter.Fit.load(tmp_path / "fit.npz"), fit)


def test_the_softening_of_a_fit_is_baked():
    fit = MADE_FITS["half and difference, softened by 0.3, stretched by 12"]
    baked = float(re.search(r"#define SOFTENING_2 (\S+)", bake(fit, mixture=any_mixture(fit)))[1])
    assert baked == pytest.approx(0.3 ** 2, rel=1e-6)


@pytest.mark.parametrize("softening", [-0.1, 0.0, 1e-9, 1.0, math.nan, math.inf, "0.1", None, True, [0.1], 10**400])
def test_a_softening_radius_that_is_none_is_refused(tmp_path, softening):
    tampered(MADE_FITS["half and difference"], tmp_path / "bad.npz", header={"softening": softening})
    with pytest.raises(fitter.DatasetError, match=r"bad\.npz"):
        fitter.Fit.load(tmp_path / "bad.npz")


@pytest.mark.parametrize("stretch", [-5.0, 0.05, 1e9, math.nan, math.inf, "5", None, True, [5.0], 10**400])
@pytest.mark.parametrize("name", ["stretch", "back_stretch"])
def test_a_stretch_of_the_half_angle_that_is_none_is_refused(tmp_path, name, stretch):
    tampered(MADE_FITS["half angle"], tmp_path / "bad.npz", header={name: stretch})
    with pytest.raises(fitter.DatasetError, match=r"bad\.npz: a damaged fit.*stretch"):
        fitter.Fit.load(tmp_path / "bad.npz")


def test_a_fit_of_the_half_angle_has_no_softening_of_its_own(tmp_path):
    """It follows from the stretch."""
    fit = MADE_FITS["half angle, stretched by 300, all lobes, damped"]
    tampered(fit, tmp_path / "fit.npz", header={"softening": 0.5})
    assert fitter.Fit.load(tmp_path / "fit.npz").coordinates == fit.coordinates


@pytest.mark.parametrize(("header", "message"), [
    ({"coordinates": "spherical"}, "coordinates are unknown"), ({"coordinates": ["rusinkiewicz"]}, ""),
    ({"transform": "linear"}, "transform is unknown"),
    *(({"stretch": stretch}, "stretch") for stretch in (
        math.nan, math.inf, 1e9, -5.0, 1e-300, 0.05, "5", None, True, [5.0])),
    *(({"softening": softening}, "softening") for softening in (0.0, 1e-9, -0.01, 1.0, math.nan, "0.01", None)),
    *(({"lobes": lobes}, "") for lobes in (
        ["mirror", "retro", "velvet"], ["mirror", "retro"], ["mirror"] * 4, "mirror", [], None, 3, [["mirror"]] * 3,
        {"mirror": 1, "retro": 2, "sheet": 3}))])
def test_a_header_with_parts_that_do_not_exist_is_refused(tmp_path, header, message):
    path = tmp_path / "bad.npz"
    tampered(DAMPED, path, header)
    with pytest.raises(fitter.DatasetError, match=rf"bad\.npz: a damaged fit.*{message}"):
        fitter.Fit.load(path)


@pytest.mark.parametrize("missing", ["stretch", "softening", "lobes", "coordinates", "transform"])
def test_a_header_without_a_part_of_its_version_is_refused(tmp_path, missing):
    DAMPED.save(tmp_path / "fit.npz")
    with np.load(tmp_path / "fit.npz") as file:
        entries = dict(file)
    header = json.loads(str(entries["header"]))
    del header[missing]
    np.savez(tmp_path / "bad.npz", **entries | {"header": np.array(json.dumps(header))})
    with pytest.raises(fitter.DatasetError, match=rf"bad\.npz.*{missing}"):
        fitter.Fit.load(tmp_path / "bad.npz")


@pytest.mark.parametrize("damping", [
    lambda d: d - 1, lambda d: d + 1, lambda d: np.full_like(d, np.nan), lambda d: np.full_like(d, np.inf),
    lambda d: d[:-1], lambda d: d[:, :1], lambda d: d.astype(np.float32), lambda d: d[0, 0], lambda d: d.ravel(),
    lambda d: np.concatenate([d, d])], ids=range(10))
def test_a_damping_that_is_not_a_factor_at_each_knot_is_refused(tmp_path, damping):
    path = tmp_path / "bad.npz"
    tampered(DAMPED, path, damping=damping(DAMPED.transform.damping))
    with pytest.raises(fitter.DatasetError, match=r"bad\.npz: a damaged fit"):
        fitter.Fit.load(path)


HOSTILE = '"; */ } shader evil() { system("x"); } /* #include <x> \n#define SPARSE 1\n'


def test_no_name_path_or_text_of_a_fit_becomes_code(glossy, tmp_path):
    """The baked source is the same to the letter, whatever the strings of the fit say."""
    fit = fitter.fit(replace(glossy, name=HOSTILE, source=HOSTILE, channels=(HOSTILE, "#", "*/")), 1, 2)
    fit.save(tmp_path / "hostile.npz")
    loaded = fitter.Fit.load(tmp_path / "hostile.npz")
    assert loaded.name == HOSTILE
    mixture = any_mixture(loaded)
    assert bake(loaded, mixture=mixture) == bake(fitter.fit(glossy, 1, 2), mixture=mixture)


@pytest.mark.parametrize("number", [2**31, "1;", [1], 1.5, True, None, -1, 10**400])
@pytest.mark.parametrize("entry", ["diffuse_level", "specular_level", "multiplier"])
def test_a_number_of_the_header_that_is_none_is_refused(glossy, tmp_path, entry, number):
    path = tmp_path / "bad.npz"
    tampered(fitter.fit(glossy, 1, 2), path, header={entry: number})
    if entry == "specular_level" and number is None:
        assert fitter.Fit.load(path).specular is None       # plain MBA; the other arrays are not looked at
        return
    with pytest.raises(fitter.DatasetError, match=r"bad\.npz"):
        fitter.Fit.load(path)


@pytest.mark.parametrize("kind", ["of the paper", "Rusinkiewicz, stretched by 33, all lobes, damped",
                                  "half angle, stretched by 300, all lobes, damped"])
def test_whatever_a_file_says_it_is_refused_or_only_its_numbers_are_baked(glossy, tmp_path, kind):
    """Each entry of a saved fit in turn holds text that would be code, a NaN, or another type."""
    path = tmp_path / "fit.npz"
    fit = MADE_FITS[kind] if kind in MADE_FITS else fitter.fit(subset(glossy, slice(200)), 1, 3)
    fit.save(path)
    with np.load(path) as file:
        entries = dict(file)
    header = json.loads(str(entries["header"]))
    mixture = any_mixture(fit)
    expected = bake(fit, mixture=mixture)
    odd = HOSTILE, [HOSTILE] * 3, {"x": HOSTILE}, math.inf, 10**400, [0, 1, 10**12], [-1, 0, 1]
    changes = [{"header": {key: value}} for key in header for value in odd]
    for name, array in entries.items():
        if name != "header":
            changes += [{name: np.full(array.shape, value).astype(kind)} for kind, values in (
                ("f4", (np.nan, np.inf, -np.inf)), ("f8", (1e300,)), ("U9", ("1;};evil",)), ("i8", (-1, 2**62)))
                for value in values]
    for change in changes:
        tamper(path, entries, **change)
        try:
            loaded = fitter.Fit.load(path)
        except fitter.DatasetError:
            continue
        assert change.get("header", {}).keys() <= {"name", "source", "channels", "compression", "changes"}, change
        assert bake(loaded, mixture=mixture) == expected
