//! The list of the cells that shapes touch, which [`crate::caster::grid::voxelize`] fills.

use crate::caster::error::GridTooLarge;

/// The indices of the cells that shapes touch, shape by shape. Since a user may ask for an arbitrarily fine
/// grid, the list reports an error instead of exceeding the available memory.
#[derive(Debug, Default)]
pub struct TouchedCells {
    /// Indices of the lattice, in the order of insertion.
    pub indices: Vec<u32>,
}

impl TouchedCells {
    /// Reserves memory for this number of cells, which are about to be tested.
    #[inline(always)]
    pub fn reserve(&mut self, cells: u32) -> Result<(), GridTooLarge> {
        self.indices.try_reserve(cells as usize).map_err(|_| GridTooLarge)
    }

    /// Adds a cell that the shape touches, for which memory has been reserved.
    #[inline(always)]
    pub fn push(&mut self, index: u32) {
        self.indices.push(index);
    }
}
