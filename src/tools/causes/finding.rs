//! The explanation of a difference.

use super::mistakes::{Mistake, with_kind, with_kinds};
use super::student::SelfHitting;
use crate::tools::compare::Tolerance;
use serde::Serialize;
use std::fmt;

/// The explanation of a difference. `Display` writes it in one line.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "finding", rename_all = "snake_case")]
pub enum Finding {
    /// The mistake gives the picture, up to rounding at edges.
    Equal {
        /// The mistake.
        #[serde(rename = "mistake", serialize_with = "with_kind")]
        cause: Mistake,
        /// The mistakes that are made besides.
        #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "with_kinds")]
        also: Vec<Mistake>,
        /// Other mistakes that give the same picture.
        #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "with_kinds")]
        same: Vec<Mistake>,
        /// The number of pixels that still differ.
        pixels: u64,
        /// The number of these that differ by more than one level.
        by_more_than_one_level: u64,
        /// The number of the differing pixels at edges.
        at_edges: u64,
    },
    /// The mistake explains part of the difference.
    Part {
        /// The mistake that explains the most.
        #[serde(rename = "mistake", serialize_with = "with_kind")]
        cause: Mistake,
        /// The share of the wrong pixels that it makes right.
        share: f64,
    },
    /// A correct tracer in single precision differs by that much.
    Rounding {
        /// The number of pixels that differ.
        pixels: u64,
        /// The number of these at edges.
        at_edges: u64,
        /// A tolerance that accepts the difference.
        tolerance: Tolerance,
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

impl Finding {
    /// Returns the mistakes in words, as they complete "this program's picture". Empty if none is named.
    pub fn mistakes(&self) -> String {
        match self {
            Self::Equal { cause, also, same, .. } => {
                let also = also.iter().map(|other| format!(" and{other}"));
                let same = same.iter().map(|other| format!(", or{other}"));
                std::iter::once(cause.to_string()).chain(also).chain(same).collect()
            }
            Self::Part { cause, .. } => cause.to_string(),
            Self::Rounding { .. } | Self::Speckles { .. } | Self::Unknown { .. } => String::new(),
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mistakes = self.mistakes();
        match self {
            Self::Equal { pixels, by_more_than_one_level, at_edges, .. } => {
                let verb = if *pixels == 1 { "pixel differs" } else { "pixels differ" };
                let rest = match (pixels, by_more_than_one_level) {
                    (0, _) => String::new(),
                    (_, 0) => ", by one level".to_owned(),
                    _ => format!(", {at_edges} at edges"),
                };
                write!(f, "equals this program's picture{mistakes} ({pixels} {verb}{rest})")
            }
            Self::Part { share, .. } => {
                let percent = (100.0 * share).floor();
                write!(
                    f,
                    "in part this program's picture{mistakes}, which makes {percent:.0}% of the wrong pixels right"
                )
            }
            Self::Rounding { pixels, at_edges, tolerance } => {
                let noun = if *pixels == 1 { "pixel" } else { "pixels" };
                let Tolerance { levels, pixels: beyond } = tolerance;
                write!(
                    f,
                    "rounding of single precision: {pixels} {noun}, {at_edges} at edges; nothing to fix; \
                     `-tolerance {levels} {beyond}` accepts it"
                )
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
