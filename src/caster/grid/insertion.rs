//! Insertion: the cells of a lattice that each primitive is in. This step connects primitives and rules of insertion to
//! [`crate::caster::grid::voxelize`], which knows only shapes.

use crate::caster::error::GridTooLarge;
use crate::caster::grid::cell_lists::{CellLists, widened};
use crate::caster::grid::dda::face_error_bound;
use crate::caster::grid::lattice::Lattice;
use crate::caster::grid::touched_cells::TouchedCells;
use crate::caster::grid::voxelize;
use crate::math::aabb::Aabb;
use crate::primitive::shape::{Form, InCells};
use crate::primitive::sphere::Sphere;
use crate::world::{Primitive, World};
use rayon::prelude::*;

/// Into which cells a primitive is inserted. The rule never changes a hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellRule {
    /// The cells that it touches.
    Exact,
    /// The cells into which the course's program inserts it, so that counts compare with the course's.
    Course,
}

/// The padded bounding box of all finite primitives.
pub fn bounds_of(world: &World) -> Aabb {
    widened(world.boxes().fold(world.bounds, |all, b| all.union(b)))
}

/// The cells of each finite primitive in a lattice.
pub fn cell_lists(world: &World, lattice: &Lattice, rule: CellRule) -> Result<CellLists, GridTooLarge> {
    let padding = padding(lattice);
    CellLists::new(lattice, world.finite_count(), |i, out| {
        insert(world, i as u32, lattice, rule, padding, out)
    })
}

/// An upper bound on the number of cells of all primitives together: those that their boxes touch.
pub fn most_references(world: &World, lattice: &Lattice) -> u64 {
    // The course's rule for spheres reaches less than a cell beyond their boxes.
    let (padding, of_shapes) = (padding(lattice), 1.0);
    let ids = (0..world.finite_count() as u32).into_par_iter();
    ids.map(|id| {
        let padding = if world.is_triangle(id) { padding } else { of_shapes };
        voxelize::count_of_box(lattice, &world.box_of(id), padding)
    })
    .sum()
}

/// The padding of cells for insertion, in cells: the error bounds of the DDA and of hit
/// points.
fn padding(lattice: &Lattice) -> f64 {
    face_error_bound(lattice) + POSITION_ERROR_BOUND
}

/// Error bound of the positions of a hit and a crossing because of f64 roundings, in cells: see `proofs/dda.g`.
const POSITION_ERROR_BOUND: f64 = 7.8e-6;

/// Appends the cells into which a primitive is inserted by a rule.
fn insert(world: &World, id: u32, lattice: &Lattice, rule: CellRule, padding: f64, out: &mut TouchedCells) {
    match (world.primitive(id), rule) {
        (Primitive::Triangle(i), CellRule::Course) => {
            voxelize::of_box(lattice, &Aabb::around(world.corners(i)), padding, out)
        }
        (Primitive::Triangle(_), _) if !world.may_be_hit(id) => {}
        (Primitive::Triangle(i), _) => voxelize::of_triangle(lattice, world.corners(i), padding, out),
        (Primitive::Shape(i), _) => match (world.shapes[i].in_cells(), rule) {
            (InCells::Sphere(Sphere { center, radius }), CellRule::Course) => {
                voxelize::of_ball_by_centers(lattice, center, radius, padding, out)
            }
            (InCells::Sphere(Sphere { center, radius }), _) => {
                voxelize::of_sphere(lattice, center, radius, padding, out)
            }
            (InCells::Box(bounds), _) => voxelize::of_box(lattice, &bounds, padding, out),
        },
        (Primitive::Plane(_), _) => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::caster::blocks::triangle8::Frame;
    use crate::caster::grid::dda::{Dda, T_ONE};
    use crate::caster::reach::MAX_ORIGIN_CELLS;
    use crate::math::double_double::{Dd, difference, dot};
    use crate::math::ray::Ray;
    use crate::math::robust::UNIT_ROUNDOFF;
    use crate::math::worst_case::{Input, Rng, search};
    use glam::DVec3;

    #[test]
    fn cells_are_padded_by_the_face_error_bound_and_that_of_positions() {
        let lattice = Lattice::new(Aabb { min: DVec3::ZERO, max: DVec3::ONE }, [4096, 2, 3]);
        let more = padding(&lattice) - face_error_bound(&lattice);
        assert!((0.9 * POSITION_ERROR_BOUND..1.1 * POSITION_ERROR_BOUND).contains(&more), "{more}");
    }

    /// `proofs/box8.g` assumes it for the boxes of trees, which end at the corners of padded cells. Cells far from the
    /// origin are not smaller than `widened` makes them.
    #[test]
    fn the_corners_of_cells_are_off_by_at_most_two_roundings_of_single_precision() {
        let (rng, mut largest) = (&mut Rng(1), 0.0f64);
        for _ in 0..20_000 {
            let (min, extent) = (rng.vector(), libm::exp2(-60.0 * rng.unit()) * rng.vector().abs());
            let bounds = widened(Aabb { min, max: min + extent });
            let counts = [0, 1, 2].map(|_| 1 + rng.below(50));
            let lattice = Lattice::new(bounds, counts);
            let (scale, padding) = (Frame::new(&bounds).scale, padding(&lattice));
            let cell = counts.map(|count| rng.below(count as u64));
            let padded = lattice.box_of(lattice.index(cell), padding);
            for axis in 0..3 {
                let (first, count) = (bounds.min[axis], Dd::from(counts[axis] as f64));
                let whole = Dd::difference(bounds.max[axis], first);
                let off = |corner: f64, cells: Dd| {
                    (Dd::difference(corner, first) * count - cells * whole).value() / count.value() * scale
                };
                let cells = [cell[axis], cell[axis] + 1].map(|cells| Dd::from(cells as f64));
                let below = off(padded.min[axis], cells[0] - padding.into());
                let above = off(padded.max[axis], cells[1] + padding.into());
                largest = largest.max(below.abs()).max(above.abs());
            }
        }
        let roundings = largest * libm::exp2(24.0);
        assert!((0.5..=2.0).contains(&roundings), "{roundings}");
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

    /// A ray from as far away as it may come, where rounding errors are those just above a power of two: a corner and
    /// the extent of a lattice, the ray's origin, where in the lattice it is aimed, and the length of its direction.
    fn from_far_away(rng: &mut Rng) -> Input<5> {
        let extent = DVec3::new(1e5, CELLS as f64 * (1.0 + rng.unit()), 1e5);
        let min = DVec3::new(0.0, rng.signed(), 0.0);
        let far = MAX_ORIGIN_CELLS * extent.y / CELLS as f64;
        let origin = min + far * DVec3::new(0.3, 1.0 - 1e-9 * rng.unit(), 0.2);
        [min, extent, origin, DVec3::splat(0.5), DVec3::splat(1.0 + rng.unit())]
    }

    const CELLS: usize = 7;

    /// The largest error of a crossing, in roundings of the largest distance in cells.
    fn crossing(&[min, extent, origin, part, length]: &Input<5>) -> Option<f64> {
        let lattice = Lattice::new(Aabb { min, max: min + extent }, [1, CELLS, 1]);
        let farthest = MAX_ORIGIN_CELLS * lattice.cell_size.min_element();
        let is_within = (origin - (min + 0.5 * extent)).abs().max_element() <= farthest;
        let is_aimed =
            part.min_element() > 0.0 && part.max_element() < 1.0 && length.x > 1e-3 && extent.y > 1e-3;
        if !(is_within && is_aimed) {
            return None;
        }
        let ray = Ray::new(origin, length.x * (min + part * extent - origin));
        Some(largest_position_error(&lattice, &ray)? / (MAX_ORIGIN_CELLS * UNIT_ROUNDOFF))
    }

    /// A ray along a diagonal from the origin, and a sphere ahead at a distance of about one.
    fn sphere_far_away(rng: &mut Rng) -> Input<3> {
        let diagonal = DVec3::ONE + 1e-2 * rng.vector();
        [1e-3 * rng.vector(), diagonal, diagonal + DVec3::splat(1e-3).with_x(0.1 * rng.unit())]
    }

    /// The distance of a sphere's hit from its surface, in roundings of the origin's largest distance
    /// from its centre along an axis.
    fn off_sphere(&[origin, direction, place]: &Input<3>) -> Option<f64> {
        let sphere = Sphere { center: place, radius: 1e-2 };
        let t = sphere.intersect(&Ray::new(origin, direction))?;
        let from_center = difference(origin, sphere.center);
        let at = [0, 1, 2].map(|k| from_center[k] + Dd::from(t) * direction[k].into());
        let radius = Dd::from(sphere.radius);
        let off = (dot(at, at) - radius * radius).value() / (2.0 * sphere.radius);
        Some(off.abs() / ((origin - sphere.center).abs().max_element() * UNIT_ROUNDOFF))
    }

    /// The errors of crossings and of hits are of different roundings, so that a ray can have both. Other than spheres,
    /// what is hit is less far from where it seems to be.
    #[test]
    fn crossings_and_hits_of_rays_from_far_away_need_half_of_the_padding() {
        let (crossing, _) = search(16, 60_000, from_far_away, crossing);
        let (hit, _) = search(16, 200_000, sphere_far_away, off_sphere);
        let padding = POSITION_ERROR_BOUND / (MAX_ORIGIN_CELLS * UNIT_ROUNDOFF);
        println!(
            "crossings are off by {crossing:.2} roundings and hits by {hit:.2}, of a padding of {padding:.2}"
        );
        assert!((0.5..1.0).contains(&((crossing + hit) / padding)), "{crossing} {hit} {padding}");
    }
}
