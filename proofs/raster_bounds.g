# A triangle's bounds on the screen leave out no pixel whose ray hits it.
#@ src/fast/raster/triangle_bounds.rs MAX_STEEPNESS = 1024.0
#@ src/fast/raster/triangle_bounds.rs SCREEN_ROUNDINGS = 2.5
#@ src/fast/raster/triangle_bounds.rs EYE_ROUNDINGS = 31.0
#@ src/fast/raster/triangle_bounds.rs SCREEN_CLEARANCE = 0.9
#@ src/fast/raster/triangle_bounds.rs BEHIND_ROUNDINGS = 2.75
#@ src/fast/raster/triangle_bounds.rs SIDE_ROUNDINGS = 4.3
# Let D, R and U be the eye's direction and steps, A = R / |R|^2 the computed axis, p a point relative to the eye, S
# MAX_STEEPNESS and M the viewport's max_direction_length, which is at least |D| + |x R| + |y U| for every pixel, and at
# least 1. Hence |x| <= (M - 1) |A|, and so is the picture's half width. What holds for x and R holds for y and U. The point's
# screen coordinate is (p.A) / (p.D). Where p.D > 0, that of a point in a triangle lies between those of its corners.
# So two errors matter, the one of a point on a pixel's ray and the one of a corner. They are counted in units of u |A|.
#
# A pixel's ray. A point on it is a multiple of D + x R + y U + e with |e| <= 6 u M: the ray's direction has 5 roundings,
# and R another one. R.A is 1 up to 4 roundings (3 of the square, 1 of the division), and |D|^2 is 1 up to 9 (twice the
# 1.5 of the square, and 3 for the root, the reciprocal and the product). With c for the sum of the three cosines between
# D, R and U, the coordinate is off x by the following over p.D:
#   D.A, y U.A, x (x R.D + y U.D): at most c M^2 in all, since |x R| + |y U| <= M - 1;
#   x times R.A and |D|^2:         13 M;
#   e.A and x e.D:                 6 M + 6 M^2.
# p.D is at least 1 - c M and less than 2^-40, as |D| = 1. Where a view is rasterized, c (S + M) M |A| is below a
# SUBPIXELS-th, and M |A| exceeds 1, since it exceeds half the sum of the picture's sides; so c M < 1/64.
#
# A dot product p.V of a computed p, with T for the sum of its terms' magnitudes, T <= |p| |V|. Each term has a rounding
# of the difference and one of the product: 2 T. The sum of two terms is rounded, and that of all three. The sum of two
# is the result less the third term, so it is at most as large as the mean of T and the result: (T + |p.V|) / 2 and
# |p.V|. In all the error is 2.5 T + 1.5 |p.V|: where the result is close to zero, it is 2.5 T.
#
# A corner. p.A and p.D have the errors above, and |p| <= S p.D. A coordinate is at most half the picture's side, which is
# at most (M - 1) |A|. Divided by p.D, the error of p.A is 2.5 S + 1.5 (M - 1), and that of p.D is (M - 1) times 2.5 S +
# 1.5. The reciprocal and the product with it are 2 roundings of at most M - 1. The sum with the middle is one, of at
# most twice as much. This makes 2.5 S + (2.5 S + 7) (M - 1), which is less than (2.5 S + 7) M. A coordinate beyond the
# picture's side is computed beyond the last pixel, which is half a pixel closer to the middle.
#
# The cosines. Each is computed with 3 roundings of the product and 4.5 for each vector that is made a unit vector (2.5
# of the length, 1 of the reciprocal, 1 of the product), which R and U are: 12, 7.5 and 7.5. The sum of the cosines and
# the bound's other operations are 10 more roundings of the bound, which the clearance covers.
#
# The sum of all errors is compared with the source's bound, for the coefficients of M^2 (with c, to which the errors of
# the cosines are added) and of S M; in the latter S <= S M and M <= S M / S. SCREEN_CLEARANCE of a subpixel is left for the error, so that the error can be
# 1 / SCREEN_CLEARANCE times its bound.
#
# Behind the eye. The sign of p.D can be wrong only where the computed p.D is at most its error, which is then 2.5 |p|
# and second-order terms, for which 1.0001 leaves room; the length of p and the bound have at most 5 roundings of their
# own.
#
# Sides. A pixel's x is at least one less than `border`, b, which is exact; so a point on its ray, whose coordinate is off
# by less than a pixel, fulfils p.A < b p.D. If all corners of a triangle fulfil the opposite, no ray hits it. The
# comparison can be wrong only where both sides are v, up to their errors. p.A has an error of 2.5 |p| |A| + 1.5 v, and
# b p.D one of 2.5 b |p| + 1.5 v, one more rounding of v for the product and one for the sum with the bound: 5 v in all.
# A and D are at right angles up to the cosines, so that (v / |A|)^2 + (v / b)^2 <= |p|^2, and v is at most
# |p| |A| b / sqrt(|A|^2 + b^2). With r = b / |A| that is r / ((1 + r) sqrt(1 + r^2)) of |p| (|A| + b), which is largest for
# r = 1: 1 / sqrt(8). (The square is r^2 / ((1 + r)^2 (1 + r^2)), and 8 r^2 <= (1 + r)^2 (1 + r^2), since the
# factors are at least 4 r and 2 r.) |A|, |p|, |D| and the bound itself are off by at most 16 roundings.
u = 1b-53;
MAX_STEEPNESS = 1024.0;
SCREEN_ROUNDINGS = 2.5;
EYE_ROUNDINGS = 31.0;
SCREEN_CLEARANCE = 0.9;
BEHIND_ROUNDINGS = 2.75;
SIDE_ROUNDINGS = 4.3;

# The errors of a dot product in units of T and of the result, and `half` for (1 + u) / 2.
terms = e1 + e2 + e1 * e2 + e3 * half * (1 + 2 * u + u * u);
result = e3 * half + e4 * (1 + u);
# The errors of a side in units of |p| (|A| + b).
INV_SQRT8 = 0.35356;
side = |terms| + (2 * |result| + |e5 + e6 + u * u|) * INV_SQRT8 * 1.0001;

bound = (1 - u) * (1 - u) * (1 - u) * (1 - u) * (1 - u) * (1 - u) * (1 - u) * (1 - u)
      * (1 - u) * (1 - u) * (1 - u) * (1 - u) * (1 - u) * (1 - u) * (1 - u) * (1 - u);

# What p.D below 1 and the terms of second order do to the errors.
exceed = 1.0001 / (1 - 1b-6 - 1b-40);
cosines = 12 + 7.5 + 7.5;
needed_mm = (cosines + 6) * exceed;
needed_sm = (2.5 + (13 + 6 + 7) / MAX_STEEPNESS) * exceed;

{ (e1 in [-1b-53, 1b-53] /\ e2 in [-1b-53, 1b-53] /\ e3 in [-1b-53, 1b-53] /\ e4 in [-1b-53, 1b-53]
 /\ e5 in [-1b-53, 1b-53] /\ e6 in [-1b-53, 1b-53] /\ half in [0.4999, 0x0.80000000000008p0]
    -> |terms| / u <= 2.5000001
    /\ |result| / u <= 1.5000001
    /\ BEHIND_ROUNDINGS * u * bound - |terms| * 1.0001 >= 1b-58
    /\ SIDE_ROUNDINGS * u * bound - side * 1.0001 >= 1b-60)
/\ INV_SQRT8 * INV_SQRT8 >= 0.125
/\ needed_mm * SCREEN_CLEARANCE * 1.0001 / EYE_ROUNDINGS <= 1
/\ needed_sm * SCREEN_CLEARANCE * 1.0001 / SCREEN_ROUNDINGS <= 1
/\ exceed * SCREEN_CLEARANCE * 1.0001 <= 1 }
