//! Makes each mistake, alone and in pairs, and writes the findings of the search to `tables.md`.

use super::{Case, cases, named};
use crate::picture::Picture;
use crate::render::Request;
use crate::tools::causes::search::{Made as Found, Search};
use crate::tools::causes::speckles::speckles;
use crate::tools::causes::{Finding, Mistake, Original, SelfHitting};
use crate::trace::{Effects, Shadows};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;
use std::rc::Rc;

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

Both are named, or one with `at least`, or nothing is. If one hides the other, or both together equal a third, that one is
named alone.

| one mistake | the other | named |
|---|---|---|
";

/// The number of pairs of mistakes for each of the first two scenes.
const PAIRS: usize = 15;

/// The picture of a mistake.
struct MadePicture {
    mistake: Mistake,
    picture: Picture,
    found: Rc<Found>,
    /// The levels by which it differs from the right picture.
    changes: Vec<u8>,
}

/// A case with the pictures of its mistakes.
struct Made<'c> {
    original: Original<'c>,
    right: Picture,
    reference: Rc<Found>,
    mistakes: Vec<MadePicture>,
}

impl<'c> Made<'c> {
    fn new(case: &'c Case) -> Self {
        let original = case.original();
        let right = original.picture(Mistake::Unchanged).unwrap();
        let reference = Rc::new(Found::new(&original.colors));
        let made = |mistake| {
            let colors = original.made(&[mistake], None)?;
            let picture = colors.to_picture();
            let changes = reference.all_levels(&picture);
            Some(MadePicture { mistake, picture, found: Rc::new(Found::new(&colors)), changes })
        };
        let mistakes = Mistake::all().filter_map(made).filter(|made| made.picture != right).collect();
        Self { original, right, reference, mistakes }
    }

    /// Searches with only these causes known.
    fn explain(&self, is_known: impl Fn(Mistake, &Picture) -> bool, wrong: &Picture) -> Finding {
        let mut search = Search::new(Cow::Borrowed(wrong), self.reference.clone());
        for made in self.mistakes.iter().filter(|made| is_known(made.mistake, &made.picture)) {
            if made.changes.iter().any(|&levels| levels > 0) {
                search.try_mistakes(&[made.mistake], &made.found, &made.changes);
            }
        }
        match search.finding() {
            Finding::Unknown { tried } => {
                speckles(&self.original, wrong, &self.right).unwrap_or(Finding::Unknown { tried })
            }
            found => found,
        }
    }

    /// Returns true if the mistake makes exactly this picture.
    fn makes(&self, cause: Mistake, picture: &Picture) -> bool {
        self.mistakes.iter().any(|made| made.mistake == cause && made.picture == *picture)
    }
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
        (Mistake::CheckerboardCut, Mistake::CheckerboardSwapped),
        (Mistake::DoubleScreen, Mistake::AngleOfShorterSide),
        (Mistake::NoShadeBack, Mistake::AmbientFromAbove),
        (Mistake::LightsTimesPi, Mistake::PointDirectionsNotNormalised),
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

/// Returns the mistakes named for each mistake.
fn named_alone(made: &Made) -> Vec<(Mistake, Vec<Mistake>)> {
    let wrong: Vec<Picture> = made.mistakes.iter().map(|made| made.picture.clone()).collect();
    let found = made.original.explain_all_with(&wrong, &made.right, &[]);
    let names = |(MadePicture { mistake, picture, .. }, found): (&MadePicture, Finding)| {
        let Finding::Equal { pixels: 0, cause, ref also, ref same, .. } = found else {
            panic!("{mistake:?}: {found}")
        };
        assert!(made.makes(cause, picture) && also.is_empty(), "{mistake:?}: {found}");
        (*mistake, std::iter::once(cause).chain(same.iter().copied()).collect())
    };
    made.mistakes.iter().zip(found).map(names).collect()
}

fn add_alone(rows: &mut Vec<Row>, cause: Mistake, all: &[Mistake]) {
    let place = rows.iter().position(|row| row.made == cause).unwrap_or_else(|| {
        rows.push(Row { made: cause, named: 0, same: BTreeSet::new() });
        rows.len() - 1
    });
    rows[place].named += all.iter().filter(|&&named| named == cause).count();
    rows[place].same.extend(all.iter().filter(|&&named| named != cause).map(|&named| words(named)));
}

/// Returns each mistake that is unknown with the one named instead.
fn named_instead(made: &Made, wrong_names: &mut Vec<String>) -> Vec<[String; 2]> {
    let mut named_instead = vec![];
    for MadePicture { mistake: cause, picture: wrong, .. } in &made.mistakes {
        let found = made.explain(|other, same| !other.is_akin(*cause) && same != wrong, wrong);
        let name = match (named(&found), &found) {
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
        named_instead.push([words(*cause), name]);
    }
    named_instead
}

/// Returns true if pixels become as dark as in their own shadow, also where the visible side faces away from the light.
fn darkens_scattered_pixels(cause: Mistake) -> bool {
    matches!(cause, Mistake::NoEpsilon { .. } | Mistake::ReflectionFromBelow | Mistake::NormalsFlipped)
}

/// Returns the findings for pairs of mistakes, one table row each.
fn pairs(made: &Made, wrong_names: &mut Vec<String>) -> Vec<String> {
    let causes: Vec<Mistake> = made.mistakes.iter().map(|made| made.mistake).collect();
    let all = causes.iter().flat_map(|&one| causes.iter().map(move |&other| [one, other]));
    let all: Vec<[Mistake; 2]> = all.filter(|&[one, other]| kind(one) < kind(other)).collect();
    let chosen = all.iter().step_by(all.len() / (PAIRS + 1));
    let both =
        chosen.filter_map(|&pair| Some((pair, made.original.made(&pair, None)?.to_picture()))).take(PAIRS);
    let (pairs, wrong): (Vec<[Mistake; 2]>, Vec<Picture>) = both.unzip();
    let found = made.original.explain_all_with(&wrong, &made.right, &[]);
    let rows = pairs.into_iter().zip(wrong).zip(found).map(|(([one, other], wrong), found)| {
        let is_meant = |name: Mistake| name.is_akin(one) || name.is_akin(other);
        let (shown, is_right) = match &found {
            Finding::Part { cause, .. } => (format!("at least {}", words(*cause)), is_meant(*cause)),
            Finding::Equal { cause, also, .. } => {
                let all: Vec<Mistake> = std::iter::once(cause).chain(also).copied().collect();
                let is_right = all.iter().all(|&name| is_meant(name));
                let is_same = made.original.made(&all, None).is_some_and(|made| made.to_picture() == wrong);
                let names: Vec<String> = all.iter().map(|&name| words(name)).collect();
                let shown = match (names.len(), is_right) {
                    (2, true) => "both".to_owned(),
                    _ => format!("the same picture: {}", names.join(", and ")),
                };
                (shown, is_right || is_same)
            }
            _ => ("nothing".to_owned(), true),
        };
        if !is_right {
            wrong_names.push(format!("{one:?} {other:?}: {found}"));
        }
        format!("| {} | {} | {shown} |\n", words(one), words(other))
    });
    rows.collect()
}

#[test]
fn the_page_shows_what_is_named() {
    let mut page = HEAD.to_owned();
    let outcome = |(place, case): (usize, &Case)| {
        let (made, mut wrong_names) = (Made::new(case), vec![]);
        let instead = named_instead(&made, &mut wrong_names);
        let both = if place < 2 { pairs(&made, &mut wrong_names) } else { vec![] };
        (named_alone(&made), instead, both, wrong_names)
    };
    let cases = cases();
    let outcomes: Vec<_> = cases.par_iter().enumerate().map(outcome).collect();
    let (mut alone, mut instead, mut both, mut wrong_names) = (vec![], BTreeSet::new(), vec![], vec![]);
    for (case, outcome) in cases.iter().zip(outcomes) {
        let _ = writeln!(page, "* `{}{}`", case.name, flags(&case.request));
        outcome.0.iter().for_each(|(cause, all)| add_alone(&mut alone, *cause, all));
        instead.extend(outcome.1);
        both.extend(outcome.2);
        wrong_names.extend(outcome.3);
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

    let is_made = |cause: &Mistake| alone.iter().any(|row| row.made == *cause && row.named > 0);
    let is_of_other_layers = |cause: &Mistake| {
        matches!(cause, Mistake::NearWhite | Mistake::AbsoluteNormals | Mistake::ShiftedNormals)
    };
    let expected = Mistake::all().skip(1).filter(|cause| !is_of_other_layers(cause));
    let missing: Vec<Mistake> = expected.filter(|cause| !is_made(cause)).collect();
    assert_eq!(missing, []);
    assert!(both.len() == 2 * PAIRS && 2 * nothing < both.len(), "{nothing} of {}", both.len());

    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(PAGE);
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(&path, &page).unwrap();
    }
    let shown = std::fs::read_to_string(&path).unwrap_or_default().replace("\r\n", "\n");
    assert!(shown == page, "BLESS=1 cargo test --lib confusion writes {PAGE} anew");
}
