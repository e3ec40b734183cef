# The errors of the rasterizer's edge functions and of V are below the bounds in src/fast/raster/edge_functions.rs.
#@ src/fast/raster/edge_functions.rs EDGE_ROUNDINGS = 16.5
#@ src/fast/raster/edge_functions.rs VOLUME_ROUNDINGS = 8.5
# A computed sum of products is the sum of its terms, each multiplied by a factor 1 + e with |e| <= u for each
# rounding on the term's way. So its error is at most k u times the sum of the terms' magnitudes, where k is the largest
# number of roundings of a term; `exceed` leaves room for what is of second order.
#
# A component of b x c has terms like b_y c_z with 2 roundings for the corners and 1 for the product. The sums
# |b_y c_z| + |b_z c_y| of the magnitudes for the three components form a vector of length at most R^2 2 / sqrt(3): its
# squared length is at most 4/3 R^4, which is reached for b = c along (1, 1, 1). The difference has one rounding more, of
# the component itself; the length of b x c is at most R^2.
# In V = a.(b x c) the terms a_x n_x of the computed b x c have one rounding for the difference in n, one for a, one for the
# product and two for the sums. They add up to at most R^3, by the Cauchy-Schwarz inequality.
#
# In (b x c).D the terms n_x d_x of the computed b x c, |n| <= R^2, add up to at most R^2 L by the Cauchy-Schwarz
# inequality. The difference in n takes a rounding, the product of n and d 3, and the sum over 1, x and y another 3. The direction and the
# pixel's steps have 1 rounding here (the division by the picture's side) and 5 in the ray (the division, the product,
# two sums, and the product that makes it a unit vector).
EDGE_ROUNDINGS = 16.5;
VOLUME_ROUNDINGS = 8.5;
TERMS = 1.15471;

# The lengths R and L and the bounds themselves are computed with at most a dozen roundings, which the factor 0.999
# in the goals covers.
exceed = 1.0001;
normal = 3 * TERMS + 1;
edges = (normal + 3 + 3 + 6) * exceed;
volume = (normal + 1 + 3) * exceed;

{ TERMS * TERMS >= 1.33334 /\ edges / EDGE_ROUNDINGS <= 0.999 /\ volume / VOLUME_ROUNDINGS <= 0.999 }
