//! Nodes of eight boxes in single precision, relative to a [`Frame`](crate::caster::block::Frame), and the conservative
//! test that finds the boxes that a ray may meet.
//!
//! The test is the slab method (Kay and Kajiya, "Ray Tracing Complex Scenes", SIGGRAPH 1986) for eight boxes at once,
//! as in Wald, Benthin and Boulos ("Getting Rid of Packets", IEEE Symposium on Interactive Ray Tracing 2008).
//!
//! *Error bound.* Boxes are padded by [`PADDING`]. So the test certainly finds a box in which the ray hits something,
//! with an entry not later than the hit. Let r = 2^-24 be the unit roundoff of single precision. Along an axis let o
//! and d be the stored origin and direction of the ray, whose exact values are at most 1. At the depth t of an exact
//! hit, the point of the stored ray is off by r for the origin and 2.03 r for the direction. The stored face is off by
//! r, and by another 2 r if it is a cell's face, because the corners of cells are rounded. The depth of a face at l is
//! computed from the inverse i of d as l i - o i, where each of i, o i, l i and the difference is rounded once, which
//! moves the face by at most (2 |l - o| + |o| + |l|) r, which is 6 r. Together these are 12.1 r. The padding of 16 r
//! leaves enough for the maximum depth, which is also rounded, and for hits at the ray's entry into the frame's box.
//! `proofs/box8.g` proves these sums. A direction of less than 2^-60 counts as 2^-60, which moves the ray by less than
//! 2^-58.

use crate::caster::block::LANES;
use crate::caster::filter::FilterRay;
use fearless_simd::prelude::*;
use fearless_simd::{f32x4, f32x8};

/// The distance by which boxes are padded on each side, in roundings of single precision.
const PADDING_ROUNDINGS: f64 = 16.0;

/// The distance by which boxes are padded on each side, in units of the frame.
pub const PADDING: f64 = PADDING_ROUNDINGS / (1u32 << 24) as f64;

/// The smallest absolute value of a direction, so that its inverse is finite.
const MIN_DIRECTION: f32 = 1.0 / (1u64 << 60) as f32;

/// Eight boxes and their children. A node takes four cache lines.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Box8 {
    /// By axis: the lower and the upper faces. The faces of an empty lane are infinite, with the lower above the upper.
    faces: [[[f32; LANES]; 2]; 3],
    /// The child in each box. This module does not interpret it.
    pub children: [u32; LANES],
}

impl Box8 {
    /// A node without boxes.
    pub const EMPTY: Self =
        Self { faces: [[[f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]]; 3], children: [0; LANES] };

    /// Stores a padded box and its child in a lane.
    pub fn set(&mut self, lane: usize, corners: [impl Into<[f32; 3]>; 2], child: u32) {
        let [min, max] = corners.map(Into::into);
        for axis in 0..3 {
            self.faces[axis][0][lane] = min[axis];
            self.faces[axis][1][lane] = max[axis];
        }
        self.children[lane] = child;
    }
}

/// A ray for the test, in the coordinates of the frame. The fourth lane of arrays is unused.
#[derive(Clone, Copy, Debug)]
pub struct BoxRay {
    /// The inverse of the direction.
    inverse: [f32; 4],
    /// The origin times the inverse.
    scaled_origin: [f32; 4],
    /// The face that is met first along each axis, one bit per axis: 0 for the lower one, 1 for the upper one.
    near: u32,
}

impl BoxRay {
    /// Converts the filter's ray.
    #[inline(always)]
    pub fn new<S: Simd>(simd: S, ray: &FilterRay) -> Self {
        let direction = f32x4::simd_from(simd, ray.direction);
        let least = f32x4::splat(simd, MIN_DIRECTION);
        let direction = direction.abs().simd_lt(least).select(least, direction);
        let inverse = 1.0 / direction;
        let scaled_origin = f32x4::simd_from(simd, ray.origin) * inverse;
        let near = inverse.simd_lt(0.0).to_bitmask() as u32;
        Self { inverse: inverse.into(), scaled_origin: scaled_origin.into(), near }
    }
}

/// The boxes that a ray may meet.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// The set of lanes, bit 0 for the first.
    pub set: u32,
    /// The depth at which the ray enters the box of each lane in the set. It is at most the depth of any hit in the
    /// box.
    pub entries: [f32; LANES],
}

/// Finds the boxes that a ray may meet up to a maximum depth.
#[inline(always)]
pub(crate) fn meet<S: Simd>(simd: S, node: &Box8, ray: &BoxRay, max_depth: f32) -> Meeting {
    let near = |axis: usize| depths(simd, node, ray, axis, ray.near >> axis);
    let far = |axis: usize| depths(simd, node, ray, axis, !ray.near >> axis);
    let entry = near(0).max(near(1)).max(near(2).max(0.0));
    let exit = far(0).min(far(1)).min(far(2).min(max_depth));
    Meeting { set: exit.simd_ge(entry).to_bitmask() as u32, entries: entry.into() }
}

/// Returns the depths at which the ray meets one face of each box along an axis: the upper one if the last bit of `face`
/// is 1, and otherwise the lower one.
#[inline(always)]
fn depths<S: Simd>(simd: S, node: &Box8, ray: &BoxRay, axis: usize, face: u32) -> f32x8<S> {
    let faces = node.faces[axis][(face & 1) as usize];
    f32x8::simd_from(simd, faces).mul_sub(ray.inverse[axis], ray.scaled_origin[axis])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::instructions::{self, Level};
    use crate::math::worst_case::Rng;
    use fearless_simd::dispatch;
    use glam::DVec3;

    fn meet(level: Level, node: &Box8, ray: &FilterRay) -> Meeting {
        dispatch!(level, simd => super::meet(simd, node, &BoxRay::new(simd, ray), ray.max_depth))
    }

    /// Returns a node with a single box in the last lane, padded by `padding`.
    fn node([min, max]: [DVec3; 2], padding: f64) -> Box8 {
        let mut node = Box8::EMPTY;
        node.set(LANES - 1, [(min - padding).as_vec3(), (max + padding).as_vec3()], 5);
        node
    }

    fn ray(origin: DVec3, direction: DVec3, max_depth: f64) -> FilterRay {
        let four = |v: DVec3| v.extend(0.0).as_vec4().to_array();
        FilterRay { origin: four(origin), direction: four(direction), max_depth: max_depth as f32 }
    }

    #[test]
    fn a_ray_meets_the_boxes_that_it_passes_up_to_its_depth() {
        let mut node = Box8::EMPTY;
        for (lane, x) in [(0, -0.5f32), (3, 0.25), (6, 0.5)] {
            node.set(lane, [[x, -0.125, -0.125], [x + 0.125, 0.125, 0.125]], lane as u32);
        }
        for level in instructions::available() {
            let meets = |direction: DVec3, max_depth: f64| {
                meet(level, &node, &ray(DVec3::ZERO, direction, max_depth)).set
            };
            assert_eq!(meets(DVec3::X, 2.0), 0b100_1000, "{level:?}");
            assert_eq!(meets(DVec3::X, 0.375), 0b1000);
            assert_eq!(meets(-DVec3::X, 2.0), 0b1);
            assert_eq!(meets(DVec3::new(1.0, 0.375, 0.0), 2.0), 0b1000);
            assert_eq!(meets(DVec3::new(1.0, 0.0, -1.0), 2.0), 0);
            let meeting = meet(level, &node, &ray(DVec3::X * 0.3, DVec3::X, 1.0));
            assert_eq!((meeting.set, meeting.entries[3]), (0b100_1000, 0.0));
            assert!((meeting.entries[6] - 0.2).abs() < 1e-6);
        }
    }

    /// Casts many rays to points in flat and in tiny boxes. Returns the number of rays that miss the box, or meet it
    /// only after the point.
    fn missed(level: Level, padding: f64) -> usize {
        let rng = &mut Rng(1);
        let mut count = 0;
        for _ in 0..20_000 {
            let (corner, size) = (0.999 * rng.vector(), libm::exp2(-30.0 * rng.unit()));
            let mut extent = DVec3::new(rng.unit(), rng.unit(), rng.unit()) * size;
            extent[rng.below(3)] = 0.0;
            let max = (corner + extent).min(DVec3::ONE);
            let hit = corner + (max - corner) * DVec3::new(rng.unit(), rng.unit(), rng.unit()).round();
            let mut origin = rng.vector();
            // Some rays are parallel to an axis or almost so.
            let axis = rng.below(6);
            if axis < 3 {
                origin[axis] = hit[axis] + [0.0, 1e-30, -1e-12][rng.below(3)];
            }
            let depth = (hit - origin).abs().max_element();
            let ray = ray(origin, (hit - origin) / depth, depth);
            let meeting = meet(level, &node([corner, max], padding), &ray);
            let is_met = meeting.set == 1 << (LANES - 1) && meeting.entries[LANES - 1] <= ray.max_depth;
            count += usize::from(!is_met);
        }
        count
    }

    #[test]
    fn a_hit_in_a_box_is_never_missed_and_would_be_without_the_padding() {
        for level in instructions::available() {
            assert_eq!(missed(level, PADDING), 0, "{level:?}");
            assert!(missed(level, PADDING / 16.0) > 0, "{level:?}");
            assert!(missed(level, 0.0) > 1000, "{level:?}");
        }
    }
}
