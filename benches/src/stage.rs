//! The rabbit's scene with any of the meshes, and the rays that are cast into it.

use crate::contestant::{Contestant, FlatRay};
use glam::{DVec2, DVec3};
use raytracer::camera::Camera;
use raytracer::math::aabb::Aabb;
use raytracer::math::ray::Ray;
use raytracer::math::robust::unit;
use raytracer::scene::load;
use raytracer::scene::mesh::Mesh;
use raytracer::scene::{Light, Object, Scene};
use raytracer::world::plane::Plane;
use std::error::Error;
use std::f64::consts::TAU;
use std::path::Path;

/// The side of the picture in pixels.
const SIDE: usize = 1000;
/// The number of random rays.
const INCOHERENT: usize = 1_000_000;
/// The distance of a shadow ray's origin from the surface. The rabbit is 0.15 high.
const OFFSET: f64 = 1e-4;

/// The scene without its mesh.
pub struct Stage {
    /// A scene of the mesh alone, so that all contestants cast into the same triangles.
    pub scene: Scene,
    ground: Plane,
    /// The unit vectors towards the lights.
    lights: Vec<DVec3>,
}

/// The rays of one mesh.
pub struct Rays {
    /// The rays through every pixel, row by row.
    pub camera: Vec<FlatRay>,
    /// Shadow rays from the visible points, including those of the ground, towards each light in turn.
    pub shadow: Vec<FlatRay>,
    /// Rays from random points of a box twice as large as the mesh's, in random directions.
    pub incoherent: Vec<FlatRay>,
}

impl Stage {
    /// From the scene of 40,000 faces.
    pub fn load(scenes: &Path) -> Result<Self, Box<dyn Error>> {
        let path = scenes.join("scene6_07_bunny_mesh_40k.txt");
        let mut scene = load::load(&path).map_err(|error| error.to_string())?.scene;
        let ground = scene.objects.iter().find_map(|object| match *object {
            Object::Plane { normal, offset, .. } => Some(Plane { normal: unit(normal), offset }),
            _ => None,
        });
        let lights = scene.lights.iter().filter_map(|light| match *light {
            Light::Directional { direction, .. } => Some(-unit(direction)),
            Light::Point { .. } => None,
        });
        let lights = lights.collect();
        scene.root = scene
            .objects
            .iter()
            .position(|object| matches!(object, Object::Mesh { .. }))
            .ok_or("the scene has no mesh")?;
        Ok(Self { scene, ground: ground.ok_or("the scene has no plane")?, lights })
    }

    /// The rays for a mesh. `caster` finds the visible points.
    pub fn rays(&self, mesh: &Mesh, caster: &dyn Contestant) -> Rays {
        let camera = Camera::new(&self.scene.camera, [SIDE, SIDE]);
        let pixels = (0..SIDE * SIDE).map(|i| DVec2::new((i % SIDE) as f64, (i / SIDE) as f64));
        let camera: Vec<_> = pixels.map(|pixel| FlatRay::new(&camera.ray(pixel, DVec2::ZERO))).collect();
        let seen = caster.distances(&camera);
        let points: Vec<_> = camera.iter().zip(&seen).filter_map(|(ray, &t)| self.seen(ray, t)).collect();
        let shadow = self.lights.iter().flat_map(|&light| {
            points.iter().map(move |&point| FlatRay::new(&Ray::new(point + OFFSET * light, light)))
        });
        Rays { shadow: shadow.collect(), camera, incoherent: incoherent(mesh) }
    }

    /// The visible point along a camera ray: on the mesh at `t`, or on the ground in front of it.
    fn seen(&self, ray: &FlatRay, t: f64) -> Option<DVec3> {
        let ray = ray.exact();
        let t = self.ground.intersect(&ray).map_or(t, |ground| ground.min(t));
        (t < f64::INFINITY).then(|| ray.at(t))
    }
}

fn incoherent(mesh: &Mesh) -> Vec<FlatRay> {
    let bounds = Aabb::around(mesh.vertices.iter().copied());
    let (middle, extent) = (0.5 * (bounds.min + bounds.max), bounds.extent());
    let mut numbers = SplitMix(6837);
    let mut ray = || {
        let place = DVec3::new(numbers.next(), numbers.next(), numbers.next());
        let (z, angle) = (2.0 * numbers.next() - 1.0, TAU * numbers.next());
        let radius = (1.0 - z * z).sqrt();
        let direction = DVec3::new(radius * angle.cos(), radius * angle.sin(), z);
        FlatRay::new(&Ray::new(middle + (2.0 * place - 1.0) * extent, direction))
    };
    (0..INCOHERENT).map(|_| ray()).collect()
}

/// The random number generator of Steele, Lea and Flood ("Fast Splittable Pseudorandom Number Generators",
/// OOPSLA 2014).
struct SplitMix(u64);

impl SplitMix {
    /// Uniform in [0, 1).
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) >> 11) as f64 * 0.5f64.powi(53)
    }
}
