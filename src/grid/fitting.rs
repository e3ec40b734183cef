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
    use crate::grid::build::MAX_ORIGIN_CELLS;
    use crate::grid::dda::{Dda, T_ONE};
    use crate::math::double_double::Dd;
    use crate::math::ray::Ray;
    use glam::DVec3;

    #[test]
    fn cells_are_padded_by_the_face_error_bound_and_that_of_positions() {
        let lattice = Lattice::new(Aabb { min: DVec3::ZERO, max: DVec3::ONE }, [4096, 2, 3]);
        let more = padding(&lattice) - face_error_bound(&lattice);
        assert!((0.9 * POSITION_ERROR_BOUND..1.1 * POSITION_ERROR_BOUND).contains(&more), "{more}");
    }

    /// In a flat lattice, how far the faces along y lie, in cells, from where an exact ray is at the t at which the
    /// DDA crosses them.
    fn largest_position_error(lattice: &Lattice, ray: &Ray) -> Option<f64> {
        let (mut dda, [entry, exit]) = Dda::of_ray(lattice, ray)?;
        let t_per_unit = Dd::from(1.0 / (T_ONE / (exit - entry)));
        let y = |unit: i32| {
            let t = Dd::from(entry) + Dd::from(f64::from(unit)) * t_per_unit;
            let from_min = Dd::from(ray.origin.y) + t * ray.direction.y.into() - lattice.bounds.min.y.into();
            (from_min * (lattice.cells()[1] as f64).into()).value() / lattice.bounds.extent().y
        };
        let mut largest = 0.0f64;
        loop {
            let [cell, unit] = [lattice.cell_of(dda.index()), DVec3::splat(f64::from(dda.exit()))];
            dda.step();
            let next = lattice.cell_of(dda.index());
            if next.x != cell.x || next.z != cell.z {
                return Some(largest);
            }
            largest = largest.max((y(unit.x as i32) - next.y.max(cell.y)).abs());
            if !(0.0..lattice.cells()[1] as f64).contains(&next.y) {
                return Some(largest);
            }
        }
    }

    /// The position error of a ray, and the padding of its lattice, both in cells. The numbers from 0 to 1 choose the
    /// lattice's size and place, where the ray passes it, and the length of its direction. Its origin is as far away
    /// as it may be, where rounding errors are those just above a power of two.
    fn errors([size, place, target, length]: [f64; 4]) -> Option<[f64; 2]> {
        let extent = DVec3::new(1.0, (1.0 + size) / 1024.0, 1.0);
        let min = DVec3::new(0.0, place, 0.0);
        let lattice = Lattice::new(Aabb { min, max: min + extent }, [1, 7, 1]);
        let target = min + extent * DVec3::new(0.5, target, 0.5);
        let far = MAX_ORIGIN_CELLS * lattice.cell_size.y;
        let origin = target + far * DVec3::new(0.3, 1.0, 0.2);
        let ray = Ray::new(origin, (1.0 + length) * (target - origin));
        Some([largest_position_error(&lattice, &ray)?, padding(&lattice)])
    }

    #[test]
    fn crossings_of_rays_from_far_away_need_a_tenth_of_the_padding() {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let mut worst = [0.0; 2];
        for _ in 0..16 {
            let mut input = [0; 4].map(|_| random());
            let mut best = [0.0; 2];
            for _ in 0..10_000 {
                let mut next = input;
                let k = (4.0 * random()) as usize;
                next[k] = (next[k] + f64::powf(10.0, -12.0 * random()) * (random() - 0.5)).clamp(0.0, 1.0);
                if let Some(found) = errors(next)
                    && found[0] >= best[0]
                {
                    (input, best) = (next, found);
                }
            }
            worst = if best[0] > worst[0] { best } else { worst };
        }
        let [error, padding] = worst;
        println!("crossings are off by {error:e} cells, of a padding of {padding:e}");
        // The rest is for the hits' own errors.
        assert!(error < padding && error > 0.1 * padding, "{error:e} of {padding:e}");
    }
}
