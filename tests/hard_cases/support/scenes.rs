//! Scenes built in code.

use glam::DVec3;
use raytracer::camera::Camera;
use raytracer::caster::{Caster, LazyCaster};
use raytracer::picture::FloatPicture;
use raytracer::render::{Request, Shot, Tracing, View, render_in_memory};
use raytracer::scene::material::{Material, Phong};
use raytracer::scene::mesh::Mesh;
use raytracer::scene::model::{Lighting, MeasureColors, MeshNormals, Screen, Shows};
use raytracer::scene::{self, Background, Light, MeshFile, Object, Scene};
use raytracer::trace::Effects;
use raytracer::world::World;
use std::ops::ControlFlow;

/// A scene of these objects in one group; they use material 0, which is white.
pub fn scene_of(mut objects: Vec<Object>, lights: Vec<Light>) -> Scene {
    let children = (0..objects.len()).collect();
    objects.push(Object::Group(children));
    let named = objects.iter().filter(|o| matches!(o, Object::Mesh { .. })).count();
    Scene {
        camera: scene::Camera::Orthographic {
            center: DVec3::Z,
            direction: -DVec3::Z,
            up: DVec3::Y,
            size: 1.0,
        },
        background: Background { color: DVec3::ZERO, ambient: DVec3::ZERO },
        lights,
        materials: vec![Material::Phong(Phong::default())],
        root: objects.len() - 1,
        objects,
        positions: Default::default(),
        meshes: vec![MeshFile { name: "mesh.obj".into(), ..MeshFile::default() }; named],
        images: vec![],
        cube_map: None,
        screen: Screen::default(),
        lighting: Lighting::default(),
        mesh_normals: MeshNormals::default(),
        measure_colors: MeasureColors::default(),
        shows: Shows::default(),
    }
}

/// The world of these objects. `meshes` are those that they use, in order.
pub fn world_with(objects: Vec<Object>, lights: Vec<Light>, meshes: &[Mesh]) -> World {
    World::new(&scene_of(objects, lights), meshes).expect("a valid scene")
}

/// The world of these objects, none of which is a mesh.
pub fn world_of(objects: Vec<Object>) -> World {
    world_with(objects, vec![], &[])
}

/// The world of a mesh alone.
pub fn world_of_mesh(mesh: &Mesh) -> World {
    world_with(vec![Object::Mesh { mesh: 0, material: 0 }], vec![], std::slice::from_ref(mesh))
}

/// The bytes of a scene's colours, with one sample at the centre of each pixel.
pub fn render_picture(
    scene: &Scene,
    meshes: &[Mesh],
    cells: Option<[usize; 3]>,
    size: [usize; 2],
    effects: Effects,
) -> Vec<u8> {
    let world = World::new(scene, meshes).expect("a sound scene");
    let caster = Caster::new(&world, cells).expect("a grid");
    layers(scene, &caster, &Request { effects, ..Request::new(size) }, Tracing::Fast).concat()
}

/// The bytes of each layer of a request. None of its colours may be a NaN.
pub fn layers(scene: &Scene, caster: &Caster, request: &Request, tracing: Tracing) -> Vec<Vec<u8>> {
    let (layers, nans) = layers_and_nans(&Camera::new(&scene.camera, request.size), caster, request, tracing);
    assert_eq!(nans, 0, "colours that are not numbers");
    layers
}

/// The bytes of each layer of a request, and the number of colours with a NaN.
pub fn layers_and_nans(
    camera: &Camera,
    caster: &Caster,
    request: &Request,
    tracing: Tracing,
) -> (Vec<Vec<u8>>, u64) {
    let caster = &LazyCaster::from(caster.clone());
    let shot = Shot { camera: *camera, caster, view: View::Scene };
    let rendered =
        render_in_memory(&shot, &Request { tracing, ..request.clone() }, &|_| ControlFlow::Continue(()));
    let (pictures, _) = rendered.expect("small pictures");
    let bytes = pictures.iter().map(FloatPicture::to_bytes);
    bytes.fold((vec![], 0), |(mut all, nans), (bytes, more)| {
        all.push(bytes);
        (all, nans + more)
    })
}
