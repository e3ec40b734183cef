//! The command lines that complete a picture of which only the first rows are there.

use super::flags::{command, find};
use crate::image_io::beside;
use crate::render::Window;
use crate::shell::Shell;
use clap::Arg;
use std::ffi::{OsStr, OsString};
use std::path::Path;

/// What the file of the rest is called: `o.rest.tga` for `o.tga`.
const REST: &str = "rest";

/// Returns true if a flag has no meaning for a part, or another one.
fn is_dropped(flag: &Arg) -> bool {
    let is_excluded = |region| command().get_arg_conflicts_with(&region).contains(&flag);
    flag.get_id() == "region"
        || flag.get_help_heading() == Some("Comparison")
        || find("region").is_some_and(is_excluded)
}

/// The name in a word that is a flag: one or two dashes and a letter.
fn name_of(word: &OsStr) -> Option<&str> {
    let word = word.to_str()?;
    let name = word.strip_prefix("--").or(word.strip_prefix('-'))?;
    name.starts_with(|first: char| first.is_ascii_alphabetic()).then_some(name)
}

/// The command line that renders this region with all else as in `argv`, whose first word is the program's name.
/// `shell` reads it as it stands.
pub fn command_of_rest(argv: &[OsString], region: Window, shell: Shell) -> String {
    let Window { x, y, width, height } = region;
    let (program, mut words) = argv
        .split_first()
        .map_or(("raytracer".as_ref(), &[][..]), |(program, words)| (program.as_os_str(), words));
    let mut line = vec![shell.program(program)];
    while let Some((word, rest)) = words.split_first() {
        let count = rest.iter().take_while(|word| name_of(word).is_none()).count();
        let (values, after) = rest.split_at(count);
        line.extend(kept(word, values, shell));
        words = after;
    }
    format!("{} -region {x} {y} {width} {height}", line.join(" "))
}

/// A flag and its values for the rest.
fn kept(word: &OsStr, values: &[OsString], shell: Shell) -> Vec<String> {
    let flag = name_of(word).and_then(find);
    if flag.as_ref().is_some_and(is_dropped) {
        return vec![];
    }
    // The pictures of the rest get names of their own.
    let names = flag.as_ref().and_then(Arg::get_value_names).unwrap_or_default();
    let is_file = |index: usize| names.get(index).is_some_and(|name| name == "picture");
    let value = |(index, value): (usize, &OsString)| match is_file(index) {
        true if value != "-" => shell.word(beside(Path::new(value), REST)),
        _ => shell.word(value),
    };
    std::iter::once(shell.word(word)).chain(values.iter().enumerate().map(value)).collect()
}

/// The command line that makes a picture of the part that is there and its rest. `region` is what they make, if that is
/// not the whole.
pub fn command_of_merge(
    program: &OsStr,
    [part, file]: [&Path; 2],
    region: Option<Window>,
    shell: Shell,
) -> String {
    let region = region
        .map_or(String::new(), |Window { x, y, width, height }| format!(" -region {x} {y} {width} {height}"));
    let [part, file, rest] = [part, file, &beside(file, REST)].map(|file| shell.word(file));
    let program = shell.program(program);
    format!("{program} -merge {part} {rest} -output {file}{region}")
}

#[cfg(test)]
mod tests {
    use super::*;

    const REGION: Window = Window { x: 0, y: 7, width: 9, height: 2 };

    fn rest_of(words: &[&str], shell: Shell) -> String {
        command_of_rest(&words.iter().map(OsString::from).collect::<Vec<_>>(), REGION, shell)
    }

    #[test]
    fn pictures_of_the_rest_have_names_of_their_own() {
        for (line, rest) in [
            ("raytracer -input s.txt -output o.tga", "raytracer -input s.txt -output o.rest.tga"),
            (
                "./rt --depth -3 -.5 d/o.png -normal n.TGA -render_samples s.tga 4 -input s.txt",
                "./rt --depth -3 -.5 d/o.rest.png -normal n.rest.TGA -render_samples s.rest.tga 4 -input s.txt",
            ),
            (
                "rt -region 1 2 3 4 -shadows -compare a.tga -tolerance 0 0 -cost_map rays c.tga -output o.tga",
                "rt -shadows -output o.rest.tga",
            ),
            ("rt -output - tga -normals n png", "rt -output - tga -normals n.rest png"),
            ("rt -render_filter f.tga 3 -stats -input s.txt -grid auto", "rt -stats -input s.txt -grid auto"),
        ] {
            let words: Vec<&str> = line.split(' ').collect();
            // A file beside another is named with the separator of the system.
            let written =
                if cfg!(windows) { rest.replace("d/o.rest.png", "'d\\o.rest.png'") } else { rest.into() };
            assert_eq!(rest_of(&words, Shell::Posix), format!("{written} -region 0 7 9 2"), "{line}");
        }
    }

    #[test]
    fn the_shells_of_a_system_read_the_lines_as_they_stand() {
        let words = ["C:/my tracers/rt", "-input", "it's.txt", "-output", "a b.tga"];
        let merge = |shell| {
            command_of_merge(words[0].as_ref(), ["a b.partial.tga", "a b.tga"].map(Path::new), None, shell)
        };
        assert_eq!(
            [rest_of(&words, Shell::Posix), merge(Shell::Posix)],
            [
                "'C:/my tracers/rt' -input 'it'\\''s.txt' -output 'a b.rest.tga' -region 0 7 9 2",
                "'C:/my tracers/rt' -merge 'a b.partial.tga' 'a b.rest.tga' -output 'a b.tga'",
            ]
        );
        assert_eq!(
            [rest_of(&words, Shell::Windows), merge(Shell::Windows)],
            [
                r#"& "C:\my tracers\rt" -input "it's.txt" -output "a b.rest.tga" -region 0 7 9 2"#,
                r#"& "C:\my tracers\rt" -merge "a b.partial.tga" "a b.rest.tga" -output "a b.tga""#,
            ]
        );
    }

    #[test]
    fn the_part_and_the_rest_become_the_picture() {
        let merge = |region| {
            command_of_merge("rt".as_ref(), ["a.partial.tga", "a.tga"].map(Path::new), region, Shell::Posix)
        };
        let whole = "rt -merge a.partial.tga a.rest.tga -output a.tga";
        assert_eq!(merge(None), whole);
        assert_eq!(merge(Some(REGION)), format!("{whole} -region 0 7 9 2"));
    }
}
