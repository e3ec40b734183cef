# The error of the computed determinant of a 3x3 matrix is at most 6 roundings of Hadamard's bound, so 16 tell what is singular.
#@ src/math/robust.rs SINGULAR_ROUNDINGS = 16.0
#@ src/math/robust.rs DETERMINANT_ROUNDINGS = 6.0
#@ src/math/robust.rs ENTRY_ROUNDINGS = 2.5
#
# With x, y and z for the columns, the determinant is z . (x x y): six products of three entries. In each of them, two
# entries are multiplied, the product is added to or subtracted from another product, the result is multiplied by
# the third entry, and that goes through at most two sums: five roundings, each a factor of 1 + r. So the error
# is at most the largest such factor less 1, times the sum of the absolute values of the products. That sum is the
# permanent of the absolute values, which is at most 3!/3^(3/2) < 1.1548 times the product of the columns' lengths
# (Carlen, Lieb, Loss, "An inequality of Hadamard type for permanents", Methods and Applications of Analysis 13,
# 2006).
#
# `sum` is that sum in units of Hadamard's bound. The columns are scaled to a largest entry between 1/2 and 1, so that
# Hadamard's bound is above 1/8, and the error due to underflow is below 2^-1000 of it: `lost` allows for much more.
#
# The entries are products of numbers of a scene. If the error of each entry is at most 2.5 roundings, the resulting
# error of the determinant is `given`. The last goal says that a matrix whose exact determinant is zero still passes
# as singular when both errors occur. `length` is the effect of rounding on the bound itself: three lengths of at most
# four roundings each, two products, and two more roundings in the comparison.

SINGULAR_ROUNDINGS = 16.0;
DETERMINANT_ROUNDINGS = 6.0;
ENTRY_ROUNDINGS = 2.5;
u = 1b-53;

computed = ((1 + r1) * (1 + r2) * (1 + r3) * (1 + r4) * (1 + r5) - 1) * sum + lost;
given = ((1 + e1) * (1 + e2) * (1 + e3) - 1) * sum;
found = SINGULAR_ROUNDINGS * u * (1 + length);

{ r1 in [-1b-53, 1b-53] /\ r2 in [-1b-53, 1b-53] /\ r3 in [-1b-53, 1b-53] /\ r4 in [-1b-53, 1b-53]
  /\ r5 in [-1b-53, 1b-53] /\ sum in [0, 1.1548] /\ lost in [-1b-900, 1b-900] /\ length in [-1b-48, 1b-48]
  /\ |e1| / (ENTRY_ROUNDINGS * u) in [0, 1] /\ |e2| / (ENTRY_ROUNDINGS * u) in [0, 1]
  /\ |e3| / (ENTRY_ROUNDINGS * u) in [0, 1]
  -> |computed| / (DETERMINANT_ROUNDINGS * u) in [0, 1]
  /\ found - |computed| - |given| >= 1b-53 }
