#if SPARSE
/* Which of the ROW_TAPS keys from `key` on are stored: a bit each. Most rows have none; this tells so with one look,
 * where the hash would have to be asked for each key. */
int stored_keys(int occupancy[], int key)
{
  int word = key >> OCCUPANCY_SHIFT;
  return (occupancy[word] >> (key - (word << OCCUPANCY_SHIFT))) & ((1 << ROW_TAPS) - 1);
}

/* The slot of a key that is stored in a minimal perfect hash. It must agree with PerfectHash.slots of
 * fitter/lattice/perfect_hash.py. No intermediate value reaches 2^31. */
int find_slot(int displacement[], int key)
{
  int mixed = (key & ((1 << HASH_LOW_BITS) - 1)) * MULTIPLIER + (key >> HASH_LOW_BITS) * HASH_HIGH_MULTIPLIER;
  mixed = mixed ^ (mixed >> HASH_FOLD);
  int slot = (key + (mixed >> HASH_SKIP)) % KEY_COUNT + displacement[mixed % BUCKET_COUNT];
  return slot >= KEY_COUNT ? slot - KEY_COUNT : slot;
}
#endif
