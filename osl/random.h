/* Random numbers in [0, 1): one for each stream of a shading point. The pixel filter jitters the point P, so that the
 * numbers of all samples differ. */
float random(point seed, float stream)
{
  float u = (float)hashnoise(seed, stream);
  return u;
}

/* The seed of a shading point. Far from the origin P is too coarse to differ from sample to sample, but the viewing
 * direction I is not. */
point random_seed(point at, vector toward)
{
  return SEED_SCALE * point(random(at, RANDOM_SEED_X), random(at, RANDOM_SEED_Y), random(point(toward), RANDOM_SEED_X));
}
