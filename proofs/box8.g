# A ray that hits something in a padded box is found to meet the box, not later than the hit.
#@ src/caster/box8.rs PADDING_ROUNDINGS = 16.0
#@ src/caster/filter.rs MAX_DEPTH = 2.03125
#
# Along an axis let l be the stored lower face, o and d > 0 the stored origin and direction of the ray, and t the depth of
# the exact hit; the other cases are mirror images. The depth of the face is computed as v = l i - o i, where e0 to e3 are
# the relative errors of the inverse i of d, of the product o i, of the difference and, without fused multiply-add, of the
# product l i. So
#
#   v d = (l (1 + e3) - o (1 + e1)) (1 + e0) (1 + e2),
#
# which is l - o and what is `moved` here. The exact hit is above the unpadded face, and the point of the stored ray at
# t is off by at most `ray`: one rounding of the origin, and one of the direction times t. The stored face is off by at
# most `face`: one rounding, and two more where the box ends at the corner of a cell. A direction of almost 0 counts as
# 2^-60, which is within the last digits of these bounds. Hence (t - v) d >= `left`. As d is at most 1 and its rounding,
# t - v is not less. The maximum depth is rounded by up to `last`, and no hit that counts is more than `last` before the
# depth 0, where the ray enters the frame's box.
r = 1b-24;
PADDING_ROUNDINGS = 16.0;
MAX_DEPTH = 2.03125;

moved = (l - o) * ((1 + e0) * (1 + e2) - 1) + (l * e3 - o * e1) * ((1 + e0) * (1 + e2));
face = face_roundings * r;
ray = ray_roundings * r;
last = last_roundings * r;
left = PADDING_ROUNDINGS * r - face - ray - moved;

{ l in [-1.00001, 1.00001] /\ o in [-1.00001, 1.00001]
/\ |e0| <= 1b-24 /\ |e1| <= 1b-24 /\ |e2| <= 1b-24 /\ |e3| <= 1b-24
/\ |face_roundings| <= 3.0001 /\ |ray_roundings| <= 3.0315 /\ |last_roundings| <= 2.0315
-> 1 + MAX_DEPTH <= 3.0315 /\ MAX_DEPTH <= 2.0315
/\ left - last >= 1b-24 }
