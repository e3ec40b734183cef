//! The conservative test of eight triangles in single precision: finds the triangles that a ray may hit.
//!
//! The filter reports only what it can prove. For each triangle it reports that the ray certainly misses it, that the
//! ray certainly hits it, or that double precision must decide.
//!
//! It uses the test of Moeller and Trumbore ("Fast, Minimum Storage Ray/Triangle Intersection", Journal of Graphics
//! Tools 2(1), 1997) without the division, rearranged so that the cross product of the edges can be stored. Let s be
//! the vector from the ray's origin to the triangle's first corner, e1 the edge from the second corner to the first, e2
//! the edge from the first corner to the third, n = e1 x e2, q = d x s, and det = n.d the determinant. The ray hits the
//! triangle if u = e2.q, v = e1.q and w = det - u - v have the sign of the determinant. The hit is at t = n.s / det.
//!
//! *Error bound.* Let r = 2^-24 be the unit roundoff of single precision, b the largest absolute coordinate of the
//! block's edges. In the block's [`Frame`](crate::caster::block::Frame) the coordinates of the corners are at most 1, and
//! the ray's origin is moved along the ray to the point where it enters the box. Its coordinates are then at most 1, the
//! largest coordinate of the direction is 1, and b <= 2. Stored numbers are rounded once. Sums of three products are
//! determinants, and a determinant of numbers of at most 1 is at most 4: it is linear in each number, so the maximum is
//! reached when all are 1 or -1. With p the vector from the first corner to the point where the ray meets the triangle's
//! plane, s = t d - p; hence q = p x d, which is small for a small triangle. This table leaves out terms of less than
//! r/10:
//!
//! | quantity | at most | error at most, portable | with fused multiply-add |
//! |---|---|---|---|
//! | s | 2 | 2 r: corner and origin r / 2 each, their difference r | |
//! | n | 2 b^2 | 2 r b^2 | |
//! | det = n.d | 4 b^2 | 18 r b^2: n 4, d 2, rounding 3 * 4 | 16 |
//! | q = d x s | 2 b | by its own rounding 2 r of the products and 2 r b | 1; 2 |
//! | u = e2.q | 4 b^2 | 18 r b: d 4, s 8, q 6; 20 r b^2: e2 4, q 4, rounding 3 * 4 | 15; 18 |
//! | v = e1.q | 4 b^2 | as u | |
//! | w | 4 b^2 | 36 r b of u and v; 66 r b^2: u and v 40, det 18, rounding 8 | 30; 60 |
//! | n.s | 8 b^2 | 40 r b^2: n 8, s 8, rounding 3 * 8 | 36 |
//! | n.s - t det | | 81 r b^2 + 4 r b^3 for a hit at t <= 2.03, see [`Verdict::depths`] | 74 |
//!
//! `proofs/filter_portable.g` and `proofs/filter_fma.g` prove these sums, including the terms of second order
//! and the error of the test in double precision: a few 2^-53 of the distance to the ray's origin, which is
//! below r for origins up to 2^20 frame units away. Rays from farther away are not tested by the filter.
//! The proofs also show that a wrong sign of det does no harm, and that the bounds hold for misses that are
//! nearly hits. [`FilterErrorBounds`] rounds the bounds up and adds an allowance for underflow.

use crate::caster::block::{Block, FilterErrorBounds, Frame, LANES};
use crate::caster::bounds::RayInterval;
use crate::math::instructions::Level;
use crate::math::simd::{FourLanes, Number, RayLanes};
use fearless_simd::prelude::*;
use fearless_simd::{dispatch, f32x8, f64x4, u32x8};

/// Upper bound on the depth of a hit, which is its t in the coordinates of the frame: the box is at most 2 wide, and
/// the largest coordinate of the direction is 1. Larger depths are clamped to this bound, which loses no hit. The part
/// above 2 is for the errors of the coordinates of the box and the ray, and far larger than these errors.
pub const MAX_DEPTH: f64 = 2.03125;

/// A ray in single precision, in the coordinates of a frame. Its origin lies in the frame's box.
#[derive(Clone, Copy, Debug)]
pub struct FilterRay {
    /// The point where the ray enters the box; the fourth lane is unused.
    pub origin: [f32; 4],
    /// The direction, with a largest absolute coordinate of 1; the fourth lane is unused.
    pub direction: [f32; 4],
    /// The depth up to which a hit counts.
    pub max_depth: f32,
}

/// A ray in the filter's coordinates, up to the nearest hit so far.
pub struct FilterState {
    pub ray: FilterRay,
    /// The t at which the filter's ray starts.
    entry: f64,
    /// The depth per unit of t, and its inverse.
    depth_per_t: f64,
    t_per_depth: f64,
}

impl FilterState {
    /// Returns the state for a ray on its interval in the bounds, up to t = `last`.
    #[inline(always)]
    pub fn new<S: Simd>(interval: &RayInterval<S>, frame: &Frame, last: f64) -> Self {
        let RayInterval { entry, ray_lanes, .. } = interval;
        let (entry, RayLanes { origin, direction, inv_direction }) = (*entry, *ray_lanes);
        let largest = Number::abs(direction).max3();
        // The inverse of the largest component, without another division.
        let inv_largest = Number::abs(inv_direction).min3();
        let scale = direction.broadcast(frame.scale);
        let center = f64x4::simd_from(direction.proof(), frame.center);
        let origin = (origin - center + direction.broadcast(entry) * direction) * scale;
        let direction = (direction * direction.broadcast(inv_largest)).to_f32();
        let ray = FilterRay { origin: origin.to_f32(), direction, max_depth: 0.0 };
        let (depth_per_t, t_per_depth) = (largest * frame.scale, inv_largest * frame.unit);
        let mut filter_state = Self { ray, entry, depth_per_t, t_per_depth };
        filter_state.shorten(last);
        filter_state
    }

    /// Converts a depth to t.
    #[inline(always)]
    pub fn t(&self, depth: f32) -> f64 {
        self.entry + f64::from(depth) * self.t_per_depth
    }

    /// Ends the ray at t = `last`.
    #[inline(always)]
    pub fn shorten(&mut self, last: f64) {
        let max_depth = (last - self.entry) * self.depth_per_t;
        self.ray.max_depth = if max_depth < MAX_DEPTH { max_depth } else { MAX_DEPTH } as f32;
    }
}

/// The filter's result for a block. Sets of lanes have bit 0 for the first lane.
#[derive(Clone, Copy, Debug)]
pub struct Verdict {
    /// The lanes that may be hit; all others are certainly missed.
    pub possible: u32,
    /// The lanes that are certainly hit, before the ray's maximum depth.
    pub certain: u32,
    /// n.s of each lane, negated if the determinant is negative. Valid only for possible hits.
    depth: [f32; LANES],
    /// The absolute value of the determinant of each lane. Valid only for possible hits.
    det: [f32; LANES],
}

impl Verdict {
    const NONE: Self = Self { possible: 0, certain: 0, depth: [0.0; LANES], det: [0.0; LANES] };

    /// Returns a lower and an upper bound on the depth of the hit in a lane that is certain.
    ///
    /// The parts of the error bound are 32 r b^2 for s and the roundings of n.s, 28.5 for d and the roundings of det,
    /// 16.3 for the roundings of these quotients, and 4 for the arithmetic in double precision that follows. The error
    /// of n moves n.s and t det together: it counts times n.(s - t d) = -n.p, which makes 4 r b^3.
    #[inline(always)]
    pub fn depths(&self, lane: usize, block: &Block) -> [f32; 2] {
        let (depth, det) = (self.depth[lane], self.det[lane]);
        let negated_bound = block.error_bounds.depth;
        [(depth + negated_bound) / det, (depth - negated_bound) / det]
    }
}

/// Tests a block against a ray. Leaves out the triangles with one of two ids.
///
/// The verdicts of different instruction sets may differ. All of them are correct, so the hits do not depend on them.
#[inline(always)]
pub(crate) fn test<S: Simd>(simd: S, block: &Block, ray: &FilterRay, left_out: [u32; 2]) -> Verdict {
    let ([ox, oy, oz, _], [dx, dy, dz, _]) = (ray.origin, ray.direction);
    let d = [f32x8::splat(simd, dx), f32x8::splat(simd, dy), f32x8::splat(simd, dz)];
    let [x, y, z] = load(simd, &block.corner);
    let (e1, e2) = (load(simd, &block.edges[0]), load(simd, &block.edges[1]));
    let n = load(simd, &block.normal);
    let s = [x - ox, y - oy, z - oz];
    let q = cross(d, s);
    let (det, u, v, depth) = (dot(n, d), dot(e2, q), dot(e1, q), dot(n, s));
    // All quantities are negated if the determinant is negative.
    let sign = det.to_bits() & f32x8::splat(simd, -0.0).to_bits();
    let negated = |x: f32x8<S>| f32x8::from_bits(x.to_bits() ^ sign);
    let (u, v, depth) = (negated(u), negated(v), negated(depth));
    let det = det.abs();
    let w = det - (u + v);
    // In an empty lane all of them are NaN, which fails the comparisons.
    let inside = u.min(v).min(w);
    let before = det.mul_sub(ray.max_depth, depth);
    let depth_inside = depth.min(before);
    let FilterErrorBounds { edge, depth: along } = block.error_bounds;
    let possible = (inside.simd_ge(edge) & depth_inside.simd_ge(along)).to_bitmask() as u32;
    if possible == 0 {
        return Verdict::NONE;
    }
    let ids = u32x8::simd_from(simd, block.ids);
    let left_out = (ids.simd_eq(left_out[0]) | ids.simd_eq(left_out[1])).to_bitmask() as u32;
    let possible = possible & !left_out;
    if possible == 0 {
        return Verdict::NONE;
    }
    let certain = (inside.simd_gt(-edge) & depth_inside.simd_gt(-along)).to_bitmask() as u32;
    Verdict { possible, certain: certain & !left_out, depth: depth.into(), det: det.into() }
}

/// Tests a block with an instruction set chosen at run time, for tests of the filter alone.
pub fn test_at(level: Level, block: &Block, ray: &FilterRay, left_out: [u32; 2]) -> Verdict {
    dispatch!(level, simd => test(simd, block, ray, left_out))
}

/// Loads the three axes of eight lanes.
#[inline(always)]
fn load<S: Simd>(simd: S, [x, y, z]: &[[f32; LANES]; 3]) -> [f32x8<S>; 3] {
    [f32x8::simd_from(simd, *x), f32x8::simd_from(simd, *y), f32x8::simd_from(simd, *z)]
}

/// Returns a0 b0 + (a1 b1 + a2 b2), fused if the instruction set can.
#[inline(always)]
fn dot<S: Simd>(a: [f32x8<S>; 3], b: [f32x8<S>; 3]) -> f32x8<S> {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

/// Returns the cross product a x b, fused if the instruction set can.
#[inline(always)]
fn cross<S: Simd>(a: [f32x8<S>; 3], b: [f32x8<S>; 3]) -> [f32x8<S>; 3] {
    [a[1].mul_sub(b[2], a[2] * b[1]), a[2].mul_sub(b[0], a[0] * b[2]), a[0].mul_sub(b[1], a[1] * b[0])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::caster::block::NONE;
    use crate::math::aabb::Aabb;
    use crate::math::instructions;
    use crate::world::test_worlds::world_of_triangles;
    use glam::DVec3;

    /// A ray along z from -0.75 on, for a distance of 1.
    const RAY: FilterRay =
        FilterRay { origin: [0.0, 0.0, -0.75, 0.0], direction: [0.0, 0.0, 1.0, 0.0], max_depth: 1.0 };

    /// Triangles across the z axis, each by its corners and its z.
    fn block(triangles: [([[f64; 2]; 3], f64); LANES]) -> Block {
        let placed = |(corners, z): ([[f64; 2]; 3], f64)| corners.map(|[x, y]| DVec3::new(x, y, z));
        let world = world_of_triangles(triangles.map(placed), &[]);
        let frame = Frame::new(&Aabb { min: DVec3::splat(-0.9), max: DVec3::splat(0.9) });
        let mut block = Block::new(std::array::from_fn(|i| i as u32));
        block.fill(&world, &frame);
        block
    }

    #[test]
    fn what_is_clear_is_decided_and_what_is_within_an_error_bound_is_not() {
        let [front, aside, edge] = [
            [[-0.5, -0.5], [0.5, -0.5], [0.0, 0.25]],
            [[0.2, -0.5], [0.8, -0.5], [0.5, 0.5]],
            [[0.0, -0.5], [0.5, 0.0], [0.0, 0.5]],
        ];
        let back = [front[0], front[2], front[1]];
        let block = block([
            (front, 0.0),
            (front, -0.75),
            (front, 0.25),
            (aside, 0.0),
            (edge, 0.0),
            (back, 0.125),
            (front, -0.875),
            (front, 0.5),
        ]);
        for level in instructions::available() {
            let verdict = test_at(level, &block, &RAY, [NONE; 2]);
            assert_eq!((verdict.possible, verdict.certain), (0b0011_0111, 0b0010_0001), "{level:?}");
            for (lane, t) in [(0, 0.75), (5, 0.875)] {
                let [min, max] = verdict.depths(lane, &block);
                assert!(min < t && t < max && max - min < 1e-3, "{level:?} {min} {max}");
            }
        }
    }

    #[test]
    fn the_depth_of_a_filter_ray_ends_where_the_ray_does() {
        let mut state = FilterState { ray: RAY, entry: 2.0, depth_per_t: 4.0, t_per_depth: 0.25 };
        state.shorten(2.4375);
        assert_eq!(state.ray.max_depth, 1.75);
        state.shorten(2.5);
        assert_eq!((state.ray.max_depth, state.t(2.0)), (2.0, 2.5));
        state.shorten(0.5);
        assert_eq!(state.ray.max_depth, -6.0);
        for far in [f64::INFINITY, f64::NAN, 1e300, 2.0 + MAX_DEPTH / 4.0] {
            state.shorten(far);
            assert_eq!(f64::from(state.ray.max_depth), MAX_DEPTH, "{far}");
        }
    }
}
