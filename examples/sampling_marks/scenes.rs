//! The scenes on which samplers are measured: those of `docs/speed-against-error.md`, and others whose light is in small
//! things, which samples are likely to miss.

use raytracer::scene::load::{Hints, LoadedScene, Readers, Source, load, load_text};
use std::error::Error;
use std::f64::consts::PI;
use std::path::Path;

/// A scene, by its name, with the flags that it is rendered with.
pub struct Case {
    pub name: &'static str,
    pub flags: &'static str,
    origin: Origin,
}

enum Origin {
    File(&'static str),
    Text(fn() -> String),
}

const fn file(name: &'static str, file: &'static str, flags: &'static str) -> Case {
    Case { name, flags, origin: Origin::File(file) }
}

const fn text(name: &'static str, text: fn() -> String, flags: &'static str) -> Case {
    Case { name, flags, origin: Origin::Text(text) }
}

/// All scenes.
pub const CASES: [Case; 28] = [
    file("checkerboard", "scene6_13_checkerboard.txt", "-shadows"),
    file("glass", "scene6_14_glass_sphere.txt", "-shadows -shade_back -bounces 5 -weight 0.01"),
    file("rabbit", "scene6_07_bunny_mesh_40k.txt", "-shadows"),
    file("mirrors", "scene6_11_mirrored_floor.txt", "-shadows -bounces 4 -weight 0.01"),
    file("marble", "scene6_15_marble_cubes.txt", ""),
    file("boxes", "scene6_10_nested_transformations.txt", "-shadows"),
    text("dots", dots, ""),
    text("needles", needles, ""),
    text("hair", hair, "-shadows"),
    text("highlights", highlights, ""),
    text("lamp in mirrors", lamp_in_mirrors, "-bounces 3"),
    text("glass balls", glass_balls, "-bounces 6 -shade_back"),
    text("horizon", horizon, ""),
    text("tiles", tiles, "-shadows"),
    text("fence", fence, "-shadows"),
    text("bubbles", bubbles, "-bounces 2"),
    text("shadows of dots", shadows_of_dots, "-shadows"),
    text("sieve", sieve, "-shadows"),
    text("lamp above a sieve", lamp_above_a_sieve, "-shadows"),
    text("comb", comb, "-shadows"),
    text("torn leaf", torn_leaf, "-shadows"),
    text("two suns", two_suns, "-shadows"),
    text("shadows in a mirror", shadows_in_a_mirror, "-shadows -bounces 2"),
    text("far away", far_away, "-shadows"),
    text("lamps behind", lamps_behind, "-bounces 4"),
    text("250 small shadows", small_shadows, "-shadows"),
    text("lamp in a mirror", lamp_in_a_mirror, "-bounces 1"),
    text("shadows of fine dots", shadows_of_fine_dots, "-shadows"),
];

impl Case {
    pub fn load(&self) -> Result<LoadedScene, Box<dyn Error>> {
        let no_mesh = |_: &_, _, _| unreachable!("these scenes name no mesh");
        let no_image = |_: &_, _| unreachable!("these scenes name no picture");
        let readers = Readers { mesh: &no_mesh, image: &no_image };
        Ok(match self.origin {
            Origin::File(name) => load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name))?,
            Origin::Text(text) => {
                load_text(Source { path: self.name.into(), text: text() }, &Hints::default(), readers)?
            }
        })
    }
}

/// A sequence of numbers in [0, 1) that is spread evenly (the additive recurrence of the plastic number).
fn spread(k: usize) -> [f64; 2] {
    [0.754_877_666_246_692_7, 0.569_840_290_998_053_2].map(|step| (0.5 + k as f64 * step).fract())
}

const ABOVE: &str = "OrthographicCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 size 4 }";
const AHEAD: &str = "PerspectiveCamera { center 0 1 6 direction 0 -0.15 -1 up 0 1 0 angle 40 }";
const SUN: &str = "Lights { numLights 1 DirectionalLight { direction .3 -.6 -1 color 1 1 1 } }";

fn scene(head: &str, materials: &[&str], objects: &[String]) -> String {
    format!(
        "{head} Materials {{ numMaterials {} {} }} Group {{ numObjects {} {} }}",
        materials.len(),
        materials.join(" "),
        objects.len(),
        objects.join(" ")
    )
}

/// A quadrilateral with these half sides around a point.
fn ribbon([x, y, z]: [f64; 3], [dx, dy]: [f64; 2], [wx, wy]: [f64; 2]) -> [String; 2] {
    let corner = |a: f64, b: f64| format!("{} {} {z}", x + a * dx + b * wx, y + a * dy + b * wy);
    let triangle = |c: [(f64, f64); 3]| {
        let [p, q, r] = c.map(|(a, b)| corner(a, b));
        format!("Triangle {{ vertex0 {p} vertex1 {q} vertex2 {r} }}")
    };
    [triangle([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0)]), triangle([(-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])]
}

/// White spheres much smaller than a pixel, on black.
fn dots() -> String {
    let sphere = |k: usize| {
        let [x, y] = spread(k).map(|part| 3.9 * part - 1.95);
        format!("MaterialIndex 0 Sphere {{ center {x} {y} 0 radius 0.006 }}")
    };
    let spheres: Vec<String> = (0..100).map(sphere).collect();
    scene(
        &format!("{ABOVE} Background {{ color 0 0 0 ambientLight 1 1 1 }}"),
        &["Material { diffuseColor 1 1 1 }"],
        &spheres,
    )
}

/// Long triangles much narrower than a pixel.
fn needles() -> String {
    let mut objects = vec![];
    for k in 0..40 {
        let ([x, y], angle) = (spread(k).map(|part| 3.0 * part - 1.5), PI * (k as f64 + 0.4) / 40.0);
        let (sin, cos) = angle.sin_cos();
        let [a, b] = [0.85, 0.0015];
        objects.push(format!(
            "MaterialIndex 0 Triangle {{ vertex0 {} {} 0 vertex1 {} {} 0 vertex2 {} {} 0 }}",
            x + a * cos + b * sin,
            y + a * sin - b * cos,
            x + a * cos - b * sin,
            y + a * sin + b * cos,
            x - a * cos,
            y - a * sin
        ));
    }
    scene(
        &format!("{ABOVE} Background {{ color 0 0 0 ambientLight 1 1 1 }}"),
        &["Material { diffuseColor 1 1 1 }"],
        &objects,
    )
}

/// Brown hairs of a third of a pixel in front of a wall that they shade.
fn hair() -> String {
    let mut objects = vec!["MaterialIndex 1 Plane { normal 0 0 1 offset -0.3 }".to_string()];
    for k in 0..150 {
        let [x, y] = spread(k).map(|part| 4.0 * part - 2.0);
        let (sin, cos) = (1.2 + 0.7 * spread(k + 7)[0]).sin_cos();
        let half = 0.01;
        let [a, b] = ribbon([x, y, 0.001 * k as f64], [0.5 * cos, 0.5 * sin], [-half * sin, half * cos]);
        objects.extend([format!("MaterialIndex 0 {a}"), b]);
    }
    let materials = ["Material { diffuseColor 0.35 0.2 0.1 }", "Material { diffuseColor 0.8 0.75 0.6 }"];
    scene(&format!("{ABOVE} {SUN} Background {{ color 0 0 0 ambientLight .2 .2 .2 }}"), &materials, &objects)
}

/// Spheres with highlights smaller than a pixel.
fn highlights() -> String {
    let sphere = |k: usize| {
        let [x, y] = spread(k).map(|part| 3.6 * part - 1.8);
        format!("MaterialIndex 0 Sphere {{ center {x} {y} {} radius 0.25 }}", -0.6 * k as f64)
    };
    let spheres: Vec<String> = (0..40).map(sphere).collect();
    let material = "Material { diffuseColor .3 .1 .1 specularColor 1 1 1 exponent 20000 }";
    scene(
        &format!("{ABOVE} {SUN} Background {{ color .1 .1 .2 ambientLight .2 .2 .2 }}"),
        &[material],
        &spheres,
    )
}

/// A small bright sphere behind the camera, seen in mirrors only.
fn lamp_in_mirrors() -> String {
    let mut objects = vec!["MaterialIndex 1 Sphere { center 1 5 9 radius 0.12 }".to_string()];
    for k in 0..9 {
        let (x, y) = ((k % 3) as f64 - 1.0, (k / 3) as f64 - 0.4);
        objects.push(format!("MaterialIndex 0 Sphere {{ center {} {y} 0 radius 0.42 }}", 1.1 * x));
    }
    objects.push("MaterialIndex 2 Plane { normal 0 1 0 offset -1 }".to_string());
    let materials = [
        "Material { diffuseColor .1 .1 .1 reflectiveColor .9 .9 .9 }",
        "Material { diffuseColor 30 30 20 }",
        "Material { diffuseColor .3 .3 .3 reflectiveColor .4 .4 .4 }",
    ];
    scene(&format!("{AHEAD} Background {{ color .05 .05 .1 ambientLight 1 1 1 }}"), &materials, &objects)
}

/// Glass in front of a chequered floor.
fn glass_balls() -> String {
    let mut objects = vec!["MaterialIndex 3 Plane { normal 0 1 0 offset -1 }".to_string()];
    for k in 0..8 {
        let [x, z] = spread(k).map(|part| 4.0 * part - 2.0);
        objects.push(format!(
            "MaterialIndex 0 Sphere {{ center {x} {} {z} radius 0.5 }}",
            0.25 * k as f64 - 0.5
        ));
    }
    let materials = [
        "Material { diffuseColor 0 0 0 transparentColor .9 .95 .9 reflectiveColor .15 .15 .15 indexOfRefraction 1.5 }",
        "Material { diffuseColor .9 .9 .9 }",
        "Material { diffuseColor .2 .1 .1 }",
        "Checkerboard { Transform { UniformScale .6 } materialIndex 1 materialIndex 2 }",
    ];
    scene(
        &format!("{AHEAD} {SUN} Background {{ color .3 .5 .8 ambientLight .3 .3 .3 }}"),
        &materials,
        &objects,
    )
}

/// A chequered plane up to the horizon.
fn horizon() -> String {
    let materials = [
        "Material { diffuseColor 1 1 1 }",
        "Material { diffuseColor 0 0 0 }",
        "Checkerboard { Transform { Translate .3 .2 .1 YRotate 17 UniformScale .7 } materialIndex 0 materialIndex 1 }",
    ];
    let plane = "MaterialIndex 2 Plane { normal 0 1 0 offset -0.5 }".to_string();
    scene(&format!("{AHEAD} Background {{ color .3 .5 .8 ambientLight 1 1 1 }}"), &materials, &[plane])
}

/// Chequered boxes with a sphere on them.
fn tiles() -> String {
    let materials = [
        "Material { diffuseColor .9 .8 .7 }",
        "Material { diffuseColor .1 .2 .4 }",
        "Checkerboard { Transform { UniformScale .15 } materialIndex 0 materialIndex 1 }",
        "Checkerboard { Transform { XRotate 20 UniformScale .05 } materialIndex 1 materialIndex 0 }",
    ];
    let objects = [
        "MaterialIndex 2 Box { min -4.01 -1 -9.03 max 4.02 -.51 2 }",
        "MaterialIndex 3 Sphere { center -.6 .3 0 radius .8 }",
        "MaterialIndex 3 Transform { Translate 1.2 0 0 YRotate 33 Box { min -.5 -.5 -.5 max .5 .9 .5 } }",
    ];
    let head = format!("{AHEAD} {SUN} Background {{ color .2 .3 .4 ambientLight .3 .3 .3 }}");
    scene(&head, &materials, &objects.map(String::from))
}

/// Thin bars, which become smaller than a pixel far away.
fn fence() -> String {
    let mut objects = vec!["MaterialIndex 1 Plane { normal 0 1 0 offset -0.5 }".to_string()];
    for k in 0..60 {
        let (x, z) = (if k % 2 == 0 { -1.0 } else { 1.3 }, 3.0 - k as f64 * 0.7);
        let [x, x2, z2] = [x, x + 0.04, z + 0.04];
        objects.push(format!("MaterialIndex 0 Box {{ min {x} -.5 {z} max {x2} .8 {z2} }}"));
    }
    let materials = ["Material { diffuseColor .9 .9 .9 }", "Material { diffuseColor .2 .4 .2 }"];
    scene(
        &format!("{AHEAD} {SUN} Background {{ color .4 .6 .9 ambientLight .3 .3 .3 }}"),
        &materials,
        &objects,
    )
}

/// Clear ellipsoids of all sizes with highlights.
fn bubbles() -> String {
    let mut objects = vec![];
    for k in 0..60 {
        let ([x, y], size) = (spread(k).map(|part| 3.6 * part - 1.8), 0.3 * 0.93f64.powi(k as i32));
        objects.push(format!(
            "MaterialIndex 0 Transform {{ Translate {x} {y} {} ZRotate {} Scale {size} {} {size} Sphere {{ center 0 0 0 radius 1 }} }}",
            -0.3 * k as f64,
            17 * k,
            0.4 * size
        ));
    }
    let material = "Material { diffuseColor .2 .2 .3 specularColor .8 .8 .8 exponent 200 reflectiveColor .3 .3 .3 transparentColor .5 .6 .6 }";
    scene(
        &format!("{ABOVE} {SUN} Background {{ color .6 .3 .2 ambientLight .3 .3 .3 }}"),
        &[material],
        &objects,
    )
}

const MIDDAY: &str = "Lights { numLights 1 DirectionalLight { direction -.15 -1 .1 color 1 1 1 } }";
const GROUND: &str = "MaterialIndex 0 Plane { normal 0 1 0 offset -1 }";
const WHITE_AND_DARK: [&str; 2] =
    ["Material { diffuseColor .95 .95 .9 }", "Material { diffuseColor .2 .1 .1 }"];
const DARK_BLUE: &str = "Background { color .1 .2 .4 ambientLight .1 .1 .1 }";

/// The ground and things that shade it.
fn shaded(head: &str, shading: impl Iterator<Item = String>) -> String {
    let objects: Vec<String> = std::iter::once(GROUND.into()).chain(shading).collect();
    scene(&format!("{AHEAD} {head}"), &WHITE_AND_DARK, &objects)
}

/// Spheres out of sight, whose shadows are smaller than a pixel.
fn floating_dots(count: usize, radius: f64) -> impl Iterator<Item = String> {
    (0..count).map(move |k| {
        let [x, z] = spread(k);
        let [x, z] = [6.4 * x - 3.2, 6.0 * z - 4.2];
        format!("MaterialIndex 1 Sphere {{ center {x} 3.7 {z} radius {radius} }}")
    })
}

fn shadows_of_dots() -> String {
    shaded(&format!("{MIDDAY} {DARK_BLUE}"), floating_dots(500, 0.017))
}

/// Bars along two axes that leave small holes.
fn bars(gap: f64) -> impl Iterator<Item = String> {
    (0..60).map(move |k| {
        let at = f64::from(k % 30) * 0.21 - 3.15;
        let end = at + 0.21 - gap;
        match k < 30 {
            true => format!("MaterialIndex 1 Box {{ min {at} 1.8 -4 max {end} 1.81 2.2 }}"),
            false => format!("MaterialIndex 1 Box {{ min -3.2 1.83 {at} max 3.2 1.84 {end} }}"),
        }
    })
}

fn sieve() -> String {
    shaded(&format!("{MIDDAY} {DARK_BLUE}"), bars(0.02))
}

fn lamp_above_a_sieve() -> String {
    let lamp = "Lights { numLights 1 PointLight { position .4 4.7 -.3 color 4 4 4 attenuation 1 0 .03 } }";
    shaded(&format!("{lamp} {DARK_BLUE}"), bars(0.025))
}

/// Thin teeth, closer to each other than pixels.
fn comb() -> String {
    let tooth = |k: i32| {
        let x = f64::from(k) * 0.029 - 3.2;
        format!("MaterialIndex 1 Box {{ min {x} 2 -3.5 max {} 2.02 1.5 }}", x + 0.003)
    };
    shaded(&format!("{MIDDAY} {DARK_BLUE}"), (0..220).map(tooth))
}

/// A surface of triangles, some of which are missing.
fn torn_leaf() -> String {
    let triangles = (0..3200).filter(|k| k * 7919 % 83 != 5).map(|k| {
        let [x, z] = [k / 2 % 40, k / 80].map(|n| n as f64 * 0.15 - 3.0);
        let [x2, z2] = [x + 0.15, z + 0.15];
        let third = if k % 2 == 0 { format!("{x2} 2.5 {z}") } else { format!("{x} 2.5 {z2}") };
        format!("MaterialIndex 1 Triangle {{ vertex0 {x} 2.5 {z} vertex1 {x2} 2.5 {z2} vertex2 {third} }}")
    });
    shaded(&format!("{MIDDAY} {DARK_BLUE}"), triangles)
}

fn two_suns() -> String {
    let suns = "Lights { numLights 2 DirectionalLight { direction .4 -1 .2 color .2 .4 .6 }
                PointLight { position -2 9 3 color .7 .5 .2 } }";
    shaded(&format!("{suns} {DARK_BLUE}"), floating_dots(300, 0.025))
}

/// Shadows of dots that are seen in a mirror only.
fn shadows_in_a_mirror() -> String {
    let mut objects: Vec<String> = vec![GROUND.into()];
    objects.extend(floating_dots(400, 0.02));
    objects.push("MaterialIndex 2 Triangle { vertex0 -9 -1 -5 vertex1 9 -1 -5 vertex2 0 19 -5.5 }".into());
    objects.push("MaterialIndex 1 Box { min -4 -1 2.4 max 4 .1 2.5 }".into());
    let mirror = "Material { diffuseColor 0 0 0 reflectiveColor .9 .9 .9 }";
    let materials = [WHITE_AND_DARK[0], WHITE_AND_DARK[1], mirror];
    scene(&format!("{AHEAD} {MIDDAY} {DARK_BLUE}"), &materials, &objects)
}

/// Dots above the ground, ten thousand times as large, turned and moved.
fn far_away() -> String {
    let head = format!(
        "PerspectiveCamera {{ center 0 10000 60000 direction 0 -.15 -1 up 0 1 0 angle 40 }} {MIDDAY} {DARK_BLUE}"
    );
    let dots = floating_dots(400, 0.02).collect::<String>();
    let group = format!(
        "Transform {{ UniformScale 10000 Translate 0 0 -.5 YRotate 25 Group {{ numObjects 401 {GROUND} {dots} }} }}"
    );
    scene(&head, &WHITE_AND_DARK, &[group])
}

/// Forty lamps behind the camera, of three sizes, seen in two mirroring spheres only.
fn lamps_behind() -> String {
    let mut objects = vec!["MaterialIndex 2 Plane { normal 0 1 0 offset 0 }".to_string()];
    for (x, y, z, radius) in [(-0.9, 1.0, 0.0, 1.0), (1.2, 0.8, 0.5, 0.8)] {
        objects.push(format!("MaterialIndex 0 Sphere {{ center {x} {y} {z} radius {radius} }}"));
    }
    for k in 0..40 {
        let ([x, y], [z, _]) = (spread(k), spread(3 * k + 1));
        let [x, y, z] = [16.0 * x - 8.0, 6.0 * y + 1.2, 5.0 * z + 9.0];
        let radius = [0.4, 0.15, 0.05][k % 3];
        objects.push(format!("MaterialIndex 1 Sphere {{ center {x} {y} {z} radius {radius} }}"));
    }
    let materials = [
        "Material { diffuseColor 0 0 0 reflectiveColor .9 .9 .9 }",
        "Material { diffuseColor 4 4 3 }",
        "Material { diffuseColor .3 .2 .1 }",
    ];
    let camera = "PerspectiveCamera { center 0 3 8 direction 0 -.35 -1 up 0 1 0 angle 36 }";
    let light = "Lights { numLights 1 DirectionalLight { direction 0 -1 -.01 color .2 .2 .2 } }";
    scene(
        &format!("{camera} {light} Background {{ color .02 .02 .05 ambientLight 1 1 1 }}"),
        &materials,
        &objects,
    )
}

fn small_shadows() -> String {
    shaded(&format!("{MIDDAY} {DARK_BLUE}"), floating_dots(250, 0.02))
}

/// A flat mirror that shows a bright sphere much smaller than a pixel.
fn lamp_in_a_mirror() -> String {
    let objects = [
        "MaterialIndex 0 Triangle { vertex0 -9 -1 -5 vertex1 9 -1 -5 vertex2 0 19 -5.5 }",
        "MaterialIndex 1 Sphere { center 1 4 12 radius 0.02 }",
        "MaterialIndex 2 Plane { normal 0 1 0 offset -1 }",
    ];
    let materials = [
        "Material { diffuseColor .1 .1 .1 reflectiveColor .9 .9 .9 }",
        "Material { diffuseColor 40 40 30 }",
        "Material { diffuseColor .3 .3 .3 }",
    ];
    scene(
        &format!("{AHEAD} Background {{ color .05 .05 .1 ambientLight 1 1 1 }}"),
        &materials,
        &objects.map(String::from),
    )
}

/// Many shadows, each much smaller than a pixel.
fn shadows_of_fine_dots() -> String {
    shaded(&format!("{MIDDAY} {DARK_BLUE}"), floating_dots(1500, 0.01))
}
