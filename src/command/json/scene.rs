//! What a scene is made of, in numbers.

use raytracer::math::aabb::Aabb;
use raytracer::primitive::shape::Shape;
use raytracer::renderer::Renderer;
use raytracer::scene::material::{Material, Pattern, Texture};
use raytracer::scene::{Light, Object, Scene};
use serde::Serialize;

#[derive(Serialize)]
pub struct SceneSummary {
    file: String,
    lights: Lights,
    materials: Materials,
    objects: Objects,
    primitives: Primitives,
    bounds: Option<Aabb>,
}

#[derive(Serialize)]
struct Lights {
    directional: usize,
    point: usize,
}

#[derive(Serialize)]
struct Materials {
    phong: usize,
    checkerboard: usize,
    noise: usize,
    marble: usize,
    wood: usize,
}

/// The nodes of the object tree.
#[derive(Serialize)]
struct Objects {
    groups: usize,
    transforms: usize,
    spheres: usize,
    planes: usize,
    triangles: usize,
    boxes: usize,
    meshes: usize,
}

/// What the objects become in world space.
#[derive(Serialize)]
struct Primitives {
    triangles: usize,
    spheres: usize,
    ellipsoids: usize,
    planes: usize,
}

impl SceneSummary {
    pub fn of(renderer: &Renderer) -> Self {
        let (scene, world) = (&renderer.scene, renderer.world());
        let spheres = count(&world.shapes, |shape| matches!(shape, Shape::Sphere(_)));
        Self {
            file: renderer.source.path.to_string_lossy().into_owned(),
            lights: Lights {
                directional: count(&scene.lights, |light| matches!(light, Light::Directional { .. })),
                point: count(&scene.lights, |light| matches!(light, Light::Point { .. })),
            },
            materials: Materials::of(scene),
            objects: Objects::of(scene),
            primitives: Primitives {
                triangles: world.triangles.len(),
                spheres,
                ellipsoids: world.shapes.len() - spheres,
                planes: world.planes.len(),
            },
            bounds: renderer.bounds(),
        }
    }
}

impl Materials {
    fn of(scene: &Scene) -> Self {
        let textures = |is: fn(&Pattern) -> bool| {
            count(
                &scene.materials,
                |material| matches!(material, Material::Texture(Texture { pattern, .. }) if is(pattern)),
            )
        };
        Self {
            phong: count(&scene.materials, |material| {
                matches!(material, Material::Phong(_) | Material::Painted(..))
            }),
            checkerboard: textures(|pattern| matches!(pattern, Pattern::Checkerboard)),
            noise: textures(|pattern| matches!(pattern, Pattern::Noise { .. })),
            marble: textures(|pattern| matches!(pattern, Pattern::Marble { .. })),
            wood: textures(|pattern| matches!(pattern, Pattern::Wood { .. })),
        }
    }
}

impl Objects {
    fn of(scene: &Scene) -> Self {
        let of_kind = |is: fn(&Object) -> bool| count(&scene.objects, is);
        Self {
            groups: of_kind(|object| matches!(object, Object::Group(_))),
            transforms: of_kind(|object| matches!(object, Object::Transform { .. })),
            spheres: of_kind(|object| matches!(object, Object::Sphere { .. })),
            planes: of_kind(|object| matches!(object, Object::Plane { .. })),
            triangles: of_kind(|object| matches!(object, Object::Triangle { .. })),
            boxes: of_kind(|object| matches!(object, Object::Box { .. })),
            meshes: of_kind(|object| matches!(object, Object::Mesh { .. } | Object::Grid { .. })),
        }
    }
}

fn count<T>(all: &[T], is: impl Fn(&T) -> bool) -> usize {
    all.iter().filter(|one| is(one)).count()
}
