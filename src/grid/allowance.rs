//! Limits on the size of an automatic grid, so that building time and memory stay bounded even for scenes
//! that no grid suits.
//!
//! *Bound.* An automatic grid of n primitives holds at most max(16 n, 65,536) references. (A reference is a primitive
//! listed in a cell.) The tree of a crowded cell holds each of the cell's references once, and has at most as many
//! leaves and fewer nodes. Finding the cells of the grid costs at most 16 times as much as the references, in units of
//! one cell test, where a reference costs 16 units. An attempt that exceeds this is abandoned while the cells are being
//! found, before any contents are laid out, and repeated with fewer cells. An axis has at most 100 n^(1/3) cells, so
//! that at most log2(n) + 17 attempts are made: the work grows at most as n log n. The references that all threads hold
//! at any time stay within the bound, apart from the growth of lists by doubling.
//!
//! *Measured* on scenes that no grid suits (identical, stacked, nested, in a star or a fan, slivers) with 10,000 and
//! 100,000 primitives: up to 13.8 references and 1.8 blocks per primitive. When few rays are cast, finding the cells
//! costs up to 2,970 per primitive for 10,000 primitives and 3,510 for 100,000, which is growth with the power 1.07.

use super::budget::REFERENCE_COST;

/// References allowed for each primitive of an automatic grid.
const REFERENCES_PER_PRIMITIVE: f64 = 16.0;

/// Total number of references that is always allowed, so that a small scene gets the resolution that suits
/// it.
const MIN_TOTAL_REFERENCES: f64 = 65536.0;

/// A grid does not separate its primitives if an occupied cell holds more than this fraction of them on
/// average: a ray passes through several cells and would test nearly everything.
const MAX_FRACTION_PER_CELL: f64 = 0.25;

/// A grid with at most this many references for each primitive counts as separating them in any case: most of
/// them are then close together, and the tree in their cell separates them.
const CLUSTERED_REFERENCES: f64 = 2.0;

/// The limits for one automatic grid.
#[derive(Clone, Copy, Debug)]
pub struct Allowance {
    /// A cell with more primitives than this gets a tree.
    pub max_per_cell: usize,
    /// References allowed for each primitive of the grid.
    references: f64,
}

impl Allowance {
    /// For a grid of `count` primitives.
    pub fn new(max_per_cell: usize, count: usize) -> Self {
        Self { max_per_cell, references: REFERENCES_PER_PRIMITIVE.max(MIN_TOTAL_REFERENCES / count as f64) }
    }

    /// The maximum cost of finding the cells of `count` primitives, in the units of a
    /// [`Budget`](crate::grid::budget::Budget). The cells that a primitive turns out not to touch count too:
    /// each costs less than a reference, but there may be many.
    pub fn cost(&self, count: usize) -> usize {
        (self.references * (REFERENCE_COST * count) as f64) as usize
    }
}

/// Whether a grid separates its `count` primitives, so that a ray tests only a few of them. `counts` are the
/// numbers of primitives in its cells, and `references` is their sum.
pub fn separates(counts: &[u32], count: usize, references: usize) -> bool {
    let occupied = counts.iter().filter(|&&count| count > 0).count();
    references as f64
        <= count as f64 * f64::max(CLUSTERED_REFERENCES, MAX_FRACTION_PER_CELL * occupied as f64)
}

/// Three quarters of the cells along each axis, rounded down; none if there is only one cell.
pub fn coarser(cells: [usize; 3]) -> Option<[usize; 3]> {
    let fewer = cells.map(|n| (3 * n / 4).max(1));
    (fewer != cells).then_some(fewer)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The cost allowed for `count` primitives with this number of references each.
    fn cost(count: usize, references: usize) -> usize {
        REFERENCE_COST * count * references
    }

    #[test]
    fn sixteen_references_per_primitive_are_allowed_and_more_in_small_scenes() {
        assert_eq!(Allowance::new(96, 1_000_000).cost(1_000_000), cost(1_000_000, 16));
        assert_eq!(Allowance::new(96, 1 << 10).cost(1 << 10), cost(1 << 10, 64));
    }

    #[test]
    fn a_grid_separates_primitives_if_each_cell_holds_a_small_fraction() {
        // Eight primitives in sixteen occupied cells, two in each: a quarter of them per cell.
        let counts: Vec<u32> = (0..100).map(|i| if i % 6 == 0 { 2 } else { 0 }).take(96).collect();
        assert!(separates(&counts, 8, 32));
        assert!(!separates(&counts, 8, 33));
        // Most primitives are in one of two occupied cells.
        assert!(separates(&[15, 0, 1], 8, 16));
        assert!(!separates(&[16, 0, 1], 8, 17));
    }

    #[test]
    fn a_coarser_grid_has_three_quarters_of_the_cells_along_each_axis() {
        assert_eq!(coarser([100, 8, 1]), Some([75, 6, 1]));
        assert_eq!(coarser([1, 1, 2]), Some([1; 3]));
        assert_eq!(coarser([1; 3]), None);
    }
}
