//! The explanation of a difference.

use super::difference_kind::DifferenceKind;
use super::mistakes::Mistake;
use super::rounding::Residual;
use super::rules::SelfHitting;
use serde::Serialize;
use std::fmt;

/// The explanation of a difference. `Display` writes it in one line.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "finding", rename_all = "snake_case")]
pub enum Finding {
    /// The mistake gives the picture, up to rounding.
    Equal {
        /// The mistake.
        #[serde(rename = "mistake")]
        cause: Mistake,
        /// The mistakes that are made besides.
        #[serde(skip_serializing_if = "Vec::is_empty")]
        also: Vec<Mistake>,
        /// Other mistakes that give the same picture.
        #[serde(skip_serializing_if = "Vec::is_empty")]
        same: Vec<Mistake>,
        /// The pixels that still differ.
        #[serde(flatten)]
        rest: Rounded,
    },
    /// The mistake explains part of the difference.
    Part {
        /// The mistake that explains the most.
        #[serde(rename = "mistake")]
        cause: Mistake,
        /// The share of the wrong pixels that it makes right.
        share: f64,
    },
    /// Rounding explains most pixels, or all.
    Rounding {
        /// The pixels that differ.
        #[serde(flatten)]
        rest: Rounded,
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
        /// The kind of the difference, if the scene is known.
        #[serde(rename = "kind", skip_serializing_if = "Option::is_none")]
        difference: Option<Box<DifferenceKind>>,
    },
}

/// The pixels that differ, and the ones that rounding does not explain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rounded {
    /// The number of pixels that differ.
    pub pixels: usize,
    /// The number of these that rounding does not explain.
    pub unexplained: usize,
    /// The first of these from the top left: column and row.
    pub first: Option<[usize; 2]>,
    /// The course's own epsilon, if it explains some pixels.
    pub epsilon: Option<f64>,
    /// True if all pixels differ by one level at most.
    pub by_one_level: bool,
}

impl Rounded {
    /// Summarises a difference of a picture of this width.
    pub fn new(residual: &Residual, width: usize) -> Self {
        let place = |at: &usize| [at % width, at / width];
        Self {
            pixels: residual.differing,
            unexplained: residual.unexplained.len(),
            first: residual.unexplained.first().map(place),
            epsilon: residual.epsilon,
            by_one_level: residual.visible.is_empty(),
        }
    }
}

impl fmt::Display for Rounded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("rounding")?;
        if let Some(epsilon) = self.epsilon {
            write!(f, ", and the course's own epsilon of {epsilon}")?;
        }
        let noun = if self.pixels == 1 { "pixel" } else { "pixels" };
        match (self.unexplained, self.first) {
            (0, _) if self.by_one_level => write!(f, ": {} {noun} by one level", self.pixels),
            (0, _) if self.epsilon.is_some() => write!(f, ": {} {noun}", self.pixels),
            (0, _) if self.pixels == 1 => {
                f.write_str(": 1 pixel, equal to a view moved by less than 0.1 pixel")
            }
            (0, _) => {
                write!(f, ": {} pixels, each equal to a view moved by less than 0.1 pixel", self.pixels)
            }
            (1, Some([x, y])) => write!(f, ", and 1 pixel that it does not explain, at ({x}, {y})"),
            (count, first) => {
                write!(f, ", and {count} pixels that it does not explain")?;
                first.map_or(Ok(()), |[x, y]| write!(f, ", the first at ({x}, {y})"))
            }
        }
    }
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
            Self::Equal { rest: Rounded { pixels: 0, .. }, .. } => {
                write!(f, "equals this program's picture{mistakes} (0 pixels differ)")
            }
            Self::Equal { rest, .. } => write!(f, "this program's picture{mistakes} ({rest})"),
            Self::Part { share, .. } => {
                let percent = (100.0 * share).floor();
                write!(
                    f,
                    "in part this program's picture{mistakes}, which makes {percent:.0}% of the wrong pixels right"
                )
            }
            Self::Rounding { rest } if rest.unexplained == 0 => write!(f, "{rest}; nothing to fix"),
            Self::Rounding { rest } => rest.fmt(f),
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
            Self::Unknown { tried, difference: None } => write!(f, "none of {tried} tried"),
            Self::Unknown { tried, difference: Some(kind) } => write!(f, "none of {tried} tried; {kind}"),
        }
    }
}
