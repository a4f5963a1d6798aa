"""How the readers treat damaged and hostile files: ``python -m tools.fuzz``.

A case is a file of one of the formats, put through up to four mutations. Its number makes it again: ``python -m
tools.fuzz 1 123`` is the case 123 alone, without the hostile files. `check` holds what docs/robustness.md promises of
every one; of the formats in `NAIVE`, the numbers are those that a naive reading of the same bytes finds.
"""

import argparse
import contextlib
import io
import math
import random
import re
import struct
import sys
import tempfile
import time
import tracemalloc
import zlib
from collections import Counter, defaultdict
from functools import cache
from pathlib import Path

import numpy as np

import fitter
from fitter import cli, formats
from fitter.colours import conversion
from fitter.cycles.bake import bake
from fitter.formats import astm, curet, merl, saved_samples, spectra
from fitter.methods import METHODS
from fitter.samples import LARGEST_VALUE, choice, subset
from support import (
    anisotropic,
    checkout,
    hostile_files,
    mbsdf_files,
    merl_files,
    panel_work,
    tensor_files,
    utia_files,
    zemax_files,
)

SECONDS = 5.0               # of processor time
MEMORY = 10                 # times the file
_OVERHEAD = 1 << 20         # bytes: tables of colour matching and geometry, pieces being parsed
_OVERHEAD_DESCRIBING = 32 << 20     # and as many cosines as are worked out at a time
_ONE_OF = 50                # of the fits is baked: that takes a second
_MOST_FITTED = 20_000       # samples; of more those of the largest and least values, and others
_ODD = (b"nan", b"-nan", b"inf", b"-inf", b"1e999", b"1e300", b"-1e31", b"1e-400", b"-0", b"1_0", b"0x10", b"1,5",
        b"--1", b"1e", b"1.5708", b"-0.1", b"9" * 500, b"0." + b"3" * 5000, b"R", b"", b"\xd9\xa3", b"\xc2\xa0", b"#",
        b"400nm", b"VARS", b"2147483648", b"1e5", b"\0", b"\x85", b"\x1c", b"\xef\xbb\xbf")
_NUMBER = re.compile(rb"[-+.\w]+")
_OPTIONS = ({"colours": "ACEScg"}, {"angles": "radians", "quantity": "brdf_cos"}, {"angles": "degrees"},
            {"quantity": "brdf_cos_i", "illuminant": "A", "colours": "Rec.2020"}, {"isotropic": False},
            {"isotropic": True, "symmetry": "half_turn"})      # of reading, one for each case
_PANEL = panel_work.load()


@cache
def seeds():
    """Whole files to start from: {name: content}."""
    rng = np.random.default_rng(7)
    numbers = rng.random((40, 7)) * [1.5, 0, 1.5, 6, 1, 1, 1]
    bands = np.arange(400, 701, 20)
    found = {
        "astm, made": _text("SAMPLE_NAME Made", f"NUM_POINTS {len(numbers)}", "VARS theta_i,phi_i,theta_s,phi_s,R,G,B",
                            table=numbers),
        "pbrt, made": _text("# made", str(len(bands)), " ".join(map(str, bands)), form=".5g", separator=" ",
                            table=[[*row[:4], *np.full(len(bands), row[4])] for row in numbers]),
        "curet, made": "\n".join(" ".join([str(n), *(f"{value:.3f}" for value in rng.random(205))])
                                 for n in (3, 1, 61)).encode(),
        "matlab, made": _matlab(rng, deflated=False), "matlab, deflated": _matlab(rng, deflated=True),
        "rgl, made": tensor_files.pack(tensor_files.material(seed=7)),
        "merl, made": merl_files.pack(merl_files.random_cells(4, 7)),
        "merl, float32": merl_files.pack(merl_files.random_cells(3, 8), "<f4"),
        "mbsdf, made": mbsdf_files.made(values=rng.random(135)),
        "zemax, made": zemax_files.made(rng.random((1, 2, 3, 3)).round(4)).encode(),
        "zemax, XYZ": zemax_files.made(rng.random((3, 2, 4, 3)).round(4), azimuths=(0, 60, 120, 180),
                                       SpectralContent="XYZ").encode(),
        "rgl, anisotropic": tensor_files.pack(tensor_files.anisotropic(tensor_files.material(seed=9), seed=9)),
        "zemax, rotations": zemax_files.made(rng.random((1, 12, 4, 3)).round(4) + 1, azimuths=(0, 60, 120, 180),
                                             rotations=(0, 30, 60, 90, 120, 360),
                                             Symmetry="PlaneSymmetrical4D").encode(),
        "samples, saved": _saved(numbers),
        "translucent, made": b"# made\nname,scattering,absorption,index,width\nOne,2.1 2.6 3,0.01,1.5,0.1\nTwo,1,1,,\n",
        "utia, made": utia_files.pack(utia_files.values_of(anisotropic.ggx())),
        "rgl, spectral": tensor_files.pack(tensor_files.spectral(tensor_files.material(seed=8), bands))}
    found["astm, without a count"] = _uncounted(found["astm, made"])
    found["astm, other columns"] = _text("VARS\tphi_r[deg]\ttheta_r[deg]\t650nm\tphi_i[deg]\ttheta_i[deg]",
                                         table=numbers[:, [1, 2, 4, 3, 0]] * [57, 57, 1, 57, 57], form=".4f",
                                         separator="\t")
    found["table, made"] = _text("# angles: radians", "theta_i;theta_o;phi;R;G;B", table=numbers[:, [0, 2, 3, 4, 5, 6]],
                                 separator=";").replace(b".", b",")
    found["table, a cosine and a standard"] = _text(
        "# standard: 0.9", "theta_i[deg],phi_i[deg],theta_r[deg],phi_r[deg],BRDF*cos_o,standard", form=".4f",
        table=numbers[:, :6] * [57, 57, 57, 57, 1, 1] + [0, 0, 0, 0, 0, 0.1])
    turns = anisotropic.grid((20, 50), (0, 30, 60, 90), (0, 20, 40, 60), range(0, 360, 45))
    turned = np.column_stack([*np.degrees(turns), anisotropic.ggx()(*turns)])
    found["table, rotations"] = _text("# symmetry: 180 degrees and mirror", "theta_i,phi_i,theta_o,phi_o,R,G,B",
                                      table=turned, form=".6g")
    found["astm, Light Tec"] = _text("VARS theta_i,phi_i,theta_s,465nm,525nm,630nm", table=numbers)
    folder = checkout.measurements()
    for path in (folder / "cornell" / "garnet_red_RGB.astm", folder / "cornell" / "krylon_blue.astm",
                 folder / "cornell" / "garnet_red.brdf", folder / "curet" / "abrdf.dat"):
        if path.is_file():
            found[path.name] = _beginning(path.read_bytes())
    return found


def _text(*head, table, form=".6f", separator=","):
    """Lines, and rows of numbers below them."""
    return "\n".join([*head, *(separator.join(f"{number:{form}}" for number in row) for row in table)]).encode()


def _saved(numbers):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "saved.npz"
        saved_samples.write(fitter.Samples(*numbers[:, :4].T, numbers[:, 4:], ("R", "G", "B"), "made", notes=("made",),
                                           deviation=numbers[:, 0]), path)
        return path.read_bytes()


def _beginning(content, lines=160):
    """The first lines of a long file: as good to damage, and faster."""
    return _uncounted(b"".join(content.splitlines(keepends=True)[:lines]))


def _uncounted(astm):
    return astm.replace(b"NUM_POINTS", b"NUM_ANGLES")


def _matlab(rng, deflated, count=30):
    from scipy.io import savemat

    vectors = rng.standard_normal((2, count, 3))
    vectors[..., 2] = np.abs(vectors[..., 2])
    stream = io.BytesIO()
    savemat(stream, {"dir_in": vectors[0], "dir_out": vectors[1], "wavelength": np.linspace(380, 700, 65),
                     "fr": rng.random((count, 65))}, do_compression=deflated)
    return stream.getvalue()


def _truncate(content, rng):
    return content[:rng.randrange(len(content) + 1)]


def _change_number(content, rng):
    numbers = list(_NUMBER.finditer(content))
    if not numbers:
        return content
    chosen = rng.choice(numbers)
    return content[:chosen.start()] + rng.choice(_ODD) + content[chosen.end():]


def _flip_bits(content, rng):
    damaged = bytearray(content)
    for _ in range(rng.choice((1, 3, 30))):
        if damaged:
            damaged[rng.randrange(len(damaged))] ^= 1 << rng.randrange(8)
    return bytes(damaged)


def _insert_noise(content, rng):
    place = rng.randrange(len(content) + 1)
    return content[:place] + rng.randbytes(rng.choice((1, 2, 16, 300))) + content[place:]


def _of_lines(change):
    def mutation(content, rng):
        lines = content.splitlines(keepends=True)
        change(lines, rng)
        return b"".join(lines)
    mutation.__name__ = change.__name__
    return mutation


@_of_lines
def _drop_lines(lines, rng):
    start = rng.randrange(len(lines) + 1)
    del lines[start:start + rng.choice((1, 2, 20))]


@_of_lines
def _repeat_lines(lines, rng):
    start = rng.randrange(len(lines) + 1)
    lines[start:start] = lines[start:start + rng.choice((1, 2, 20))]


@_of_lines
def _shuffle_lines(lines, rng):
    rng.shuffle(lines)


@_of_lines
def _mix_line_ends(lines, rng):
    lines[:] = [line.rstrip(b"\r\n") + rng.choice((b"\n", b"\r\n", b"\r", b"\n\n", b" \n")) for line in lines]


@_of_lines
def _shuffle_columns(lines, rng):
    order = rng.random()
    for number, line in enumerate(lines):
        separator = b"," if b"," in line else b" "
        columns = line.rstrip().removeprefix(b"VARS ").split(separator)
        random.Random(order).shuffle(columns)
        lines[number] = b"VARS " * line.startswith(b"VARS") + separator.join(columns) + b"\n"


def _encode(content, rng):
    return content.decode("latin-1").encode(rng.choice(("utf-16", "utf-16-le", "utf-32", "utf-7", "utf-8-sig")))


def _change_count(content, rng):
    def changed(match):
        return str(max(0, int(match[0]) + rng.choice((-5, -1, 1, 2, 400)))).encode()
    return re.sub(rb"\b\d+\b", changed, content, count=rng.choice((1, 2)))


def _comment(content, rng):
    place = rng.randrange(len(content) + 1)
    return content[:place] + rng.choice((b"#", b"# note\n", b"\n#\n")) + content[place:]


def _overwrite_word(content, rng):
    """Four bytes of a binary file: a size, a type, a dimension."""
    place = rng.randrange(max(len(content) // 4, 1)) * 4
    return content[:place] + struct.pack("<I", rng.choice((0, 1, 8, 15, 255, 1 << 16, 2**31 - 1, 2**32 - 1))) + (
        content[place + 4:])


MUTATIONS = (_truncate, _change_number, _flip_bits, _insert_noise, _drop_lines, _repeat_lines, _shuffle_lines,
             _mix_line_ends, _shuffle_columns, _encode, _change_count, _comment, _overwrite_word)


def case(files, number):
    """The case of a number: what it is made from, the names of its mutations, and its content."""
    rng = random.Random(number)
    if rng.randrange(20) == 0:
        noise = rng.randbytes(rng.randrange(400))
        return "noise", (), rng.choice((noise, noise.decode("latin-1").encode()))
    name = rng.choice(sorted(files))
    mutations = rng.choices(MUTATIONS, k=rng.randint(1, 4))
    content = files[name]
    for mutation in mutations:
        content = mutation(content, rng)
    return name, tuple(mutation.__name__ for mutation in mutations), content


def check(content, path):
    """Read a case with `fitter.load`, with options too, by the command line and as the panel does, fit it, bake some
    fits, and raise AssertionError where it breaks a promise: "refused" or "read", seconds, and memory, times the file,
    beyond what any file takes."""
    path.write_bytes(content)
    samples, message, seconds, memory = _measured(fitter.load, path, content, _OVERHEAD)
    assert str(path) in message, f"the message does not name the file: {message}"
    assert len(message) < 600, f"a message of {len(message)} characters"
    shown, complaint, more, _ = _measured(lambda path: _PANEL.read(path, None), path, content, _OVERHEAD_DESCRIBING)
    assert (samples is None) == (shown is None), complaint
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as complaint:
        code = cli.main(["info", str(path)])
    assert code == 0 or (samples is None and code == 1), complaint.getvalue()     # 0 for a list of CURET samples
    seconds = max(seconds, more)
    _read_with_options(content, path, samples)
    if samples is None:
        return "refused", seconds, memory
    _check_limits(samples)
    known, _ = formats._recognise(path)
    if known in NAIVE:
        _compare(samples, *NAIVE[known](content), computed=known is merl.FORMAT)
    assert shown.description.count == len(samples)
    assert 0 <= shown.description.gap <= 180
    which, rest = divmod(zlib.crc32(content), _ONE_OF)
    _fit_and_bake(_part(samples), path, list(METHODS)[which % len(METHODS)] if rest == 0 else None)
    return "read", seconds, memory


def _check_limits(samples):
    assert np.isfinite(samples.directions).all()
    assert np.abs(samples.values).max() <= LARGEST_VALUE
    for theta in (samples.theta_i, samples.theta_o):
        assert theta.min() >= 0
        assert theta.max() <= np.pi / 2


def _compare(samples, angles, values, computed):
    """Compare samples with a naive reading; where angles are computed, they are known but for whole turns."""
    repeated = any(note.startswith("Symmetr") for note in samples.notes)        # test_samples.py has the images
    assert len(samples) >= len(values) if repeated else len(samples) == len(values)
    directions = np.transpose(samples.directions)[:len(values)]
    if computed:
        np.testing.assert_allclose(_vectors(directions), _vectors(angles), rtol=0, atol=1e-6)
    else:
        np.testing.assert_array_equal(np.minimum(angles, [np.pi / 2, np.inf] * 2), directions)
    np.testing.assert_allclose(samples.values[:len(values)], values, rtol=1e-9, atol=1e-9 * np.abs(values).max())


def _read_with_options(content, path, samples):
    """Read a case, which is `samples` without options or None, with some of them."""
    options = _OPTIONS[zlib.crc32(content) // _ONE_OF % len(_OPTIONS)]
    found, message, _, _ = _measured(lambda path: fitter.load(path, **options), path, content, _OVERHEAD)
    assert str(path) in message, f"the message does not name the file: {message}"
    assert "angles" not in options or "may be degrees or radians" not in message, message
    if [*options] == ["colours"]:
        assert (found is None) == (samples is None), message
        if samples is not None:
            matrix = np.eye(1) if len(samples.channels) == 1 else conversion("Rec.709", options["colours"])
            np.testing.assert_allclose(found.values, samples.values @ matrix.T, rtol=1e-9,
                                       atol=1e-9 * np.abs(samples.values).max())


def _vectors(angles):
    """Unit vectors of theta, phi, theta, phi: (n, 4) to (n, 6)."""
    return np.concatenate([[np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)]
                           for theta, phi in (angles[:, :2].T, angles[:, 2:].T)]).T


def _measured(read, path, content, overhead):
    """The result of `read` or None, and its message; the seconds, and the memory as a multiple of the file."""
    tracemalloc.start()
    start = time.process_time()
    try:
        found, message = read(path), str(path)
    except (fitter.DatasetError, _PANEL.fitter.DatasetError) as error:
        found, message = None, str(error)
    finally:
        seconds = time.process_time() - start
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    memory = max(0, peak - overhead) / max(len(content), 1)
    assert seconds < SECONDS, f"{seconds:.1f} s"
    assert memory < MEMORY, f"{memory:.1f} times the file"
    return found, message, seconds, memory


def _part(samples):
    """`_MOST_FITTED` samples at most: a third each of the largest and of the least values, and others at random."""
    if len(samples) <= _MOST_FITTED:
        return samples
    order, third = np.argsort(samples.values.max(axis=1)), _MOST_FITTED // 3
    chosen = np.concatenate([order[:third], order[-third:], choice(len(samples), third)])
    return subset(samples, np.unique(chosen))


def _fit_and_bake(samples, path, baked):
    """Fit by every method, and save, read and bake the fit by the method `baked`, which is made plausible."""
    for method in METHODS:
        fit = fitter.fit(samples, 1, 2, 90, method, plausible=method == baked)
        fitted = fit.evaluate(*samples.directions)
        assert np.isfinite(fitted).all()
        if method == baked:
            fit.save(path.with_suffix(".npz"))
            again = fitter.Fit.load(path.with_suffix(".npz"))
            np.testing.assert_array_equal(again.evaluate(*samples.directions), fitted)
            bake(again)


# angles (n, 4) and values (n, channels) of a valid file, by format

def _naive_lines(content):
    """Those with words; of UTF-16 with its mark or with every other byte of the first numbers zero, else any bytes."""
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        text = content.decode("utf-16")
    elif b"\0" in content[:4]:
        text = content.decode("utf-16-le" if content[1] == 0 else "utf-16-be")
    else:
        text = content.removeprefix(b"\xef\xbb\xbf").decode("latin-1")
    return [line for line in text.replace("\r\n", "\n").replace("\r", "\n").split("\n") if line.split()]


def _naive_astm(content):
    lines = _naive_lines(content)
    start = next(n for n, line in enumerate(lines) if line.startswith("VARS"))
    header, rows = lines[start][4:], lines[start + 1:]
    names = [name.strip("# \t").lower() for name in header.split("," if "," in header else None)]
    table = np.array([row.split("," if "," in rows[0] else None) for row in rows], dtype=float)
    if table.shape[1] > len(names):
        theta = next(n for n, name in enumerate(names) if name.startswith("theta") and "i" not in name)
        names.insert(theta + 1, "phi_s")
    kinds = [(name[0] + "i" * (name.replace("_", "").removeprefix("theta").removeprefix("phi")[:1] == "i"))
             if name.startswith(("theta", "phi")) else "" for name in names]
    angles = table[:, [kinds.index(kind) for kind in ("ti", "pi", "t", "p")]]
    if any("deg" in name for name, kind in zip(names, kinds, strict=True) if kind) or (
            not any("rad" in name for name, kind in zip(names, kinds, strict=True) if kind)
            and (np.abs(angles) > 2 * np.pi + 1e-3).sum() > (angles != 0).sum() / 2):
        angles = np.radians(angles)
    columns = {name: table[:, n] for n, name in enumerate(names) if not kinds[n]}
    if len(columns) == 1:
        return angles, np.transpose([*columns.values()])
    if set(columns) == set("rgb"):
        return angles, np.transpose([columns[name] for name in "rgb"])
    bands = np.array([float(name.rstrip("nm ")) for name in columns])
    values = np.transpose([*columns.values()])
    if len(bands) == 3 and bands[2] - bands[0] < 200:
        return angles, values[:, np.argsort(-bands)]
    order = np.argsort(bands)
    return angles, values[:, order] @ spectra.srgb_weights(bands[order]).T


def _naive_curet(content):
    return curet.geometry()[:, [2, 3, 0, 1]], np.array([_naive_lines(content)[0].split()[1:]], dtype=float).T


def _naive_merl(content):
    """Cell by cell: the frame of the half vector, turned from that of the normal about the y axis."""
    n_h, n_d, n_p = struct.unpack("<3i", content[:12])
    count = n_h * n_d * n_p
    kind = {8: "d", 4: "f", 2: "e"}[(len(content) - 12) // (3 * count)]
    numbers = struct.unpack(f"<{3 * count}{kind}", content[12:])
    angles, values = [], []
    for cell in range(count):
        color = [numbers[cell + channel * count] for channel in range(3)]
        theta_h = (cell // n_p // n_d / n_h) ** 2 * math.pi / 2
        theta_d, phi_d = cell // n_p % n_d / n_d * math.pi / 2, cell % n_p / n_p * math.pi
        turn = np.array([[math.cos(theta_h), 0, math.sin(theta_h)], [0, 1, 0],
                         [-math.sin(theta_h), 0, math.cos(theta_h)]])
        wi = turn @ [math.sin(theta_d) * math.cos(phi_d), math.sin(theta_d) * math.sin(phi_d), math.cos(theta_d)]
        wo = 2 * (wi @ turn[:, 2]) * turn[:, 2] - wi
        if min(color) >= 0 and min(wi[2], wo[2]) > 1e-12:
            angles.append([math.acos(min(wi[2], 1)), math.atan2(wi[1], wi[0]), math.acos(min(wo[2], 1)),
                           math.atan2(wo[1], wo[0])])
            values.append(np.multiply(color, [1, 1.15, 1.66]) / 1500)
    return np.array(angles), np.array(values)


NAIVE = {astm.FORMAT: _naive_astm, curet.FORMAT: _naive_curet, merl.FORMAT: _naive_merl}


def run(numbers, folder):
    """Go through cases: {what they are made from: Counter}, the worst time and memory, and what broke a promise."""
    files = seeds()
    for name, content in files.items():
        assert check(content, folder / "seed.dat")[0] == "read", name
    tally, worst, broken = defaultdict(Counter), {"seconds": 0.0, "memory": 0.0}, []
    for number in numbers:
        name, mutations, content = case(files, number)
        try:
            outcome, seconds, memory = check(content, folder / "case.dat")
        except Exception as error:
            broken.append(f"case {number}, {name} {' '.join(mutations)}: {error!r:.300}")
            continue
        tally[name][outcome] += 1
        worst.update(seconds=max(worst["seconds"], seconds), memory=max(worst["memory"], memory))
    return tally, worst, broken


def main():
    """Print the tables; the exit status is 1 where a promise was broken."""
    parser = argparse.ArgumentParser(prog="python -m tools.fuzz", description="How readers treat damaged files.")
    parser.add_argument("count", type=int, nargs="?", help="so many cases, without the hostile files; else 20000")
    parser.add_argument("first", type=int, nargs="?", default=0, help="the number of the first")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        count = 20000 if chosen.count is None else chosen.count
        tally, worst, broken = run(range(chosen.first, chosen.first + count), Path(folder))
        seconds = time.perf_counter() - start
        tally["all"] = sum(tally.values(), Counter())
        print(f"{'cases':>7}  {'read':>6}  {'refused':>7}  made from")
        for name, row in tally.items():
            print(f"{row.total():7,}  {row['read']:6,}  {row['refused']:7,}  {name}")
        print(f"{seconds:.0f} s; the slowest case {worst['seconds']:.3f} s, the largest {worst['memory']:.1f} times "
              f"its file\n")
        if chosen.count is None:
            hostile_files.report(Path(folder))
    print("\n".join(broken))
    return bool(broken)


if __name__ == "__main__":
    sys.exit(main())
