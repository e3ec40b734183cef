//! The lattice of cells: how a box is cut, and how its cells are numbered. It knows boxes and indices, not what a
//! primitive is.

use super::cell_lists::GridTooLarge;
use super::dda::LatticeLanes;
use super::ray_aabb::SimdAabb;
use crate::math::aabb::Aabb;
use crate::math::f64x4::F64x4;
use glam::DVec3;
use std::ops::Range;

/// How a box is cut into cells.
///
/// Around the cells lies a border one cell thick, so that a march ends when it reads a border cell
/// and needs no bounds test. Indices count the border: cell (i, j, k) of the lattice, each from 0,
/// has the index `(i + 1) + sx ((j + 1) + sy (k + 1))` with `sx = nx + 2`, `sy = ny + 2`.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    /// The box that is cut.
    pub bounds: Aabb,
    cells: [usize; 3],
    /// Edge lengths of a cell.
    pub cell_size: DVec3,
    cells_per_unit: DVec3,
    /// For the march.
    pub(super) tables: DdaTables,
}

/// What every march through a lattice needs, computed once.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DdaTables {
    simd_bounds: SimdAabb,
    cell_size: [f64; 4],
    cells_per_unit: [f64; 4],
    /// The last cell along each axis, and how an index changes from one to the next.
    last: [f64; 4],
    pub strides: [u32; 3],
    /// What to add to an index, by the axes along which a ray runs backwards (bit 0 for x) and by
    /// the axes that do not step. The latter's bit 3 is a spare one.
    pub step_offsets: [[isize; 16]; 8],
}

impl DdaTables {
    fn new(bounds: &Aabb, cells: [usize; 3], cell_size: DVec3, cells_per_unit: DVec3) -> Self {
        let [nx, ny, _] = cells;
        let strides = [1, nx + 2, (nx + 2) * (ny + 2)];
        let step_offset = |backwards: usize, stays: usize| {
            let one = |axis: usize| {
                let stride = strides[axis] as isize;
                if backwards >> axis & 1 == 1 { -stride } else { stride }
            };
            (0..3).filter(|axis| stays >> axis & 1 == 0).map(one).sum()
        };
        let floats = |[x, y, z]: [usize; 3]| [x as f64, y as f64, z as f64, 0.0];
        Self {
            simd_bounds: SimdAabb::new(bounds),
            cell_size: [cell_size.x, cell_size.y, cell_size.z, 1.0],
            cells_per_unit: [cells_per_unit.x, cells_per_unit.y, cells_per_unit.z, 1.0],
            last: floats(cells.map(|n| n - 1)),
            strides: strides.map(|stride| stride as u32),
            step_offsets: std::array::from_fn(|backwards| {
                std::array::from_fn(|stays| step_offset(backwards, stays))
            }),
        }
    }

    /// What a march takes from all axes.
    #[inline(always)]
    pub fn lattice_lanes<F: F64x4>(&self, proof: F::Proof) -> LatticeLanes<F> {
        LatticeLanes {
            low: F::new(proof, self.simd_bounds.low),
            cell_size: F::new(proof, self.cell_size),
            cells_per_unit: F::new(proof, self.cells_per_unit),
            last: F::new(proof, self.last),
        }
    }

    /// What four marches take from one axis.
    #[inline(always)]
    pub fn lattice_lanes_of_axis<F: F64x4>(&self, proof: F::Proof, axis: usize) -> LatticeLanes<F> {
        LatticeLanes {
            low: F::splat(proof, self.simd_bounds.low[axis]),
            cell_size: F::splat(proof, self.cell_size[axis]),
            cells_per_unit: F::splat(proof, self.cells_per_unit[axis]),
            last: F::splat(proof, self.last[axis]),
        }
    }
}

impl Lattice {
    /// Cuts a box, which must not be flat, into so many cells along each axis, at least one.
    pub fn new(bounds: Aabb, cells: [usize; 3]) -> Self {
        let count = DVec3::from_array(cells.map(|n| n as f64));
        let extent = bounds.extent();
        let (cell_size, cells_per_unit) = (extent / count, count / extent);
        let tables = DdaTables::new(&bounds, cells, cell_size, cells_per_unit);
        Self { bounds, cells, cell_size, cells_per_unit, tables }
    }

    /// Cells along each axis without the border, at least one. They never change, since a march relies on
    /// them.
    pub fn cells(&self) -> [usize; 3] {
        self.cells
    }

    /// The bounds as [`intersect_aabb`](super::ray_aabb::clip) reads them.
    pub(crate) fn simd_bounds(&self) -> &SimdAabb {
        &self.tables.simd_bounds
    }

    /// How many indices there are, those of the border included.
    pub fn index_count(&self) -> usize {
        self.cells.iter().map(|n| n + 2).product()
    }

    /// An error where indices, the border's included, are too many for 32 bits.
    pub fn fits(&self) -> Result<(), GridTooLarge> {
        let sides = self.cells.map(|n| n as u128 + 2);
        if sides.iter().product::<u128>() < u32::MAX as u128 { Ok(()) } else { Err(GridTooLarge) }
    }

    /// How an index changes with a step along each axis.
    pub fn strides(&self) -> [usize; 3] {
        let [nx, ny, _] = self.cells;
        [1, nx + 2, (nx + 2) * (ny + 2)]
    }

    /// The index of a cell.
    pub fn index(&self, cell: [usize; 3]) -> usize {
        let [sx, sy, sz] = self.strides();
        (cell[0] + 1) * sx + (cell[1] + 1) * sy + (cell[2] + 1) * sz
    }

    /// The indices of each row of cells along x, in ascending order.
    pub fn x_runs(&self) -> impl DoubleEndedIterator<Item = Range<usize>> {
        let [nx, ny, nz] = self.cells;
        let starts = (0..nz).flat_map(move |z| (0..ny).map(move |y| self.index([0, y, z])));
        starts.map(move |start| start..start + nx)
    }

    /// The lower corner of an index' cell in units of cells; -1 on the border.
    pub fn cell_of(&self, index: usize) -> DVec3 {
        let [_, sy, sz] = self.strides();
        DVec3::from_array([index % sy, index % sz / sy, index / sz].map(|i| i as f64 - 1.0))
    }

    /// A point in units of cells from the lattice's lower corner.
    pub fn to_cells(&self, point: DVec3) -> DVec3 {
        (point - self.bounds.min) * self.cells_per_unit
    }

    /// The cell along `axis` that holds a coordinate in units of cells; the nearest one for a
    /// coordinate outside, the first for a NaN.
    pub fn cell_at(&self, axis: usize, coordinate: f64) -> usize {
        // The conversion cuts below at 0.
        (coordinate as usize).min(self.cells[axis] - 1)
    }
}
