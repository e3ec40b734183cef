//! The flags of a page: the flags of the command line that shape a picture, within limits.

use super::http::Response;
use super::limits::MAX_SIDE_PIXELS;
use crate::caster::choose::{Resolution, Structure};
use crate::cli::{self, Command, Options};
use serde::Serialize;
use std::ffi::OsString;

/// The amounts that a picture asks for, or the most of them that it may.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Amounts {
    /// The longer side in pixels.
    pub side: usize,
    samples: usize,
    bounces: usize,
    support: usize,
    /// The cells of a grid that the flags name.
    cells: usize,
}

/// The most that any command line may ask for on a page. Each bounce may double the rays.
const LIMITS: Amounts =
    Amounts { side: MAX_SIDE_PIXELS, samples: 1024, bounces: 16, support: 16, cells: 1 << 21 };

impl Amounts {
    /// Returns what a picture asks for.
    fn of(options: &Options) -> Self {
        let samples = options.adaptive.map_or(options.sampler.count(), |adaptive| adaptive.most);
        let cells = match options.structure {
            Structure::Grid(Resolution::Cells(cells)) => cells.into_iter().product(),
            _ => 0,
        };
        Self {
            side: options.request().size.into_iter().fold(0, usize::max),
            samples: samples as usize,
            bounces: options.effects.bounces as usize,
            support: options.filter.support(),
            cells,
        }
    }

    /// Returns the limits for pages of this command line, which may ask for more itself, and compares with a picture of
    /// this size.
    pub fn most(line: &Options, compared: [usize; 2]) -> Self {
        let asked = Self::of(line);
        Self {
            side: LIMITS.side.max(asked.side).max(compared[0]).max(compared[1]),
            samples: LIMITS.samples.max(asked.samples),
            bounces: LIMITS.bounces.max(asked.bounces),
            support: LIMITS.support.max(asked.support),
            cells: LIMITS.cells.max(asked.cells),
        }
    }

    fn named(self) -> [(&'static str, usize); 5] {
        let Self { side, samples, bounces, support, cells } = self;
        [("side", side), ("samples", samples), ("bounces", bounces), ("support", support), ("cells", cells)]
    }
}

/// Returns what these flags ask for. Errors: the message of the command line's parser, a flag that does more than shape
/// a picture, or more than the limits allow.
pub fn options(words: &[String], most: Amounts) -> Result<Options, Response> {
    let line = ["raytracer", "-input", "scene.txt", "-gui"];
    let line = line.into_iter().chain(words.iter().map(String::as_str)).map(OsString::from);
    let options = match cli::parse(line)? {
        // The page's words are those that shape a picture.
        Command::Render(options)
            if options.page.iter().any(|page| words.iter().all(|word| page.words.contains(word))) =>
        {
            *options
        }
        _ => return Err(Response::text(422, "these flags cannot be given here")),
    };
    for ((name, asked), (_, most)) in Amounts::of(&options).named().into_iter().zip(most.named()) {
        if asked > most {
            let reason = format!("{name}: {asked} is more than this page allows, {most}");
            return Err(Response::text(422, &reason));
        }
    }
    Ok(options)
}
