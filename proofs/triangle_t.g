# The t of a triangle that is interpolated is off by less than T_ROUNDINGS roundings of its farthest corner's distance.
#@ src/world/edge_functions.rs T_ROUNDINGS = 238.0
#@ src/world/edge_functions.rs MAX_INTERPOLATED_STEEPNESS = 32.0
#@ src/fast/raster/edge_functions.rs VOLUME_ROUNDINGS = 8.5
#@ src/fast/raster/edge_functions.rs VOLUME_CLEARANCE = 1024.0
# Let R = 1 be the distance of the farthest corner from the ray's origin, and u = 1 the unit roundoff; what is of second
# order is counted in `exceed`. z is along the ray's longest axis, and s_x and s_y are its slopes, at most 1. (X, Y, Z) are
# the corners relative to the origin, whose length is at most 1, and x = X - s_x Z and y = Y - s_y Z the sheared ones.
# e_x, e_y and e_z are the extents of x, y and z, S = e_x + e_y, and A is twice the area in x and y. The weights of the
# crossing are l_k, its depth is z_h: sum l_k x_k = sum l_k y_k = 0, sum l_k = 1 and sum l_k Z_k = z_h. avg is the mean with
# these weights. t is interpolated where S e_z <= MAX_INTERPOLATED_STEEPNESS A. The error of the depth is multiplied by
# length = sqrt(1 + s_x^2 + s_y^2) <= sqrt(3) to make that of the distance.
#
# Extents. For three points in the unit ball the squares of the extents in X, Y and Z add up to at most 6: the squares of
# the three sides add up to at most 9, and for each axis to at least 3/2 of the squared extent. So
# S <= e_X + e_Y + 2 e_Z <= sqrt(6) sqrt(6) = 6.
#
# Corners. Let the corners move from where they are computed to where they are in truth. The edge functions are not zero
# on the way (edge_functions.g), so that the crossing stays inside. Its depth changes by avg(dz - g_x dx - g_y dy) with the
# slopes g_x and g_y of the plane. The area of the triangle in y and z is e_z times the side of the triangle that is cut
# by the plane of constant z through the middle corner, c = (c_x, c_y): |g_x| = e_z c_y / A and |g_y| = e_z c_x / A, with
# c_x <= e_x, c_y <= e_y and |c| <= 2, as the cut lies in the ball. So |g_x| <= 32 c_y / S and |g_y| <= 32 c_x / S, which
# together are at most 32. The errors are
#   - in x:  |X| of the difference, s_x |Z| of that in z (where g_x s_x dz adds to dz), s_x |Z| of the product, |x| of
#     the last difference, and |z_h| / 2 of the slope, which is the same for all corners. Likewise in y.
#   - in z:  |Z|, at most 1.
# The slope's part, with length |z_h| <= 1, is at most 32 / 2.
#
# Weights. Each product x_i y_j in an edge function has a rounding, which the third corner's distance z_k - z_h
# multiplies: the sum of all |x_i y_j (z_k - z_h)|, with i, j and k different, over A. It is convex in x, so that it is
# largest where x takes two values, as for a corner i with |x_i| = (1 - l_i) e_x and |x_j| = l_i e_x for the others. The same
# holds for y and z. The sum is then largest for the same corner in all three, 6 l^2 (1 - l) e_x e_y e_z, and the goal says
# that this is at most `permanent` of e_x e_y e_z (it is 8/9 for l = 2/3); for two different corners it is 2 p (1 - p + p q) with p + q <= 1,
# and for three it is the last of `mixed`. So the weights' part is at most 32 * permanent e_x e_y / S. The difference of the
# products has a rounding of the weight: 2 l (1 - l) e_z, at most e_z / 2.
#
# The sum. avg |x| is at most e_x / 2, as the mean of x is zero. |X| + 2 |Z| and |Y| + 2 |Z| add up, with the factors c_y and
# c_x, to at most sqrt(c_x^2 + c_y^2 + 4 (c_x + c_y)^2). So the error of the depth is 32 F with
#   F = (sqrt(c_x^2 + c_y^2 + 4 (c_x + c_y)^2) + (c_y e_x + c_x e_y) / 2 + permanent e_x e_y) / S.
# For S <= 2 sqrt(2), c <= e makes F <= sqrt(5 - 2 m) + (1 + permanent) m S with m = e_x e_y / S^2 <= 1/4, which grows with m.
# For a larger S, |c| <= 2 makes F <= 6 / S + |e| / S + permanent (S - |e|^2 / S) / 2, which falls as |e| / S grows from
# 1 / sqrt(2) on, and is then convex in S. So the largest F is that of S = 2 sqrt(2) or S = 6.
#
# The formula. The differences of depths, the products with weights and their sum, the sum of the weights (2) and the
# division are 6 roundings of at most e_z. The last sum, the factor and the product with it are 3 of the distance.
#
# The area. The computed area differs from that on the way by 2 S times the largest error of a coordinate,
# |X| + 2.5 |Z| + |x| <= 2 |X| + 3.5 |Z|, and by the products' roundings, at most (2 e_x) (2 e_y). V is A z_h, and the
# rasterizer requires V to be VOLUME_CLEARANCE times its error bound. `grown` is the factor by which this lets the
# slopes exceed 32 / S; the extents change by less than 20 roundings, which adds 20 e_z / A.
T_ROUNDINGS = 238.0;
MAX_INTERPOLATED_STEEPNESS = 32.0;
VOLUME_ROUNDINGS = 8.5;
VOLUME_CLEARANCE = 1024.0;
SQRT2 = 1.41422;
SQRT3 = 1.73206;
COORDINATE = 4.0312;
exceed = 1.0001;
permanent = 0.9;

area = VOLUME_ROUNDINGS * (VOLUME_CLEARANCE - 1);
grown = (1 + 40 / (area * MAX_INTERPOLATED_STEEPNESS)) / (1 - (2 * 6 * COORDINATE + 36) / area);
steepness = MAX_INTERPOLATED_STEEPNESS * grown;
medium = 3 / SQRT2 + SQRT2 / 2 + permanent * SQRT2 / 2;
large = 1 + SQRT2 / 2 + permanent * 6 / 4;
formula = SQRT3 * (6.5 * 2 + 1) + 3;
t = (SQRT3 * steepness * F + steepness / 2 + formula) * exceed;

q = (1 - p) * v;
r = (1 - p) * (1 - v);
same = 6 * p * p * (1 - p);
two = 2 * p * (1 - p + p * q);
mixed = (1 - p) * (1 - q) * (1 - r) + (1 - p) * q * r + p * q * (1 - r) + 2 * p * q * r + p * (1 - q) * r;

{ F in [0, 3.465] /\ p in [0, 1] /\ v in [0, 1] ->
  SQRT2 * SQRT2 - 2 in [0, 0.0001] /\ SQRT3 * SQRT3 >= 3 /\ COORDINATE * COORDINATE >= 16.25
  /\ medium <= 3.465 /\ large <= 3.465
  /\ t / T_ROUNDINGS <= 0.999
  /\ same / permanent <= 1 /\ two / permanent <= 1 /\ mixed / permanent <= 1 }

same / permanent $ p in 1000;
two / permanent $ p in 50, v in 50;
mixed / permanent $ p in 50, v in 50;
