//! The ray-triangle test in exact arithmetic, for floats of any magnitude.

use super::exact::exact;
use glam::DVec3;
use num_rational::{BigRational, Ratio};
use num_traits::{One, Signed, ToPrimitive, Zero};
use raytracer::math::ray::Ray;

/// The intersection of a line and a triangle.
#[derive(Debug, PartialEq)]
pub enum Exact {
    /// The line crosses the interior at this t.
    Inside(BigRational),
    Outside,
    /// The line meets an edge or a vertex, so that a rule has to decide.
    Boundary(BigRational),
    /// The line is in the triangle's plane, or the triangle has no area.
    Coplanar,
}

trait Quotient {
    type Number;
}

impl<T> Quotient for Ratio<T> {
    type Number = T;
}

/// An integer of any size.
type Whole = <BigRational as Quotient>::Number;

type Vector = [Whole; 3];

/// A ray and a triangle, scaled by a power of two to integers. This changes neither t nor any sign, and
/// avoids fractions.
struct Setting {
    origin: Vector,
    direction: Vector,
    vertices: [Vector; 3],
    /// The axis along which the direction is longest; the last one of several.
    longest: usize,
}

impl Setting {
    fn new(ray: &Ray, triangle: [DVec3; 3]) -> Self {
        let vectors = || [ray.origin, ray.direction].into_iter().chain(triangle);
        let last_bits = vectors().flat_map(|v| v.to_array()).filter(|&x| x != 0.0).map(last_bit);
        let lowest = last_bits.min().unwrap_or(0);
        let whole = |v: DVec3| v.to_array().map(|x| whole(x, lowest));
        let length = |axis: usize| ray.direction[axis].abs();
        let longest = (0..3).fold(0, |best, axis| if length(axis) >= length(best) { axis } else { best });
        Self {
            origin: whole(ray.origin),
            direction: whole(ray.direction),
            vertices: triangle.map(whole),
            longest,
        }
    }

    /// `d . ((p - o) x (q - o))` for the edge opposite to each vertex.
    fn edge_functions(&self, origin: &Vector) -> [Whole; 3] {
        let [a, b, c] = [0, 1, 2].map(|k| minus(&self.vertices[k], origin));
        [(&b, &c), (&c, &a), (&a, &b)].map(|(p, q)| determinant(&self.direction, p, q))
    }

    /// The change of these when the origin moves by -1 along an axis.
    fn change_along(&self, axis: usize) -> [Whole; 3] {
        let mut moved = self.origin.clone();
        moved[axis] -= Whole::one();
        let (here, there) = (self.edge_functions(&self.origin), self.edge_functions(&moved));
        std::array::from_fn(|k| &there[k] - &here[k])
    }

    /// The t of the point with these weights: o + t d = weighted vertices, along the longest axis of d.
    fn t(&self, weights: &[Whole; 3]) -> BigRational {
        let axis = self.longest;
        let depth = |k: usize| &self.vertices[k][axis] - &self.origin[axis];
        let along = &weights[0] * depth(0) + &weights[1] * depth(1) + &weights[2] * depth(2);
        Ratio::new(along, (&weights[0] + &weights[1] + &weights[2]) * &self.direction[axis])
    }
}

pub fn intersect(ray: &Ray, triangle: [DVec3; 3]) -> Exact {
    let setting = Setting::new(ray, triangle);
    let weights = setting.edge_functions(&setting.origin);
    if (&weights[0] + &weights[1] + &weights[2]).is_zero() {
        return Exact::Coplanar;
    }
    if weights.iter().any(|w| w.is_negative()) && weights.iter().any(|w| w.is_positive()) {
        return Exact::Outside;
    }
    let t = setting.t(&weights);
    if weights.iter().any(|w| w.is_zero()) { Exact::Boundary(t) } else { Exact::Inside(t) }
}

/// The t at which the line hits the triangle by the rule for edges and vertices: as if the ray were moved by
/// an infinitesimal amount towards the negative axis that follows its longest one cyclically, and by an
/// infinitely smaller amount along the next.
pub fn intersect_by_rule(ray: &Ray, triangle: [DVec3; 3]) -> Option<BigRational> {
    let setting = Setting::new(ray, triangle);
    let weights = setting.edge_functions(&setting.origin);
    let [first, second] = [1, 2].map(|k| setting.change_along((setting.longest + k) % 3));
    let side = |k: usize| {
        let orders = [&weights[k], &first[k], &second[k]];
        orders.into_iter().find(|order| !order.is_zero()).map(|order| order.is_positive())
    };
    let inside = side(0).is_some() && side(0) == side(1) && side(1) == side(2);
    inside.then(|| setting.t(&weights))
}

/// The triangle's normal, scaled by a power of two to a length from 1 to 2 if the triangle has an area.
pub fn normal(triangle: [DVec3; 3]) -> DVec3 {
    let setting = Setting::new(&Ray::new(DVec3::ZERO, DVec3::ZERO), triangle);
    let [a, b, c] = &setting.vertices;
    let (p, q) = (minus(b, a), minus(c, a));
    let normal: Vector = [(1, 2), (2, 0), (0, 1)].map(|(j, k)| &p[j] * &q[k] - &p[k] * &q[j]);
    let largest = normal.iter().map(|x| x.abs()).max().unwrap_or_else(Whole::zero);
    let share = |x: &Whole| Ratio::new(x.clone(), largest.clone()).to_f64().expect("a number up to 1");
    if largest.is_zero() { DVec3::ZERO } else { DVec3::from_array([0, 1, 2].map(|k| share(&normal[k]))) }
}

fn minus(a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|axis| &a[axis] - &b[axis])
}

fn determinant(a: &Vector, b: &Vector, c: &Vector) -> Whole {
    &a[0] * (&b[1] * &c[2] - &b[2] * &c[1])
        + &a[1] * (&b[2] * &c[0] - &b[0] * &c[2])
        + &a[2] * (&b[0] * &c[1] - &b[1] * &c[0])
}

/// The exponent of the lowest bit that is set in a non-zero float.
fn last_bit(x: f64) -> i32 {
    let exponent = (x.to_bits() >> 52 & 0x7ff) as i32;
    let fraction = x.to_bits() & ((1 << 52) - 1);
    exponent.max(1) - 1075 + fraction.trailing_zeros().min(52) as i32
}

/// `x / 2^lowest`, which must be an integer.
fn whole(x: f64, lowest: i32) -> Whole {
    if x == 0.0 {
        return Whole::zero();
    }
    let last_bit = last_bit(x);
    // In two steps, because the power itself may overflow.
    let odd = x * 2f64.powi(-last_bit / 2) * 2f64.powi(-last_bit + last_bit / 2);
    exact(odd).to_integer() << (last_bit - lowest) as usize
}

/// The relative error of `t`.
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
    // The edges towards negative x are hit, and of the vertices the one at negative x and y.
    assert_eq!(intersect_by_rule(&down(0.5, 0.5), t), Some(exact(4.0)));
    assert_eq!(intersect_by_rule(&down(0.0, 0.5), t), None);
    assert_eq!(intersect_by_rule(&down(0.5, 0.0), t), None);
    assert_eq!(intersect_by_rule(&down(1.0, 0.0), t), None);
}

#[test]
fn the_oracle_knows_no_largest_and_no_smallest_number() {
    let (tiny, huge) = (f64::from_bits(1), f64::MAX);
    let t = [DVec3::ZERO, huge * DVec3::X, huge * DVec3::Y];
    let ray = |direction: DVec3| Ray::new(DVec3::new(tiny, tiny, -tiny), direction);
    assert_eq!(intersect(&ray(tiny * DVec3::Z), t), Exact::Inside(exact(1.0)));
    assert_eq!(intersect(&ray(DVec3::new(-tiny, 0.0, tiny)), t), Exact::Boundary(exact(1.0)));
    assert_eq!(normal(t), DVec3::Z);
}
