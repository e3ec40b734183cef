//! Scenes built in code.

use glam::DVec3;
use raytracer::camera::Camera;
use raytracer::grid::Caster;
use raytracer::mode::Mode;
use raytracer::picture::FloatPicture;
use raytracer::render::{Request, View, render_in_memory};
use raytracer::scene::material::{Material, Phong};
use raytracer::scene::mesh::{Mesh, parse_obj};
use raytracer::scene::{self, Background, Light, MeshFile, Object, Position, Scene};
use raytracer::stats::Quiet;
use raytracer::trace::Effects;
use raytracer::world::World;

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

/// The unit icosahedron, each triangle divided into four so many times and pushed out to the sphere.
pub fn icosphere(divisions: u32) -> Mesh {
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let mut vertices: Vec<DVec3> = [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)]
        .into_iter()
        .flat_map(|(a, b)| [DVec3::new(a, b, 0.0), DVec3::new(0.0, a, b), DVec3::new(b, 0.0, a)])
        .map(DVec3::normalize)
        .collect();
    let mut triangles = faces_of_hull(&vertices);
    for _ in 0..divisions {
        triangles = triangles.iter().flat_map(|&t| divided(t, &mut vertices)).collect();
    }
    Mesh { vertices, triangles }
}

/// The outward triples of vertices that are nearest to each other.
fn faces_of_hull(vertices: &[DVec3]) -> Vec<[u32; 3]> {
    let edge = vertices[1..].iter().map(|v| v.distance(vertices[0])).fold(f64::INFINITY, f64::min);
    let near = |i: u32, j: u32| vertices[i as usize].distance(vertices[j as usize]) < 1.01 * edge;
    let n = vertices.len() as u32;
    let triples = (0..n).flat_map(|i| (i + 1..n).flat_map(move |j| (j + 1..n).map(move |k| [i, j, k])));
    let faces = triples.filter(|&[i, j, k]| near(i, j) && near(j, k) && near(k, i));
    faces
        .map(|[i, j, k]| {
            let [a, b, c] = [i, j, k].map(|v| vertices[v as usize]);
            if (b - a).cross(c - a).dot(a) > 0.0 { [i, j, k] } else { [i, k, j] }
        })
        .collect()
}

fn divided([i, j, k]: [u32; 3], vertices: &mut Vec<DVec3>) -> [[u32; 3]; 4] {
    let mut middle = |a: u32, b: u32| {
        vertices.push((vertices[a as usize] + vertices[b as usize]).normalize());
        vertices.len() as u32 - 1
    };
    let (ij, jk, ki) = (middle(i, j), middle(j, k), middle(k, i));
    [[i, ij, ki], [j, jk, ij], [k, ki, jk], [ij, jk, ki]]
}

/// The bytes of a scene's colour picture, one centred sample a pixel.
pub fn render_picture(
    scene: &Scene,
    meshes: &[Mesh],
    cells: Option<[usize; 3]>,
    size: [usize; 2],
    effects: Effects,
) -> Vec<u8> {
    let world = World::new(scene, meshes).expect("a sound scene");
    let caster = Caster::new(&world, cells).expect("a grid");
    layers(scene, &caster, &Request { effects, ..Request::new(size) }).concat()
}

/// The bytes of each layer of a request. None of its colours may be a NaN.
pub fn layers<M: Mode>(scene: &Scene, caster: &Caster<M>, request: &Request) -> Vec<Vec<u8>> {
    let (layers, nans) = layers_and_nans(&Camera::new(&scene.camera, request.size), caster, request);
    assert_eq!(nans, 0, "colours that are not numbers");
    layers
}

/// The bytes of each layer of a request, and how many of their colours are not numbers.
pub fn layers_and_nans<M: Mode>(
    camera: &Camera,
    caster: &Caster<M>,
    request: &Request,
) -> (Vec<Vec<u8>>, u64) {
    let rendered = render_in_memory::<_, Quiet>(camera, caster, View::Scene, request);
    let (pictures, Quiet) = rendered.expect("small pictures");
    let bytes = pictures.iter().map(FloatPicture::to_bytes);
    bytes.fold((vec![], 0), |(mut all, nans), (bytes, more)| {
        all.push(bytes);
        (all, nans + more)
    })
}
