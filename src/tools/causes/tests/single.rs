//! A student's tracer in single precision, with an epsilon: without a mistake, with each mistake, and with two.

use super::Case;
use crate::picture::{CHANNELS, Picture};
use crate::render::renderer::Renderer;
use crate::render::{Layer, Request};
use crate::sampling::drand48::Drand48;
use crate::sampling::sampler::{Pattern, Sampler};
use crate::tools::causes::mistakes::Mistake;
use crate::tools::causes::paint::colors;
use crate::tools::causes::search::Made;
use crate::tools::causes::student::{ObjectSpaces, Student};
use crate::tools::causes::{Changed, Finding, Original, finish};
use crate::tools::error_report::SinglePrecision;
use crate::trace::{Effects, Shadows};
use rayon::prelude::*;
use std::rc::Rc;

/// The side of pictures with mistakes.
const SIDE: usize = 40;
/// One of this many pairs of mistakes is tried.
const PAIR_STEP: usize = 151;

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
    let student = Student::new(renderer, hits, changed.request.effects);
    let student = Student { mistake: changed.switch, spaces: Some(spaces), is_single: true, ..student };
    let mut colors = colors(&student, &changed.request, &|| false).ok()?;
    finish(mistakes, &mut colors);
    let mut bytes = Vec::with_capacity(colors.colors.len() * CHANNELS);
    let cut = |channel: f32| (255.0 * channel) as u8;
    bytes.extend(colors.colors.iter().flat_map(|color| color.as_vec3().to_array().map(cut)));
    Some(Picture::from_rgb(colors.size[0] as u32, colors.size[1] as u32, bytes))
}

/// Returns true if a finding names only these mistakes, or others that give the same picture.
fn names_only(original: &Original, found: &Finding, mistakes: &[Mistake]) -> bool {
    let is_meant = |name: &Mistake| mistakes.iter().any(|mistake| mistake.is_akin(*name));
    let makes = |names: &[Mistake]| Some(Made::new(&original.made(names, None)?));
    let is_same = |one: &[Mistake], other: &[Mistake]| {
        makes(one).zip(makes(other)).is_some_and(|(one, other)| one.is_like(&other))
    };
    match found {
        Finding::Equal { cause, also, .. } => {
            let names: Vec<Mistake> = std::iter::once(cause).chain(also).copied().collect();
            names.iter().all(is_meant) || is_same(&names, mistakes)
        }
        Finding::Part { cause, .. } => {
            is_meant(cause) || mistakes.iter().any(|&mistake| is_same(&[*cause], &[mistake]))
        }
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
            let found = original.explain(&own);
            assert!(matches!(found, Finding::Rounding { .. }), "{}: {found}", case.name);
        }
    }
    assert!(differing > 8, "{differing}");
}

#[test]
fn a_picture_darker_by_a_level_shows_no_acne() {
    let mirrors = Effects { shadows: Shadows::Opaque, bounces: 2, ..Effects::default() };
    let request = Request { effects: mirrors, ..Request::new([150; 2]) };
    let case = Case::new("scene6_11_mirrored_floor.txt", request);
    let mistakes = [Mistake::OneLevelDarker];
    let (original, wrong) = (case.original(), picture(&case, &mistakes).unwrap());
    let found = original.explain(&wrong);
    assert!(names_only(&original, &found, &mistakes), "{found}");
}

/// The number of mistakes that show and of mistakes that are named, alone and in pairs.
type Score = [[u32; 2]; 2];

/// Makes each mistake that shows in this case, and some pairs. Nothing else may be named.
fn score(case: &Case) -> Score {
    let original = case.original();
    let right = original.colors.to_picture();
    let reference = Rc::new(Made::new(&original.colors));
    // Returns the picture if more than a hundredth of the pixels differs by more than rounding.
    let shown = |mistakes: &[Mistake]| {
        let picture = picture(case, mistakes)?;
        let differing = reference.all_levels(&picture).iter().filter(|&&levels| levels > 0).count();
        (100 * differing > SIDE * SIDE).then_some(picture)
    };
    let show = |mistakes: Vec<Mistake>| Some((shown(&mistakes)?, mistakes));
    let singles: Vec<_> = Mistake::all().skip(1).filter_map(|mistake| show(vec![mistake])).collect();
    let all: Vec<Mistake> = singles.iter().map(|(_, mistakes)| mistakes[0]).collect();
    let pairs = all.iter().flat_map(|&one| all.iter().map(move |&other| vec![one, other]));
    let pairs = pairs.filter(|pair| pair[0].kind() < pair[1].kind()).step_by(PAIR_STEP).filter_map(show);
    let (pictures, mistakes): (Vec<Picture>, Vec<_>) = singles.into_iter().chain(pairs).unzip();
    let mut score = Score::default();
    for (mistakes, found) in mistakes.iter().zip(original.explain_all_with(&pictures, &right, &[])) {
        assert!(names_only(&original, &found, mistakes), "{} {mistakes:?}: {found}", case.name);
        let is_named = match &found {
            Finding::Equal { also, .. } => also.len() + 1 == mistakes.len(),
            Finding::Speckles { .. } => true,
            _ => false,
        };
        let [shown, named] = &mut score[mistakes.len() - 1];
        (*shown, *named) = (*shown + 1, *named + u32::from(is_named));
    }
    score
}

#[test]
fn mistakes_in_single_precision_are_named() {
    // The first scene is tried once.
    let scores: Vec<Score> = cases(SIDE).par_iter().skip(2).map(score).collect();
    let sum = |at: usize| {
        scores.iter().fold([0; 2], |[shown, named], score| [shown + score[at][0], named + score[at][1]])
    };
    let ([shown, named], [pairs, both]) = (sum(0), sum(1));
    println!("{named} of {shown}, {both} of {pairs} pairs");
    assert!(shown > 600 && 10 * named >= 9 * shown, "{named} of {shown}");
    assert!(pairs > 50 && 4 * both > pairs, "{both} of {pairs} pairs");
}
