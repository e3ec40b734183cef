# A triangle's edge function is never off by more than the bound that the source compares it with.
#@ src/primitive/edge_functions.rs EDGE_ROUNDINGS = 7.0
#@ src/primitive/edge_functions.rs SHEAR_ROUNDINGS = 5.0
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
# The edge function. Let |x'| <= X and |y'| <= Y for all vertices, and M = X + Y, so that 2 X Y <= M^2 / 2. For
# two vertices p and q, with numbers a and b of their own for each coordinate,
#   p.x q.y = (p.x'(1 + u a1) + u b1 Z) (q.y'(1 + u a2) + u b2 Z)
# is off p.x' q.y' by at most  u (2 A + u A^2) X Y + u B (1 + u A) (X + Y) Z + u^2 B^2 Z^2,  and so is p.y q.x. The
# computed function is off p.x' q.y' - p.y' q.x' by two roundings of products and one of their difference: at most
# u (2 + u) 2 X Y. Together at most
#   u M^2 needed_mm + u M Z needed_mz + u^2 Z^2 needed_zz.
#
# The bound. Let w = 1 - u, by which a rounding diminishes a number at most. The computed M is at least w M, the
# computed M + Z at least w^2 (M + Z), the sum of M and SHEAR_ROUNDINGS u (M + Z) at least
# w (w M + w^3 SHEAR_ROUNDINGS u (M + Z)), and two products and one sum follow (HUGE is a power of two), so that
# the bound is at least  w^7 EDGE_ROUNDINGS u (M + Z) (M + w^2 SHEAR_ROUNDINGS u (M + Z)),  which is
#   u M^2 given_mm + u M Z given_mz + u^2 Z^2 given_zz
# or more. It holds where each coefficient that is given is above the one that is needed. For M^2 it is so by 3 u
# and more, which is far more than the 2^-1072 M by which underflow moves what is computed of the vertices where
# M >= 1; elsewhere MIN_EDGE_ERROR_BOUND is.

EDGE_ROUNDINGS = 7.0;
SHEAR_ROUNDINGS = 5.0;
u = 1b-53;
w = 1 - u;

alpha = f5 + f1 + u * f5 * f1;
beta = f4 + f1 + u * f4 * f1 - f2;
gamma = f3 / 2 * (1 + u * f2);

needed_mm = (2 * A + u * A * A) / 2 + (2 + u) / 2;
needed_mz = 2 * B * (1 + u * A);
needed_zz = 2 * B * B;

w7 = w * w * w * w * w * w * w;
given_mm = EDGE_ROUNDINGS * w7;
given_mz = EDGE_ROUNDINGS * w7 * (1 + 2 * SHEAR_ROUNDINGS * u * w * w);
given_zz = EDGE_ROUNDINGS * w7 * SHEAR_ROUNDINGS * w * w;

{ f1 in [-1, 1] /\ f2 in [-1, 1] /\ f3 in [-1, 1] /\ f4 in [-1, 1] /\ f5 in [-1, 1]
  # A = 2 + u and B = 3.5 + 1.5 u.
  /\ A in [0, 0x1.00000000000004p1] /\ B in [0, 0x1.c0000000000006p1] ->
  |alpha| <= 0x1.00000000000004p1 /\ |beta| + |gamma| <= 0x1.c0000000000006p1
  /\ given_mm - needed_mm >= 3 /\ given_mz - needed_mz >= 1b-54 /\ given_zz - needed_zz >= 10 }
