//! The ray-triangle test in exact arithmetic on the bits of the floats.

use super::exact::exact;
use glam::DVec3;
use num_rational::{BigRational, Ratio};
use num_traits::{Signed, ToPrimitive, Zero};
use raytracer::math::ray::Ray;

/// Where a line meets a triangle.
#[derive(Debug, PartialEq)]
pub enum Exact {
    /// Truly between the edges, at this t.
    Inside(BigRational),
    Outside,
    /// On an edge or a vertex, where a rule has to decide.
    Boundary(BigRational),
    /// The line lies in the triangle's plane, or the triangle has no area.
    Coplanar,
}

/// All coordinates are scaled by one power of two to whole numbers, which changes no t and spares
/// the fractions.
pub fn intersect(ray: &Ray, triangle: [DVec3; 3]) -> Exact {
    let scale = whole_scale([ray.origin, ray.direction].iter().chain(&triangle));
    let whole = |v: DVec3| (v * scale).to_array().map(|x| exact(x).to_integer());
    let (o, d) = (whole(ray.origin), whole(ray.direction));
    macro_rules! det {
        ($p:expr, $q:expr) => {{
            let (p, q) = ($p, $q);
            &d[0] * (&p[1] * &q[2] - &p[2] * &q[1])
                + &d[1] * (&p[2] * &q[0] - &p[0] * &q[2])
                + &d[2] * (&p[0] * &q[1] - &p[1] * &q[0])
        }};
    }
    let [a, b, c] = triangle.map(|v| {
        let v = whole(v);
        [&v[0] - &o[0], &v[1] - &o[1], &v[2] - &o[2]]
    });
    let weights = [det!(&b, &c), det!(&c, &a), det!(&a, &b)];
    let sum = &weights[0] + &weights[1] + &weights[2];
    if sum.is_zero() {
        return Exact::Coplanar;
    }
    if weights.iter().any(|w| w.is_negative()) && weights.iter().any(|w| w.is_positive()) {
        return Exact::Outside;
    }
    // o + t d = weighted vertices; taken along the longest axis of d.
    let axis =
        (0..3).fold(0, |best, i| if ray.direction[i].abs() > ray.direction[best].abs() { i } else { best });
    let along = &weights[0] * &a[axis] + &weights[1] * &b[axis] + &weights[2] * &c[axis];
    let t = Ratio::new(along, sum * &d[axis]);
    if weights.iter().any(|w| w.is_zero()) { Exact::Boundary(t) } else { Exact::Inside(t) }
}

/// A power of two that makes every coordinate a whole number.
fn whole_scale<'a>(vectors: impl Iterator<Item = &'a DVec3>) -> f64 {
    let coordinates = vectors.flat_map(|v| v.to_array()).filter(|&x| x != 0.0);
    let last_bit = |x: f64| {
        let exponent = (x.to_bits() >> 52 & 0x7ff) as i32 - 1023;
        let fraction = x.to_bits() & ((1 << 52) - 1);
        exponent - 52 + fraction.trailing_zeros().min(52) as i32
    };
    let lowest = coordinates.map(last_bit).min().unwrap_or(0);
    2f64.powi(-lowest)
}

/// How far `t` is from the exact value, relative to it.
pub fn relative_error(t: f64, true_t: &BigRational) -> f64 {
    if !t.is_finite() {
        return f64::INFINITY;
    }
    ((exact(t) - true_t) / true_t).abs().to_f64().unwrap_or(f64::INFINITY)
}

#[test]
fn the_oracle_knows_inside_from_edge_and_plane() {
    let t = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let down = |x: f64, y: f64| Ray::new(DVec3::new(x, y, 2.0), DVec3::new(0.0, 0.0, -0.5));
    assert_eq!(intersect(&down(0.25, 0.25), t), Exact::Inside(exact(4.0)));
    assert_eq!(intersect(&down(0.5, 0.5), t), Exact::Boundary(exact(4.0)));
    assert_eq!(intersect(&down(0.5, 0.500_000_1), t), Exact::Outside);
    assert_eq!(intersect(&Ray::new(DVec3::NEG_X, DVec3::X), t), Exact::Coplanar);
}
