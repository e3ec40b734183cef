//! Triangles as the filter wants them: eight side by side, in single precision around one centre.

use crate::math::aabb::Aabb;
use crate::world::World;
use glam::DVec3;

/// Triangles in a block.
pub const LANES: usize = 8;

/// The number of no primitive, in a lane that holds no triangle.
pub const NONE: u32 = u32::MAX;

/// Eight triangles, structure of arrays, in the coordinates of a [`Frame`]: seven cache lines, with
/// what the filter reads in front.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Block {
    /// x, y and z of the first corner; NaN in an empty lane, which no test passes.
    pub corner: [[f32; LANES]; 3],
    /// From the second corner to the first, and from the first to the third.
    pub edges: [[[f32; LANES]; 3]; 2],
    /// The edges' cross product.
    pub normal: [[f32; LANES]; 3],
    /// How far the filter may be off for these triangles.
    pub slack: Slack,
    pub then: Then,
    /// The triangles' numbers in their world; [`NONE`] in an empty lane.
    pub numbers: [u32; LANES],
}

/// What follows a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Then {
    /// The next block, of the same cell.
    Block,
    /// Nothing: the cell ends here.
    End,
    /// What the cell holds beside triangles.
    Others,
}

impl Block {
    /// Holds nothing, and is its cell's last.
    pub const EMPTY: Self = Self {
        corner: [[f32::NAN; LANES]; 3],
        edges: [[[0.0; LANES]; 3]; 2],
        normal: [[0.0; LANES]; 3],
        slack: Slack { edge: 0.0, depth: 0.0 },
        then: Then::End,
        numbers: [NONE; LANES],
    };

    /// Of at most eight triangles.
    pub fn fill(&mut self, world: &World, frame: &Frame, triangles: &[u32]) {
        let mut longest = 0.0f32;
        self.numbers[..triangles.len()].copy_from_slice(triangles);
        for (lane, &number) in triangles.iter().enumerate() {
            let [a, b, c] = world.corners(number as usize);
            let corner = frame.point(a);
            let edges = [frame.vector(a - b), frame.vector(c - a)];
            let normal = edges[0].cross(edges[1]);
            for axis in 0..3 {
                self.corner[axis][lane] = corner[axis] as f32;
                self.normal[axis][lane] = normal[axis] as f32;
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
    /// n.s - t det.
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
    /// With a spare place.
    pub center: [f64; 4],
    /// A power of two: scaling by it is exact.
    pub scale: f64,
}

impl Frame {
    pub fn new(bounds: &Aabb) -> Self {
        let center = 0.5 * (bounds.min + bounds.max);
        let reach = (bounds.max - center).max(center - bounds.min).max_element();
        // 2^-e for the least 2^e above the reach.
        let exponent = libm::frexp(reach).1;
        Self { center: [center.x, center.y, center.z, 0.0], scale: libm::ldexp(1.0, -exponent) }
    }

    pub fn point(&self, point: DVec3) -> DVec3 {
        let [x, y, z, _] = self.center;
        (point - DVec3::new(x, y, z)) * self.scale
    }

    pub fn vector(&self, vector: DVec3) -> DVec3 {
        vector * self.scale
    }
}
