#if SPARSE
/* The slot of a key in a minimal perfect hash, or -1 if it is not stored; see fitter/lattice/perfect_hash.py, whose
 * PerfectHash.slots must give the same. No intermediate value reaches 2^31. */
int find_slot(int keys[], int displacement[], int key)
{
  int mixed = (key & 4095) * MULTIPLIER + (key >> 12) * 40503;
  mixed = mixed ^ (mixed >> 13);
  int slot = (key + (mixed >> 4)) % KEY_COUNT + displacement[mixed % BUCKET_COUNT];
  if (slot >= KEY_COUNT) {
    slot -= KEY_COUNT;
  }
  return keys[slot] == key ? slot : -1;
}
#endif
