//! Building the acceleration structure of the finite primitives: a list, a uniform grid, or a grid with
//! trees in its crowded cells. The steps are in modules of their own: the lattice and the cells of
//! each primitive ([`super::fitting`]), then the contents of each cell ([`super::cell_contents`]), then the trees
//! ([`super::trees`]).

use super::allowance::{Allowance, separates};
use super::budget::{Budget, REFERENCE_COST};
use super::cell_contents::CellContents;
use super::cell_lists::CellLists;
use super::cell_table::CellTable;
use super::error::GridTooLarge;
use super::fitting::{FittedLattice, bounds_of, cell_lists};
use super::lattice::Lattice;
use super::options::{CellRule, GridOptions};
use super::ray_aabb::SimdAabb;
use super::reach::max_origin_distance;
use super::trees::Trees;
use super::triangle8::{Block, Frame};
use crate::math::aabb::Aabb;
use crate::memory;
use crate::world::World;

/// The acceleration structure of some primitives: a grid, or a single list.
#[derive(Debug)]
pub struct AccelerationStructure {
    /// Rays are tested only in this box.
    pub simd_bounds: SimdAabb,
    /// The entries of the grid's cells; none for a list.
    pub table: Option<CellTable>,
    /// The primitives of the cells; a list counts as one cell.
    pub cells: CellContents,
    /// The blocks of the cells, followed by those of the trees.
    pub blocks: Vec<Block>,
    /// The trees of crowded cells.
    pub trees: Trees,
    /// The cost of building it, including abandoned attempts.
    cost: usize,
    /// The proofs of filter and DDA hold for rays whose origin is at most this far from the centre along each
    /// axis. For other rays every primitive is tested.
    pub max_origin_distance: f64,
}

/// The size of an acceleration structure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StructureSize {
    /// Cells, including the border, and nodes of trees; a list counts as one cell.
    pub cells: usize,
    /// References to primitives in all cells; a primitive counts once for each cell that lists it.
    pub references: usize,
    /// Blocks of eight triangles.
    pub blocks: usize,
    /// The cost of building: 1 for each test of a cell, and 16 for each reference.
    pub cost: usize,
}

impl AccelerationStructure {
    /// The structure of all finite primitives of a world. An error when it does not fit into memory.
    pub fn new(world: &World, options: GridOptions) -> Result<Self, GridTooLarge> {
        let mut structure = Self::without_blocks(world, options)?;
        structure.blocks = memory::zeroed(structure.cells.block_count()).map_err(|_| GridTooLarge)?;
        structure.cells.fill(world, &mut structure.blocks);
        Ok(structure)
    }

    /// The same with indices in place of the blocks.
    fn without_blocks(world: &World, GridOptions { cells, rule }: GridOptions) -> Result<Self, GridTooLarge> {
        let bounds = bounds_of(world);
        let Some(cells) = cells else {
            return Self::list(world, &bounds, !matches!(rule, CellRule::Course { .. }));
        };
        let allowance = |max_per_cell: usize| Allowance::new(max_per_cell, world.finite_count());
        match rule {
            CellRule::Trees { max_per_cell } => {
                Self::automatic(world, bounds, cells, allowance(max_per_cell))
            }
            CellRule::Course { is_bounded: true } => {
                let fitted = FittedLattice::new(world, bounds, cells, rule, allowance(usize::MAX))?;
                Self::grid(world, fitted.lattice, fitted.cell_lists, &[])
            }
            CellRule::Exact | CellRule::Course { is_bounded: false } => {
                let lattice = Lattice::new(bounds, cells);
                let cell_lists = cell_lists(world, &lattice, rule, &Budget::unlimited())?;
                Self::grid(world, lattice, cell_lists, &[])
            }
        }
    }

    /// The size of the structure.
    pub fn size(&self) -> StructureSize {
        StructureSize {
            cells: self.table.as_ref().map_or(1, |table| table.lattice().index_count())
                + self.trees.nodes.len(),
            references: CellContents::references(&self.blocks),
            blocks: self.blocks.len(),
            cost: self.cost,
        }
    }

    /// A list of all finite primitives of a world with these bounds, or only of those that rays may hit.
    fn list(world: &World, bounds: &Aabb, hittable: bool) -> Result<Self, GridTooLarge> {
        let cost = REFERENCE_COST * world.finite_count();
        Ok(Self {
            simd_bounds: SimdAabb::new(bounds),
            table: None,
            cells: CellContents::all(world, Frame::new(bounds), hittable)?,
            blocks: vec![],
            trees: Trees::default(),
            cost,
            max_origin_distance: max_origin_distance(bounds, f64::INFINITY),
        })
    }

    /// A grid of at most these cells with trees in its crowded cells, or a list if no grid within the allowance
    /// separates the primitives.
    fn automatic(
        world: &World,
        bounds: Aabb,
        cells: [usize; 3],
        allowance: Allowance,
    ) -> Result<Self, GridTooLarge> {
        let count = world.finite_count();
        let rule = CellRule::Trees { max_per_cell: allowance.max_per_cell };
        let FittedLattice { lattice, mut cell_lists, abandoned_cost } =
            FittedLattice::new(world, bounds, cells, rule, allowance)?;
        let (counts, references) = (cell_lists.counts(&lattice)?, cell_lists.references());
        if count > allowance.max_per_cell && !separates(&counts, count, references) {
            let mut list = Self::list(world, &bounds, true)?;
            list.cost += abandoned_cost + cell_lists.cost();
            return Ok(list);
        }
        let crowded = cell_lists.take_crowded(&counts, allowance.max_per_cell)?;
        drop(counts);
        let mut grid = Self::grid(world, lattice, cell_lists, &crowded)?;
        grid.cost += abandoned_cost;
        Ok(grid)
    }

    /// A grid with these cell lists, and with trees in the `crowded` cells, which the lists leave out.
    fn grid(
        world: &World,
        lattice: Lattice,
        cell_lists: CellLists,
        crowded: &[(u32, Vec<u32>)],
    ) -> Result<Self, GridTooLarge> {
        let in_trees: usize = crowded.iter().map(|(_, ids)| ids.len()).sum();
        let cost = cell_lists.cost() + REFERENCE_COST * in_trees;
        let mut cells = CellContents::new(world, &lattice, &cell_lists)?;
        drop(cell_lists);
        let trees = Trees::new(world, &lattice, crowded, &mut cells)?;
        let max_origin_distance = max_origin_distance(&lattice.bounds, lattice.cell_size.min_element());
        let simd_bounds = SimdAabb::new(&lattice.bounds);
        let table = Some(CellTable::new(lattice, cells.take_entries())?);
        Ok(Self { simd_bounds, table, cells, blocks: vec![], trees, cost, max_origin_distance })
    }
}

#[cfg(test)]
mod tests;
