//! Scenes whose colours can be computed by hand from the laws of optics.

use super::*;
use crate::caster::Caster;
use crate::caster::choose::Layout;
use crate::math::instructions;
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

    fn seen_by(&self, ray: &Ray, observer: &mut impl Observer) -> Color {
        let caster = Caster::new(&self.world, None).unwrap();
        Tracer::new(&caster, self.effects).color(ray, &mut RayStack::default(), observer)
    }

    /// Returns the colour along a ray from a point, and checks that counting does not change it.
    fn seen(&self, origin: [f64; 3], direction: [f64; 3]) -> Color {
        let ray = Ray::new(origin.into(), DVec3::from(direction).normalize());
        let color = self.seen_by(&ray, &mut Quiet);
        assert_eq!(self.seen_by(&ray, &mut Counts::default()), color);
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

const DOWN: [f64; 3] = [0.0, -1.0, 0.0];
const FLOOR: &str = "Material { diffuseColor 1 .5 .25 } Plane { normal 0 1 0 offset 0 }";
const FLOOR_COLOR: Color = Color::new(1.0, 0.5, 0.25);
const SUN: &str = "DirectionalLight { direction 0 -1 0 color .5 .5 .5 }";

fn with(shadows: Shadows) -> Effects {
    Effects { shadows, ..Effects::default() }
}

fn bounces(bounces: u32) -> Effects {
    Effects { bounces, ..Effects::default() }
}

#[test]
fn a_surface_shows_ambient_light_and_each_light_above_it_by_its_cosine() {
    let below = "DirectionalLight { direction 0 1 0 color 1 1 1 }";
    let slanting = "DirectionalLight { direction .6 -.8 0 color 1 1 1 }";
    let setting = Setting::new(&[SUN, below, slanting].concat(), FLOOR, Effects::default());
    assert_near(setting.seen([0.0, 1.0, 0.0], DOWN), (0.125 + 0.5 + 0.8) * FLOOR_COLOR);
    assert_eq!(setting.seen([0.0, 1.0, 0.0], [0.0, 1.0, 0.0]), BACKGROUND);
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
fn the_inside_of_a_surface_is_black_unless_back_faces_are_lit() {
    let sphere = "Material { } Sphere { center 0 0 0 radius 1 }";
    let (front, back) = (Effects::default(), Effects { shade_back: true, ..Effects::default() });
    assert_eq!(Setting::new(SUN, sphere, front).seen([0.0; 3], DOWN), Color::ZERO);
    let lit_from_within = Setting::new(SUN, sphere, back);
    assert_near(lit_from_within.seen([0.0; 3], DOWN), Color::splat(0.625));
    assert_near(lit_from_within.seen([0.0; 3], [0.0, 1.0, 0.0]), Color::splat(0.125));
    // A surface that is seen edge on counts as seen from outside.
    assert_eq!(Setting::new(SUN, sphere, front).color_of_surface(DVec3::X), Color::splat(0.125));
}

#[test]
fn an_object_before_the_light_casts_a_shadow_and_one_behind_it_casts_none() {
    let lamp = "PointLight { position 0 4 0 color 1 1 1 }";
    for (height, color) in [(2, 0.125), (6, 1.125)] {
        let ball = format!("{FLOOR} Sphere {{ center 0 {height} 0 radius .5 }}");
        let seen = |effects| Setting::new(lamp, &ball, effects).seen([1.0, 1.0, 0.0], [-1.0, -1.0, 0.0]);
        assert_near(seen(with(Shadows::Opaque)), color * FLOOR_COLOR);
        assert_near(seen(with(Shadows::Transparent)), color * FLOOR_COLOR);
        assert_near(seen(Effects::default()), 1.125 * FLOOR_COLOR);
    }
}

#[test]
fn a_transparent_object_tints_light_by_the_length_of_its_path_inside() {
    const GLASS: &str = "Material { transparentColor .5 .25 1 }";
    let glass = format!(
        "{FLOOR} {GLASS} Sphere {{ center 0 3 0 radius 1 }} Sphere {{ center 0 7 0 radius .5 }}
         Sphere {{ center 0 12 0 radius 1 }}"
    );
    let lamp = "PointLight { position 0 9 0 color 1 1 1 }";
    let tint = DVec3::new(0.5f64.powi(3), 0.25f64.powi(3), 1.0);
    let seen = |shadows| Setting::new(lamp, &glass, with(shadows)).seen([9.0, 9.0, 0.0], [-1.0, -1.0, 0.0]);
    assert_near(seen(Shadows::Transparent), (0.125 + tint) * FLOOR_COLOR);
    assert_near(seen(Shadows::Opaque), 0.125 * FLOOR_COLOR);
}

#[test]
fn as_in_the_course_a_shadow_ray_is_cast_to_a_light_behind_the_surface() {
    let below = "DirectionalLight { direction 0 1 0 color 1 1 1 }";
    let mut counts = Counts::default();
    let setting = Setting::new(&[SUN, below].concat(), FLOOR, with(Shadows::Opaque));
    setting.seen_by(&Ray::new(DVec3::Y, DVec3::NEG_Y), &mut counts);
    assert_eq!((counts.shadow_rays, counts.non_shadow_rays), (2, 0));
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
    let mut counts = Counts::default();
    Setting::new("", hall, bounces(3)).seen_by(&Ray::new(DVec3::Y, DVec3::NEG_Y), &mut counts);
    assert_eq!(counts.non_shadow_rays, 3);
}

#[test]
fn a_glass_plate_displaces_a_ray_sideways() {
    let (sine, index) = (0.6f64, 1.5f64);
    let tangent = |sine: f64| sine / (1.0 - sine * sine).sqrt();
    // The path through a plate from y = 0 down to y = -1, and down to y = -2 below it.
    let x = tangent(sine / index) + tangent(sine);
    let scene = format!(
        "Material {{ diffuseColor 0 0 0 transparentColor .5 .25 1 indexOfRefraction {index} }}
         Box {{ min -9 -1 -9 max 9 0 9 }}
         Material {{ diffuseColor 1 1 1 }} Sphere {{ center {x} -2 0 radius 1e-9 }}"
    );
    let (from, direction) = ([-0.75, 1.0, 0.0], [sine, -0.8, 0.0]);
    let through_both = DVec3::new(0.25, 0.0625, 1.0);
    assert_near(Setting::new("", &scene, bounces(2)).seen(from, direction), through_both);
    assert_near(Setting::new("", &scene, bounces(1)).seen(from, direction), Color::ZERO);
    let beside = Setting::new("", &scene, bounces(2)).seen([-0.75 + 1e-6, 1.0, 0.0], direction);
    assert_near(beside, through_both * BACKGROUND);
}

#[test]
fn a_reflected_direction_keeps_its_tangential_component() {
    let incoming = DVec3::new(0.6, -0.8, 0.0);
    for normal in [DVec3::Y, DVec3::NEG_Y] {
        assert!((reflected(incoming, normal) - DVec3::new(0.6, 0.8, 0.0)).length() < 1e-15);
    }
}

#[test]
fn snell() {
    let incoming = DVec3::new(0.6, -0.8, 0.0);
    let out = refracted(incoming, DVec3::Y, 1.0 / 1.5).unwrap();
    assert!((out.x - 0.4).abs() < 1e-15 && out.y < 0.0);
    assert!((refracted(incoming, DVec3::Y, 1.0).unwrap() - incoming).length() < 1e-15);
    assert_eq!(refracted(incoming, DVec3::Y, 2.0), None);
}

#[test]
fn the_critical_angle_is_that_of_the_direction_as_it_stands() {
    // The root is rounded down, so that the direction is flatter than 30 degrees from the surface's normal.
    let flatter = DVec3::new(0.5, -0.75f64.sqrt(), 0.0);
    assert_eq!(refracted(flatter, DVec3::Y, 2.0), None);
    let steeper = flatter.with_y(flatter.y.next_down());
    let refracted = refracted(steeper, DVec3::Y, 2.0).unwrap();
    assert!((refracted - DVec3::X).length() < 1e-7, "{refracted}");
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
    let shadows = |shadows| Effects { shadows, ..Effects::default() };
    let bounces = |bounces| Effects { bounces, shade_back: true, ..shadows(Shadows::Opaque) };
    // Two planes in one place, with the same numbers.
    let twice = |material: &str| [plane(material, floor), plane(material, floor)].concat();
    for (objects, effects, expected) in [
        (twice("diffuseColor 1 1 1"), shadows(Shadows::Opaque), lit),
        (twice("diffuseColor 1 1 1"), shadows(Shadows::Transparent), lit),
        (twice("diffuseColor 0 0 0 reflectiveColor 1 1 1"), bounces(1), BACKGROUND),
        (plane("diffuseColor 0 0 0 transparentColor 1 1 1", floor), bounces(1), BACKGROUND),
    ] {
        let setting = Setting::new(&light("0 3 0"), &objects, effects);
        assert_eq!(setting.seen([0.0, 2.0, 0.0], [0.0, -1.0, 0.0]), expected, "{objects}");
    }
    let glass = plane("transparentColor .5 .5 .5", "normal 1 0 0 offset 0");
    let objects = [plane("diffuseColor 1 1 1", "normal -1 0 0 offset -1"), glass].concat();
    let setting = Setting::new(&light("-1 0 0"), &objects, shadows(Shadows::Transparent));
    assert_eq!(setting.seen([0.5, 0.0, 0.0], [1.0, 0.0, 0.0]), lit);
}

/// The light lies on a ball of glass. The ray may hit the far side of the ball before.
#[test]
fn tinted_shadows_of_a_light_on_a_ball_follow_the_length_of_the_way_within() {
    for (transform, stretch) in [("", 1.0), ("Scale 1 1 .5", 0.5)] {
        for k in 0..400 {
            let turn = f64::from(k);
            let light = DVec3::new((1.1 * turn).sin(), (0.7 * turn).cos(), (0.31 * turn).sin()).normalize();
            let light = light * DVec3::new(1.0, 1.0, stretch);
            let target = DVec3::new(3.7 * (0.71 * turn).sin(), 3.3 * (1.3 * turn).cos(), -3.0);
            let [x, y, z] = light.to_array();
            let lights = format!("PointLight {{ position {x:?} {y:?} {z:?} color 1 1 1 }}");
            let ball = "Sphere { center 0 0 0 radius 1 }";
            let ball =
                if transform.is_empty() { ball } else { &format!("Transform {{ {transform} {ball} }}") };
            let objects = format!(
                "Material {{ diffuseColor 1 1 1 }} Plane {{ normal 0 0 1 offset -3 }}
                 Material {{ transparentColor .5 .25 .75 indexOfRefraction 1 }} {ball}"
            );
            let effects = Effects { shadows: Shadows::Transparent, ..Effects::default() };
            let setting = Setting::new(&lights, &objects, effects);
            let color = setting.seen((target + 0.5 * DVec3::Z).to_array(), [0.0, 0.0, -1.0]);
            // In the space of the unit sphere: the part of the ray from the other crossing to the light.
            let to_sphere = DVec3::new(1.0, 1.0, 1.0 / stretch);
            let (way, on) = ((light - target) * to_sphere, light * to_sphere);
            let part = (2.0 * on.dot(way) / way.length_squared()).max(0.0);
            let length = part * (light - target).length();
            let cosine = (light - target).normalize().z;
            let passed = Color::new(0.5, 0.25, 0.75).powf(length);
            let expected = Color::splat(0.125) + cosine * passed;
            assert!((color - expected).length() < 1e-9, "{transform} {light} {target}: {color} {expected}");
        }
    }
}

/// The light lies on a face, an edge or a corner of a glass box. The tint of its light on the floor depends on the
/// length of the ray within the box, and not on the faces that the ray hits by rounding.
#[test]
fn tinted_shadows_of_a_light_on_glass_follow_the_length_of_the_way_within() {
    for light in [[1.0, 0.3, 1.0], [0.2, 0.3, 1.0], [1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [0.0, -1.0, -1.0]] {
        let [x, y, z] = light;
        let text = format!(
            "OrthographicCamera {{ center 0 0 9 direction 0 0 -1 up 0 1 0 size 1 }}
             Lights {{ numLights 1 PointLight {{ position {x} {y} {z} color 1 1 1 }} }} Group {{ numObjects 2
             Material {{ diffuseColor 1 1 1 }} Plane {{ normal 0 0 1 offset -3 }}
             Material {{ transparentColor .5 .25 .75 indexOfRefraction 1 }} Box {{ min -1 -1 -1 max 1 1 1 }} }}"
        );
        let world = World::new(&parse(&text).unwrap(), &[]).unwrap();
        let caster = Caster::new(&world, None).unwrap();
        let effects = Effects { shadows: Shadows::Transparent, ..Effects::default() };
        let tracer = Tracer::new(&caster, effects);
        let (light, mut within) = (DVec3::from_array(light), 0);
        for i in 0..400 {
            let turn = f64::from(i);
            let target = DVec3::new(3.7 * (0.71 * turn).sin(), 3.3 * (1.3 * turn).cos(), -3.0);
            let ray = Ray::new(target + 0.5 * DVec3::Z, -DVec3::Z);
            let color = tracer.color(&ray, &mut RayStack::default(), &mut Quiet);
            // The part of the ray between the box's sides, from 0 at the floor to 1 at the light.
            let way = light - target;
            let [a, b] = [-1.0, 1.0].map(|side| (DVec3::splat(side) - target) / way);
            let (enters, leaves) = (a.min(b).max_element(), a.max(b).min_element().min(1.0));
            let length = (leaves - enters).max(0.0) * way.length();
            within += usize::from(length > 0.1);
            let expected = transmittance(DVec3::new(0.5, 0.25, 0.75), length) * (way.z / way.length());
            assert!((color - expected).length() < 1e-9, "{light} {target}: {color} {expected}");
        }
        assert_eq!(within > 50, light.z > 0.0, "{within}");
    }
}

/// Two boxes and a ball of glass with a reflective coating, a reflective floor, and an opaque box.
const GLASS_AND_MIRRORS: &str = "PerspectiveCamera { center 0 0 0 direction 0 0 -1 up 0 1 0 angle 30 }
     Background { color .25 .5 1 ambientLight .125 .125 .125 }
     Lights { numLights 2 DirectionalLight { direction -1 -2 -1 color .5 .5 .5 }
     PointLight { position 0 4 0 color 1 .5 .25 } }
     Materials { numMaterials 3
     Material { diffuseColor .2 .3 .4 reflectiveColor .4 .3 .2 transparentColor .9 .8 .7 indexOfRefraction 1.5 }
     Material { diffuseColor .5 .1 .2 reflectiveColor .5 .5 .5 }
     Material { diffuseColor 1 .5 .25 specularColor 1 1 1 exponent 9 } }
     Group { numObjects 5
     MaterialIndex 0 Transform { Translate -1 .5 0 XRotate 40 Box { min -.7 -.7 -.7 max .7 .7 .7 } }
     MaterialIndex 0 Transform { Translate 1 .5 0 ZRotate 25 Box { min -.7 -.7 -.7 max .7 .7 .7 } }
     MaterialIndex 0 Sphere { center 0 .4 1.5 radius .6 }
     MaterialIndex 2 Box { min -3 -1 -3 max -2 2 -2 }
     MaterialIndex 1 Plane { normal 0 1 0 offset -1 } }";

/// Returns a camera ray from around the objects. Some rays miss them. Neighbours are often close to each other.
fn camera_ray(k: usize) -> Ray {
    let [turn, height, aim] = [k / 8, k % 5, k].map(|k| k as f64);
    let origin = DVec3::new(4.0 * turn.cos(), 0.2 + 0.5 * height, 4.0 * turn.sin());
    let target = DVec3::new(1.3 * (0.37 * aim).sin(), 0.9 * (0.61 * aim).cos() + 0.4, (0.23 * aim).sin());
    Ray::new(origin, (target - origin).normalize())
}

#[test]
fn uncounted_rays_have_the_colours_of_counted_ones_with_fewer_shadow_rays() {
    let world = World::new(&parse(GLASS_AND_MIRRORS).unwrap(), &[]).unwrap();
    let effects = Effects { shadows: Shadows::Opaque, shade_back: true, bounces: 4, min_weight: 0.01 };
    for level in instructions::available() {
        let caster = Caster::with(&world, Layout::Grid([6, 5, 7]), level).unwrap();
        let tracer = Tracer::new(&caster, effects);
        let (mut stack, mut rays, mut counts) = (RayStack::default(), RayCount::default(), Counts::default());
        for ray in (0..1500).map(camera_ray) {
            let color = tracer.color(&ray, &mut stack, &mut rays);
            let expected = tracer.color(&ray, &mut stack, &mut counts);
            let bits = |color: Color| color.to_array().map(f64::to_bits);
            assert_eq!(bits(color), bits(expected), "{ray:?}");
        }
        assert!(rays.0 < counts.rays() && rays.0 > counts.non_shadow_rays);
        assert!(counts.non_shadow_rays > 4 * 1500, "{}", counts.non_shadow_rays);
    }
}
