# The sign of a triangle's edge function is right where its size exceeds the bound that the source compares it with.
#@ src/world/edge_functions.rs EDGE_ROUNDINGS = 7.001
#
# Notation: u = 2^-53; f1, f2, ... are numbers from -1 to 1, one for each rounding. No product underflows here.
#
# One vertex. Computed are X' = fl(v.x - o.x), Z' = fl(v.z - o.z), s' = fl(d.x / d.z), k' = fl(s' Z') and
# x' = fl(X' - k'). A rounded number is off by at most u times itself, before or after its rounding:
#   X = X'(1 + u f1), Z = Z'(1 + u f2), k' = s' Z'(1 + u f4), X' - k' = x'(1 + u f5).
# |s| <= 1, since the direction is longest along z, so s' is off by at most half of u: s = s' + u f3 / 2. Then
#   x = X - s Z = x' + u (alpha x' + (beta s' + gamma) Z')
# with alpha, beta and gamma as below. With Z from now on the largest |Z'| of the vertices, and A and B the bounds
# proved here,   x = x' + u (a x' + b Z),  |a| <= A,  |b| <= B.   The same holds for y.
#
# The edge function. Let |x'| <= X and |y'| <= Y for all vertices, and M = X + Y. So each coordinate of a vertex is off by
# at most  r = u (A M + B Z).  For two vertices (x1, y1) and (x2, y2) as computed the exact edge function is x1 y2 - x2 y1.
# Let them move along straight lines to where they are in truth. If the sign of the edge function is not the same in
# truth, it is zero on the way: both have then moved onto one line through the origin, whose direction is (c, s). Let
# c and s not be negative, or else mirror the plane. They have moved there from
#   d1 = s x1 - c y1  and  d2 = s x2 - c y2,  which are at most (c + s) r,
# and the identity below, which Gappa checks, says
#   (c + s) (x1 y2 - x2 y1) = d1 (x2 + y2) - d2 (x1 + y1).
# Hence |x1 y2 - x2 y1| <= 2 M r, without any term of second order. The computed function is off x1 y2 - x2 y1 by two
# roundings of products and one of their difference: at most u (2 + u) 2 X Y <= u (2 + u) M^2 / 2. So the sign can be
# wrong only where the computed function is at most
#   u M^2 needed_mm + u M Z needed_mz.
#
# The bound. Let w = 1 - u, by which a rounding diminishes a number at most. The computed M is at least w M, the
# computed M + Z at least w^2 (M + Z), and three products and sums follow (HUGE is a power of two), so that the bound
# is at least  w^6 EDGE_ROUNDINGS u M (M + Z),  which is  u M^2 given + u M Z given  or more. It holds where `given` is
# above both that are needed. For M^2 it is so by u and more, which is far more than the 2^-1072 M by which underflow
# moves what is computed of the vertices where M >= 1; elsewhere MIN_EDGE_ERROR_BOUND is.

EDGE_ROUNDINGS = 7.001;
u = 1b-53;
w = 1 - u;

alpha = f5 + f1 + u * f5 * f1;
beta = f4 + f1 + u * f4 * f1 - f2;
gamma = f3 / 2 * (1 + u * f2);

d1 = s * x1 - c * y1;
d2 = s * x2 - c * y2;
identity = (c + s) * (x1 * y2 - x2 * y1) - (d1 * (x2 + y2) - d2 * (x1 + y1));

needed_mm = 2 * A + (2 + u) / 2;
needed_mz = 2 * B;

given = EDGE_ROUNDINGS * w * w * w * w * w * w;

{ (f1 in [-1, 1] /\ f2 in [-1, 1] /\ f3 in [-1, 1] /\ f4 in [-1, 1] /\ f5 in [-1, 1]
  # A = 2 + u and B = 3.5 + 1.5 u.
  /\ A in [0, 0x1.00000000000004p1] /\ B in [0, 0x1.c0000000000006p1] ->
  |alpha| <= 0x1.00000000000004p1 /\ |beta| + |gamma| <= 0x1.c0000000000006p1
  /\ given - needed_mm >= 1 /\ given - needed_mz >= 1b-20)
/\ identity in [0, 0] }

identity -> 0;
