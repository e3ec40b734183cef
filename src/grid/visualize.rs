//! `-visualize_grid`: the occupied cells themselves, by the course's own rule of insertion.
//!
//! The tracer's grid enters a primitive wherever its box reaches. The course's picture shows a
//! coarser rule for spheres and a tolerance at cell faces, so it has counters of its own.

use super::{Lattice, build::GridTooLarge, march::March};
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
    counts: Vec<u32>,
}

/// The face by which a ray comes upon an occupied cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
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
        let mut counts = Vec::new();
        counts.try_reserve_exact(lattice.cell_count()).map_err(|_| GridTooLarge)?;
        counts.resize(lattice.cell_count(), 0);
        let mut occupancy = Self { lattice, counts };
        if !bounds.is_empty() {
            placements(scene).for_each(|placement| occupancy.enter(&placement, meshes));
        }
        Ok(occupancy)
    }

    fn enter(&mut self, placement: &Placement, meshes: &[Mesh]) {
        let map = |p: DVec3| placement.matrix.transform_point3(p);
        match *placement.object {
            Object::Sphere { center, radius, .. } if placement.transform.is_none() => {
                self.enter_sphere(center, radius)
            }
            Object::Sphere { center, radius, .. } => {
                self.enter_box(course_sphere_box(center, radius, placement))
            }
            Object::Triangle { vertices, .. } => self.enter_box(Aabb::around(vertices.map(map))),
            Object::Box { min, max, .. } => {
                self.enter_box(Aabb::around(Aabb { min, max }.corners().map(map)))
            }
            Object::Mesh { mesh, .. } => {
                let Mesh { vertices, triangles } = &meshes[mesh];
                let corners = |t: &[u32; 3]| t.map(|v| map(vertices[v as usize]));
                triangles.iter().for_each(|t| self.enter_box(Aabb::around(corners(t))));
            }
            Object::Plane { .. } | Object::Group(_) | Object::Transform { .. } => {}
        }
    }

    fn enter_box(&mut self, bounds: Aabb) {
        self.lattice.for_each_cell(&bounds, TOUCH, |cell| self.counts[cell] += 1);
    }

    /// Every cell whose centre lies within the radius and half the cell's diagonal of the sphere's.
    fn enter_sphere(&mut self, center: DVec3, radius: f64) {
        let size = self.lattice.cell_size;
        let reach = radius + 0.5 * size.length();
        let [nx, ny, _] = self.lattice.cells;
        let around = Aabb { min: center - reach, max: center + reach };
        self.lattice.for_each_cell(&around, 0.0, |cell| {
            let place = DVec3::new((cell % nx) as f64, (cell / nx % ny) as f64, (cell / nx / ny) as f64);
            let middle = self.lattice.bounds.min + (place + 0.5) * size;
            self.counts[cell] += (middle.distance(center) <= reach) as u32;
        });
    }

    /// The first occupied cell along the ray.
    pub fn first_face(&self, ray: &Ray) -> Option<Face> {
        let mut march = March::new(&self.lattice, ray)?;
        while self.counts[march.cell] == 0 {
            if !march.step() {
                return None;
            }
        }
        Some(Face {
            t: march.entry,
            normal: entered_face(&march, ray),
            color: count_color(self.counts[march.cell]),
        })
    }
}

/// The normal of the face entered by. A ray that begins inside an occupied cell is shown the face it
/// would have come through if it ran along its longest axis.
fn entered_face(march: &March, ray: &Ray) -> DVec3 {
    let axis = march.entered_by.unwrap_or_else(|| ray.direction.abs().max_position());
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
