//! Makes each mistake, alone and in pairs, and writes the findings of the search to `tables.md`.

use super::{Case, cases, named};
use crate::picture::Picture;
use crate::render::{Layer, Request};
use crate::tools::causes::finding::find_causes;
use crate::tools::causes::mistakes::{Make, Setting};
use crate::tools::causes::paint::colors;
use crate::tools::causes::{Finding, Mistake, Original, SelfHitting};
use crate::trace::{Effects, Shadows};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;

const PAGE: &str = "src/tools/causes/tests/tables.md";

const HEAD: &str = "# Which cause is named

The answers of `-compare` for pictures with known mistakes. `BLESS=1 cargo test --lib confusion` writes this page. An
answer is right if it is the mistake, or another one that makes the same picture to the byte; in the first table all are.
The scene `everything` is in the test.

";

const ALONE: &str = "
## One mistake

In how many of these scenes the mistake shows and is named, and which other one is named where both make the same
picture.

| the mistake that is made | named | the same picture |
|---|---:|---|
";

const UNKNOWN: &str = "
## A mistake that is not known

A leave-one-out test: each mistake is made while it is removed from the candidates. Ideally nothing is named. The table
has the exceptions, where a similar mistake is named.

| the mistake that is made | named |
|---|---|
";

const BOTH: &str = "
## Two mistakes

One of the two is named with `at least`, or nothing is. If one hides the other, or both together equal a third, that one
is named.

| one mistake | the other | named |
|---|---|---|
";

/// The number of pairs of mistakes for each of the first two scenes.
const PAIRS: usize = 15;

/// A case with the pictures of its mistakes.
struct Made<'c> {
    case: &'c Case,
    original: Original<'c>,
    right: Picture,
    mistakes: Vec<(Mistake, Picture)>,
}

impl<'c> Made<'c> {
    fn new(case: &'c Case) -> Self {
        let original = case.original();
        let right = original.picture(Mistake::Unchanged).unwrap();
        let mistakes = Mistake::all().filter_map(|cause| Some((cause, original.picture(cause)?)));
        let mistakes = mistakes.filter(|(_, picture)| *picture != right).collect();
        Self { case, original, right, mistakes }
    }

    /// Searches with only these causes known.
    fn explain(&self, is_known: impl Fn(Mistake, &Picture) -> bool, wrong: &Picture) -> Finding {
        let known = self.mistakes.iter().filter(|(cause, picture)| is_known(*cause, picture));
        let picture = |asked: Mistake| match asked {
            Mistake::Unchanged => Some(self.right.clone()),
            _ => self.mistakes.iter().find(|(made, _)| *made == asked).map(|(_, picture)| picture.clone()),
        };
        let known = known.map(|(cause, _)| *cause);
        let found = find_causes(known, picture, std::slice::from_ref(wrong), &self.right)[0];
        self.original.or_speckles(found, wrong, &self.right)
    }

    /// Returns true if the mistake makes exactly this picture.
    fn makes(&self, cause: Mistake, picture: &Picture) -> bool {
        self.mistakes.iter().any(|(made, same)| *made == cause && same == picture)
    }
}

/// Returns the picture with both mistakes. `None` if they cannot be combined.
fn both(case: &Case, mistakes: [Mistake; 2]) -> Option<Picture> {
    let (renderer, request) = (&case.renderer, &case.request);
    let mut scene = renderer.scene.clone();
    let (mut changed, mut switch, mut pixels) = (request.clone(), None, None);
    for mistake in mistakes {
        match mistake.make()? {
            Make::Pixels(change) => pixels = Some(change),
            make @ (Make::Camera(_) | Make::Effects(_)) => changed = make.request(&scene, &changed)?,
            make @ (Make::Scene(_) | Make::Text(_)) => scene = make.scene(&scene, &renderer.source.text)?,
            Make::Student(shows) if shows(&Setting { scene: &scene, request: &changed }) => {
                switch = Some(mistake);
            }
            Make::Student(_) => return None,
        }
    }
    let renderer = renderer.with_scene(scene).ok()?;
    let prepared = renderer.prepare(&changed).ok()?;
    let colors = match switch {
        Some(_) => colors(&renderer, &changed, prepared.caster(), switch, &|| false).ok()?,
        None => prepared.render(&changed).ok()?.pop()?,
    };
    Some(pixels.map_or_else(|| colors.to_picture(), |change| change(&colors)))
}

/// Returns true if one mistake resembles the other so much that it may be named when the other is unknown.
fn are_alike(one: Mistake, other: Mistake) -> bool {
    let pairs = [
        (Mistake::NoHighlights, Mistake::HighlightsByReflection),
        (Mistake::NoAmbient, Mistake::NoShadeBack),
        (Mistake::AngleNotHalved, Mistake::AngleOfShorterSide),
        (Mistake::BlackBackground, Mistake::BackgroundForCameraOnly),
        (Mistake::NoShadows, Mistake::Epsilon { distance: 0.3 }),
        (Mistake::NoShadows, Mistake::GlassWithoutShadows),
        (Mistake::RaysClamped, Mistake::SamplesClamped),
        (Mistake::Shadows, Mistake::TransparentShadows),
        (Mistake::OneLevelBrighter, Mistake::RoundedUp),
        (Mistake::NoEpsilon { rays: SelfHitting::Secondary }, Mistake::ReflectionFromBelow),
    ];
    pairs.iter().any(|&(a, b)| (a.is_akin(one) && b.is_akin(other)) || (a.is_akin(other) && b.is_akin(one)))
}

fn kind(mistake: Mistake) -> Option<usize> {
    ["unchanged", "pixels", "request", "scene", "rule"].iter().position(|&kind| kind == mistake.kind())
}

fn words(cause: Mistake) -> String {
    cause.to_string().trim_start().to_owned()
}

fn flags(request: &Request) -> String {
    let Effects { shadows, shade_back, bounces, min_weight } = request.effects;
    let mut flags = match shadows {
        Shadows::None => String::new(),
        Shadows::Opaque => " -shadows".to_owned(),
        Shadows::Transparent => " -transparent_shadows".to_owned(),
    };
    if shade_back {
        flags += " -shade_back";
    }
    let _ = write!(flags, " -bounces {bounces}");
    if min_weight > 0.0 {
        let _ = write!(flags, " -weight {min_weight}");
    }
    if request.sampler.count() > 1 {
        let _ = write!(flags, " -jittered_samples {}", request.sampler.count());
    }
    flags
}

/// A mistake, the number of scenes in which it is named, and the mistakes named instead because they make the same
/// picture.
struct Row {
    made: Mistake,
    named: usize,
    same: BTreeSet<String>,
}

fn add_alone(rows: &mut Vec<Row>, made: &Made) {
    let wrong: Vec<Picture> = made.mistakes.iter().map(|(_, picture)| picture.clone()).collect();
    let found = made.original.explain_all(&wrong, &made.right);
    for ((cause, picture), found) in made.mistakes.iter().zip(found) {
        assert!(matches!(found, Finding::Equal { pixels: 0, .. }), "{cause:?}: {found}");
        let name = named(found).unwrap();
        assert!(made.makes(name, picture), "{cause:?}: {found}");
        let place = rows.iter().position(|row| row.made == *cause).unwrap_or_else(|| {
            rows.push(Row { made: *cause, named: 0, same: BTreeSet::new() });
            rows.len() - 1
        });
        if name == *cause {
            rows[place].named += 1;
        } else {
            rows[place].same.insert(words(name));
        }
    }
}

fn add_unknown(named_instead: &mut BTreeSet<[String; 2]>, made: &Made, wrong_names: &mut Vec<String>) {
    for (cause, wrong) in &made.mistakes {
        let found = made.explain(|other, same| !other.is_akin(*cause) && same != wrong, wrong);
        let name = match (named(found), found) {
            (Some(name), _) => {
                if !are_alike(name, *cause) {
                    wrong_names.push(format!("{cause:?}: {found}"));
                }
                words(name)
            }
            (None, Finding::Speckles { .. }) => {
                if !darkens_scattered_pixels(*cause) {
                    wrong_names.push(format!("{cause:?}: {found}"));
                }
                "scattered pixels, since epsilon is too small".to_owned()
            }
            (None, _) => continue,
        };
        named_instead.insert([words(*cause), name]);
    }
}

/// Returns true if pixels become as dark as in their own shadow, also where the visible side faces away from the light.
fn darkens_scattered_pixels(cause: Mistake) -> bool {
    matches!(cause, Mistake::NoEpsilon { .. } | Mistake::ReflectionFromBelow | Mistake::NormalsFlipped)
}

/// Returns the findings for pairs of mistakes, one table row each.
fn pairs(made: &Made, wrong_names: &mut Vec<String>) -> Vec<String> {
    let causes: Vec<Mistake> = made.mistakes.iter().map(|(cause, _)| *cause).collect();
    let all = causes.iter().flat_map(|&one| causes.iter().map(move |&other| [one, other]));
    let all: Vec<[Mistake; 2]> = all.filter(|&[one, other]| kind(one) < kind(other)).collect();
    let chosen = all.iter().step_by(all.len() / (PAIRS + 1));
    let both = chosen.filter_map(|&pair| Some((pair, both(made.case, pair)?))).take(PAIRS);
    both.map(|([one, other], wrong)| {
        let found = made.explain(|_, _| true, &wrong);
        let shown = match (named(found), found) {
            (None, _) => "nothing".to_owned(),
            (Some(name), Finding::Part { .. }) => {
                if !name.is_akin(one) && !name.is_akin(other) {
                    wrong_names.push(format!("{one:?} {other:?}: {found}"));
                }
                format!("at least {}", words(name))
            }
            (Some(name), _) => {
                if !made.makes(name, &wrong) {
                    wrong_names.push(format!("{one:?} {other:?}: {found}"));
                }
                format!("the same picture: {}", words(name))
            }
        };
        format!("| {} | {} | {shown} |\n", words(one), words(other))
    })
    .collect()
}

#[test]
fn the_page_shows_what_is_named() {
    let mut page = HEAD.to_owned();
    let (mut alone, mut instead, mut both, mut wrong_names) = (vec![], BTreeSet::new(), vec![], vec![]);
    for (place, case) in cases().iter().enumerate() {
        let made = Made::new(case);
        let _ = writeln!(page, "* `{}{}`", case.name, flags(&case.request));
        add_alone(&mut alone, &made);
        add_unknown(&mut instead, &made, &mut wrong_names);
        if place < 2 {
            both.extend(pairs(&made, &mut wrong_names));
        }
    }
    assert!(wrong_names.is_empty(), "{wrong_names:#?}");
    page += ALONE;
    for Row { made, named, same } in &alone {
        let same: Vec<&str> = same.iter().map(String::as_str).collect();
        let _ = writeln!(page, "| {} | {named} | {} |", words(*made), same.join("; "));
    }
    page += UNKNOWN;
    for [made, named] in &instead {
        let _ = writeln!(page, "| {made} | {named} |");
    }
    page += BOTH;
    page.extend(both.iter().map(String::as_str));
    let nothing = both.iter().filter(|line| line.ends_with("| nothing |\n")).count();
    let _ = writeln!(page, "\nOf {nothing} of these {} pictures nothing is named.", both.len());

    // In these scenes nothing is this near to anything else.
    let small = [0.0001, 0.001].map(|distance| Mistake::Epsilon { distance });
    let is_made = |cause: &Mistake| alone.iter().any(|row| row.made == *cause && row.named > 0);
    // These mistakes show in other layers.
    let is_of_colors = |cause: &Mistake| cause.shows_in(Layer::Color);
    let expected = Mistake::all().skip(1).filter(is_of_colors);
    let missing: Vec<Mistake> = expected.filter(|cause| !is_made(cause)).collect();
    assert_eq!(missing, small);
    assert!(both.len() == 2 * PAIRS && 2 * nothing < both.len(), "{nothing} of {}", both.len());

    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(PAGE);
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(&path, &page).unwrap();
    }
    let shown = std::fs::read_to_string(&path).unwrap_or_default().replace("\r\n", "\n");
    assert!(shown == page, "BLESS=1 cargo test --lib confusion writes {PAGE} anew");
}
