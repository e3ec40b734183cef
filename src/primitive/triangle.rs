//! Triangles by the watertight test of Woop, Benthin and Wald (JCGT 2(1), 2013), made exact: whether
//! a ray hits a triangle is decided as without any rounding, so that every ray through a closed
//! mesh's shared edge or vertex hits exactly one triangle there.
//!
//! This holds for all finite coordinates and directions. A hit has a t that is right to within rounding, and
//! a normal of unit length; only where t itself is too large for a float the triangle counts as missed. Its
//! point is known as long as no coordinate is above 2^500.

use crate::math::extremes::{greatest, least};
use crate::math::predicate::{
    area_vector, cross_component, edge_functions as exact_edge_functions, projected_area, volume,
};
use crate::math::ray::Ray;
use crate::math::robust::{UNIT_ROUNDOFF, unit};
use crate::math::scaled::on_one_scale;
use glam::DVec3;
use std::ops::Range;

/// What the test needs of a ray, computed once per ray: the shear that turns its direction into
/// the z axis, and the axes permuted so that z is the one along which the ray is longest.
#[derive(Clone, Copy, Debug)]
pub struct Shear<'r> {
    ray: &'r Ray,
    axes: [usize; 3],
    /// The ray's origin, by these axes.
    origin: DVec3,
    /// x and y shear per unit of z; the scale that turns a depth along z into t.
    scale: DVec3,
}

/// The point of a triangle with these weights, which need not sum to one: within rounding of its vertices,
/// and never beyond an edge by more, however far away the ray began that crosses it there.
pub fn point([a, b, c]: [DVec3; 3], [u, v, w]: [f64; 3]) -> DVec3 {
    (u * a + v * b + w * c) / (u + v + w)
}

impl<'r> Shear<'r> {
    #[inline(always)]
    pub fn new(ray: &'r Ray) -> Self {
        let d = ray.direction.to_array();
        let [x, y, z] = d.map(f64::abs);
        // Without branches, which rays in all directions would take at random.
        let z = usize::from(!((x > y) & (x > z))) + usize::from((z >= x) & (z >= y));
        static ACROSS: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];
        let [x, y] = ACROSS[z];
        // Where the inverse would lose digits, NaN leaves every t to be computed exactly.
        let inverse = if USUAL.contains(&d[z].abs()) { 1.0 / d[z] } else { f64::NAN };
        let scale = DVec3::new(d[x] / d[z], d[y] / d[z], inverse);
        let o = ray.origin.to_array();
        Self { ray, axes: [x, y, z], origin: DVec3::new(o[x], o[y], o[z]), scale }
    }

    /// A vertex seen along the ray: x and y across it, z the depth along the longest axis.
    #[inline(always)]
    fn apply(&self, vertex: &DVec3) -> DVec3 {
        // As an array where it stands: picking from a vector by number branches, and a copy would
        // have to be written before it is read.
        let v: &[f64; 3] = vertex.as_ref();
        let [x, y, z] = self.axes;
        let v = DVec3::new(v[x], v[y], v[z]) - self.origin;
        DVec3::new(v.x - self.scale.x * v.z, v.y - self.scale.y * v.z, v.z)
    }

    /// Where the ray's line crosses the triangle, whatever its winding; any t, also a negative one.
    ///
    /// It does where the three edge functions have one sign. Where rounding leaves a doubt about a
    /// sign, it is decided exactly, and where an edge function is truly zero, as if the ray were
    /// moved by an infinitesimal amount. So neighbours never disagree about an edge, and a triangle
    /// without area, or one that lies along the ray, is missed without opening a gap.
    #[inline(always)]
    pub fn intersect(&self, corners: [&DVec3; 3]) -> Option<f64> {
        let (a, b, c) = self.sheared(corners);
        let weights = edge_functions([a, b, c]);
        match sides(weights, [a, b, c]) {
            Sides::Outside => return None,
            Sides::Unsure => return self.decide_hit(corners.map(|&v| v), [a.z, b.z, c.z]),
            Sides::Inside => {}
        }
        let [u, v, w] = weights;
        let sum = u + v + w;
        // In this form vertices in another order move t by hardly more than its rounding.
        let t = self.scale.z * (a.z + (v * (b.z - a.z) + w * (c.z - a.z)) / sum);
        if is_well_seen([a, b, c], sum) && t.is_finite() {
            return Some(t);
        }
        self.exact_t(corners.map(|&v| v), [a.z, b.z, c.z])
    }

    /// The weights of the vertices where the ray's line crosses the triangle, as [`intersect`](Self::intersect)
    /// finds them.
    #[inline]
    pub fn weights(&self, corners: [&DVec3; 3]) -> Option<[f64; 3]> {
        let (a, b, c) = self.sheared(corners);
        let weights = edge_functions([a, b, c]);
        match sides(weights, [a, b, c]) {
            Sides::Inside => Some(weights),
            Sides::Outside => None,
            Sides::Unsure => self.decide(corners.map(|&v| v)),
        }
    }

    #[inline(always)]
    fn sheared(&self, [p, q, r]: [&DVec3; 3]) -> (DVec3, DVec3, DVec3) {
        // Written out: a mapped array goes through memory, and waits for it.
        (self.apply(p), self.apply(q), self.apply(r))
    }

    #[cold]
    fn decide_hit(&self, vertices: [DVec3; 3], depths: [f64; 3]) -> Option<f64> {
        self.decide(vertices).and_then(|_| self.exact_t(vertices, depths))
    }

    /// The t where the ray meets the triangle's plane, rounded a few times.
    #[cold]
    fn exact_t(&self, vertices: [DVec3; 3], depths: [f64; 3]) -> Option<f64> {
        let Ray { origin, direction, .. } = *self.ray;
        if !direction.is_finite() {
            return None;
        }
        let t = volume(origin, vertices).over(projected_area(direction, vertices));
        // As the vertices' own t are rounded: so t is the same for triangles in one plane across an axis.
        let [p, q, r] = depths.map(|z| self.scale.z * z);
        let (least, greatest) = (p.min(q).min(r), p.max(q).max(r));
        let t = if least.is_finite() && greatest.is_finite() { t.max(least).min(greatest) } else { t };
        t.is_finite().then_some(t)
    }

    /// The edge functions with exact signs, all divided by the same power of two, if the ray, moved by an
    /// infinitesimal amount, lies on one side of all three edges.
    #[cold]
    fn decide(&self, vertices: [DVec3; 3]) -> Option<[f64; 3]> {
        let Ray { origin, direction, .. } = *self.ray;
        if ![origin, direction].iter().chain(&vertices).all(|v| v.is_finite()) {
            return None;
        }
        let weights = exact_edge_functions(origin, direction, vertices);
        let sides = [0, 1, 2].map(|i| match weights[i].sign() {
            0 => self.side_of_edge_met([vertices[(i + 1) % 3], vertices[(i + 2) % 3]]),
            side => side,
        });
        let inside = sides[0] != 0 && sides[0] == sides[1] && sides[1] == sides[2];
        inside.then(|| on_one_scale(weights))
    }

    /// On which side of an edge the ray is that truly meets the edge's line: as if it had moved, in
    /// the sheared plane, towards negative x, and infinitely less towards negative y. Zero for an
    /// edge along the ray.
    fn side_of_edge_met(&self, edge: [DVec3; 2]) -> i32 {
        let (d, [x, y, z]) = (self.ray.direction, self.axes);
        let sheared = |axis: usize| cross_component(d, edge, [z, axis]).sign();
        [sheared(y), -sheared(x)].into_iter().find(|&side| side != 0).unwrap_or(0)
    }
}

/// Where the ray lies, seen along itself.
enum Sides {
    Inside,
    Outside,
    Unsure,
}

/// On which sides of a triangle's edges the ray lies that has these edge functions for these sheared vertices.
#[inline(always)]
fn sides(edge_functions: [f64; 3], sheared: [DVec3; 3]) -> Sides {
    let (lowest, highest) = (least(edge_functions), greatest(edge_functions));
    let error_bound = edge_error_bound(sheared);
    if lowest < -error_bound && highest > error_bound {
        Sides::Outside
    } else if lowest > error_bound || highest < -error_bound {
        Sides::Inside
    } else {
        Sides::Unsure
    }
}

/// Whether the weights give t to within about a hundred roundings. A sheared vertex is off by a few
/// roundings of its distance D. Over an extent E that changes the area by E roundings of D, and as
/// t varies by Z over the triangle, t by E Z / area of them: much for a needle, or a triangle seen
/// nearly edge on.
#[inline(always)]
fn is_well_seen([a, b, c]: [DVec3; 3], area: f64) -> bool {
    // By axis: the vectors' own selections share registers, and become four times as many steps.
    let extent = |p: f64, q: f64, r: f64| greatest([p, q, r]) - least([p, q, r]);
    (extent(a.x, b.x, c.x) + extent(a.y, b.y, c.y)) * extent(a.z, b.z, c.z) <= 32.0 * area.abs()
}

/// Of the edges opposite to the vertices: twice the areas that they span with the ray in the sheared plane.
#[inline(always)]
fn edge_functions([a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let cross = |p: DVec3, q: DVec3| p.x * q.y - p.y * q.x;
    [cross(b, c), cross(c, a), cross(a, b)]
}

/// How far rounding may have moved an edge function.
///
/// Let e be the unit roundoff, M the largest |x| + |y| of a sheared vertex and D = M + |z| then a
/// bound of the vertex' unsheared coordinates. A sheared x or y carries the roundings of the
/// subtraction of the origin (e D), of the shear factor, the depth and their product (3 e D) and of
/// the difference (e M): at most 5 e D. Hence an edge function is off by 10 e D M + 50 e^2 D^2, and
/// its own three roundings add no more than e M^2.
///
/// Products that underflow move it by less than 2^-1070 more. [`LEAST_EDGE_BOUND`] is far above that, so that
/// where the edge functions are above the bound nothing underflows that matters; and the bound overflows long
/// before they do, or what is computed of them.
#[inline(always)]
fn edge_error_bound([a, b, c]: [DVec3; 3]) -> f64 {
    let largest = |p: f64, q: f64, r: f64| greatest([p.abs(), q.abs(), r.abs()]);
    let across = largest(a.x, b.x, c.x) + largest(a.y, b.y, c.y);
    let reach = across + largest(a.z, b.z, c.z);
    let square = HUGE * reach * (across + 4.0 * UNIT_ROUNDOFF * reach);
    16.0 * UNIT_ROUNDOFF / HUGE * square + LEAST_EDGE_BOUND
}

/// 2^500.
const HUGE: f64 = power_of_two(500);

/// 2^-300.
const LEAST_EDGE_BOUND: f64 = power_of_two(-300);

const fn power_of_two(exponent: i64) -> f64 {
    f64::from_bits(((1023 + exponent) as u64) << 52)
}

/// The sizes of a ray's direction whose inverse has all its digits.
const USUAL: Range<f64> = 1e-300..1e300;

/// The outward unit normal: vertices run counter-clockwise seen from outside. Right to 2^-20 for every triangle
/// with an area, and NaN for one without.
pub fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    /// The square of the tangent of the angle at which the rounding of two edges moves the normal by so much.
    const NEEDLE: f64 = 1.0 / (1u64 << 60) as f64;
    /// The squares of lengths at which nothing that matters underflows or overflows.
    const USUAL: Range<f64> = 1e-280..1e280;
    let (p, q) = (b - a, c - a);
    let (normal, along) = (p.cross(q), p.dot(q));
    let square = normal.length_squared();
    let is_accurate = square > NEEDLE * (along * along) + USUAL.start && square < USUAL.end;
    if is_accurate { normal.normalize() } else { exact_normal([a, b, c]) }
}

#[cold]
fn exact_normal(triangle: [DVec3; 3]) -> DVec3 {
    unit(DVec3::from_array(on_one_scale(area_vector(triangle))))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn test(origin: DVec3, direction: DVec3, triangle: [DVec3; 3]) -> Option<f64> {
        Shear::new(&Ray::new(origin, direction)).intersect(triangle.each_ref())
    }

    /// A fan of triangles around the origin in the plane z = 0.
    fn fan(spokes: usize) -> Vec<[DVec3; 3]> {
        let rim = |i: usize| {
            let angle = (i % spokes) as f64 / spokes as f64 * std::f64::consts::TAU;
            DVec3::new(libm::cos(angle), libm::sin(angle), 0.0)
        };
        (0..spokes).map(|i| [DVec3::ZERO, rim(i), rim(i + 1)]).collect()
    }

    #[test]
    fn a_ray_through_a_shared_vertex_hits_exactly_one_triangle() {
        for spokes in 3..40 {
            for direction in [DVec3::Z, DVec3::new(0.3, -0.2, 1.0), DVec3::new(1.0, 1.0, 1.0)] {
                for back in [0.0, 1.0, 3.7] {
                    let origin = -back * direction;
                    let hits =
                        fan(spokes).into_iter().filter(|&t| test(origin, direction, t).is_some()).count();
                    assert_eq!(hits, 1, "{spokes} spokes, direction {direction}, {back} back");
                }
            }
        }
    }

    #[test]
    fn a_ray_through_a_shared_edge_hits_exactly_one_triangle() {
        let square = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
        let halves = [[square[0], square[1], square[2]], [square[0], square[2], square[3]]];
        for i in 1..100 {
            let p = DVec3::new(i as f64, i as f64, 0.0) / 100.0;
            let hits = halves.iter().filter(|&&t| test(p - DVec3::Z, DVec3::Z, t).is_some()).count();
            assert_eq!(hits, 1);
        }
    }

    #[test]
    fn winding_does_not_matter_to_the_hit() {
        let t = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let p = DVec3::new(0.25, 0.25, -2.0);
        assert_eq!(test(p, DVec3::Z, t), Some(2.0));
        assert_eq!(test(p, DVec3::Z, [t[0], t[2], t[1]]), Some(2.0));
    }

    #[test]
    fn degenerate_and_edge_on_triangles_are_missed() {
        let p = DVec3::new(1.0, 2.0, 3.0);
        let q = DVec3::new(-2.0, 0.5, 1.0);
        for t in [[p, p, p], [p, p, q], [p, q, p], [p, q, 0.5 * (p + q)]] {
            assert_eq!(test(DVec3::ZERO, p, t), None);
        }
        assert_eq!(test(DVec3::NEG_X, DVec3::X, [DVec3::ZERO, DVec3::X, DVec3::Y]), None);
    }

    #[test]
    fn a_triangle_on_one_line_is_missed_and_leaves_no_gap() {
        // The long side of one triangle is shared by two halves, and a triangle without area stands
        // between. Its third corner lies on the side exactly.
        let (p, q) = (DVec3::new(0.1, 0.2, 0.3), DVec3::new(0.7, -0.4, 0.9));
        let [p, q] = [p, q].map(|v| v.as_vec3().as_dvec3());
        let m = 0.5 * (p + q);
        let (left, right) = (DVec3::new(-1.0, 2.0, 0.5), DVec3::new(1.5, 1.0, -2.0));
        for i in 0..2000 {
            let origin = DVec3::new(3.0, libm::sin(i as f64), 4.0);
            let direction = p.lerp(q, i as f64 / 2000.0) - origin;
            assert_eq!(test(origin, direction, [p, m, q]), None);
            let around = [[p, q, left], [q, m, right], [m, p, right]];
            assert_eq!(around.into_iter().filter(|&t| test(origin, direction, t).is_some()).count(), 1);
        }
    }

    #[test]
    fn the_crossed_point_lies_in_the_triangle() {
        let t = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let ray = Ray::new(DVec3::new(0.25, 0.5, -1e9), DVec3::Z);
        let weights = Shear::new(&ray).weights(t.each_ref());
        assert_eq!(weights.map(|w| point(t, w)), Some(DVec3::new(0.25, 0.5, 0.0)));
    }
}
