import json
import math
import re
import tracemalloc
import zipfile
from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest

import fitter
from fitter.coordinates.nusselt import Nusselt
from fitter.cycles.bake import bake
from fitter.methods.editing import edited
from fitter.model import fit_file
from fitter.samples import subset
from support import hostile_fits
from support.made_fits import MADE_FITS
from support.mixtures import any_mixture

LOBES = "Rusinkiewicz, stretched by 33, all lobes, damped"
DAMPED = MADE_FITS[LOBES]
DAMPING = DAMPED.transform.damping
ALL_EDITS = {"diffuse": (0.5, 1.0, 2.0), "highlight": (3.0, 0.5, 1.0), "width": 1.7, "coat": 0.6, "coat_width": 0.1}
FITS = MADE_FITS | {
    "not plausible": replace(DAMPED, changes=("lowered",), transform=replace(DAMPED.transform, floor=-np.inf)),
    "of the paper": replace(DAMPED, coordinates=Nusselt(), transform=None),
    "of the paper, dense": replace(DAMPED, coordinates=Nusselt(), transform=None, specular=None, compression=0.0),
    **{f"edited, {name}": edited(MADE_FITS[name], **ALL_EDITS) for name in (
        LOBES, "half and difference, stretched by 5, retro, grey, damped", "half angle",
        "half and difference, stretched by 2, all lobes, two columns, damped", "anisotropic Rusinkiewicz",
        "anisotropic Rusinkiewicz, stretched by 33, a Lambertian, dense, grey")}}


@pytest.fixture(params=[{"specular_level": None, "diffuse_level": 3}, {"diffuse_level": 2, "specular_level": 4}])
def fit(request, glossy):
    return fitter.fit(glossy, **request.param)


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


NO_NUMBERS = math.nan, math.inf, "5", None, True, [5.0], 10 ** 400
NO_DAMPINGS = (DAMPING - 1, DAMPING + 1, np.full_like(DAMPING, np.nan), np.full_like(DAMPING, np.inf), DAMPING[:-1],
               DAMPING[:, :1], DAMPING.astype(np.float32), DAMPING[0, 0], DAMPING.ravel(),
               np.concatenate([DAMPING, DAMPING]))
REFUSED = [     # a fit, what is wrong in its file, and what the message says
    *(("of the paper", {"header": {name: number}}, "") for name in ("diffuse_level", "specular_level", "multiplier")
      for number in (2 ** 31, "1;", [1], 1.5, True, -1, 10 ** 400)),
    *(("of the paper", {"header": header}, "") for header in (
        {"version": 99}, {"diffuse_level": 4}, {"diffuse_level": "4"}, {"channels": []}, {"specular_level": 3},
        {"multiplier": 3}, {"compression": math.nan}, {"format": "something else"})),
    *(("of the paper", arrays, "") for arrays in (
        {"diffuse": np.zeros(3, np.float32)}, {"keys": np.zeros(5, np.uint32)},
        {"displacement": np.zeros(0, np.uint16)},
        {"displacement": DAMPED.specular.index.displacement + DAMPED.specular.index.keys.size},
        {"coefficients": np.full((5, 3), np.nan, np.float32)}, {"diffuse": np.array([object()])})),
    *((LOBES, {"header": {"softening": number}}, "softening") for number in (*NO_NUMBERS, 0.0, 1e-9, -0.01, 1.0)),
    *((name, {"header": {stretch: number}}, stretch)
      for name, stretch in ((LOBES, "stretch"), ("half angle", "stretch"), ("half angle", "back_stretch"))
      for number in (*NO_NUMBERS, 1e9, -5.0, 1e-300, 0.05)),
    *((LOBES, {"header": {"lobes": lobes}}, "") for lobes in (
        ["mirror", "retro", "velvet"], ["mirror", "retro"], ["mirror"] * 4, "mirror", [], None, 3, [["mirror"]] * 3,
        {"mirror": 1, "retro": 2, "sheet": 3})),
    (LOBES, {"header": {"coordinates": "spherical"}}, "coordinates are unknown"),
    (LOBES, {"header": {"coordinates": ["rusinkiewicz"]}}, ""),
    (LOBES, {"header": {"transform": "linear"}}, "transform is unknown"),
    *((LOBES, {"damping": damping}, "") for damping in NO_DAMPINGS)]


@pytest.mark.parametrize(("name", "change", "message"), REFUSED, ids=range(len(REFUSED)))
def test_a_file_that_holds_no_fit_is_refused(tmp_path, name, change, message):
    tampered(FITS[name], tmp_path / "bad.npz", **change)
    with pytest.raises(fitter.DatasetError, match=rf"bad\.npz: .*{message}"):
        fitter.Fit.load(tmp_path / "bad.npz")


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
    assert type(back) is type(fit)
    if is_dataclass(fit):
        for field in fields(fit):
            assert_same(getattr(back, field.name), getattr(fit, field.name))
    else:
        assert getattr(back, "dtype", None) == getattr(fit, "dtype", None)
        np.testing.assert_array_equal(back, fit)


@pytest.mark.parametrize("name", FITS)
def test_every_part_of_a_fit_comes_back(name, tmp_path):
    FITS[name].save(tmp_path / "fit.npz")
    back = fitter.Fit.load(tmp_path / "fit.npz")
    assert_same(back, FITS[name])
    directions = np.random.default_rng(4).random((4, 500)) * [[1.57], [6.3], [1.57], [6.3]]
    np.testing.assert_array_equal(back.evaluate(*directions), FITS[name].evaluate(*directions))
    assert [path.name for path in tmp_path.iterdir()] == ["fit.npz"]


def test_the_softening_of_a_fit_is_baked():
    fit = MADE_FITS["half and difference, softened by 0.3, stretched by 12"]
    baked = float(re.search(r"#define SOFTENING_2 (\S+)", bake(fit, mixture=any_mixture(fit)))[1])
    assert baked == pytest.approx(0.3 ** 2, rel=1e-6)


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


HOSTILE = '"; */ } shader evil() { system("x"); } /* #include <x> \n#define SPARSE 1\n'


def test_no_name_path_or_text_of_a_fit_becomes_code(glossy, tmp_path):
    """The baked source is the same to the letter, whatever the strings of the fit say."""
    fit = fitter.fit(replace(glossy, name=HOSTILE, source=HOSTILE, channels=(HOSTILE, "#", "*/")), 1, 2)
    fit.save(tmp_path / "hostile.npz")
    loaded = fitter.Fit.load(tmp_path / "hostile.npz")
    assert loaded.name == HOSTILE
    mixture = any_mixture(loaded)
    assert bake(loaded, mixture=mixture) == bake(fitter.fit(glossy, 1, 2), mixture=mixture)


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
