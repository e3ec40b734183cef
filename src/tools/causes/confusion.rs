//! Each mistake is made, alone and together with another, and must not be taken for a third. The tests print tables:
//! what was made, and what was named.

use super::finding::find_causes;
use super::paint::paint;
use super::{Cause, Finding, Original, PixelChange, RequestChange, Rule, SceneChange, SelfHitting, rules};
use crate::caster::choose::Structure;
use crate::math::ray::{Ray, Visible};
use crate::picture::Picture;
use crate::render::{Request, Tracing};
use crate::renderer::{Meshes, Renderer};
use crate::sampling::drand48::Drand48;
use crate::sampling::sampler::{Pattern, Sampler};
use crate::scene::MeshFile;
use crate::scene::error::{Problem, SceneError};
use crate::scene_io::{Source, load, load_text};
use crate::stats::{Probe, Quiet};
use crate::trace::{Departure, Effects, Rules, Shadows, Tracer};
use crate::world::{SurfacePoint, World};
use glam::{DVec2, DVec3};
use std::path::Path;

/// A little of everything, where every mistake shows.
const SCENE: &str = "
    PerspectiveCamera { center 0 2.5 8 direction 0 -.25 -1 up 0 1 0 angle 40 }
    Background { color .10980392 .3 .5 ambientLight .2 .15 .2 }
    Lights { numLights 2
        PointLight { position .5 3 2 color 2.2 2 1.8 attenuation 1 .2 0 }
        DirectionalLight { direction -1 -1 -.5 color .4 .4 .5 } }
    Materials { numMaterials 6
        Material { diffuseColor .8 .4 .2 specularColor .9 .9 .9 exponent 20 }
        Material { diffuseColor .1 .1 .2 reflectiveColor .7 .7 .7 }
        Material { diffuseColor .1 .1 .1 transparentColor .8 .9 .7 indexOfRefraction 1.5 }
        Material { diffuseColor .9 .9 .9 }
        Checkerboard { materialIndex 0 materialIndex 3 }
        Noise { materialIndex 0 materialIndex 3 octaves 3 } }
    Group { numObjects 9
        MaterialIndex 4 Plane { normal 0 1 0 offset -.2 }
        MaterialIndex 1 Sphere { center -1.2 .6 0 radius .8 }
        MaterialIndex 2 Sphere { center .8 .4 1.5 radius .6 }
        MaterialIndex 0 Transform { Translate 1.6 .8 -1 ZRotate 30 Scale 1 .4 .6 Sphere { center 0 0 0 radius 1 } }
        MaterialIndex 0 Sphere { center .6 4.5 2 radius .7 }
        MaterialIndex 3 Triangle { vertex0 -2.5 .2 1.5 vertex1 -2.5 1.2 1.5 vertex2 -1.7 .2 1.5 }
        MaterialIndex 3 Triangle { vertex0 2.2 .2 1.5 vertex1 2.2 1.2 1.5 vertex2 3 .2 1.5 }
        MaterialIndex 5 Sphere { center -.2 .3 2.6 radius .4 }
        Transform { Translate -.9 .3 2 Group { numObjects 1 MaterialIndex 0
            Transform { YRotate 30 Scale .3 .5 .3 Box { min -.5 -.5 -.5 max .5 .5 .5 } } } } }";

/// A scene of these, and the request of a picture of it.
struct Case {
    name: &'static str,
    renderer: Renderer,
    request: Request,
}

impl Case {
    fn new(name: &'static str, request: Request) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
        let loaded = if name == "everything" {
            let source = Source { path: name.into(), text: SCENE.into() };
            load_text(source, &|file: &MeshFile| Err(SceneError::new(file.at, Problem::NoNormal)))
        } else {
            load(&path)
        };
        Self { name, renderer: Renderer::new(loaded.unwrap(), Meshes::Kept).unwrap(), request }
    }

    fn original(&self) -> Original<'_> {
        Original::new(&self.renderer, Structure::Any, &self.request).unwrap()
    }
}

fn cases() -> Vec<Case> {
    let shadows = Effects { shadows: Shadows::Opaque, bounces: 2, ..Effects::default() };
    let back = Effects { shade_back: true, ..shadows };
    let tinted = Effects { shadows: Shadows::Transparent, ..back };
    let picture = |effects| Request { effects, ..Request::new([64, 48]) };
    let sampler = Sampler::new(Pattern::Jittered, 4, Drand48::UNSEEDED);
    vec![
        Case::new("everything", picture(shadows)),
        Case::new("everything", picture(back)),
        Case::new("everything", picture(Effects { min_weight: 1.3, bounces: 2, ..Effects::default() })),
        Case::new("everything", Request { sampler, ..picture(shadows) }),
        Case::new("everything", picture(tinted)),
        Case::new("scene6_03_sphere_plane.txt", picture(shadows)),
        Case::new("scene4_02_colored_shadows.txt", picture(shadows)),
        Case::new("scene6_05_bunny_mesh_1k.txt", picture(back)),
        Case::new("scene7_05_glass_sphere.txt", picture(tinted)),
        Case::new("scene6_12_faceted_gem.txt", picture(back)),
        Case::new("scene2_05_inside_sphere.txt", picture(back)),
    ]
}

/// The picture with both mistakes; none where they cannot be made together.
fn both(case: &Case, mistakes: [Cause; 2]) -> Option<Picture> {
    let (renderer, request) = (&case.renderer, &case.request);
    let mut scene = renderer.scene.clone();
    let (mut changed, mut rule, mut pixels) = (request.clone(), None, None);
    for cause in mistakes {
        match cause {
            Cause::Unchanged => {}
            Cause::Pixels(change) => pixels = Some(change),
            Cause::Request(change) => changed = change.apply(&scene, &changed)?,
            Cause::Scene(change) => scene = change.apply(&scene, &renderer.source.text)?,
            Cause::Rule(broken) if broken.applies(&scene, &changed) => rule = Some(broken),
            Cause::Rule(_) => return None,
        }
    }
    let renderer = renderer.with_scene(scene).ok()?;
    let prepared = renderer.prepare_for(Structure::Any, &changed, Tracing::Fast).ok()?;
    let colors = match rule {
        Some(_) => rules::colors(&renderer, &changed, prepared.caster(), rule).ok()?,
        None => prepared.render(&changed).ok()?.pop()?,
    };
    Some(pixels.map_or_else(|| colors.to_picture(), |change| change.apply(&colors)))
}

/// What is named, if anything is.
fn named(found: Finding) -> Option<Cause> {
    match found {
        Finding::Equal { cause, .. } | Finding::Part { cause, .. } => Some(cause),
        Finding::Speckles { .. } | Finding::Unknown { .. } => None,
    }
}

/// The mistakes that the case can show, with the picture that each makes.
fn mistakes(original: &Original, right: &Picture) -> Vec<(Cause, Picture)> {
    let made = Cause::all().filter_map(|cause| Some((cause, original.picture(cause)?)));
    made.filter(|(_, picture)| picture != right).collect()
}

#[test]
fn each_mistake_is_named_among_all_others() {
    let mut seen: Vec<Cause> = vec![];
    for case in cases() {
        let original = case.original();
        let right = original.picture(Cause::Unchanged).unwrap();
        let made = mistakes(&original, &right);
        let wrong: Vec<Picture> = made.iter().map(|(_, picture)| picture.clone()).collect();
        println!("{} {:?}", case.name, case.request.effects);
        for ((cause, picture), found) in made.iter().zip(original.explain_all(&wrong, &right)) {
            println!("  made:{cause}\n    {found}");
            let name = named(found).unwrap_or_else(|| panic!("{cause:?}: {found}"));
            let is_same = made.iter().any(|(other, same)| *other == name && same == picture);
            assert!(name == *cause || is_same, "{cause:?}: {found}");
            seen.push(*cause);
        }
    }
    let missing: Vec<Cause> =
        Cause::all().filter(|&cause| cause != Cause::Unchanged && !seen.contains(&cause)).collect();
    // Nothing is so near to anything else in these scenes.
    let small = [0.0001, 0.001].map(|distance| Cause::Rule(Rule::Epsilon { distance }));
    assert_eq!(missing, small);
}

/// Whether one is so much like the other that it may be named where the other is not known.
fn are_alike(one: Cause, other: Cause) -> bool {
    let pairs = [
        (Cause::Scene(SceneChange::NoHighlights), Cause::Rule(Rule::HighlightsByReflection)),
        (Cause::Scene(SceneChange::NoAmbient), Cause::Request(RequestChange::NoShadeBack)),
        (Cause::Request(RequestChange::AngleNotHalved), Cause::Request(RequestChange::AngleOfShorterSide)),
        (Cause::Request(RequestChange::NoShadows), Cause::Rule(Rule::Epsilon { distance: 0.3 })),
        (Cause::Rule(Rule::RaysClamped), Cause::Rule(Rule::SamplesClamped)),
        (Cause::Request(RequestChange::Shadows), Cause::Request(RequestChange::TransparentShadows)),
        (Cause::Pixels(PixelChange::OneLevelBrighter), Cause::Pixels(PixelChange::RoundedUp)),
        (
            Cause::Rule(Rule::NoEpsilon { rays: SelfHitting::Secondary }),
            Cause::Rule(Rule::ReflectionFromBelow),
        ),
    ];
    pairs.iter().any(|&(a, b)| (a.is_akin(one) && b.is_akin(other)) || (a.is_akin(other) && b.is_akin(one)))
}

/// Each mistake stands here for one of those that nobody has thought of.
#[test]
fn a_mistake_that_is_not_known_is_not_taken_for_another() {
    for case in cases() {
        let original = case.original();
        let right = original.picture(Cause::Unchanged).unwrap();
        let made = mistakes(&original, &right);
        println!("{} {:?}", case.name, case.request.effects);
        for (cause, picture) in &made {
            let others = made.iter().filter(|(other, same)| !other.is_akin(*cause) && same != picture);
            let picture_of = |asked: Cause| match asked {
                Cause::Unchanged => Some(right.clone()),
                _ => made.iter().find(|(other, _)| *other == asked).map(|(_, picture)| picture.clone()),
            };
            let others = others.map(|(other, _)| *other);
            let found = find_causes(others, picture_of, std::slice::from_ref(picture), &right)[0];
            println!("  made:{cause}\n    {found}");
            let is_right = named(found).is_none_or(|name| are_alike(name, *cause));
            assert!(is_right, "{cause:?}: {found}");
        }
    }
}

fn kind(cause: Cause) -> u8 {
    match cause {
        Cause::Unchanged => 0,
        Cause::Pixels(_) => 1,
        Cause::Request(_) => 2,
        Cause::Scene(_) => 3,
        Cause::Rule(_) => 4,
    }
}

#[test]
fn of_two_mistakes_one_is_named() {
    let [mut right_ones, mut unknown] = [0; 2];
    for case in cases().into_iter().take(2) {
        let original = case.original();
        let right = original.picture(Cause::Unchanged).unwrap();
        let made = mistakes(&original, &right);
        let causes: Vec<Cause> = made.iter().map(|(cause, _)| *cause).collect();
        let pairs = causes.iter().flat_map(|&one| causes.iter().map(move |&other| (one, other)));
        let pairs: Vec<[Cause; 2]> =
            pairs.filter(|&(one, other)| kind(one) < kind(other)).map(|(one, other)| [one, other]).collect();
        let chosen = pairs.iter().step_by(pairs.len() / PAIRS).take(PAIRS);
        let both: Vec<_> = chosen.filter_map(|&pair| Some((pair, both(&case, pair)?))).collect();
        let wrong: Vec<Picture> = both.iter().map(|(_, picture)| picture.clone()).collect();
        for (([one, other], picture), found) in both.iter().zip(original.explain_all(&wrong, &right)) {
            println!("  made:{one} and{other}\n    {found}");
            match named(found) {
                None => unknown += 1,
                Some(name) => {
                    let is_one = name.is_akin(*one) || name.is_akin(*other);
                    // Both together may make what a third makes.
                    let is_same = made.iter().any(|(cause, same)| *cause == name && same == picture);
                    assert!(is_one || is_same, "{one:?} {other:?}: {found}");
                    right_ones += 1;
                }
            }
        }
    }
    println!("{right_ones} named, {unknown} unknown");
    assert!(right_ones > unknown, "{right_ones} named, {unknown} unknown");
}

/// Combinations of two mistakes for each scene.
const PAIRS: usize = 30;

/// The right rules, but for rays that start on either side of the surface that they leave, as they do by the roundings
/// of a tracer without an epsilon.
struct Rounded<'a, R> {
    right: &'a R,
    rays: SelfHitting,
    /// How many of the rays start on the wrong side.
    density: f64,
}

impl<R: Rules> Rules for Rounded<'_, R> {
    fn world(&self) -> &World {
        self.right.world()
    }

    fn nearest<P: Probe>(&self, ray: &Ray, leaves: Option<u32>, probe: &mut P) -> Option<Visible> {
        self.right.nearest(ray, leaves, probe)
    }

    fn departing(&self, why: Departure, surface: &SurfacePoint, direction: DVec3) -> (Ray, Option<u32>) {
        let bits = (surface.position + 0.37 * direction).to_array().map(f64::to_bits);
        let hash = bits
            .iter()
            .fold(0_u64, |hash, bits| (hash ^ bits).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29));
        let random = (hash.wrapping_mul(0xd134_2543_de82_ef95) >> 11) as f64 / (1_u64 << 53) as f64;
        if why == Departure::Onwards || !self.rays.includes(why) || random >= self.density {
            return self.right.departing(why, surface, direction);
        }
        let side = -surface.normal.dot(direction).signum();
        (Ray::new(surface.position + 1e-7 * side * surface.normal, direction), None)
    }
}

#[test]
fn speckles_are_known_at_any_density() {
    let shadows = Effects { shadows: Shadows::Opaque, ..Effects::default() };
    let mirrors = Effects { bounces: 2, ..Effects::default() };
    let picture = |effects| Request { effects, ..Request::new([96, 96]) };
    let rows = [
        ("scene6_03_sphere_plane.txt", shadows, SelfHitting::Shadow),
        ("scene4_02_colored_shadows.txt", shadows, SelfHitting::Shadow),
        ("scene6_11_mirrored_floor.txt", mirrors, SelfHitting::Secondary),
        ("scene7_05_glass_sphere.txt", Effects { shade_back: true, ..mirrors }, SelfHitting::Secondary),
        ("scene6_11_mirrored_floor.txt", Effects { bounces: 2, ..shadows }, SelfHitting::All),
    ];
    for (name, effects, rays) in rows {
        let case = Case::new(name, picture(effects));
        let original = case.original();
        let right = original.picture(Cause::Unchanged).unwrap();
        let prepared = &original.prepared;
        // Of glass few pixels are away from edges.
        let least = if name.contains("glass") { 0.1 } else { 0.02 };
        for density in [least, 0.1, 0.3, 0.5, 0.7, 0.8, 0.95, 1.0] {
            let rules = Rounded { right: prepared.caster(), rays, density };
            let tracer = Tracer { rules: &rules, effects };
            let camera = case.renderer.camera(&case.request);
            let color = |ray: &Ray| tracer.color(ray, &mut Quiet);
            let wrong = paint(&camera, &case.request, DVec2::ZERO, &color).unwrap().to_picture();
            let found = original.explain(&wrong, &right);
            println!("{name} {rays:?} {density}: {found}");
            let is_known = match found {
                Finding::Speckles { .. } => true,
                _ => matches!(named(found), Some(Cause::Rule(Rule::NoEpsilon { .. }))),
            };
            assert!(is_known, "{name} {rays:?} {density}: {found}");
        }
    }
}
