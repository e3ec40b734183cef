//! Scenes whose colours can be computed by hand from the laws of optics.

use super::*;
use crate::caster::Caster;
use crate::scene::parser::parse;
use crate::stats::Counts;
use crate::trace::Quiet;
use glam::DVec3;

/// The background colour in the text of [`Setting::new`].
const BACKGROUND: Color = Color::new(0.25, 0.5, 1.0);

/// A world with the effects that are modelled in it.
struct Setting {
    world: World,
    effects: Effects,
}

impl Setting {
    fn new(lights: &str, objects: &str, effects: Effects) -> Self {
        let count: usize = ["Sphere", "Plane", "Box"].map(|word| objects.matches(word).count()).iter().sum();
        let lights_count = lights.matches("Light ").count();
        let text = format!(
            "PerspectiveCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 angle 30 }}
             Background {{ color .25 .5 1 ambientLight .125 .125 .125 }}
             Lights {{ numLights {lights_count} {lights} }}
             Group {{ numObjects {count} {objects} }}"
        );
        let world = World::new(&parse(&text).unwrap(), &[]).unwrap();
        Self { world, effects }
    }

    /// Returns the colour along a ray from a point, and checks that counting does not change it.
    fn seen(&self, origin: [f64; 3], direction: [f64; 3]) -> Color {
        let ray = Ray::new(origin.into(), DVec3::from(direction).normalize());
        let caster = Caster::new(&self.world, None).unwrap();
        let (tracer, stack) = (Tracer::new(&caster, self.effects), &mut RayStack::default());
        let color = tracer.color(&ray, stack, &mut Quiet);
        assert_eq!(tracer.color(&ray, stack, &mut Counts::default()), color);
        color
    }

    /// Returns the colour of a surface with this normal for a ray along the negative z axis.
    fn color_of_surface(&self, normal: DVec3) -> Color {
        let caster = Caster::new(&self.world, None).unwrap();
        let surface = SurfacePoint {
            position: DVec3::ZERO,
            normal,
            extent: 0.0,
            material: 0,
            primitive: None,
            triangle: None,
        };
        let ray = Ray::new(DVec3::Z, DVec3::NEG_Z);
        let (tracer, stack, mut color) =
            (Tracer::new(&caster, self.effects), &mut RayStack::default(), Color::ZERO);
        let surface = Some(&surface);
        dispatch!(caster.level, simd => tracer.set_color(simd, &mut color, &ray, surface, stack, &mut Quiet));
        color
    }
}

fn assert_near(color: Color, expected: Color) {
    assert!((color - expected).abs().max_element() <= 1e-13, "{color} instead of {expected}");
}

const FLOOR_COLOR: Color = Color::new(1.0, 0.5, 0.25);
const SUN: &str = "DirectionalLight { direction 0 -1 0 color .5 .5 .5 }";

fn with(shadows: Shadows) -> Effects {
    Effects { shadows, ..Effects::default() }
}

fn bounces(bounces: u32) -> Effects {
    Effects { bounces, ..Effects::default() }
}

#[test]
fn a_light_in_the_plane_of_a_surface_leaves_no_highlight_on_it() {
    let material = "Material { diffuseColor 0 0 0 specularColor 1 1 1 } Sphere { center 9 9 9 radius 1 }";
    let beside = "DirectionalLight { direction -1 0 0 color 1 1 1 }";
    assert_eq!(Setting::new(beside, material, Effects::default()).color_of_surface(DVec3::Z), Color::ZERO);
    let slanting = "DirectionalLight { direction -1 0 -.001 color 1 1 1 }";
    assert!(Setting::new(slanting, material, Effects::default()).color_of_surface(DVec3::Z).x > 0.7);
}

#[test]
fn a_surface_that_is_seen_edge_on_counts_as_seen_from_outside() {
    let sphere = "Material { } Sphere { center 0 0 0 radius 1 }";
    let setting = Setting::new(SUN, sphere, Effects::default());
    assert_eq!(setting.color_of_surface(DVec3::X), Color::splat(0.125));
}

#[test]
fn mirrors_reflect_as_often_as_there_are_bounces_and_the_weight_allows() {
    // A floor and a ceiling; each bounce is multiplied by the mirrors before it.
    let hall = "Material { diffuseColor 1 0 0 reflectiveColor .5 0 0 } Plane { normal 0 1 0 offset 0 }
                Material { diffuseColor 1 0 0 reflectiveColor .25 0 0 } Plane { normal 0 -1 0 offset -4 }";
    let red = |effects| {
        let color = Setting::new("", hall, effects).seen([0.0, 1.0, 0.0], [1.0, -1.0, 0.0]);
        assert_eq!((color.y, color.z), (0.0, 0.0));
        color.x
    };
    let sums = [1.0, 1.5, 1.625, 1.6875];
    for (n, sum) in sums.into_iter().enumerate() {
        assert_eq!(red(bounces(n as u32)), sum);
    }
    for (min_weight, sum) in [(0.5, 1.0), (0.49, 1.5), (0.125, 1.5), (0.124, 1.625), (0.0624, 1.6875)] {
        assert_eq!(red(Effects { min_weight, ..bounces(3) }), sum, "{min_weight}");
    }
}

#[test]
fn light_parallel_to_a_surface_continues_straight_on() {
    let scene = "Material { diffuseColor 0 0 0 transparentColor 1 1 1 indexOfRefraction 1.5 }
                 Sphere { center 9 9 9 radius 1 }
                 Material { diffuseColor 1 .5 .25 } Sphere { center 0 0 -5 radius .1 }";
    assert_near(Setting::new("", scene, bounces(1)).color_of_surface(DVec3::X), FLOOR_COLOR);
}

/// Near the critical angle, the normal component is small compared with the terms that it is computed from.
#[test]
fn the_normal_component_is_accurate_near_the_critical_angle() {
    for (ratio, rest) in [(1.0_f64 + 3e-7, 1e-7_f64), (1.0 + 5e-6, 3e-7), (1.1, 1e-7), (2.0, 1e-7)] {
        // 1 - ratio^2 sine^2 = rest.
        let cosine = (((ratio - 1.0) * (ratio + 1.0) + rest) / (ratio * ratio)).sqrt();
        let sine = ((1.0 - cosine) * (1.0 + cosine)).sqrt();
        let refracted = refracted(DVec3::new(sine, -cosine, 0.0), DVec3::Y, ratio).unwrap();
        // The rounding error of the cosine or sine itself, times ratio^2, is unavoidable.
        let error_bound = 8.0 * f64::EPSILON * if ratio < 1.5 { (ratio - 1.0) + rest } else { 1.0 };
        let inward = refracted.y * refracted.y;
        assert!((inward - rest).abs() <= error_bound, "{ratio}: {inward} {rest}");
    }
}

/// These rays start on a surface at the origin. The coordinates there are zero, so their roundings move no ray.
#[test]
fn rays_leave_a_surface_at_the_origin() {
    let light = |position: &str| format!("PointLight {{ position {position} color 1 1 1 }}");
    let plane = |material: &str, plane: &str| format!("Material {{ {material} }} Plane {{ {plane} }}");
    let (floor, lit) = ("normal 0 1 0 offset 0", Color::splat(1.125));
    let bounces = |bounces| Effects { bounces, shade_back: true, ..with(Shadows::Opaque) };
    // Two planes in one place, with the same numbers.
    let twice = |material: &str| [plane(material, floor), plane(material, floor)].concat();
    for (objects, effects, expected) in [
        (twice("diffuseColor 1 1 1"), with(Shadows::Opaque), lit),
        (twice("diffuseColor 1 1 1"), with(Shadows::Transparent), lit),
        (twice("diffuseColor 0 0 0 reflectiveColor 1 1 1"), bounces(1), BACKGROUND),
        (plane("diffuseColor 0 0 0 transparentColor 1 1 1", floor), bounces(1), BACKGROUND),
    ] {
        let setting = Setting::new(&light("0 3 0"), &objects, effects);
        assert_eq!(setting.seen([0.0, 2.0, 0.0], [0.0, -1.0, 0.0]), expected, "{objects}");
    }
    let glass = plane("transparentColor .5 .5 .5", "normal 1 0 0 offset 0");
    let objects = [plane("diffuseColor 1 1 1", "normal -1 0 0 offset -1"), glass].concat();
    let setting = Setting::new(&light("-1 0 0"), &objects, with(Shadows::Transparent));
    assert_eq!(setting.seen([0.5, 0.0, 0.0], [1.0, 0.0, 0.0]), lit);
}

/// Returns a light over a floor at z = -3, with a solid of glass.
fn over_glass(light: DVec3, solid: &str) -> Setting {
    let [x, y, z] = light.to_array();
    let lights = format!("PointLight {{ position {x:?} {y:?} {z:?} color 1 1 1 }}");
    let objects = format!(
        "Material {{ diffuseColor 1 1 1 }} Plane {{ normal 0 0 1 offset -3 }}
         Material {{ transparentColor .5 .25 .75 indexOfRefraction 1 }} {solid}"
    );
    Setting::new(&lights, &objects, with(Shadows::Transparent))
}

/// Returns a point on the floor.
fn target(k: u32) -> DVec3 {
    let turn = f64::from(k);
    DVec3::new(3.7 * (0.71 * turn).sin(), 3.3 * (1.3 * turn).cos(), -3.0)
}

/// Asserts that the light at a point on the floor has passed through this length of glass.
fn assert_tinted(setting: &Setting, light: DVec3, target: DVec3, length: f64) {
    let color = setting.seen((target + 0.5 * DVec3::Z).to_array(), [0.0, 0.0, -1.0]);
    let passed = Color::new(0.5, 0.25, 0.75).powf(length);
    let expected = Color::splat(0.125) + (light - target).normalize().z * passed;
    assert!((color - expected).length() < 1e-9, "{light} {target}: {color} {expected}");
}

/// The light lies on a ball of glass. The ray may hit the far side of the ball before.
#[test]
fn tinted_shadows_of_a_light_on_a_ball_follow_the_length_of_the_way_within() {
    const BALL: &str = "Sphere { center 0 0 0 radius 1 }";
    for (solid, stretch) in [(BALL.to_owned(), 1.0), (format!("Transform {{ Scale 1 1 .5 {BALL} }}"), 0.5)] {
        for k in 0..400 {
            let turn = f64::from(k);
            let light = DVec3::new((1.1 * turn).sin(), (0.7 * turn).cos(), (0.31 * turn).sin()).normalize();
            let (light, target) = (light * DVec3::new(1.0, 1.0, stretch), target(k));
            // In the space of the unit sphere: the part of the ray from the other crossing to the light.
            let to_sphere = DVec3::new(1.0, 1.0, 1.0 / stretch);
            let (way, on) = ((light - target) * to_sphere, light * to_sphere);
            let part = (2.0 * on.dot(way) / way.length_squared()).max(0.0);
            assert_tinted(&over_glass(light, &solid), light, target, part * (light - target).length());
        }
    }
}

/// The light lies on a face, an edge or a corner of a glass box. The tint of its light on the floor depends on the
/// length of the ray within the box, and not on the faces that the ray hits by rounding.
#[test]
fn tinted_shadows_of_a_light_on_glass_follow_the_length_of_the_way_within() {
    for light in [[1.0, 0.3, 1.0], [0.2, 0.3, 1.0], [1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [0.0, -1.0, -1.0]] {
        let (setting, light, mut within) =
            (over_glass(light.into(), "Box { min -1 -1 -1 max 1 1 1 }"), DVec3::from_array(light), 0);
        for target in (0..400).map(target) {
            // The part of the ray between the box's sides, from 0 at the floor to 1 at the light.
            let way = light - target;
            let [a, b] = [-1.0, 1.0].map(|side| (DVec3::splat(side) - target) / way);
            let (enters, leaves) = (a.min(b).max_element(), a.max(b).min_element().min(1.0));
            let length = (leaves - enters).max(0.0) * way.length();
            within += usize::from(length > 0.1);
            assert_tinted(&setting, light, target, length);
        }
        assert_eq!(within > 50, light.z > 0.0, "{within}");
    }
}
