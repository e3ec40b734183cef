//! A comparison of two pictures.

use super::error::CliError;
use super::flags::Comparing;
use super::values::{lossy_or_null, picture, value};
use crate::tools::compare::Tolerance;
use clap::value_parser;
use serde::Serialize;
use std::path::PathBuf;

/// A comparison of two pictures. One that has no file is rendered, and not both are.
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
    pub(super) fn new(flags: &Comparing) -> Result<Option<Self>, CliError> {
        if flags.compare.is_none() && flags.reference.is_none() {
            return Ok(None);
        }
        let reference = flags.reference.as_ref();
        let reference = reference.map(|path| value("reference", path.as_os_str(), picture())).transpose()?;
        let (picture, difference) = (flags.compare.clone(), flags.difference.clone());
        Ok(Some(Self { picture, reference, difference, tolerance: tolerance(flags)? }))
    }

    /// Returns true if one of the pictures is to be rendered.
    pub fn needs_scene(&self) -> bool {
        self.picture.is_none() || self.reference.is_none()
    }
}

pub(super) fn tolerance(flags: &Comparing) -> Result<Option<Tolerance>, CliError> {
    let Some([levels, pixels]) = flags.tolerance.as_deref() else { return Ok(None) };
    Ok(Some(Tolerance {
        levels: value("tolerance", levels, value_parser!(u8))?,
        pixels: value("tolerance", pixels, value_parser!(u32))?.into(),
    }))
}
