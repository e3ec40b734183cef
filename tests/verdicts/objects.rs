//! The objects of a scene in single precision, and their intersection with rays.

use super::mistake::Mistake::*;
use super::mistake::Mistakes;
use glam::{Affine3A, Vec3};
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
                let start = usize::from(self.mistakes.has(FirstObjectMissing)).min(children.len());
                let missing = usize::from(self.mistakes.has(LastObjectMissing));
                let end = children.len().saturating_sub(missing);
                children[start..end].iter().for_each(|&child| self.place(scene, meshes, child, to_world));
                return;
            }
            Object::Transform { matrix, child, .. } => {
                let own = matrix.map.as_affine3a();
                let outer = to_world.filter(|_| !self.mistakes.has(OnlyInnermostTransform));
                return self.place(scene, meshes, *child, Some(outer.map_or(own, |outer| outer * own)));
            }
            &Object::Sphere { center, radius, material } => {
                let factor = if self.mistakes.has(RadiusLarger) { 1.01 } else { 1.0 };
                (Shape::Sphere { center: center.as_vec3(), radius: factor * radius as f32 }, material)
            }
            &Object::Plane { normal, offset, material } => {
                (Shape::Plane { normal: normal.as_vec3().normalize(), offset: offset as f32 }, material)
            }
            &Object::Triangle { vertices, material } => {
                (Shape::Triangles(vec![vertices.map(|vertex| vertex.as_vec3())]), material)
            }
            &Object::Box { min, max, material } => {
                (Shape::Triangles(triangles_of_box(min.as_vec3(), max.as_vec3())), material)
            }
            Object::Grid { surface, material } => (self.mesh(surface), *material),
            &Object::Mesh { mesh, material } => (self.mesh(&meshes[mesh]), material),
        };
        let material = match scene.materials.len() {
            _ if self.mistakes.has(MaterialsAllFirst) => 0,
            count if self.mistakes.has(MaterialsOffByOne) => (material + 1) % count,
            _ => material,
        };
        let to_shape = to_world.map(|to_world| to_world.inverse());
        self.primitives.push(Primitive { shape, material, to_shape });
    }

    fn mesh(&self, mesh: &Mesh) -> Shape {
        let missing = usize::from(self.mistakes.has(LastTriangleMissing));
        let count = mesh.triangles.len().saturating_sub(missing);
        let vertex = |index: u32| mesh.vertices[index as usize].as_vec3();
        Shape::Triangles(mesh.triangles[..count].iter().map(|corners| corners.map(vertex)).collect())
    }

    /// Returns the nearest hit with t between `t_min` and `t_max`.
    pub fn nearest(&self, ray: &Ray, t_min: f32, t_max: f32) -> Option<Hit> {
        let mut nearest: Option<Hit> = None;
        for Primitive { shape, material, to_shape } in &self.primitives {
            let limit = nearest.filter(|_| !self.mistakes.has(LastHitWins)).map_or(t_max, |hit| hit.t);
            let hit = match to_shape {
                Some(map) => self.transformed(shape, map, ray, [t_min, limit]),
                None => self.intersect(shape, ray, [t_min, limit]),
            };
            if let Some((t, normal)) = hit {
                nearest = Some(Hit { t, normal, material: *material });
            }
        }
        nearest
    }

    /// Intersects a ray with a transformed shape. The ray's direction is not normalised, so t is the same in both
    /// spaces.
    fn transformed(
        &self,
        shape: &Shape,
        to_shape: &Affine3A,
        ray: &Ray,
        range: [f32; 2],
    ) -> Option<(f32, Vec3)> {
        let origin = to_shape.transform_point3(ray.origin);
        let mut direction = to_shape.transform_vector3(ray.direction);
        if self.mistakes.has(DistanceNotRescaled) {
            direction = direction.normalize();
        }
        let (t, normal) = self.intersect(shape, &Ray { origin, direction }, range)?;
        let normal = to_shape.matrix3.transpose() * normal;
        Some((t, if self.mistakes.has(NormalsNotNormalised) { normal } else { normal.normalize() }))
    }

    /// Returns the nearest t of a shape within the range, and the normal.
    fn intersect(&self, shape: &Shape, ray: &Ray, range: [f32; 2]) -> Option<(f32, Vec3)> {
        match shape {
            Shape::Sphere { center, radius } => {
                let t = self.sphere(*center, *radius, ray, range)?;
                let normal = ray.at(t) - center;
                Some((t, if self.mistakes.has(NormalsNotNormalised) { normal } else { normal / *radius }))
            }
            Shape::Plane { normal, offset } => {
                let t = (offset - normal.dot(ray.origin)) / normal.dot(ray.direction);
                is_within(t, range).then_some((t, *normal))
            }
            Shape::Triangles(triangles) => {
                let [t_min, mut t_max] = range;
                let mut nearest = None;
                for triangle in triangles {
                    let Some(t) = self.triangle(triangle, ray, [t_min, t_max]) else { continue };
                    nearest = Some((t, triangle));
                    t_max = if self.mistakes.has(LastHitWins) { t_max } else { t };
                }
                nearest.map(|(t, triangle)| (t, self.triangle_normal(triangle)))
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

    fn triangle_normal(&self, &[a, b, c]: &Triangle) -> Vec3 {
        let normal = (b - a).cross(c - a);
        let normal = if self.mistakes.has(TrianglesReversed) { -normal } else { normal };
        if self.mistakes.has(TriangleNormalsNotNormalised) { normal } else { normal.normalize() }
    }
}

fn is_within(t: f32, [t_min, t_max]: [f32; 2]) -> bool {
    t > t_min && t < t_max
}

/// Returns two triangles for each face.
fn triangles_of_box(min: Vec3, max: Vec3) -> Vec<Triangle> {
    let corner = |bits: usize| {
        let [x, y, z] = [0, 1, 2].map(|axis| bits >> axis & 1 == 1);
        Vec3::select(glam::BVec3::new(x, y, z), max, min)
    };
    // The corners of each face, counter-clockwise seen from outside. Bit 0 of a corner's number is its side along x.
    let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let halves = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    halves.map(|half| half.map(corner)).collect()
}
