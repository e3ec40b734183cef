//! The help: about the usual flags, all flags, one of them, or those with a word.

use super::error::of_clap;
use super::flags::{command, find, meant};
use super::words::single;
use crate::diagnostic::Diagnostic;
use clap::{Arg, Id};
use std::ffi::OsString;

/// The length of the longest lines in characters, on a terminal that has room for it.
const WIDTH: usize = 80;
/// The characters that clap reserves before each flag for a short one. No flag has a short one.
const ROOM: usize = 5;

const USUAL_TAIL: &str =
    "-help lists all flags, -help size explains one, and -help shadow lists the flags with this word.";

const TAIL: &str = "Examples:
  raytracer -input spheres.txt -size 200 200 -output spheres.tga
            -shadows -bounces 3 -weight 0.01
  raytracer -input plane.txt -size 200 200 -output plane.png
            -depth 8 20 depth.tga -normals normals.tga

The exit status is 1 for a file that cannot be read or written and for an error in the scene, \
2 for an error in the command line, 3 for a difference above -tolerance or a -target that is not \
reached, and 130, 143 or 129 for a run stopped by Ctrl-C, SIGTERM or SIGHUP.";

/// Returns the length of the longest lines on this terminal.
pub(super) fn width() -> usize {
    terminal_size::terminal_size().map_or(WIDTH, |(width, _)| WIDTH.min(width.0.into()))
}

/// Returns the help that `words` ask for, which have clap's dashes, in lines of at most `width` characters. The first
/// word is `--h` or `--help`, and the next may tell what about.
pub(super) fn text(words: &[OsString], width: usize) -> Result<String, Diagnostic> {
    let topic = words.get(1).map(|word| word.to_string_lossy());
    match topic.filter(|word| !word.starts_with('-') || known(bare(word)).is_some()) {
        Some(topic) => about(bare(&topic), width),
        None if words[0] == "--h" => Ok(usual(width)),
        None => Ok(show(command(), width) + &tail(TAIL, width)),
    }
}

/// Returns the first sentences about the usual flags, on one screen.
fn usual(width: usize) -> String {
    let mut built = command();
    built.build();
    let usual = |name: &Id| {
        built.get_groups().any(|group| group.get_id() == "usual" && group.get_args().any(|id| id == name))
    };
    let usual = command().mut_args(|flag| {
        let is_hidden = !usual(flag.get_id());
        let help = summary(&flag);
        let flag = flag.help(help).hide(is_hidden).help_heading("Usual flags");
        // The name of a format after the picture's would leave no room beside it.
        if flag.get_id() == "output" { flag.num_args(1).value_names(["picture"]) } else { flag }
    });
    show(usual, width) + &tail(USUAL_TAIL, width)
}

/// Returns the first sentence about a flag.
fn summary(flag: &Arg) -> String {
    let help = flag.get_help().map(ToString::to_string).unwrap_or_default();
    help.split(". ").next().unwrap_or_default().to_owned()
}

/// Returns the whole help of the flag with this name, here or in other programs; otherwise the flags with this word.
fn about(name: &str, width: usize) -> Result<String, Diagnostic> {
    if let Some(flag) = known(name) {
        let some = only(|other| other.get_id() == flag.get_id()).term_width(width + ROOM);
        let mut some = with_three_cells(some);
        return Ok(single_dashes(&some.render_long_help().to_string()));
    }
    let has_part = |text: String| text.to_lowercase().contains(&name.to_lowercase());
    let has_word = |flag: &Arg| {
        let help = [flag.get_help(), flag.get_long_help()].into_iter().flatten().map(ToString::to_string);
        let names = flag.get_all_aliases().into_iter().flatten().map(str::to_owned);
        help.chain(names).chain([flag.get_id().to_string()]).any(has_part)
    };
    // clap's error of an unknown flag has a suggestion.
    let words = [OsString::from(format!("--{name}"))];
    match command().try_get_matches_from(&words) {
        Err(error) if !command().get_arguments().any(has_word) => Err(of_clap(error, &words)),
        _ => Ok(show(only(has_word), width)),
    }
}

fn bare(word: &str) -> &str {
    word.trim_start_matches('-')
}

/// Returns the flag with this name, here or in other programs.
fn known(name: &str) -> Option<Arg> {
    find(name).or_else(|| find(meant(name)?))
}

/// Returns the command with these flags alone, and no text around them.
fn only(is_shown: impl Fn(&Arg) -> bool) -> clap::Command {
    command().help_template("{options}\n").mut_args(|flag| {
        let is_hidden = !is_shown(&flag);
        flag.hide(is_hidden)
    })
}

fn show(command: clap::Command, width: usize) -> String {
    single_dashes(&with_three_cells(command).term_width(width + ROOM).render_help().to_string())
}

/// Wraps a text below the flags, after an empty line.
fn tail(text: &'static str, width: usize) -> String {
    let mut lines = clap::Command::new("").help_template("{about}").about(text).term_width(width);
    format!("\n{}\n", lines.render_help().to_string().trim_end())
}

/// Shows three values of `-grid`. One value is a word, which its text names, and two are an error.
fn with_three_cells(command: clap::Command) -> clap::Command {
    command.mut_arg("grid", |flag| flag.num_args(3))
}

/// Writes one dash before each flag, and removes the characters for short flags.
fn single_dashes(text: &str) -> String {
    let moved = |line: &str| match line.strip_prefix("      --") {
        Some(rest) => format!("  -{rest}\n"),
        None => line.strip_prefix("     ").unwrap_or(line).trim_end().to_owned() + "\n",
    };
    single(&text.lines().map(moved).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fits(text: &str, width: usize) -> bool {
        text.lines().all(|line| line.chars().count() <= width) && !text.contains("--")
    }

    #[test]
    fn help_names_every_flag_and_fits_the_screen() {
        for width in [WIDTH, 60] {
            let text = text(&["--help".into()], width).unwrap();
            for flag in command().get_arguments() {
                assert!(text.contains(&format!("\n  -{}", flag.get_id())), "{flag:?}");
            }
            assert!(fits(&text, width) && fits(&usual(width), width), "{text}");
            assert!(["size", "shadow"].iter().all(|word| fits(&about(word, width).unwrap(), width)));
        }
    }

    #[test]
    fn the_usual_flags_are_ten_on_one_screen() {
        let text = usual(WIDTH);
        assert_eq!(text.lines().filter(|line| line.starts_with("  -")).count(), 10);
        assert!(fits(&text, WIDTH) && text.lines().count() <= 24, "{text}");
    }

    #[test]
    fn a_word_lists_the_flags_that_have_it() {
        let listed = |word: &str| {
            let text = about(bare(word), WIDTH).unwrap();
            let flags = text.lines().filter_map(|line| line.strip_prefix("  -")?.split(' ').next());
            flags.map(str::to_owned).collect::<Vec<_>>()
        };
        assert_eq!(listed("_Filter").len(), 5);
        assert!(listed("netravali") == ["mitchell_filter"] && listed("_count") == ["visualize_grid"]);
        assert!(listed("shadow").contains(&"transparent_shadows".into()));
        for (word, flag) in [("-o", "output"), ("spp", "jittered_samples"), ("--normal", "normals")] {
            assert_eq!(listed(word), [flag]);
        }
        assert!(about("shadwos", WIDTH).unwrap_err().to_string().contains("did you mean '-shadows'?"));
    }
}
