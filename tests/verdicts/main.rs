//! Verdicts on the pictures of a student's ray tracer.
//!
//! [`single`] is such a tracer, in single precision, with a switch for each [`Mistake`]. It shares the reader of scenes
//! with this program, and nothing else.

mod cases;
mod mistake;
mod names;
mod objects;
mod single;
mod textures;

use cases::{CASES, Opened};
use mistake::Mistake;
use names::name_of;
use raytracer::picture::Picture;
use raytracer::render::Request;
use raytracer::render::renderer::{Meshes, Renderer};
use raytracer::tools::causes::{Finding, MAX_UNEXPLAINED, Mistake as Named, Original};
use std::env;

/// Pairs of mistakes, at least one of them in the finished picture.
const PAIRS: &[[Mistake; 2]] = &[
    [Mistake::UpsideDown, Mistake::RedAndBlueSwapped],
    [Mistake::Gamma, Mistake::RedAndBlueSwapped],
    [Mistake::Gamma, Mistake::OneBounceFewer],
    [Mistake::Mirrored, Mistake::Rounded],
    [Mistake::Times256, Mistake::UpsideDown],
];

/// The number of pixels in which a mistake shows at least.
const VISIBLE: usize = 4;

/// Renders the picture of a case by the student's tracer.
fn render(case: &Opened, mistakes: &[Mistake]) -> Picture {
    single::render(&case.scene, &case.options, case.layer, mistakes)
}

/// Returns for each pixel, row by row from the top, if a channel differs by more than this number of levels.
fn differing(a: &Picture, b: &Picture, levels: u8) -> Vec<bool> {
    let channels: Vec<bool> =
        a.pixels().iter().zip(b.pixels()).map(|(a, b)| a.abs_diff(*b) > levels).collect();
    channels.chunks(3).map(|pixel| pixel.contains(&true)).collect()
}

fn count(pixels: &[bool]) -> usize {
    pixels.iter().filter(|&&differs| differs).count()
}

/// Returns true if there is a square of 3 x 3 pixels that all differ.
fn has_block(pixels: &[bool], width: usize) -> bool {
    let rows: Vec<&[bool]> = pixels.chunks(width).collect();
    let differs_at = |x: usize, rows: &[&[bool]]| rows.iter().all(|row| row[x..x + 3] == [true; 3]);
    rows.windows(3).any(|rows| (0..width - 2).any(|x| differs_at(x, rows)))
}

#[test]
fn the_student_s_pictures_are_right_but_for_rounding() {
    for case in CASES {
        let opened = case.open();
        let pixels = differing(&render(&opened, &[]), &opened.render(), 1);
        assert!(count(&pixels) <= pixels.len() / 100, "{}: {} pixels", case.name, count(&pixels));
        assert!(!has_block(&pixels, opened.options.size[0]), "{}", case.name);
    }
}

#[test]
fn every_mistake_shows_in_a_case() {
    let mut hidden = Mistake::ALL.to_vec();
    for case in CASES {
        let mut opened = case.open();
        opened.options.size = opened.options.size.map(|side| side / 4);
        let right = render(&opened, &[]);
        hidden.retain(|&mistake| right == render(&opened, &[mistake]));
    }
    assert_eq!(hidden, []);
}

/// The verdict on a picture with mistakes that show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verdict {
    /// All mistakes are named, or others that give the same picture.
    Right,
    /// Only some of the mistakes are named, or none.
    Unnamed,
    /// Another mistake is named.
    Wrong,
    /// No mistake is there.
    Acquitted,
}

/// Judges a finding on a picture with these mistakes.
fn judge(original: &Original, found: &Finding, mistakes: &[Mistake]) -> Verdict {
    let is_meant = |named: &Named| {
        mistakes
            .iter()
            .filter_map(|&mistake| name_of(mistake))
            .any(|[name, detail]| named.name == name && (detail.is_empty() || named.detail == detail))
    };
    // Whatever else gives the same picture is right, too.
    let known: Option<Vec<Named>> = mistakes
        .iter()
        .map(|&mistake| {
            let [name, detail] = name_of(mistake)?;
            Named::all().find(|named| named.name == name && (detail.is_empty() || named.detail == detail))
        })
        .collect();
    let is_same = |named: &[Named]| {
        let known = known.as_ref().and_then(|known| original.picture(known));
        known.is_some() && original.picture(named) == known
    };
    match found {
        Finding::Equal { cause, also, .. } => {
            let named: Vec<Named> = std::iter::once(cause).chain(also).cloned().collect();
            match named.iter().all(&is_meant) {
                true if named.len() == mistakes.len() => Verdict::Right,
                true => Verdict::Unnamed,
                false if is_same(&named) => Verdict::Right,
                false => Verdict::Wrong,
            }
        }
        Finding::Part { cause, .. } if is_meant(cause) => Verdict::Unnamed,
        Finding::Part { .. } => Verdict::Wrong,
        Finding::Speckles { .. } if mistakes == [Mistake::EpsilonZero] => Verdict::Right,
        Finding::Speckles { .. } => Verdict::Wrong,
        Finding::Rounding { rest } if rest.unexplained == 0 => Verdict::Acquitted,
        Finding::Rounding { .. } | Finding::Unknown { .. } => Verdict::Unnamed,
    }
}

#[test]
fn some_mistakes_are_named_and_none_is_acquitted() {
    judge_all([3, 16], false);
}

#[test]
#[ignore = "slow: a minute"]
fn mistakes_are_named_and_none_is_acquitted() {
    let is_whole = env::var_os("VERDICTS").is_some_and(|value| value == "all");
    judge_all([1, if is_whole { 1 } else { 8 }], is_whole);
}

/// Judges one of `step` pictures of every `case_step`th case, at half the size unless `is_whole`.
fn judge_all([case_step, step]: [usize; 2], is_whole: bool) {
    let (mut counts, mut wrong, mut unnamed) = ([0; 4], vec![], vec![]);
    for (place, case) in CASES.iter().enumerate().step_by(case_step) {
        let mut opened = case.open();
        if !is_whole {
            opened.options.size = opened.options.size.map(|side| side / 2);
        }
        let renderer = Renderer::new(opened.scene.clone(), Meshes::Kept).unwrap();
        let request = Request { layers: vec![opened.layer], ..opened.options.request() };
        let original = Original::new(&renderer, &request).unwrap();
        let (own, right) = (original.own(), render(&opened, &[]));
        let found = original.explain(&right);
        let is_rounding = match &found {
            Finding::Rounding { rest } => rest.unexplained <= MAX_UNEXPLAINED,
            Finding::Equal { cause, .. } => cause.is_unchanged(),
            _ => false,
        };
        assert!(is_rounding, "{}: {found}", case.name);
        let all: Vec<Vec<Mistake>> = Mistake::ALL.iter().map(|&mistake| vec![mistake]).collect();
        let pairs = PAIRS.iter().map(|pair| pair.to_vec());
        for mistakes in all.into_iter().chain(pairs).skip(place % step).step_by(step) {
            let picture = render(&opened, &mistakes);
            // A mistake may also hide the tracer's own rounding.
            let more = count(&differing(&picture, &own, 1)) >= count(&differing(&right, &own, 1)) + VISIBLE;
            let is_single =
                mistakes.len() > 1 && mistakes.iter().any(|&one| render(&opened, &[one]) == picture);
            if !more || is_single || count(&differing(&right, &picture, 1)) < VISIBLE {
                continue;
            }
            let found = original.explain(&picture);
            let line = format!("{} {mistakes:?}: {found}", case.name);
            let verdict = judge(&original, &found, &mistakes);
            match verdict {
                Verdict::Right => {}
                Verdict::Unnamed if mistakes.iter().all(|&mistake| name_of(mistake).is_none()) => continue,
                Verdict::Unnamed => unnamed.push(line),
                Verdict::Wrong | Verdict::Acquitted => wrong.push(format!("{verdict:?}: {line}")),
            }
            counts[verdict as usize] += 1;
        }
    }
    let all: usize = counts.iter().sum();
    println!("{} of {all} visible mistakes are named; not named:\n{}", counts[0], unnamed.join("\n"));
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(100 * counts[0] >= 90 * all && all > 400 / step / case_step, "{counts:?}\n{unnamed:#?}");
}
