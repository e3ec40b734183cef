//! Files of command lines, such as the course's.

use super::error::fail;
use super::options::Options;
use super::{Command, Output, parse};
use crate::diagnostic::Diagnostic;
use crate::render::Layer;
use std::ffi::OsString;
use std::path::Path;

/// Parses the command lines of a text, all of which render a scene. Each starts with the name of the program, which may
/// be any; words are separated by white space. Empty lines and lines that start with `#` are skipped. The error about
/// the first line that cannot be used has its number.
pub fn parse_commands(text: &str) -> Result<Vec<Options>, Diagnostic> {
    let lines = text.lines().enumerate().map(|(index, line)| (index + 1, line.trim()));
    let commands = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    let in_line = |number, error: Diagnostic| Diagnostic {
        message: format!("line {number}: {}", error.message),
        ..error
    };
    commands.map(|(number, line)| rendering(line).map_err(|error| in_line(number, error))).collect()
}

fn rendering(line: &str) -> Result<Options, Diagnostic> {
    let options = match parse(line.split_whitespace().map(OsString::from))? {
        Command::Render(options) if options.input.is_some() => *options,
        _ => return fail("the command does not render a scene"),
    };
    let is_cost = |output: &Output| matches!(output.layer, Layer::Cost(_));
    if options.outputs.iter().any(is_cost) {
        return fail("a cost map cannot be graded: leave out `-cost_map`");
    }
    if options.region.is_some() {
        return fail("a part cannot be graded: leave out `-region`");
    }
    if options.outputs.iter().any(Output::is_standard_output)
        || options.input.as_deref() == Some(Path::new("-"))
    {
        return fail("`-` cannot be graded: name a file");
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
            ("rt -input a.txt -sise 1 1", "line 2: unexpected argument '-sise' found"),
            ("rt -help", "line 2: the command does not render a scene"),
            ("rt -compare a.tga -reference b.tga", "line 2: the command does not render a scene"),
            ("rt -grade a -reference b", "line 2: the command does not render a scene"),
            (
                "rt -input a.txt -region 0 0 9 9 -output a.tga",
                "line 2: a part cannot be graded: leave out `-region`",
            ),
            ("rt -input - -output a.tga", "line 2: `-` cannot be graded: name a file"),
            ("rt -input a.txt -output - tga", "line 2: `-` cannot be graded: name a file"),
            (
                "rt -input a.txt -cost_map rays a.tga",
                "line 2: a cost map cannot be graded: leave out `-cost_map`",
            ),
        ] {
            assert_eq!(parse_commands(&format!("\n{line}")).unwrap_err().message, message);
        }
    }
}
