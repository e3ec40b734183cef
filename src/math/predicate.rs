//! Signs that are right whatever the input: first in double-double, and where that leaves a doubt in
//! exact sums of floats (Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust
//! Geometric Predicates", Discrete & Computational Geometry 18, 1997).
//!
//! Exact as long as no product of three coordinates leaves the range of f64.

use super::double_double::{Dd, cross, dot};
use glam::DVec3;

/// `d . (p x q)`, with the exact sign and zero only if it is zero.
pub fn triple_product(d: DVec3, p: [Dd; 3], q: [Dd; 3]) -> f64 {
    let fast = dot(d.to_array().map(Dd::from), cross(p, q)).value();
    let [size_p, size_q] = [p, q].map(|v| DVec3::from_array(v.map(Dd::value)).abs());
    let terms = |i: usize, j: usize| size_p[i] * size_q[j] + size_p[j] * size_q[i];
    let largest = d.abs().dot(DVec3::new(terms(1, 2), terms(2, 0), terms(0, 1)));
    // Eight operations of 2^-100 each, and room. What is no number, or too large for one, no sum can
    // decide, and only a slow one would be tried.
    if fast.abs() > 0.5f64.powi(95) * largest || !largest.is_finite() {
        return fast;
    }
    let mut sum = ExactSum::default();
    for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
        for (p, q, sign) in [(p[j], q[k], 1.0), (p[k], q[j], -1.0)] {
            for [x, y] in pairs(p.parts(), q.parts()) {
                sum.add_product(sign * d[i], x, y);
            }
        }
    }
    sum.value()
}

/// `a * p - b * q`, with the exact sign and zero only if it is zero.
pub fn difference_of_products(a: f64, p: Dd, b: f64, q: Dd) -> f64 {
    let mut sum = ExactSum::default();
    p.parts().into_iter().for_each(|x| sum.add_product(a, x, 1.0));
    q.parts().into_iter().for_each(|x| sum.add_product(-b, x, 1.0));
    sum.value()
}

fn pairs([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [[f64; 2]; 4] {
    [[a, c], [a, d], [b, c], [b, d]]
}

/// A sum of floats without any rounding: parts of ascending size that do not overlap, none zero.
#[derive(Debug, Default)]
struct ExactSum(Vec<f64>);

impl ExactSum {
    fn add(&mut self, x: f64) {
        let mut carried = x;
        let mut kept = 0;
        for i in 0..self.0.len() {
            let [low, high] = Dd::difference(carried, -self.0[i]).parts();
            if low != 0.0 {
                self.0[kept] = low;
                kept += 1;
            }
            carried = high;
        }
        self.0.truncate(kept);
        if carried != 0.0 {
            self.0.push(carried);
        }
    }

    /// Adds `a * b * c`.
    fn add_product(&mut self, a: f64, b: f64, c: f64) {
        let product = |a: f64, b: f64| [a.mul_add(b, -(a * b)), a * b];
        for ab in product(a, b) {
            product(ab, c).into_iter().filter(|&x| x != 0.0).for_each(|x| self.add(x));
        }
    }

    /// The sum, rounded; its sign is exact.
    fn value(&self) -> f64 {
        self.0.iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::super::double_double::difference;
    use super::*;

    #[test]
    fn three_vectors_in_a_plane_span_nothing_and_out_of_it_a_trifle() {
        let exact = |v: DVec3| difference(v, DVec3::ZERO);
        let (p, q) = (DVec3::new(0.1, 0.7, -0.3), DVec3::new(1.3, 2.0 / 3.0, 0.9));
        assert_eq!(triple_product(p, exact(p), exact(q)), 0.0);
        assert_eq!(triple_product(2.0 * p, exact(q), exact(p)), 0.0);
        let tiny = 2f64.powi(-200);
        let beside = [exact(p)[0], exact(p)[1], difference(DVec3::splat(p.z), DVec3::splat(tiny))[0]];
        let found = triple_product(p, beside, exact(q));
        // d . ((d - tiny z) x q) = -tiny z . (q x d)
        let expected = -tiny * (q.x * p.y - q.y * p.x);
        assert!((found / expected - 1.0).abs() < 1e-15, "{found:e} {expected:e}");
    }

    #[test]
    fn products_that_agree_to_a_hundred_digits_differ() {
        let [x, y] = [0.1, 0.3].map(|x| Dd::difference(x, 2f64.powi(-60)));
        assert_eq!(difference_of_products(0.7, x, 0.7, x), 0.0);
        assert!(difference_of_products(0.3, x, 0.1, y) < 0.0);
    }
}
