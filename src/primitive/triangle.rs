//! Triangles by the watertight test of Woop, Benthin and Wald (JCGT 2(1), 2013), made exact: whether
//! a ray hits a triangle is decided as without any rounding, so that every ray through a closed
//! mesh's shared edge or vertex hits exactly one triangle there.

use crate::math::double_double::{Dd, cross as exact_cross, difference, dot};
use crate::math::extremes::{greatest, least};
use crate::math::predicate::{difference_of_products, triple_product};
use crate::math::ray::Ray;
use crate::math::robust::{UNIT_ROUNDOFF, unit};
use glam::DVec3;

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
        // Without a length no t is right; NaN makes every triangle a miss.
        let inverse = if d[z].is_finite() { 1.0 / d[z] } else { f64::NAN };
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
        let [p, q, r] = corners;
        let (a, b, c) = self.sheared(corners);
        let weights = self.weights_of(corners, [a, b, c])?;
        let [u, v, w] = weights;
        let sum = u + v + w;
        // In this form vertices in another order move t by hardly more than its rounding.
        let mut t = self.scale.z * (a.z + (v * (b.z - a.z) + w * (c.z - a.z)) / sum);
        if !is_well_seen([a, b, c], sum) {
            t = self.refined([*p, *q, *r], [a.z, b.z, c.z], t);
        }
        // The sum is zero only for a triangle seen edge on; a NaN comes from a broken ray.
        t.is_finite().then_some(t)
    }

    /// The weights of the vertices where the ray's line crosses the triangle, as [`intersect`](Self::intersect)
    /// finds them.
    #[inline]
    pub fn weights(&self, corners: [&DVec3; 3]) -> Option<[f64; 3]> {
        let (a, b, c) = self.sheared(corners);
        self.weights_of(corners, [a, b, c])
    }

    #[inline(always)]
    fn sheared(&self, [p, q, r]: [&DVec3; 3]) -> (DVec3, DVec3, DVec3) {
        // Written out: a mapped array goes through memory, and waits for it.
        (self.apply(p), self.apply(q), self.apply(r))
    }

    #[inline(always)]
    fn weights_of(&self, corners: [&DVec3; 3], [a, b, c]: [DVec3; 3]) -> Option<[f64; 3]> {
        let weights = [cross(b, c), cross(c, a), cross(a, b)];
        let (lowest, highest) = (least(weights), greatest(weights));
        let doubt = doubt([a, b, c]);
        if lowest < -doubt && highest > doubt {
            return None;
        }
        if lowest > doubt || highest < -doubt { Some(weights) } else { self.decide(corners.map(|&v| v)) }
    }

    /// The t of a crossing that the weights give only roughly: where the ray meets the triangle's
    /// plane, in twice the digits.
    #[cold]
    fn refined(&self, [a, b, c]: [DVec3; 3], depths: [f64; 3], rough: f64) -> f64 {
        let normal = exact_cross(difference(b, a), difference(c, a));
        let along = dot(normal, self.ray.direction.to_array().map(Dd::from)).value();
        let t = dot(normal, difference(a, self.ray.origin)).value() / along;
        if !t.is_finite() {
            return rough;
        }
        // Not beyond the vertices by rounding, so that the grid finds the hit where it keeps them.
        let [p, q, r] = depths.map(|z| self.scale.z * z);
        t.max(p.min(q).min(r)).min(p.max(q).max(r))
    }

    /// The edge functions with exact signs, if the ray, moved by an infinitesimal amount, lies on
    /// one side of all three edges.
    #[cold]
    fn decide(&self, vertices: [DVec3; 3]) -> Option<[f64; 3]> {
        let [a, b, c] = vertices.map(|v| difference(v, self.ray.origin));
        let edges = [(b, c), (c, a), (a, b)];
        let along = self.scale.z;
        let weights = edges.map(|(p, q)| along * triple_product(self.ray.direction, p, q));
        let sides = [0, 1, 2].map(|i| match sign(weights[i]) {
            0 => self.side_of_edge_met(vertices[(i + 1) % 3], vertices[(i + 2) % 3]),
            side => side,
        });
        let inside = sides[0] != 0 && sides[0] == sides[1] && sides[1] == sides[2];
        inside.then_some(weights)
    }

    /// On which side of an edge the ray is that truly meets the edge's line: as if it had moved, in
    /// the sheared plane, towards negative x, and infinitely less towards negative y. Zero for an
    /// edge along the ray.
    fn side_of_edge_met(&self, from: DVec3, to: DVec3) -> i32 {
        let (edge, d, [x, y, z]) = (difference(to, from), self.ray.direction, self.axes);
        let sheared = |axis: usize| sign(difference_of_products(d[z], edge[axis], d[axis], edge[z]));
        let toward_z = sign(d[z]);
        [toward_z * sheared(y), -toward_z * sheared(x)].into_iter().find(|&s| s != 0).unwrap_or(0)
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

/// The edge function of `p` and `q` in the sheared plane: twice the area they span with the ray.
#[inline(always)]
fn cross(p: DVec3, q: DVec3) -> f64 {
    p.x * q.y - p.y * q.x
}

/// How far rounding may have moved an edge function.
///
/// Let e be the unit roundoff, M the largest |x| + |y| of a sheared vertex and D = M + |z| then a
/// bound of the vertex' unsheared coordinates. A sheared x or y carries the roundings of the
/// subtraction of the origin (e D), of the shear factor, the depth and their product (3 e D) and of
/// the difference (e M): at most 5 e D. Hence an edge function is off by 10 e D M + 50 e^2 D^2, and
/// its own three roundings add no more than e M^2.
#[inline(always)]
fn doubt([a, b, c]: [DVec3; 3]) -> f64 {
    let largest = |p: f64, q: f64, r: f64| greatest([p.abs(), q.abs(), r.abs()]);
    let across = largest(a.x, b.x, c.x) + largest(a.y, b.y, c.y);
    let reach = across + largest(a.z, b.z, c.z);
    16.0 * UNIT_ROUNDOFF * reach * (across + 4.0 * UNIT_ROUNDOFF * reach)
}

fn sign(x: f64) -> i32 {
    (x > 0.0) as i32 - (x < 0.0) as i32
}

/// The outward unit normal: vertices run counter-clockwise seen from outside.
pub fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    let normal = (b - a).cross(c - a);
    if normal.length_squared() > 1e-290 { unit(normal) } else { unit(unit(b - a).cross(unit(c - a))) }
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
