# The errors of the filter in f32, with separate multiplications and additions, are within its error bounds.
#@ src/caster/block.rs EDGE_ROUNDINGS = 37.0
#@ src/caster/block.rs AREA_ROUNDINGS = 67.0
#@ src/caster/block.rs DEPTH_ROUNDINGS = 82.0
#@ src/caster/block.rs NORMAL_ROUNDINGS = 4.5
#@ src/caster/filter.rs MAX_DEPTH = 2.03125
#
# The names are those of src/caster/filter.rs. A trailing f marks what is computed in f32, and r is 2^-24.
#
# Sums of three products are computed from the third one on, so that the first is rounded twice, and the others three
# times: as a product, and in the sums.
#
# Scaling. All coordinates of corners and of the ray's origin are at most 1, and t is at most MAX_DEPTH. Edges and what
# is computed from them, u, v, w, n, det and n.s, are divided by b or b^2, which need not be powers of two. Hence their
# roundings are modelled by relative errors of their own, re, rn, rq, ru, rd, rs, ra, rb and rp, of at most r, instead
# of by the spacing of floats. The goals are multiples of r b, r b^2 and, for `normal`, r b^3.
#
# Underflow. A relative error does not model numbers below 2^-126: there, storing or multiplying adds an error of up
# to 2^-150. Counted with their factors, these errors are at most 36 for w (12 for each edge, which q multiplies, and
# 3 for its products; 3 for n and 3 for its products) and 32 for n.s - t det. That is less than 2^-144, while the
# source allows for 2^-126. Sums that underflow are exact. Where det is certain, it exceeds 2^-126.
#
# Hypotheses.
# - s, ds, df, dd, pq and dfar are the differences to the origin, the directions, the change of q due to the roundings
#   of its products, and the rounding of the maximum depth. filter_stored.g proves their bounds.
# - e and g are the edges, and |ef| <= b = 1. An edge is computed in f64 with one rounding, and then stored. What
#   holds for u holds for v. n is the cross product in f64, with an error m of 8 * 2^-53 plus terms of second order:
#   |m| <= 2^-49.
# - The determinant of three rows of numbers of at most 1 is at most 4: it is linear in each number, so the maximum is
#   reached when all are 1 or -1. Then the cross product of two rows is, up to order and signs, (2, 2, 0) or zero.
#   Hence n.x is at most twice the sum of the two largest bounds of x. The hypotheses on of_s, of_d, det_sum,
#   depth_sum, of_det, of_depth and normal_sum follow from this, from the bounds of ds, dd, rn and p, and from those of
#   x, y, z, dy and sz, which are goals.
# - The hypothesis on of_sum follows in the same way. With p the vector from the first corner to the point where the
#   ray meets the triangle's plane, s = t d - p and q = p x d; and in a triangle no coordinate of p exceeds that of an
#   edge, which the rounding of a stored edge may have made larger than b. normal_b2 is `normal` in units of b^2:
#   up to twice as much, since b <= 2.
# - Hits have 0 <= u + v <= det and 0 <= w <= det, if all quantities are negated where det is negative.
# - t is the result of the test in f64, in units of the frame. t_error is its error, together with that of the f64
#   arithmetic on the filter's results: a sheared vertex has an error of 5 * 2^-53 * 2^20, which causes one of at most
#   32 times 2 times that in t, since t is computed from exact determinants if the area is smaller. That is 0.63 r;
#   the sum with entry adds far less. The total is below r.
#
# Conclusions.
# - A rejected triangle is missed. For a hit, if the computed det has the right sign, then u, v >= -u_error, w >=
#   -(w_edges + w_area), n.s >= -depth_error - t_error det, and max_depth det - n.s is at least minus the error
#   `before` and `normal`, times at most 1 + r. If the sign is wrong, det is within det_error of zero, 18 r b^2; so the negated u
#   and v are at least -u_error - det_error, w is at least -(u_error + v_error), n.s is at least -depth_error - t
#   det_error, as the last goal says in roundings, and the last one is at least n.s >= -depth_error. All of these are
#   within the bounds.
# - A certain hit is a hit. Let u, v and w as computed all exceed their bound B, 37 r b + 67 r b^2. Then u + v is
#   below det, so that w's roundings are those of numbers below det, as for a hit; and det, which is their sum,
#   exceeds 3 B - 18 r b^2 > 183 r b^2 and has the sign that was computed. Let N be the absolute value of the sum of
#   the negative ones among the exact u / det, v / det and w / det. Then p is at most (1 + 2 N) b, and since of_sum
#   grows with p, the error of each of u, v and w is at most B + 40 r b^2 * 2 N. As at most two of them are negative,
#   N <= 160 N r b^2 / det < N, unless N is zero. The depth comparisons exceed their bounds, so t lies on the ray,
#   before the maximum depth.
# - Verdict::depths are a lower and an upper bound on t: (n.s -+ bound) / det with two roundings, times det, minus t
#   det, is depths -+ bound, and its sign is that of -+ bound.

EDGE_ROUNDINGS = 37.0;
AREA_ROUNDINGS = 67.0;
DEPTH_ROUNDINGS = 82.0;
NORMAL_ROUNDINGS = 4.5;
MAX_DEPTH = 2.03125;

# The stored numbers, whose errors filter_stored.g bounds.
sf0 = s0 + ds0; df0 = dt0 + dd0;
sf1 = s1 + ds1; df1 = dt1 + dd1;
sf2 = s2 + ds2; df2 = dt2 + dd2;

# q = d x s: from the stored numbers, and the exact one.
qe0 = df1 * sf2 - df2 * sf1;
q0 = dt1 * s2 - dt2 * s1;
qe1 = df2 * sf0 - df0 * sf2;
q1 = dt2 * s0 - dt0 * s2;
qe2 = df0 * sf1 - df1 * sf0;
q2 = dt0 * s1 - dt1 * s0;

# u = e.q, where q is (qe - pq) (1 + rq): the factors that roundings contribute to each product, and the parts of the
# error.
e0 = ef0 * (1 + re0); tu0 = (1 + rq0) * (1 + ru0) * (1 + ru4); x0 = ef0 * (tu0 - 1 - re0);
e1 = ef1 * (1 + re1); tu1 = (1 + rq1) * (1 + ru1) * (1 + ru3) * (1 + ru4); x1 = ef1 * (tu1 - 1 - re1);
e2 = ef2 * (1 + re2); tu2 = (1 + rq2) * (1 + ru2) * (1 + ru3) * (1 + ru4); x2 = ef2 * (tu2 - 1 - re2);
u = e0 * (dt1 * s2 - dt2 * s1) + e1 * (dt2 * s0 - dt0 * s2) + e2 * (dt0 * s1 - dt1 * s0);
uf = ef0 * (qe0 - pq0) * tu0 + ef1 * (qe1 - pq1) * tu1 + ef2 * (qe2 - pq2) * tu2;
of_products = -(ef0 * tu0 * pq0 + ef1 * tu1 * pq1 + ef2 * tu2 * pq2);
of_sum = q0 * x0 + q1 * x1 + q2 * x2;
of_second = (qe0 - q0) * x0 + (qe1 - q1) * x1 + (qe2 - q2) * x2;
of_s = e0 * (df1 * ds2 - df2 * ds1) + e1 * (df2 * ds0 - df0 * ds2) + e2 * (df0 * ds1 - df1 * ds0);
of_d = e0 * (dd1 * s2 - dd2 * s1) + e1 * (dd2 * s0 - dd0 * s2) + e2 * (dd0 * s1 - dd1 * s0);
u_edges = of_products + of_second + of_s + of_d;
u_error = u_edges + of_sum;

# det = n.d, and n.s.
td0 = (1 + rd0) * (1 + rd4); y0 = (1 + rn0) * td0 * df0 - dt0;
ts0 = (1 + rs0) * (1 + rs4); z0 = (1 + rn0) * ts0 * sf0 - s0;
td1 = (1 + rd1) * (1 + rd3) * (1 + rd4); y1 = (1 + rn1) * td1 * df1 - dt1;
ts1 = (1 + rs1) * (1 + rs3) * (1 + rs4); z1 = (1 + rn1) * ts1 * sf1 - s1;
td2 = (1 + rd2) * (1 + rd3) * (1 + rd4); y2 = (1 + rn2) * td2 * df2 - dt2;
ts2 = (1 + rs2) * (1 + rs3) * (1 + rs4); z2 = (1 + rn2) * ts2 * sf2 - s2;
det = n0 * dt0 + n1 * dt1 + n2 * dt2;
detf = (n0 + m0) * (1 + rn0) * df0 * td0 + (n1 + m1) * (1 + rn1) * df1 * td1 + (n2 + m2) * (1 + rn2) * df2 * td2;
det_sum = n0 * y0 + n1 * y1 + n2 * y2;
det_m = m0 * (1 + rn0) * df0 * td0 + m1 * (1 + rn1) * df1 * td1 + m2 * (1 + rn2) * df2 * td2;
det_error = det_sum + det_m;
ns = n0 * s0 + n1 * s1 + n2 * s2;
depthf = (n0 + m0) * (1 + rn0) * sf0 * ts0 + (n1 + m1) * (1 + rn1) * sf1 * ts1 + (n2 + m2) * (1 + rn2) * sf2 * ts2;
depth_sum = n0 * z0 + n1 * z1 + n2 * z2;
depth_m = m0 * (1 + rn0) * sf0 * ts0 + m1 * (1 + rn1) * sf1 * ts1 + m2 * (1 + rn2) * sf2 * ts2;
depth_error = depth_sum + depth_m;
# The error of w = det - (u + v) has a part proportional to b and a part proportional to b^2.
w_edges = (u_edges + v_edges) * (1 + ra) * (1 + rb);
w_area = (of_sum + v_of_sum) * (1 + ra) * (1 + rb) + det_error * (1 + rb) + (w * rb - uv * (ra + ra * rb));

# n.s - t det, where the exact n.(s - t d) is zero, and s - t d is -p. The error of the stored n is multiplied by p,
# which is in units of b, so this part is in units of r b^3. The others are relative to the errors z and y without it.
dn0 = n0 * rn0 + m0 * (1 + rn0); sz0 = ts0 * sf0 - s0; dy0 = td0 * df0 - dt0;
dn1 = n1 * rn1 + m1 * (1 + rn1); sz1 = ts1 * sf1 - s1; dy1 = td1 * df1 - dt1;
dn2 = n2 * rn2 + m2 * (1 + rn2); sz2 = ts2 * sf2 - s2; dy2 = td2 * df2 - dt2;
normal_sum = n0 * rn0 * p0 + n1 * rn1 * p1 + n2 * rn2 * p2;
normal = normal_sum + (m0 * (1 + rn0) * p0 + m1 * (1 + rn1) * p1 + m2 * (1 + rn2) * p2);
of_depth = n0 * sz0 + n1 * sz1 + n2 * sz2;
of_det = n0 * dy0 + n1 * dy1 + n2 * dy2;
apart = of_depth - t * of_det + (dn0 * (sz0 - t * dy0) + dn1 * (sz1 - t * dy1) + dn2 * (sz2 - t * dy2));
# The test against the maximum depth, and the bounds of Verdict::depths, without `normal`.
before = dfar * (1 + rp) * (det + det_error) + far * rp * (det + det_error) - apart - t_error * (det + det_error);
depths = apart + (t * (det + det_error) + (apart - normal_b2) - bound) * (ra + rb + ra * rb)
  - t_error * (det + det_error);

{
|sf0| <= 2 /\
|s0| <= 0x1.00000008p1 /\
|ds0| <= 132096b-40 /\
|df0| <= 1 /\
|dt0| <= 1 /\
|dd0| <= 33792b-40 /\
|pq0| <= 2b-24 /\
|ef0| <= 1 /\
|re0| <= 0x1.00000002p-24 /\
|n0| <= 0x1.00001p1 /\
|m0| <= 1b-49 /\
|rn0| <= 1b-24 /\
|sf1| <= 2 /\
|s1| <= 0x1.00000008p1 /\
|ds1| <= 132096b-40 /\
|df1| <= 1 /\
|dt1| <= 1 /\
|dd1| <= 33792b-40 /\
|pq1| <= 2b-24 /\
|ef1| <= 1 /\
|re1| <= 0x1.00000002p-24 /\
|n1| <= 0x1.00001p1 /\
|m1| <= 1b-49 /\
|rn1| <= 1b-24 /\
|sf2| <= 2 /\
|s2| <= 0x1.00000008p1 /\
|ds2| <= 132096b-40 /\
|df2| <= 1 /\
|dt2| <= 1 /\
|dd2| <= 33792b-40 /\
|pq2| <= 2b-24 /\
|ef2| <= 1 /\
|re2| <= 0x1.00000002p-24 /\
|n2| <= 0x1.00001p1 /\
|m2| <= 1b-49 /\
|rn2| <= 1b-24 /\
|ru0| <= 1b-24 /\
|ru1| <= 1b-24 /\
|ru2| <= 1b-24 /\
|ru3| <= 1b-24 /\
|ru4| <= 1b-24 /\
|rd0| <= 1b-24 /\
|rd1| <= 1b-24 /\
|rd2| <= 1b-24 /\
|rd3| <= 1b-24 /\
|rd4| <= 1b-24 /\
|rs0| <= 1b-24 /\
|rs1| <= 1b-24 /\
|rs2| <= 1b-24 /\
|rs3| <= 1b-24 /\
|rs4| <= 1b-24 /\
|rq0| <= 1b-24 /\
|rq1| <= 1b-24 /\
|rq2| <= 1b-24 /\
|ra| <= 1b-24 /\
|rb| <= 1b-24 /\
|of_sum| <= 1318914b-40 /\
|v_of_sum| <= 1318914b-40 /\
|of_s| <= 528385b-40 /\
|of_d| <= 270337b-40 /\
|det_sum| <= 1187842b-40 /\
|depth_sum| <= 2629635b-40 /\
|p0| <= 0x1.00001p0 /\
|p1| <= 0x1.00001p0 /\
|p2| <= 0x1.00001p0 /\
|normal_sum| <= 0x4.0001p-24 /\
|normal_b2| <= 0x8.01p-24 /\
|of_depth| <= 2105346b-40 /\
|of_det| <= 925698b-40 /\
|v_edges| <= 37b-25 /\
w in [0,4.0625] /\
uv in [0,4.0625] /\
|det| <= 0x1.00001p2 /\
far / MAX_DEPTH in [-1, 1] /\
|dfar| <= 0x2.0004p-24 /\
t / MAX_DEPTH in [-1, 1] /\
|t_error| <= 1b-24 /\
bound in [0, 0x1p-17] /\
|rp| <= 1b-24
->
|sz0| <= 395264b-40 /\
|dy0| <= 165888b-40 /\
|sz1| <= 526336b-40 /\
|dy1| <= 231424b-40 /\
|sz2| <= 526336b-40 /\
|dy2| <= 231424b-40 /\
|x0| <= 264192b-40 /\
|y0| <= 231424b-40 /\
|z0| <= 526336b-40 /\
|x1| <= 329728b-40 /\
|y1| <= 296960b-40 /\
|z1| <= 657408b-40 /\
|x2| <= 329728b-40 /\
|y2| <= 296960b-40 /\
|z2| <= 657408b-40 /\
|u_edges| <= 37b-25 /\
|w_edges / EDGE_ROUNDINGS| <= 0x.fffp-24 /\
|w_area / AREA_ROUNDINGS| <= 0x.fffp-24 /\
|before / DEPTH_ROUNDINGS| <= 0x.fffp-24 /\
|depths / DEPTH_ROUNDINGS| <= 0x.fffp-24 /\
|normal / NORMAL_ROUNDINGS| <= 0x.fffp-24 /\
(MAX_DEPTH * 19 + 41) / DEPTH_ROUNDINGS <= 0.999 /\
|uf - u| <= 41b-24 /\
|detf - det| <= 19b-24 /\
|depthf - ns| <= 41b-24
}
qe0 - q0 -> (df1 * ds2 + dd1 * s2) - (df2 * ds1 + dd2 * s1);
qe1 - q1 -> (df2 * ds0 + dd2 * s0) - (df0 * ds2 + dd0 * s2);
qe2 - q2 -> (df0 * ds1 + dd0 * s1) - (df1 * ds0 + dd1 * s0);
uf - u -> u_error;
detf - det -> det_error;
depthf - ns -> depth_error;
(1 + rn0) * td0 * df0 - dt0 -> df0 * ((1 + rn0) * td0 - 1) + dd0;
(1 + rn0) * ts0 * sf0 - s0 -> sf0 * ((1 + rn0) * ts0 - 1) + ds0;
(1 + rn1) * td1 * df1 - dt1 -> df1 * ((1 + rn1) * td1 - 1) + dd1;
(1 + rn1) * ts1 * sf1 - s1 -> sf1 * ((1 + rn1) * ts1 - 1) + ds1;
(1 + rn2) * td2 * df2 - dt2 -> df2 * ((1 + rn2) * td2 - 1) + dd2;
(1 + rn2) * ts2 * sf2 - s2 -> sf2 * ((1 + rn2) * ts2 - 1) + ds2;
ts0 * sf0 - s0 -> sf0 * (ts0 - 1) + ds0;
td0 * df0 - dt0 -> df0 * (td0 - 1) + dd0;
ts1 * sf1 - s1 -> sf1 * (ts1 - 1) + ds1;
td1 * df1 - dt1 -> df1 * (td1 - 1) + dd1;
ts2 * sf2 - s2 -> sf2 * (ts2 - 1) + ds2;
td2 * df2 - dt2 -> df2 * (td2 - 1) + dd2;
