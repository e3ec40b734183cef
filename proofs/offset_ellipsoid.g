# The offset of secondary rays exceeds the error of points on ellipsoids and of the next test.
#@ src/math/robust.rs OFFSET_ROUNDINGS = 32.0
#@ src/world/ellipsoid.rs ORTHOGONAL_ROUNDINGS = 4.0
#
# Errors are measured along the normal, in units of u. Let v be the vector from the centre c to the point p, h the
# lengths of the semi-axes, and e those of the half extents along the world's axes. In the frame of the semi-axes let
# w = h s be v, where s is the point of the unit sphere, and n the unit normal, which is s / h times T. T = n.w is the
# distance of the centre from the plane that touches at p, at most |v|. The next test begins with o = inverse (p - c) and is
# right where |o|^2 - 1 has the right sign. An error of f_i / h_i in o_i is one of n.f along the normal, and an error of
# g in |o|^2 is one of g T / 2. |A| is the matrix of the magnitudes of the axes' directions; for unit vectors x and y
# x.|A|y is at most sqrt(3), as each row has the length 1.
#
#   in |v|:      1  rounding of p - c;
#               2 sqrt(3)  of the products in inverse (p - c) and the first of their sums;
#               2 sqrt(3)  of the two divisions by the axis's length in the inverse;
#               2 sqrt(3)  of the products in linear s and the first of their sums, and 1 of the second sum.
#   in T:        1  of the second sum in inverse (p - c);
#               5  of the two lengths in the inverse (1.5 of the square and 1 of the root, each);
#               4.5  of s, which is made a unit vector (1.5 + 1 of its length, the reciprocal and the product);
#               1.5  of |o|^2, half of 3.
#   in |p|:      2 sqrt(3)  of adding c and of moving the point, where |p| is the largest coordinate.
# The axes are at right angles up to `skew`: their product, with ORTHOGONAL_ROUNDINGS to stop, has an error of 1 for its
# products and of half for the first of their sums, as its result is close to zero. This adds `skew` times the sum of
# n_i w_j over different axes, which is at most sqrt(3) W - T with W for the sum of w.
#
# The magnitude, the largest coordinate of the point plus that of the centre plus the longest semi-axis, is at least |p_j| + |c_j| + e_j for each
# axis j, so at least |v_j| + e_j, which is at least 2 |v_j|; and it is at least 2 |p_j|. Let it be 1. W is at most the root
# of the sum of h^2, which is also that of e^2, so W^2 <= sum (1 - |v_j|)^2 = 3 - 2 sum |v_j| + |v|^2. As |v_j| <= 1/2,
# sum |v_j| >= 2 |v|^2. Hence W^2 <= 3 (1 - |v|^2), and so sqrt(3) W <= 3 z with z = sqrt(1 - |v|^2). The total is at
# most a |v| + 3 skew z, and so at most the root of a^2 + (3 skew)^2, which is `most` or less.
#
# The offset is along the normal, or along a direction by its length divided by the cosine. Its other roundings are
# of second order.
OFFSET_ROUNDINGS = 32.0;
ORTHOGONAL_ROUNDINGS = 4.0;
SQRT3 = 1.73206;
skew = ORTHOGONAL_ROUNDINGS + 1.5;
in_v = 1 + 3 * 2 * SQRT3 + 1;
in_t = 1 + 5 + 4.5 + 1.5 - skew;
in_p = 2 * SQRT3;
a = in_v + in_t;
most = 25.2;
moved = OFFSET_ROUNDINGS * 0.999;

{ SQRT3 * SQRT3 >= 3
/\ most * most - a * a - 9 * skew * skew >= 0
/\ (most + in_p / 2) * 1.0001 / moved <= 0.85 }
