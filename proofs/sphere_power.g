# The sign of a point's power with respect to a sphere, and whether a line passes beside it, are certain in f64.
#@ src/world/sphere.rs POWER_ROUNDINGS = 8.0
#@ src/world/sphere.rs BESIDE = 3.0
#
# All errors are in units of u = 2^-53 and of s = f^2 + r^2, where f is the vector from the centre to the ray's origin
# and r the radius; second-order terms are below a thousandth. Subnormal products lose less than the smallest normal
# number, which the source adds.
#
# The power is f^2 - r^2. A component of f has 1 rounding, so its square has 2 + 1; two sums add 2 at most; together 5 of
# f^2. r^2 has 1, and the difference 1 of s. The bound itself, computed with 5 roundings of its sum, product and squares,
# may be short by 8 * 5 u^2 s, which is second order.
#
# The line passes beside the sphere where b^2 < a c, for b = -f.d, a = d^2 and the power c, which is at most s.
# - b has the rounding of f, of a product, and of two sums: 4 of |f| |d|. Its square is off by 8 of a s, and 1 for its own
#   rounding.
# - a has 3 roundings, and its product with the power one. The difference of the power and the bound has one.
# - The power is off by what is counted above.
POWER_ROUNDINGS = 8.0;
BESIDE = 3.0;
power = 5 + 1 + 1;
beside = 8 + 1 + 3 + 1 + 1 + power;

{ power * 1.001 / POWER_ROUNDINGS <= 1
/\ beside * 1.001 / (BESIDE * POWER_ROUNDINGS) <= 1 }
