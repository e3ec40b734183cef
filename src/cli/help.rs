//! The help: about the usual flags, all flags, one of them, or those with a word.

use super::dashes::single;
use super::error::CliError;
use super::flags::{USUAL, command, find, meant};
use clap::Arg;
use std::ffi::{OsStr, OsString};

/// The length of the longest lines in characters.
const WIDTH: usize = 80;
/// The room that clap leaves before flags for short ones, which there are not.
const ROOM: usize = 5;

const USUAL_TAIL: &str = "
-help lists all flags, -help size tells all about one, and -help shadow lists
those with this word.
";

const TAIL: &str = "
Examples:
  raytracer -input spheres.txt -size 200 200 -output spheres.tga
            -shadows -bounces 3 -weight 0.01
  raytracer -input plane.txt -size 200 200 -output plane.png
            -depth 8 20 depth.tga -normals normals.tga

The exit status is 1 for a file that cannot be read or written and for an error
in the scene, 2 for an error in the command line, 3 for a difference above the
tolerance, and 130, 143 or 129 for a run stopped by Ctrl-C, SIGTERM or SIGHUP.
";

/// What help is asked for.
pub(super) enum Topic {
    Usual,
    All,
    About(OsString),
}

/// Finds the first flag that asks for help. Cuts `words`, which have clap's dashes, after it: what follows is not read.
pub(super) fn topic(words: &mut Vec<OsString>) -> Option<Topic> {
    let place = words.iter().position(|word| word == "--h" || word == "--help")?;
    let is_flag = |word: &OsStr| word.as_encoded_bytes().starts_with(b"-");
    let is_known = |word: &OsStr| known(&name_of(word)).is_some();
    let word = words.get(place + 1).filter(|word| !is_flag(word) || is_known(word));
    let topic = match word {
        Some(word) => Topic::About(word.clone()),
        None if words[place] == "--h" => Topic::Usual,
        None => Topic::All,
    };
    words.truncate(place + 1);
    Some(topic)
}

/// The text about a topic.
pub(super) fn text(topic: &Topic) -> Result<String, CliError> {
    match topic {
        Topic::Usual => Ok(usual()),
        Topic::All => Ok(show(command()) + TAIL),
        Topic::About(word) => about(word),
    }
}

/// The first sentences about the usual flags, on one screen.
fn usual() -> String {
    let usual = command().mut_args(|flag| {
        let is_hidden = !USUAL.contains(&flag.get_id().as_str());
        let help = summary(&flag);
        let flag = flag.help(help).hide(is_hidden).help_heading("Usual flags");
        // The name of a format after the picture's would leave no room beside it.
        if flag.get_id() == "output" { flag.num_args(1).value_names(["picture"]) } else { flag }
    });
    show(usual) + USUAL_TAIL
}

/// The first sentence about a flag.
fn summary(flag: &Arg) -> String {
    let help = flag.get_help().map(ToString::to_string).unwrap_or_default();
    help.split(". ").next().unwrap_or_default().to_owned()
}

/// All about the flag of this name, or the one that other programs call so; otherwise the flags with the word.
fn about(word: &OsStr) -> Result<String, CliError> {
    let name = name_of(word);
    if let Some(id) = known(&name) {
        return Ok(show_some(|flag| flag.get_id() == id.as_str(), true));
    }
    let part = name.to_lowercase();
    let has_part = |text: String| text.to_lowercase().contains(&part);
    let has_word = |flag: &Arg| {
        let help = [flag.get_help(), flag.get_long_help()].into_iter().flatten().map(ToString::to_string);
        let names = flag.get_all_aliases().into_iter().flatten().map(str::to_owned);
        help.chain(names).chain([flag.get_id().to_string()]).any(has_part)
    };
    if command().get_arguments().any(has_word) {
        return Ok(show_some(has_word, false));
    }
    // The error for an unknown flag has a suggestion.
    let words = [OsString::from(format!("--{name}"))];
    match command().try_get_matches_from(&words) {
        Err(error) => Err(CliError::of(error, &words)),
        Ok(_) => Err(CliError::new(format!("no flag has '{name}' in its help"))),
    }
}

fn name_of(word: &OsStr) -> String {
    word.to_string_lossy().trim_start_matches('-').to_owned()
}

/// The flag that is called so here or elsewhere.
fn known(name: &str) -> Option<String> {
    let command = command();
    let flag = find(&command, name).map(|flag| flag.get_id().to_string());
    flag.or_else(|| meant(name).map(str::to_owned))
}

fn show_some(is_shown: impl Fn(&Arg) -> bool, in_full: bool) -> String {
    let some = command().help_template("{options}\n").mut_args(|flag| {
        let is_hidden = !is_shown(&flag);
        flag.hide(is_hidden)
    });
    if in_full {
        single_dashes(&some.term_width(WIDTH + ROOM).render_long_help().to_string())
    } else {
        show(some)
    }
}

fn show(command: clap::Command) -> String {
    single_dashes(&command.term_width(WIDTH + ROOM).render_help().to_string())
}

/// One dash before each flag, and lines without the room for short ones.
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

    fn fits(text: &str) -> bool {
        text.lines().all(|line| line.chars().count() <= WIDTH) && !text.contains("--")
    }

    #[test]
    fn help_names_every_flag_and_fits_the_screen() {
        let text = text(&Topic::All).unwrap();
        for flag in command().get_arguments() {
            assert!(text.contains(&format!("\n  -{}", flag.get_id())), "{flag:?}");
        }
        assert!(fits(&text), "{text}");
    }

    #[test]
    fn the_usual_flags_are_ten_on_one_screen() {
        let text = usual();
        assert_eq!(text.lines().filter(|line| line.starts_with("  -")).count(), USUAL.len());
        assert!(fits(&text) && text.lines().count() <= 24, "{text}");
    }

    #[test]
    fn a_word_lists_the_flags_that_have_it() {
        let listed = |word: &str| {
            let text = about(OsStr::new(word)).unwrap();
            let flags = text.lines().filter_map(|line| line.strip_prefix("  -")?.split(' ').next());
            flags.map(str::to_owned).collect::<Vec<_>>()
        };
        assert_eq!(listed("_Filter").len(), 5);
        assert!(listed("netravali") == ["mitchell_filter"] && listed("_count") == ["visualize_grid"]);
        assert!(listed("shadow").contains(&"transparent_shadows".into()));
        for (word, flag) in [("-o", "output"), ("spp", "jittered_samples"), ("--normal", "normals")] {
            assert_eq!(listed(word), [flag]);
        }
        assert!(about(OsStr::new("shadwos")).unwrap_err().to_string().contains("did you mean '-shadows'?"));
    }
}
