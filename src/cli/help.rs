//! The help text, generated from the table of flags.

use super::flags::{FLAGS, Flag};
use super::section::Section;

/// The column at which the descriptions start.
const INDENT: usize = 32;
/// The length of the longest lines in characters.
const WIDTH: usize = 80;

const HEAD: &str = "\
Renders a scene of MIT's 6.837 ray tracing assignments and writes the requested
pictures.

Usage: raytracer -input scene.txt [flags, in any order]
";

const TAIL: &str = "
Examples:
  raytracer -input spheres.txt -size 200 200 -output spheres.tga
            -shadows -bounces 3 -weight 0.01
  raytracer -input plane.txt -size 200 200 -output plane.png
            -depth 8 20 depth.tga -normals normals.tga

The exit status is 1 for a file that cannot be read or written and for an error
in the scene, 2 for an error in the command line, 3 for a difference above the
tolerance, and 130 or 143 for a run that was stopped by Ctrl-C or SIGTERM.
";

/// The text that `-help` prints.
pub(super) fn text() -> String {
    let sections: String = Section::ALL.into_iter().map(section).collect();
    format!("{HEAD}{sections}{TAIL}")
}

/// The text that `-version` prints.
pub(super) fn version() -> String {
    format!("raytracer {}\n", env!("CARGO_PKG_VERSION"))
}

fn section(section: Section) -> String {
    let flags: String = FLAGS.iter().filter(|flag| flag.section == section).map(|flag| entry(flag)).collect();
    format!("\n{}:\n{flags}", section.title())
}

fn entry(flag: &Flag) -> String {
    let mut left = format!("  {}", flag.usage());
    let mut text = String::new();
    for line in wrap(flag.doc, WIDTH - INDENT) {
        text += &format!("{left:<INDENT$}{line}\n");
        left.clear();
    }
    text
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
    fn usage_leaves_room_for_the_description() {
        assert!(FLAGS.iter().all(|flag| flag.usage().len() + 3 <= INDENT));
    }
}
