# A triangle's bounds on the screen leave out no pixel whose ray hits it.
#@ src/raster/triangle_bounds.rs MAX_STEEPNESS = 1024.0
#@ src/raster/triangle_bounds.rs SCREEN_ROUNDINGS = 8.0
#@ src/raster/triangle_bounds.rs EYE_ROUNDINGS = 31.0
#@ src/raster/triangle_bounds.rs SCREEN_CLEARANCE = 0.9
#@ src/raster/triangle_bounds.rs BEHIND_ROUNDINGS = 5.0
#@ src/raster/triangle_bounds.rs SIDE_ROUNDINGS = 7.0
# Let D, R and U be the eye's direction and steps, A = R / |R|^2 the computed axis, p a point relative to the eye, S
# MAX_STEEPNESS and M the viewport's max_direction_length, which is at least |D| + |x R| + |y U| for every pixel, and at
# least 1. Hence |x| <= M |A|, and so is the picture's half width. What holds for x and R holds for y and U. The point's
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
# A corner. p.A has an error of 4 |p| |A| (a difference, a product, two sums), p.D one of 4 |p|, and |p| <= S p.D. The
# reciprocal, the product with it and the sum with the middle are 3 roundings of at most M |A|, and the middle is as
# large. This makes 4 S + 4 S M + 4 M. A coordinate beyond M |A| is computed beyond the last pixel, which is half a
# pixel closer to the middle.
#
# The cosines. Each is computed with 3 roundings of the product and 4.5 for each vector that is made a unit vector (2.5
# of the length, 1 of the reciprocal, 1 of the product), which R and U are: 12, 7.5 and 7.5. The sum of the cosines and
# the bound's other operations are 10 more roundings of the bound, which the clearance covers.
#
# The sum of all errors is compared with the source's bound, for the coefficients of M^2 (with c, to which the errors of
# the cosines are added) and of S M; in the latter S <= S M and M <= S M / S. SCREEN_CLEARANCE of a subpixel is left for the error, so that the error can be
# 1 / SCREEN_CLEARANCE times its bound.
#
# Behind the eye. p.D has an error of 4 |p|; the length of p and the bound have at most 5 roundings of their own.
#
# Sides. A pixel's x is at least one less than `border`, which is exact; so a point on its ray, whose coordinate is off
# by less than a pixel, fulfils p.A < border p.D. If all corners of a triangle fulfil the opposite, no ray hits it.
# p.A has an error of 4 |p| |A|. border p.D has the same 4, one of the product and one of the sum with the bound, times
# border |p| |D|. |A|, |p|, |D| and the bound itself are off by at most 16 roundings.
u = 1b-53;
MAX_STEEPNESS = 1024.0;
SCREEN_ROUNDINGS = 8.0;
EYE_ROUNDINGS = 31.0;
SCREEN_CLEARANCE = 0.9;
BEHIND_ROUNDINGS = 5.0;
SIDE_ROUNDINGS = 7.0;

f4 = (1 + e1) * (1 + e2) * (1 + e3) * (1 + e4);
f6 = f4 * (1 + e5) * (1 + e6);
bound = (1 - u) * (1 - u) * (1 - u) * (1 - u) * (1 - u) * (1 - u) * (1 - u) * (1 - u)
      * (1 - u) * (1 - u) * (1 - u) * (1 - u) * (1 - u) * (1 - u) * (1 - u) * (1 - u);

# What p.D below 1 and the terms of second order do to the errors.
exceed = 1.0001 / (1 - 1b-6 - 1b-40);
cosines = 12 + 7.5 + 7.5;
needed_mm = (cosines + 6) * exceed;
needed_sm = (4 + 4 + (13 + 6 + 4) / MAX_STEEPNESS) * exceed;

{ (e1 in [-1b-53, 1b-53] /\ e2 in [-1b-53, 1b-53] /\ e3 in [-1b-53, 1b-53] /\ e4 in [-1b-53, 1b-53]
 /\ e5 in [-1b-53, 1b-53] /\ e6 in [-1b-53, 1b-53]
    -> BEHIND_ROUNDINGS * u * bound - |f4 - 1| >= 1b-54
    /\ SIDE_ROUNDINGS * u * bound - |f4 - 1| >= 1b-54
    /\ SIDE_ROUNDINGS * u * bound - |f6 - 1| >= 1b-54)
/\ needed_mm * SCREEN_CLEARANCE * 1.0001 / EYE_ROUNDINGS <= 1
/\ needed_sm * SCREEN_CLEARANCE * 1.0001 / SCREEN_ROUNDINGS <= 1
/\ exceed * SCREEN_CLEARANCE * 1.0001 <= 1 }
