//! The flags of a page: the flags of the command line that shape a picture, within limits.

use super::http::Answer;
use super::limits::MAX_SIDE;
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
        ("side", side, MAX_SIDE),
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

#[cfg(test)]
mod tests {
    use super::*;

    fn words(line: &str) -> Vec<String> {
        line.split_whitespace().map(str::to_owned).collect()
    }

    fn line(flags: &str) -> Options {
        let all = format!("raytracer -input s.txt {flags}");
        match cli::parse(all.split_whitespace().map(OsString::from)) {
            Ok(Command::Render(options)) => *options,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn no_flag_reaches_a_file_or_starts_anything_else() {
        let most = most(&line(""), [0; 2]);
        for flags in [
            "-output a.png",
            "-depth 1 2 a.png",
            "-normals a.png",
            "-cost_map rays a.png",
            "-render_samples a.png 3",
            "-compare a.png",
            "-reference a.png",
            "-json -",
            "-stats",
            "-pixel 0 0",
            "-gui",
            "-gui -port 80",
            "-gouraud",
            "-threads 4096",
            "-repeat 3",
            "-region 0 0 1 1",
            "-strict",
            "-progress",
            "-quiet",
            "-merge a.png",
            "-help",
            "-version",
            "-input other.txt",
            "--output a.png",
            "-bounces=3 -stats",
            "a.png",
        ] {
            assert!(options(&words(flags), &most).is_err(), "{flags}");
        }
    }

    #[test]
    fn the_limits_are_those_of_the_page_or_of_the_line() {
        let message = "bounces: 17 is more than this page allows, 16";
        let too_much = words("-bounces 17");
        assert_eq!(options(&too_much, &most(&line(""), [0; 2])), Err(Answer::text(422, message)));
        assert!(options(&too_much, &most(&line("-bounces 17"), [0; 2])).is_ok());
        for flags in [
            "-size 4 2049",
            "-random_samples 1025",
            "-box_filter 17",
            "-grid 1000 1000 3",
            "-size 70000 1",
            "-bounces x",
        ] {
            assert!(options(&words(flags), &most(&line(""), [0; 2])).is_err(), "{flags}");
        }
    }
}
