//! `-visualize_grid`: the occupied cells themselves, by the course's own rule of insertion.
//!
//! The tracer's grid enters a primitive wherever its box reaches. The course's picture shows a
//! coarser rule for spheres and a tolerance at cell faces, so it has counters of its own.

use crate::grid::budget::{Budget, TouchedCells};
use crate::grid::cell_lists::{GridTooLarge, filled_with};
use crate::grid::dda::March;
use crate::grid::{Lattice, voxelize};
use crate::math::aabb::Aabb;
use crate::math::ray::Ray;
use crate::scene::{Color, Object, Scene, mesh::Mesh};
use crate::world::{Placement, course_sphere_box, placements};
use glam::DVec3;

/// How far a box may stay short of a cell, in cells, and still count as touching it.
const TOUCH: f64 = 1e-5;

/// How many primitives the course's program enters in each cell.
#[derive(Clone, Debug)]
pub struct Occupancy {
    lattice: Lattice,
    /// By index; [`BORDER`] around the lattice.
    counts: Vec<u32>,
}

const BORDER: u32 = u32::MAX;

/// The face by which a ray comes upon an occupied cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Where the ray meets it.
    pub t: f64,
    /// Outward unit normal of the face.
    pub normal: DVec3,
    /// By the number of primitives in the cell.
    pub color: Color,
}

impl Occupancy {
    /// `bounds` is the world's box; it may be empty, and then every ray misses.
    pub fn new(
        scene: &Scene,
        meshes: &[Mesh],
        bounds: Aabb,
        cells: [usize; 3],
    ) -> Result<Self, GridTooLarge> {
        let lattice = Lattice::new(bounds, cells);
        lattice.fits()?;
        let mut counts = filled_with(BORDER, lattice.index_count())?;
        let [nx, ny, nz] = cells;
        for (j, k) in (0..nz).flat_map(|k| (0..ny).map(move |j| (j, k))) {
            counts[lattice.index([0, j, k])..][..nx].fill(0);
        }
        let mut occupancy = Self { lattice, counts };
        if !bounds.is_empty() {
            let budget = Budget::unlimited();
            let mut touched = TouchedCells::new(&budget);
            placements(scene).try_for_each(|placement| occupancy.enter(&placement, meshes, &mut touched))?;
        }
        Ok(occupancy)
    }

    fn enter(
        &mut self,
        placement: &Placement,
        meshes: &[Mesh],
        touched: &mut TouchedCells,
    ) -> Result<(), GridTooLarge> {
        let map = |p: DVec3| placement.matrix.transform_point3(p);
        let mut enter_box = |corners: Aabb| voxelize::of_box(&self.lattice, &corners, TOUCH, touched);
        match *placement.object {
            Object::Sphere { center, radius, .. } if placement.transform.is_none() => {
                voxelize::of_ball_by_centers(&self.lattice, center, radius, 0.0, touched)
            }
            Object::Sphere { center, radius, .. } => enter_box(course_sphere_box(center, radius, placement)),
            Object::Triangle { vertices, .. } => enter_box(Aabb::around(vertices.map(map))),
            Object::Box { min, max, .. } => enter_box(Aabb::around(Aabb { min, max }.corners().map(map))),
            Object::Mesh { mesh, .. } => {
                let Mesh { vertices, triangles } = &meshes[mesh];
                let corners = |triangle: &[u32; 3]| triangle.map(|v| map(vertices[v as usize]));
                triangles.iter().try_for_each(|triangle| enter_box(Aabb::around(corners(triangle))))
            }
            Object::Plane { .. } | Object::Group(_) | Object::Transform { .. } => Ok(()),
        }?;
        touched.indices.drain(..).for_each(|index| self.counts[index as usize] += 1);
        Ok(())
    }

    /// The first occupied cell along the ray.
    pub fn first_face(&self, ray: &Ray) -> Option<Face> {
        let (mut march, [entry, _]) = March::of_ray(&self.lattice, ray)?;
        let mut face = self.face(march.index(), entry, self.face_at(entry, ray), ray);
        while face.is_none() {
            let mut index = march.index();
            let stays = march.step();
            // Where faces meet, cells are passed one by one: x before y before z.
            for axis in (0..3).filter(|axis| stays >> axis & 1 == 0) {
                index = index.wrapping_add_signed(march.stride(axis));
                if self.counts[index] == BORDER {
                    return None;
                }
                let entry = self.entry_across(axis, index, ray);
                face = face.or_else(|| self.face(index, entry, Some(axis), ray));
            }
        }
        face
    }

    /// The face by which the ray enters a cell, if the cell is occupied.
    fn face(&self, index: usize, t: f64, by: Option<usize>, ray: &Ray) -> Option<Face> {
        let count = self.counts[index];
        (count > 0).then(|| Face { t, normal: face_normal(by, ray), color: count_color(count) })
    }

    /// The axis whose face the ray crosses at its entry; none where it begins inside.
    fn face_at(&self, entry: f64, ray: &Ray) -> Option<usize> {
        let at = ray.at(entry);
        let Aabb { min, max } = self.lattice.bounds;
        let away = (at - min).abs().min((at - max).abs());
        (entry > ray.t_min).then(|| away.min_position())
    }

    /// Where the ray enters a cell across the face that `axis` pierces.
    fn entry_across(&self, axis: usize, index: usize, ray: &Ray) -> f64 {
        let cell = self.lattice.cell_of(index)[axis] + f64::from(ray.direction[axis] < 0.0);
        let face = self.lattice.bounds.min[axis] + cell * self.lattice.cell_size[axis];
        (face - ray.origin[axis]) / ray.direction[axis]
    }
}

/// The normal of the face entered by. A ray that begins inside an occupied cell is shown the face it
/// would have come through if it ran along its longest axis.
fn face_normal(by: Option<usize>, ray: &Ray) -> DVec3 {
    let axis = by.unwrap_or_else(|| ray.direction.abs().max_position());
    DVec3::AXES[axis] * -ray.direction[axis].signum()
}

/// The course's scale from white over blue, green and yellow to red.
fn count_color(count: u32) -> Color {
    const SCALE: [[f64; 3]; 17] = [
        [1.0, 1.0, 1.0],
        [1.0, 0.0, 1.0],
        [0.7, 0.0, 1.0],
        [0.3, 0.0, 1.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.3, 1.0],
        [0.0, 0.7, 1.0],
        [0.0, 1.0, 1.0],
        [0.0, 1.0, 0.7],
        [0.0, 1.0, 0.3],
        [0.0, 1.0, 0.0],
        [0.3, 1.0, 0.0],
        [0.7, 1.0, 0.0],
        [1.0, 1.0, 0.0],
        [1.0, 0.7, 0.0],
        [1.0, 0.3, 0.0],
        [1.0, 0.0, 0.0],
    ];
    Color::from_array(SCALE[(count as usize).clamp(1, SCALE.len()) - 1])
}
