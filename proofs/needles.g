# The plane of a triangle without area, such as rounding makes it, passes its points within what voxelization adds.
#@ src/grid/voxelize/triangle.rs PLANE_ROUNDINGS = 32.0
#
# In cells, a and b are the sides from a triangle's first corner, divided by its largest extent along an axis, the
# length, and p the way to any point of it, divided likewise: no coordinate exceeds 1. n = a x b, and n.p = 0. With
# normals as f64 computes them, each operation rounded relatively, n.p is off zero by at most PLANE_ROUNDINGS
# roundings; undone, the division makes it times the cube of the length. The further roundings, of the normal's
# products with a cell's centre, are relative to the normal, 2^-22 of it for up to 2^29 cells, and are far less
# than the normal times POSITION_ERROR_BOUND, by which cells are widened.

PLANE_ROUNDINGS = 32.0;

n0 = a1 * b2 - a2 * b1;
n1 = a2 * b0 - a0 * b2;
n2 = a0 * b1 - a1 * b0;
n0f = (a1 * (1 + ra1) * b2 * (1 + rb2) * (1 + r0) - a2 * (1 + ra2) * b1 * (1 + rb1) * (1 + s0)) * (1 + t0);
n1f = (a2 * (1 + ra2) * b0 * (1 + rb0) * (1 + r1) - a0 * (1 + ra0) * b2 * (1 + rb2) * (1 + s1)) * (1 + t1);
n2f = (a0 * (1 + ra0) * b1 * (1 + rb1) * (1 + r2) - a1 * (1 + ra1) * b0 * (1 + rb0) * (1 + s2)) * (1 + t2);
off = (n0f - n0) * p0 + (n1f - n1) * p1 + (n2f - n2) * p2;

{
  |a0| <= 1 /\ |a1| <= 1 /\ |a2| <= 1 /\ |b0| <= 1 /\ |b1| <= 1 /\ |b2| <= 1 /\ |p0| <= 1 /\ |p1| <= 1 /\ |p2| <= 1 /\
  |ra0| <= 1b-53 /\ |ra1| <= 1b-53 /\ |ra2| <= 1b-53 /\ |rb0| <= 1b-53 /\ |rb1| <= 1b-53 /\ |rb2| <= 1b-53 /\
  |r0| <= 1b-53 /\ |r1| <= 1b-53 /\ |r2| <= 1b-53 /\ |s0| <= 1b-53 /\ |s1| <= 1b-53 /\ |s2| <= 1b-53 /\
  |t0| <= 1b-53 /\ |t1| <= 1b-53 /\ |t2| <= 1b-53
->
  |off / PLANE_ROUNDINGS| <= 1b-53
}

n0f - n0 -> a1 * b2 * ((1 + ra1) * (1 + rb2) * (1 + r0) * (1 + t0) - 1) - a2 * b1 * ((1 + ra2) * (1 + rb1) * (1 + s0) * (1 + t0) - 1);
n1f - n1 -> a2 * b0 * ((1 + ra2) * (1 + rb0) * (1 + r1) * (1 + t1) - 1) - a0 * b2 * ((1 + ra0) * (1 + rb2) * (1 + s1) * (1 + t1) - 1);
n2f - n2 -> a0 * b1 * ((1 + ra0) * (1 + rb1) * (1 + r2) * (1 + t2) - 1) - a1 * b0 * ((1 + ra1) * (1 + rb0) * (1 + s2) * (1 + t2) - 1);
