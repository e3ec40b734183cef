# The offset of secondary rays takes them beyond what rounding leaves of the surface of planes, triangles and spheres.
#@ src/math/robust.rs OFFSET_ROUNDINGS = 32.0
# Errors are counted along the normal, in units of u times `magnitude`, the largest coordinate of the point plus
# the largest of the primitives. A point is moved by OFFSET_ROUNDINGS of those: along the normal, or along a direction by
# so much over the slope. Roundings of coordinates are factors 1 + e each, at right angles to each other, so a vector
# whose coordinates are off by e M is off by SQRT3 e M at most, and a sum of products with a unit vector by as much
# for each rounding.
#
# `added`: the moved point's own coordinates are rounded.
#
# A plane: the point's distance from it is computed with 4 roundings (a product and two sums, and the difference), and
# is subtracted with one rounding of the coordinates. The test of the next ray computes the same distance from
# the moved point, with 4 more. (The differences are small; their relative roundings do not count.)
#
# A triangle: the point is (u a + v b + w c) / (u + v + w) with weights of one sign, so that with exact
# arithmetic it would lie in the triangle whatever they are. It takes 3 roundings above, 2 below, 1 for the
# division. Whether a neighbour's line is crossed is decided exactly, and the triangle itself is left out.
#
# A sphere: the point is c + r n. n is unit but for the square of its length (3 roundings, halved by the root), the
# root, the inverse and the product; then come the product with r, at most the magnitude, and the sum. On which
# side of the sphere a ray begins is computed with twice the digits.
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
