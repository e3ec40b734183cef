# The errors of inverse depths in the rasterizer are below the bounds in src/fast/raster/edge_functions.rs.
#@ src/fast/raster/edge_functions.rs INV_DEPTH_ROUNDINGS = 47.5
#@ src/fast/raster/edge_functions.rs VOLUME_ROUNDINGS = 8.5
#@ src/fast/raster/edge_functions.rs VOLUME_CLEARANCE = 1024.0
#@ src/fast/raster/edge_functions.rs PLANE_ROUNDINGS = 19.0
# The inverse depth is n = N.D / V with the sum N of the normals n_k of raster_edges.g. Let R = 1 be the length of the
# longest of the corners a, b and c, u the unit roundoff, and let D be l + X + Y, the direction and the multiples of the
# eye's steps to the right and up. They are at right angles, and their lengths add up to L = 1 at most. What is of second
# order is counted in `exceed`. The errors of N.D, in units of u:
#
# - A corner's own rounding, say e of a, changes N.D by (e x (b - c)).D, so those of all three make at most the sides of
#   the triangle, which are 3 sqrt(3) together for a triangle in the unit ball.
# - The products in b x c and their differences: TERMS (see raster_edges.g) and |b x c|, which is at most 1, for each of the
#   three normals.
# - The products of a normal with D and the two sums: 3 for each of the three normals. (Each is a part of the sum of the
#   terms' magnitudes, which is at most 1.)
# - The first sum of two normals' coefficients: n_0 + n_1 = c x (a - b), at most 2.
# - The second sum, the two factors of the product with 1 / V, the product with the pixel's x or y, and the two
#   sums over 1, x and y are 6 roundings, each of at most f = |N.l| + |N.X| + |N.Y|.
# - The roundings of D: one of the eye's steps, and in the ray one of the division by the picture's side, one of the product,
#   two of the sums and one of the product that makes it a unit vector. As vectors they are at most 3 |X| + 3 |Y| + |X + Y| +
#   2 |D|. As |X| + |Y| <= sqrt(2) |X + Y|, this is at most RAY |D| with RAY = 3 sqrt(2) + 3. What lies along D only changes
#   the length, which does not matter. So they count by the part of N across D.
#
# N is twice the area of a triangle in the unit ball, at most 3 sqrt(3) / 2. Let N be of length 1 for the moment, and let
# N.D = p - m, where p is the sum of the positive ones among N.l, N.X and N.Y, and m that of the negative ones, so that
# f = p + m. The part of N across D times |D| is the root of |D|^2 - (p - m)^2 = |D|^2 + 4 p m - f^2. As two components of
# a unit vector have a product of at most 1/2, 4 p m is at most the sum of 2 |l| |X| and the like, and |D|^2 + 4 p m <= L^2 = 1.
# Hence the last two add up to at most 6 f + RAY sqrt(1 - f^2) <= sqrt(36 + RAY^2).
#
# Let the computed V be 1. It is at least VOLUME_CLEARANCE times its error bound, so the true V is at least
# 1 - 1 / VOLUME_CLEARANCE, whose inverse is `ratio`. The part of the bound that is proportional to n covers the error of V;
# it is multiplied by the computed n, which differs from the true one by a fraction of 1 / VOLUME_CLEARANCE. So
# VOLUME_ROUNDINGS exceeds the error of V (raster_edges.g) by a larger fraction, as the second line of the goal shows.
#
# The n of a plane is (normal.D) / ahead, where ahead is its distance from the eye, and the ray's test computes
# t = ahead / (normal.d) with the same number. The roundings are 3 for the product of normal and direction, 2 for the
# division by ahead, 3 for the sum over 1, x and y, 1 for the pixel's steps and 5 for the ray, and in the test 3 for
# the product and 1 for the division. All terms together are at most L / ahead.
u = 1b-53;
INV_DEPTH_ROUNDINGS = 47.5;
VOLUME_ROUNDINGS = 8.5;
VOLUME_CLEARANCE = 1024.0;
PLANE_ROUNDINGS = 19.0;
TERMS = 1.15471;
SQRT2 = 1.41422;
SQRT3 = 1.73206;
exceed = 1.0001;

RAY = 3 * SQRT2 + 3;
# The root of 36 + RAY^2.
BOTH = 9.409;
numerator = 3 * SQRT3 + 3 * (TERMS + 1) + 3 * 3 + 2 + 3 * SQRT3 / 2 * BOTH;
ratio = 1 / (1 - 1 / VOLUME_CLEARANCE);
f18 = (1 + e1) * (1 + e2) * (1 + e3) * (1 + e4) * (1 + e5) * (1 + e6) * (1 + e7) * (1 + e8) * (1 + e9)
    * (1 + e10) * (1 + e11) * (1 + e12) * (1 + e13) * (1 + e14) * (1 + e15) * (1 + e16) * (1 + e17) * (1 + e18);
plane = f18 - 1;

{ TERMS * TERMS >= 1.33334 /\ SQRT2 * SQRT2 >= 2 /\ SQRT3 * SQRT3 >= 3 /\ BOTH * BOTH - RAY * RAY >= 36
/\ VOLUME_ROUNDINGS / (3 * TERMS + 5) >= 1.002
/\ numerator * ratio * exceed / INV_DEPTH_ROUNDINGS <= 0.999
/\ (e1 in [-1b-53, 1b-53] /\ e2 in [-1b-53, 1b-53] /\ e3 in [-1b-53, 1b-53] /\ e4 in [-1b-53, 1b-53]
 /\ e5 in [-1b-53, 1b-53] /\ e6 in [-1b-53, 1b-53] /\ e7 in [-1b-53, 1b-53] /\ e8 in [-1b-53, 1b-53]
 /\ e9 in [-1b-53, 1b-53] /\ e10 in [-1b-53, 1b-53] /\ e11 in [-1b-53, 1b-53] /\ e12 in [-1b-53, 1b-53]
 /\ e13 in [-1b-53, 1b-53] /\ e14 in [-1b-53, 1b-53] /\ e15 in [-1b-53, 1b-53] /\ e16 in [-1b-53, 1b-53]
 /\ e17 in [-1b-53, 1b-53] /\ e18 in [-1b-53, 1b-53]
    -> |plane| / (PLANE_ROUNDINGS * u) <= 0.999) }
