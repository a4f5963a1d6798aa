"""The numbers that the shader and Python share, and those that tune the shader: Python imports them, and `cycles.bake`
writes all of them into a shader's `baked_constants.h` as `#define NAME value`. What depends on a fit is not here.

Angles are in radians; a cosine, weight, share or probability has no unit. A threshold is *numerical* where any small
number would do: it only keeps single precision away from a division by nothing.
"""

from math import radians

# The mixture (cycles/node_mixture.py, osl/mixture.h).

# Kinds of its lobes, as `node_lobes` names them.
DIFFUSE_LOBE = 0
SHEEN_LOBE = 1
GGX_LOBE = 2
BECKMANN_LOBE = 3
KNOTS = 8                           # values of a colour ramp; Cycles fixes it for phong_ramp
# The last tabulated viewing angle: beyond 88 degrees a surface fills next to nothing of a picture.
GRAZING = radians(88)
# Index of refraction of the microfacet closure; Cycles takes no notice of it for reflection without a Fresnel factor.
MICROFACET_IOR = 1.5
LEAST_COSINE = 1e-3                 # smaller cosines from the normal of a lobe count as this (numerical)
LEAST_SINE_2 = 1e-9                 # smaller squared sines of the half angle of sheen count as this (numerical)
STEEPEST_FACET = 80.0               # a facet is as rare as exp(-80) at most

# The field of a fit (model/transform.py, model/microfacet.py, coordinates/; osl/fit.h, osl/prior.h,
# osl/coordinates.h).

# The largest value of the field: exp(40), the factor on the prior, is still a number in single precision.
LARGEST_EXPONENT = 40.0
# The ratio of two numbers below which the 16-norm of both is the larger one in single precision (numerical).
NEGLIGIBLE_RATIO = 0.3
DAMPING_KNOTS = 33                  # control points of the factor of a polar angle by which a fit conserves energy
# Added to the denominator of the microfacet visibility, so that it stays finite where both directions graze.
DENSEST = 1e-3
LEAST_LENGTH = 1e-7                 # shorter projected vectors have no azimuth (numerical)
# The least squared height of the sum of both directions, where both graze (numerical).
LEAST_HEIGHT_2 = 1e-12
# Share of the difference vector from which on its part across the half vector is found from the directions (numerical).
MOSTLY = 0.99
# The least squared tangent of the half angle in a sheen lobe, which is 0 far above it (numerical).
LEAST_SLOPE_2 = 1e-9

# An edit of a fit (model/edit.py, osl/edit.h).

COAT_F0 = 0.04                      # reflectance of a clear coat at normal incidence: an index of refraction of 1.5

# The perfect hash of the sparse lattice (lattice/perfect_hash.py, osl/perfect_hash.h). All intermediate values of a key
# of 26 bits stay below 2^31.

# The bits of a key that the multiplier of the fit mixes; the others are mixed by the next number.
HASH_LOW_BITS = 12
# A prime of 16 bits, near 2^16 over the golden ratio, which spreads consecutive numbers evenly.
HASH_HIGH_MULTIPLIER = 40503
# Bits by which the product is shifted before it is folded onto itself: its upper half reaches the lower one.
HASH_FOLD = 13
# Low bits of the result that choose the bucket only, and not the slot: the two are less alike then.
HASH_SKIP = 4
# A word of the table that tells which keys are stored is about 2 to this power of them, and of the ROW_TAPS - 1 next:
# one look tells of a row of ROW_TAPS keys wherever it begins.
OCCUPANCY_SHIFT = 4
ROW_TAPS = 4                        # control points of a cubic B-spline along one axis

# Lamps (osl/lamps.h, addon/core/lamps).

# Lamps that a shader has parameters for. Each costs time where it exists, and the 32 brightest cover most scenes.
MAX_LAMPS = 32
DIRECTIONS = MAX_LAMPS + 1          # directions in which the fit is evaluated: one beside the lamps
# The least cosine of incidence by which a lamp's light is scaled when lamps are chosen by it: a large lamp whose centre
# is on the horizon still lights a surface.
LEAST_LAMP_COSINE = 0.1

# Mixes (osl/mix.osl).

# Measured materials that Cycles has room for at one point: it has 64 closures, and a material fills up to 28, its
# mixture 13, each of four lamps 3, a sampled direction 3.
MOST_MIXED = 2

# Lobes at lamps (osl/light_lobes.h).

# Lobes of one shading point: where more lamps are above the horizon, some are taken at random.
MAX_LOBES = 4
# How many are taken in the mean: each costs evaluations of the fit, and one more closure for Cycles.
SAMPLED_LOBES = 2
CLOSURE_LIMITED_LOBES = 1           # both where few closures fit: on GPUs, all closures of a point share 1024 bytes
# By how much a lobe is wider than its lamp, beside which it falls off: two standard deviations of the directions about
# a sampled one (RESIDUAL_EXPONENT). Else what is sampled just outside, where the lobe is low, spreads over the lamp.
LOBE_MARGIN = 0.002
# The angle to which a lobe reaches, in that up to which it is flat: it is 0 from the knot below the edge's on.
LOBE_REACH = 1.24
# Below this angular radius, that of the sun, the fit counts as constant over a lamp, and its lobe alone renders it,
# since sampled directions would seldom hit it; at a larger one directions are sampled.
SMALL_LAMP_RADIUS = 0.005
# A lamp above this angular radius has no lobe: the mixture is right in the mean over so much of the hemisphere.
MAX_LOBE_RADIUS = 0.6
# The least angular radius of a lobe, 1.1 degrees: the exponent of a narrower one is too large for single precision.
MIN_LOBE_RADIUS = 0.0185
# The angle of the axis of a small lamp's lobe from the lamp. On the axis Cycles' cosine may round to more than 1, which
# its power makes 0.3 % and no ramp makes up for; where the cosine's power is 0.903, the lobe is as high, and flattest.
LOBE_TILT = 0.0079
# The knot of the ramp, of 0 to 7, that lies at the lamp's edge: the lobe is flat up to there, to .6 %, and ends at the
# next one.
LOBE_EDGE_KNOT = 4
# In the sine of its radius, the cosine of incidence below which the lobe of a lamp gets lower: the fit falls to 0 at
# the horizon.
LOBE_RAISED = 1.5
# Share of all that a mixture below the fit leaves of it that the lobe of a lamp carries at most which is not small.
MOST_GIVEN = 1.0
# Share of the mixture that the lobe of a lamp which is not small takes away at most, where it is above the fit.
MOST_TAKEN = 0.8
LEAST_FALLOFF = 1e-6                # where a lobe has fallen to less it counts as 0
# What a lobe reflects where its height is 1, times its exponent: 2 pi ln 7/4 for the flat part, and the rest beyond it.
LOBE_SOLID_ANGLE = 4.3
# Closure weight of a lobe. Cycles finds lamps by sampling them, and should hardly ever follow a lobe instead; a closure
# below 1e-5 would be dropped.
LIGHT_LOBE_WEIGHT = 2e-4

# Residual sampling (osl/residual.h).

# Exponent of the phong_ramp that sends a path in the sampled direction: about 0.08 degrees wide, as narrow as single
# precision evaluates well.
RESIDUAL_EXPONENT = 1e6
# The least colour of its closure weight in a channel, in that of the largest: the fit may have none of a colour.
LEAST_COLOUR = 0.01
LEAST_WEIGHT = 2e-4                 # its least closure weight: Cycles drops closures below 1e-5
LEAST_LAMP_SHARE = 0.3              # share of the sampled directions that are taken about a lamp of no size
# The share about a lamp of this angular radius, 3.4 degrees, and above: most of the light is there. Every sample has a
# direction then, as what one takes away is bounded by its density.
LARGE_LAMP_RADIUS = 0.06
LARGE_LAMP_SHARE = 0.7
# Share of the albedo that the weights of sampled directions are at least in the mean.
LEAST_FOLLOWED = 0.03
# From this far below an albedo of 1 on, directions that correct what is shown toward a lamp are followed less often and
# carry more: of metals, their weights would add up to .2 to the denoiser's albedo.
BRIGHT = 0.5
# About what the weights of these add to the denoiser's albedo, in it, where all directions are taken about a lamp.
CORRECTION_WEIGHT = 0.06
# How often at least, where 1 takes away no more in a sample than others show of the whole lamp.
LEAST_CORRECTION = 0.15
# Cycles has no closures up to this width in the denoiser's albedo, as long as others have a quarter of all weights.
NARROW_WIDTH = 0.075
MOST_NARROW = 0.25                  # share of the weights of the mixture that these have at most to be made up for
MOST_CORRECTED = 0.65               # share of what is shown toward a lamp that a sampled direction takes away at most
# Share of what is shown toward a lamp below which the lamp's lobe takes a correction, evenly. A smaller one leaves more
# to directions, which are seldom followed; a larger one misplaces more where a lamp is half hidden.
SMALL_CORRECTION = 0.1
# Times as much as is shown that a lobe takes away in a sample for what a direction may not: without a bound that leaves
# pixels below 0, as `python -m benchmarks.black_pixels` counts them.
MOST_SPREAD = 2.0

# The shading frame, and the horizon (osl/shading_frame.h).

# The least cosine of the angle to the viewer: normals that interpolation or a bump map has turned away are turned back.
LEAST_FACING = 1e-3
LEAST_NORMAL = 1e-3                 # a shading normal that is shorter is an unconnected input
LEAST_TANGENT = 1e-6                # a tangent that is shorter has no direction, and any other will do (numerical)
LEAST_HORIZON_COSINE = 1e-4         # directions whose cosine is lower count as below the horizon: 0.006 degrees
NEARLY_PARALLEL = 0.9               # from this cosine on an axis counts as nearly parallel to the normal (numerical)

# Streams of random numbers (osl/random.h): each number of a shading point has its own. The last three have one for each
# lamp, or each mix, and so lie MAX_LAMPS or more apart.
# The first two make the seed of a shading point; it is scaled so that its hash changes with all of its digits.
RANDOM_SEED_X = 0.0
RANDOM_SEED_Y = 0.5
SEED_SCALE = 1000.0
RANDOM_LOBE = 2.0
RANDOM_RING = 3.0
RANDOM_AZIMUTH = 4.0
RANDOM_LOBES = 6.0
RANDOM_RESIDUAL = 7.0
RANDOM_TOWARD_LAMP = 7.5
RANDOM_EXACT = 7.75
RANDOM_CONE_HEIGHT = 8.0
RANDOM_CONE_AZIMUTH = 9.0
RANDOM_LAMP = 50.0
RANDOM_MIX = 200.0


def shader_constants() -> dict[str, str]:
    """The numbers of this module as OSL literals, by name; nine digits give each in single precision."""
    return {name: _literal(value) for name, value in globals().items() if name.isupper()}


def _literal(value: int | float) -> str:
    text = f"{value:.9g}"
    return text if isinstance(value, int) or "." in text or "e" in text else f"{text}.0"
