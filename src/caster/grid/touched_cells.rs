//! The list of the cells that shapes touch, which [`crate::caster::grid::voxelize`] fills.

/// The indices of the cells that shapes touch, shape by shape.
#[derive(Debug, Default)]
pub struct TouchedCells {
    /// Indices of the lattice, in the order of insertion.
    pub indices: Vec<u32>,
}

impl TouchedCells {
    /// Reserves memory for this number of cells, which are about to be tested.
    #[inline(always)]
    pub fn reserve(&mut self, cells: u32) {
        self.indices.reserve(cells as usize);
    }

    /// Adds a cell that the shape touches, for which memory has been reserved.
    #[inline(always)]
    pub fn push(&mut self, index: u32) {
        self.indices.push(index);
    }
}
