/* Random numbers in [0, 1): one for each stream of a shading point. The pixel filter jitters the point P, so that the
 * numbers of all samples differ. */
float random(point seed, float stream)
{
  float u = (float)hashnoise(seed, stream);
  return u;
}
