//! The flags about a comparison of two pictures.

use super::error::CliError;
use super::flags;
use super::raw::Raw;
use super::values::lossy_or_null;
use crate::tools::compare::Tolerance;
use serde::Serialize;
use std::path::PathBuf;

/// A comparison of two pictures. One that has no file is the rendered colour picture, and not both are.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Comparison {
    /// The picture in question.
    #[serde(serialize_with = "lossy_or_null")]
    pub picture: Option<PathBuf>,
    /// The picture to compare it with.
    #[serde(serialize_with = "lossy_or_null")]
    pub reference: Option<PathBuf>,
    /// The file of the picture that shows the difference.
    #[serde(serialize_with = "lossy_or_null")]
    pub difference: Option<PathBuf>,
    /// The difference that still passes; none if any passes.
    pub tolerance: Option<Tolerance>,
}

impl Comparison {
    /// The comparison that the flags ask for.
    pub(super) fn from_raw(raw: &Raw) -> Result<Option<Self>, CliError> {
        let (picture, reference) = (raw.read(&flags::COMPARE)?, raw.read(&flags::REFERENCE)?);
        let (difference, tolerance) = (raw.read(&flags::DIFFERENCE)?, raw.read(&flags::TOLERANCE)?);
        if picture.is_some() || reference.is_some() {
            return Ok(Some(Self { picture, reference, difference, tolerance }));
        }
        match (difference, tolerance) {
            (None, None) => Ok(None),
            (Some(_), _) => Err(CliError::ComparisonNeeded { flag: flags::DIFFERENCE.name }),
            (None, Some(_)) => Err(CliError::ComparisonNeeded { flag: flags::TOLERANCE.name }),
        }
    }

    /// Whether one of the pictures is to be rendered.
    pub fn needs_scene(&self) -> bool {
        self.picture.is_none() || self.reference.is_none()
    }
}
