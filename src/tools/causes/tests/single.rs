//! A student's tracer in single precision, with an epsilon: without a mistake, with each mistake, and with two.

use super::Case;
use crate::picture::{CHANNELS, Picture};
use crate::render::renderer::Renderer;
use crate::render::{Layer, Request};
use crate::sampling::drand48::Drand48;
use crate::sampling::sampler::{Pattern, Sampler};
use crate::tools::causes::mistakes::Mistake;
use crate::tools::causes::search::{Made, Search};
use crate::tools::causes::student::{ObjectSpaces, Student, colors};
use crate::tools::causes::{Changed, Finding, Original, finished};
use crate::tools::error_report::SinglePrecision;
use crate::trace::{Effects, Shadows};
use std::borrow::Cow;
use std::rc::Rc;

/// The side of pictures with mistakes.
const SIDE: usize = 40;

fn cases(side: usize) -> Vec<Case> {
    let plain = Effects::default();
    let shadows = Effects { shadows: Shadows::Opaque, ..plain };
    let mirrors = Effects { bounces: 2, ..shadows };
    let glass = Effects { shade_back: true, bounces: 3, ..shadows };
    let tinted = Effects { shadows: Shadows::Transparent, ..glass };
    let picture = |effects| Request { effects, ..Request::new([side; 2]) };
    let sampler = Sampler::new(Pattern::Uniform, 4, Drand48::UNSEEDED);
    vec![
        Case::new("everything", picture(mirrors)),
        Case::new("everything", picture(tinted)),
        Case::new("everything", Request { sampler, ..picture(shadows) }),
        Case::new("scene2_03_colored_lights.txt", picture(plain)),
        Case::new("scene2_05_inside_sphere.txt", picture(Effects { shade_back: true, ..plain })),
        Case::new("scene2_13_rotated_squashed_sphere.txt", picture(plain)),
        Case::new("scene2_14_axes_cube.txt", picture(plain)),
        Case::new("scene3_09_exponent_variations.txt", picture(plain)),
        Case::new("scene4_02_colored_shadows.txt", picture(shadows)),
        Case::new("scene4_04_reflective_sphere.txt", picture(mirrors)),
        Case::new("scene4_09_transparent_sphere_2.0.txt", picture(glass)),
        Case::new("scene4_13_point_light_circle_d2_attenuation.txt", picture(shadows)),
        Case::new("scene6_02_sphere_triangles.txt", picture(shadows)),
        Case::new("scene6_04_bunny_mesh_200.txt", picture(shadows)),
        Case::new("scene6_11_mirrored_floor.txt", picture(mirrors)),
        Case::new("scene7_02_checkerboard.txt", picture(shadows)),
        Case::new(
            "scene2_13_rotated_squashed_sphere.txt",
            Request { layers: vec![Layer::Normals], ..picture(plain) },
        ),
    ]
}

/// Renders with these mistakes in single precision. `None` if the scene cannot show one of them.
fn picture(case: &Case, mistakes: &[Mistake]) -> Option<Picture> {
    let changed = Changed::new(&case.renderer, &case.request, mistakes)?;
    let renderer: &Renderer = changed.renderer.as_ref().unwrap_or(&case.renderer);
    let hits = &SinglePrecision { world: renderer.world() };
    let spaces = &ObjectSpaces::new(&renderer.scene, case.renderer.meshes(), renderer.world());
    let student = Student::new(renderer, hits, changed.request.effects, spaces);
    let student = Student { mistake: changed.switch, is_single: true, ..student };
    let colors = finished(mistakes, colors(&student, renderer, &changed.request, &|| false).ok()?);
    let mut bytes = Vec::with_capacity(colors.colors.len() * CHANNELS);
    let cut = |channel: f32| (255.0 * channel) as u8;
    bytes.extend(colors.colors.iter().flat_map(|color| color.as_vec3().to_array().map(cut)));
    Some(Picture::from_rgb(colors.size[0] as u32, colors.size[1] as u32, bytes))
}

/// Returns true if a finding names only these mistakes, or others that give the same picture.
fn names_only(original: &Original, found: &Finding, mistakes: &[Mistake]) -> bool {
    let is_meant = |name: &Mistake| mistakes.iter().any(|mistake| mistake.is_akin(*name));
    let makes = |names: &[Mistake]| Some(Made::new(&original.made(names, None)?));
    match found {
        Finding::Equal { cause, also, .. } => {
            let names: Vec<Mistake> = std::iter::once(cause).chain(also).copied().collect();
            let is_same =
                || makes(&names).zip(makes(mistakes)).is_some_and(|(one, other)| one.is_like(&other));
            names.iter().all(is_meant) || is_same()
        }
        Finding::Part { cause, .. } => is_meant(cause),
        Finding::Speckles { .. } => {
            let is_meant = |mistake: &Mistake| {
                matches!(mistake, Mistake::NoEpsilon { .. } | Mistake::ReflectionFromBelow)
            };
            mistakes.iter().any(is_meant)
        }
        Finding::Rounding { .. } | Finding::Unknown { .. } => true,
    }
}

#[test]
fn a_correct_tracer_in_single_precision_rounds() {
    let mut differing = 0;
    for case in cases(60) {
        let (original, own) = (case.original(), picture(&case, &[]).unwrap());
        let right = original.colors.to_picture();
        if own != right {
            differing += 1;
            let found = original.explain(&own, &right);
            assert!(matches!(found, Finding::Rounding { .. }), "{}: {found}", case.name);
        }
    }
    assert!(differing > 8, "{differing}");
}

#[test]
fn mistakes_in_single_precision_are_named() {
    let (mut shown, mut named, mut both) = (0, 0, 0);
    // The first scene is tried once.
    for case in cases(SIDE).into_iter().skip(2) {
        let original = case.original();
        let right = original.colors.to_picture();
        let reference = Rc::new(Made::new(&original.colors));
        // Mistakes that show in more than a hundredth of the pixels by more than rounding.
        let shows = |picture: &Picture| {
            let search = Search::new(Cow::Borrowed(picture), reference.clone());
            100 * (0..SIDE * SIDE).filter(|&at| search.differs(at)).count() > SIDE * SIDE
        };
        let singles: Vec<Mistake> = Mistake::all()
            .filter(|&mistake| mistake.shows_in(original.layer()) && mistake != Mistake::Unchanged)
            .collect();
        let pairs = singles.iter().flat_map(|&one| singles.iter().map(move |&other| vec![one, other]));
        let pairs = pairs.filter(|pair| pair[0].kind() < pair[1].kind()).step_by(151);
        let all: Vec<Vec<Mistake>> = singles.iter().map(|&mistake| vec![mistake]).chain(pairs).collect();
        let made = all.into_iter().filter_map(|mistakes| Some((picture(&case, &mistakes)?, mistakes)));
        let (pictures, mistakes): (Vec<Picture>, Vec<_>) = made.filter(|(picture, _)| shows(picture)).unzip();
        let found = original.explain_all(&pictures, &right, &[]);
        for (mistakes, found) in mistakes.iter().zip(found) {
            assert!(names_only(&original, &found, mistakes), "{} {mistakes:?}: {found}", case.name);
            let is_named = match &found {
                Finding::Equal { also, .. } => also.len() + 1 == mistakes.len(),
                Finding::Speckles { .. } => true,
                _ => false,
            };
            if mistakes.len() == 1 {
                (shown, named) = (shown + 1, named + u32::from(is_named));
            } else {
                both += u32::from(is_named);
            }
        }
    }
    assert!(10 * named >= 9 * shown && both > 20, "{named} of {shown}, {both} pairs");
}
