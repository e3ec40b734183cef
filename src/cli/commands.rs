//! Files of command lines, such as the course's.

use super::options::Options;
use super::{Command, Output, parse};
use crate::render::Layer;
use std::ffi::OsString;
use std::path::Path;

/// Parses the command lines of a text, all of which render a scene. Each starts with the name of the program, which may
/// be any; words are separated by white space. Empty lines, and those that start with `#`, are skipped. Errors: the
/// message about the first line that cannot be used, with its number.
pub fn parse_commands(text: &str) -> Result<Vec<Options>, String> {
    let lines = text.lines().enumerate().map(|(index, line)| (index + 1, line.trim()));
    let commands = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    commands
        .map(|(number, line)| rendering(line).map_err(|problem| format!("line {number}: {problem}")))
        .collect()
}

fn rendering(line: &str) -> Result<Options, String> {
    let command = parse(line.split_whitespace().map(OsString::from)).map_err(|error| error.to_string())?;
    let options = match command {
        Command::Render(options) if options.input.is_some() => *options,
        _ => return Err("the command does not render a scene".into()),
    };
    let is_cost = |output: &Output| matches!(output.layer, Layer::Cost(_));
    if options.outputs.iter().any(is_cost) {
        return Err("a cost map is nothing to grade by".into());
    }
    if options.region.is_some() {
        return Err("a part of a picture is nothing to grade by".into());
    }
    if options.has_standard_output() || options.input.as_deref() == Some(Path::new("-")) {
        return Err("`-` is no file to grade by".into());
    }
    Ok(options)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_lines_and_comments_are_skipped() {
        let text = "# a\n\nraytracer -input a.txt -output a.tga\r\n  ./rt -input b.txt -size 7 8\n";
        let found = parse_commands(text).unwrap();
        assert_eq!(found.iter().map(|options| options.size).collect::<Vec<_>>(), [[100, 100], [7, 8]]);
    }

    #[test]
    fn a_line_that_cannot_be_used_is_named() {
        for (line, message) in [
            ("rt -input a.txt -sise 1 1", "line 2: unexpected argument '-sise' found; did you mean '-size'?"),
            ("rt -help", "line 2: the command does not render a scene"),
            ("rt -compare a.tga -reference b.tga", "line 2: the command does not render a scene"),
            ("rt -grade a -reference b", "line 2: the command does not render a scene"),
            (
                "rt -input a.txt -region 0 0 9 9 -output a.tga",
                "line 2: a part of a picture is nothing to grade by",
            ),
            ("rt -input - -output a.tga", "line 2: `-` is no file to grade by"),
            ("rt -input a.txt -output - tga", "line 2: `-` is no file to grade by"),
            ("rt -input a.txt -cost_map rays a.tga", "line 2: a cost map is nothing to grade by"),
        ] {
            assert_eq!(parse_commands(&format!("\n{line}")).unwrap_err(), message);
        }
    }
}
