//! The flags about a comparison of two pictures.

use super::error::CliError;
use super::flags;
use super::raw::Raw;
use super::values::{bad, byte_picture_name, lossy_or_null, picture_name, whole};
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
        let file = |flag| raw.values(flag)?.map(|[word]| picture_name(flag, word)).transpose();
        let (picture, reference) = (file(&flags::COMPARE)?, file(&flags::REFERENCE)?);
        let difference = |[word]: [_; 1]| byte_picture_name(&flags::DIFFERENCE, word);
        let (difference, tolerance) =
            (raw.values(&flags::DIFFERENCE)?.map(difference).transpose()?, tolerance(raw)?);
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

/// The difference that still passes.
pub(super) fn tolerance(raw: &Raw) -> Result<Option<Tolerance>, CliError> {
    let Some([levels, pixels]) = raw.values(&flags::TOLERANCE)? else { return Ok(None) };
    let number = |word, range| whole(word, range).map_err(|problem| bad(&flags::TOLERANCE, word, problem));
    let levels = number(levels, (0, u32::from(u8::MAX)))?;
    Ok(Some(Tolerance { levels: levels as u8, pixels: number(pixels, (0, u32::MAX))?.into() }))
}
