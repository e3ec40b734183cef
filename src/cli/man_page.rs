//! The manual page, generated from the definitions of the flags, in the macros of man(7).

use super::flag::Flag;
use super::flags::FLAGS;
use super::help::STATUS;
use super::section::{SECTIONS, Section};

/// The text of `raytracer.1`.
pub fn man_page() -> String {
    let sections: String = SECTIONS.into_iter().map(section).collect();
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

fn section((section, title): (Section, &str)) -> String {
    let flags: String = FLAGS.iter().filter(|flag| flag.section == section).map(|flag| entry(flag)).collect();
    format!(".SS {}\n{flags}", escape(title))
}

fn entry(flag: &Flag) -> String {
    let values: String = flag.values.iter().map(|value| format!(" \\fI{}\\fR", escape(value.name))).collect();
    let mut text = format!(".TP\n\\fB{}\\fR{values}\n", escape(&format!("-{}", flag.name)));
    for sentence in [flag.help, flag.details].into_iter().filter(|sentence| !sentence.is_empty()) {
        text += &format!("{}\n", escape(sentence));
    }
    if !flag.default.is_empty() {
        text += &format!(".br\nDefault: {}\n", escape(flag.default));
    }
    if !flag.example.is_empty() {
        text += &format!(".br\nExample: {}\n", escape(flag.example));
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
