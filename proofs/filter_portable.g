# The filter in f32, with separate multiplications and additions, is off by no more than its error bounds.
#@ src/grid/triangle8.rs EDGE_ROUNDINGS = 37.0
#@ src/grid/triangle8.rs AREA_ROUNDINGS = 67.0
#@ src/grid/triangle8.rs DEPTH_ROUNDINGS = 113.5
#@ src/grid/filter.rs MAX_DEPTH = 2.5
#
# Names are those of src/grid/filter.rs; a trailing f marks what is computed in f32, and r is 2^-24.
#
# Scaling. All coordinates of corners and of the ray's origin are divided by c, a power of two from 1 to 4,
# which changes no rounding: then all are at most 1, and t, too, is at most MAX_DEPTH. What stands behind an edge,
# u, v, w, n, det and n.s, is divided by b, or b^2, which need not be a power of two; so their roundings are
# modelled by a relative error of their own each, re, rn, rq, ru, rd, rs, ra, rb, rp, of at most r, and not by the
# distance of floats there. Goals then are multiples of r b c, r b^2 and r b^2 c.
#
# Underflow. A relative error is no model of numbers below 2^-126: there storing or multiplying adds up to 2^-150.
# Counted with their factors those are at most 36 for w (12 for each edge, which q multiplies, and 3 for its
# products; 3 for n and 3 for its products) and 32 for n.s - t det: below 2^-144, while the source adds 2^-126.
# Sums that underflow are exact. Where det is certain it exceeds 2^-126.
#
# What is given:
# - s, ds, df, dd, pq and dfar: differences to the origin, directions, what the roundings of the products of q
#   change, and the rounding of the farthest t; see filter_stored.g, which proves them.
# - e, g are the edges, |ef| <= b = 1; the edge is computed in f64 with one rounding, then stored. Of v the same
#   is true as of u. n is the cross product in f64, off by 8 * 2^-53 + 2nd order: m, |m| <= 2^-49.
# - The determinant of three rows of numbers of at most 1 is at most 4, since it is linear in each number, so
#   that it is largest where all are 1 or -1; there the cross product of two rows is (2, 2, 0) but for order and
#   signs, or zero, so that n.x is at most twice the sum of the two largest bounds of x. The hypotheses on of_s,
#   of_d, det_sum and depth_sum are that, with the bounds of ds and dd, and those of x, y and z, which are goals.
# - So is the one on of_sum: with p from the first corner to where the ray meets the triangle's plane, s = t d - p
#   and q = p x d; and in a triangle no coordinate of p exceeds b.
# - Hits have 0 <= u + v <= det and 0 <= w <= det, if signs are turned so that det is positive.
# - t is what the test in f64 finds, in the frame's units; t_error is what it, and what the source makes in f64 of
#   these numbers, is off: a sheared vertex by 5 * 2^-53 * 2^20, at most 32 times 2 times that in t, since it is
#   refined in twice the digits where the area is smaller; 0.7 r, and the sum with entry far less. Below 2 r.
#
# What follows.
# - Rejected means missed. If a hit's det has the right sign, u, v >= -u_error, w >= -(w_edges + w_area),
#   n.s >= -depth_error - t_error det, and farthest det - n.s is before times at most 1 + r below zero. If the sign
#   is wrong, det is within det_error of zero, 18 r b^2; so u and v turned the wrong way are at least -u_error
#   - det_error, w at least -(u_error + v_error), n.s at least -depth_error - t det_error, and the last one is
#   at least n.s >= -depth_error: all within the bounds.
# - Certain means hit. Let u, v and w as computed all exceed their bound B, 37 r b c + 67 r b^2. Then u + v is
#   below det, so that w's roundings are those of numbers below det as for a hit; and det, their sum, exceeds
#   3 B - 18 r b^2 > 183 r b^2 and has the sign that it was found to have. Let N be how much the true negative ones
#   among u / det, v / det and w / det come to together: then p is at most (1 + 2 N) b, and as of_sum grows with p,
#   each of u, v, w errs by no more than B + 40 r b^2 * 2 N. As two at most are negative, N <= 160 N r b^2 / det < N,
#   unless N is zero. The depth comparisons exceed their bounds, so t lies on the ray, before the farthest.
# - Verdict::depths are below and above t: (n.s -+ bound) / det with two roundings, times det, minus t det, is
#   depths -+ bound, and its sign is that of -+ bound.

EDGE_ROUNDINGS = 37.0;
AREA_ROUNDINGS = 67.0;
DEPTH_ROUNDINGS = 113.5;
MAX_DEPTH = 2.5;

# Stored numbers, as they are off by what filter_stored.g proves.
sf0 = s0 + ds0; df0 = dt0 + dd0;
sf1 = s1 + ds1; df1 = dt1 + dd1;
sf2 = s2 + ds2; df2 = dt2 + dd2;

# q = d x s: with the stored numbers, and the true one.
qe0 = df1 * sf2 - df2 * sf1;
q0 = dt1 * s2 - dt2 * s1;
qe1 = df2 * sf0 - df0 * sf2;
q1 = dt2 * s0 - dt0 * s2;
qe2 = df0 * sf1 - df1 * sf0;
q2 = dt0 * s1 - dt1 * s0;

# u = e.q, where q is (qe - pq) (1 + rq): what the roundings make of each product, and the parts of the error.
e0 = ef0 * (1 + re0); tu0 = (1 + rq0) * (1 + ru0) * (1 + ru3) * (1 + ru4); x0 = ef0 * (tu0 - 1 - re0);
e1 = ef1 * (1 + re1); tu1 = (1 + rq1) * (1 + ru1) * (1 + ru3) * (1 + ru4); x1 = ef1 * (tu1 - 1 - re1);
e2 = ef2 * (1 + re2); tu2 = (1 + rq2) * (1 + ru2) * (1 + ru4); x2 = ef2 * (tu2 - 1 - re2);
u = e0 * (dt1 * s2 - dt2 * s1) + e1 * (dt2 * s0 - dt0 * s2) + e2 * (dt0 * s1 - dt1 * s0);
uf = ef0 * (qe0 - pq0) * tu0 + ef1 * (qe1 - pq1) * tu1 + ef2 * (qe2 - pq2) * tu2;
of_products = -(ef0 * tu0 * pq0 + ef1 * tu1 * pq1 + ef2 * tu2 * pq2);
of_sum = q0 * x0 + q1 * x1 + q2 * x2;
of_second = (qe0 - q0) * x0 + (qe1 - q1) * x1 + (qe2 - q2) * x2;
of_s = e0 * (df1 * ds2 - df2 * ds1) + e1 * (df2 * ds0 - df0 * ds2) + e2 * (df0 * ds1 - df1 * ds0);
of_d = e0 * (dd1 * s2 - dd2 * s1) + e1 * (dd2 * s0 - dd0 * s2) + e2 * (dd0 * s1 - dd1 * s0);
u_edges = of_products + of_second + of_s + of_d;
u_error = u_edges + of_sum;

# det = n.d and n.s.
td0 = (1 + rd0) * (1 + rd3) * (1 + rd4); y0 = (1 + rn0) * td0 * df0 - dt0;
ts0 = (1 + rs0) * (1 + rs3) * (1 + rs4); z0 = (1 + rn0) * ts0 * sf0 - s0;
td1 = (1 + rd1) * (1 + rd3) * (1 + rd4); y1 = (1 + rn1) * td1 * df1 - dt1;
ts1 = (1 + rs1) * (1 + rs3) * (1 + rs4); z1 = (1 + rn1) * ts1 * sf1 - s1;
td2 = (1 + rd2) * (1 + rd4); y2 = (1 + rn2) * td2 * df2 - dt2;
ts2 = (1 + rs2) * (1 + rs4); z2 = (1 + rn2) * ts2 * sf2 - s2;
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
# w = det - (u + v) has one part that grows with b c and one that grows with b^2.
w_edges = (u_edges + v_edges) * (1 + ra) * (1 + rb);
w_area = (of_sum + v_of_sum) * (1 + ra) * (1 + rb) + det_error * (1 + rb) + (w * rb - uv * (ra + ra * rb));

# The farthest t, and what is tested and given for a t whose right value, times det, is n.s.
before = dfar * (1 + rp) * (det + det_error) + far * rp * (det + det_error) + far * det_error - depth_error - t_error * det;
depths = (depth_error - t * det_error) + (t * (det + det_error) + (depth_error - t * det_error) - bound) * (ra + rb + ra * rb)
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
|v_edges| <= 37b-25 /\
w in [0,4.0625] /\
uv in [0,4.0625] /\
|det| <= 0x1.00001p2 /\
far / MAX_DEPTH in [-1, 1] /\
|dfar| <= 0x2.0004p-24 /\
t / MAX_DEPTH in [-1, 1] /\
|t_error| <= 1b-23 /\
bound in [0, 0x1p-17] /\
|rp| <= 1b-24
->
|x0| <= 329728b-40 /\
|y0| <= 296960b-40 /\
|z0| <= 657408b-40 /\
|x1| <= 329728b-40 /\
|y1| <= 296960b-40 /\
|z1| <= 657408b-40 /\
|x2| <= 264192b-40 /\
|y2| <= 231424b-40 /\
|z2| <= 526336b-40 /\
|u_edges| <= 37b-25 /\
|w_edges / EDGE_ROUNDINGS| <= 0x.fffp-24 /\
|w_area / AREA_ROUNDINGS| <= 0x.fffp-24 /\
|before / DEPTH_ROUNDINGS| <= 0x.fffp-24 /\
|depths / DEPTH_ROUNDINGS| <= 0x.fffp-24 /\
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
