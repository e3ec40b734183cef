# The errors of inverse depths in the rasterizer are below the bounds in src/raster/edge_functions.rs.
#@ src/raster/edge_functions.rs INV_DEPTH_ROUNDINGS = 64.0
#@ src/raster/edge_functions.rs VOLUME_ROUNDINGS = 10.0
#@ src/raster/edge_functions.rs VOLUME_CLEARANCE = 64.0
#@ src/raster/edge_functions.rs PLANE_ROUNDINGS = 19.0
#@ src/raster/edge_functions.rs T_ROUNDINGS = 1250.0
# As in raster_edges.g each term of a sum is multiplied by a factor 1 + e for each rounding on its way.
#
# The inverse depth is n = (n_0 + n_1 + n_2).D / V with the normals n_k of raster_edges.g. Besides the 4 roundings of
# each n_k and the 12 of its product with D there are two for the sum and one for the product with 1 / V, so 15. All
# three normals together are at most 3 R^2 L. Let R = 1 and let the computed V be 1. It is at least VOLUME_CLEARANCE
# times its error bound, so the true V is at least 1 - 1 / VOLUME_CLEARANCE, whose inverse is `ratio`. The part of
# the bound that is proportional to n covers the error of V; it is multiplied by the computed n, which differs from
# the true one by a fraction of 1 / VOLUME_CLEARANCE. VOLUME_ROUNDINGS exceeds the 8 roundings of V by a larger
# fraction, as the second line of the goal shows. The inverse of V has one more rounding, r, relative to
# n <= 3 R^2 L / V.
#
# The n of a plane is (normal.D) / ahead, where ahead is its distance from the eye, and the ray's test computes
# t = ahead / (normal.d) with the same number. The roundings are 3 for the product of normal and direction, 2 for the
# division by ahead, 3 for the sum over 1, x and y, 1 for the pixel's steps and 5 for the ray, and in the test 3 for
# the product and 1 for the division. All terms together are at most L / ahead.
#
# T_ROUNDINGS: src/raster/edge_functions.rs lists the errors. `across` is the error of a sheared corner in units of
# u R: that of its own subtraction, the factor, the depth and their product, and the difference. |x| + 3 |z| is at
# most sqrt(10) R, and the difference is at most sqrt(2) R. The error of a weight is 4 u E_x E_y, and
# Z / A <= 32 / (E_x + E_y). Since E_x E_y / (E_x + E_y) <= (E_x + E_y) / 4 and E_x + E_y <= 4 sqrt(2) R, three weights
# move the depth by at most 3 * 32 times that. A ray is at most sqrt(3) times as long as its longest axis.
u = 1b-53;
INV_DEPTH_ROUNDINGS = 64.0;
VOLUME_ROUNDINGS = 10.0;
VOLUME_CLEARANCE = 64.0;
PLANE_ROUNDINGS = 19.0;
T_ROUNDINGS = 1250.0;
TERMS = 1.15471;
SQRT2 = 1.41422;
SQRT3 = 1.73206;
SQRT10 = 3.16228;

f4 = (1 + e1) * (1 + e2) * (1 + e3) * (1 + e4);
f15 = (1 + e5) * (1 + e6) * (1 + e7) * (1 + e8) * (1 + e9) * (1 + e10) * (1 + e11) * (1 + e12)
    * (1 + e13) * (1 + e14) * (1 + e15) * (1 + e16) * (1 + e17) * (1 + e18) * (1 + e19);
f18 = (1 + e1) * (1 + e2) * (1 + e3) * f15;

numerator = 3 * (TERMS * (f4 - 1) + (1 + TERMS * (f4 - 1)) * (f15 - 1) + r);
ratio = 1 / (1 - 1 / VOLUME_CLEARANCE);
plane = f18 - 1;
across = SQRT10 + SQRT2;
weights = 96 * 4 * SQRT2;
formula = 1 + 6 * 2 + 2;
t = SQRT3 * (32 * across + weights + formula);

{ TERMS * TERMS >= 1.33334 /\ SQRT2 * SQRT2 >= 2 /\ SQRT3 * SQRT3 >= 3 /\ SQRT10 * SQRT10 >= 10
/\ VOLUME_ROUNDINGS / (8 * TERMS) >= 1.017
/\ t / T_ROUNDINGS <= 0.999
/\ (e1 in [-1b-53, 1b-53] /\ e2 in [-1b-53, 1b-53] /\ e3 in [-1b-53, 1b-53] /\ e4 in [-1b-53, 1b-53]
 /\ e5 in [-1b-53, 1b-53] /\ e6 in [-1b-53, 1b-53] /\ e7 in [-1b-53, 1b-53] /\ e8 in [-1b-53, 1b-53]
 /\ e9 in [-1b-53, 1b-53] /\ e10 in [-1b-53, 1b-53] /\ e11 in [-1b-53, 1b-53] /\ e12 in [-1b-53, 1b-53]
 /\ e13 in [-1b-53, 1b-53] /\ e14 in [-1b-53, 1b-53] /\ e15 in [-1b-53, 1b-53] /\ e16 in [-1b-53, 1b-53]
 /\ e17 in [-1b-53, 1b-53] /\ e18 in [-1b-53, 1b-53] /\ e19 in [-1b-53, 1b-53] /\ r in [-1b-53, 1b-53]
    -> |numerator * ratio| / (INV_DEPTH_ROUNDINGS * u) <= 0.999
    /\ |plane| / (PLANE_ROUNDINGS * u) <= 0.999) }
