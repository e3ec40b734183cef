# The t of two flat surfaces that are not united tell which one is nearer, from as far as 2^39 times their coordinates.
#@ src/world/coincidence.rs WRITTEN_ROUNDINGS = 4.0
#
# With point = o + t d at some t near that of the hit, the height over a surface is computed in double-double arithmetic, the
# relative error of whose operations is below e = 2^-100 (src/math/double_double.rs):
#   for a plane     n . point - c,          for a triangle  n . (point - a).
# Each term of the sum goes through the product t d_k, the sum with o_k, for a triangle the difference from a_k, the product
# with n_k, and at most three sums: seven roundings. The normal of a triangle, (b - a) x (c - a), has two more, of a product
# and a difference; its edges are exact. So the height is off by at most (1 + e)^9 - 1 < 10 e times `size`, the sum of the
# absolute values of the terms, in which the normal's products are unsigned, too.
#
# The t is t - height / slope. The slope n . d has at most seven roundings of the sum of its terms' absolute values, the
# quotient one and the difference one: less than 10 e together. They count with the height, which is at most 2^-20 of t
# times the slope where t is within what is looked through (PER_T in src/world/coincidence.rs), and so with 2^-20 of `size`.
#
# Times the slope, which is at most 1, each t is so off by `error`. The unit is the size of the surfaces' coordinates. The
# origin and the way t d are at most 2^39, so that `size` is below 2^41 for a unit normal, and the t of triangles that count
# as the same differ by at most 2^-92 (SAME_T in src/world/coincidence.rs) of 2^40. Surfaces that are not united are at
# least somewhere farther apart than WRITTEN_ROUNDINGS roundings, which exceeds both errors and that.

WRITTEN_ROUNDINGS = 4.0;
u = 1b-53;

error = of_height * size + of_step * (part * size);
apart = WRITTEN_ROUNDINGS * u;

{ |of_height| <= 10b-100 /\ |of_step| <= 10b-100 /\ part in [-1b-20, 1b-20] /\ size in [0, 1b41]
  /\ same in [0, 1b-52]
  -> apart - 2 * |error| - same >= 0 }
