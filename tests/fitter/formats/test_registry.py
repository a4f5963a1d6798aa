"""What every file format must do. A format that is entered in FORMATS is tested here, once it has an example below."""

import io
import tempfile
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

import fitter
from fitter import DatasetError, formats
from fitter.formats import FORMATS, saved_samples
from fitter.formats.text import plain_text
from support import anisotropic_instruments as instruments
from support import mbsdf_files, merl_files, speos_files, tensor_files, utia_files, zemax_files

ANGLES = [(0.2, 0.0, 0.3, 3.1), (0.9, 0.0, 0.4, -2.0), (1.2, 0.0, 1.1, 0.5)]
WAVELENGTHS = np.arange(400, 701, 50)


def astm():
    rows = "".join(f"{i},{pi},{o},{po},0.1,0.2,0.3\n" for i, pi, o, po in ANGLES)
    return f"SAMPLE_NAME Made\nNUM_POINTS 3\nVARS theta_i,phi_i,theta_s,phi_s,R,G,B\n{rows}".encode()


def pbrt():
    rows = "".join(f"{i} {pi} {o} {po} {' 0.2' * len(WAVELENGTHS)}\n" for i, pi, o, po in ANGLES)
    return f"{len(WAVELENGTHS)}  # made\n{' '.join(map(str, WAVELENGTHS))}\n{rows}".encode()


def curet():
    return "".join(f"{number} {' 0.125' * 205}\n" for number in (1, 5, 61)).encode()


def paint():
    theta_i, phi_i, theta_o, phi_o = np.transpose(ANGLES)
    stream = io.BytesIO()
    savemat(stream, {"dir_in": instruments.unit(theta_i, phi_i).T, "dir_out": instruments.unit(theta_o, phi_o).T,
                     "fr": np.full((3, len(WAVELENGTHS)), 0.2), "wavelength": WAVELENGTHS.astype(float)},
            do_compression=True)
    return stream.getvalue()


def table():
    rows = "".join(f"{i};{o};{po - pi};0,1;0,2;0,3\n" for i, pi, o, po in ANGLES)
    return f"# made\ntheta_i[rad];theta_o[rad];phi[rad];R;G;B\n{rows}".encode()


def saved():
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "saved.npz"
        saved_samples.write(fitter.Samples(*np.transpose(ANGLES), np.full((3, 3), 0.2), ("R", "G", "B")), path)
        return path.read_bytes()


def fred():
    rows = "".join(f"{i} 0\n{o} {po} 0.2\n" for i, _, o, po in np.degrees(ANGLES))
    return f"type bsdf_data\nformat angles=deg bsdf=value scale=1\n{rows}".encode()


# by `Format.files`; a format without an example fails the first test
EXAMPLES = {"Cornell or Light Tec ASTM (.astm)": astm(), "pbrt-v2 .brdf": pbrt(), "CURET abrdf.dat": curet(),
            "Cornell paint.reformat.mat": paint(), "RGL .bsdf": tensor_files.pack(tensor_files.material()),
            "MERL .binary": merl_files.pack(merl_files.random_cells(3, 1)),
            "table with column names (.csv, .tsv, .txt)": table(),
            "NVIDIA .mbsdf": mbsdf_files.made(), "Zemax .bsdf": zemax_files.made().encode(),
            "FRED's text (.txt)": fred(), "Speos .anisotropicbsdf": speos_files.made().encode(),
            "UTIA .bin": utia_files.pack(utia_files.values_of(instruments.ggx())),
            "translucent materials .csv": b"name,albedo,path\nWax,.8 .5 .2,2\nSoap,.6,1\n",
            "samples saved by Measured BRDF (.npz)": saved()}
every_format = pytest.mark.parametrize("known", FORMATS, ids=lambda known: known.files)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "measured.xyz"


def recognised_by(content):
    """All formats that recognise a file, each asked with the content in the form that it takes."""
    try:
        text = plain_text(content, "example")
    except DatasetError:
        text = None
    return [known for known in FORMATS
            if (text is not None and known.recognises(text) if known.is_text else known.recognises(content))]


def read_or_refuse(path, content):
    """Load a file: True if it was read, False if it raised DatasetError. Any other exception fails the test."""
    path.write_bytes(content)
    try:
        samples = fitter.load(path)
    except DatasetError as error:
        if Path(error.path) != path:
            raise
        return False
    assert np.isfinite(samples.values).all()
    return True


def test_every_format_has_an_example_and_a_name_of_its_own():
    assert {known.files for known in FORMATS} == set(EXAMPLES)
    assert len({known.files for known in FORMATS}) == len(FORMATS)


@every_format
def test_extensions_are_lower_case_and_begin_with_a_dot(known):
    assert known.extensions
    for extension in known.extensions:
        assert extension.startswith(".")
        assert len(extension) > 1
        assert extension == extension.lower()
        assert extension in formats.EXTENSIONS


@every_format
def test_its_example_is_recognised_by_this_format_alone(known):
    assert recognised_by(EXAMPLES[known.files]) == [known]


@every_format
def test_its_example_is_read_whatever_the_files_name(known, path):
    assert read_or_refuse(path, EXAMPLES[known.files])
    samples = fitter.load(path)
    assert samples.source == str(path)
    assert len(samples.channels) == samples.values.shape[1]


@every_format
def test_the_samples_that_it_lists_are_read_by_number_and_by_name(known, path):
    path.write_bytes(EXAMPLES[known.files])
    listed = formats.list_samples(path)
    assert bool(listed) == (known.list_samples is not None)
    for number, name in listed:
        assert fitter.load(path, number).name == fitter.load(path, name).name == name


@every_format
def test_a_byte_order_mark_before_text_does_not_matter(known, path):
    if known.is_text:
        assert read_or_refuse(path, b"\xef\xbb\xbf" + EXAMPLES[known.files])


@every_format
def test_truncations_are_read_or_refused(known, path):
    content = EXAMPLES[known.files]
    lengths = np.unique(np.linspace(1, len(content) - 1, 80).astype(int))
    read = [read_or_refuse(path, content[:length]) for length in lengths]
    assert not read[0]                      # a single byte is no measurement


@every_format
def test_arbitrary_bytes_are_read_or_refused(known, path, random):
    content = EXAMPLES[known.files]
    for _ in range(60):
        noise = random.integers(0, 256, random.integers(1, 64), dtype=np.uint8).tobytes()
        place = random.integers(0, len(content))
        read_or_refuse(path, noise)
        read_or_refuse(path, content[:place] + noise + content[place + len(noise):])


def test_what_numpy_warns_of_while_a_file_is_read_reaches_nobody(tmp_path, monkeypatch):
    """Of damaged RGL files it did; what comes of it is refused where it is no number."""
    (tmp_path / "a.astm").write_bytes(astm())
    known = next(each for each in FORMATS if ".astm" in each.extensions)

    def read(*given, **options):
        np.array([np.nan, 1e300]).astype(int)
        return known.read(*given, **options)

    monkeypatch.setattr(formats, "FORMATS", (replace(known, read=read),))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(fitter.load(tmp_path / "a.astm")) == 3
