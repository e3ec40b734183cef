//! The pictures to write: what each shows, and where it goes.

use super::error::{fail, invalid, unexpected, value};
use super::flags::Flags;
use super::values::{FINITE, SIDES, lossy, must_end_in, number};
use crate::base::stdio::{STDIO, is_stdio};
use crate::diagnostic::Diagnostic;
use crate::image_io::Format;
use crate::render::{Cost, Layer};
use clap::value_parser;
use serde::Serialize;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// A picture to write.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Output {
    /// The layer that it shows. Depths and their difference are finite, and the sides of an enlarged picture are below
    /// 65536.
    #[serde(flatten)]
    pub layer: Layer,
    /// The picture's file, or `-` for standard output.
    #[serde(serialize_with = "lossy")]
    pub file: PathBuf,
    /// Only layers of rendered colours are written as floating-point numbers.
    pub format: Format,
}

impl Output {
    /// Reads a file's name, and the name of the format after it if the file's has no ending of a picture. `-` and
    /// `/dev/stdout` are standard output.
    fn new(flag: &str, values: &[OsString], [of_bytes, of_floats]: [Layer; 2]) -> Result<Self, Diagnostic> {
        let name = values.first().cloned().unwrap_or_default();
        let is_standard_output = name == STDIO || name == "/dev/stdout";
        let format = match (Format::of(Path::new(&name)), values.get(1)) {
            (Some(format), None) => format,
            (Some(_), Some(word)) => return unexpected(word),
            (None, Some(word)) => match Format::named(&word.to_string_lossy()) {
                Some(format) => format,
                None => return invalid(flag, word, &format!("must be {}", Format::WRITTEN.replace('.', ""))),
            },
            (None, None) => {
                return match is_standard_output {
                    true => invalid(flag, name, "needs its format after it, as in '- png'"),
                    false => invalid(flag, name, &must_end_in(Format::WRITTEN)),
                };
            }
        };
        let file = if is_standard_output { STDIO.into() } else { PathBuf::from(name) };
        let layer = if format.is_float() { of_floats } else { of_bytes };
        Ok(Self { layer, file, format })
    }

    /// Refuses a picture in floating point.
    fn of_bytes(self, flag: &str) -> Result<Self, Diagnostic> {
        if self.format.is_float() { invalid(flag, &self.file, &must_end_in(Format::BYTES)) } else { Ok(self) }
    }

    /// Returns true if it goes to standard output.
    pub fn is_standard_output(&self) -> bool {
        is_stdio(&self.file)
    }
}

/// Returns the pictures that the flags ask for, in the order of the help. `size` is the value of `-size`.
pub(super) fn outputs(flags: &Flags, size: [usize; 2]) -> Result<Vec<Output>, Diagnostic> {
    let normals = |values: &_| Output::new("normals", values, [Layer::Normals, Layer::SignedNormals]);
    let samples = |values: &_| enlarged("render_samples", values, size, |zoom| Layer::Samples { zoom });
    let filter = |values: &_| enlarged("render_filter", values, size, |zoom| Layer::Filter { zoom });
    let all = [
        flags.output.as_deref().map(colors),
        flags.depth.as_deref().map(depth),
        flags.normals.as_deref().map(normals),
        flags.render_samples.as_deref().map(samples),
        flags.render_filter.as_deref().map(filter),
        flags.cost_map.as_deref().map(cost_map),
    ];
    all.into_iter().flatten().collect()
}

/// Returns the picture of bytes that `-output` asks for, which clap has required.
pub(super) fn output_of_bytes(flags: &Flags) -> Result<Output, Diagnostic> {
    colors(flags.output.as_deref().unwrap_or_default())?.of_bytes("output")
}

fn colors(values: &[OsString]) -> Result<Output, Diagnostic> {
    Output::new("output", values, [Layer::Color; 2])
}

fn depth(values: &[OsString]) -> Result<Output, Diagnostic> {
    let (ends, picture) = values.split_at(2);
    let end = |index: usize| value("depth", &ends[index], number(FINITE));
    let (near, far) = (end(0)?, end(1)?);
    if near >= far {
        return fail(format!("-depth: t0 must be less than t1, but {near} >= {far}"));
    }
    // The greys divide by the difference.
    if !(far - near).is_finite() {
        return fail("-depth: t1 - t0 is too large for a number");
    }
    Output::new("depth", picture, [Layer::Depth { near, far }, Layer::Distance])
}

/// Returns a picture with enlarged pixels, whose `layer` has the last value as its zoom.
fn enlarged(
    flag: &str,
    values: &[OsString],
    size: [usize; 2],
    layer: fn(usize) -> Layer,
) -> Result<Output, Diagnostic> {
    let (picture, last) = values.split_at(values.len() - 1);
    if picture.len() > 1 && Format::of(Path::new(&picture[0])).is_some() {
        return unexpected(&last[0]);
    }
    let layer = layer(value(flag, &last[0], value_parser!(u16).range(1..))?.into());
    if !layer.size(size).iter().all(|side| SIDES.contains(side)) {
        return fail(format!("-{flag}: the enlarged picture has more than 65535 pixels a side"));
    }
    Output::new(flag, picture, [layer; 2])
}

fn cost_map(values: &[OsString]) -> Result<Output, Diagnostic> {
    let cost = match values[0].to_str() {
        Some("rays") => Cost::Rays,
        Some("tests") => Cost::Tests,
        Some("cells") => Cost::Cells,
        _ => return invalid("cost_map", &values[0], "must be rays, tests or cells"),
    };
    // A picture in false colours has nothing beyond bytes.
    Output::new("cost_map", &values[1..], [Layer::Cost(cost); 2])?.of_bytes("cost_map")
}
