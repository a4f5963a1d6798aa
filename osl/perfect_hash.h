#if SPARSE
/* The slot of a key in a minimal perfect hash, or -1 for a key that is not stored. It must agree with
 * PerfectHash.slots of fitter/lattice/perfect_hash.py. No intermediate value reaches 2^31. */
int find_slot(int keys[], int displacement[], int key)
{
  int mixed = (key & ((1 << HASH_LOW_BITS) - 1)) * MULTIPLIER + (key >> HASH_LOW_BITS) * HASH_HIGH_MULTIPLIER;
  mixed = mixed ^ (mixed >> HASH_FOLD);
  int slot = (key + (mixed >> HASH_SKIP)) % KEY_COUNT + displacement[mixed % BUCKET_COUNT];
  if (slot >= KEY_COUNT) {
    slot -= KEY_COUNT;
  }
  return keys[slot] == key ? slot : -1;
}
#endif
