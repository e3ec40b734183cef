//! Triangles, by the watertight test of Woop, Benthin and Wald (JCGT 2(1), 2013), made exact: whether a ray
//! hits a triangle is decided as if there were no rounding, so that a ray through an edge or a vertex that
//! triangles of a closed mesh share hits exactly one of them.
//!
//! This holds for all finite coordinates and directions. The t of a hit is accurate to within rounding, and
//! the normal has unit length. A triangle whose t would overflow counts as missed. The point of a hit is
//! accurate as long as no coordinate exceeds 2^500.

use crate::math::predicate::{
    area_vector, cross_component, edge_functions as exact_edge_functions, projected_area, volume,
};
use crate::math::ray::Ray;
use crate::math::robust::unit;
use crate::math::scaled::on_one_scale;
use crate::primitive::edge_functions::{Sides, edge_functions, is_interpolation_accurate, sides};
use glam::DVec3;

/// The part of the test that depends on the ray only: the shear that maps its direction to the z axis, after
/// a permutation of the axes that makes z the one along which the direction is longest.
#[derive(Clone, Copy, Debug)]
pub struct Shear<'r> {
    ray: &'r Ray,
    axes: [usize; 3],
    /// The ray's origin, with its axes permuted.
    origin: DVec3,
    /// x and y are the shear per unit of z, and z is the factor that converts a depth along z to t.
    scale: DVec3,
}

/// The point of a triangle with these barycentric weights, which need not add up to one. Its error is that of
/// rounding the vertices, so the point is at most that far beyond an edge, however distant the ray's origin
/// is.
pub fn point([a, b, c]: [DVec3; 3], [u, v, w]: [f64; 3]) -> DVec3 {
    (u * a + v * b + w * c) / (u + v + w)
}

impl<'r> Shear<'r> {
    /// The shear for a ray. A ray whose direction is zero or not finite misses every triangle.
    #[inline(always)]
    pub fn new(ray: &'r Ray) -> Self {
        let d = ray.direction.to_array();
        let [x, y, z] = d.map(f64::abs);
        // Without branches, because they would be unpredictable for rays in all directions.
        let z = usize::from(!((x > y) & (x > z))) + usize::from((z >= x) & (z >= y));
        static ACROSS: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];
        let [x, y] = ACROSS[z];
        // No t is meaningful for a direction of infinite length. The NaN makes every triangle a miss.
        let inverse = if d[z].is_finite() { 1.0 / d[z] } else { f64::NAN };
        let scale = DVec3::new(d[x] / d[z], d[y] / d[z], inverse);
        let o = ray.origin.to_array();
        Self { ray, axes: [x, y, z], origin: DVec3::new(o[x], o[y], o[z]), scale }
    }

    /// A vertex in the sheared space: x and y are its distances from the ray, z its depth along the longest
    /// axis.
    #[inline(always)]
    fn apply(&self, vertex: &DVec3) -> DVec3 {
        // The vertex is indexed in place as an array: indexing a glam vector branches, and a copy would have
        // to be stored to memory before it is indexed.
        let v: &[f64; 3] = vertex.as_ref();
        let [x, y, z] = self.axes;
        let v = DVec3::new(v[x], v[y], v[z]) - self.origin;
        DVec3::new(v.x - self.scale.x * v.z, v.y - self.scale.y * v.z, v.z)
    }

    /// The t where the ray's line crosses the triangle, whatever its winding. It may be negative.
    ///
    /// The line crosses the triangle where the three edge functions have the same sign. A sign that is within
    /// the error bound is decided in exact arithmetic, and where an edge function is exactly zero, as if the
    /// ray were moved by an infinitesimal amount. So two triangles never disagree about the edge they share,
    /// and a triangle without area, or one that contains the ray's direction, is missed without opening a
    /// gap.
    #[inline(always)]
    pub fn intersect(&self, corners: [&DVec3; 3]) -> Option<f64> {
        self.hit(corners).map(|(t, _)| t)
    }

    /// The same with the barycentric weights of the crossing, up to a common factor.
    #[inline(always)]
    pub fn hit(&self, corners: [&DVec3; 3]) -> Option<(f64, [f64; 3])> {
        let (a, b, c) = self.sheared(corners);
        let weights = edge_functions([a, b, c]);
        match sides(weights, [a, b, c]) {
            Sides::Outside => return None,
            Sides::Unsure => return self.decide_hit(corners.map(|&v| v), [a.z, b.z, c.z]),
            Sides::Inside => {}
        }
        let [u, v, w] = weights;
        let sum = u + v + w;
        // In this form another order of the vertices changes t by little more than its rounding error.
        let t = self.scale.z * (a.z + (v * (b.z - a.z) + w * (c.z - a.z)) / sum);
        if is_interpolation_accurate([a, b, c], sum) && t.is_finite() {
            return Some((t, weights));
        }
        self.exact_t(corners.map(|&v| v), [a.z, b.z, c.z]).map(|t| (t, weights))
    }

    /// The weights alone, for callers that do not need t. They are none exactly where [`hit`](Self::hit) finds
    /// no crossing, except for a t that overflows.
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
        // Written out, because a mapped array would be stored to memory and loaded again.
        (self.apply(p), self.apply(q), self.apply(r))
    }

    /// The t of a triangle for which rounding errors do not tell whether it is hit.
    #[cold]
    fn decide_hit(&self, vertices: [DVec3; 3], depths: [f64; 3]) -> Option<(f64, [f64; 3])> {
        let weights = self.decide(vertices)?;
        Some((self.exact_t(vertices, depths)?, weights))
    }

    /// The t where the ray crosses the triangle's plane, from exact determinants that are rounded before the
    /// division.
    #[cold]
    fn exact_t(&self, vertices: [DVec3; 3], depths: [f64; 3]) -> Option<f64> {
        let Ray { origin, direction, .. } = *self.ray;
        if !direction.is_finite() {
            return None;
        }
        let t = volume(origin, vertices).over(projected_area(direction, vertices));
        // Clamped to the rounded t of the vertices, so that triangles in one plane across an axis agree on t.
        let [p, q, r] = depths.map(|z| self.scale.z * z);
        let (min, max) = (p.min(q).min(r), p.max(q).max(r));
        let t = if min.is_finite() && max.is_finite() { t.max(min).min(max) } else { t };
        t.is_finite().then_some(t)
    }

    /// The edge functions with exact signs, all divided by the same power of two, if the ray, moved by an
    /// infinitesimal amount, passes on the same side of all three edges.
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

    /// The side of an edge on which the ray passes that meets the edge's line exactly: as if the ray were
    /// moved in the sheared plane by an infinitesimal amount towards negative x, and by an infinitely smaller
    /// one towards negative y. Zero for an edge that is parallel to the ray.
    fn side_of_edge_met(&self, edge: [DVec3; 2]) -> i32 {
        let (d, [x, y, z]) = (self.ray.direction, self.axes);
        let sheared = |axis: usize| cross_component(d, edge, [z, axis]).sign();
        [sheared(y), -sheared(x)].into_iter().find(|&side| side != 0).unwrap_or(0)
    }
}

/// The outward unit normal; the vertices run counter-clockwise seen from outside. Its error is at most 2^-20
/// for every triangle with an area. It is NaN for a triangle without one.
#[inline(always)]
pub fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    /// The squared tangent of the angle between two edges at which their rounding changes the normal by
    /// 2^-20.
    const NEEDLE: f64 = 1.0 / (1u64 << 60) as f64;
    /// The squared length of the cross product above which underflow does not matter.
    const SHORT: f64 = 1e-280;
    let (p, q) = (b - a, c - a);
    let (normal, along) = (p.cross(q), p.dot(q));
    let square = normal.length_squared();
    let is_accurate = square > NEEDLE * (along * along) + SHORT && square.is_finite();
    if is_accurate { normal.normalize() } else { exact_normal([a, b, c]) }
}

#[cold]
fn exact_normal(triangle: [DVec3; 3]) -> DVec3 {
    unit(DVec3::from_array(on_one_scale(area_vector(triangle))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::primitive::edge_functions::edge_error_bound;

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
    fn the_t_of_a_tilted_triangle_is_right_within_and_on_an_edge() {
        let [a, b, c, d] =
            [[0.0, 0.0, 1.0], [1.0, 0.0, 2.0], [0.0, 1.0, 4.0], [1.0, 1.0, 5.0]].map(DVec3::from);
        for (x, y) in [(0.25, 0.25), (0.125, 0.5), (0.75, 0.25), (0.5, 0.5), (0.5, 0.75)] {
            let hits = [[a, b, c], [b, d, c]].map(|t| test(DVec3::new(x, y, -2.0), DVec3::Z * 0.5, t));
            let depth = 1.0 + x + 3.0 * y + 2.0;
            assert_eq!(hits.into_iter().flatten().collect::<Vec<_>>(), [2.0 * depth], "{x} {y}");
        }
    }

    #[test]
    fn normals_are_right_at_every_size() {
        for size in [1e-300, 1e-150, 1e-72, 1e-68, 1.0, 1e68, 1e72, 1e150, 1e300] {
            let t = [DVec3::ZERO, size * DVec3::X, size * DVec3::Y];
            for (t, expected) in [(t, DVec3::Z), ([t[0], t[2], t[1]], -DVec3::Z)] {
                assert!((normal(t) - expected).length() < f64::EPSILON, "{size:e}");
            }
        }
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
        // Two small triangles share the long side of another, and a triangle without area fills the seam. Its
        // third corner lies exactly on that side.
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

    /// Rays and two points as bit patterns: direction, origin, p and q. The computed edge function of p and q
    /// has the wrong sign, and hill climbing made it as large as it could: 0.77, 0.84, 0.73 and 0.86 of the
    /// error bound.
    #[rustfmt::skip]
    const WORST: [[u64; 12]; 4] = [
        // The points are close to the ray compared with their distance along it,
        [0x3ff462c58f4473e3, 0xbff462c3841b646e, 0x3ff462c58f44750b, 0xbf9b3fd515406c23, 0xbf7f07473e70177b, 0x3fa5aadbc27c8810,
         0x3ff214a44971a339, 0xbff2a0a9036de5f1, 0x3ff32efa75fa281b, 0x3fefc2872847eff0, 0xbff06d4893ecf834, 0x3ff0fb99cc6d40e1],
        [0x3ff45ed4a899c19f, 0xbff45ed4335adb09, 0x3ff45ed4a899c2c6, 0x3f41c9cd9afe4c11, 0xbfa84c83c5eb512e, 0x3f8761b2bd743c40,
         0x3ff0b268385069c3, 0xbff17285bcb7a993, 0x3ff0def37c1dca1e, 0x3ff0135ce8b24de6, 0xbff0d39470bbc60d, 0x3ff03fe5fc7400ba],
        // about as far from it as along it,
        [0x3ff371ef42ed53df, 0xbff3ee97e4517352, 0x3ff3ee97e4519fe5, 0xbfee4ca3c40e83d8, 0x3fde46a795de4ee7, 0xbfcc3017a5b4ed30,
         0x3fc2e4a518224cb4, 0xbfe213ee9afceda3, 0x3fecd576874e7d3b, 0x3fc2bd5bf9fc151b, 0xbfe767fedf6a0f8d, 0x3fecd512b61cfb1f],
        // and no farther from it than the rounding errors.
        [0x3ff07312bf37470e, 0x3ff06b597f3fef5c, 0x3ff07313ffa0c5bb, 0x3fe3c84e95f06e43, 0x3feedf2b40d8ffd9, 0xbfd1ca6b47eec18a,
         0x3ffb2201614a5234, 0x400052aba04015ce, 0x3fe99681285b7b8a, 0x3ffb195c6b31c49c, 0x40004e5b2cc6698f, 0x3fe985373ad99da2],
    ];

    /// The ray, p and q.
    fn worst() -> [(Ray, [DVec3; 2]); 4] {
        WORST.map(|bits| {
            let vector = |i: usize| DVec3::from_array([0, 1, 2].map(|k| f64::from_bits(bits[3 * i + k])));
            (Ray::new(vector(1), vector(0)), [vector(2), vector(3)])
        })
    }

    #[test]
    fn the_worst_error_of_an_edge_function_is_between_two_thirds_and_all_of_the_bound() {
        for (ray, [p, q]) in worst() {
            let sheared = [p, q, p].map(|v| Shear::new(&ray).apply(&v));
            let [_, _, found] = edge_functions(sheared);
            let exact = projected_area(ray.direction, [ray.origin, p, q]).sign();
            assert!(exact as f64 * found < 0.0, "the case tests nothing: {exact} {found}");
            let ratio = found.abs() / edge_error_bound(sheared);
            assert!((2.0 / 3.0..1.0).contains(&ratio), "{ratio}");
        }
    }

    #[test]
    fn a_ray_beside_an_edge_where_rounding_is_worst_hits_one_triangle() {
        for (ray, [p, q]) in worst() {
            let shear = Shear::new(&ray);
            let [x, y, z] = shear.axes;
            // A point beside the edge, `times` as far from the ray as p is.
            let beside = |times: f64| {
                let seen = shear.apply(&p);
                let mut point = p;
                point[x] = ray.origin[x] + shear.scale.x * seen.z - times * seen.y;
                point[y] = ray.origin[y] + shear.scale.y * seen.z + times * seen.x;
                point[z] = p[z];
                point
            };
            let triangles = [[p, q, beside(0.9)], [q, p, beside(-1e5)]];
            let hits = triangles.iter().filter(|t| shear.intersect(t.each_ref()).is_some()).count();
            assert_eq!(hits, 1, "{ray:?}");
        }
    }
}
