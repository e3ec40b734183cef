//! The uniform grid. It knows boxes and indices, not what a primitive is.

pub mod build;
pub mod march;
pub mod visualize;

use crate::math::aabb::Aabb;
use glam::DVec3;

/// How a box is cut into cells. Cell (i, j, k) has the index `i + nx (j + ny k)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    pub bounds: Aabb,
    /// Cells along each axis, at least one.
    pub cells: [usize; 3],
    /// Edge lengths of a cell.
    pub cell_size: DVec3,
}

impl Lattice {
    pub fn new(bounds: Aabb, cells: [usize; 3]) -> Self {
        let count = DVec3::new(cells[0] as f64, cells[1] as f64, cells[2] as f64);
        Self { bounds, cells, cell_size: bounds.extent() / count }
    }

    pub fn cell_count(&self) -> usize {
        self.cells.iter().product()
    }

    pub fn index(&self, cell: [usize; 3]) -> usize {
        cell[0] + self.cells[0] * (cell[1] + self.cells[1] * cell[2])
    }

    /// The cells along `axis` that the interval touches, widened by `slack` cells on both sides and
    /// clamped to the lattice.
    pub fn range(&self, axis: usize, low: f64, high: f64, slack: f64) -> std::ops::RangeInclusive<usize> {
        let last = self.cells[axis] - 1;
        // A float turns into the nearest index that exists, and a NaN into 0.
        let cell = |x: f64, slack: f64| {
            (((x - self.bounds.min[axis]) / self.cell_size[axis] + slack).floor() as usize).min(last)
        };
        cell(low, -slack)..=cell(high, slack)
    }

    /// Calls `visit` with the index of every cell that touches the box widened by `slack` cells.
    pub fn for_each_cell(&self, bounds: &Aabb, slack: f64, mut visit: impl FnMut(usize)) {
        let [xs, ys, zs] = [0, 1, 2].map(|axis| self.range(axis, bounds.min[axis], bounds.max[axis], slack));
        for z in zs {
            for y in ys.clone() {
                for x in xs.clone() {
                    visit(self.index([x, y, z]));
                }
            }
        }
    }
}
