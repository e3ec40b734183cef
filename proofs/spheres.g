# A sphere is inserted into every cell where a ray may find it, although roundings move its surface.
#@ src/caster/insertion.rs SPHERE_ROUNDINGS = 64.0
#
# All lengths are in units of the radius r, and errors in units of u; f is the vector from the centre to the ray's
# origin. A point that the sphere's test finds is off the surface by some u r, plus an error that is proportional to the
# distance of the origin from the surface, which dda.g counts. A cell within whose padding it lies is listed if the
# distance from the sphere's centre to the cell's is at most r (1 + SPHERE_ROUNDINGS u) and half of the padded diagonal.
#
# The test. If d is the direction and t a root that is off by e, then |o + t d - c|^2 - r^2 is off by 2 sqrt(a disc) e,
# and the distance from the surface by half of that over r, where sqrt(a disc) = |d| r cos i, and i is the angle between
# the ray and the sphere's normal.
# - disc = r^2 - |nearest|^2 has 7 roundings of r^2 (two squares, of which one has two sums and is of coordinates that are
#   sums, and the difference). nearest is off by f's own rounding and that of a product, and by 7 roundings of f along d, whose square counts: where disc is
#   not computed in double-double arithmetic, |disc| > 64 u r |f|, so |f| is below r / (37 u) and 49 u^2 f^2 is below
#   2 * 0.67 u r |f|. Together 3.5 r + 2.7 |f|. Both roots pass on at most that. |nearest| = r sin i, so that the product's
#   part is |f| sin i.
# - c = f^2 - r^2 has 5 roundings of f^2 or r^2, where it is not computed in double-double arithmetic. For |f| <= 2 r,
#   c / q is off so that the distance is 5 f^2 / (2 r) at most.
# - b = -f.d has 3 roundings of |f| |d|. With q at least sqrt(a disc) the distance is 3 |f| t |d| / r, and t |d| <= |f| + r.
# - sqrt(a disc), the sum, and the division have 2 (of a and the product) + 1 + 1 + 1 roundings of t |d|.
#
# For |f| > 2 r let h = |f| - r be the distance from the surface.
# - The errors of c are 3 f^2 + r^2 + c = 4 c + 4 r^2, so 4 + 4 r^2 / c of t. Those of b and the root are 3 b and 3 sqrt(a
#   disc), together 3 of q, so 3 of t, and the sum and the division are 2 more. The distance from the surface is
#   t |d| cos i times these. f^2 = t^2 d^2 + r^2 + 2 t |d| r cos i and t |d| >= h make t |d| cos i at most h, so that the
#   second part of c is at most 4 r^2 / (|f| + r) < 1.34 r. The other root, q / a, has the 3 of a in place of
#   the 4 of c and is farther by 2 r at most.
# - Together with the product's part this is t |d| (9 cos i + sin i) + r <= 9.06 (h + r) + r, as t |d| <= |f| <= h + r.
# - f's own rounding, as a whole, and the 0.67 above are 1.67 (h + r).
# The part in h is `far`, counted in dda.g, and that in r, with another 2 * 9 for the other root, is `far_r`.
#
# Insertion. The distance has 3 roundings (of the differences, of their squares and sums, and of the root, by half), and the
# sum with which it is compared 2. Their parts in the size of a cell are below the half unit of fixed-point t per cell by
# which the source's bound on the crossing exceeds the error (see dda.g).
SPHERE_ROUNDINGS = 64.0;
disc_r = 3.5; disc_f = 2.7;
close = disc_r + disc_f * 2 + 5 * 2 + 3 * 2 * 3 + 5 * 3;
ALONG = 9.06;
far = ALONG + 1.67;
far_r = disc_r + 1.34 + ALONG + 1 + 1.67 + 2 * 9;
insertion = 3 + 2;

{ (close + insertion) * 1.0001 / SPHERE_ROUNDINGS <= 1
/\ (far_r + insertion) * 1.0001 / SPHERE_ROUNDINGS <= 1
/\ ALONG * ALONG >= 82
/\ far * 1.0001 <= 10.75
/\ 10.75 * 1.73206 <= 18.7
/\ 3 * 1b-53 <= 1b-30 }
