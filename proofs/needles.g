# The computed plane of a triangle that is nearly degenerate passes its points within the error bound of insertion.
#@ src/caster/insertion.rs PLANE_ROUNDINGS = 32.0
#
# In units of cells, a and b are the sides from a triangle's first corner, divided by its largest extent along an
# axis, the length. p is the vector to any point of the triangle, divided likewise, so no coordinate exceeds 1. n = a
# x b, and n.p = 0. With the normal as f64 computes it, each operation having a relative rounding error, the absolute
# value of n.p is at most PLANE_ROUNDINGS roundings; undoing the division multiplies it by the cube of the length. The
# further roundings, of the products of the normal with a cell's centre, are relative to the normal: 2^-22 of it for
# up to 2^29 cells, which is far less than the normal times POSITION_ERROR_BOUND, by which cells are padded.

PLANE_ROUNDINGS = 32.0;

n0 = a1 * b2 - a2 * b1;
n1 = a2 * b0 - a0 * b2;
n2 = a0 * b1 - a1 * b0;
n0f = (a1 * (1 + ra1) * b2 * (1 + rb2) * (1 + r0) - a2 * (1 + ra2) * b1 * (1 + rb1) * (1 + s0)) * (1 + t0);
n1f = (a2 * (1 + ra2) * b0 * (1 + rb0) * (1 + r1) - a0 * (1 + ra0) * b2 * (1 + rb2) * (1 + s1)) * (1 + t1);
n2f = (a0 * (1 + ra0) * b1 * (1 + rb1) * (1 + r2) - a1 * (1 + ra1) * b0 * (1 + rb0) * (1 + s2)) * (1 + t2);
error = (n0f - n0) * p0 + (n1f - n1) * p1 + (n2f - n2) * p2;

{
  |a0| <= 1 /\ |a1| <= 1 /\ |a2| <= 1 /\ |b0| <= 1 /\ |b1| <= 1 /\ |b2| <= 1 /\ |p0| <= 1 /\ |p1| <= 1 /\ |p2| <= 1 /\
  |ra0| <= 1b-53 /\ |ra1| <= 1b-53 /\ |ra2| <= 1b-53 /\ |rb0| <= 1b-53 /\ |rb1| <= 1b-53 /\ |rb2| <= 1b-53 /\
  |r0| <= 1b-53 /\ |r1| <= 1b-53 /\ |r2| <= 1b-53 /\ |s0| <= 1b-53 /\ |s1| <= 1b-53 /\ |s2| <= 1b-53 /\
  |t0| <= 1b-53 /\ |t1| <= 1b-53 /\ |t2| <= 1b-53
->
  |error / PLANE_ROUNDINGS| <= 1b-53
}

n0f - n0 -> a1 * b2 * ((1 + ra1) * (1 + rb2) * (1 + r0) * (1 + t0) - 1) - a2 * b1 * ((1 + ra2) * (1 + rb1) * (1 + s0) * (1 + t0) - 1);
n1f - n1 -> a2 * b0 * ((1 + ra2) * (1 + rb0) * (1 + r1) * (1 + t1) - 1) - a0 * b2 * ((1 + ra0) * (1 + rb2) * (1 + s1) * (1 + t1) - 1);
n2f - n2 -> a0 * b1 * ((1 + ra0) * (1 + rb1) * (1 + r2) * (1 + t2) - 1) - a1 * b0 * ((1 + ra1) * (1 + rb0) * (1 + s2) * (1 + t2) - 1);
