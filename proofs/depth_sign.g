# The sign of a triangle's t is right where its depth times its area exceeds the bound that the source compares it with.
#@ src/world/edge_functions.rs EDGE_ROUNDINGS = 7.001
#@ src/world/edge_functions.rs DEPTH_BOUNDS = 5.0
#
# Notation as in edge_functions.g: u = 2^-53; of the sheared vertices as computed, |x| <= X and |y| <= Y, M = X + Y, and
# |z| <= Z. An exact x or y is off by r = u (A M + B Z) at most, an exact z by u Z. No product underflows here.
#
# The edge functions. That of the exact vertices is off that of the computed ones by 2 r (X + Y) + 2 r^2, and the computed
# one by its roundings, u (2 + u) M^2 / 2, so both differ by e = 2 M r (1 + r / M) + u (2 + u) M^2 / 2 at most. Their signs
# are certain, so that each is above their bound, w^6 EDGE_ROUNDINGS u M (M + Z), and one is at most (1 + 3 u) M^2 / 2. Hence
# u Z / M is at most `z`, and r / M at most `R`.
#
# The volume. The exact depth times the exact area is V = sum of e_k z_k over the vertices, whose sign, with that of the
# area, is the sign of t. With the computed e_k and z_k it differs by 3 e Z, and by u Z times the sum of the e_k, which is at
# most (1 + 4 u) M^2, since it is twice the area of a triangle in a box of 2 X by 2 Y.
#
# The depth. With S for the sum of the computed e_k, depth S is V as computed, but for the 6 roundings of the difference of
# depths, at most 2 Z, its product, the sum of two, the division, and two of S; and for that of the last sum, which is
# relative to the result and does not change its sign.
#
# All in units of u M Z times M (the part `of_m`) or times Z (the part `of_z`). In the comparison are 6 roundings of the
# edge functions' bound, two products on its side, and on the other a product and the area's two.
EDGE_ROUNDINGS = 7.001;
DEPTH_BOUNDS = 5.0;
A = 0x1.00000000000004p1;
B = 0x1.c0000000000006p1;
u = 1b-53;
w = 1 - u;

z = (1 + 3 * u) / (2 * EDGE_ROUNDINGS * w * w * w * w * w * w);
R = 0.251;
area = 1 + 4 * u;
of_m = 3 * (2 * A * (1 + R) + (2 + u) / 2) + (12.001 + 1) * area;
of_z = 3 * 2 * B * (1 + R);
given = DEPTH_BOUNDS * EDGE_ROUNDINGS * (1 - 12 * u);

{ (u * A + B * z) / R <= 1
/\ of_m * 1.001 / given <= 0.9
/\ of_z * 1.001 / given <= 0.8 }
