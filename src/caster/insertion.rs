//! Insertion: finds the cells of a lattice that list each primitive. Cells are padded, so that the cell that the DDA
//! visits at the t of a hit always lists the primitive.
//!
//! For a triangle, the plane and the projections along the three axes must overlap the cell (Schwarz and Seidel, "Fast
//! Parallel Surface and Solid Voxelization on GPUs", SIGGRAPH Asia 2010). `proofs/needles.g` proves the error bound of
//! the plane.

use crate::base::patience::{Ended, Patience, Steps};
use crate::caster::bounds::widened;
use crate::caster::dda::face_error_bound;
use crate::caster::lattice::{Lattice, NotBuilt};
use crate::math::aabb::Aabb;
use crate::math::extremes::{box_corners, max3, min3};
use crate::math::robust::UNIT_ROUNDOFF;
use crate::world::shape::Shape;
use crate::world::sphere::Sphere;
use crate::world::{Primitive, World};
use glam::{DVec2, DVec3, Vec3Swizzles};
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

/// Returns the references of all finite primitives, in ascending order of the primitives. They are to the cells that
/// the primitives touch or, with `as_course`, to the cells into which the course's program inserts them, so that the
/// counts are comparable. The work is done on all threads, as long as there is patience. The result does not depend on
/// their number.
pub fn references(
    world: &World,
    lattice: &Lattice,
    as_course: bool,
    patience: &dyn Patience,
) -> Result<Vec<Vec<Reference>>, NotBuilt> {
    lattice.ask_for_entries()?;
    let (count, padding) = (world.finite_count() as u32, padding(lattice));
    let chunk = |first: u32| {
        let (mut cells, mut references) = (vec![], Vec::with_capacity(4 * PRIMS_PER_CHUNK));
        let mut steps = Steps::new(patience);
        for id in first..count.min(first + PRIMS_PER_CHUNK as u32) {
            cells.clear();
            insert(world, id, lattice, as_course, padding, &mut cells);
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

/// Appends the cells of a primitive.
fn insert(world: &World, id: u32, lattice: &Lattice, as_course: bool, padding: f64, out: &mut Vec<u32>) {
    if !as_course && !world.may_be_seen(id) {
        return;
    }
    match world.primitive(id) {
        Primitive::Triangle(_) if as_course => of_box(lattice, &world.box_of(id), padding, out),
        Primitive::Triangle(i) => of_triangle(lattice, world.corners(i), padding, out),
        Primitive::Shape(i) => match world.shapes[i] {
            Shape::Sphere(Sphere { center, radius }) if as_course => {
                of_ball_by_centers(lattice, center, radius, padding, out)
            }
            Shape::Sphere(Sphere { center, radius }) => of_sphere(lattice, center, radius, padding, out),
            _ => of_box(lattice, &world.box_of(id), padding, out),
        },
        Primitive::Plane(_) => {}
    }
}

/// Appends the index of every cell that a box touches, where each cell is padded by `padding` cells.
pub fn of_box(lattice: &Lattice, bounds: &Aabb, padding: f64, out: &mut Vec<u32>) {
    CellRange::of_box(lattice, bounds, padding).push_if(lattice, out, |_| true)
}

/// Returns the cells that [`of_box`] appends, as runs of indices along x.
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
/// the centre of the ball, where each cell is padded by `padding` cells. This is the course's rule for
/// spheres. It includes every cell that the ball touches.
pub fn of_ball_by_centers(lattice: &Lattice, center: DVec3, radius: f64, padding: f64, out: &mut Vec<u32>) {
    let size = lattice.cell_size;
    let max_distance = radius + (0.5 + padding) * size.length();
    let bounds = Aabb { min: center - max_distance, max: center + max_distance };
    CellRange::of_box(lattice, &bounds, 0.0).push_if(lattice, out, |cell| {
        let cell_center = lattice.bounds.min + (cell + 0.5) * size;
        cell_center.distance(center) <= max_distance
    })
}

/// Appends the index of every cell that the surface of a sphere touches, where each cell is padded by `padding` cells.
/// Cells inside the sphere are left out, since no ray hits the sphere there.
pub fn of_sphere(lattice: &Lattice, center: DVec3, radius: f64, padding: f64, out: &mut Vec<u32>) {
    let (center_in_cells, size) = (lattice.to_cells(center), lattice.cell_size);
    let bounds = Aabb { min: center - radius, max: center + radius };
    let square = radius * radius;
    CellRange::of_box(lattice, &bounds, padding).push_if(lattice, out, |cell| {
        let (min, max) = (cell - padding, cell + (1.0 + padding));
        let nearest = (center_in_cells - center_in_cells.clamp(min, max)) * size;
        let farthest = (center_in_cells - min).abs().max((max - center_in_cells).abs()) * size;
        // For a radius of very many cells, rounding loses the padding.
        let touches_ball = nearest.length_squared() <= square * (1.0 + SPHERE_ROUNDINGS * UNIT_ROUNDOFF);
        touches_ball && farthest.length_squared() >= square * (1.0 - SPHERE_ROUNDINGS * UNIT_ROUNDOFF)
    })
}

/// Error bound of a squared distance from a sphere's centre and of the points that a ray finds on the sphere, in
/// roundings of the squared radius: see `proofs/spheres.g`.
const SPHERE_ROUNDINGS: f64 = 128.0;

/// A box of cells, as a half-open range of coordinates along each axis; never empty.
struct CellRange {
    start: [u32; 3],
    end: [u32; 3],
}

impl CellRange {
    /// Returns the cells that a box touches, each padded by `padding` cells.
    fn of_box(lattice: &Lattice, bounds: &Aabb, padding: f64) -> Self {
        Self::new(lattice, lattice.to_cells(bounds.min), lattice.to_cells(bounds.max), padding)
    }

    /// Returns the cells between two points in units of cells, padded by `padding` cells. A point outside the lattice
    /// counts as in the nearest cell.
    #[inline(always)]
    fn new(lattice: &Lattice, min: DVec3, max: DVec3, padding: f64) -> Self {
        // The conversion saturates at 0, and maps NaN to 0.
        let cell = |x: f64, axis: usize| (x as u32).min(lattice.cells()[axis] as u32 - 1);
        let (min, max) = ((min - padding).to_array(), (max + padding).to_array());
        Self {
            start: [0, 1, 2].map(|axis| cell(min[axis], axis)),
            end: [0, 1, 2].map(|axis| cell(max[axis], axis) + 1),
        }
    }

    /// Returns true if the range has several cells along at most one axis.
    #[inline(always)]
    fn is_line(&self) -> bool {
        let spans_cells = |axis: &usize| self.end[*axis] > self.start[*axis] + 1;
        (0..3).filter(spans_cells).count() <= 1
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

/// Appends the index of every cell that a triangle touches, where each cell is padded by `padding` cells.
#[inline]
pub fn of_triangle(lattice: &Lattice, corners: [DVec3; 3], padding: f64, out: &mut Vec<u32>) {
    let v = corners.map(|p| lattice.to_cells(p));
    let [min, max] = box_corners(v);
    let range = CellRange::new(lattice, min, max, padding);
    if range.is_line() {
        // The triangle touches all of these cells.
        range.push_if(lattice, out, |_| true);
    } else {
        let triangle = TriangleOverlap::new(v, 0.5 + padding);
        range.push_if(lattice, out, |cell| triangle.overlaps(cell + 0.5));
    }
}

/// A triangle projected along an axis, for overlap tests with cells. The cell with the centre (u, v) overlaps it if
/// `a u + b v + c >= 0` for each of the three edges. The padding of cells is far above the rounding errors of these
/// sums.
struct Projection([[f64; 3]; 3]);

impl Projection {
    /// Takes the projected corners in units of cells. `half` is half the edge length of a padded cell.
    #[inline(always)]
    fn new([p, q, r]: [DVec2; 3], half: f64) -> Self {
        let edge = |from: DVec2, to: DVec2, opposite: DVec2| {
            let (a, b) = (from.y - to.y, to.x - from.x);
            // The sign makes the interior the positive side of the edge, whatever the orientation is. It may be wrong
            // only if rounding errors hide the side of this edge on which the triangle lies. Then the whole triangle
            // practically lies on the edge. A common sign for all edges is not enough: the area of a needle has the
            // rounding errors of its long edges, which hide the side of a short edge.
            let sign = 1f64.copysign(a * (opposite.x - from.x) + b * (opposite.y - from.y));
            let (a, b) = (a * sign, b * sign);
            [a, b, half * (a.abs() + b.abs()) - (a * from.x + b * from.y)]
        };
        Self([edge(p, q, r), edge(q, r, p), edge(r, p, q)])
    }

    /// Returns true if the cell with this centre, in units of cells, overlaps the projection.
    #[inline(always)]
    fn overlaps(&self, center: DVec2) -> bool {
        min3(self.0.map(|[a, b, c]| a * center.x + b * center.y + c)) >= 0.0
    }
}

/// Error bound of the plane of a triangle, in roundings of the cube of its length: see `proofs/needles.g`.
const PLANE_ROUNDINGS: f64 = 32.0;

/// A triangle for overlap tests with cells: its plane and its projections along the three axes.
struct TriangleOverlap {
    normal: DVec3,
    /// The dot product of the normal and any point of the plane.
    offset: f64,
    /// The largest distance of the plane from the centre of a cell that it touches, times the length of the
    /// normal.
    max_distance: f64,
    xy: Projection,
    yz: Projection,
    zx: Projection,
}

impl TriangleOverlap {
    /// Takes the corners in units of cells. `half` is half the edge length of a padded cell.
    #[inline(always)]
    fn new(v: [DVec3; 3], half: f64) -> Self {
        let sides = [v[1] - v[0], v[2] - v[1], v[0] - v[2]];
        let normal = sides[0].cross(v[2] - v[0]);
        // The normal of a needle is mostly rounding error and may have any direction. The error is proportional to the
        // square of the needle's length, and the error of the plane to the cube of the length.
        let length = max3(box_corners(sides.map(DVec3::abs))[1].to_array());
        let plane_error_bound = PLANE_ROUNDINGS * UNIT_ROUNDOFF * length * length * length;
        Self {
            normal,
            offset: normal.dot(v[0]),
            max_distance: half * normal.abs().element_sum() + plane_error_bound,
            xy: Projection::new(v.map(DVec3::xy), half),
            yz: Projection::new(v.map(DVec3::yz), half),
            zx: Projection::new(v.map(DVec3::zx), half),
        }
    }

    /// Returns true if the cell with this centre, in units of cells, overlaps the triangle.
    #[inline(always)]
    fn overlaps(&self, center: DVec3) -> bool {
        (self.normal.dot(center) - self.offset).abs() <= self.max_distance
            && self.xy.overlaps(center.xy())
            && self.yz.overlaps(center.yz())
            && self.zx.overlaps(center.zx())
    }
}

#[cfg(test)]
mod tests;
