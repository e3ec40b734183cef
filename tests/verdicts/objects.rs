//! The objects of a scene in single precision, and their intersection with rays.

use super::mistake::Mistake::*;
use super::mistake::Mistakes;
use glam::{Affine3A, DVec3, Vec3};
use raytracer::scene::mesh::Mesh;
use raytracer::scene::{Object, ObjectId, Scene};

#[derive(Clone, Copy, Debug)]
pub struct Ray {
    pub origin: Vec3,
    pub direction: Vec3,
}

impl Ray {
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + t * self.direction
    }
}

/// A hit of a ray, with the surface's outward normal.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    pub t: f32,
    pub normal: Vec3,
    pub material: usize,
}

type Triangle = [Vec3; 3];

enum Shape {
    Sphere { center: Vec3, radius: f32 },
    Plane { normal: Vec3, offset: f32 },
    Triangles(Vec<Triangle>),
}

struct Primitive {
    shape: Shape,
    material: usize,
    /// The map from world space to the space of the shape, unless these are the same.
    to_shape: Option<Affine3A>,
}

/// The objects of a scene, in its order.
pub struct Objects {
    primitives: Vec<Primitive>,
    mistakes: Mistakes,
}

impl Objects {
    pub fn new(scene: &Scene, meshes: &[Mesh], mistakes: Mistakes) -> Self {
        let mut objects = Self { primitives: vec![], mistakes };
        objects.place(scene, meshes, scene.root, None);
        objects
    }

    /// Adds the primitives of an object. `to_world` is the product of the transforms around it.
    fn place(&mut self, scene: &Scene, meshes: &[Mesh], id: ObjectId, to_world: Option<Affine3A>) {
        let (shape, material) = match &scene.objects[id] {
            Object::Group(children) => {
                let first = usize::from(self.mistakes.has(FirstObjectMissing));
                let last = children.len().saturating_sub(usize::from(self.mistakes.has(LastObjectMissing)));
                let placed = children.iter().take(last).skip(first);
                return placed.for_each(|&id| self.place(scene, meshes, id, to_world));
            }
            Object::Transform { matrix, child, .. } => {
                let own = matrix.map.as_affine3a();
                let outer = to_world.filter(|_| !self.mistakes.has(OnlyInnermostTransform));
                return self.place(scene, meshes, *child, Some(outer.map_or(own, |outer| outer * own)));
            }
            &Object::Sphere { center, radius, material } => {
                let radius = self.mistakes.pick(radius, [(RadiusLarger, 1.01 * radius)]) as f32;
                (Shape::Sphere { center: center.as_vec3(), radius }, material)
            }
            &Object::Plane { normal, offset, material } => {
                (Shape::Plane { normal: normal.as_vec3().normalize(), offset: offset as f32 }, material)
            }
            &Object::Triangle { vertices, material } => {
                (Shape::Triangles(vec![vertices.map(|vertex| vertex.as_vec3())]), material)
            }
            &Object::Box { min, max, material } => (Shape::Triangles(triangles_of_box([min, max])), material),
            Object::Grid { surface, material } => (self.mesh(surface), *material),
            &Object::Mesh { mesh, material } => (self.mesh(&meshes[mesh]), material),
        };
        let next = (material + 1) % scene.materials.len();
        let material = self.mistakes.pick(material, [(MaterialsAllFirst, 0), (MaterialsOffByOne, next)]);
        self.primitives.push(Primitive { shape, material, to_shape: to_world.map(|map| map.inverse()) });
    }

    fn mesh(&self, mesh: &Mesh) -> Shape {
        let missing = usize::from(self.mistakes.has(LastTriangleMissing));
        let triangles = mesh.triangles.iter().take(mesh.triangles.len().saturating_sub(missing));
        let vertex = |index: u32| mesh.vertices[index as usize].as_vec3();
        Shape::Triangles(triangles.map(|corners| corners.map(vertex)).collect())
    }

    /// Returns the nearest hit with t between `t_min` and `t_max`.
    pub fn nearest(&self, ray: &Ray, t_min: f32, t_max: f32) -> Option<Hit> {
        let (mut nearest, mut limit) = (None, t_max);
        for &Primitive { ref shape, material, ref to_shape } in &self.primitives {
            let hit = match to_shape {
                Some(map) => self.transformed(shape, map, ray, [t_min, limit]),
                None => self.intersect(shape, ray, [t_min, limit]),
            };
            if let Some((t, normal)) = hit {
                nearest = Some(Hit { t, normal, material });
                limit = self.mistakes.pick(t, [(LastHitWins, t_max)]);
            }
        }
        nearest
    }

    /// Intersects a ray with a transformed shape. The direction is not normalised, so t is the same in both spaces.
    fn transformed(&self, shape: &Shape, map: &Affine3A, ray: &Ray, range: [f32; 2]) -> Option<(f32, Vec3)> {
        let origin = map.transform_point3(ray.origin);
        let direction = map.transform_vector3(ray.direction);
        let direction = self.mistakes.pick(direction, [(DistanceNotRescaled, direction.normalize())]);
        let (t, normal) = self.intersect(shape, &Ray { origin, direction }, range)?;
        let normal = map.matrix3.transpose() * normal;
        Some((t, self.mistakes.pick(normal.normalize(), [(NormalsNotNormalised, normal)])))
    }

    /// Returns the nearest t of a shape within the range, and the normal.
    fn intersect(&self, shape: &Shape, ray: &Ray, range: [f32; 2]) -> Option<(f32, Vec3)> {
        match shape {
            Shape::Sphere { center, radius } => {
                let t = self.sphere(*center, *radius, ray, range)?;
                let normal = ray.at(t) - center;
                Some((t, self.mistakes.pick(normal / *radius, [(NormalsNotNormalised, normal)])))
            }
            Shape::Plane { normal, offset } => {
                let t = (offset - normal.dot(ray.origin)) / normal.dot(ray.direction);
                is_within(t, range).then_some((t, *normal))
            }
            Shape::Triangles(triangles) => {
                let (mut nearest, mut limit) = (None, range[1]);
                for triangle in triangles {
                    if let Some(t) = self.triangle(triangle, ray, [range[0], limit]) {
                        nearest = Some((t, triangle));
                        limit = self.mistakes.pick(t, [(LastHitWins, range[1])]);
                    }
                }
                let (t, &[a, b, c]) = nearest?;
                let cross = (b - a).cross(c - a);
                let cross = self.mistakes.pick(cross, [(TrianglesReversed, -cross)]);
                Some((t, self.mistakes.pick(cross.normalize(), [(TriangleNormalsNotNormalised, cross)])))
            }
        }
    }

    /// Solves the quadratic equation.
    fn sphere(&self, center: Vec3, radius: f32, ray: &Ray, range: [f32; 2]) -> Option<f32> {
        let from_center = ray.origin - center;
        let a = ray.direction.length_squared();
        let b = 2.0 * ray.direction.dot(from_center);
        let c = from_center.length_squared() - radius * radius;
        // Without a solution the root is NaN.
        let root = (b * b - 4.0 * a * c).sqrt();
        let [near, far] = [-root, root].map(|root| (-b + root) / (2.0 * a));
        let is_near = near > range[0] && !self.mistakes.has(FarHitOfSpheres);
        Some(if is_near { near } else { far }).filter(|&t| is_within(t, range))
    }

    /// Intersects a triangle by the algorithm of Möller and Trumbore.
    fn triangle(&self, &[a, b, c]: &Triangle, ray: &Ray, range: [f32; 2]) -> Option<f32> {
        let [ab, ac, from_a] = [b - a, c - a, ray.origin - a];
        let across = ray.direction.cross(ac);
        let determinant = ab.dot(across);
        if self.mistakes.has(BackFacesCulled) && determinant < 0.0 {
            return None;
        }
        let u = from_a.dot(across) / determinant;
        let along = from_a.cross(ab);
        let v = ray.direction.dot(along) / determinant;
        let t = ac.dot(along) / determinant;
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && is_within(t, range)).then_some(t)
    }
}

fn is_within(t: f32, [t_min, t_max]: [f32; 2]) -> bool {
    t > t_min && t < t_max
}

/// Returns two triangles for each face, counter-clockwise seen from outside.
fn triangles_of_box(ends: [DVec3; 2]) -> Vec<Triangle> {
    // Bit k of a corner's number is its end along axis k.
    let corner = |n: usize| DVec3::new(ends[n & 1].x, ends[n >> 1 & 1].y, ends[n >> 2].z).as_vec3();
    let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let halves = faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    halves.map(|half| half.map(corner)).collect()
}
