//! What the finite primitives stand in: one grid, with grids of their own for crowded cells, or one
//! list of everything.

use super::allowance::{Allowance, separates};
use super::cell_contents::CellContents;
use super::cell_table::CellTable;
use super::fitting::{Fitted, bounds_of, cell_lists, padding};
use super::prim_set::PrimSet;
use super::triangle8::Frame;
use crate::grid::Lattice;
use crate::grid::budget::{Budget, REFERENCE_COST};
use crate::grid::cell_lists::{CellLists, GridTooLarge, widened};
use crate::grid::options::{CellRule, GridOptions, cubic};
use crate::grid::ray_aabb::SimdAabb;
use crate::math::aabb::Aabb;
use crate::world::World;
use glam::DVec3;
use rayon::prelude::*;

/// Up to so many primitives that span a crowded cell stand beside its grid instead of in it.
const MAX_SPANNING: usize = 32;

/// Cells for each primitive in such a grid. Measured on a mesh of 2.5 million: with twice as many, rays
/// are slower by 5 to 10% and building by 25%.
const NESTED_CELLS: f64 = 0.4;

/// Some primitives, by cells or all in one list.
#[derive(Debug)]
pub struct AccelerationStructure {
    pub simd_bounds: SimdAabb,
    /// The cells of a grid; none in a list.
    pub table: Option<CellTable>,
    pub cells: CellContents,
    /// What the cells hold whose words name it.
    pub nested: Vec<NestedGrid>,
    pub prims: PrimSet,
    /// What filling it has cost, what was given up included, without the nested ones.
    cost: usize,
    /// A ray that begins farther than this from the middle, along any axis, is too coarse for the
    /// proofs of filter and march; everything is tested for it one by one.
    pub max_origin_distance: f64,
}

/// How large a structure is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StructureSize {
    /// Cells of all grids, their borders' included; a list counts as one.
    pub cells: usize,
    /// How many primitives stand in the cells and lists, each as often as it does.
    pub references: usize,
    /// Blocks of eight triangles.
    pub blocks: usize,
    /// What building took, where looking at a cell for a primitive costs 1 and entering it there 16.
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

/// What stands in a crowded cell.
#[derive(Debug)]
pub struct NestedGrid {
    /// What spans the cell, as a list: in the grid it would stand in most cells, and keep the grid from
    /// fitting around the rest.
    pub spanning: Option<AccelerationStructure>,
    /// The rest, as a grid.
    pub grid: AccelerationStructure,
}

impl AccelerationStructure {
    /// Of all finite primitives.
    pub fn new(world: &World, GridOptions { cells, rule }: GridOptions) -> Result<Self, GridTooLarge> {
        let bounds = bounds_of(world);
        let Some(cells) = cells else {
            return Self::listed(world, PrimSet::All, &bounds, Frame::new(&bounds));
        };
        let allowance = |max_per_cell: usize| Allowance::new(max_per_cell, world.finite_count());
        match rule {
            CellRule::Nested { max_per_cell } => {
                Self::automatic(world, PrimSet::All, bounds, cells, allowance(max_per_cell))
            }
            CellRule::Course { is_bounded: true } => {
                let fitted = Fitted::new(world, &PrimSet::All, bounds, cells, rule, allowance(usize::MAX))?;
                Self::gridded(world, PrimSet::All, fitted.lattice, fitted.cell_lists, &[])
            }
            CellRule::Exact | CellRule::Course { is_bounded: false } => {
                let lattice = Lattice::new(bounds, cells);
                let cell_lists = cell_lists(world, &PrimSet::All, &lattice, rule, &Budget::unlimited())?;
                Self::gridded(world, PrimSet::All, lattice, cell_lists, &[])
            }
        }
    }

    /// How large it is, with everything nested in it.
    pub fn size(&self) -> StructureSize {
        let own = StructureSize {
            cells: self.table.as_ref().map_or(1, |table| table.lattice().index_count()),
            references: self.cells.references(),
            blocks: self.cells.blocks.len(),
            cost: self.cost,
        };
        let nested = self.nested.iter().flat_map(|nested| nested.spanning.iter().chain([&nested.grid]));
        nested.fold(own, |all, structure| all + structure.size())
    }

    /// Of `prims` as far as they reach into a box, in the order of their numbers.
    fn listed(world: &World, prims: PrimSet, bounds: &Aabb, frame: Frame) -> Result<Self, GridTooLarge> {
        let cost = REFERENCE_COST * prims.count(world);
        Ok(Self {
            simd_bounds: SimdAabb::new(bounds),
            table: None,
            cells: CellContents::all(world, &prims, frame)?,
            nested: vec![],
            prims,
            cost,
            max_origin_distance: max_origin_distance(bounds, f64::INFINITY),
        })
    }

    /// Of `prims` as far as they reach into a box: a grid of at most these cells with grids in its crowded
    /// cells, or a list where no grid that the allowance covers separates them.
    fn automatic(
        world: &World,
        prims: PrimSet,
        bounds: Aabb,
        cells: [usize; 3],
        allowance: Allowance,
    ) -> Result<Self, GridTooLarge> {
        let count = prims.count(world);
        let rule = CellRule::Nested { max_per_cell: allowance.max_per_cell };
        let Fitted { lattice, mut cell_lists, given_up } =
            Fitted::new(world, &prims, bounds, cells, rule, allowance)?;
        let (counts, references) = (cell_lists.counts(&lattice)?, cell_lists.references());
        if count > allowance.max_per_cell && !separates(&counts, count, references) {
            let frame = Frame::new(&bounds.union(union(world, &prims)));
            let mut list = Self::listed(world, prims, &bounds, frame)?;
            list.cost += given_up + cell_lists.cost();
            return Ok(list);
        }
        let within = allowance.within(count, references);
        let crowded =
            within.map_or(Ok(vec![]), |within| cell_lists.take_crowded(&counts, within.max_per_cell))?;
        drop(counts);
        let mut grid = Self::gridded(world, prims, lattice.clone(), cell_lists, &crowded)?;
        grid.cost += given_up;
        let Some(within) = within else {
            return Ok(grid);
        };
        let nest = |(cell, ids): &(u32, Vec<u32>)| {
            let ids = ids.iter().map(|&i| grid.prims.id(i as usize)).collect();
            NestedGrid::new(world, ids, &cell_box(&lattice, *cell), within)
        };
        grid.nested = crowded.par_iter().map(nest).collect::<Result<Vec<_>, _>>()?;
        Ok(grid)
    }

    /// A grid of the rows of `prims`, and of cells that they leave out for grids of their own.
    fn gridded(
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
        Ok(Self { simd_bounds, table, cells, nested: vec![], prims, cost, max_origin_distance })
    }
}

/// So many cells away a dozen roundings of a ray's way stay below what cells are widened by for them: 2^32.
const MAX_ORIGIN_CELLS: f64 = 4294967296.0;

/// So many boxes from its middle, 2^20 of the filter's units, the proof of the filter holds: 2^19.
const MAX_ORIGIN_BOXES: f64 = 524288.0;

/// How far from a box' middle a ray may begin. `cell` is the least edge length of its cells.
fn max_origin_distance(bounds: &Aabb, cell: f64) -> f64 {
    (bounds.extent().max_element() * MAX_ORIGIN_BOXES).min(cell * MAX_ORIGIN_CELLS)
}

/// A cell, widened by more than what is entered in it.
fn cell_box(lattice: &Lattice, index: u32) -> Aabb {
    let padding = padding(lattice);
    let low = lattice.cell_of(index as usize);
    let corner = |cells: DVec3| lattice.bounds.min + cells * lattice.cell_size;
    Aabb { min: corner(low - 2.0 * padding), max: corner(low + (1.0 + 2.0 * padding)) }
}

impl NestedGrid {
    /// Of the primitives that a cell holds, as far as they reach into it.
    fn new(world: &World, ids: Vec<u32>, cell: &Aabb, allowance: Allowance) -> Result<Self, GridTooLarge> {
        let (mut spanning, mut grid): (Vec<u32>, _) =
            ids.into_iter().partition(|&id| spans(&world.box_of(id), cell));
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
        // The filter's ray enters by the cell's box, so that the frame must hold that too.
        let bounds = widened(*cell);
        let frame = Frame::new(&bounds.union(union(world, &spanning)));
        Ok(Self { spanning: Some(AccelerationStructure::listed(world, spanning, &bounds, frame)?), grid })
    }
}

/// Whether a box reaches across half the cell or more along some axis.
fn spans(bounds: &Aabb, cell: &Aabb) -> bool {
    let common = bounds.max.min(cell.max) - bounds.min.max(cell.min);
    common.cmpge(0.5 * cell.extent()).any()
}

fn union(world: &World, prims: &PrimSet) -> Aabb {
    (0..prims.count(world)).fold(Aabb::EMPTY, |all, i| all.union(world.box_of(prims.id(i))))
}

/// Cells for as much of the primitives as lies in a cell, which may be little.
fn nested_cells(world: &World, prims: &PrimSet, cell: &Aabb) -> (Aabb, [usize; 3]) {
    let all = union(world, prims);
    let common = Aabb { min: all.min.max(cell.min), max: all.max.min(cell.max) };
    // Something that only just touches the widened cell may miss it by rounding.
    let bounds = widened(if common.is_empty() { *cell } else { common });
    (bounds, cubic(&bounds, NESTED_CELLS * prims.count(world) as f64))
}
