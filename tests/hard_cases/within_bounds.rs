//! Section F, hostile input: the largest and smallest numbers that a scene may have never lead to a NaN.

use crate::support::scenes::layers_and_nans;
use raytracer::camera::Camera;
use raytracer::caster::Caster;
use raytracer::render::{Layer, Request, Tracing};
use raytracer::scene;
use raytracer::trace::{Effects, Shadows};
use raytracer::world::World;

/// Scenes of numbers within the limits whose colours or normals would be NaN without countermeasures: a name,
/// the camera, a light, the materials, the last of which is used, and the objects.
const AT_THE_BOUNDS: [(&str, &str, &str, &str, &str); 9] = [
    (
        "a negative tint has no power that is no whole number",
        AHEAD,
        "DirectionalLight { direction 0 0 -1 color 1 1 1 }",
        "Material { transparentColor -0.5 0.5 0.5 }",
        "Sphere { center 0 0 -3 radius 1 } Sphere { center 0 0 0 radius 0.4 }",
    ),
    (
        "a bright tint's power has no end, and meets a colour of 0",
        AHEAD,
        "DirectionalLight { direction 0 0 -1 color 1 0 1 }",
        "Material { transparentColor 1e30 1e30 1e30 }",
        "Plane { normal 0 0 1 offset -99 } Sphere { center 0 0 -30 radius 15 }",
    ),
    (
        "what mirrors brighten without end meets a colour of 0",
        "PerspectiveCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 angle 10 }",
        "DirectionalLight { direction 0 0 -1 color 1 1 0 }",
        "Material { reflectiveColor 1e30 1e30 1e30 diffuseColor 1 0 1 }",
        "Plane { normal 0 0 1 offset -9 } Plane { normal 0 0 -1 offset -9 }",
    ),
    (
        "a light that hardly falls off has no end, and meets a colour of 0",
        AHEAD,
        "PointLight { position 0 0 5 color 1 1 1 attenuation 1e-320 0 0 }",
        "Material { diffuseColor 1 0 1 }",
        "Plane { normal 0 0 1 offset 0 }",
    ),
    (
        "a texture's place is no number, nor infinite",
        AHEAD,
        "DirectionalLight { direction 0 0 -1 color 1 1 1 }",
        "Material { } Material { diffuseColor 1 0 0 }
         Marble { Transform { UniformScale 1e99 UniformScale 1e99 UniformScale 1e99 UniformScale 1e10 }
         materialIndex 0 materialIndex 1 octaves 3 frequency 1e99 amplitude 1e99 }",
        "Sphere { center 0 0 0 radius 1 }",
    ),
    (
        "a highlight's base is above 1 by rounding, and its power has no end",
        "OrthographicCamera { center 1 1 1 direction -1 -1 -1 up 0 1 0 size 2 }",
        "DirectionalLight { direction -1 -1 -1 color 1 1 1 }",
        "Material { specularColor 1 0 0 exponent 1e99 }",
        "Plane { normal 1 1 1 offset 0 } Sphere { center 0 0 0 radius 1 }",
    ),
    (
        "a sphere is smaller than the rounding of its place",
        AHEAD,
        "DirectionalLight { direction 0 0 -1 color 1 1 1 }",
        "Material { }",
        "Sphere { center 0 0 1 radius 1e-60 }",
    ),
    (
        "a plane is crossed almost where no coordinate is a number any more",
        "OrthographicCamera { center 0 0 0 direction 1 64 1e-304 up 0 0 1 size 2 }",
        "PointLight { position 0 0 5 color 1 1 1 attenuation 0 1 0 }",
        "Material { transparentColor 1 1 1 reflectiveColor 1 1 1 specularColor 1 0 1 indexOfRefraction 1.5 }",
        "Plane { normal 0 0 1 offset 1.2 } Plane { normal 1 1 0 offset 1e100 } Sphere { center 0 0 0 radius 1 }",
    ),
    (
        "the products of a short up vector are 0",
        "PerspectiveCamera { center 0 0 0 direction 9 3 3 up 5e-324 0 0 angle 40 }",
        "DirectionalLight { direction 0 0 -1 color 1 1 1 }",
        "Material { }",
        "Sphere { center 0 0 0 radius 1 }",
    ),
];

const AHEAD: &str = "OrthographicCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 size 3 }";

/// The number of NaNs in a scene's pictures, and whether anything of it is visible.
fn nans_at_the_bounds(camera: &str, light: &str, materials: &str, objects: &str) -> (u64, bool) {
    let count = |text: &str, words: &[&str]| text.split_whitespace().filter(|w| words.contains(w)).count();
    let all = count(materials, &["Material", "Marble"]);
    let text = format!(
        "{camera} Background {{ color 0 0 0 ambientLight 0 0 0 }} Lights {{ numLights 1 {light} }}
         Materials {{ numMaterials {all} {materials} }}
         Group {{ numObjects {} MaterialIndex {} {objects} }}",
        count(objects, &["Sphere", "Plane"]),
        all - 1
    );
    let scene = scene::parser::parse(&text).expect("numbers within bounds");
    let world = World::new(&scene, &[]).expect("numbers within bounds");
    let caster = Caster::new(&world, None).expect("no grid");
    let effects = Effects { shadows: Shadows::Transparent, shade_back: true, bounces: 15, min_weight: 0.0 };
    let layers = vec![Layer::Normals, Layer::Color];
    let request = Request { effects, layers, ..Request::new([9, 9]) };
    let (pictures, nans) =
        layers_and_nans(&Camera::new(&scene.camera, [9, 9]), &caster, &request, Tracing::Fast);
    (nans, pictures[0].iter().any(|&byte| byte != 0))
}

#[test]
fn numbers_within_bounds_make_only_numbers() {
    let mut failed = vec![];
    for (name, camera, light, materials, objects) in AT_THE_BOUNDS {
        let (nans, is_seen) = nans_at_the_bounds(camera, light, materials, objects);
        if nans > 0 || !is_seen {
            failed.push(format!("{name}: {nans} are no numbers, and it is seen: {is_seen}"));
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}
