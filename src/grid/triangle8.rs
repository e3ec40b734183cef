//! Triangles as the filter wants them: eight side by side, in single precision around one centre.

use crate::math::aabb::Aabb;
use crate::math::extremes::{box_corners, max, max3};
use crate::world::World;
use bytemuck::{Pod, Zeroable};
use glam::DVec3;

/// Triangles in a block.
pub const LANES: usize = 8;

/// The number of no primitive, in a lane that holds no triangle.
pub const NONE: u32 = u32::MAX;

/// Eight triangles, structure of arrays, in the coordinates of a [`Frame`]: seven cache lines, with
/// what the filter reads in front. Plain numbers, so that it may stand in any memory.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Block {
    /// x, y and z of the first corner; NaN in an empty lane, which no test passes.
    pub corner: [[f32; LANES]; 3],
    /// From the second corner to the first, and from the first to the third.
    pub edges: [[[f32; LANES]; 3]; 2],
    /// The edges' cross product.
    pub normal: [[f32; LANES]; 3],
    /// How far the filter may be off for these triangles.
    pub error_bounds: FilterErrorBounds,
    /// The triangles' numbers in their world; [`NONE`] in an empty lane.
    pub ids: [u32; LANES],
    /// In a cell's last block: where in the list of what is no triangle the cell's own begin and end.
    pub non_triangles: [u32; 2],
    /// In a cell's first block: how many there are.
    pub count: u32,
    /// The rest of the last cache line.
    _rest: [u32; 3],
}

impl Block {
    /// Fills a block of zeros with the triangles of these numbers, which end at the first [`NONE`].
    /// `all_within` says that the frame's box holds them all.
    pub fn fill(&mut self, world: &World, frame: &Frame, all_within: bool, ids: &[u32; LANES]) {
        self.ids = *ids;
        self.corner = [[f32::NAN; LANES]; 3];
        let mut max_abs_coord_of_lanes = 1.0;
        let used = ids.iter().take_while(|&&id| id != NONE);
        for (lane, &id) in used.enumerate() {
            let corners = world.corners(id as usize);
            let max_abs_coord = if all_within { 1.0 } else { frame.max_abs_coord(corners) };
            if max_abs_coord <= MAX_CORNER_COORD {
                self.set(lane, frame, corners);
                max_abs_coord_of_lanes = f64::max(max_abs_coord_of_lanes, max_abs_coord);
            } else {
                // All zeros: the filter never rejects it, nor is ever certain of it.
                self.corner.iter_mut().for_each(|row| row[lane] = 0.0);
            }
        }
        // Straight through all lanes, since an empty one's edges are 0.
        let mut longest = [0.0f32; LANES];
        for row in self.edges.as_flattened() {
            longest = std::array::from_fn(|lane| max(longest[lane], row[lane].abs()));
        }
        let longest = longest.into_iter().fold(0.0, max);
        self.error_bounds = FilterErrorBounds::of(longest, max_abs_coord_of_lanes);
    }

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

/// No corner in a block has a larger coordinate. In the frame of a grid within a cell a triangle may
/// reach far out; one that reaches farther is left open, for the sake of its neighbours' error bounds.
const MAX_CORNER_COORD: f64 = 4.0;

/// How far below zero the filter's quantities may come out for the triangles of one block where in truth
/// they are not negative: minus the error bounds that are derived in [`super::filter`].
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct FilterErrorBounds {
    /// u, v and w.
    pub edge: f32,
    /// n.s - t det.
    pub depth: f32,
}

/// Roundings of w, the largest of the three, that are as large as those of an edge times a corner.
const EDGE_ROUNDINGS: f32 = 37.0;

/// Further ones, as large as those of an edge squared.
const AREA_ROUNDINGS: f32 = 67.0;

/// Roundings of n.s - t det, of numbers as large as an edge squared times a corner.
const DEPTH_ROUNDINGS: f32 = 113.5;

/// More than all that single precision loses where its products underflow, less than 2^-144.
const UNDERFLOW: f32 = f32::MIN_POSITIVE;

impl FilterErrorBounds {
    /// `longest` is b, the largest absolute coordinate of the block's edges, and `max_abs_coord_of_lanes` that of its
    /// corners, from which c follows: a power of two, so that a division by it rounds nothing.
    pub fn of(longest: f32, max_abs_coord_of_lanes: f64) -> Self {
        const ROUNDING: f32 = 1.0 / (1u32 << 24) as f32;
        let mut corner = 1.0;
        while f64::from(corner) < max_abs_coord_of_lanes {
            corner *= 2.0;
        }
        let edge = EDGE_ROUNDINGS * corner + AREA_ROUNDINGS * longest;
        let depth = DEPTH_ROUNDINGS * corner * longest;
        let scale = ROUNDING * longest;
        Self { edge: -(edge * scale) - UNDERFLOW, depth: -(depth * scale) - UNDERFLOW }
    }
}

/// Coordinates in which a box lies within -1 and 1, so that single precision can hold what is in it
/// wherever the box stands and however large it is.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// With a spare place.
    pub center: [f64; 4],
    /// A power of two: scaling by it is exact.
    pub scale: f64,
    /// Its inverse.
    pub unit: f64,
}

impl Frame {
    /// Of a box that is not empty.
    pub fn new(bounds: &Aabb) -> Self {
        let center = 0.5 * (bounds.min + bounds.max);
        let max_abs_coord = (bounds.max - center).max(center - bounds.min).max_element();
        // 2^-e for the least 2^e above the reach.
        let exponent = libm::frexp(max_abs_coord).1;
        Self {
            center: [center.x, center.y, center.z, 0.0],
            scale: libm::ldexp(1.0, -exponent),
            unit: libm::ldexp(1.0, exponent),
        }
    }

    /// Whether a box, and so whatever is in it, lies within -1 and 1.
    pub fn holds(&self, bounds: &Aabb) -> bool {
        let [low, high] = [bounds.min, bounds.max].map(|corner| self.point(corner));
        low.min_element() >= -1.0 && high.max_element() <= 1.0
    }

    /// The largest absolute coordinate of three corners.
    fn max_abs_coord(&self, [a, b, c]: [DVec3; 3]) -> f64 {
        let points = [self.point(a).abs(), self.point(b).abs(), self.point(c).abs()];
        max3(box_corners(points)[1].to_array())
    }

    /// A point in these coordinates.
    pub fn point(&self, point: DVec3) -> DVec3 {
        let [x, y, z, _] = self.center;
        (point - DVec3::new(x, y, z)) * self.scale
    }

    /// A vector in these coordinates.
    pub fn vector(&self, vector: DVec3) -> DVec3 {
        vector * self.scale
    }
}
