//! The manual page, generated from the table of flags, in the macros of man(7).

use super::flags::{FLAGS, Flag};
use super::help::STATUS;
use super::notes;
use super::section::Section;

/// The text of `raytracer.1`.
pub fn man_page() -> String {
    let sections: String = Section::ALL.into_iter().map(section).collect();
    let version = env!("CARGO_PKG_VERSION");
    let status = escape(STATUS);
    format!(
        "\
.\\\" Made from the table of flags by `cargo run --example shell_files`.
.TH RAYTRACER 1 \"\" \"raytracer {version}\" \"User Commands\"
.SH NAME
raytracer \\- render the scenes of MIT's computer graphics course 6.837
.SH SYNOPSIS
.B raytracer
.B \\-input
.I scene.txt
.RI [ flags ]
.br
.B raytracer \\-help
.RI [ flag ]
.SH DESCRIPTION
Renders a scene of MIT's 6.837 ray tracing assignments and writes the requested pictures.
Flags start with one dash, may come in any order, and may be given once each.
Values are separate words.
A word that starts with a dash and a letter is a flag, and any other word is a value.
The format of a picture follows from the extension of its name.
.SH OPTIONS
{sections}.SH EXIT STATUS
{status}
It is 0 otherwise.
.SH EXAMPLES
.nf
raytracer \\-input spheres.txt \\-output spheres.png \\-size 200 200 \\-shadows \\-bounces 3
raytracer \\-input plane.txt \\-depth 8 20 depth.png \\-normals normals.png
raytracer \\-compare mine.tga \\-reference theirs.png \\-difference difference.png
.fi
"
    )
}

fn section(section: Section) -> String {
    let flags: String = FLAGS.iter().filter(|flag| flag.section == section).map(|flag| entry(flag)).collect();
    format!(".SS {}\n{flags}", escape(section.title()))
}

fn entry(flag: &Flag) -> String {
    let values: String = flag.values.iter().map(|value| format!(" \\fI{}\\fR", escape(value))).collect();
    let notes = notes::of(flag);
    let mut text = format!(".TP\n\\fB{}\\fR{values}\n", escape(&format!("-{}", flag.name)));
    for sentence in [flag.doc, notes.details].into_iter().filter(|sentence| !sentence.is_empty()) {
        text += &format!("{}\n", escape(sentence));
    }
    if !notes.default.is_empty() {
        text += &format!(".br\nDefault: {}\n", escape(notes.default));
    }
    if !notes.example.is_empty() {
        text += &format!(".br\nExample: {}\n", escape(notes.example));
    }
    text
}

/// Text that the formatter takes as it is: a dash is no hyphen, and no line is a request.
fn escape(text: &str) -> String {
    let text = text.replace('\\', "\\e").replace('-', "\\-");
    if text.starts_with(['.', '\'']) { format!("\\&{text}") } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escaped_text_is_no_request() {
        assert_eq!(escape(".tga or a-b\\"), "\\&.tga or a\\-b\\e");
        assert_eq!(escape("'x"), "\\&'x");
    }
}
