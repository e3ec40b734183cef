//! The scenes in `scenes/` and, if `COURSE_DIR` is set, those of the course; also scaled and translated.

use super::is_whole;
use super::meshes::bunny;
use super::scenes::world_of_mesh;
use glam::{DAffine3, DVec3};
use raytracer::caster::Caster;
use raytracer::render::{Layer, Request, Tracing};
use raytracer::scene::load::load;
use raytracer::scene::material::Material;
use raytracer::scene::mesh::Mesh;
use raytracer::scene::parser::parse;
use raytracer::scene::{Camera, Light, Object, Position, Scene};
use raytracer::trace::{Effects, Shadows};
use raytracer::world::World;
use std::path::{Path, PathBuf};
use std::sync::Arc;

#[derive(Clone)]
pub struct Named {
    pub name: String,
    pub scene: Scene,
    pub meshes: Vec<Mesh>,
    /// The size of its pictures. The sides are primes, and smaller if a ray may have to test many faces.
    pub size: [usize; 2],
}

impl Named {
    fn new(name: String, scene: Scene, meshes: Vec<Mesh>) -> Self {
        let faces: usize = meshes.iter().map(|mesh| mesh.triangles.len()).sum();
        Self { name, scene, meshes, size: if faces > 20_000 { [17, 13] } else { [43, 37] } }
    }

    pub fn world(&self) -> World {
        World::new(&self.scene, &self.meshes).unwrap_or_else(|e| panic!("{}: {e:?}", self.name))
    }
}

/// A scene with all primitives, all textures, both kinds of light, mirrors and glass.
const MIXED: &str = "
    PerspectiveCamera { center 0.3 1.5 6 direction -0.05 -0.2 -1 up 0 1 0 angle 40 }
    Lights { numLights 2
        DirectionalLight { direction -0.4 -1 -0.3 color 0.7 0.7 0.6 }
        PointLight { position 2 3 3 color 2 2 2.5 attenuation 0.2 0.1 0.05 } }
    Background { color 0.1 0.2 0.4 ambientLight 0.1 0.1 0.1 }
    Materials { numMaterials 8
        Material { diffuseColor 0.8 0.3 0.2 specularColor 1 1 1 exponent 20 }
        Material { diffuseColor 0.1 0.1 0.1 reflectiveColor 0.8 0.8 0.8 }
        Material { diffuseColor 0.1 0.1 0.1 transparentColor 0.9 0.8 0.9 indexOfRefraction 1.4 }
        Material { diffuseColor 0.2 0.5 0.9 }
        Checkerboard { Transform { Scale 1.7 1.7 1.7 } materialIndex 0 materialIndex 3 }
        Noise { Transform { YRotate 30 Scale 4 4 4 } materialIndex 0 materialIndex 1 octaves 4 }
        Marble { materialIndex 3 materialIndex 0 octaves 3 frequency 5 amplitude 4 }
        Wood { Transform { ZRotate 20 } materialIndex 0 materialIndex 3 octaves 2 frequency 9 amplitude 1 } }
    Group { numObjects 8
        MaterialIndex 4 Plane { normal 0.02 1 0.01 offset -1 }
        MaterialIndex 6 TriangleMesh { obj_file bunny_1k.obj }
        MaterialIndex 5 Transform { Translate 0.2 0.1 0 Scale 8 8 8 TriangleMesh { obj_file bunny_1k.obj } }
        MaterialIndex 2 Sphere { center -1.2 0 1.5 radius 0.7 }
        MaterialIndex 1 Transform { Translate 1.7 0.3 0 ZRotate 33 Scale 0.4 0.9 0.6 Sphere { center 0 0 0 radius 1 } }
        MaterialIndex 7 Transform { Translate -2 0 -1 XRotate 15 YRotate 40 Box { min -0.6 -0.6 -0.6 max 0.6 0.9 0.6 } }
        MaterialIndex 3 Triangle { vertex0 -4 -1 -3 vertex1 4 -1 -3 vertex2 0 5 -4 }
        MaterialIndex 0 Sphere { center 1.2 -0.6 2.2 radius 0.35 } }";

/// All available scenes, or one of four in a sample, the first of which has all primitives and textures.
pub fn scenes() -> Vec<Named> {
    let mut all = every_own_scene();
    if let Some(course) = std::env::var_os("COURSE_DIR") {
        all.extend(in_folder(&PathBuf::from(course).join("scenes")));
    }
    all.into_iter().step_by(if is_whole() { 1 } else { 4 }).collect()
}

/// The scenes of this project, or one of four in a sample.
pub fn own_scenes() -> Vec<Named> {
    every_own_scene().into_iter().step_by(if is_whole() { 1 } else { 4 }).collect()
}

fn every_own_scene() -> Vec<Named> {
    let mixed = parse(MIXED).unwrap_or_else(|e| panic!("{e:?}"));
    let meshes = mixed.meshes.iter().map(|_| bunny("1k")).collect();
    let mut all = vec![Named::new("mixed".into(), mixed, meshes)];
    all.extend(in_folder(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")));
    all
}

fn in_folder(folder: &Path) -> Vec<Named> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut paths: Vec<_> = entries.map(|entry| entry.expect("a readable folder").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "txt"));
    paths.sort();
    let named = |path: &PathBuf| {
        let loaded = load(path).unwrap_or_else(|e| panic!("{e}"));
        Named::new(path.display().to_string(), loaded.scene, loaded.meshes)
    };
    paths.iter().map(named).collect()
}

/// The bytes of small pictures of colours, depths and normals. The scene was scaled by 2^`power`.
///
/// Shadows are opaque, because the filtering of transparent ones depends on absolute lengths: light passes
/// through more glass in a larger scene, which is rightly darker.
pub fn render(named: &Named, world: &World, cells: Option<[usize; 3]>, power: i32) -> Vec<u8> {
    let caster = Caster::new(world, cells).unwrap_or_else(|e| panic!("{}: {e}", named.name));
    render_with(named, &caster, Tracing::Fast, power)
}

/// The same, traced in any way. Where it is counted every camera ray is cast, where otherwise triangles may be rasterized
/// instead.
pub fn render_with(named: &Named, caster: &Caster, tracing: Tracing, power: i32) -> Vec<u8> {
    let [near, far] = [2.0, 30.0].map(|t| t * 2f64.powi(power));
    let effects = Effects { shadows: Shadows::Opaque, shade_back: true, bounces: 3, min_weight: 0.01 };
    let layers = vec![Layer::Color, Layer::Depth { near, far }, Layer::Normals];
    let request = Request { effects, layers, ..Request::new(named.size) };
    super::scenes::layers(&named.scene, caster, &request, tracing).concat()
}

/// The scene scaled by 2^power, which is exact.
pub fn scaled(named: &Named, power: i32) -> Named {
    let f = 2f64.powi(power);
    let mut large = named.clone();
    let scene = &mut large.scene;
    match &mut scene.camera {
        Camera::Perspective { center, .. } => *center *= f,
        Camera::Orthographic { center, size, .. } => (*center, *size) = (*center * f, *size * f),
    }
    for light in &mut scene.lights {
        if let Light::Point { position, attenuation: [_, linear, square], .. } = light {
            *position *= f;
            *linear /= f;
            *square = *square / f / f;
        }
    }
    for material in &mut scene.materials {
        if let Material::Texture(texture) = material {
            // The inverse scale, so that the texture is scaled with the world.
            texture.world_to_texture.map.matrix3 *= 1.0 / f;
            texture.world_to_texture.error.matrix3 *= 1.0 / f;
        }
    }
    for object in &mut scene.objects {
        match object {
            Object::Group(_) | Object::Mesh { .. } => {}
            Object::Transform { matrix, .. } => {
                matrix.map.translation *= f;
                matrix.error.translation *= f;
            }
            Object::Sphere { center, radius, .. } => (*center, *radius) = (*center * f, *radius * f),
            Object::Plane { offset, .. } => *offset *= f,
            Object::Triangle { vertices, .. } => vertices.iter_mut().for_each(|v| *v *= f),
            Object::Box { min, max, .. } => (*min, *max) = (*min * f, *max * f),
            Object::Grid { surface, .. } => {
                Arc::make_mut(surface).vertices.iter_mut().for_each(|v| *v *= f);
            }
        }
    }
    large.meshes.iter_mut().flat_map(|mesh| &mut mesh.vertices).for_each(|v| *v *= f);
    large
}

/// The scene translated, which rounds its coordinates.
pub fn translated(named: &Named, shift: DVec3) -> Named {
    let mut moved = named.clone();
    let scene = &mut moved.scene;
    match &mut scene.camera {
        Camera::Perspective { center, .. } | Camera::Orthographic { center, .. } => *center += shift,
    }
    for light in &mut scene.lights {
        if let Light::Point { position, .. } = light {
            *position += shift;
        }
    }
    for material in &mut scene.materials {
        if let Material::Texture(texture) = material {
            texture.world_to_texture = texture.world_to_texture * DAffine3::from_translation(-shift).into();
        }
    }
    let (matrix, at) = (DAffine3::from_translation(shift).into(), Position { line: 1, column: 1 });
    scene.objects.push(Object::Transform { matrix, factors: Box::default(), child: scene.root, at });
    scene.root = scene.objects.len() - 1;
    moved
}

/// A world of the scene's triangles alone, rounded to multiples of 2^-30 of their extent and then translated
/// by `shift`, with that extent. None if there are no triangles.
pub fn moved_world(named: &Named, shift: DVec3) -> Option<(World, f64)> {
    let world = named.world();
    let points = || world.triangles.iter().flatten().map(|&v| world.vertices[v as usize]);
    let largest = points().map(|v| v.abs().max_element()).fold(0.0, f64::max);
    if largest == 0.0 {
        return None;
    }
    let unit = 2f64.powi(largest.log2().ceil() as i32 + 1);
    let grid = unit * 0.5f64.powi(30);
    let vertices = world.vertices.iter().map(|&v| (v / grid).round() * grid + shift).collect();
    Some((world_of_mesh(&Mesh { vertices, triangles: world.triangles.clone() }), unit))
}
