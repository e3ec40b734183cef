//! The lattice of a uniform grid: divides a box into cells and indexes the cells. Insertion and traversal use it; it
//! does not depend on primitives.

use crate::base::memory;
use crate::base::patience::Ended;
use crate::caster::bounds::SimdAabb;
use crate::math::aabb::Aabb;
use glam::DVec3;
use std::fmt;
use std::ops::Range;

/// The reason why a structure was not built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotBuilt {
    /// The cells of a grid or their contents do not fit into memory or into their indices.
    TooLarge,
    /// The patience was over.
    Ended,
}

impl fmt::Display for NotBuilt {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::TooLarge => f.write_str("the grid does not fit into memory: use fewer cells"),
            Self::Ended => Ended.fmt(f),
        }
    }
}

impl std::error::Error for NotBuilt {}

impl From<Ended> for NotBuilt {
    fn from(_: Ended) -> Self {
        Self::Ended
    }
}

/// The division of a box into cells.
///
/// The cells are surrounded by a border one cell thick. The traversal ends when it reads a border cell, and needs no
/// bounds test. Indices include the border: cell (i, j, k), counted from 0, has the index
/// `(i + 1) + (nx + 2) ((j + 1) + (ny + 2) (k + 1))`.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    /// The box that is divided into cells.
    pub bounds: Aabb,
    cells: [usize; 3],
    /// The edge lengths of a cell.
    pub cell_size: DVec3,
    // The following fields are tables of the traversal, whose fourth lanes are not used.
    pub(super) simd_bounds: SimdAabb,
    pub(super) cell_size_lanes: [f64; 4],
    pub(super) cells_per_unit: [f64; 4],
    /// The coordinate of the last cell along each axis.
    pub(super) last_cell: [f64; 4],
    /// The index difference between neighbouring cells along each axis.
    pub(super) strides: [u32; 3],
    /// The offset that a step adds to the index, by the set of axes along which the ray's direction is negative and by
    /// the set of axes that do not step (bit 0 for x). Bit 3 of the latter belongs to the unused lane and has no
    /// effect.
    pub(super) step_offsets: [[isize; 16]; 8],
}

impl Lattice {
    /// Divides a box of positive extent into this number of cells along each axis, which must be at least
    /// one.
    pub fn new(bounds: Aabb, cells: [usize; 3]) -> Self {
        let count = DVec3::from_array(cells.map(|n| n as f64));
        let extent = bounds.extent();
        let cell_size = extent / count;
        let [nx, ny, _] = cells;
        let strides = [1, nx + 2, (nx + 2) * (ny + 2)];
        let step_offset = |negative_axes: usize, unstepped: usize| -> isize {
            let steps = (0..3).filter(|axis| unstepped >> axis & 1 == 0);
            steps.map(|axis| strides[axis] as isize * (1 - 2 * (negative_axes >> axis & 1) as isize)).sum()
        };
        Self {
            bounds,
            cells,
            cell_size,
            simd_bounds: SimdAabb::new(&bounds),
            cell_size_lanes: cell_size.extend(1.0).to_array(),
            cells_per_unit: (count / extent).extend(1.0).to_array(),
            last_cell: (count - 1.0).extend(0.0).to_array(),
            strides: strides.map(|stride| stride as u32),
            step_offsets: std::array::from_fn(|negative_axes| {
                std::array::from_fn(|unstepped| step_offset(negative_axes, unstepped))
            }),
        }
    }

    /// Returns the number of cells along each axis without the border, at least one.
    pub fn cells(&self) -> [usize; 3] {
        self.cells
    }

    /// Returns the number of indices, including the border.
    pub fn index_count(&self) -> usize {
        self.cells.iter().map(|n| n + 2).product()
    }

    /// Returns an error if the indices, including the border, do not fit into 32 bits.
    fn fits(&self) -> Result<(), NotBuilt> {
        let sides = self.cells.map(|n| n as u128 + 2);
        if sides.iter().product::<u128>() < u32::MAX as u128 { Ok(()) } else { Err(NotBuilt::TooLarge) }
    }

    /// Returns an error if the indices do not fit into 32 bits, or if there is not enough memory for an entry per
    /// index.
    pub fn ask_for_entries(&self) -> Result<(), NotBuilt> {
        self.fits()?;
        memory::ask((self.index_count() * size_of::<u32>()) as u64).map_err(|_| NotBuilt::TooLarge)
    }

    /// Returns the index difference between neighbouring cells along each axis.
    pub fn strides(&self) -> [usize; 3] {
        self.strides.map(|stride| stride as usize)
    }

    /// Returns the index of the cell with these coordinates.
    pub fn index(&self, cell: [usize; 3]) -> usize {
        let [sx, sy, sz] = self.strides();
        (cell[0] + 1) * sx + (cell[1] + 1) * sy + (cell[2] + 1) * sz
    }

    /// Returns the contiguous index ranges of the cells along x, in ascending order, without the border.
    pub fn x_runs(&self) -> impl DoubleEndedIterator<Item = Range<usize>> {
        let [nx, ny, nz] = self.cells;
        let starts = (0..nz).flat_map(move |z| (0..ny).map(move |y| self.index([0, y, z])));
        starts.map(move |start| start..start + nx)
    }

    /// Returns the coordinates of the cell with this index, which are its lower corner in units of cells. On the
    /// border, a coordinate is -1 or the number of cells.
    pub fn cell_of(&self, index: usize) -> DVec3 {
        let [_, sy, sz] = self.strides();
        DVec3::from_array([index % sy, index % sz / sy, index / sz].map(|i| i as f64 - 1.0))
    }

    /// Converts a point to units of cells, relative to the lower corner of the lattice.
    pub fn to_cells(&self, point: DVec3) -> DVec3 {
        let [x, y, z, _] = self.cells_per_unit;
        (point - self.bounds.min) * DVec3::new(x, y, z)
    }

    /// Returns the cell that contains a point in units of cells. Along each axis it is the nearest cell for a coordinate
    /// outside, and the first for a NaN.
    #[inline(always)]
    pub fn cell_at(&self, point: DVec3) -> [u32; 3] {
        // The conversion saturates at 0, and maps NaN to 0.
        let cell = |coordinate: f64, cells: usize| (coordinate as u32).min((cells - 1) as u32);
        let [nx, ny, nz] = self.cells;
        [cell(point.x, nx), cell(point.y, ny), cell(point.z, nz)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice(cells: [usize; 3]) -> Lattice {
        Lattice::new(Aabb { min: DVec3::new(1.0, 2.0, 3.0), max: DVec3::new(2.0, 4.0, 6.0) }, cells)
    }

    #[test]
    fn the_last_index_is_that_of_the_last_corner_of_the_border() {
        let lattice = lattice([5, 3, 4]);
        let [sx, sy, sz] = lattice.strides();
        assert_eq!(lattice.index([4, 2, 3]) + sx + sy + sz + 1, lattice.index_count());
    }

    #[test]
    fn indices_must_be_less_than_the_largest_number_of_32_bits() {
        // 255 * 257 * 65537 = 2^32 - 1.
        assert_eq!(lattice([253, 255, 65535]).fits(), Err(NotBuilt::TooLarge));
        assert_eq!(lattice([253, 255, 65534]).fits(), Ok(()));
    }

    #[test]
    fn points_have_coordinates_in_cells_and_those_outside_have_the_nearest_cells() {
        let lattice = lattice([4, 2, 6]);
        assert_eq!(lattice.to_cells(DVec3::new(1.25, 2.5, 5.0)), DVec3::new(1.0, 0.5, 4.0));
        assert_eq!(
            [-3.0, 0.5, 3.75, 4.0, 1e19].map(|x| lattice.cell_at(DVec3::splat(x))[0]),
            [0, 0, 3, 3, 3]
        );
    }
}
