//! Ray casting with a list, a uniform grid or a tree of boxes.
//!
//! Each module is one step of building or traversing the grid, and imports only from the modules before it in
//! this list.

mod error;
#[doc(hidden)]
pub mod touched_cells;
pub(crate) mod ray_aabb;
mod reach;
mod lattice;
mod fixed_t;
#[doc(hidden)]
pub mod dda;
pub(crate) mod dda4;
#[doc(hidden)]
pub mod voxelize;
#[doc(hidden)]
pub mod cell_lists;
#[doc(hidden)]
pub mod insertion;
pub mod choose;
#[doc(hidden)]
pub mod triangle8;
#[doc(hidden)]
pub mod filter;
mod box8;
mod tree;
mod cell_table;
mod cell_contents;
mod build;
mod fullness;
mod query;
mod ray_entry;
mod descent;
mod traverse;
mod caster;
mod packet_setup;
#[doc(hidden)]
pub mod packet;

pub use crate::math::instructions::Instructions;
pub use build::StructureSize;
pub use caster::Caster;
pub use error::GridTooLarge;
pub use fullness::Fullness;
pub use lattice::Lattice;
