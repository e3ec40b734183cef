//! Triangles as the filter wants them: eight side by side, in single precision around one centre.

use crate::math::aabb::Aabb;
use crate::world::World;
use glam::DVec3;

/// Triangles in a block.
pub const LANES: usize = 8;

/// The number of no primitive, in a lane that holds no triangle.
pub const NONE: u32 = u32::MAX;

/// Eight triangles, structure of arrays, in the coordinates of a [`Frame`]: five cache lines with
/// all that the filter reads and nothing else.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Block {
    /// x, y and z of the first corner; NaN in an empty lane, which no test passes.
    pub corner: [[f32; LANES]; 3],
    /// From the first corner to the second and to the third.
    pub edges: [[[f32; LANES]; 3]; 2],
    /// How far the filter may be off for these triangles.
    pub slack: Slack,
    /// Whether the cell's blocks end here.
    pub is_last: bool,
    /// Whether the cell holds anything but triangles.
    pub has_others: bool,
}

/// The numbers of a block's triangles in their world; [`NONE`] in an empty lane.
pub type Numbers = [u32; LANES];

impl Block {
    /// Holds nothing, and is its cell's last.
    pub const EMPTY: Self = Self {
        corner: [[f32::NAN; LANES]; 3],
        edges: [[[0.0; LANES]; 3]; 2],
        slack: Slack { edge: 0.0, depth: 0.0 },
        is_last: true,
        has_others: false,
    };

    /// Of at most eight triangles.
    pub fn fill(&mut self, world: &World, frame: &Frame, triangles: &[u32]) {
        let mut longest = 0.0f32;
        for (lane, &number) in triangles.iter().enumerate() {
            let [a, b, c] = world.corners(number as usize);
            let corner = frame.point(a);
            let edges = [frame.vector(b - a), frame.vector(c - a)];
            for axis in 0..3 {
                self.corner[axis][lane] = corner[axis] as f32;
                for (stored, edge) in self.edges.iter_mut().zip(edges) {
                    stored[axis][lane] = edge[axis] as f32;
                    longest = longest.max(stored[axis][lane].abs());
                }
            }
        }
        self.slack = Slack::of(longest);
    }
}

/// What the filter's quantities may be off by, for the triangles of one block: the bounds that are
/// derived in [`super::filter`].
#[derive(Clone, Copy, Debug)]
pub struct Slack {
    /// u, v and w.
    pub edge: f32,
    /// e2.q - t det.
    pub depth: f32,
}

impl Slack {
    /// `longest` is b, the largest absolute coordinate of the block's edges.
    pub fn of(longest: f32) -> Self {
        const ROUNDING: f32 = 1.0 / (1u32 << 24) as f32;
        Self { edge: 400.0 * ROUNDING * longest, depth: 280.0 * ROUNDING * longest * longest }
    }
}

/// Coordinates in which a box lies within -1 and 1, so that single precision can hold what is in it
/// wherever the box stands and however large it is.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    pub center: DVec3,
    /// A power of two: scaling by it is exact.
    pub scale: f64,
}

impl Frame {
    pub fn new(bounds: &Aabb) -> Self {
        let center = 0.5 * (bounds.min + bounds.max);
        let reach = (bounds.max - center).max(center - bounds.min).max_element();
        // 2^-e for the least 2^e above the reach.
        let exponent = libm::frexp(reach).1;
        Self { center, scale: libm::ldexp(1.0, -exponent) }
    }

    pub fn point(&self, point: DVec3) -> DVec3 {
        (point - self.center) * self.scale
    }

    pub fn vector(&self, vector: DVec3) -> DVec3 {
        vector * self.scale
    }
}
