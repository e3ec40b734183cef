//! The help texts, generated from the definitions of the flags.

use super::error::CliError;
use super::flag::Flag;
use super::flags::{self, FLAGS};
use super::section::{SECTIONS, Section};
use std::ffi::OsStr;

/// The column at which the descriptions start.
const INDENT: usize = 32;
/// The same in the short help.
const USUAL_INDENT: usize = 24;
/// The length of the longest lines in characters.
const WIDTH: usize = 80;

const HEAD: &str = "\
Renders a scene of MIT's 6.837 ray tracing assignments and writes the requested
pictures.

Usage: raytracer -input scene.txt [flags, in any order]
       raytracer -help word        all about a flag, or the flags with this word
";

const USUAL_HEAD: &str = "\
Renders a scene of MIT's 6.837 ray tracing assignments.

Usage: raytracer -input scene.txt -output picture.png [flags, in any order]

";

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

";

/// What the exit status means.
pub(super) const STATUS: &str = "\
The exit status is 1 for a file that cannot be read or written and for an error in the scene, 2 for an error in the \
command line, 3 for a difference above the tolerance, and 130, 143 or 129 for a run that was stopped by Ctrl-C, SIGTERM or SIGHUP.";

/// The text that `-help` prints.
pub(super) fn text() -> String {
    let sections: String = SECTIONS.into_iter().map(section).collect();
    format!("{HEAD}{sections}{TAIL}{}", paragraph(STATUS, 0))
}

/// The text that `-h` prints, which fits on a screen of 24 lines.
pub(super) fn usual() -> String {
    let row = |flag: &&Flag| {
        let lines = wrap(&format!("{}.", flag.summary()), WIDTH - USUAL_INDENT);
        table_row(flag, USUAL_INDENT, lines)
    };
    let flags: String = FLAGS.iter().filter(|flag| flag.is_usual).map(row).collect();
    format!("{USUAL_HEAD}{flags}{USUAL_TAIL}")
}

/// The text that `-help` prints for a word: all about the flag of this name, which may have dashes, or about the one
/// that other programs call so; otherwise the flags whose names or descriptions have the word in them.
pub(super) fn about(word: &OsStr) -> Result<String, CliError> {
    let name = word.to_string_lossy();
    let name = name.trim_start_matches('-');
    if let Some(flag) = flags::find(name).or_else(|| flags::meant(name)) {
        return Ok(in_full(flag));
    }
    let part = name.to_lowercase();
    let has_it = |flag: &&&Flag| {
        flag.names().chain([flag.help, flag.details]).any(|text| text.to_lowercase().contains(&part))
    };
    let found: Vec<String> = FLAGS.iter().filter(has_it).map(|flag| entry(flag)).collect();
    match found.is_empty() {
        true => Err(CliError::UnknownFlag { flag: name.to_owned(), nearest: nearest(name) }),
        false => Ok(found.concat()),
    }
}

/// The text that `-version` prints.
pub(super) fn version() -> String {
    format!("raytracer {}\n", env!("CARGO_PKG_VERSION"))
}

fn section((section, title): (Section, &str)) -> String {
    let flags: String = FLAGS.iter().filter(|flag| flag.section == section).map(|flag| entry(flag)).collect();
    format!("\n{}:\n{flags}", title)
}

fn entry(flag: &Flag) -> String {
    let lines = wrap(flag.help, WIDTH - INDENT).into_iter().chain(default_and_example(flag));
    table_row(flag, INDENT, lines.collect())
}

/// A flag, and beside it these lines from a column on.
fn table_row(flag: &Flag, column: usize, lines: Vec<String>) -> String {
    let mut left = format!("  {}", flag.usage());
    let mut text = String::new();
    for line in lines {
        text += &format!("{left:<column$}{line}\n");
        left.clear();
    }
    text
}

/// The default and an example, in one line if they fit.
fn default_and_example(flag: &Flag) -> Vec<String> {
    let default = (!flag.default.is_empty()).then(|| format!("Default: {}", flag.default));
    let example = (!flag.example.is_empty()).then(|| format!("Example: {}", flag.example));
    let parts: Vec<String> = default.into_iter().chain(example).collect();
    let line = parts.join("   ");
    if line.chars().count() <= WIDTH - INDENT && !line.is_empty() { vec![line] } else { parts }
}

/// Everything about a flag.
fn in_full(flag: &Flag) -> String {
    let mut text = format!("{}\n{}", flag.usage(), paragraph(flag.help, 2));
    if !flag.details.is_empty() {
        text += &paragraph(flag.details, 2);
    }
    text += "\n";
    let excluded: Vec<String> = flag.excluded().map(|other| format!("-{}", other.name)).collect();
    let aliases: Vec<String> = flag.aliases.iter().map(|alias| format!("-{alias}")).collect();
    for (label, value) in [
        ("Default", flag.default.to_owned()),
        ("Not with", excluded.join(" ")),
        ("Also", aliases.join(" ")),
        ("Example", flag.command()),
    ] {
        if !value.is_empty() {
            text += &format!("  {:<10}{value}\n", format!("{label}:"));
        }
    }
    text
}

fn nearest(name: &str) -> Option<String> {
    const LONGEST: usize = 40;
    let distance = |flag: &&Flag| strsim::levenshtein(name, flag.name);
    let near = |flag: &&Flag| distance(flag) <= (name.chars().count() + 1) / 3;
    let all = FLAGS.iter().copied().filter(|_| name.len() <= LONGEST);
    all.filter(near).min_by_key(distance).map(|flag| flag.name.to_owned())
}

/// A text in lines that start with this number of blanks.
fn paragraph(text: &str, indent: usize) -> String {
    wrap(text, WIDTH - indent).into_iter().map(|line| format!("{:indent$}{line}\n", "")).collect()
}

/// Breaks `text` between words into lines of at most `width` characters.
fn wrap(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.is_empty() => line.push_str(word),
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn help_names_every_flag_with_its_values_and_fits_the_screen() {
        let text = text();
        for flag in FLAGS {
            let usage = format!("\n  {} ", flag.usage());
            assert!(text.contains(&usage), "{usage}");
        }
        assert!(text.lines().all(|line| line.chars().count() <= WIDTH));
        assert!(!text.contains("--"));
    }

    #[test]
    fn the_usual_flags_are_ten_on_one_screen() {
        let text = usual();
        assert_eq!(FLAGS.iter().filter(|flag| flag.is_usual).count(), 10);
        assert!(
            text.lines().count() < 24 && text.lines().all(|line| line.chars().count() <= WIDTH),
            "{text}"
        );
    }

    #[test]
    fn no_flag_has_a_name_that_another_program_gives_to_another_one() {
        let others: Vec<&str> = FLAGS.iter().flat_map(|flag| flag.elsewhere).copied().collect();
        for (index, name) in others.iter().enumerate() {
            assert!(flags::find(name).is_none() && !others[..index].contains(name), "{name}");
        }
    }

    #[test]
    fn a_word_lists_the_flags_that_have_it() {
        let listed = |word: &str| {
            let text = about(OsStr::new(word)).unwrap();
            let flags = text.lines().filter_map(|line| line.strip_prefix("  -")?.split(' ').next());
            flags.map(str::to_owned).collect::<Vec<_>>()
        };
        assert_eq!(listed("_Filter").len(), 5);
        assert_eq!(listed("gaussian"), ["gaussian_filter"]);
        assert!(listed("shadow").contains(&"transparent_shadows".into()));
        let text = |word: &str| about(OsStr::new(word));
        assert_eq!([text("-o"), text("spp")], [text("output"), text("jittered_samples")]);
    }

    #[test]
    fn usage_leaves_room_for_the_description() {
        assert!(FLAGS.iter().all(|flag| flag.usage().len() + 3 <= INDENT));
    }

    #[test]
    fn a_flag_is_explained_in_full() {
        let expected = "\
-box_filter r
  Averages the samples within r pixels along both axes.

  Default:  0.5
  Not with: -tent_filter -gaussian_filter -mitchell_filter
  Example:  raytracer -input scene.txt -output picture.png -jittered_samples 16 -box_filter 1
";
        for word in ["box_filter", "-box_filter", "--box_filter"] {
            assert_eq!(about(OsStr::new(word)), Ok(expected.to_owned()));
        }
    }

    #[test]
    fn a_flag_that_is_none_is_corrected() {
        let nearest = |word| match about(OsStr::new(word)) {
            Err(CliError::UnknownFlag { nearest, .. }) => nearest,
            other => panic!("{other:?}"),
        };
        assert_eq!(nearest("shadwos"), Some("shadows".into()));
        assert_eq!((nearest("teapot"), nearest(&"s".repeat(1000))), (None, None));
    }
}
