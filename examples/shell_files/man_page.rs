//! The manual page, by clap_mangen.

use clap_mangen::Man;
use raytracer::cli::command;

/// What stands before the flags.
const DESCRIPTION: &str = "\
Flags start with one dash and come in any order, each at most once.
Values are separate words.
A word that starts with a dash and a letter is a flag, any other word is a value.
The format of a picture follows from the extension of its name.";

/// What stands after the flags, in the macros of man(7).
const END: &str = r"
.SH EXIT STATUS
.TP
0
Success.
.TP
1
A file cannot be read or written, or there is an error in the scene.
.TP
2
There is an error in the command line.
.TP
3
Pictures differ by more than the tolerance, or no setting reaches the target.
.TP
130, 143, 129
Ctrl\-C, SIGTERM or SIGHUP stopped the run.
.SH EXAMPLES
.nf
raytracer \-input spheres.txt \-output spheres.png \-size 200 200 \-shadows \-bounces 3
raytracer \-input plane.txt \-depth 8 20 depth.png \-normals normals.png
raytracer \-compare mine.tga \-reference theirs.png \-difference difference.png
.fi
";

/// The text of `raytracer.1`.
pub fn man_page() -> String {
    let about = command().get_about().map(ToString::to_string).unwrap_or_default();
    let page = Man::new(command().long_about(format!("{about}.\n{DESCRIPTION}")));
    let mut text = b".\\\" Made from the flags by `cargo run --example shell_files`.\n".to_vec();
    let sections = [
        Man::render_title,
        Man::render_name_section,
        Man::render_synopsis_section,
        Man::render_description_section,
        Man::render_options_section,
    ];
    for section in sections {
        section(&page, &mut text).expect("memory takes all text");
    }
    // The flags have one dash, whose formatting is between it and the name.
    let text = String::from_utf8(text).expect("UTF-8").replace("\\-\\-", "\\-");
    // A line break beside an empty line has no effect, and some programs warn of it.
    text.replace("\n.br\n\n.br\n", "\n\n") + END.trim_start()
}
