//! The surfaces of triangles where four rays hit them, one ray in each SIMD lane.
//!
//! It differs from [`Shear`](crate::world::triangle::Shear) only in how the axes are permuted: that type chooses a
//! ray's longest axis by its index. Lanes that need exact arithmetic are left to single rays.

use super::edge_functions::{EdgeRange, edge_functions, sheared};
use super::surface::LEAST_PART;
use super::triangle::{interpolated, largest_coordinate, rounded_normal};
use crate::math::ray::Ray;
use crate::math::simd::{FourLanes, Number};
use crate::math::vector::Vector;
use fearless_simd::{Simd, f64x4};
use glam::DVec3;

/// Four triangles.
#[derive(Clone, Copy, Debug)]
pub struct Triangles4<S: Simd> {
    corners: [Vector<f64x4<S>>; 3],
    /// The outward unit normals.
    pub normals: [DVec3; 4],
    /// The largest absolute coordinate of the corners of each triangle.
    pub extents: [f64; 4],
    /// Points with smaller coordinates than these need exact arithmetic.
    least: f64x4<S>,
    /// The set of the triangles whose normals are accurate, bit 0 for the first one.
    accurate: u32,
}

/// The points where four rays hit four triangles.
#[derive(Clone, Copy, Debug)]
pub struct Hits4 {
    pub points: [DVec3; 4],
    /// The set of the rays for which rounded numbers suffice, bit 0 for the first one. The points and the normals of
    /// the other rays have no meaning.
    pub certain: u32,
}

impl<S: Simd> Triangles4<S> {
    /// Returns the triangles with these corners.
    #[inline(always)]
    pub fn new(simd: S, [p, q, r, s]: [[&DVec3; 3]; 4]) -> Self {
        let a = Vector::new(simd, [p[0], q[0], r[0], s[0]]);
        let b = Vector::new(simd, [p[1], q[1], r[1], s[1]]);
        let c = Vector::new(simd, [p[2], q[2], r[2], s[2]]);
        let (normals, accurate) = rounded_normal([a, b, c]);
        let extents: f64x4<S> = largest_coordinate([a, b, c]);
        let least = extents.broadcast(LEAST_PART) * extents;
        let (normals, extents) = (normals.to_array(), extents.to_array());
        Self { corners: [a, b, c], normals, extents, least, accurate }
    }

    /// Returns the points where each ray hits its triangle.
    #[inline(always)]
    pub fn hits(&self, simd: S, rays: [&Ray; 4]) -> Hits4 {
        let (weights, inside) = weights(simd, rays, self.corners);
        let points = interpolated(self.corners, weights);
        let Vector { x, y, z } = points.abs();
        let near = self.least.le_mask(x.max(y).max(z));
        Hits4 { points: points.to_array(), certain: inside & self.accurate & near }
    }
}

/// Returns the barycentric weights, and the set of the rays that certainly pass through their triangles.
#[inline(always)]
fn weights<S: Simd>(simd: S, rays: [&Ray; 4], [p, q, r]: [Vector<f64x4<S>>; 3]) -> ([f64x4<S>; 3], u32) {
    let [i, j, k, l] = rays;
    let origin = Vector::new(simd, [&i.origin, &j.origin, &k.origin, &l.origin]);
    let d = Vector::new(simd, [&i.direction, &j.direction, &k.direction, &l.direction]);
    let (p, q, r) = (p - origin, q - origin, r - origin);
    const ALL: u32 = 0b1111;
    match longest_axes(d) {
        (0, _) => sheared_weights(yzx(d), [yzx(p), yzx(q), yzx(r)]),
        (ALL, 0) => sheared_weights(zxy(d), [zxy(p), zxy(q), zxy(r)]),
        (ALL, ALL) => sheared_weights(d, [p, q, r]),
        // Few neighbours are longest along different axes. They are left to single rays.
        _ => ([d.x; 3], 0),
    }
}

/// Finds the axes along which these directions are longest, as a shear chooses them. Returns the set of the directions
/// that are not longest along x, and the set of those that are longest along z.
#[inline(always)]
fn longest_axes<S: Simd>(directions: Vector<f64x4<S>>) -> (u32, u32) {
    let Vector { x, y, z } = directions.abs();
    let is_z = x.le_mask(z) & y.le_mask(z);
    (x.le_mask(y) | x.le_mask(z), is_z)
}

#[inline(always)]
fn yzx<S: Simd>(Vector { x, y, z }: Vector<f64x4<S>>) -> Vector<f64x4<S>> {
    Vector { x: y, y: z, z: x }
}

#[inline(always)]
fn zxy<S: Simd>(Vector { x, y, z }: Vector<f64x4<S>>) -> Vector<f64x4<S>> {
    Vector { x: z, y: x, z: y }
}

/// Returns the weights for directions that are longest along z, and vertices relative to the rays' origins.
#[inline(always)]
fn sheared_weights<S: Simd>(
    direction: Vector<f64x4<S>>,
    [p, q, r]: [Vector<f64x4<S>>; 3],
) -> ([f64x4<S>; 3], u32) {
    let slopes = [direction.x / direction.z, direction.y / direction.z];
    let sheared = [sheared(p, slopes), sheared(q, slopes), sheared(r, slopes)];
    let weights = edge_functions(sheared);
    (weights, EdgeRange::new(weights, sheared).inside())
}

#[cfg(test)]
mod tests {
    use super::{DVec3, Hits4, Ray, Simd, Triangles4, Vector};
    use crate::math::instructions::{self, Level};
    use crate::sampling::drand48::Drand48;
    use crate::world::edge_functions::{Sides, edge_error_bound};
    use crate::world::triangle::{Shear, normal, point};
    use fearless_simd::dispatch;
    use rand::RngExt;

    /// Random numbers, some of them exceptional.
    struct Numbers(Drand48);

    impl Numbers {
        fn below(&mut self, n: usize) -> usize {
            (self.0.random::<f64>() * n as f64) as usize
        }

        fn number(&mut self) -> f64 {
            let x = self.0.random::<f64>() - 0.5;
            match self.below(200) {
                0 => f64::NAN,
                1 => f64::INFINITY.copysign(x),
                2 => x * 1e200,
                3 => x * 1e-200,
                4..10 => 0.0f64.copysign(x),
                10..20 => (4.0 * x).round(),
                _ => 4.0 * x,
            }
        }

        fn vector(&mut self) -> DVec3 {
            DVec3::new(self.number(), self.number(), self.number())
        }

        /// Returns a triangle; some are thin, large or small.
        fn triangle(&mut self) -> [DVec3; 3] {
            let [a, b, c] = [self.vector(), self.vector(), self.vector()];
            let scale = [1.0, 1e-90, 1e100, 1e-65, 1e-150, 1e150][[0, 0, 0, 1, 2, 3, 4, 5][self.below(8)]];
            let c = match self.below(6) {
                0 => a + 1e-8 * c,
                1 => a.lerp(b, 0.3) + 1e-9 * c,
                _ => c,
            };
            [a, b, c].map(|v| v * scale)
        }

        /// Returns a ray towards a triangle, most often through its inside or its boundary.
        fn ray(&mut self, [a, b, c]: [DVec3; 3], from: DVec3) -> Ray {
            let [u, v] = [self.0.random::<f64>(), self.0.random()];
            let target = match self.below(4) {
                0 => a.lerp(b, u),
                1 => a,
                _ => a.lerp(b.lerp(c, u), v),
            };
            let towards = target - from;
            Ray::new(from, if self.below(10) == 0 { self.vector() } else { towards })
        }
    }

    fn hits(triangle: [&DVec3; 3], rays: [&Ray; 4]) -> Hits4 {
        dispatch!(Level::baseline(), simd => Triangles4::new(simd, [triangle; 4]).hits(simd, rays))
    }

    fn bits(v: DVec3) -> [u64; 3] {
        v.to_array().map(f64::to_bits)
    }

    /// Compares every lane that is certain with the surface of one triangle. Returns the number of certain lanes, and
    /// the number that could have been certain.
    fn agree_with_one<S: Simd>(simd: S) -> [usize; 2] {
        let mut numbers = Numbers(Drand48::UNSEEDED);
        let mut counts = [0; 2];
        for k in 0..40_000 {
            // Rays towards one triangle often point along the same axis.
            let first = numbers.triangle();
            let triangles: [_; 4] =
                std::array::from_fn(|_| if k % 2 == 0 { first } else { numbers.triangle() });
            let from = numbers.vector() * if k % 3 == 0 { 1e3 } else { 1.0 };
            let start = |numbers: &mut Numbers| if k % 2 == 0 { from } else { numbers.vector() };
            let rays = triangles.map(|triangle| {
                let from = start(&mut numbers);
                numbers.ray(triangle, from)
            });
            let four = Triangles4::new(simd, triangles.each_ref().map(|t| t.each_ref()));
            let hits = four.hits(simd, rays.each_ref());
            for (lane, (triangle, ray)) in triangles.iter().zip(&rays).enumerate() {
                let shear = Shear::new(ray);
                let is_certain = hits.certain & (1 << lane) != 0;
                let sides = shear.sides(triangle.each_ref());
                counts[1] += usize::from(sides == Sides::Inside);
                if is_certain {
                    counts[0] += 1;
                    assert_eq!(sides, Sides::Inside, "{ray:?} {triangle:?}");
                    let weights = shear.weights(triangle.each_ref()).unwrap();
                    assert_eq!(
                        bits(hits.points[lane]),
                        bits(point(*triangle, weights)),
                        "{ray:?} {triangle:?}"
                    );
                    assert_eq!(bits(four.normals[lane]), bits(normal(*triangle)), "{triangle:?}");
                }
            }
        }
        counts
    }

    #[test]
    fn certain_lanes_have_the_bits_of_one_triangle() {
        let counts = dispatch!(Level::baseline(), simd => agree_with_one(simd));
        // The others point at edges or at needles.
        assert!(counts[0] > 5_000 && counts[0] < counts[1], "{counts:?}");
        for level in instructions::available() {
            assert_eq!(dispatch!(level, simd => agree_with_one(simd)), counts, "{level:?}");
        }
    }

    #[test]
    fn a_lane_at_the_error_bound_is_not_certain() {
        let [a, b] = [DVec3::new(1.0, 0.0, 1.0), DVec3::new(0.0, 1.0, 1.0)];
        let bound = edge_error_bound([a, b, DVec3::Z].map(Vector::from));
        for (step, swap) in (-20..=20).flat_map(|step| [(step, false), (step, true)]) {
            // Two edge functions are this large, since the third corner is so near to the ray.
            let distance = f64::from_bits(bound.to_bits().wrapping_add_signed(step));
            let c = DVec3::new(-distance, -distance, 1.0);
            let triangle = if swap { [b, a, c] } else { [a, b, c] };
            let (corners, ray) = (triangle.each_ref(), Ray::new(DVec3::ZERO, DVec3::Z));
            let certain = hits(corners, [&ray; 4]).certain;
            assert_eq!(Shear::new(&ray).sides(corners) == Sides::Inside, step > 0);
            assert_eq!(certain, if step > 0 { 0b1111 } else { 0 }, "{step}");
        }
    }

    #[test]
    fn rays_along_any_axes_have_the_points_of_one_triangle() {
        let triangle = [DVec3::new(3.0, 0.0, 0.0), DVec3::new(0.0, 3.0, 0.0), DVec3::new(0.0, 0.0, 3.0)];
        // Where two components are equal, a shear prefers z, and y to x.
        let targets = [[1.0, 0.5, 0.6], [0.5, 1.0, 0.6], [0.6, 0.5, 1.0], [1.0, 1.0, 0.5], [1.0, 0.5, 1.0]];
        let targets = targets.into_iter().chain([[0.5, 1.0, 1.0], [1.0, 1.0, 1.0]]);
        let rays: Vec<Ray> = targets.map(|target| Ray::new(DVec3::ZERO, DVec3::from_array(target))).collect();
        let count = rays.len();
        for k in 0..count.pow(4) {
            let four = [0, 1, 2, 3].map(|lane| &rays[k / count.pow(lane) % count]);
            let found = hits(triangle.each_ref(), four);
            let axes = four.map(|ray| {
                let [x, y, z] = ray.direction.to_array();
                usize::from(x <= y || x <= z) + usize::from(x <= z && y <= z)
            });
            assert_eq!(found.certain, if axes == [axes[0]; 4] { 0b1111 } else { 0 }, "{four:?}");
            for (lane, ray) in four.into_iter().enumerate().filter(|(lane, _)| found.certain >> lane & 1 != 0)
            {
                let weights = Shear::new(ray).weights(triangle.each_ref()).unwrap();
                assert_eq!(bits(found.points[lane]), bits(point(triangle, weights)), "{lane} {four:?}");
            }
        }
    }
}
