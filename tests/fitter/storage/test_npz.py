"""Arrays in files: what `numpy.savez` writes is read, and whatever was done to a header is an error of the file."""

import io
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given, seed, settings
from hypothesis import strategies as st

import fitter
from fitter.storage import npz
from support.damaged_npz import with_header

ARRAYS = {"grid": np.arange(24.0).reshape(2, 3, 4), "column": np.asfortranarray(np.arange(6, dtype="i4").reshape(2, 3)),
          "number": np.array(7, "<u2"), "names": np.array(["R", "Grün"]), "none": np.zeros((0, 3), "f2")}


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_what_numpy_writes_is_read(save):
    content = io.BytesIO()
    save(content, **ARRAYS)
    for name, array in npz.read(content.getvalue()).items():
        np.testing.assert_array_equal(array, ARRAYS[name])
        assert array.dtype == ARRAYS[name].dtype


@pytest.mark.parametrize("kind", [bool, complex, object, [("a", float)]])
def test_other_arrays_are_refused(kind):
    content = io.BytesIO()
    np.savez(content, grid=np.zeros(3, kind))
    with pytest.raises(ValueError, match="expected plain numbers"):
        npz.read(content.getvalue())


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    path = tmp_path_factory.mktemp("npz") / "saved.npz"
    path.write_bytes(npz.to_bytes(ARRAYS))
    return path


@settings(max_examples=400, deadline=None, database=None)
@seed(7)
@given(st.lists(st.tuples(st.integers(0, 117), st.sampled_from(list(b"(){}[]'\"\\,:0123456789 \n\t#<fOVb\0\xff"))),
                min_size=1, max_size=4))
def test_any_damaged_header_is_a_value_error_and_of_a_file_a_dataset_error(saved, changes):
    def change(header):
        damaged = bytearray(header)
        for place, byte in changes:
            damaged[place % len(header)] = byte
        return bytes(damaged)

    content = with_header(npz.to_bytes(ARRAYS), change)
    with suppress(ValueError):
        npz.read(content)
    saved.write_bytes(content)
    with pytest.raises(fitter.DatasetError, match=r"saved\.npz"):
        fitter.load(saved)
