//! The error of building a grid.

use std::fmt;

/// The error of building a grid: its cells or their contents do not fit into memory, or exceed a budget.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GridTooLarge;

impl fmt::Display for GridTooLarge {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "the grid does not fit into memory: use fewer cells")
    }
}

impl std::error::Error for GridTooLarge {}
