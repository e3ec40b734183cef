//! The determinants that decide whether and where a ray meets a triangle, from the coordinates as they are and
//! without any rounding before the last: right for all finite floats.
//!
//! No difference of points is taken. It would have to be rounded, or would overflow; instead determinants are
//! split: (p - o) x (q - o) is p x q + q x o' + o' x p with o' = o, since o x o is nothing.

use super::exact_sum::ExactSum;
use super::scaled::Scaled;
use glam::DVec3;

/// `d . ((p - o) x (q - o))`: the edge function of the edge from `p` to `q` for the ray from `o` along `d`.
pub fn edge_function([o, d]: [DVec3; 2], [p, q]: [DVec3; 2]) -> Scaled {
    projected_area(d, [o, p, q])
}

/// `d . ((b - a) x (c - a))`: twice the area of a triangle seen along `d`, in lengths of `d`.
pub fn projected_area(d: DVec3, [a, b, c]: [DVec3; 3]) -> Scaled {
    let mut sum = ExactSum::new();
    for [p, q] in [[a, b], [b, c], [c, a]] {
        sum.add_determinant([d, p, q]);
    }
    sum.value()
}

/// `(a - o) . ((b - a) x (c - a))`: six times the volume between a point and a triangle.
pub fn volume(o: DVec3, [a, b, c]: [DVec3; 3]) -> Scaled {
    let mut sum = ExactSum::new();
    sum.add_determinant([a, b, c]);
    for [p, q] in [[a, b], [b, c], [c, a]] {
        sum.add_determinant([-o, p, q]);
    }
    sum.value()
}

/// `(b - a) x (c - a)`: the normal of a triangle.
pub fn area_vector([a, b, c]: [DVec3; 3]) -> [Scaled; 3] {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| {
        let mut sum = ExactSum::new();
        for [p, q] in [[a, b], [b, c], [c, a]] {
            sum.add_product([p[i], q[j], 1.0]);
            sum.add_product([-p[j], q[i], 1.0]);
        }
        sum.value()
    })
}

/// `d[i] * (q - p)[j] - d[j] * (q - p)[i]`.
pub fn cross_component(d: DVec3, [p, q]: [DVec3; 2], [i, j]: [usize; 2]) -> Scaled {
    let mut sum = ExactSum::new();
    for (point, sign) in [(q, 1.0), (p, -1.0)] {
        sum.add_product([sign, d[i], point[j]]);
        sum.add_product([-sign, d[j], point[i]]);
    }
    sum.value()
}
