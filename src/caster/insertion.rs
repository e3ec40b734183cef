//! Insertion: finds the cells of a lattice that list each primitive, by the rule of the course's program: the cells that
//! the primitive's box touches, and for a sphere those whose centres are near it. If rays are only cast, a triangle is
//! left out of the cells that its plane does not touch. Cells are padded, so that the cell that the DDA visits at the t
//! of a hit always lists the primitive.

use crate::base::memory;
use crate::base::patience::{Ended, Patience, Steps};
use crate::caster::bounds::widened;
use crate::caster::dda::face_error_bound;
use crate::caster::lattice::{Lattice, NotBuilt};
use crate::math::aabb::Aabb;
use crate::math::robust::UNIT_ROUNDOFF;
use crate::world::shape::Shape;
use crate::world::sphere::Sphere;
use crate::world::{Primitive, World};
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// Returns the padded bounding box of all finite primitives.
pub fn bounds_of(world: &World) -> Aabb {
    widened(world.boxes().fold(world.bounds, |all, b| all.union(b)))
}

/// A primitive in a cell: the cell's index in the lattice, and the primitive's id.
pub type Reference = [u32; 2];

/// The number of primitives that one task inserts.
const PRIMS_PER_CHUNK: usize = 4096;

/// Returns the references of the finite primitives that rays may see, in ascending order of the primitives. The work is
/// done on all threads, as long as there is patience. The result does not depend on their number.
pub fn references(
    world: &World,
    lattice: &Lattice,
    patience: &dyn Patience,
) -> Result<Vec<Vec<Reference>>, NotBuilt> {
    lattice.ask_for_entries()?;
    let bytes = most_references(world, lattice).saturating_mul(size_of::<Reference>() as u64);
    memory::ask(bytes).map_err(|_| NotBuilt::TooLarge)?;
    let (count, padding) = (world.finite_count() as u32, padding(lattice));
    let chunk = |first: u32| {
        let (mut cells, mut references) = (vec![], Vec::with_capacity(4 * PRIMS_PER_CHUNK));
        let mut steps = Steps::new(patience);
        let ids = first..count.min(first + PRIMS_PER_CHUNK as u32);
        for id in ids.filter(|&id| world.may_be_seen(id)) {
            cells.clear();
            match world.primitive(id) {
                Primitive::Triangle(i) => of_triangle(lattice, world.corners(i), padding, &mut cells),
                _ => push_cells(world, id, lattice, &mut cells),
            }
            references.extend(cells.iter().map(|&cell| [cell, id]));
            steps.take(1 + cells.len())?;
        }
        Ok(references)
    };
    let firsts = (0..count).into_par_iter().step_by(PRIMS_PER_CHUNK);
    let references: Vec<_> = firsts.map(chunk).collect::<Result<_, Ended>>()?;
    let total: usize = references.iter().map(Vec::len).sum();
    if total <= u32::MAX as usize { Ok(references) } else { Err(NotBuilt::TooLarge) }
}

/// Returns an upper bound on the number of references: the number of cells that the primitives' boxes touch.
pub fn most_references(world: &World, lattice: &Lattice) -> u64 {
    // The course's rule for spheres reaches less than a cell beyond their boxes.
    let (padding, of_shapes) = (padding(lattice), 1.0);
    let ids = (0..world.finite_count() as u32).into_par_iter();
    ids.map(|id| {
        let padding = if world.is_triangle(id) { padding } else { of_shapes };
        count_of_box(lattice, &world.box_of(id), padding)
    })
    .sum()
}

/// Returns the padding of cells for insertion, in cells: the error bounds of the DDA and of hit points.
fn padding(lattice: &Lattice) -> f64 {
    face_error_bound(lattice) + POSITION_ERROR_BOUND
}

/// Error bound of the positions of a hit and a crossing due to roundings in f64, in cells: see `proofs/dda.g`.
const POSITION_ERROR_BOUND: f64 = 7.8e-6;

/// Appends the indices of the cells of a finite primitive, by the rule of the course's program.
pub fn push_cells(world: &World, id: u32, lattice: &Lattice, out: &mut Vec<u32>) {
    let padding = padding(lattice);
    if let Primitive::Shape(i) = world.primitive(id)
        && let Shape::Sphere(Sphere { center, radius }) = world.shapes[i]
    {
        of_ball(lattice, center, radius, padding, out);
    } else {
        CellRange::of_box(lattice, &world.box_of(id), padding).push_if(lattice, out, |_| true);
    }
}

/// Error bound of the plane of a triangle, in roundings of the cube of its length: see `proofs/needles.g`.
const PLANE_ROUNDINGS: f64 = 32.0;

/// Appends the index of every cell that both the box and the plane of a triangle touch, where each cell is padded by
/// `padding` cells.
fn of_triangle(lattice: &Lattice, corners: [DVec3; 3], padding: f64, out: &mut Vec<u32>) {
    let [a, b, c] = corners.map(|corner| lattice.to_cells(corner));
    let normal = (b - a).cross(c - a);
    // The normal of a needle is mostly rounding error and may have any direction. The error is proportional to the square
    // of the needle's length, and the error of the plane to the cube of the length.
    let length = (b - a).abs().max((c - a).abs()).max((c - b).abs()).max_element();
    let error_bound = PLANE_ROUNDINGS * UNIT_ROUNDOFF * length * length * length;
    // The largest distance of the plane from the centre of a cell that it touches, times the length of the normal.
    let max_distance = (0.5 + padding) * normal.abs().element_sum() + error_bound;
    let range = CellRange::of_box(lattice, &Aabb::around(corners), padding);
    range.push_if(lattice, out, |cell| normal.dot(cell + 0.5 - a).abs() <= max_distance);
}

/// Returns the cells that a box touches, each padded by `padding` cells, as runs of indices along x.
pub fn runs_of_box(lattice: &Lattice, bounds: &Aabb, padding: f64) -> impl Iterator<Item = Range<usize>> {
    let CellRange { start: [x0, y0, z0], end: [x1, y1, z1] } = CellRange::of_box(lattice, bounds, padding);
    let run = move |y: u32, z: u32| {
        let first = lattice.index([x0, y, z].map(|i| i as usize));
        first..first + (x1 - x0) as usize
    };
    (z0..z1).flat_map(move |z| (y0..y1).map(move |y| run(y, z)))
}

/// Returns the number of cells that a box touches, where each cell is padded by `padding` cells.
pub fn count_of_box(lattice: &Lattice, bounds: &Aabb, padding: f64) -> u64 {
    let range = CellRange::of_box(lattice, bounds, padding);
    (0..3).map(|axis| u64::from(range.end[axis] - range.start[axis])).product()
}

/// Appends the index of every cell whose centre is at most the radius plus half the cell's diagonal away from
/// the centre of the ball, where each cell is padded by `padding` cells. They include every cell that the ball touches.
pub fn of_ball(lattice: &Lattice, center: DVec3, radius: f64, padding: f64, out: &mut Vec<u32>) {
    let size = lattice.cell_size;
    // For a radius of very many cells, rounding loses the padding.
    let max_distance = radius * (1.0 + SPHERE_ROUNDINGS * UNIT_ROUNDOFF) + (0.5 + padding) * size.length();
    let bounds = Aabb { min: center - max_distance, max: center + max_distance };
    CellRange::of_box(lattice, &bounds, 0.0).push_if(lattice, out, |cell| {
        let cell_center = lattice.bounds.min + (cell + 0.5) * size;
        cell_center.distance(center) <= max_distance
    })
}

/// Error bound of a distance from a sphere's centre and of the points that a ray finds on the sphere, in roundings of the
/// radius: see `proofs/spheres.g`.
const SPHERE_ROUNDINGS: f64 = 64.0;

/// A box of cells, as a half-open range of coordinates along each axis; never empty.
struct CellRange {
    start: [u32; 3],
    end: [u32; 3],
}

impl CellRange {
    /// Returns the cells that a box touches, each padded by `padding` cells. A corner outside the lattice counts as in the
    /// nearest cell.
    #[inline(always)]
    fn of_box(lattice: &Lattice, bounds: &Aabb, padding: f64) -> Self {
        let [min, max] = [lattice.to_cells(bounds.min) - padding, lattice.to_cells(bounds.max) + padding];
        let (start, [x, y, z]) = (lattice.cell_at(min), lattice.cell_at(max));
        Self { start, end: [x + 1, y + 1, z + 1] }
    }

    /// Appends the cells for which `is_touched` holds; its argument is the cell's lower corner in units of
    /// cells.
    #[inline(always)]
    fn push_if(&self, lattice: &Lattice, out: &mut Vec<u32>, is_touched: impl Fn(DVec3) -> bool) {
        let [x0, y0, z0] = self.start;
        for z in z0..self.end[2] {
            for y in y0..self.end[1] {
                let start = lattice.index([x0, y, z].map(|i| i as usize)) as u32;
                out.reserve((self.end[0] - x0) as usize);
                for (x, index) in (x0..self.end[0]).zip(start..) {
                    if is_touched(DVec3::new(x.into(), y.into(), z.into())) {
                        out.push(index);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
