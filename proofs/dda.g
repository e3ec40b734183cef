# The DDA's crossing times are off by no more than its error bound, for rays from up to 2^32 cells away.
#@ src/grid/dda.rs SETUP_ROUNDINGS = 2.0
#@ src/grid/build.rs MAX_ORIGIN_CELLS = 4294967296.0
#@ src/grid/fitting.rs POSITION_ERROR_BOUND = 1e-5
#
# Ticks. By definition t = entry + tick / per_tick, with the floats entry and per_tick, so that these two have no
# error. A face's true tick is c for the first face of an axis, and c + k step for the next ones. The source has the
# whole numbers nextf for the first one and stepf, off by at most 1/2 but for what f64 loses: rc and rs, relative to
# c, at most 2^30, and to the step. After k steps the tick is nextf + k stepf, a sum of whole numbers below 2^31
# and so without rounding: by induction off by k times the error of stepf more than nextf is. As the whole way has
# 2^29 ticks, k step <= 2^29; so the parts of f64 come to at most 2^-18 in all, and the tick is off by at most
# (k + 1) / 2 + 2^-18 <= (n + SETUP_ROUNDINGS) / 2.
#
# Cells. The way crosses at most n cells of the axis, so that one has at least 2^29 / n ticks, and the schedule is
# off by at most (n + SETUP_ROUNDINGS) n / 2^30 cells.
#
# Places. Before ticks are made of it, a crossing is computed from the origin's place x, in cells from the lattice's
# lower corner, up to MAX_ORIGIN_CELLS and a few from it: r1 to r3 are the roundings of the difference to that corner,
# of per_unit and of their product; r4 that of the difference to a face j; r5 to r8 those of inverse, cell_size,
# their product and the product with it. The t of a hit carries three such roundings of the way there, r9.
# Together that is POSITION_ERROR_BOUND of a cell at most.

SETUP_ROUNDINGS = 2.0;
MAX_ORIGIN_CELLS = 4294967296.0;
POSITION_ERROR_BOUND = 1e-5;

nextf = int<ne>(c * (1 + rc));
stepf = int<ne>(step * (1 + rs));
first_error = nextf - c;
f64_errors = rs * way;

from = x * (1 + r1) * (1 + r2) * (1 + r3);
crossing = (j - from) * (1 + r4) * (1 + r5) * (1 + r6) * (1 + r7) * (1 + r8);
place_error = crossing - (j - x);
hit_error = r9 * (j - x);

{
  |c| <= 0x1p30 /\ |rc| <= 1b-51 /\ step in [0, 0x1p30] /\ |rs| <= 1b-50 /\ way in [0, 0x1p29] /\
  x / MAX_ORIGIN_CELLS in [-1.125, 1.125] /\ j in [0, 0x1p29] /\
  |r1| <= 1b-53 /\ |r2| <= 1b-53 /\ |r3| <= 1b-53 /\ |r4| <= 1b-53 /\ |r5| <= 1b-53 /\ |r6| <= 1b-53 /\
  |r7| <= 1b-53 /\ |r8| <= 1b-53 /\ |r9| <= 0x1.8001p-52
->
  |first_error| <= 0x.80002p0 /\
  |stepf - step * (1 + rs)| <= 1b-1 /\
  |f64_errors| <= 1b-21 /\
  (0.5 + 1b-18) / SETUP_ROUNDINGS <= 0.5 /\
  |(place_error + hit_error) / POSITION_ERROR_BOUND| <= 1
}

nextf - c -> (nextf - c * (1 + rc)) + c * rc;
crossing - (j - x) -> (j - x) * ((1 + r4) * (1 + r5) * (1 + r6) * (1 + r7) * (1 + r8) - 1)
  - (from - x) * ((1 + r4) * (1 + r5) * (1 + r6) * (1 + r7) * (1 + r8));
from - x -> x * ((1 + r1) * (1 + r2) * (1 + r3) - 1);
