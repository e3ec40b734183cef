//! Triangles by the watertight test of Woop, Benthin and Wald (JCGT 2(1), 2013), decided in f64
//! so that every ray through a closed mesh's shared edge or vertex hits exactly one triangle there.

use crate::math::ray::Ray;
use crate::math::robust::{difference_of_products, unit};
use glam::DVec3;

/// What the test needs of a ray, computed once per ray: the shear that turns its direction into
/// the z axis, and the axes permuted so that z is the one along which the ray is longest.
#[derive(Clone, Copy, Debug)]
pub struct Shear {
    origin: DVec3,
    axes: [usize; 3],
    /// x and y shear per unit of z; the scale that turns a depth along z into t.
    scale: DVec3,
}

/// A crossing, with the weights of the three vertices at it (not normalised).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    pub t: f64,
    pub weights: [f64; 3],
}

impl Crossing {
    /// The point of the triangle that is crossed: within rounding of its vertices, and never
    /// beyond an edge by more, however far away the ray began.
    pub fn point(&self, [a, b, c]: [DVec3; 3]) -> DVec3 {
        let [u, v, w] = self.weights;
        (u * a + v * b + w * c) / (u + v + w)
    }
}

impl Shear {
    pub fn new(ray: &Ray) -> Self {
        let d = ray.direction;
        let z = if d.x.abs() > d.y.abs() {
            if d.x.abs() > d.z.abs() { 0 } else { 2 }
        } else if d.y.abs() > d.z.abs() {
            1
        } else {
            2
        };
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        // Without a length no t is right; NaN makes every triangle a miss.
        let inverse = if d[z].is_finite() { 1.0 / d[z] } else { f64::NAN };
        Self { origin: ray.origin, axes: [x, y, z], scale: DVec3::new(d[x] / d[z], d[y] / d[z], inverse) }
    }

    /// A vertex seen along the ray: x and y across it, z the depth along the longest axis.
    #[inline(always)]
    fn apply(&self, vertex: DVec3) -> DVec3 {
        let v = vertex - self.origin;
        let [x, y, z] = self.axes;
        DVec3::new(v[x] - self.scale.x * v[z], v[y] - self.scale.y * v[z], v[z])
    }

    /// Where the ray's line crosses the triangle, whatever its winding; any t, also a negative one.
    ///
    /// The three edge functions are exact in sign, since a rounded product difference that is not
    /// zero has the right sign and one that is zero is recomputed. Both triangles at an edge see
    /// the same two sheared vertices, so their edge functions are exact negatives, and where one is
    /// truly zero the tie is broken as if the ray were moved by an infinitesimal amount. The edge
    /// functions must not be contracted into fused operations: that breaks the antisymmetry.
    #[inline(always)]
    pub fn intersect(&self, vertices: [DVec3; 3]) -> Option<Crossing> {
        let [a, b, c] = vertices.map(|v| self.apply(v));
        let mut weights = [cross(b, c), cross(c, a), cross(a, b)];
        let [u, v, w] = weights;
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        if u == 0.0 || v == 0.0 || w == 0.0 {
            weights = decide_on_edge([a, b, c])?;
        }
        let [u, v, w] = weights;
        let t = self.scale.z * ((u * a.z + v * b.z + w * c.z) / (u + v + w));
        // The sum is zero only for a triangle seen edge on; a NaN comes from a broken ray.
        t.is_finite().then_some(Crossing { t, weights })
    }
}

/// The edge function of `p` and `q` in the sheared plane: twice the area they span with the ray.
#[inline(always)]
fn cross(p: DVec3, q: DVec3) -> f64 {
    p.x * q.y - p.y * q.x
}

/// The decision where the ray meets an edge within rounding: the edge functions if the ray, moved
/// by an infinitesimal amount, lies on one side of all three edges.
#[cold]
fn decide_on_edge([a, b, c]: [DVec3; 3]) -> Option<[f64; 3]> {
    let edges = [(b, c), (c, a), (a, b)];
    let weights = edges.map(|(p, q)| difference_of_products(p.x, q.y, p.y, q.x));
    let sides = [0, 1, 2].map(|i| side(weights[i], edges[i].0, edges[i].1));
    let inside = sides[0] != 0 && sides[0] == sides[1] && sides[1] == sides[2];
    inside.then_some(weights)
}

/// The sign of an edge function; of a zero one, as if the ray had moved towards negative x, and
/// infinitely less towards negative y. Zero only for an edge without length.
fn side(weight: f64, from: DVec3, to: DVec3) -> i32 {
    let sign = |x: f64| (x > 0.0) as i32 - (x < 0.0) as i32;
    [weight, to.y - from.y, from.x - to.x].into_iter().map(sign).find(|&s| s != 0).unwrap_or(0)
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
        Shear::new(&Ray::new(origin, direction)).intersect(triangle).map(|c| c.t)
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
    fn the_crossed_point_lies_in_the_triangle() {
        let t = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let ray = Ray::new(DVec3::new(0.25, 0.5, -1e9), DVec3::Z);
        let crossing = Shear::new(&ray).intersect(t);
        assert_eq!(crossing.map(|c| c.point(t)), Some(DVec3::new(0.25, 0.5, 0.0)));
    }
}
