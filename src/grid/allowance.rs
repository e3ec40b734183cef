//! How much an automatic grid may build.
//!
//! *Bound.* An automatic grid of n primitives holds, with all grids within its cells, at most
//! max(16 n, 65,536) entries. By induction: let e be the entries allowed for each of the m primitives of a
//! grid. Where its cells hold E entries, E <= e m, each cell may hold e m / E entries for each of its own,
//! counted with all grids within it; over all cells that sums to at most E (e m / E) = e m. A list, which
//! needs one entry for each primitive, is always allowed, since e >= 1.
//!
//! Finding the cells of such a grid costs at most 16 e m, where an entry costs 16 and looking at a cell costs
//! 1; what goes beyond is given up while it is found, before anything is laid out, and tried with fewer cells.
//! An axis has at most 100 n^(1/3) cells, so that there are at most 17 + log2(n) tries, on each of four
//! levels: the work grows at most as n log n. All that is held at any time, by all threads, stays within the
//! bound on entries, up to the growth of lists by doubling.
//!
//! *Measured* on scenes that no grid suits (identical, stacked, nested, in a star or a fan, slivers) of 10,000
//! to 1,000,000 primitives: up to 13.8 entries and 1.8 blocks for each. Finding the cells costs up to 2,800
//! for each of 10,000, 3,510 for each of 100,000 and 4,280 for each of 1,000,000 where few rays are cast, a
//! growth with the powers 1.10 and 1.09; up to 6,670 for each of 1,000,000 where many are, since their grid
//! has two levels from the start. Meshes need 2 to 6 entries and a cost of 30 to 100.

use crate::grid::budget::REFERENCE_COST;

/// e of an automatic grid that stands in no other.
const REFERENCES_PER_PRIMITIVE: f64 = 16.0;

/// Or so many entries in all, where that is more, so that few primitives get the cells that suit them.
const FREE_REFERENCES: f64 = 65536.0;

/// A grid within a cell is given up before it is begun where less than so many entries are allowed for each
/// primitive, since hardly any grid needs less.
const WORTH_A_GRID: f64 = 2.0;

/// A grid does not separate its primitives where a cell that is not empty holds more than this part of them
/// on average: a ray goes through several cells, and would test everything.
const PART_OF_ALL: f64 = 0.25;

/// Unless it has no more entries than this for each primitive: then most stand close together, and a grid
/// within their cell, which fits around them, still has almost the whole allowance.
const CLOSE_TOGETHER: f64 = 2.0;

/// So many grids one within the other. Where many primitives share a point no grid separates them.
const DEPTH: usize = 4;

/// What an automatic grid may build.
#[derive(Clone, Copy, Debug)]
pub struct Allowance {
    /// A cell with more primitives than this may get a grid of its own.
    pub max_per_cell: usize,
    depth: usize,
    /// e: entries for each primitive of the grid.
    references: f64,
}

impl Allowance {
    /// For a grid of `count` primitives that stands in no other.
    pub fn new(max_per_cell: usize, count: usize) -> Self {
        Self {
            max_per_cell,
            depth: DEPTH,
            references: REFERENCES_PER_PRIMITIVE.max(FREE_REFERENCES / count as f64),
        }
    }

    /// What filling a grid of `count` primitives may cost, in the units of a
    /// [`Budget`](crate::grid::budget::Budget). A cell that is looked at and not entered costs less than an
    /// entry, but a primitive may have many of those.
    pub fn cost(&self, count: usize) -> usize {
        (self.references * (REFERENCE_COST * count) as f64) as usize
    }

    /// What may be built in the cells of a grid that holds `count` primitives by so many entries; none where
    /// it is not worth it.
    pub fn within(&self, count: usize, references: usize) -> Option<Self> {
        let spread = (references as f64 / count as f64).max(1.0);
        let within = Self { depth: self.depth - 1, references: self.references / spread, ..*self };
        (within.depth > 0 && within.references >= WORTH_A_GRID).then_some(within)
    }
}

/// Whether a grid with so many primitives in its cells, by index, separates those `count` that it holds.
pub fn separates(counts: &[u32], count: usize, references: usize) -> bool {
    let occupied = counts.iter().filter(|&&count| count > 0).count();
    references as f64 <= count as f64 * f64::max(CLOSE_TOGETHER, PART_OF_ALL * occupied as f64)
}

/// Three quarters as many cells along each axis; none where there is but one cell.
pub fn coarser(cells: [usize; 3]) -> Option<[usize; 3]> {
    let fewer = cells.map(|n| (3 * n / 4).max(1));
    (fewer != cells).then_some(fewer)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What may be spent on a grid of `count` primitives with so many entries allowed for each.
    fn cost(count: usize, references: usize) -> usize {
        REFERENCE_COST * count * references
    }

    #[test]
    fn a_grid_may_hold_sixteen_entries_for_each_primitive_or_some_that_are_free() {
        assert_eq!(Allowance::new(96, 1_000_000).cost(1_000_000), cost(1_000_000, 16));
        assert_eq!(Allowance::new(96, 1 << 10).cost(1 << 10), cost(1 << 10, 64));
    }

    #[test]
    fn grids_within_cells_share_what_their_grid_has_left() {
        let outer = Allowance::new(96, 1_000_000);
        let within = |count, references| outer.within(count, references).map(|inner| inner.cost(50));
        assert_eq!(within(100, 400), Some(cost(50, 4)));
        // Cells that leave primitives out give no more to the others.
        assert_eq!(within(100, 25), Some(cost(50, 16)));
        assert_eq!(within(100, 800), Some(cost(50, 2)));
        assert_eq!(within(100, 801), None);
        assert_eq!(outer.within(100, 400).map(|inner| inner.max_per_cell), Some(96));
    }

    #[test]
    fn grids_stand_within_one_another_four_deep() {
        let inner = |outer: &Allowance| outer.within(100, 100);
        let depth = std::iter::successors(Some(Allowance::new(96, 1_000_000)), inner).count();
        assert_eq!(depth, DEPTH);
    }

    #[test]
    fn cells_separate_primitives_where_each_holds_a_small_part_of_them() {
        // Sixteen cells of eight primitives, among empty ones: a quarter of all in each.
        let counts: Vec<u32> = (0..100).map(|i| if i % 6 == 0 { 2 } else { 0 }).take(96).collect();
        assert!(separates(&counts, 8, 32));
        assert!(!separates(&counts, 8, 33));
        // Most stand close together in one of two cells.
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
