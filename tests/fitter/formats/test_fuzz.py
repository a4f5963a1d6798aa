"""The first few hundred of the damaged and hostile files of ``python -m tools.fuzz``."""

import os

import pytest

import fitter
from fitter.storage import files
from tools import fuzz

FILES = fuzz.seeds()


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("fuzz") / "case.dat"


@pytest.fixture(autouse=True)
def few_fitted(monkeypatch):
    """The command fits all samples of nearly all files."""
    monkeypatch.setattr(fuzz, "_MOST_FITTED", 100)


@pytest.mark.parametrize("name", FILES)
def test_the_files_to_be_damaged_are_read_as_they_stand(path, name):
    assert fuzz.check(FILES[name], path)[0] == "read"


@pytest.mark.parametrize("number", range(300))
def test_a_damaged_file_is_refused_or_read_within_limits_and_as_a_naive_reader_does(path, number):
    fuzz.check(fuzz.case(FILES, number)[-1], path)


def test_a_pipe_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe.astm")
    with pytest.raises(fitter.DatasetError, match="not a file"):
        fitter.load(tmp_path / "pipe.astm")


@pytest.mark.parametrize("change", [lambda stream: stream.write(b"1,0,1,0,1,1,1\n"), lambda stream: stream.truncate(9)])
def test_a_file_that_changes_while_it_is_read_is_refused(path, monkeypatch, change):
    path.write_bytes(FILES["astm, made"])
    real, calls = os.fstat, []

    def fstat(descriptor):
        if calls:
            with open(path, "ab") as stream:
                change(stream)
        calls.append(descriptor)
        return real(descriptor)

    monkeypatch.setattr(files.os, "fstat", fstat)
    with pytest.raises(fitter.DatasetError, match="changed while it was read"):
        fitter.load(path)


def test_more_than_measurements_can_be_is_not_even_read(tmp_path):
    with open(tmp_path / "digits.dat", "wb") as stream:
        stream.truncate(200 << 20)
    with pytest.raises(fitter.DatasetError, match=r"209,715,200 bytes, expected at most"):
        fitter.load(tmp_path / "digits.dat")
