# The error of the DDA's crossing times is within its error bound, for rays from up to 2^31 cells away.
#@ src/caster/dda.rs SETUP_ROUNDINGS = 2.0
#@ src/caster/bounds.rs MAX_ORIGIN_CELLS = 2147483648.0
#@ src/caster/insertion.rs POSITION_ERROR_BOUND = 7.8e-6
#
# Fixed-point t. By definition t = entry + fixed_t / fixed_per_t with the floats entry and fixed_per_t, so these two
# have no error. The exact fixed-point t of the faces of an axis is c for the first one, and c + k step for the
# following ones. The source stores them as the integers nextf (t_next) for the first face and stepf (t_delta). The
# error of both is at most 1/2, plus the roundings in f64: rc relative to c, which is at most 2^30, and rs relative to
# the step. After k steps the source has nextf + k stepf, a sum of integers below 2^31, which is exact: by induction
# its error is that of nextf plus k times that of stepf. As the ray's interval is 2^29 units long, k step <= 2^29; so
# the roundings in f64 contribute at most 2^-18 in all, and the total error is at most (k + 1) / 2 + 2^-18 <= (n +
# SETUP_ROUNDINGS) / 2 units.
#
# Cells. The interval crosses at most n cells of the axis, so a cell is at least 2^29 / n units long, and the error is
# at most (n + SETUP_ROUNDINGS) n / 2^30 cells.
#
# Positions. Before a crossing is converted to fixed point, it is computed from the origin's position x, in cells from
# the lattice's lower corner, which is at most MAX_ORIGIN_CELLS and a few more away: r1 to r3 are the roundings of the
# difference to that corner, of cells_per_unit and of their product; r4 and r10 are those of the difference to a face j,
# which is taken in two steps; r5 to r8 are those of inv_direction, of cell_size, of their product and of the product
# with it. The point where a ray is at the computed t of a hit is off the surface by at most HIT_ROUNDINGS of the largest
# coordinate of the distance, r9, of which the distance itself is at most sqrt(3): by 10.75 of the distance on a sphere
# (spheres.g); in a triangle by 5 across the ray for each sheared corner (a difference, the slope, its product and
# another difference), and by 3 along it (that of the depth, 1 / d and their product); by 3 on a plane. For insertion a
# triangle's plane and its cells take another 2^-22 cells. Together these are at most POSITION_ERROR_BOUND cells. An
# origin is at most MAX_ORIGIN_CELLS from the lattice's middle, and half of the lattice's cells are an eighth of that.

SETUP_ROUNDINGS = 2.0;
MAX_ORIGIN_CELLS = 2147483648.0;
HIT_ROUNDINGS = 18.7;
POSITION_ERROR_BOUND = 7.8e-6;

nextf = int<ne>(c * (1 + rc));
stepf = int<ne>(step * (1 + rs));
first_error = nextf - c;
f64_errors = rs * interval;

from = x * (1 + r1) * (1 + r2) * (1 + r3);
crossing = (j - from) * (1 + r4) * (1 + r10) * (1 + r5) * (1 + r6) * (1 + r7) * (1 + r8);
position_error = crossing - (j - x);
hit_error = r9 * (j - x);

{
  |c| <= 0x1p30 /\ |rc| <= 1b-51 /\ step in [0, 0x1p30] /\ |rs| <= 1b-50 /\ interval in [0, 0x1p29] /\
  x / MAX_ORIGIN_CELLS in [-1.125, 1.125] /\ (j - x) / MAX_ORIGIN_CELLS in [-1.125, 1.125] /\
  |r1| <= 1b-53 /\ |r2| <= 1b-53 /\ |r3| <= 1b-53 /\ |r4| <= 1b-53 /\ |r5| <= 1b-53 /\ |r6| <= 1b-53 /\
  |r7| <= 1b-53 /\ |r8| <= 1b-53 /\ |r10| <= 1b-53 /\
  r9 / HIT_ROUNDINGS in [-0x1.00001p-53, 0x1.00001p-53] /\ |inserted| <= 1b-22
->
  |first_error| <= 0x.80002p0 /\
  |stepf - step * (1 + rs)| <= 1b-1 /\
  |f64_errors| <= 1b-21 /\
  (0.5 + 1b-18) / SETUP_ROUNDINGS <= 0.5 /\
  |(position_error + hit_error + inserted) / POSITION_ERROR_BOUND| <= 0.99
}

nextf - c -> (nextf - c * (1 + rc)) + c * rc;
crossing - (j - x) -> (j - x) * ((1 + r4) * (1 + r10) * (1 + r5) * (1 + r6) * (1 + r7) * (1 + r8) - 1)
  - (from - x) * ((1 + r4) * (1 + r10) * (1 + r5) * (1 + r6) * (1 + r7) * (1 + r8));
from - x -> x * ((1 + r1) * (1 + r2) * (1 + r3) - 1);
