//! The flags of a page: the flags of the command line that shape a picture, within limits.

use super::http::Answer;
use super::limits::MAX_SIDE_PIXELS;
use crate::caster::choose::{Resolution, Structure};
use crate::cli::{self, Command, Options};
use std::ffi::OsString;

/// Returns the amounts that a picture asks for, each with its name and with the most that any command line may ask for
/// on a page. The longer side is the first.
fn amounts(options: &Options) -> [(&'static str, usize, usize); 5] {
    let samples = options.adaptive.map_or(options.sampler.count(), |adaptive| adaptive.most);
    let cells = match options.structure {
        Structure::Grid(Resolution::Cells(cells)) => cells.into_iter().product(),
        _ => 0,
    };
    let side = options.request().size.into_iter().fold(0, usize::max);
    [
        ("side", side, MAX_SIDE_PIXELS),
        ("samples", samples as usize, 1024),
        // Each may double the rays.
        ("bounces", options.effects.bounces as usize, 16),
        ("support", options.filter.support(), 16),
        ("cells", cells, 1 << 21),
    ]
}

/// The most that a picture may ask for, in the order of [`amounts`].
pub type Most = [usize; 5];

/// Returns the limits for pages of this command line, which may ask for more itself, and compares with a picture of
/// this size.
pub fn most(line: &Options, compared: [usize; 2]) -> Most {
    let mut most = amounts(line).map(|(_, asked, limit)| limit.max(asked));
    most[0] = most[0].max(compared[0]).max(compared[1]);
    most
}

/// Returns what these flags ask for. Errors: the message of the command line's parser, a flag that does more than shape
/// a picture, or more than the limits allow.
pub fn options(words: &[String], most: &Most) -> Result<Options, Answer> {
    let line = ["raytracer", "-input", "scene.txt", "-gui"];
    let line = line.into_iter().chain(words.iter().map(String::as_str)).map(OsString::from);
    let options = match cli::parse(line)? {
        // The page's words are those that shape a picture.
        Command::Render(options)
            if options.page.iter().any(|page| words.iter().all(|word| page.words.contains(word))) =>
        {
            *options
        }
        _ => return Err(Answer::text(422, "these flags cannot be given here")),
    };
    match amounts(&options).into_iter().zip(most).find(|((_, asked, _), most)| asked > *most) {
        Some(((name, asked, _), most)) => {
            let reason = format!("{name}: {asked} is more than this page allows, {most}");
            Err(Answer::text(422, &reason))
        }
        None => Ok(options),
    }
}
