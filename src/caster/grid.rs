//! The uniform grid: its lattice, the 3D-DDA, which cells a primitive touches, and the table of cells.
//!
//! Each module is one step of building or traversing the grid, and imports only from the modules before it in this list.

pub(super) mod lattice;
mod fixed_t;
#[doc(hidden)]
pub mod dda;
#[doc(hidden)]
pub mod touched_cells;
#[doc(hidden)]
pub mod voxelize;
#[doc(hidden)]
pub mod cell_lists;
#[doc(hidden)]
pub mod insertion;
pub(super) mod cell_table;

pub use lattice::Lattice;
