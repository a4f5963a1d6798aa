"""What every file format must do. A format that is entered in FORMATS is tested here, once it has an example below."""

import re
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import fitter
from fitter import DatasetError, formats
from fitter.formats import FORMATS
from fitter.formats.text import plain_text
from support import speos_files
from tools import fuzz

MADE = fuzz.seeds()
# by `Format.files`; a format without an example fails the first test
EXAMPLES = {"Cornell or Light Tec ASTM (.astm)": MADE["astm, made"], "pbrt-v2 .brdf": MADE["pbrt, made"],
            "CURET abrdf.dat": MADE["curet, made"], "Cornell paint.reformat.mat": MADE["matlab, deflated"],
            "RGL .bsdf": MADE["rgl, made"], "MERL .binary": MADE["merl, made"],
            "table with column names (.csv, .tsv, .txt)": MADE["table, made"], "NVIDIA .mbsdf": MADE["mbsdf, made"],
            "Zemax .bsdf": MADE["zemax, made"], "Speos .anisotropicbsdf": speos_files.made().encode(),
            "FRED's text (.txt)": b"type bsdf_data\nformat angles=deg bsdf=value\n11 0\n17 178 .2\n52 0\n23 90 .3\n",
            "UTIA .bin": MADE["utia, made"], "translucent materials .csv": MADE["translucent, made"],
            "samples saved by Measured BRDF (.npz)": MADE["samples, saved"]}
every_format = pytest.mark.parametrize("known", FORMATS, ids=lambda known: known.files)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "measured.xyz"


def recognised_by(content):
    """All formats that recognise a file, each asked with the content in the form that it takes."""
    try:
        text = plain_text(content)
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
        assert re.fullmatch(r"\.[a-z0-9]+", extension)
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
    (tmp_path / "a.astm").write_bytes(MADE["astm, made"])
    known = next(each for each in FORMATS if ".astm" in each.extensions)

    def read(*given, **options):
        np.array([np.nan, 1e300]).astype(int)
        return known.read(*given, **options)

    monkeypatch.setattr(formats, "FORMATS", (replace(known, read=read),))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(fitter.load(tmp_path / "a.astm")) == 40
