# Single precision in the projection is off by less than SINGLE_ROUNDINGS roundings of the largest value.
#@ src/raster/tile.rs SINGLE_ROUNDINGS = 5.0
# A value is first + slope k: first has a rounding of its own and that of the sum, the other term those of the slope,
# of the product and of the sum. `most` in the source is at least |first| + |slope k|, so that 3 roundings are for the
# value. The error bound e is subtracted from it or added with another rounding, of at most most + e. Where e is above
# `most` no pixel is decided for the triangle; what e itself loses when it is rounded, and in that sum, is
# two roundings of it, for which the bounds of double precision leave a thousandth.
SINGLE_ROUNDINGS = 5.0;
value = (1 + e1) * (1 + e2) * (1 + e3) - 1;
sum = e4 * (1 + value);

{ (e1 in [-1b-24, 1b-24] /\ e2 in [-1b-24, 1b-24] /\ e3 in [-1b-24, 1b-24] /\ e4 in [-1b-24, 1b-24]
    -> (|value| + |sum|) / (SINGLE_ROUNDINGS * 1b-24) <= 0.81) }
