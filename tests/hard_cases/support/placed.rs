//! Objects under lists of transformations with an exact inverse, as they are written in a scene's text.

use super::rng::Rng;
use glam::{DAffine3, DVec3};
use raytracer::scene::mesh::Mesh;
use raytracer::scene::parser::parse;
use raytracer::scene::{Object, Scene};
use raytracer::world::World;

/// Some transformations as a scene's text names them.
#[derive(Clone, Debug, Default)]
pub struct Transformations(Vec<[String; 2]>);

impl Transformations {
    /// A few of any kind. Scales are powers of two, so that their inverses are exact, and differ by axis if
    /// `may_distort`.
    pub fn any(rng: &mut Rng, most: usize, may_distort: bool) -> Self {
        let vector = |name: &str, v: DVec3| format!("{name} {} {} {}", v.x, v.y, v.z);
        let count = rng.below(most + 1);
        let one = |_| match rng.below(if may_distort { 4 } else { 3 }) {
            0 => {
                let axis = ["X", "Y", "Z"][rng.below(3)];
                let angle = [rng.range(-180.0, 180.0), 10.0 * rng.integer(36)][rng.below(2)];
                [angle, -angle].map(|angle| format!("{axis}Rotate {angle}"))
            }
            1 => {
                let v = 10f64.powf(rng.range(-1.0, 3.0)) * rng.in_cube();
                [vector("Translate", v), vector("Translate", -v)]
            }
            2 => {
                let scale = 2f64.powi(rng.below(21) as i32 - 10);
                [scale, 1.0 / scale].map(|scale| format!("UniformScale {scale}"))
            }
            _ => {
                let mut power = || 2f64.powi(rng.below(7) as i32 - 3);
                let scale = DVec3::new(power(), power(), power());
                [vector("Scale", scale), vector("Scale", 1.0 / scale)]
            }
        };
        Self((0..count).map(one).collect())
    }

    /// The same map, after the way there, around a full turn in three steps, and back. The exact product is the same, and
    /// the roundings of far away stay.
    pub fn after_detour(self, rng: &mut Rng) -> Self {
        let v = 10f64.powf(rng.range(0.0, 3.0)) * rng.in_cube();
        let axis = ["X", "Y", "Z"][rng.below(3)];
        let (one, other) = (rng.integer(360), rng.integer(360));
        let there = [v, -v].map(|v| format!("Translate {} {} {}", v.x, v.y, v.z));
        let turn = |angle: f64| [angle, -angle].map(|angle| format!("{axis}Rotate {angle}"));
        let back = [there[1].clone(), there[0].clone()];
        let detour = [there, turn(one), turn(other), turn(360.0 - one - other), back];
        Self(detour.into_iter().chain(self.0).collect())
    }

    /// The text of the list.
    pub fn text(&self) -> String {
        self.0.iter().map(|[one, _]| format!("{one} ")).collect()
    }

    /// The text of the inverse.
    pub fn inverse(&self) -> String {
        self.0.iter().rev().map(|[_, inverse]| format!("{inverse} ")).collect()
    }

    /// An object under them: under one transform, or each under one of its own.
    pub fn around(&self, object: &str, is_nested: bool) -> String {
        match (self.0.is_empty(), is_nested) {
            (true, _) => object.to_string(),
            (_, false) => format!("Transform {{ {} {object} }}", self.text()),
            (_, true) => {
                let nest = |object: String, [one, _]: &[String; 2]| format!("Transform {{ {one} {object} }}");
                self.0.iter().rev().fold(object.to_string(), nest)
            }
        }
    }

    /// The map, as it is rounded.
    pub fn map(&self) -> DAffine3 {
        let object = format!("Transform {{ {} Sphere {{ center 0 0 0 radius 1 }} }}", self.text());
        let scene = scene_of(&[object], "");
        let maps = scene.objects.iter().find_map(|object| match object {
            Object::Transform { matrix, .. } => Some(matrix.map),
            _ => None,
        });
        maps.expect("a transform")
    }
}

/// A scene of these objects, each of which has the material of its index.
pub fn scene_of(objects: &[String], texture: &str) -> Scene {
    let materials = "Material { } ".repeat(objects.len().max(2));
    let textured = usize::from(!texture.is_empty());
    let list: String = objects
        .iter()
        .enumerate()
        .map(|(i, object)| {
            format!("MaterialIndex {} {object} ", if textured == 1 { objects.len().max(2) } else { i })
        })
        .collect();
    let text = format!(
        "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
         Materials {{ numMaterials {} {materials} {texture} }} Group {{ numObjects {} {list} }}",
        objects.len().max(2) + textured,
        objects.len()
    );
    parse(&text).unwrap_or_else(|error| panic!("{error:?} in {text}"))
}

/// The world of a scene, whose meshes are all this one.
pub fn world_of(scene: &Scene, mesh: &Mesh) -> World {
    let meshes = vec![mesh.clone(); scene.meshes.len()];
    World::new(scene, &meshes).expect("a sound scene")
}

/// A square of this half width in the plane at `height` above the xz plane, seen from above, in so many strips.
pub fn square(half: f64, height: f64, strips: usize) -> Mesh {
    let x = |k: usize| half * (2.0 * k as f64 / strips as f64 - 1.0);
    let ends = |k: usize| [-half, half].map(|z| DVec3::new(x(k), height, z));
    let vertices = (0..=strips).flat_map(ends).collect();
    let faces = |k: u32| [[2 * k, 2 * k + 1, 2 * k + 3], [2 * k, 2 * k + 3, 2 * k + 2]];
    Mesh { vertices, triangles: (0..strips as u32).flat_map(faces).collect() }
}
