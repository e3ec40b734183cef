//! The cells that primitives touch, in a lattice that is no finer than it may be.

use super::allowance::{Allowance, coarser};
use super::options::CellRule;
use super::prim_set::PrimSet;
use crate::grid::Lattice;
use crate::grid::budget::{Budget, TouchedCells};
use crate::grid::cell_lists::{CellLists, GridTooLarge, widened};
use crate::grid::dda::face_error_bound;
use crate::grid::voxelize;
use crate::math::aabb::Aabb;
use crate::world::{Primitive, World};

/// A lattice with rows that an allowance covers.
pub struct Fitted {
    pub lattice: Lattice,
    pub cell_lists: CellLists,
    /// What the rows of finer lattices have cost, which it does not cover.
    pub given_up: usize,
}

impl Fitted {
    /// Of these cells, or of fewer where their rows would cost more than the allowance covers.
    pub fn new(
        world: &World,
        prims: &PrimSet,
        bounds: Aabb,
        cells: [usize; 3],
        rule: CellRule,
        allowance: Allowance,
    ) -> Result<Self, GridTooLarge> {
        let count = prims.count(world);
        let cost = allowance.cost(count);
        let (mut lattice, mut given_up) = (Lattice::new(bounds, cells), 0);
        loop {
            let budget = Budget::new(cost, CellLists::chunk_count(count));
            match (cell_lists(world, prims, &lattice, rule, &budget), coarser(lattice.cells())) {
                (Ok(cell_lists), _) => return Ok(Self { lattice, cell_lists, given_up }),
                (Err(_), Some(cells)) => lattice = Lattice::new(bounds, cells),
                (Err(error), None) => return Err(error),
            }
            given_up += cost;
        }
    }
}

/// The box around everything finite, a little larger.
pub fn bounds_of(world: &World) -> Aabb {
    widened(world.boxes().fold(world.bounds, |all, b| all.union(b)))
}

/// The cells of a lattice's `prims`, as far as the budget allows.
pub fn cell_lists(
    world: &World,
    prims: &PrimSet,
    lattice: &Lattice,
    rule: CellRule,
    budget: &Budget,
) -> Result<CellLists, GridTooLarge> {
    let padding = padding(lattice);
    CellLists::within(budget, lattice, prims.count(world), |i, out| {
        enter(world, prims.id(i), lattice, rule, padding, out)
    })
}

/// By how much of a cell the cells are widened: a little more than the march needs, for the rounding
/// of a hit's place.
pub fn padding(lattice: &Lattice) -> f64 {
    face_error_bound(lattice) + POSITION_ERROR_BOUND
}

/// The most that a dozen roundings of a ray's way can be, in cells: see `proofs/dda.g`.
const POSITION_ERROR_BOUND: f64 = 1e-5;

/// Appends the cells of a primitive.
fn enter(
    world: &World,
    id: u32,
    lattice: &Lattice,
    rule: CellRule,
    padding: f64,
    out: &mut TouchedCells,
) -> Result<(), GridTooLarge> {
    match (world.primitive(id), rule) {
        (Primitive::Triangle(i), CellRule::Course { .. }) => {
            voxelize::of_box(lattice, &Aabb::around(world.corners(i)), padding, out)
        }
        (Primitive::Triangle(i), _) => voxelize::of_triangle(lattice, world.corners(i), padding, out),
        (Primitive::Sphere(i), CellRule::Course { .. }) => {
            let sphere = &world.spheres[i];
            voxelize::of_ball_by_centers(lattice, sphere.center, sphere.radius, padding, out)
        }
        (Primitive::Sphere(i), _) => {
            let sphere = &world.spheres[i];
            voxelize::of_sphere(lattice, sphere.center, sphere.radius, padding, out)
        }
        (Primitive::Ellipsoid(i), _) => {
            voxelize::of_box(lattice, &world.ellipsoids[i].bounds(), padding, out)
        }
        (Primitive::Plane(_), _) => Ok(()),
    }
}
