//! The search for the causes of differences, and what it finds.

use super::speckles::{Speckles, can_show};
use super::window::{part, telling_windows};
use super::{Cause, Original};
use crate::picture::Picture;
use crate::tools::compare::{colors, largest_channel_difference, sum_of_squares};
use serde::Serialize;
use std::fmt;

/// What explains a difference. `Display` gives the words of one line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "finding", rename_all = "snake_case")]
pub enum Finding {
    /// The mistake makes the same picture, up to one level.
    Equal {
        /// The mistake.
        #[serde(rename = "mistake")]
        cause: Cause,
        /// How many pixels still differ, by one level.
        pixels: u64,
    },
    /// The mistake is part of the reason.
    Part {
        /// The mistake that explains the most.
        #[serde(rename = "mistake")]
        cause: Cause,
        /// The share of the squared error that it explains.
        share: f64,
    },
    /// Shadow rays hit the surface that they leave.
    Speckles {
        /// How many pixels lie in a shadow of their own.
        pixels: usize,
    },
    /// None of the causes.
    Unknown {
        /// How many mistakes were tried.
        tried: usize,
    },
}

/// The share of the squared error that a partial cause explains at least.
const MIN_SHARE: f64 = 0.5;
/// The share of the differing pixels that a partial cause makes right at least. A change that merely comes closer on
/// the average, as a brighter picture does to a random one, makes none right.
const MIN_PIXELS: f64 = 0.25;
/// The share of the pixels that a cause changes which may be right in the picture in question. A mistake that was made
/// shows wherever it can.
const MAX_CONTRADICTED: f64 = 0.02;
/// Another cause leaves so many times the error at least.
const MIN_LEAD: f64 = 1.5;

/// How far two pictures are from each other.
#[derive(Clone, Copy, Debug)]
struct Distance {
    /// The sum over all channels of the differences' squares, in levels.
    squares: u64,
    differing: u64,
    /// Pixels that differ by more than one level.
    visibly: u64,
}

impl Distance {
    /// The pictures are of the same size.
    fn between(a: &Picture, b: &Picture) -> Self {
        let mut distance = Self { squares: 0, differing: 0, visibly: 0 };
        for (&a, &b) in colors(a).iter().zip(colors(b)).filter(|(a, b)| a != b) {
            distance.squares += sum_of_squares(a, b);
            distance.differing += 1;
            distance.visibly += u64::from(largest_channel_difference(a, b) > 1);
        }
        distance
    }

    /// The share of this error that is gone where `rest` is left.
    fn share_gone(&self, rest: &Self) -> f64 {
        1.0 - rest.squares as f64 / self.squares as f64
    }

    /// Whether so much is gone where `rest` is left that it is no accident.
    fn is_explained(&self, rest: &Self) -> bool {
        let (before, after) =
            if self.visibly > 0 { (self.visibly, rest.visibly) } else { (self.differing, rest.differing) };
        self.share_gone(rest) >= MIN_SHARE && after as f64 <= (1.0 - MIN_PIXELS) * before as f64
    }
}

/// Whether the picture is right in too many of the pixels that a cause changes. `levels` is a difference that does not
/// count.
fn is_contradicted(picture: &Picture, made: &Picture, reference: &Picture, levels: u8) -> bool {
    let differs = |a, b| largest_channel_difference(a, b) > levels;
    let (mut changed, mut contradicted) = (0_u64, 0_u64);
    for ((&seen, &made), &right) in colors(picture).iter().zip(colors(made)).zip(colors(reference)) {
        if differs(made, right) {
            changed += 1;
            contradicted += u64::from(!differs(seen, right) && differs(seen, made));
        }
    }
    contradicted as f64 > MAX_CONTRADICTED * changed as f64
}

/// A cause that explains a part of the difference at least, and what its picture leaves of it.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    cause: Cause,
    rest: Distance,
}

/// The search for what makes one picture.
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

    fn try_cause(&mut self, cause: Cause, made: &Picture) {
        self.tried += 1;
        let rest = Distance::between(self.picture, made);
        self.is_over = rest.differing == 0;
        let levels = u8::from(self.whole.visibly > 0);
        let is_candidate = self.whole.is_explained(&rest)
            && (self.is_over || !is_contradicted(self.picture, made, self.reference, levels));
        if is_candidate {
            self.candidates.push(Candidate { cause, rest });
        }
    }

    fn finding(&self) -> Finding {
        let Self { whole, tried, .. } = *self;
        // Of equally good ones the first is taken.
        let Some(best) = self.candidates.iter().min_by_key(|candidate| candidate.rest.squares) else {
            return Finding::Unknown { tried };
        };
        let &Candidate { cause, rest } = best;
        match rest.visibly {
            0 if whole.visibly > 0 || rest.differing == 0 => Finding::Equal { cause, pixels: rest.differing },
            _ if !self.leads(best) => Finding::Unknown { tried },
            _ => Finding::Part { cause, share: whole.share_gone(&rest) },
        }
    }

    /// Whether no cause of another kind explains about as much.
    fn leads(&self, best: &Candidate) -> bool {
        let others = self.candidates.iter().filter(|other| !other.cause.is_akin(best.cause));
        let bound = MIN_LEAD * best.rest.squares as f64;
        others.map(|other| other.rest.squares as f64).all(|squares| squares >= bound)
    }
}

/// Why each wrong picture differs from the reference `b`. All are of one size.
///
/// Each cause is tried on all pictures, so that what it makes is made once. The search ends with the first cause that
/// makes the same picture, and leaves out those that make the reference.
pub fn find_causes(
    causes: impl Iterator<Item = Cause>,
    picture: impl Fn(Cause) -> Option<Picture>,
    wrong: &[Picture],
    b: &Picture,
) -> Vec<Finding> {
    let own = picture(Cause::Unchanged);
    let shows = |cause: Cause, picture: &Picture| {
        picture != b && (cause == Cause::Unchanged || Some(picture) != own.as_ref())
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
    /// Why picture `a` differs from the reference `b`, where it does. Both are of the original's size.
    pub fn explain(&self, a: &Picture, b: &Picture) -> Finding {
        let found = self.explain_all(std::slice::from_ref(a), b);
        found.first().copied().unwrap_or(Finding::Unknown { tried: 0 })
    }

    /// Why each wrong picture differs from the reference `b`. All are of the original's size.
    pub fn explain_all(&self, wrong: &[Picture], b: &Picture) -> Vec<Finding> {
        let found = find_causes(Cause::all(), |cause| self.picture(cause), wrong, b);
        let speckles = Speckles::new(self);
        found.into_iter().zip(wrong).map(|(found, a)| self.or_speckles(found, &speckles, a, b)).collect()
    }

    /// Why each wrong picture differs from the reference `b`, as judged by a small part of it where many pixels
    /// differ: a window of some two thousand camera rays. All are of the original's size. None of a picture whose
    /// difference lies elsewhere than that of the others.
    pub fn explain_parts(&mut self, wrong: &[Picture], b: &Picture) -> Vec<Option<Finding>> {
        let mut findings = vec![None; wrong.len()];
        for telling in telling_windows(wrong, b, self.request.sampler) {
            let parts: Vec<Picture> =
                telling.pictures.iter().map(|&picture| part(&wrong[picture], telling.window)).collect();
            self.request.window = Some(telling.window);
            let picture = |cause| self.picture(cause);
            let found = find_causes(Cause::all(), picture, &parts, &part(b, telling.window));
            let speckles = Speckles::new(self);
            for (&picture, found) in telling.pictures.iter().zip(found) {
                findings[picture] = Some(self.or_speckles(found, &speckles, &wrong[picture], b));
            }
        }
        self.request.window = None;
        findings
    }

    /// What is found, or speckles if that is nothing. The pictures are whole.
    fn or_speckles(&self, found: Finding, speckles: &Speckles, a: &Picture, b: &Picture) -> Finding {
        let Finding::Unknown { tried } = found else { return found };
        let tried = tried + usize::from(can_show(self));
        speckles.count(a, b).map_or(Finding::Unknown { tried }, |pixels| Finding::Speckles { pixels })
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
            Self::Speckles { pixels } => {
                write!(
                    f,
                    "{pixels} scattered pixels lie in a shadow of their own: epsilon is too small for shadow rays"
                )
            }
            Self::Unknown { tried } => write!(f, "none of {tried} tried"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tools::causes::PixelChange::{GammaDecoded, GammaEncoded, Mirrored, UpsideDown};

    #[test]
    fn a_search_ends_with_its_cause_while_that_of_others_goes_on() {
        let picture = |level: u8| Picture::from_rgb(1, 1, vec![level; 3]);
        let made = |cause: Cause| match cause {
            Cause::Pixels(UpsideDown) => Some(picture(50)),
            Cause::Pixels(Mirrored) => Some(picture(90)),
            Cause::Pixels(_) => None,
            _ => Some(picture(0)),
        };
        let causes = [UpsideDown, GammaEncoded, Mirrored].map(Cause::Pixels);
        let wrong = [50, 90, 255].map(picture);
        let found = find_causes(causes.into_iter(), made, &wrong, &picture(0));
        let equal = |change| Finding::Equal { cause: Cause::Pixels(change), pixels: 0 };
        assert_eq!(found, [equal(UpsideDown), equal(Mirrored), Finding::Unknown { tried: 2 }]);

        let all = causes.into_iter().chain([Cause::Pixels(GammaDecoded)]);
        let no_more = |cause| {
            assert_ne!(cause, Cause::Pixels(GammaDecoded), "all are found");
            made(cause)
        };
        assert_eq!(find_causes(all, no_more, &wrong[..2], &picture(0)).len(), 2);
    }

    #[test]
    fn a_cause_that_makes_the_reference_is_not_tried() {
        let [own, wrong] = [0, 9].map(|level: u8| Picture::from_rgb(1, 1, vec![level; 3]));
        let causes = [UpsideDown, Mirrored].map(Cause::Pixels).into_iter();
        let found = find_causes(causes, |_| Some(own.clone()), &[wrong], &own);
        assert_eq!(found, [Finding::Unknown { tried: 0 }]);
    }
}
