# The edge functions and the V of the projection are off by less than the bounds in src/raster/edge_functions.rs.
#@ src/raster/edge_functions.rs EDGE_ROUNDINGS = 17.0
#@ src/raster/edge_functions.rs VOLUME_ROUNDINGS = 10.0
# A sum of products, however it is computed, is the sum of its terms, each times a product of factors 1 + e
# with |e| <= u, one for each rounding on the term's way. So it is off by at most ((1 + u)^k - 1) times the sum of
# the terms' magnitudes, k being the longest way.
#
# A component of b x c has terms like b_y c_z; 2 roundings are those of the corners, 1 of the product, 1 of
# the difference. The magnitudes |b_y c_z| + |b_z c_y| of the three components are a vector not longer than
# R^2 2 / sqrt(3): its square is at most 4/3 R^4, which it reaches for b = c along (1, 1, 1).
# With V = a.(b x c) there are 4 more: a's own, the product's and two sums'. The magnitudes of the terms
# add up to at most R^3 2 / sqrt(3).
#
# For (b x c).D the terms n_x d_x of the computed b x c, |n| <= R^2, add up to at most R^2 L by Cauchy and Schwarz.
# The product of n and d takes 3 roundings, the sum over 1, x and y another 3; d, h and v are off by 1 here (the
# division by the picture's side) and by 5 in the ray (the division, the product, two sums, and the
# product that makes it a unit vector).
u = 1b-53;
EDGE_ROUNDINGS = 17.0;
VOLUME_ROUNDINGS = 10.0;
TERMS = 1.15471;

f2 = (1 + e1) * (1 + e2);
f4 = f2 * (1 + e3) * (1 + e4);
f8 = f4 * (1 + e5) * (1 + e6) * (1 + e7) * (1 + e8);
f12 = f8 * (1 + e9) * (1 + e10) * (1 + e11) * (1 + e12);

# The lengths R and L, and the bounds themselves, are computed with a dozen roundings at most.
edges = TERMS * (f4 - 1) + (1 + TERMS * (f4 - 1)) * (f12 - 1);
volume = TERMS * (f8 - 1);

{ TERMS * TERMS >= 1.33334
/\ (e1 in [-1b-53, 1b-53] /\ e2 in [-1b-53, 1b-53] /\ e3 in [-1b-53, 1b-53] /\ e4 in [-1b-53, 1b-53]
 /\ e5 in [-1b-53, 1b-53] /\ e6 in [-1b-53, 1b-53] /\ e7 in [-1b-53, 1b-53] /\ e8 in [-1b-53, 1b-53]
 /\ e9 in [-1b-53, 1b-53] /\ e10 in [-1b-53, 1b-53] /\ e11 in [-1b-53, 1b-53] /\ e12 in [-1b-53, 1b-53]
    -> |edges| / (EDGE_ROUNDINGS * u) <= 0.999
    /\ |volume| / (VOLUME_ROUNDINGS * u) <= 0.999) }
