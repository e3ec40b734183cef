//! The pictures to write: what each shows, and where it goes.

use super::error::{CliError, Problem};
use super::flags::{self, Flag};
use super::options::SIZE_RANGE;
use super::raw::Raw;
use super::values::{bad, finite, lossy, picture_file, whole};
use crate::image_io::Format;
use crate::render::{Cost, Layer};
use serde::Serialize;
use std::ffi::OsStr;
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
    let outputs = [
        picture(raw, &flags::OUTPUT, [Layer::Color; 2])?,
        depth(raw)?,
        picture(raw, &flags::NORMALS, [Layer::Normals, Layer::SignedNormals])?,
        enlarged(raw, &flags::RENDER_SAMPLES, |zoom| Layer::Samples { zoom })?,
        enlarged(raw, &flags::RENDER_FILTER, |zoom| Layer::Filter { zoom })?,
        cost_map(raw)?,
    ];
    Ok(outputs.into_iter().flatten().collect())
}

/// The layers are that of a picture of bytes and that of floating-point numbers.
fn picture(raw: &Raw, flag: &Flag, layers: [Layer; 2]) -> Result<Option<Output>, CliError> {
    let Some(([word], format)) = raw.picture_values(flag)? else { return Ok(None) };
    output(flag, word, format, layers).map(Some)
}

fn output(flag: &Flag, name: &OsStr, format: Option<&OsStr>, layers: [Layer; 2]) -> Result<Output, CliError> {
    let (file, format) = picture_file(flag, name, format)?;
    Ok(Output { layer: layers[usize::from(format.is_float())], file, format })
}

fn depth(raw: &Raw) -> Result<Option<Output>, CliError> {
    let Some(([from, to, file], format)) = raw.picture_values(&flags::DEPTH)? else { return Ok(None) };
    let (near, far) = (finite(&flags::DEPTH, from)?, finite(&flags::DEPTH, to)?);
    if near >= far {
        return Err(CliError::DepthOrder { t0: near, t1: far });
    }
    // The greys divide by the difference.
    if !(far - near).is_finite() {
        return Err(CliError::DepthRange);
    }
    output(&flags::DEPTH, file, format, [Layer::Depth { near, far }, Layer::Distance]).map(Some)
}

fn cost_map(raw: &Raw) -> Result<Option<Output>, CliError> {
    let Some(([kind, file], format)) = raw.picture_values(&flags::COST_MAP)? else { return Ok(None) };
    let cost = match kind.to_str() {
        Some("rays") => Cost::Rays,
        Some("tests") => Cost::Tests,
        Some("cells") => Cost::Cells,
        _ => return Err(bad(&flags::COST_MAP, kind, Problem::NotCost)),
    };
    let map = output(&flags::COST_MAP, file, format, [Layer::Cost(cost); 2])?;
    // A picture in false colours has nothing beyond bytes.
    if map.format.is_float() {
        Err(bad(&flags::COST_MAP, format.unwrap_or(file), Problem::NotBytes))
    } else {
        Ok(Some(map))
    }
}

fn enlarged(raw: &Raw, flag: &Flag, layer: fn(usize) -> Layer) -> Result<Option<Output>, CliError> {
    let Some(([file, zoom], format)) = raw.picture_values(flag)? else { return Ok(None) };
    let zoom = whole(zoom, (1, SIZE_RANGE.1)).map_err(|problem| bad(flag, zoom, problem))? as usize;
    output(flag, file, format, [layer(zoom); 2]).map(Some)
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
