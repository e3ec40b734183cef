//! The search for the causes of differences, and its findings.

use super::Original;
use super::mistakes::{Mistake, with_kind};
use super::speckles::{Speckles, can_show, speckles};
use super::student::SelfHitting;
use super::window::{part, telling_windows};
use crate::picture::Picture;
use crate::tools::compare::{colors, largest_channel_difference, sum_of_squares};
use serde::Serialize;
use std::fmt;

/// The explanation of a difference. `Display` writes it in one line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "finding", rename_all = "snake_case")]
pub enum Finding {
    /// The mistake gives the same picture, up to one level.
    Equal {
        /// The mistake.
        #[serde(rename = "mistake", serialize_with = "with_kind")]
        cause: Mistake,
        /// The number of pixels that still differ, by one level.
        pixels: u64,
    },
    /// The mistake explains part of the difference.
    Part {
        /// The mistake that explains the most.
        #[serde(rename = "mistake", serialize_with = "with_kind")]
        cause: Mistake,
        /// The share of the squared error that it explains.
        share: f64,
    },
    /// Isolated rays hit the surface that they leave.
    Speckles {
        /// The number of pixels affected.
        pixels: usize,
        /// The rays that hit the surface that they leave.
        rays: SelfHitting,
    },
    /// No known mistake.
    Unknown {
        /// The number of mistakes tried.
        tried: usize,
    },
}

/// The smallest share of the squared error that a partial cause must explain.
const MIN_SHARE: f64 = 0.5;
/// The smallest share if no pixel differs by more than one level. It is higher because many changes move colours by
/// less than that.
const MIN_SHARE_OF_LEVELS: f64 = 0.9;
/// The smallest share of the differing pixels that a partial cause must make right. A change that only reduces the mean
/// error makes no pixel right, as when a brighter picture comes closer to a random one.
const MIN_PIXELS: f64 = 0.1;
/// The largest share of the pixels changed by a cause that may be right in the examined picture. A real mistake shows
/// wherever it can.
const MAX_CONTRADICTED: f64 = 0.03;
/// The largest such share for rays that hit the surface that they leave. Rounding spares some of them.
const MAX_CONTRADICTED_BY_ROUNDING: f64 = 0.2;
/// The smallest share of the pixels changed by a cause that it must make right. A change that is only similar to the
/// mistake leaves an error in the same pixels.
const MIN_PRECISION: f64 = 0.75;
/// The largest share of all pixels that may differ by one level if the mistake is the only one. If more differ,
/// something else is wrong, too, such as the rounding of colours.
const MAX_LEVELS: f64 = 0.2;
/// Any cause of another kind must leave at least this many times the error.
const MIN_LEAD: f64 = 2.0;

/// Upper bounds on the camera rays in the windows of successive searches.
const RAYS_OF_WINDOWS: [usize; 2] = [1 << 11, 1 << 18];

/// The distance between two pictures.
#[derive(Clone, Copy, Debug)]
struct Distance {
    /// The sum of squared differences over all channels, in levels.
    squares: u64,
    differing: u64,
    /// The number of pixels that differ by more than one level.
    visibly: u64,
}

impl Distance {
    /// Compares two pictures of the same size.
    fn between(a: &Picture, b: &Picture) -> Self {
        let mut distance = Self { squares: 0, differing: 0, visibly: 0 };
        for (&a, &b) in colors(a).iter().zip(colors(b)).filter(|(a, b)| a != b) {
            distance.squares += sum_of_squares(a, b);
            distance.differing += 1;
            distance.visibly += u64::from(largest_channel_difference(a, b) > 1);
        }
        distance
    }

    /// Returns the share of this error that is gone if `rest` remains.
    fn share_gone(&self, rest: &Self) -> f64 {
        1.0 - rest.squares as f64 / self.squares as f64
    }

    /// Returns the number of pixels that differ by more than `levels`, which is 0 or 1.
    fn beyond(&self, levels: u8) -> f64 {
        (if levels > 0 { self.visibly } else { self.differing }) as f64
    }
}

/// The effect of a cause, counted over the pixels that it changes by more than a number of levels.
#[derive(Clone, Copy, Debug, Default)]
struct Effect {
    changed: f64,
    /// Changed pixels that become equal to the examined picture.
    right: f64,
    /// Changed pixels where the examined picture equals the reference.
    contradicted: f64,
}

impl Effect {
    fn of(made: &Picture, picture: &Picture, reference: &Picture, levels: u8) -> Self {
        let differs = |a, b| largest_channel_difference(a, b) > levels;
        let mut effect = Self::default();
        for ((&seen, &made), &right) in colors(picture).iter().zip(colors(made)).zip(colors(reference)) {
            if differs(made, right) {
                effect.changed += 1.0;
                effect.right += f64::from(!differs(seen, made));
                effect.contradicted += f64::from(!differs(seen, right) && differs(seen, made));
            }
        }
        effect
    }
}

fn max_contradicted(cause: Mistake) -> f64 {
    match cause {
        Mistake::NoEpsilon { .. } => MAX_CONTRADICTED_BY_ROUNDING,
        _ => MAX_CONTRADICTED,
    }
}

/// A cause that explains at least part of the difference, and the difference that its picture leaves.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    cause: Mistake,
    rest: Distance,
}

/// The search for the cause of one picture.
struct Search<'p> {
    picture: &'p Picture,
    reference: &'p Picture,
    whole: Distance,
    candidates: Vec<Candidate>,
    tried: usize,
    is_over: bool,
}

impl<'p> Search<'p> {
    fn new(picture: &'p Picture, reference: &'p Picture) -> Self {
        let whole = Distance::between(picture, reference);
        Self { picture, reference, whole, candidates: vec![], tried: 0, is_over: false }
    }

    fn try_cause(&mut self, cause: Mistake, made: &Picture) {
        self.tried += 1;
        let rest = Distance::between(self.picture, made);
        self.is_over = rest.differing == 0;
        if self.is_over || self.is_part(cause, made, &rest) {
            self.candidates.push(Candidate { cause, rest });
        }
    }

    /// Returns true if a cause that leaves `rest` explains too much to be a coincidence.
    fn is_part(&self, cause: Mistake, made: &Picture, rest: &Distance) -> bool {
        let is_visible = self.whole.visibly > 0;
        let (levels, share) = if is_visible { (1, MIN_SHARE) } else { (0, MIN_SHARE_OF_LEVELS) };
        let (before, after) = (self.whole.beyond(levels), rest.beyond(levels));
        if self.whole.share_gone(rest) < share || after > (1.0 - MIN_PIXELS) * before {
            return false;
        }
        let effect = Effect::of(made, self.picture, self.reference, levels);
        effect.changed > 0.0
            && effect.contradicted <= max_contradicted(cause) * effect.changed
            && effect.right >= MIN_PRECISION * effect.changed
    }

    fn pixels(&self) -> f64 {
        colors(self.picture).len() as f64
    }

    fn finding(&self) -> Finding {
        let Self { whole, tried, .. } = *self;
        // The first of several equally good causes is taken.
        let Some(best) = self.candidates.iter().min_by_key(|candidate| candidate.rest.squares) else {
            return Finding::Unknown { tried };
        };
        let &Candidate { cause, rest } = best;
        let is_equal = rest.visibly == 0 && rest.differing as f64 <= MAX_LEVELS * self.pixels();
        match rest.differing {
            0 => Finding::Equal { cause, pixels: 0 },
            pixels if is_equal && whole.visibly > 0 => Finding::Equal { cause, pixels },
            _ if !self.leads(best) => Finding::Unknown { tried },
            _ => Finding::Part { cause, share: whole.share_gone(&rest) },
        }
    }

    /// Returns true if no cause of another kind explains about as much.
    fn leads(&self, best: &Candidate) -> bool {
        // An equal remainder means the same picture.
        let is_other =
            |other: &&Candidate| !other.cause.is_akin(best.cause) && other.rest.squares != best.rest.squares;
        let others = self.candidates.iter().filter(is_other);
        let bound = MIN_LEAD * best.rest.squares as f64;
        others.map(|other| other.rest.squares as f64).all(|squares| squares >= bound)
    }
}

/// Finds why each wrong picture differs from the reference `b`. All pictures have the same size.
///
/// Each cause is tried on all pictures, so its picture is made only once. The search ends with the first cause that
/// makes the same picture. Causes that give the reference are skipped.
pub fn find_causes(
    causes: impl Iterator<Item = Mistake>,
    picture: impl Fn(Mistake) -> Option<Picture>,
    wrong: &[Picture],
    b: &Picture,
) -> Vec<Finding> {
    let own = picture(Mistake::Unchanged);
    let shows = |cause: Mistake, picture: &Picture| {
        picture != b && (cause == Mistake::Unchanged || Some(picture) != own.as_ref())
    };
    let mut searches: Vec<Search> = wrong.iter().map(|picture| Search::new(picture, b)).collect();
    for cause in causes {
        if searches.iter().all(|search| search.is_over) {
            break;
        }
        let Some(made) = picture(cause).filter(|picture| shows(cause, picture)) else { continue };
        searches
            .iter_mut()
            .filter(|search| !search.is_over)
            .for_each(|search| search.try_cause(cause, &made));
    }
    searches.iter().map(Search::finding).collect()
}

impl Original<'_> {
    /// Finds why the picture `a` differs from the reference `b`. Both have the original's size.
    pub fn explain(&self, a: &Picture, b: &Picture) -> Finding {
        let found = self.explain_all(std::slice::from_ref(a), b);
        found.first().copied().unwrap_or(Finding::Unknown { tried: 0 })
    }

    /// Finds why each wrong picture differs from the reference `b`. All have the original's size.
    pub fn explain_all(&self, wrong: &[Picture], b: &Picture) -> Vec<Finding> {
        let found = find_causes(Mistake::all(), |cause| self.picture(cause), wrong, b);
        found.into_iter().zip(wrong).map(|(found, a)| self.or_speckles(found, a, b)).collect()
    }

    /// Finds why each wrong picture differs from the reference `b`, using parts of the pictures. All have the
    /// original's size.
    ///
    /// Searches first in a window of about two thousand camera rays where many pixels differ, and checks each finding
    /// on the whole picture. Pictures that remain unexplained are searched in a larger window, up to the whole picture.
    pub fn explain_parts(&mut self, wrong: &[Picture], b: &Picture) -> Vec<Finding> {
        if self.request.is_reduced {
            // A window would need the surrounding pixels.
            return self.explain_all(wrong, b);
        }
        let mut findings = vec![Finding::Unknown { tried: 0 }; wrong.len()];
        for rays in RAYS_OF_WINDOWS {
            let unknown: Vec<usize> =
                (0..wrong.len()).filter(|&at| matches!(findings[at], Finding::Unknown { .. })).collect();
            let pictures: Vec<Picture> = unknown.iter().map(|&at| wrong[at].clone()).collect();
            let found = self.explain_in_windows(&pictures, b, rays);
            unknown.into_iter().zip(found).for_each(|(at, found)| findings[at] = found);
            if self.request.camera_rays() <= rays {
                break;
            }
        }
        findings.into_iter().zip(wrong).map(|(found, a)| self.or_speckles(found, a, b)).collect()
    }

    /// Searches in windows of at most `rays` camera rays.
    fn explain_in_windows(&mut self, wrong: &[Picture], b: &Picture, rays: usize) -> Vec<Finding> {
        let mut findings = vec![Finding::Unknown { tried: 0 }; wrong.len()];
        for telling in telling_windows(wrong, b, self.request.sampler, rays) {
            let parts: Vec<Picture> =
                telling.pictures.iter().map(|&picture| part(&wrong[picture], telling.window)).collect();
            self.request.window = Some(telling.window);
            let picture = |cause| self.picture(cause);
            let found = find_causes(Mistake::all(), picture, &parts, &part(b, telling.window));
            self.request.window = None;
            let is_whole = [telling.window.width, telling.window.height] == self.request.size;
            for (&at, found) in telling.pictures.iter().zip(found) {
                findings[at] = if is_whole { found } else { self.confirmed(found, &wrong[at], b) };
            }
        }
        findings
    }

    /// Checks a finding on the whole picture.
    fn confirmed(&self, found: Finding, a: &Picture, b: &Picture) -> Finding {
        match found {
            Finding::Equal { cause, .. } | Finding::Part { cause, .. } => {
                let picture = |cause| self.picture(cause);
                let found = find_causes(std::iter::once(cause), picture, std::slice::from_ref(a), b);
                found.first().copied().unwrap_or(Finding::Unknown { tried: 1 })
            }
            Finding::Speckles { .. } | Finding::Unknown { .. } => found,
        }
    }

    /// Returns the finding, or speckles if nothing was found. The pictures are whole.
    pub(super) fn or_speckles(&self, found: Finding, a: &Picture, b: &Picture) -> Finding {
        let Finding::Unknown { tried } = found else { return found };
        let tried = tried + usize::from(can_show(self));
        speckles(self, a, b).map_or(Finding::Unknown { tried }, |Speckles { pixels, rays }| {
            Finding::Speckles { pixels, rays }
        })
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Equal { cause, pixels: 0 } => {
                write!(f, "equals this program's picture{cause} (0 pixels differ)")
            }
            Self::Equal { cause, pixels: 1 } => {
                write!(f, "equals this program's picture{cause} (1 pixel differs, by one level)")
            }
            Self::Equal { cause, pixels } => {
                write!(f, "equals this program's picture{cause} ({pixels} pixels differ, by one level)")
            }
            Self::Part { cause, share } => {
                let percent = (100.0 * share).floor();
                write!(f, "at least this program's picture{cause}, which explains {percent:.0}% of the error")
            }
            Self::Speckles { pixels, rays } => {
                let (seen, meant) = match rays {
                    SelfHitting::Shadow => ("show shadow acne", "shadow rays"),
                    SelfHitting::Secondary => {
                        ("mirror or refract themselves", "reflected and refracted rays")
                    }
                    SelfHitting::All => ("shadow, mirror or refract themselves", "all secondary rays"),
                };
                write!(f, "{pixels} scattered pixels {seen}: epsilon is too small for {meant}")
            }
            Self::Unknown { tried } => write!(f, "none of {tried} tried"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tools::causes::Mistake::{GammaDecoded, GammaEncoded, Mirrored, UpsideDown};

    #[test]
    fn a_search_ends_with_its_cause_while_that_of_others_goes_on() {
        let picture = |level: u8| Picture::from_rgb(1, 1, vec![level; 3]);
        let made = |cause: Mistake| match cause {
            UpsideDown => Some(picture(50)),
            Mirrored => Some(picture(90)),
            GammaEncoded | GammaDecoded => None,
            _ => Some(picture(0)),
        };
        let causes = [UpsideDown, GammaEncoded, Mirrored];
        let wrong = [50, 90, 255].map(picture);
        let found = find_causes(causes.into_iter(), made, &wrong, &picture(0));
        let equal = |change| Finding::Equal { cause: change, pixels: 0 };
        assert_eq!(found, [equal(UpsideDown), equal(Mirrored), Finding::Unknown { tried: 2 }]);

        let all = causes.into_iter().chain([GammaDecoded]);
        let no_more = |cause| {
            assert_ne!(cause, GammaDecoded, "all are found");
            made(cause)
        };
        assert_eq!(find_causes(all, no_more, &wrong[..2], &picture(0)).len(), 2);
    }

    #[test]
    fn a_cause_that_makes_the_reference_is_not_tried() {
        let [own, wrong] = [0, 9].map(|level: u8| Picture::from_rgb(1, 1, vec![level; 3]));
        let causes = [UpsideDown, Mirrored].into_iter();
        let found = find_causes(causes, |_| Some(own.clone()), &[wrong], &own);
        assert_eq!(found, [Finding::Unknown { tried: 0 }]);
    }
}
