# The depths of triangles and planes in the projection are off by less than the bounds in src/raster/edge_functions.rs.
#@ src/raster/edge_functions.rs INV_DEPTH_ROUNDINGS = 64.0
#@ src/raster/edge_functions.rs VOLUME_ROUNDINGS = 10.0
#@ src/raster/edge_functions.rs VOLUME_CLEARANCE = 64.0
#@ src/raster/edge_functions.rs PLANE_ROUNDINGS = 19.0
#@ src/raster/edge_functions.rs T_ROUNDINGS = 1250.0
# As in projection_edges.g each term of a sum is multiplied by a factor 1 + e for each rounding on its way.
#
# A nearness is n = (n_0 + n_1 + n_2).D / V. Beside the 4 roundings of each n_k and the 12 of its product with D there
# are two of the sum and one of the product with 1 / V, so 15; all three together are at most 3 R^2 L. The
# computed V is the true one plus `volume`, at most VOLUME_ROUNDINGS u R^3 in which R = 1; as it is VOLUME_CLEARANCE
# times as large at least, the computed V is 1 and the true one not less than 1 - 1 / VOLUME_CLEARANCE of it, `ratio`.
# The value that the bound's part with n is multiplied by is the computed one, which differs by parts of
# 1 / VOLUME_CLEARANCE; `slack` is for this. The inverse has one rounding more, which is relative to n <= 3 R^2 L / V.
#
# A plane's n is (normal.D) / ahead, and the ray's test has t = ahead / (normal.d) with the same ahead. Roundings: 3 for
# the product of normal and direction, 2 for the division by ahead, 3 for the sum over 1, x and y, 1 of h and v and 5 of
# the ray; in the test 3 for the product and 1 for the division. All terms together are at most L / ahead.
#
# T_ROUNDINGS: src/raster/edge_functions.rs says how often each error counts. `across` is the error of a sheared corner, in
# R: its own subtraction, the factor, the depth and their product, and the difference; |x| + 3 |z| <= sqrt(10) R, and
# the difference is at most sqrt(2) R. A weight is off by 4 E_x E_y, and Z / A <= 32 / (E_x + E_y); as
# E_x E_y / (E_x + E_y) <= (E_x + E_y) / 4 and E_x + E_y <= 4 sqrt(2) R, three weights move the depth by 3 * 32 * that.
# A ray is sqrt(3) times as long as its longest axis, at most.
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
