"""Minimal perfect hashing: n keys in n slots, found with one displacement and one comparison, by hash and displace (D.
Belazzougui, F. C. Botelho, M. Dietzfelbinger: Hash, Displace, and Compress, ESA 2009) ::

    mixed  = low * multiplier + high * HASH_HIGH_MULTIPLIER,  mixed ^= mixed >> HASH_FOLD
    home   = (key + (mixed >> HASH_SKIP)) % n
    slot   = (home + displacement[mixed % buckets]) % n

with the key split into its HASH_LOW_BITS low bits and the high ones. Other keys hash to some slot too, so each slot
keeps its key for comparison; the shader has a table of bits instead, which tells of several keys at once (`occupancy`).
All intermediate values are below 2^31: `osl/perfect_hash.h` finds the same slots with OSL's signed 32-bit integers.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arrays import BoolArray, IntArray
from ..shader_constants import HASH_FOLD, HASH_HIGH_MULTIPLIER, HASH_LOW_BITS, HASH_SKIP, OCCUPANCY_SHIFT, ROW_TAPS

MAX_KEY = (1 << 26) - 1     # low * multiplier + high * HASH_HIGH_MULTIPLIER < 2^31
MULTIPLIERS = 1 << 18
_KEYS_PER_BUCKET = 3.0
_OCCUPANCY_WORD = 1 << OCCUPANCY_SHIFT
_TRIALS_AT_ONCE = 1 << 19   # bounds the memory of `_try_displacements`


@dataclass(frozen=True)
class PerfectHash:
    """A minimal perfect hash of integer keys."""

    keys: NDArray[np.uint32]                            # the key in each slot, (n,)
    displacement: NDArray[np.unsignedinteger[Any]]      # (buckets,) uint16, or uint32 for more than 65,536 keys
    multiplier: int                                     # selects the hash function of the family

    def __len__(self) -> int:
        return len(self.keys)

    @property
    def nbytes(self) -> int:
        """Bytes of the keys and the displacements."""
        return self.keys.nbytes + self.displacement.nbytes

    def slots(self, keys: ArrayLike) -> NDArray[np.int64]:
        """The slots of keys, -1 for a key that is not stored: (...) int to (...) int64."""
        keys = np.asarray(keys, dtype=np.int64)
        n = len(self.keys)
        if n == 0:
            return np.full(keys.shape, -1, dtype=np.int64)
        bucket, home = _hash(keys, self.multiplier, len(self.displacement), n)
        slot = (home + self.displacement[bucket].astype(np.int64)) % n
        return np.where(self.keys[slot] == keys, slot, -1)


def build(keys: ArrayLike) -> PerfectHash:
    """Make a minimal perfect hash of keys, (n,). Raises ValueError where one is not from 0 to `MAX_KEY`."""
    keys = np.unique(np.asarray(keys, dtype=np.int64))
    n = len(keys)
    width = np.uint16 if n <= 1 << 16 else np.uint32
    if n == 0:
        return PerfectHash(np.zeros(0, np.uint32), np.zeros(1, width), 1)
    if keys[0] < 0 or keys[-1] > MAX_KEY:
        raise ValueError(f"keys from {keys[0]} to {keys[-1]}, expected 0 to {MAX_KEY}")
    random = np.random.default_rng(n)
    buckets = max(1, int(n / _KEYS_PER_BUCKET))
    while True:
        multiplier = int(random.integers(MULTIPLIERS // 4, MULTIPLIERS)) | 1
        bucket, home = _hash(keys, multiplier, buckets, n)
        displacement = _place(bucket, home, buckets, random)
        if displacement is not None:
            break
        buckets += 1 + buckets // 64        # try another multiplier, with slightly more buckets
    index = PerfectHash(np.zeros(n, np.uint32), displacement.astype(width), multiplier)
    index.keys[(home + displacement[bucket]) % n] = keys
    return index


def occupancy(keys: ArrayLike, count: int) -> NDArray[np.int32]:
    """Which of the keys 0 to count - 1 are stored, (words,) int32: bit b of word w is 1 for a stored key ``b + (w <<
    OCCUPANCY_SHIFT)``, with b up to that of the last of `ROW_TAPS` keys in a row that begins in the word."""
    stored = np.zeros((-(-count // _OCCUPANCY_WORD) + 1) * _OCCUPANCY_WORD, dtype=bool)
    stored[np.asarray(keys, dtype=np.int64)] = True
    starts = np.arange(0, count, _OCCUPANCY_WORD)
    bits = np.arange(_OCCUPANCY_WORD + ROW_TAPS - 1)
    return np.asarray(stored[starts[:, None] + bits] @ (1 << bits), dtype=np.int32)


def _hash(keys: IntArray, multiplier: int, buckets: int, n: int) -> tuple[IntArray, IntArray]:
    """The bucket of each key, and its slot before displacement."""
    low, high = keys & ((1 << HASH_LOW_BITS) - 1), keys >> HASH_LOW_BITS
    mixed = low * multiplier + high * HASH_HIGH_MULTIPLIER
    mixed ^= mixed >> HASH_FOLD
    return mixed % buckets, (keys + (mixed >> HASH_SKIP)) % n


def _place(bucket: IntArray, home: IntArray, buckets: int, random: np.random.Generator) -> IntArray | None:
    """Displacements, (buckets,) int, with which no two of the n slots are the same, or None: the fullest buckets
    first."""
    n = len(home)
    order = np.lexsort((home, bucket))
    bucket, home = bucket[order], home[order]
    if ((bucket[1:] == bucket[:-1]) & (home[1:] == home[:-1])).any():
        return None                         # every displacement moves two keys of a bucket to the same slot
    size = np.bincount(bucket, minlength=buckets)
    start = np.cumsum(size) - size
    free = np.ones(n, dtype=bool)
    displacement = np.zeros(buckets, dtype=np.int64)
    for members in range(size.max(), 1, -1):
        pending = np.flatnonzero(size == members)
        homes = home[start[pending, None] + np.arange(members)]
        tried = 0
        while len(pending):
            if tried > 4 * n + 64:
                return None
            enough = 2 / (np.count_nonzero(free) / n) ** members        # twice the expected trials until a success
            trials = int(min(enough, _TRIALS_AT_ONCE / (len(pending) * members), n)) + 1
            trial, placed = _try_displacements(homes, random.integers(0, n, (len(pending), trials)), free)
            displacement[pending[placed]] = trial[placed]
            pending, homes = pending[~placed], homes[~placed]
            tried += trials
    single = np.flatnonzero(size == 1)
    displacement[single] = (np.flatnonzero(free) - home[start[single]]) % n
    return displacement


def _try_displacements(homes: IntArray, trials: IntArray, free: BoolArray) -> tuple[IntArray, BoolArray]:
    """Displace each bucket by the first of its trials, (buckets, trials), with which all slots of its homes, (buckets,
    members), are free; where two buckets claim a slot, the later one is not placed. The displacement of each bucket and
    whether it is placed; in `free`, (n,), slots that are taken become False."""
    n = len(free)
    fits = free[(homes[:, :1] + trials) % n]
    for member in range(1, homes.shape[1]):
        fits &= free[(homes[:, member, None] + trials) % n]
    displacement = trials[np.arange(len(trials)), fits.argmax(axis=1)]
    slots = (homes + displacement[:, None]) % n
    candidates = np.flatnonzero(fits.any(axis=1))
    claim = np.full(n, -1)
    claim[slots[candidates[::-1]]] = candidates[::-1, None]
    placed = np.zeros(len(homes), dtype=bool)
    placed[candidates] = (claim[slots[candidates]] == candidates[:, None]).all(axis=1)
    free[slots[placed]] = False
    return displacement, placed
