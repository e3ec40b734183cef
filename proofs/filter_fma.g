# The errors of the filter in f32, with fused multiply-add, are within its error bounds.
#@ src/caster/block.rs EDGE_ROUNDINGS = 37.0
#@ src/caster/block.rs AREA_ROUNDINGS = 67.0
#@ src/caster/block.rs DEPTH_ROUNDINGS = 82.0
#@ src/caster/block.rs NORMAL_ROUNDINGS = 4.5
#@ src/caster/filter.rs MAX_DEPTH = 2.03125
#
# The derivation is the same as in filter_portable.g, with two differences. In a sum of three products each of the first
# two is rounded together with the sum, so that the first is rounded once, the second twice, and the third three times.
# In a difference of two products only one product is rounded.

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
e0 = ef0 * (1 + re0); tu0 = (1 + rq0) * (1 + ru0); x0 = ef0 * (tu0 - 1 - re0);
e1 = ef1 * (1 + re1); tu1 = (1 + rq1) * (1 + ru1) * (1 + ru0); x1 = ef1 * (tu1 - 1 - re1);
e2 = ef2 * (1 + re2); tu2 = (1 + rq2) * (1 + ru2) * (1 + ru1) * (1 + ru0); x2 = ef2 * (tu2 - 1 - re2);
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
td0 = (1 + rd0); y0 = (1 + rn0) * td0 * df0 - dt0;
ts0 = (1 + rs0); z0 = (1 + rn0) * ts0 * sf0 - s0;
td1 = (1 + rd1) * (1 + rd0); y1 = (1 + rn1) * td1 * df1 - dt1;
ts1 = (1 + rs1) * (1 + rs0); z1 = (1 + rn1) * ts1 * sf1 - s1;
td2 = (1 + rd2) * (1 + rd1) * (1 + rd0); y2 = (1 + rn2) * td2 * df2 - dt2;
ts2 = (1 + rs2) * (1 + rs1) * (1 + rs0); z2 = (1 + rn2) * ts2 * sf2 - s2;
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
before = dfar * (det + det_error) - apart - t_error * (det + det_error);
depths = apart + (t * (det + det_error) + (apart - normal_b2) - bound) * (ra + rb + ra * rb)
  - t_error * (det + det_error);

{
|sf0| <= 2 /\
|s0| <= 0x1.00000008p1 /\
|ds0| <= 132096b-40 /\
|df0| <= 1 /\
|dt0| <= 1 /\
|dd0| <= 33792b-40 /\
|pq0| <= 1b-24 /\
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
|pq1| <= 1b-24 /\
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
|pq2| <= 1b-24 /\
|ef2| <= 1 /\
|re2| <= 0x1.00000002p-24 /\
|n2| <= 0x1.00001p1 /\
|m2| <= 1b-49 /\
|rn2| <= 1b-24 /\
|ru0| <= 1b-24 /\
|ru1| <= 1b-24 /\
|ru2| <= 1b-24 /\
|rd0| <= 1b-24 /\
|rd1| <= 1b-24 /\
|rd2| <= 1b-24 /\
|rs0| <= 1b-24 /\
|rs1| <= 1b-24 /\
|rs2| <= 1b-24 /\
|rq0| <= 1b-24 /\
|rq1| <= 1b-24 /\
|rq2| <= 1b-24 /\
|ra| <= 1b-24 /\
|rb| <= 1b-24 /\
|of_sum| <= 1187842b-40 /\
|v_of_sum| <= 1187842b-40 /\
|of_s| <= 528385b-40 /\
|of_d| <= 270337b-40 /\
|det_sum| <= 1056770b-40 /\
|depth_sum| <= 2367491b-40 /\
|p0| <= 0x1.00001p0 /\
|p1| <= 0x1.00001p0 /\
|p2| <= 0x1.00001p0 /\
|normal_sum| <= 0x4.0001p-24 /\
|normal_b2| <= 0x8.01p-24 /\
|of_depth| <= 1843202b-40 /\
|of_det| <= 794626b-40 /\
|v_edges| <= 31b-25 /\
w in [0,4.0625] /\
uv in [0,4.0625] /\
|det| <= 0x1.00001p2 /\
far / MAX_DEPTH in [-1, 1] /\
|dfar| <= 0x2.0004p-24 /\
t / MAX_DEPTH in [-1, 1] /\
|t_error| <= 1b-24 /\
bound in [0, 0x1p-17]
->
|sz0| <= 264192b-40 /\
|dy0| <= 100352b-40 /\
|sz1| <= 395264b-40 /\
|dy1| <= 165888b-40 /\
|sz2| <= 526336b-40 /\
|dy2| <= 231424b-40 /\
|x0| <= 198656b-40 /\
|y0| <= 165888b-40 /\
|z0| <= 395264b-40 /\
|x1| <= 264192b-40 /\
|y1| <= 231424b-40 /\
|z1| <= 526336b-40 /\
|x2| <= 329728b-40 /\
|y2| <= 296960b-40 /\
|z2| <= 657408b-40 /\
|u_edges| <= 31b-25 /\
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
