"""A minimal perfect hash: n keys to the n slots 0 to n - 1, none empty, found with one displacement and one comparison.

Hash and displace: a key falls into a bucket, and all keys of a bucket are displaced by the same number so that they
land in free slots. ::

    mixed  = low * multiplier + high * HASH_HIGH_MULTIPLIER,  mixed ^= mixed >> HASH_FOLD
    home   = (key + (mixed >> HASH_SKIP)) % n
    slot   = (home + displacement[mixed % buckets]) % n

with the key split into its HASH_LOW_BITS low bits and the high ones.

The slot of a key that was never stored is some slot too, so the key that owns the slot is kept beside it and compared:
there is no false hit. All intermediate values stay below 2^31, so that `osl/perfect_hash.h` finds the same slots in
OSL's signed 32-bit integers. Buckets are placed by size, the largest first, as in F. C. Botelho, D. Belazzougui,
M. Dietzfelbinger: Compress, Hash, and Displace, ESA 2009; single keys fill what is left, so a minimal table needs no
luck at the end.
"""

from dataclasses import dataclass

import numpy as np

from ..shader_constants import HASH_FOLD, HASH_HIGH_MULTIPLIER, HASH_LOW_BITS, HASH_SKIP

MAX_KEY = (1 << 23) - 1     # low * multiplier + high * HASH_HIGH_MULTIPLIER < 2^31
MULTIPLIERS = 1 << 18
_KEYS_PER_BUCKET = 3.0
_TRIALS_AT_ONCE = 1 << 19   # bounds the memory of one round


@dataclass(frozen=True)
class PerfectHash:
    """A minimal perfect hash of integer keys.

    Attributes
    ----------
    keys : (n,) uint32
        The key that each slot holds.
    displacement : (buckets,) uint16, or uint32 for more than 65,536 keys
    multiplier : int
        The member of the family of hash functions that worked for these keys.
    """

    keys: np.ndarray
    displacement: np.ndarray
    multiplier: int

    def __len__(self):
        return len(self.keys)

    @property
    def nbytes(self):
        """Bytes of the keys and the displacements."""
        return self.keys.nbytes + self.displacement.nbytes

    def slots(self, keys):
        """Slot of each key, -1 for a key that is not stored: (...) int to (...) int64."""
        keys = np.asarray(keys, dtype=np.int64)
        n = len(self.keys)
        if n == 0:
            return np.full(keys.shape, -1)
        bucket, home = _hash(keys, self.multiplier, len(self.displacement), n)
        slot = (home + self.displacement[bucket].astype(np.int64)) % n
        return np.where(self.keys[slot] == keys, slot, -1)


def build(keys):
    """A minimal perfect hash of distinct keys.

    Parameters
    ----------
    keys : (n,) int
        Distinct, 0 to `MAX_KEY`, in any order.

    Returns
    -------
    PerfectHash

    Raises
    ------
    ValueError
        If keys repeat or are out of range.
    """
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
        buckets += 1 + buckets // 64        # loosen, a little: the next multiplier may well do
    found = PerfectHash(np.zeros(n, np.uint32), displacement.astype(width), multiplier)
    found.keys[(home + displacement[bucket]) % n] = keys
    return found


def _hash(keys, multiplier, buckets, n):
    """Bucket and undisplaced slot of each key."""
    low, high = keys & ((1 << HASH_LOW_BITS) - 1), keys >> HASH_LOW_BITS
    mixed = low * multiplier + high * HASH_HIGH_MULTIPLIER
    mixed ^= mixed >> HASH_FOLD
    return mixed % buckets, (keys + (mixed >> HASH_SKIP)) % n


def _place(bucket, home, buckets, random):
    """Displacements that give every key a slot of its own, or None where these buckets allow none."""
    n = len(home)
    order = np.lexsort((home, bucket))
    bucket, home = bucket[order], home[order]
    if ((bucket[1:] == bucket[:-1]) & (home[1:] == home[:-1])).any():
        return None                         # two keys that every displacement moves to the same slot
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
            enough = 2 / (np.count_nonzero(free) / n) ** members        # twice the trials that one success takes
            trials = int(min(enough, _TRIALS_AT_ONCE / (len(pending) * members), n)) + 1
            trial, placed = _try(homes, random.integers(0, n, (len(pending), trials)), free)
            displacement[pending[placed]] = trial[placed]
            pending, homes = pending[~placed], homes[~placed]
            tried += trials
    single = np.flatnonzero(size == 1)
    displacement[single] = (np.flatnonzero(free) - home[start[single]]) % n
    return displacement


def _try(homes, trials, free):
    """Displace each bucket by the first of its trials that finds its slots free; of two that want a slot, one waits.

    Parameters
    ----------
    homes : (buckets, members) int
    trials : (buckets, trials) int
    free : (n,) bool
        Changed: the slots taken are no longer free.

    Returns
    -------
    displacement : (buckets,) int
    placed : (buckets,) bool
    """
    n = len(free)
    fits = free[(homes[:, :1] + trials) % n]
    for member in range(1, homes.shape[1]):
        fits &= free[(homes[:, member, None] + trials) % n]
    displacement = trials[np.arange(len(trials)), fits.argmax(axis=1)]
    slots = (homes + displacement[:, None]) % n
    hopeful = np.flatnonzero(fits.any(axis=1))
    claim = np.full(n, -1)
    claim[slots[hopeful[::-1]]] = hopeful[::-1, None]
    placed = np.zeros(len(homes), dtype=bool)
    placed[hopeful] = (claim[slots[hopeful]] == hopeful[:, None]).all(axis=1)
    free[slots[placed]] = False
    return displacement, placed
