//! Textbook intersections in single precision: the triangle test of Moeller and Trumbore ("Fast, Minimum Storage
//! Ray/Triangle Intersection", JGT 2(1), 1997), the quadratic formula for spheres, and a fixed epsilon.

use crate::math::ray::{Ray, Visible};
use crate::tools::causes::hits::Hits;
use crate::world::plane::Plane;
use crate::world::shape::{Shape, UnitSphereMaps};
use crate::world::sphere::Sphere;
use crate::world::{Primitive, SurfacePoint, World};
use glam::Vec3;

/// The smallest t of a hit, so that a ray does not hit the surface that it leaves.
const EPSILON: f32 = 1e-4;

/// Tests every primitive, one by one.
pub struct SinglePrecision<'a> {
    pub world: &'a World,
}

/// A ray in single precision.
struct SingleRay {
    origin: Vec3,
    direction: Vec3,
    t_min: f32,
    t_max: f32,
}

impl SingleRay {
    fn new(ray: &Ray) -> Self {
        Self {
            origin: ray.origin.as_vec3(),
            direction: ray.direction.as_vec3(),
            // An orthographic camera also sees objects behind it, and some models have their own epsilon.
            t_min: if ray.t_min == 0.0 { EPSILON } else { ray.t_min as f32 },
            t_max: ray.t_max as f32,
        }
    }

    fn at(&self, t: f32) -> Vec3 {
        self.origin + t * self.direction
    }

    fn covers(&self, t: f32) -> bool {
        t > self.t_min && t < self.t_max
    }
}

impl SinglePrecision<'_> {
    /// Returns the t and the flat normal of the first intersection with a primitive.
    fn hit(&self, ray: &SingleRay, id: u32) -> Option<(f32, Vec3)> {
        let (t, normal) = match self.world.primitive(id) {
            Primitive::Triangle(i) => triangle(ray, self.world.corners(i).map(|corner| corner.as_vec3()))?,
            Primitive::Shape(i) => match &self.world.shapes[i] {
                Shape::Sphere(Sphere { center, radius }) => {
                    let center = center.as_vec3();
                    let t = quadratic(ray, ray.origin - center, ray.direction, *radius as f32)?;
                    (t, (ray.at(t) - center).normalize_or_zero())
                }
                shape => {
                    let UnitSphereMaps { center, inverse, .. } = shape.form().unit_sphere_maps();
                    let (center, inverse) = (center.as_vec3(), inverse.as_mat3());
                    let t = quadratic(ray, inverse * (ray.origin - center), inverse * ray.direction, 1.0)?;
                    let normal = inverse.transpose() * (inverse * (ray.at(t) - center));
                    (t, normal.normalize_or_zero())
                }
            },
            Primitive::Plane(i) => {
                let Plane { normal, offset } = &self.world.planes[i];
                let (normal, offset) = (normal.as_vec3(), *offset as f32);
                ((offset - normal.dot(ray.origin)) / normal.dot(ray.direction), normal)
            }
        };
        ray.covers(t).then_some((t, normal))
    }
}

impl Hits for SinglePrecision<'_> {
    fn world(&self) -> &World {
        self.world
    }

    fn nearest(&self, ray: &Ray, _: Option<u32>) -> Option<Visible> {
        let ray = SingleRay::new(ray);
        let hits = self.world.ids().filter_map(|id| Some((self.hit(&ray, id)?.0, id)));
        let (t, primitive) = hits.reduce(|best, other| if other.0 < best.0 { other } else { best })?;
        Some(Visible { primitive, t_bound: t.into() })
    }

    fn distance(&self, _: &Ray, Visible { t_bound: t, .. }: Visible) -> f64 {
        t
    }

    fn surface(&self, ray: &Ray, Visible { primitive, t_bound: t }: Visible) -> SurfacePoint {
        let ray = SingleRay::new(ray);
        let normal = self.hit(&ray, primitive).map_or(Vec3::ZERO, |(_, normal)| normal);
        let flat = SurfacePoint {
            position: ray.at(t as f32).as_dvec3(),
            normal: normal.as_dvec3(),
            extent: self.world.max_abs_coord,
            material: self.world.material_of(primitive),
            primitive: None,
            triangle: Some(primitive).filter(|&id| self.world.is_triangle(id)),
        };
        let smooth = self.world.smooth_normal(&flat);
        SurfacePoint { normal: smooth.map_or(flat.normal, |normal| normal.as_vec3().as_dvec3()), ..flat }
    }
}

/// Returns the t and the normal of the intersection with a triangle, wherever it lies on the ray's line.
fn triangle(ray: &SingleRay, [a, b, c]: [Vec3; 3]) -> Option<(f32, Vec3)> {
    let (e1, e2) = (b - a, c - a);
    let p = ray.direction.cross(e2);
    let determinant = e1.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let s = ray.origin - a;
    let u = s.dot(p) / determinant;
    let q = s.cross(e1);
    let v = ray.direction.dot(q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0)
        .then(|| (e2.dot(q) / determinant, e1.cross(e2).normalize_or_zero()))
}

/// Returns the first intersection with a sphere around the origin that lies on the ray.
fn quadratic(ray: &SingleRay, origin: Vec3, direction: Vec3, radius: f32) -> Option<f32> {
    let a = direction.length_squared();
    let b = 2.0 * direction.dot(origin);
    let c = origin.length_squared() - radius * radius;
    let root = (b * b - 4.0 * a * c).sqrt();
    [-root, root].map(|root| (root - b) / (2.0 * a)).into_iter().find(|&t| ray.covers(t))
}
