# The points of surfaces and their coordinates in a checkerboard's space are within the error bounds that decide.
#@ src/world/point_error.rs BETWEEN_VERTICES_ROUNDINGS = 7.0
#@ src/world/sphere.rs AT_RADIUS_ROUNDINGS = 6.0
#@ src/world/point_error.rs ON_PLANE_ROUNDINGS = 6.0
#@ src/math/rounded.rs PRODUCT_ROUNDINGS = 5.0
#@ src/math/rounded.rs IMAGE_ROUNDINGS = 16.0
#@ src/shading/checkerboard.rs ALONG_AXIS_ROUNDINGS = 4.0
#@ src/scene/transform.rs REST_ROUNDINGS = 11.0
#@ src/scene/transform.rs SINE_ROUNDINGS = 5.0
#@ src/scene/transform.rs COSINE_ROUNDINGS = 5.0
# All errors are relative to the sums of absolute values that the source multiplies the constants with, so that a sum of
# rounded terms has the error (1 + e1) (1 + e2) ... - 1 of its longest chain of roundings.
BETWEEN_VERTICES_ROUNDINGS = 7.0;
AT_RADIUS_ROUNDINGS = 6.0;
ON_PLANE_ROUNDINGS = 6.0;
PRODUCT_ROUNDINGS = 5.0;
IMAGE_ROUNDINGS = 16.0;
ALONG_AXIS_ROUNDINGS = 4.0;
REST_ROUNDINGS = 11.0;
SINE_ROUNDINGS = 5.0;
COSINE_ROUNDINGS = 5.0;

# A point between vertices, (u a + v b + w c) / (u + v + w): x is the exact coordinate over the largest one of the
# vertices. The weights have one sign, so that their sum has a relative error.
numerator = (1 + e1) * (1 + e2) * (1 + e3) - 1;
quotient = (1 + e4) / ((1 + e5) * (1 + e6)) - 1;
between = x * quotient + numerator * (1 + quotient);

# A point at a radius r = 1 - c from a centre c, in units of both: the unit normal has at most three roundings.
radius = (1 - c) * ((1 + 3 * e1) * (1 + e2) - 1);
at_radius = radius + e3 * (1 + radius);

# A point p that is projected on the plane n.p = o. Its distance h from the plane is computed with an error of three
# roundings of the sum of |p| and one of |o|, and is itself at most 2^-20 of both, since the point was computed to be a
# hit. Then h n is subtracted. The length of n is off by at most four roundings.
distance = (1 + e1) * (1 + e2) * (1 + e3) * (1 + e4) - 1;
projected = distance + h * ((1 + 4 * e5) * (1 + e6) - 1) + (1 + h) * e7;

# A number of a product of maps, and a coordinate of an image: three products and three sums. Along an axis two of the
# products and two of the sums are exact.
image = (1 + e1) * (1 + e2) * (1 + e3) * (1 + e4) - 1;
along_axis = (1 + e1) * (1 + e2) - 1;

# A number of a rotation, (1 - cosine) x y + sine z, or + cosine. Each term of the error in units of |x y|, |z| and 1.
# s and k are what the two roundings of the angle, which is at most pi / 4, change the sine and the cosine by; both are
# right to less than one unit in the last place of a number below 1.
sine_error = s + e1 * (1 + s);
cosine_error = k + e1 * (1 + k);
rest = cosine_error + e2 * (2 + cosine_error);
rest_product = rest + ((1 + e3) * (1 + e4) - 1) * (2 + rest);
sine_product = sine_error + e5 * (1 + sine_error);
of_rest = rest_product + e6 * (2 + rest_product);
of_sine = sine_product + e6 * (1 + sine_product);
of_cosine = cosine_error + e6 * (1 + cosine_error);

{ (e1 in [-1b-53, 1b-53] /\ e2 in [-1b-53, 1b-53] /\ e3 in [-1b-53, 1b-53] /\ e4 in [-1b-53, 1b-53]
    /\ e5 in [-1b-53, 1b-53] /\ e6 in [-1b-53, 1b-53] /\ e7 in [-1b-53, 1b-53]
    /\ x in [-1, 1] /\ c in [0, 1] /\ h in [-1b-20, 1b-20]
    /\ s in [-7b-55, 7b-55] /\ k in [-7b-55, 7b-55]
    -> |between| / (BETWEEN_VERTICES_ROUNDINGS * 1b-53) <= 1
    /\ |at_radius| / (AT_RADIUS_ROUNDINGS * 1b-53) <= 1
    /\ |projected| / (ON_PLANE_ROUNDINGS * 1b-53) <= 1
    /\ |image| / (PRODUCT_ROUNDINGS * 1b-53) <= 0.81
    /\ |image| / (IMAGE_ROUNDINGS * 1b-53) <= 0.26
    /\ |along_axis| / (ALONG_AXIS_ROUNDINGS * 1b-53) <= 0.51
    /\ |of_rest| / (REST_ROUNDINGS * 1b-53) <= 1
    /\ |of_sine| / (SINE_ROUNDINGS * 1b-53) <= 1
    /\ |of_cosine| / (COSINE_ROUNDINGS * 1b-53) <= 1) }
