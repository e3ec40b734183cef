# The offset of secondary rays exceeds the error of points on planes, triangles and spheres, and of the next test.
#@ src/math/robust.rs OFFSET_ROUNDINGS = 32.0
#
# Errors are measured along the normal, in units of u times `magnitude`, the largest coordinate of the point plus the
# extent of its own primitive: the largest coordinate of a triangle's corners, that of a sphere's centre plus its radius, or
# a plane's offset. Other primitives need no offset, since the sign of t is exact there. A point is moved by OFFSET_ROUNDINGS of these units: along the normal, or
# along a direction by that amount divided by the cosine. Each rounding is a factor 1 + e of a coordinate. The
# coordinates are orthogonal, so an error of e M in each coordinate of a vector is an error of at most SQRT3 e M of
# the vector, and each rounding of a dot product with a unit vector contributes as much.
#
# `added`: the coordinates of the moved point are rounded.
#
# Plane: the point's distance from it is computed with 4 roundings (a product and two sums, and the difference), and
# is subtracted with one rounding of the coordinates. The test of the next ray computes the same distance from the
# moved point, with 4 more. (The differences are small, so their relative roundings do not count.)
#
# Triangle: the point is (u a + v b + w c) / (u + v + w) with weights of one sign, so in exact arithmetic it lies in
# the triangle whatever the weights are. It takes 3 roundings in the numerator, 2 in the denominator, and 1 for the
# division. Whether the ray crosses the edge of a neighbour is decided exactly, and the triangle itself is excluded.
#
# Sphere: the point is c + r n. n is a unit vector except for the roundings of its squared length (3, halved by the
# square root), the square root, the reciprocal and the product. They are followed by the product with r, which is at
# most the magnitude, and by the sum. The side of the sphere on which a ray begins is computed in double-double
# arithmetic.
OFFSET_ROUNDINGS = 32.0;
SQRT3 = 1.73206;
added = SQRT3 * 1.0001;
moved = OFFSET_ROUNDINGS * 0.999;
plane = SQRT3 * (4 + 1 + 4) + added;
triangle = SQRT3 * (3 + 2 + 1) * 1.0001 + added;
sphere = (1.5 + 1 + 1 + 1 + 1) * 1.0001 + SQRT3 + added;

{ SQRT3 * SQRT3 >= 3
/\ plane / moved <= 0.55
/\ triangle / moved <= 0.39
/\ sphere / moved <= 0.29 }
