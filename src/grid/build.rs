//! Building the acceleration structure of the finite primitives: a list, a uniform grid, or a grid with
//! nested grids in its crowded cells. The steps are in modules of their own: the lattice and the cells of
//! each primitive ([`super::fitting`]), then the contents of each cell ([`super::cell_contents`]).

use super::allowance::{Allowance, separates};
use super::budget::{Budget, REFERENCE_COST};
use super::cell_contents::CellContents;
use super::cell_lists::{CellLists, widened, with_room_for};
use super::cell_table::CellTable;
use super::error::GridTooLarge;
use super::fitting::{FittedLattice, bounds_of, cell_lists, padding};
use super::lattice::Lattice;
use super::options::{CellRule, GridOptions, cubic};
use super::prim_set::PrimSet;
use super::ray_aabb::SimdAabb;
use super::triangle8::{Block, Frame};
use crate::math::aabb::Aabb;
use crate::memory;
use crate::world::World;
use bytemuck::allocation::try_zeroed_vec;
use glam::DVec3;
use rayon::prelude::*;

/// Up to this number of primitives that span a crowded cell are kept in a list beside its nested grid.
const MAX_SPANNING: usize = 32;

/// Cells per primitive of a nested grid. Measured on a mesh of 2.5 million triangles: with twice as many
/// cells, rays are slower by 5 to 10% and building by 25%.
const NESTED_CELLS: f64 = 0.4;

/// The acceleration structure of some primitives: a grid, or a single list.
#[derive(Debug)]
pub struct AccelerationStructure {
    /// Rays are tested only in this box.
    pub simd_bounds: SimdAabb,
    /// The entries of the grid's cells; none for a list.
    pub table: Option<CellTable>,
    /// The primitives of the cells; a list counts as one cell.
    pub cells: CellContents,
    /// The blocks of this structure, followed by those of all structures nested in it. That of a nested one is empty.
    pub blocks: Vec<Block>,
    /// The nested grids, in the order of the entries that refer to them.
    pub nested: Vec<NestedGrid>,
    /// The primitives that the structure was built from.
    pub prims: PrimSet,
    /// The cost of building it, including abandoned attempts and without the nested grids.
    cost: usize,
    /// The proofs of filter and DDA hold for rays whose origin is at most this far from the centre along each
    /// axis. For other rays every primitive is tested.
    pub max_origin_distance: f64,
}

/// The size of an acceleration structure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StructureSize {
    /// Cells of all grids, including the borders; a list counts as one cell.
    pub cells: usize,
    /// References to primitives in all cells and lists; a primitive counts once for each cell that lists it.
    pub references: usize,
    /// Blocks of eight triangles.
    pub blocks: usize,
    /// The cost of building: 1 for each test of a cell, and 16 for each reference.
    pub cost: usize,
}

impl std::ops::Add for StructureSize {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            cells: self.cells + other.cells,
            references: self.references + other.references,
            blocks: self.blocks + other.blocks,
            cost: self.cost + other.cost,
        }
    }
}

/// The contents of a crowded cell.
#[derive(Debug)]
pub struct NestedGrid {
    /// The primitives that span the cell, as a list. In the grid they would be in most cells, and keep its
    /// bounds from fitting the others.
    pub spanning: Option<AccelerationStructure>,
    /// The other primitives.
    pub grid: AccelerationStructure,
}

impl AccelerationStructure {
    /// The structure of all finite primitives of a world. An error when it does not fit into memory.
    pub fn new(world: &World, options: GridOptions) -> Result<Self, GridTooLarge> {
        let mut structure = Self::without_blocks(world, options)?;
        structure.fill_blocks(world)?;
        Ok(structure)
    }

    /// The same with indices in place of the blocks.
    fn without_blocks(world: &World, GridOptions { cells, rule }: GridOptions) -> Result<Self, GridTooLarge> {
        let bounds = bounds_of(world);
        let Some(cells) = cells else {
            return Self::list(world, PrimSet::All, &bounds, Frame::new(&bounds));
        };
        let allowance = |max_per_cell: usize| Allowance::new(max_per_cell, world.finite_count());
        match rule {
            CellRule::Nested { max_per_cell } => {
                Self::automatic(world, PrimSet::All, bounds, cells, allowance(max_per_cell))
            }
            CellRule::Course { is_bounded: true } => {
                let fitted =
                    FittedLattice::new(world, &PrimSet::All, bounds, cells, rule, allowance(usize::MAX))?;
                Self::grid(world, PrimSet::All, fitted.lattice, fitted.cell_lists, &[])
            }
            CellRule::Exact | CellRule::Course { is_bounded: false } => {
                let lattice = Lattice::new(bounds, cells);
                let cell_lists = cell_lists(world, &PrimSet::All, &lattice, rule, &Budget::unlimited())?;
                Self::grid(world, PrimSet::All, lattice, cell_lists, &[])
            }
        }
    }

    /// Fills the blocks of all structures in one list.
    fn fill_blocks(&mut self, world: &World) -> Result<(), GridTooLarge> {
        let mut all = vec![];
        let count = self.place_blocks(0, 0, &mut all);
        let mut blocks: Vec<Block> = try_zeroed_vec(count).map_err(|()| GridTooLarge)?;
        let mut rest = blocks.as_mut_slice();
        let parts = all.into_iter().map(|cells| {
            let own = rest.split_off_mut(..cells.block_count()).unwrap_or_default();
            (cells, own)
        });
        parts.collect::<Vec<_>>().into_par_iter().for_each(|(cells, own)| cells.fill(world, own));
        self.blocks = blocks;
        Ok(())
    }

    /// Places the blocks of this structure at `first` in the list of all blocks, followed by those of the nested ones,
    /// and returns where they end. The blocks of the structure around it start at `outer`. The contents are appended to
    /// `all` in the same order.
    fn place_blocks<'s>(
        &'s mut self,
        outer: usize,
        first: usize,
        all: &mut Vec<&'s mut CellContents>,
    ) -> usize {
        self.cells.first_block = first - outer;
        let end = first + self.cells.block_count();
        all.push(&mut self.cells);
        let nested =
            self.nested.iter_mut().flat_map(|nested| nested.spanning.iter_mut().chain([&mut nested.grid]));
        nested.fold(end, |next, structure| structure.place_blocks(first, next, all))
    }

    /// The size of the structure, including all nested ones. Its blocks are the first of these.
    pub fn size(&self, blocks: &[Block]) -> StructureSize {
        let count = self.cells.block_count();
        let own = StructureSize {
            cells: self.table.as_ref().map_or(1, |table| table.lattice().index_count()),
            references: CellContents::references(&blocks[..count]),
            blocks: count,
            cost: self.cost,
        };
        let nested = self.nested.iter().flat_map(|nested| nested.spanning.iter().chain([&nested.grid]));
        nested.fold(own, |all, structure| all + structure.size(&blocks[structure.cells.first_block..]))
    }

    /// A list of the parts of `prims` that lie in a box.
    fn list(world: &World, prims: PrimSet, bounds: &Aabb, frame: Frame) -> Result<Self, GridTooLarge> {
        let cost = REFERENCE_COST * prims.count(world);
        Ok(Self {
            simd_bounds: SimdAabb::new(bounds),
            table: None,
            cells: CellContents::all(world, &prims, frame)?,
            blocks: vec![],
            nested: vec![],
            prims,
            cost,
            max_origin_distance: max_origin_distance(bounds, f64::INFINITY),
        })
    }

    /// The parts of `prims` that lie in a box, in a grid of at most these cells with nested grids in its
    /// crowded cells, or in a list if no grid within the allowance separates them.
    fn automatic(
        world: &World,
        prims: PrimSet,
        bounds: Aabb,
        cells: [usize; 3],
        allowance: Allowance,
    ) -> Result<Self, GridTooLarge> {
        let count = prims.count(world);
        let rule = CellRule::Nested { max_per_cell: allowance.max_per_cell };
        let FittedLattice { lattice, mut cell_lists, abandoned_cost } =
            FittedLattice::new(world, &prims, bounds, cells, rule, allowance)?;
        let (counts, references) = (cell_lists.counts(&lattice)?, cell_lists.references());
        if count > allowance.max_per_cell && !separates(&counts, count, references) {
            let frame = Frame::new(&bounds.union(bounds_of_prims(world, &prims)));
            let mut list = Self::list(world, prims, &bounds, frame)?;
            list.cost += abandoned_cost + cell_lists.cost();
            return Ok(list);
        }
        let nested_allowance = allowance.nested(count, references);
        let crowded = nested_allowance
            .map_or(Ok(vec![]), |nested| cell_lists.take_crowded(&counts, nested.max_per_cell))?;
        drop(counts);
        let mut grid = Self::grid(world, prims, lattice.clone(), cell_lists, &crowded)?;
        grid.cost += abandoned_cost;
        let Some(nested_allowance) = nested_allowance else {
            return Ok(grid);
        };
        let nest = |(cell, ids): &(u32, Vec<u32>)| {
            let ids = ids.iter().map(|&i| grid.prims.id(i as usize));
            NestedGrid::new(world, ids, &padded_cell(&lattice, *cell), nested_allowance)
        };
        grid.nested = crowded.par_iter().map(nest).collect::<Result<Vec<_>, _>>()?;
        Ok(grid)
    }

    /// A grid of `prims` with these cell lists. The entries of `crowded` cells, which the lists leave out,
    /// refer to nested grids, which the caller adds.
    fn grid(
        world: &World,
        prims: PrimSet,
        lattice: Lattice,
        cell_lists: CellLists,
        crowded: &[(u32, Vec<u32>)],
    ) -> Result<Self, GridTooLarge> {
        let cost = cell_lists.cost();
        let mut cells = CellContents::new(world, &lattice, &cell_lists, &prims)?;
        cells.link_nested(crowded.iter().map(|(cell, _)| *cell));
        let max_origin_distance = max_origin_distance(&lattice.bounds, lattice.cell_size.min_element());
        let simd_bounds = SimdAabb::new(&lattice.bounds);
        let table = Some(CellTable::new(lattice, cells.take_entries())?);
        let (blocks, nested) = (vec![], vec![]);
        Ok(Self { simd_bounds, table, cells, blocks, nested, prims, cost, max_origin_distance })
    }
}

/// Maximum distance of a ray's origin in cells, 2^31: the rounding errors of a hit point then stay below the
/// padding that `proofs/dda.g` assumes.
pub const MAX_ORIGIN_CELLS: f64 = 2147483648.0;

/// Maximum distance of a ray's origin in box sizes. That is at most 2^20 units of the filter's frame, for
/// which the proof of the filter holds.
const MAX_ORIGIN_BOXES: f64 = (1u32 << 19) as f64;

/// Maximum distance of a ray's origin from the centre of a box along each axis, for which the proofs of
/// filter and DDA hold. `min_cell_size` is the smallest edge length of the cells.
fn max_origin_distance(bounds: &Aabb, min_cell_size: f64) -> f64 {
    (bounds.extent().max_element() * MAX_ORIGIN_BOXES).min(min_cell_size * MAX_ORIGIN_CELLS)
}

/// The box of a cell, with twice the padding that was used for insertion.
fn padded_cell(lattice: &Lattice, index: u32) -> Aabb {
    let padding = padding(lattice);
    let cell = lattice.cell_of(index as usize);
    let corner = |cells: DVec3| lattice.bounds.min + cells * lattice.cell_size;
    Aabb { min: corner(cell - 2.0 * padding), max: corner(cell + (1.0 + 2.0 * padding)) }
}

impl NestedGrid {
    /// The nested grid of the primitives with these ids, restricted to a cell.
    fn new(
        world: &World,
        ids: impl ExactSizeIterator<Item = u32>,
        cell: &Aabb,
        allowance: Allowance,
    ) -> Result<Self, GridTooLarge> {
        let (mut spanning, mut grid) = (vec![], with_room_for(ids.len())?);
        for id in ids {
            match spans(&world.box_of(id), cell) {
                true => memory::push(&mut spanning, id).map_err(|_| GridTooLarge)?,
                false => grid.push(id),
            }
        }
        if spanning.len() > MAX_SPANNING {
            grid.append(&mut spanning);
            grid.sort_unstable();
        }
        let grid = PrimSet::Subset(grid);
        let (bounds, cells) = nested_cells(world, &grid, cell);
        let grid = AccelerationStructure::automatic(world, grid, bounds, cells, allowance)?;
        if spanning.is_empty() {
            return Ok(Self { spanning: None, grid });
        }
        let spanning = PrimSet::Subset(spanning);
        // The filter moves a ray's origin to where it enters the cell's box, so the frame must contain that
        // box too.
        let bounds = widened(*cell);
        let frame = Frame::new(&bounds.union(bounds_of_prims(world, &spanning)));
        Ok(Self { spanning: Some(AccelerationStructure::list(world, spanning, &bounds, frame)?), grid })
    }
}

/// Whether a box covers at least half of the cell along some axis.
fn spans(bounds: &Aabb, cell: &Aabb) -> bool {
    let common = bounds.max.min(cell.max) - bounds.min.max(cell.min);
    common.cmpge(0.5 * cell.extent()).any()
}

/// The bounding box of some primitives.
fn bounds_of_prims(world: &World, prims: &PrimSet) -> Aabb {
    (0..prims.count(world)).fold(Aabb::EMPTY, |all, i| all.union(world.box_of(prims.id(i))))
}

/// The bounds and the resolution of a nested grid, fitted to the part of the primitives' bounds that lies in
/// the cell.
fn nested_cells(world: &World, prims: &PrimSet, cell: &Aabb) -> (Aabb, [usize; 3]) {
    let all = bounds_of_prims(world, prims);
    let common = Aabb { min: all.min.max(cell.min), max: all.max.min(cell.max) };
    // The bounds of a primitive that only just touches the padded cell may miss it because of rounding.
    let bounds = widened(if common.is_empty() { *cell } else { common });
    (bounds, cubic(&bounds, NESTED_CELLS * prims.count(world) as f64))
}

#[cfg(test)]
mod tests;
