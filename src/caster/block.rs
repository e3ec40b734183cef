//! Blocks of eight triangles in single precision, relative to a frame: the data of the conservative test in
//! [`crate::caster::filter`], with the error bounds that `proofs/filter_portable.g` and `proofs/filter_fma.g` prove.

use crate::math::aabb::Aabb;
use crate::math::extremes::max;
use crate::world::World;
use bytemuck::{Pod, Zeroable};
use glam::DVec3;

/// The number of triangles in a block.
pub const LANES: usize = 8;

/// The id that stands for no primitive, for example in an empty lane.
pub const NONE: u32 = u32::MAX;

/// Eight triangles as a structure of arrays, in the coordinates of a [`Frame`]. A block takes seven cache
/// lines, and the data that the filter reads comes first. It is plain old data, so that zeroed memory is a
/// valid block.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Block {
    /// The x, y and z of the first corner. They are NaN in an empty lane, so that the lane fails every comparison.
    pub corner: [[f32; LANES]; 3],
    /// The edges from the second corner to the first, and from the first to the third.
    pub edges: [[[f32; LANES]; 3]; 2],
    /// The cross product of the edges.
    pub normal: [[f32; LANES]; 3],
    /// The error bounds of the filter for these triangles.
    pub error_bounds: FilterErrorBounds,
    /// The ids of the triangles in the world; [`NONE`] in an empty lane.
    pub ids: [u32; LANES],
    /// Fills the last cache line.
    _padding: [u32; 6],
}

impl Block {
    /// Returns a block of these triangles, which end at the first [`NONE`], without their coordinates.
    pub fn new(ids: [u32; LANES]) -> Self {
        Self { ids, ..Self::zeroed() }
    }

    /// Fills a new block with the coordinates of its triangles, which must lie in the frame's box.
    pub fn fill(&mut self, world: &World, frame: &Frame) {
        self.corner = [[f32::NAN; LANES]; 3];
        for (lane, id) in self.ids.into_iter().take_while(|&id| id != NONE).enumerate() {
            self.set(lane, frame, world.corners(id as usize));
        }
        // Empty lanes need no special case, since their edges are 0.
        let mut longest = [0.0f32; LANES];
        for row in self.edges.as_flattened() {
            longest = std::array::from_fn(|lane| max(longest[lane], row[lane].abs()));
        }
        let longest = longest.into_iter().fold(0.0, max);
        self.error_bounds = FilterErrorBounds::of(longest);
    }

    /// Stores a triangle in a lane.
    #[inline(always)]
    fn set(&mut self, lane: usize, frame: &Frame, [a, b, c]: [DVec3; 3]) {
        let corner = frame.point(a);
        let edges = [frame.vector(a - b), frame.vector(c - a)];
        let normal = edges[0].cross(edges[1]);
        for axis in 0..3 {
            self.corner[axis][lane] = corner[axis] as f32;
            self.edges[0][axis][lane] = edges[0][axis] as f32;
            self.edges[1][axis][lane] = edges[1][axis] as f32;
            self.normal[axis][lane] = normal[axis] as f32;
        }
    }
}

/// Negated error bounds of the filter's quantities for the triangles of a block. If the exact value of a quantity is
/// not negative, the computed value is at least the negated bound. The bounds are derived in [`crate::caster::filter`].
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct FilterErrorBounds {
    /// The bound of the edge functions u, v and w.
    pub edge: f32,
    /// The bound of n.s - t det.
    pub depth: f32,
}

/// The coefficient of r b in the error bound of w, the least accurate of u, v and w. Half of it is enough for u and v, but
/// one bound for the least of the three saves a comparison.
const EDGE_ROUNDINGS: f32 = 37.0;

/// The coefficient of r b^2 in the error bound of w.
const AREA_ROUNDINGS: f32 = 67.0;

/// The coefficient of r b^2 in the error bound of n.s - t det.
const DEPTH_ROUNDINGS: f32 = 82.0;

/// The coefficient of r b^3 in the error bound of n.s - t det, for the error of n.
const NORMAL_ROUNDINGS: f32 = 4.5;

/// Upper bound on the error due to underflow, which is less than 2^-144.
const UNDERFLOW: f32 = f32::MIN_POSITIVE;

impl FilterErrorBounds {
    /// Returns the error bounds of a block. `longest` is b, the largest absolute coordinate of its edges.
    pub fn of(longest: f32) -> Self {
        const ROUNDING: f32 = 1.0 / (1u32 << 24) as f32;
        let edge = EDGE_ROUNDINGS + AREA_ROUNDINGS * longest;
        let depth = (DEPTH_ROUNDINGS + NORMAL_ROUNDINGS * longest) * longest;
        let scale = ROUNDING * longest;
        Self { edge: -(edge * scale) - UNDERFLOW, depth: -(depth * scale) - UNDERFLOW }
    }
}

/// A coordinate system in which the coordinates of a box are from -1 to 1. Single precision represents the contents of
/// the box equally well, whatever the position and the size of the box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The centre of the box, with an unused fourth lane.
    pub center: [f64; 4],
    /// Frame units per unit of the world: a power of two, so that scaling is exact.
    pub scale: f64,
    /// The reciprocal of `scale`.
    pub unit: f64,
}

impl Frame {
    /// Returns the frame of a box that is not empty.
    pub fn new(bounds: &Aabb) -> Self {
        let center = 0.5 * (bounds.min + bounds.max);
        let max_abs_coord = (bounds.max - center).max(center - bounds.min).max_element();
        let exponent = libm::frexp(max_abs_coord).1;
        Self {
            center: [center.x, center.y, center.z, 0.0],
            scale: libm::ldexp(1.0, -exponent),
            unit: libm::ldexp(1.0, exponent),
        }
    }

    /// Converts a point to the coordinates of this frame.
    pub fn point(&self, point: DVec3) -> DVec3 {
        let [x, y, z, _] = self.center;
        (point - DVec3::new(x, y, z)) * self.scale
    }

    /// Converts a vector to the coordinates of this frame.
    pub fn vector(&self, vector: DVec3) -> DVec3 {
        vector * self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a frame with a unit of four world units.
    fn frame() -> Frame {
        Frame::new(&Aabb { min: DVec3::splat(2.0), max: DVec3::splat(6.0) })
    }

    #[test]
    fn the_error_bounds_are_these_roundings_of_edges() {
        let rounding = 2f32.powi(-24);
        for longest in [0.25, 0.5, 2.0] {
            let error_bounds = FilterErrorBounds::of(longest);
            let edge = (EDGE_ROUNDINGS + AREA_ROUNDINGS * longest) * longest * rounding;
            let depth = (DEPTH_ROUNDINGS + NORMAL_ROUNDINGS * longest) * longest * longest * rounding;
            assert_eq!((error_bounds.edge, error_bounds.depth), (-edge, -depth), "{longest}");
        }
        let least = FilterErrorBounds::of(0.0);
        assert_eq!((least.edge, least.depth), (-UNDERFLOW, -UNDERFLOW));
    }

    #[test]
    fn a_frame_counts_from_its_middle_in_its_unit() {
        let point = |x: f64, y: f64, z: f64| frame().point(DVec3::new(x, y, z));
        assert_eq!(point(6.0, 2.0, 3.0), DVec3::new(0.5, -0.5, -0.25));
        assert_eq!(frame().vector(DVec3::new(6.0, 2.0, -4.0)), DVec3::new(1.5, 0.5, -1.0));
        assert_eq!((frame().scale, frame().unit), (0.25, 4.0));
    }
}
