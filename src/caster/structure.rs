//! What the finite primitives stand in: one grid, with grids of their own for crowded cells, or one
//! list of everything.

use super::Insertion;
use super::block::Frame;
use super::cells::Cells;
use super::items::Items;
use super::words::Words;
use crate::grid::Lattice;
use crate::grid::build::{GridTooLarge, Rows, widened};
use crate::grid::footprint;
use crate::grid::march::drift;
use crate::grid::passage::Slab;
use crate::grid::resolution::cubic;
use crate::math::aabb::Aabb;
use crate::world::{Primitive, World};
use glam::DVec3;
use rayon::prelude::*;

/// Up to so many primitives that span a crowded cell stand beside its grid instead of in it.
const WIDE: usize = 32;

/// Cells for each primitive in such a grid. Measured on a mesh of 2.5 million: with twice as many, rays
/// are slower by 5 to 10% and building by 25%.
const NESTED_CELLS: f64 = 0.4;

/// So many grids one within the other. Where many primitives share a point no grid parts them, and
/// without a limit the cells around it would be cut for ever.
const DEPTH: usize = 4;

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
    /// A ray that begins farther than this from the middle, along any axis, is too coarse for the
    /// proofs of filter and march; everything is tested for it one by one.
    pub farthest: f64,
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
    pub fn new(world: &World, cells: Option<[usize; 3]>, insertion: Insertion) -> Result<Self, GridTooLarge> {
        let bounds = widened(world.boxes().fold(world.bounds, |all, b| all.union(b)));
        let Some(cells) = cells else {
            return Self::listed(world, Items::All, &bounds, Frame::new(&bounds));
        };
        let depth = if matches!(insertion, Insertion::Nested { .. }) { DEPTH } else { 1 };
        Self::gridded(world, Items::All, Lattice::new(bounds, cells), insertion, depth)
    }

    /// Of `items` as far as they reach into a box, in the order of their numbers.
    fn listed(world: &World, items: Items, bounds: &Aabb, frame: Frame) -> Result<Self, GridTooLarge> {
        Ok(Self {
            slab: Slab::new(bounds),
            words: None,
            cells: Cells::all(world, &items, frame)?,
            nested: vec![],
            items,
            farthest: farthest(bounds, f64::INFINITY),
        })
    }

    /// Of `items` as far as they reach into the lattice, with grids up to `depth` deep.
    fn gridded(
        world: &World,
        items: Items,
        lattice: Lattice,
        insertion: Insertion,
        depth: usize,
    ) -> Result<Self, GridTooLarge> {
        let slack = slack(&lattice);
        let mut rows = Rows::new(&lattice, items.count(world), |i, out| {
            enter(world, items.number(i), &lattice, insertion, slack, out)
        })?;
        let crowded = match insertion {
            Insertion::Nested { crowd } if depth > 1 => rows.take_crowded(&lattice, crowd)?,
            _ => vec![],
        };
        let mut cells = Cells::new(world, &lattice, &rows, &items)?;
        drop(rows);
        let nest = |(cell, held): &(u32, Vec<u32>)| {
            let held = held.iter().map(|&i| items.number(i as usize)).collect();
            Crowd::new(world, held, &cell_box(&lattice, *cell), insertion, depth - 1)
        };
        let nested = crowded.par_iter().map(nest).collect::<Result<Vec<_>, _>>()?;
        cells.name_nested(crowded.iter().map(|(cell, _)| *cell));
        let farthest = farthest(&lattice.bounds, lattice.cell_size.min_element());
        let slab = Slab::new(&lattice.bounds);
        let words = Some(Words::new(lattice, cells.take_words())?);
        Ok(Self { slab, words, cells, nested, items, farthest })
    }
}

/// By how much of a cell the cells are widened: a little more than the march needs, for the rounding
/// of a hit's place.
fn slack(lattice: &Lattice) -> f64 {
    drift(lattice) + 1e-5
}

/// Up to 2^20 boxes away the filter's proof holds, and up to 2^32 cells away a dozen roundings of the
/// ray's way stay below the hundred-thousandth of a cell that cells are widened by.
fn farthest(bounds: &Aabb, cell: f64) -> f64 {
    (bounds.extent().max_element() * 0.5f64.powi(-19)).min(cell * 0.5f64.powi(-32))
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
    fn new(
        world: &World,
        held: Vec<u32>,
        cell: &Aabb,
        insertion: Insertion,
        depth: usize,
    ) -> Result<Self, GridTooLarge> {
        let (mut wide, mut fine): (Vec<u32>, _) =
            held.into_iter().partition(|&number| spans(&world.box_of(number), cell));
        if wide.len() > WIDE {
            fine.append(&mut wide);
            fine.sort_unstable();
        }
        let lattice = nested_lattice(world, &fine, cell);
        let fine = Structure::gridded(world, Items::These(fine), lattice, insertion, depth)?;
        if wide.is_empty() {
            return Ok(Self { wide: None, fine });
        }
        // The filter's ray enters by the cell's box, so that the frame must hold that too.
        let bounds = widened(*cell);
        let frame = Frame::new(&bounds.union(union(world, &wide)));
        let wide = Structure::listed(world, Items::These(wide), &bounds, frame)?;
        Ok(Self { wide: Some(wide), fine })
    }
}

/// Whether a box reaches across half the cell or more along some axis.
fn spans(bounds: &Aabb, cell: &Aabb) -> bool {
    let common = bounds.max.min(cell.max) - bounds.min.max(cell.min);
    common.cmpge(0.5 * cell.extent()).any()
}

fn union(world: &World, numbers: &[u32]) -> Aabb {
    numbers.iter().fold(Aabb::EMPTY, |all, &number| all.union(world.box_of(number)))
}

/// A lattice over as much of the primitives as lies in a cell, which may be little.
fn nested_lattice(world: &World, numbers: &[u32], cell: &Aabb) -> Lattice {
    let held = union(world, numbers);
    let common = Aabb { min: held.min.max(cell.min), max: held.max.min(cell.max) };
    // Something that only just touches the widened cell may miss it by rounding.
    let bounds = widened(if common.is_empty() { *cell } else { common });
    Lattice::new(bounds, cubic(&bounds, NESTED_CELLS * numbers.len() as f64))
}

/// Appends the cells of a primitive.
fn enter(
    world: &World,
    number: u32,
    lattice: &Lattice,
    insertion: Insertion,
    slack: f64,
    out: &mut Vec<u32>,
) -> Result<(), GridTooLarge> {
    match (world.primitive(number), insertion) {
        (Primitive::Triangle(i), Insertion::Course) => {
            footprint::of_box(lattice, &Aabb::around(world.corners(i)), slack, out)
        }
        (Primitive::Triangle(i), _) => footprint::of_triangle(lattice, world.corners(i), slack, out),
        (Primitive::Sphere(i), Insertion::Course) => {
            let sphere = &world.spheres[i];
            footprint::of_ball_by_centers(lattice, sphere.center, sphere.radius, slack, out)
        }
        (Primitive::Sphere(i), _) => {
            let sphere = &world.spheres[i];
            footprint::of_sphere(lattice, sphere.center, sphere.radius, slack, out)
        }
        (Primitive::Ellipsoid(i), _) => footprint::of_box(lattice, &world.ellipsoids[i].bounds(), slack, out),
        (Primitive::Plane(_), _) => Ok(()),
    }
}
