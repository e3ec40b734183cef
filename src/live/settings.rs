//! What the page's controls say, as flags of a command line: checked as those of the program, and limited.

use super::http::Answer;
use super::limits::MAX_SIDE;
use crate::base::shell::Shell;
use crate::caster::choose::{Resolution, Structure};
use crate::cli::{self, Command, Options, ShowProgress};
use crate::render::Cost;
use serde_json::Value;
use std::ffi::OsString;
use std::path::Path;

/// What a picture may ask for at most, with the names by which the page knows these limits, and those of messages.
const LIMITS: [(usize, &str, &str); 5] = [
    (MAX_SIDE, "side", "-size"),
    (1024, "samples", "the number of samples"),
    // Each may double the rays.
    (16, "bounces", "-bounces"),
    (16, "support", "the filter's support"),
    (1 << 21, "cells", "the number of the grid's cells"),
];

/// Returns what a picture asks for, in the order of [`LIMITS`].
fn amounts(options: &Options) -> [usize; 5] {
    let samples = options.adaptive.map_or(options.sampler.count(), |adaptive| adaptive.most);
    let cells = match options.structure {
        Structure::Grid(Resolution::Cells(cells)) => cells.into_iter().product(),
        _ => 0,
    };
    let side = options.request().size.into_iter().fold(0, usize::max);
    [side, samples as usize, options.effects.bounces as usize, options.filter.support(), cells]
}

/// The most that a picture may ask for: what the command line asks for, or the limits of any page.
pub struct Most([usize; 5]);

impl Most {
    /// The limits for pages of this command line, which compares with a picture of this size.
    pub fn of(line: &Options, compared: [usize; 2]) -> Self {
        let mut most = amounts(line);
        most[0] = most[0].max(compared[0]).max(compared[1]);
        most.iter_mut().zip(LIMITS).for_each(|(most, (limit, ..))| *most = limit.max(*most));
        Self(most)
    }

    /// The longest side of a picture.
    pub fn side(&self) -> usize {
        self.0[0]
    }

    pub fn to_json(&self) -> Value {
        self.0.iter().zip(LIMITS).map(|(&most, (_, name, _))| (name.to_owned(), Value::from(most))).collect()
    }

    /// Returns what these flags ask for. Errors: the message of the command line's parser, a flag that a page cannot
    /// give, or more than the limits allow.
    pub fn options(&self, words: &[String]) -> Result<Options, Answer> {
        let line = ["raytracer", "-input", "scene.txt"].into_iter().chain(words.iter().map(String::as_str));
        let options = match cli::parse(line.map(OsString::from))? {
            Command::Render(options) if shapes_a_picture(&options) => *options,
            _ => return Err(Answer::impossible("these flags cannot be given here")),
        };
        for ((value, most), (_, _, name)) in amounts(&options).into_iter().zip(self.0).zip(LIMITS) {
            if value > most {
                let reason = format!("{name}: {value} is more than this page allows, {most}");
                return Err(Answer::impossible(reason));
            }
        }
        Ok(options)
    }
}

/// Returns true if the options do nothing but shape a picture: no file is named, and nothing else is asked for.
fn shapes_a_picture(options: &Options) -> bool {
    let does_more = options.stats || options.strict || options.preview;
    let has_value = options.region.is_some()
        || options.repeat.is_some()
        || options.comparison.is_some()
        || options.json.is_some()
        || options.pixel.is_some()
        || options.page.is_some()
        || options.threads.is_some();
    !does_more && !has_value && options.outputs.is_empty() && options.progress == ShowProgress::OnTerminal
}

/// Returns the command line that writes a picture.
pub fn command_line(input: &Path, words: &[String], cost: Option<Cost>, output: Option<&Path>) -> String {
    let name = |path: &Path| path.to_string_lossy().into_owned();
    let output = output.map_or("picture.png".into(), name);
    let kind = match cost {
        None => vec!["-output"],
        Some(Cost::Rays) => vec!["-cost_map", "rays"],
        Some(Cost::Tests) => vec!["-cost_map", "tests"],
        Some(Cost::Cells) => vec!["-cost_map", "cells"],
    };
    let head = ["raytracer".to_owned(), "-input".to_owned(), name(input)];
    let tail = kind.into_iter().map(str::to_owned).chain([output]);
    let words = head.into_iter().chain(words.iter().cloned()).chain(tail);
    words.map(|word| Shell::OF_SYSTEM.word(word)).collect::<Vec<_>>().join(" ")
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
    fn flags_that_shape_a_picture_are_understood() {
        let most = Most::of(&line(""), [0; 2]);
        for flags in [
            "",
            "-size 7 9 -shadows -shade_back -bounces 3 -weight .1 -grid auto -visualize_grid",
            "-transparent_shadows -jittered_samples 9 -seed 3 -gaussian_filter .5 -grid 3 4 5",
            "-adaptive_samples 64 1 -mitchell_filter 2",
        ] {
            assert_eq!(
                most.options(&words(flags)),
                Ok(Options { input: Some("scene.txt".into()), ..line(flags) })
            );
        }
    }

    #[test]
    fn no_flag_reaches_a_file_or_starts_anything_else() {
        let most = Most::of(&line(""), [0; 2]);
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
            "a.png",
        ] {
            assert!(most.options(&words(flags)).is_err(), "{flags}");
        }
    }

    #[test]
    fn the_limits_are_those_of_the_page_or_of_the_line() {
        let message = "-bounces: 17 is more than this page allows, 16";
        let too_much = words("-bounces 17");
        assert_eq!(Most::of(&line(""), [0; 2]).options(&too_much), Err(Answer::impossible(message)));
        assert!(Most::of(&line("-bounces 17"), [0; 2]).options(&too_much).is_ok());
        for flags in [
            "-size 4 2049",
            "-random_samples 1025",
            "-box_filter 17",
            "-grid 1000 1000 3",
            "-size 70000 1",
            "-bounces x",
        ] {
            assert!(Most::of(&line(""), [0; 2]).options(&words(flags)).is_err(), "{flags}");
        }
    }

    #[test]
    fn the_command_line_can_be_copied() {
        let shown = command_line(Path::new("my scenes/a.txt"), &words("-size 7 9"), None, None);
        let scene = if cfg!(windows) { "\"my scenes/a.txt\"" } else { "'my scenes/a.txt'" };
        assert_eq!(shown, format!("raytracer -input {scene} -size 7 9 -output picture.png"));
        let shown = command_line(Path::new("a.txt"), &[], Some(Cost::Tests), Some(Path::new("c.png")));
        assert_eq!(shown, "raytracer -input a.txt -cost_map tests c.png");
    }
}
