//! `-visualize_grid`: a picture of the grid's occupied cells, by the course's rule for inserting primitives.
//!
//! The grid of the acceleration structure does not serve for this picture, because the course's program inserts
//! spheres by a coarser rule and has a tolerance at the faces of cells. So this module counts the primitives of each
//! cell.

use crate::base::patience::{Ended, Patience, Steps};
use crate::caster::NotBuilt;
use crate::caster::cell_counts::CellCounts;
use crate::caster::dda::Dda;
use crate::caster::insertion;
use crate::caster::lattice::Lattice;
use crate::math::aabb::Aabb;
use crate::math::ray::Ray;
use crate::picture::Color;
use crate::scene::{Object, Scene, mesh::Mesh};
use crate::shading::light::incident;
use crate::world::{Placement, World, placements};
use glam::DVec3;

/// The distance, in cells, up to which a box next to a cell counts as touching it.
const TOUCH: f64 = 1e-5;

/// The number of primitives that the course's program inserts into each cell.
#[derive(Debug)]
pub struct Occupancy(CellCounts);

/// The face through which a ray enters an occupied cell.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Face {
    /// The t where the ray crosses the face.
    t: f64,
    /// The outward unit normal of the face.
    normal: DVec3,
    /// The colour for the number of primitives in the cell.
    color: Color,
}

impl Face {
    fn lit(&self, ray: &Ray, world: &World) -> Color {
        let lights = world.lights.iter().map(|light| {
            let light = incident(light, ray.at(self.t));
            light.color * self.normal.dot(light.direction).max(0.0)
        });
        self.color * (world.ambient + lights.sum::<Color>())
    }
}

impl Occupancy {
    /// Counts the primitives in each cell. `bounds` is the world's box. If it is empty, every ray misses. Fails if the
    /// grid is too large for the memory, or if the patience is over.
    pub fn new(
        scene: &Scene,
        meshes: &[Mesh],
        bounds: Aabb,
        cells: [usize; 3],
        patience: &dyn Patience,
    ) -> Result<Self, NotBuilt> {
        let mut occupancy = Self(CellCounts::empty(Lattice::new(bounds, cells))?);
        if !bounds.is_empty() {
            let mut steps = Steps::new(patience);
            placements(scene).try_for_each(|placement| occupancy.insert(&placement, meshes, &mut steps))?;
        }
        Ok(occupancy)
    }

    fn insert(&mut self, placement: &Placement, meshes: &[Mesh], steps: &mut Steps) -> Result<(), Ended> {
        let map = |p: DVec3| placement.matrix.transform_point3(p);
        match *placement.object {
            Object::Sphere { center, radius, .. } if placement.transform.is_none() => {
                let mut touched = vec![];
                insertion::of_ball(&self.0.lattice, center, radius, 0.0, &mut touched);
                self.0.add(&touched);
                steps.take(touched.len())
            }
            Object::Triangle { vertices, .. } => {
                self.0.add_box(&Aabb::around(vertices.map(map)), TOUCH, steps)
            }
            Object::Box { min, max, .. } => {
                self.0.add_box(&placement.course_box(Aabb { min, max }), TOUCH, steps)
            }
            Object::Grid { ref surface, .. } => self.insert_mesh(surface, map, steps),
            Object::Mesh { mesh, .. } => self.insert_mesh(&meshes[mesh], map, steps),
            _ => match placement.object.shape_box() {
                Some(of_object) => self.0.add_box(&placement.course_box(of_object), TOUCH, steps),
                None => Ok(()),
            },
        }
    }

    fn insert_mesh(
        &mut self,
        Mesh { vertices, triangles }: &Mesh,
        map: impl Fn(DVec3) -> DVec3,
        steps: &mut Steps,
    ) -> Result<(), Ended> {
        let corners = |triangle: &[u32; 3]| triangle.map(|v| map(vertices[v as usize]));
        triangles
            .iter()
            .try_for_each(|triangle| self.0.add_box(&Aabb::around(corners(triangle)), TOUCH, steps))
    }

    /// Returns the colour that a camera ray sees: the face of the first occupied cell in the ambient and diffuse light
    /// of the world, without shadows, or else the background.
    pub fn color(&self, ray: &Ray, world: &World) -> Color {
        self.first_face(ray).map_or(world.background, |face| face.lit(ray, world))
    }

    /// Returns the face of the first occupied cell along the ray.
    fn first_face(&self, ray: &Ray) -> Option<Face> {
        let (mut dda, [entry, _]) = Dda::of_ray(&self.0.lattice, ray)?;
        let mut index = dda.index();
        if self.0.at(index).is_some_and(|count| count > 0) {
            return Some(self.face(index, entry, self.entry_axis(entry, ray), ray));
        }
        loop {
            let unchanged_axes = dda.step();
            // If a ray crosses several faces at once, visit the cells one by one: x before y before z.
            for axis in (0..3).filter(|axis| unchanged_axes >> axis & 1 == 0) {
                index = index.wrapping_add_signed(dda.stride(axis));
                match self.0.at(index)? {
                    0 => {}
                    _ => {
                        let t = self.entry_across(axis, index, ray);
                        return Some(self.face(index, t, axis, ray));
                    }
                }
            }
        }
    }

    /// Returns the face with this axis as its normal through which the ray enters an occupied cell at `t`.
    fn face(&self, index: usize, t: f64, axis: usize, ray: &Ray) -> Face {
        let normal = DVec3::AXES[axis] * -ray.direction[axis].signum();
        Face { t, normal, color: count_color(self.0.at(index).unwrap_or(0)) }
    }

    /// Returns the axis of the face through which the ray enters the grid at `entry`. A ray that starts inside gets the
    /// face through which it would have entered along its longest axis.
    fn entry_axis(&self, entry: f64, ray: &Ray) -> usize {
        if entry <= ray.t_min {
            return ray.direction.abs().max_position();
        }
        let (at, Aabb { min, max }) = (ray.at(entry), self.0.lattice.bounds);
        (at - min).abs().min((at - max).abs()).min_position()
    }

    /// Returns the t where the ray enters a cell through the face with this axis as its normal.
    fn entry_across(&self, axis: usize, index: usize, ray: &Ray) -> f64 {
        let cell = self.0.lattice.cell_of(index)[axis] + f64::from(ray.direction[axis] < 0.0);
        let face = self.0.lattice.bounds.min[axis] + cell * self.0.lattice.cell_size[axis];
        (face - ray.origin[axis]) / ray.direction[axis]
    }
}

/// The course's colour scale, from white through blue, green and yellow to red: the colours of cells with one
/// primitive, two, and so on. Cells with more primitives have the last colour.
pub const SCALE: [[f64; 3]; 17] = [
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

fn count_color(count: u32) -> Color {
    Color::from_array(SCALE[(count as usize).clamp(1, SCALE.len()) - 1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::patience::Endless;
    use crate::scene::parser::parse;

    /// Returns the occupancy of the box from (0, 0, 0) to (4, 4, 2) with unit cells. The given cells are occupied.
    fn occupied(cells: &[[usize; 3]]) -> Occupancy {
        let scene =
            "OrthographicCamera { center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 } Group { numObjects 0 }";
        let bounds = Aabb { min: DVec3::ZERO, max: DVec3::new(4.0, 4.0, 2.0) };
        let mut occupancy = Occupancy::new(&parse(scene).unwrap(), &[], bounds, [4, 4, 2], &Endless).unwrap();
        for &cell in cells {
            occupancy.0.add(&[occupancy.0.lattice.index(cell) as u32]);
        }
        occupancy
    }

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
        Ray::new(DVec3::from_array(origin), DVec3::from_array(direction))
    }

    /// All primitives are inserted by their boxes, except a sphere that is not transformed.
    #[test]
    fn cells_count_the_primitives_that_touch_them() {
        let objects = "Material { }
            Sphere { center 1.2 1.1 1 radius 0.7 }
            Plane { normal 0 1 0 offset 0 }
            Box { min 2.2 2.2 0.5 max 3.5 2.8 0.6 }
            Transform { Translate 1 0 0 Triangle { vertex0 0.5 0.5 0.5 vertex1 2.5 0.5 0.5 vertex2 0.5 1.5 0.5 } }
            Transform { Translate 3.5 3.5 0 Sphere { center 0 0 0 radius 0.2 } }
            TriangleMesh { obj_file mesh.obj }";
        let text = format!(
            "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
             Group {{ numObjects 6 {objects} }}"
        );
        let corners = [[0.5, 3.0, 1.5], [0.6, 3.5, 1.5], [0.4, 3.5, 1.5], [0.5, 3.5, 1.999_999]];
        let vertices = corners.map(DVec3::from_array).to_vec();
        let mesh = Mesh { vertices, triangles: vec![[0, 1, 2], [3, 1, 2]] };
        let bounds = Aabb { min: DVec3::ZERO, max: DVec3::new(4.0, 4.0, 2.0) };
        let occupancy = Occupancy::new(&parse(&text).unwrap(), &[mesh], bounds, [4, 4, 2], &Endless).unwrap();
        let boxes = [
            [[2.2, 2.2, 0.5], [3.5, 2.8, 0.6]],
            [[1.5, 0.5, 0.5], [3.5, 1.5, 0.5]],
            [[3.3, 3.3, -0.2], [3.7, 3.7, 0.2]],
            // This box touches a face between cells, and counts in the cells on both sides.
            [[0.4, 3.0 - TOUCH, 1.5], [0.6, 3.5, 1.5]],
            [[0.4, 3.5, 1.5], [0.6, 3.5, 2.0]],
        ];
        let mut total = 0;
        for index in 0..32 {
            let cell = [index % 4, index / 4 % 4, index / 16];
            let corner = DVec3::from_array(cell.map(|i| i as f64));
            let touches = |[min, max]: &[[f64; 3]; 2]| {
                DVec3::from_array(*min).cmple(corner + 1.0).all()
                    && DVec3::from_array(*max).cmpge(corner).all()
            };
            let in_sphere = (corner + 0.5).distance(DVec3::new(1.2, 1.1, 1.0)) <= 0.7 + 0.75f64.sqrt();
            let expected = boxes.iter().filter(|b| touches(b)).count() as u32 + u32::from(in_sphere);
            assert_eq!(occupancy.0.at(occupancy.0.lattice.index(cell)), Some(expected), "{cell:?}");
            total += expected;
        }
        assert!(total > 16);
        let inside = (0..occupancy.0.lattice.index_count()).filter(|&index| occupancy.0.at(index).is_some());
        assert_eq!(inside.count(), 32);
    }

    #[test]
    fn an_empty_world_shows_no_face() {
        let scene = "OrthographicCamera { center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }
            Group { numObjects 1 Material { } Plane { normal 0 1 0 offset 0 } }";
        let occupancy =
            Occupancy::new(&parse(scene).unwrap(), &[], Aabb::EMPTY, [2, 2, 2], &Endless).unwrap();
        assert_eq!(occupancy.first_face(&ray([0.5, 0.5, -1.0], [0.1, 0.2, 1.0])), None);
    }

    /// A ray through an edge also visits the cells beside the edge, first the cell across the face along x.
    #[test]
    fn a_ray_through_an_edge_steps_along_x_before_y_before_z() {
        let [across, corner] = [ray([-1.0, -1.0, 0.5], [1.0, 1.0, 0.0]), ray([-1.0; 3], [1.0; 3])];
        let t = |occupancy: Occupancy, ray: &Ray| occupancy.first_face(ray).map(|face| (face.t, face.normal));
        assert_eq!(t(occupied(&[[2, 1, 0]]), &across), Some((3.0, -DVec3::X)));
        assert_eq!(t(occupied(&[[1, 2, 0]]), &across), None);
        assert_eq!(t(occupied(&[[2, 2, 0]]), &across), Some((3.0, -DVec3::Y)));
        assert_eq!(t(occupied(&[[1, 0, 0]]), &corner), Some((2.0, -DVec3::X)));
        assert_eq!(t(occupied(&[[1, 1, 0]]), &corner), Some((2.0, -DVec3::Y)));
        assert_eq!(t(occupied(&[[1, 1, 1]]), &corner), Some((2.0, -DVec3::Z)));
        assert_eq!(t(occupied(&[[0, 1, 1]]), &corner), None);
        // Of two faces at the same t the first one visited is shown.
        assert_eq!(t(occupied(&[[2, 1, 0], [2, 2, 0]]), &across), Some((3.0, -DVec3::X)));
        // This also holds if the ray leaves the grid through an edge.
        let outward = ray([-1.0, 0.0, 0.5], [1.0, 1.0, 0.0]);
        assert_eq!(t(occupied(&[[3, 3, 0]]), &outward), Some((4.0, -DVec3::X)));
    }

    #[test]
    fn colors_run_from_white_over_green_to_red() {
        let shown = |count| count_color(count).to_array();
        assert_eq!([1, 2, 5].map(shown), [[1.0; 3], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]]);
        assert_eq!(
            [11, 17, 18, 900].map(shown),
            [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
        );
    }
}
