//! What the finite primitives stand in: one grid, with grids of their own for crowded cells, or one
//! list of everything.

use super::allowance::{Allowance, separates};
use super::cell_table::Words;
use super::cells::Cells;
use super::fitting::{Fitted, bounds_of, rows, slack};
use super::prim_set::Items;
use super::triangle8::Frame;
use crate::grid::Lattice;
use crate::grid::budget::{Budget, ENTRY_COST};
use crate::grid::cell_lists::{GridTooLarge, Rows, widened};
use crate::grid::options::{CellRule, GridOptions, cubic};
use crate::grid::ray_aabb::Slab;
use crate::math::aabb::Aabb;
use crate::world::World;
use glam::DVec3;
use rayon::prelude::*;

/// Up to so many primitives that span a crowded cell stand beside its grid instead of in it.
const WIDE: usize = 32;

/// Cells for each primitive in such a grid. Measured on a mesh of 2.5 million: with twice as many, rays
/// are slower by 5 to 10% and building by 25%.
const NESTED_CELLS: f64 = 0.4;

/// Some primitives, by cells or all in one list.
#[derive(Debug)]
pub struct Structure {
    pub slab: Slab,
    /// The cells of a grid; none in a list.
    pub words: Option<Words>,
    pub cells: Cells,
    /// What the cells hold whose words name it.
    pub nested: Vec<Crowd>,
    pub items: Items,
    /// What filling it has cost, what was given up included, without the nested ones.
    cost: usize,
    /// A ray that begins farther than this from the middle, along any axis, is too coarse for the
    /// proofs of filter and march; everything is tested for it one by one.
    pub farthest: f64,
}

/// How large a structure is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Size {
    /// Cells of all grids, their borders' included; a list counts as one.
    pub cells: usize,
    /// How many primitives stand in the cells and lists, each as often as it does.
    pub entries: usize,
    /// Blocks of eight triangles.
    pub blocks: usize,
    /// What building took, where looking at a cell for a primitive costs 1 and entering it there 16.
    pub cost: usize,
}

impl std::ops::Add for Size {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            cells: self.cells + other.cells,
            entries: self.entries + other.entries,
            blocks: self.blocks + other.blocks,
            cost: self.cost + other.cost,
        }
    }
}

/// What stands in a crowded cell.
#[derive(Debug)]
pub struct Crowd {
    /// What spans the cell, as a list: in the grid it would stand in most cells, and keep the grid from
    /// fitting around the rest.
    pub wide: Option<Structure>,
    /// The rest, as a grid.
    pub fine: Structure,
}

impl Structure {
    /// Of all finite primitives.
    pub fn new(world: &World, GridOptions { cells, rule }: GridOptions) -> Result<Self, GridTooLarge> {
        let bounds = bounds_of(world);
        let Some(cells) = cells else {
            return Self::listed(world, Items::All, &bounds, Frame::new(&bounds));
        };
        let allowance = |crowd: usize| Allowance::new(crowd, world.finite_count());
        match rule {
            CellRule::Nested { crowd } => Self::automatic(world, Items::All, bounds, cells, allowance(crowd)),
            CellRule::Course { is_bounded: true } => {
                let fitted = Fitted::new(world, &Items::All, bounds, cells, rule, allowance(usize::MAX))?;
                Self::gridded(world, Items::All, fitted.lattice, fitted.rows, &[])
            }
            CellRule::Exact | CellRule::Course { is_bounded: false } => {
                let lattice = Lattice::new(bounds, cells);
                let rows = rows(world, &Items::All, &lattice, rule, &Budget::unlimited())?;
                Self::gridded(world, Items::All, lattice, rows, &[])
            }
        }
    }

    /// How large it is, with everything nested in it.
    pub fn size(&self) -> Size {
        let own = Size {
            cells: self.words.as_ref().map_or(1, |words| words.lattice().index_count()),
            entries: self.cells.entries(),
            blocks: self.cells.blocks.len(),
            cost: self.cost,
        };
        let nested = self.nested.iter().flat_map(|crowd| crowd.wide.iter().chain([&crowd.fine]));
        nested.fold(own, |all, structure| all + structure.size())
    }

    /// Of `items` as far as they reach into a box, in the order of their numbers.
    fn listed(world: &World, items: Items, bounds: &Aabb, frame: Frame) -> Result<Self, GridTooLarge> {
        let cost = ENTRY_COST * items.count(world);
        Ok(Self {
            slab: Slab::new(bounds),
            words: None,
            cells: Cells::all(world, &items, frame)?,
            nested: vec![],
            items,
            cost,
            farthest: farthest(bounds, f64::INFINITY),
        })
    }

    /// Of `items` as far as they reach into a box: a grid of at most these cells with grids in its crowded
    /// cells, or a list where no grid that the allowance covers separates them.
    fn automatic(
        world: &World,
        items: Items,
        bounds: Aabb,
        cells: [usize; 3],
        allowance: Allowance,
    ) -> Result<Self, GridTooLarge> {
        let count = items.count(world);
        let rule = CellRule::Nested { crowd: allowance.crowd };
        let Fitted { lattice, mut rows, given_up } =
            Fitted::new(world, &items, bounds, cells, rule, allowance)?;
        let (counts, entries) = (rows.counts(&lattice)?, rows.entries());
        if count > allowance.crowd && !separates(&counts, count, entries) {
            let frame = Frame::new(&bounds.union(union(world, &items)));
            let mut list = Self::listed(world, items, &bounds, frame)?;
            list.cost += given_up + rows.cost();
            return Ok(list);
        }
        let within = allowance.within(count, entries);
        let crowded = within.map_or(Ok(vec![]), |within| rows.take_crowded(&counts, within.crowd))?;
        drop(counts);
        let mut grid = Self::gridded(world, items, lattice.clone(), rows, &crowded)?;
        grid.cost += given_up;
        let Some(within) = within else {
            return Ok(grid);
        };
        let nest = |(cell, held): &(u32, Vec<u32>)| {
            let held = held.iter().map(|&i| grid.items.number(i as usize)).collect();
            Crowd::new(world, held, &cell_box(&lattice, *cell), within)
        };
        grid.nested = crowded.par_iter().map(nest).collect::<Result<Vec<_>, _>>()?;
        Ok(grid)
    }

    /// A grid of the rows of `items`, and of cells that they leave out for grids of their own.
    fn gridded(
        world: &World,
        items: Items,
        lattice: Lattice,
        rows: Rows,
        crowded: &[(u32, Vec<u32>)],
    ) -> Result<Self, GridTooLarge> {
        let cost = rows.cost();
        let mut cells = Cells::new(world, &lattice, &rows, &items)?;
        cells.name_nested(crowded.iter().map(|(cell, _)| *cell));
        let farthest = farthest(&lattice.bounds, lattice.cell_size.min_element());
        let slab = Slab::new(&lattice.bounds);
        let words = Some(Words::new(lattice, cells.take_words())?);
        Ok(Self { slab, words, cells, nested: vec![], items, cost, farthest })
    }
}

/// So many cells away a dozen roundings of a ray's way stay below what cells are widened by for them: 2^32.
const FARTHEST_CELLS: f64 = 4294967296.0;

/// So many boxes from its middle, 2^20 of the filter's units, the proof of the filter holds: 2^19.
const FARTHEST_BOXES: f64 = 524288.0;

/// How far from a box' middle a ray may begin. `cell` is the least edge length of its cells.
fn farthest(bounds: &Aabb, cell: f64) -> f64 {
    (bounds.extent().max_element() * FARTHEST_BOXES).min(cell * FARTHEST_CELLS)
}

/// A cell, widened by more than what is entered in it.
fn cell_box(lattice: &Lattice, index: u32) -> Aabb {
    let slack = slack(lattice);
    let low = lattice.cell_of(index as usize);
    let corner = |cells: DVec3| lattice.bounds.min + cells * lattice.cell_size;
    Aabb { min: corner(low - 2.0 * slack), max: corner(low + (1.0 + 2.0 * slack)) }
}

impl Crowd {
    /// Of the primitives that a cell holds, as far as they reach into it.
    fn new(world: &World, held: Vec<u32>, cell: &Aabb, allowance: Allowance) -> Result<Self, GridTooLarge> {
        let (mut wide, mut fine): (Vec<u32>, _) =
            held.into_iter().partition(|&number| spans(&world.box_of(number), cell));
        if wide.len() > WIDE {
            fine.append(&mut wide);
            fine.sort_unstable();
        }
        let fine = Items::These(fine);
        let (bounds, cells) = nested_cells(world, &fine, cell);
        let fine = Structure::automatic(world, fine, bounds, cells, allowance)?;
        if wide.is_empty() {
            return Ok(Self { wide: None, fine });
        }
        let wide = Items::These(wide);
        // The filter's ray enters by the cell's box, so that the frame must hold that too.
        let bounds = widened(*cell);
        let frame = Frame::new(&bounds.union(union(world, &wide)));
        Ok(Self { wide: Some(Structure::listed(world, wide, &bounds, frame)?), fine })
    }
}

/// Whether a box reaches across half the cell or more along some axis.
fn spans(bounds: &Aabb, cell: &Aabb) -> bool {
    let common = bounds.max.min(cell.max) - bounds.min.max(cell.min);
    common.cmpge(0.5 * cell.extent()).any()
}

fn union(world: &World, items: &Items) -> Aabb {
    (0..items.count(world)).fold(Aabb::EMPTY, |all, i| all.union(world.box_of(items.number(i))))
}

/// Cells for as much of the primitives as lies in a cell, which may be little.
fn nested_cells(world: &World, items: &Items, cell: &Aabb) -> (Aabb, [usize; 3]) {
    let held = union(world, items);
    let common = Aabb { min: held.min.max(cell.min), max: held.max.min(cell.max) };
    // Something that only just touches the widened cell may miss it by rounding.
    let bounds = widened(if common.is_empty() { *cell } else { common });
    (bounds, cubic(&bounds, NESTED_CELLS * items.count(world) as f64))
}
