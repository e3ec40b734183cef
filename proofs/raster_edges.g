# The errors of the rasterizer's edge functions and of V are below the bounds in src/raster/edge_functions.rs.
#@ src/raster/edge_functions.rs EDGE_ROUNDINGS = 17.0
#@ src/raster/edge_functions.rs VOLUME_ROUNDINGS = 10.0
# A computed sum of products is the sum of its terms, each multiplied by a factor 1 + e with |e| <= u for each
# rounding on the term's way. So its error is at most ((1 + u)^k - 1) times the sum of the terms' magnitudes, where
# k is the largest number of roundings of a term.
#
# A component of b x c has terms like b_y c_z with 2 roundings for the corners, 1 for the product and 1 for the
# difference. The sums |b_y c_z| + |b_z c_y| of the magnitudes for the three components form a vector of length at
# most R^2 2 / sqrt(3): its squared length is at most 4/3 R^4, which is reached for b = c along (1, 1, 1).
# V = a.(b x c) has 4 more roundings: for a, for the product and for two sums. The magnitudes of its terms
# add up to at most R^3 2 / sqrt(3).
#
# In (b x c).D the terms n_x d_x of the computed b x c, |n| <= R^2, add up to at most R^2 L by the Cauchy-Schwarz
# inequality. The product of n and d takes 3 roundings, and the sum over 1, x and y another 3. The direction and the
# pixel's steps have 1 rounding here (the division by the picture's side) and 5 in the ray (the division, the product,
# two sums, and the product that makes it a unit vector).
u = 1b-53;
EDGE_ROUNDINGS = 17.0;
VOLUME_ROUNDINGS = 10.0;
TERMS = 1.15471;

f2 = (1 + e1) * (1 + e2);
f4 = f2 * (1 + e3) * (1 + e4);
f8 = f4 * (1 + e5) * (1 + e6) * (1 + e7) * (1 + e8);
f12 = f8 * (1 + e9) * (1 + e10) * (1 + e11) * (1 + e12);

# The lengths R and L and the bounds themselves are computed with at most a dozen roundings, which the factor 0.999
# in the goals covers.
edges = TERMS * (f4 - 1) + (1 + TERMS * (f4 - 1)) * (f12 - 1);
volume = TERMS * (f8 - 1);

{ TERMS * TERMS >= 1.33334
/\ (e1 in [-1b-53, 1b-53] /\ e2 in [-1b-53, 1b-53] /\ e3 in [-1b-53, 1b-53] /\ e4 in [-1b-53, 1b-53]
 /\ e5 in [-1b-53, 1b-53] /\ e6 in [-1b-53, 1b-53] /\ e7 in [-1b-53, 1b-53] /\ e8 in [-1b-53, 1b-53]
 /\ e9 in [-1b-53, 1b-53] /\ e10 in [-1b-53, 1b-53] /\ e11 in [-1b-53, 1b-53] /\ e12 in [-1b-53, 1b-53]
    -> |edges| / (EDGE_ROUNDINGS * u) <= 0.999
    /\ |volume| / (VOLUME_ROUNDINGS * u) <= 0.999) }
