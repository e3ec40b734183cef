//! The cells that primitives touch, in a lattice no finer than the allowance covers. This step connects
//! primitives and rules of insertion to [`super::voxelize`], which knows only shapes.

use super::allowance::{Allowance, coarser};
use super::budget::{Budget, TouchedCells};
use super::cell_lists::{CellLists, widened};
use super::dda::face_error_bound;
use super::error::GridTooLarge;
use super::lattice::Lattice;
use super::options::CellRule;
use super::prim_set::PrimSet;
use super::voxelize;
use crate::math::aabb::Aabb;
use crate::world::{Primitive, World};

/// A lattice whose cell lists an allowance covers.
pub struct FittedLattice {
    pub lattice: Lattice,
    pub cell_lists: CellLists,
    /// The cost of abandoned attempts with finer lattices, which the allowance did not cover.
    pub abandoned_cost: usize,
}

impl FittedLattice {
    /// A lattice with this number of cells along each axis, or fewer if their lists would exceed the
    /// allowance.
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
        let (mut lattice, mut abandoned_cost) = (Lattice::new(bounds, cells), 0);
        loop {
            let budget = Budget::new(cost, CellLists::chunk_count(count));
            match (cell_lists(world, prims, &lattice, rule, &budget), coarser(lattice.cells())) {
                (Ok(cell_lists), _) => return Ok(Self { lattice, cell_lists, abandoned_cost }),
                (Err(_), Some(cells)) => lattice = Lattice::new(bounds, cells),
                (Err(error), None) => return Err(error),
            }
            abandoned_cost += cost;
        }
    }
}

/// The padded bounding box of all finite primitives.
pub fn bounds_of(world: &World) -> Aabb {
    widened(world.boxes().fold(world.bounds, |all, b| all.union(b)))
}

/// The cells of each of `prims` in a lattice, or an error when they exceed the budget.
pub fn cell_lists(
    world: &World,
    prims: &PrimSet,
    lattice: &Lattice,
    rule: CellRule,
    budget: &Budget,
) -> Result<CellLists, GridTooLarge> {
    let padding = padding(lattice);
    CellLists::within(budget, lattice, prims.count(world), |i, out| {
        insert(world, prims.id(i), lattice, rule, padding, out)
    })
}

/// The padding of cells for insertion, in cells: the error bounds of the DDA and of hit points.
pub fn padding(lattice: &Lattice) -> f64 {
    face_error_bound(lattice) + POSITION_ERROR_BOUND
}

/// Error bound of the position of a hit or a crossing because of f64 roundings, in cells: see `proofs/dda.g`.
const POSITION_ERROR_BOUND: f64 = 1e-5;

/// Appends the cells into which a primitive is inserted by a rule.
fn insert(
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

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn cells_are_padded_by_the_face_error_bound_and_that_of_positions() {
        let lattice = Lattice::new(Aabb { min: DVec3::ZERO, max: DVec3::ONE }, [4096, 2, 3]);
        let more = padding(&lattice) - face_error_bound(&lattice);
        assert!((0.9 * POSITION_ERROR_BOUND..1.1 * POSITION_ERROR_BOUND).contains(&more), "{more}");
    }
}
