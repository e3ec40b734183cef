//! The pictures to write: what each shows, and where it goes.

use super::error::{CliError, Problem};
use super::flag::Flag;
use super::flags;
use super::raw::Raw;
use super::values::lossy;
use crate::image_io::Format;
use crate::render::Layer;
use serde::Serialize;
use std::path::{Path, PathBuf, absolute};

/// A picture to write.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Output {
    /// What it shows. Depths and their difference are finite, and the sides of an enlarged picture are below 65536.
    #[serde(flatten)]
    pub layer: Layer,
    /// The picture's file, or `-` for standard output.
    #[serde(serialize_with = "lossy")]
    pub file: PathBuf,
    /// How it is written. Only layers that are rendered colours are written as floating-point numbers.
    pub format: Format,
}

impl Output {
    /// Whether it goes to standard output.
    pub fn is_standard_output(&self) -> bool {
        self.file == Path::new("-")
    }

    /// The flag that asks for it.
    pub(super) fn flag(&self) -> &'static Flag {
        match self.layer {
            Layer::Color => &flags::OUTPUT,
            Layer::Depth { .. } | Layer::Distance => &flags::DEPTH,
            Layer::Normals | Layer::SignedNormals => &flags::NORMALS,
            Layer::Samples { .. } => &flags::RENDER_SAMPLES,
            Layer::Cost(_) => &flags::COST_MAP,
            Layer::Filter { .. } => &flags::RENDER_FILTER,
        }
    }
}

/// The pictures that the flags ask for, in the order of the help.
pub(super) fn outputs(raw: &Raw) -> Result<Vec<Output>, CliError> {
    let flags = [
        &flags::OUTPUT,
        &flags::DEPTH,
        &flags::NORMALS,
        &flags::RENDER_SAMPLES,
        &flags::RENDER_FILTER,
        &flags::COST_MAP,
    ];
    flags.into_iter().filter_map(|flag| raw.read(flag).transpose()).collect()
}

/// The picture of bytes that `-output` asks for, which `flag` needs.
pub(super) fn output_of_bytes(raw: &Raw, flag: &'static Flag) -> Result<Output, CliError> {
    let needed = || CliError::Needed { flag: flag.name, needed: flags::OUTPUT.usage() };
    let values = raw.values(&flags::OUTPUT).ok_or_else(needed)?;
    let output = (flags::OUTPUT.read)(&values)?;
    match values.words.last() {
        Some(word) if output.format.is_float() => Err(values.bad(word, Problem::NotBytes)),
        _ => Ok(output),
    }
}

/// Compares full paths, not the file system: links that lead to one file are found when the files are at hand.
pub(super) fn distinct(files: &[(&'static Flag, &Path)]) -> Result<(), CliError> {
    let full = |path: &Path| absolute(path).unwrap_or_else(|_| path.to_owned());
    for (i, &(flag, file)) in files.iter().enumerate() {
        if let Some((other, _)) = files[i + 1..].iter().find(|(_, later)| full(later) == full(file)) {
            if file == Path::new("-") {
                return Err(CliError::SameStream { flag: flag.name, other: other.name });
            }
            return Err(CliError::SameFile { flag: flag.name, other: other.name, file: file.to_owned() });
        }
    }
    Ok(())
}
