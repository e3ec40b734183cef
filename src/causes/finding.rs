//! The search for the cause of a difference, and what it finds.

use super::{Cause, Original, speckles};
use crate::compare::{colors, largest_channel_difference, sum_of_squares};
use crate::picture::Picture;
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

impl Original<'_> {
    /// Why picture `a` differs from the reference `b`, where it does. Both are of the original's size.
    ///
    /// Tries every cause up to the first that makes the same picture, and leaves out those that make the reference.
    pub fn explain(&self, a: &Picture, b: &Picture) -> Finding {
        let whole = Distance::between(a, b);
        let (best, mut tried) = self.best_cause(a, b, &whole);
        if let Some((cause, rest)) = best {
            return match rest.visibly {
                0 if whole.visibly > 0 || rest.differing == 0 => {
                    Finding::Equal { cause, pixels: rest.differing }
                }
                _ => Finding::Part { cause, share: whole.share_gone(&rest) },
            };
        }
        tried += usize::from(speckles::can_show(self));
        speckles::count(self, a, b).map_or(Finding::Unknown { tried }, |pixels| Finding::Speckles { pixels })
    }

    /// The cause that leaves the least error of those that explain any, with the distance to its picture, and how
    /// many were tried.
    fn best_cause(&self, a: &Picture, b: &Picture, whole: &Distance) -> (Option<(Cause, Distance)>, usize) {
        let own = self.picture(Cause::Unchanged);
        let shows = |cause: Cause, picture: &Picture| {
            picture != b && (cause == Cause::Unchanged || Some(picture) != own.as_ref())
        };
        let (mut best, mut tried): (Option<(Cause, Distance)>, _) = (None, 0);
        for cause in Cause::all() {
            let Some(picture) = self.picture(cause).filter(|picture| shows(cause, picture)) else { continue };
            tried += 1;
            let rest = Distance::between(a, &picture);
            let is_better = best.is_none_or(|(_, best)| rest.squares < best.squares);
            if is_better && whole.is_explained(&rest) {
                best = Some((cause, rest));
            }
            if rest.differing == 0 {
                break;
            }
        }
        (best, tried)
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
                write!(f, "explains {percent:.0}% of the error: this program's picture{cause}")
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
