//! Scenes built in code.

use glam::DVec3;
use raytracer::scene::material::{Material, Phong};
use raytracer::scene::mesh::{Mesh, parse_obj};
use raytracer::scene::{Background, Camera, Light, MeshFile, Object, Position, Scene};
use raytracer::world::World;

/// A scene of these objects in one group; they use material 0, which is white.
pub fn scene_of(mut objects: Vec<Object>, lights: Vec<Light>) -> Scene {
    let children = (0..objects.len()).collect();
    objects.push(Object::Group(children));
    let named = objects.iter().filter(|o| matches!(o, Object::Mesh { .. })).count();
    Scene {
        camera: Camera::Orthographic { center: DVec3::Z, direction: -DVec3::Z, up: DVec3::Y, size: 1.0 },
        background: Background { color: DVec3::ZERO, ambient: DVec3::ZERO },
        lights,
        materials: vec![Material::Phong(Phong::default())],
        root: objects.len() - 1,
        objects,
        meshes: vec![MeshFile { name: "mesh.obj".into(), at: Position { line: 1, column: 1 } }; named],
    }
}

/// The world of these objects, which are no meshes.
pub fn world_of(objects: Vec<Object>) -> World {
    World::new(&scene_of(objects, vec![]), &[]).expect("a sound scene")
}

/// One of the meshes in the folder `scenes`.
pub fn mesh(name: &str) -> Mesh {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
    parse_obj(&std::fs::read(path).expect("the mesh")).expect("a sound mesh")
}
