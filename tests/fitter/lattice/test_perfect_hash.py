import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fitter.lattice import dense, perfect_hash


def check(keys):
    """The hash is minimal and perfect, and rejects other keys: all up to 400,000, and those about the largest."""
    index = perfect_hash.build(keys)
    expected = sorted(set(np.asarray(keys).tolist()))
    end = max([*expected, 0]) + 5000
    everything = np.unique(np.concatenate([np.arange(min(end, 400_000)), np.arange(max(end - 10_000, 0), end),
                                           np.array(expected, dtype=int)]))
    slots = index.slots(everything)
    assert everything[slots >= 0].tolist() == expected
    assert np.sort(slots[slots >= 0]).tolist() == list(range(len(expected)))
    return index


@given(st.sets(st.integers(0, 90_000), max_size=400))
@settings(max_examples=60, deadline=None)
def test_any_set_of_keys_gets_a_minimal_perfect_hash(keys):
    check(np.array(sorted(keys), dtype=int))


@pytest.mark.parametrize("keys", [
    np.arange(5_000), np.arange(0, 300_000, 70), np.array([0]), np.array([perfect_hash.MAX_KEY]), np.array([], int),
    (np.arange(300)[:, None] * 1024 + np.arange(4)).ravel(), np.arange(12) * 4096, np.arange(2345) * 2345,
    np.arange(2048) * 4096, np.arange(2345) + 2345 * 7 * (np.arange(2345) % 30)])
def test_regular_sets_of_keys_do_not_swell_the_table(keys):
    index = check(np.unique(keys))
    assert index.displacement.nbytes * 8 <= max(12 * len(index), 16)


def test_the_largest_keys_do_not_overflow_signed_32_bits():
    key = perfect_hash.MAX_KEY
    assert (key & 4095) * perfect_hash.MULTIPLIERS + (key >> 12) * 40503 < 2**31
    assert np.prod(dense.shape(dense.MAX_LEVEL)) - 1 <= perfect_hash.MAX_KEY


def test_a_lattice_of_level_6_at_95_percent_takes_about_6_bits_a_key_beside_the_keys(random):
    keys = random.choice(np.prod(dense.shape(6)), 15_038, replace=False)
    index = check(keys)
    assert index.displacement.dtype == np.uint16
    assert index.displacement.nbytes * 8 / len(keys) < 7


@pytest.mark.parametrize("keys", [[-1, 3], [0, perfect_hash.MAX_KEY + 1]])
def test_keys_out_of_range_are_refused(keys):
    with pytest.raises(ValueError, match="expected 0 to"):
        perfect_hash.build(keys)


@given(st.sets(st.integers(0, 999), max_size=60), st.integers(0, 996))
@settings(max_examples=60, deadline=None)
def test_a_word_of_the_occupancy_tells_which_of_a_row_of_keys_are_stored(keys, first):
    """As `stored_keys` of osl/perfect_hash.h reads it."""
    table = perfect_hash.occupancy(sorted(keys), 1000)
    bits = int(table[first >> 4]) >> (first & 15) & 15
    assert bits == sum(1 << k for k in range(4) if first + k in keys)
