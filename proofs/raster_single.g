# The error of single precision in the rasterizer is below SINGLE_ROUNDINGS roundings of the largest value.
#@ src/fast/raster/tile.rs SINGLE_ROUNDINGS = 5.0
# A value is first + slope k. The first term has a rounding of its own and that of the sum, and the other term has those
# of the slope, of the product and of the sum. `max_abs` in the source is at least |first| + |slope k|, so the value has
# at most 3 roundings of it. The error bound e is added to the value or subtracted from it, with another rounding of at
# most max_abs + e. If e is larger than `max_abs`, no pixel shows the triangle for certain. The rounding of e
# itself and its part in that sum are two roundings of e, for which the bounds of double precision leave a thousandth.
SINGLE_ROUNDINGS = 5.0;
value = (1 + e1) * (1 + e2) * (1 + e3) - 1;
sum = e4 * (1 + value);

{ (e1 in [-1b-24, 1b-24] /\ e2 in [-1b-24, 1b-24] /\ e3 in [-1b-24, 1b-24] /\ e4 in [-1b-24, 1b-24]
    -> (|value| + |sum|) / (SINGLE_ROUNDINGS * 1b-24) <= 0.81) }
