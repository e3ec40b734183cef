//! The command lines that complete a picture of which only the first rows are there.

use super::flag::{Flag, Value};
use super::flags;
use super::raw::{is_flag, named};
use super::section::Section;
use crate::escape::shell_word;
use crate::image_io::beside;
use crate::render::Window;
use std::ffi::{OsStr, OsString};
use std::path::Path;

/// What the file of the rest is called: `o.rest.tga` for `o.tga`.
const REST: &str = "rest";

/// Whether a flag has no meaning for a part, or another one.
fn is_dropped(flag: &Flag) -> bool {
    flag.name == flags::REGION.name || flag.conflicts(&flags::REGION) || flag.section == Section::Comparison
}

/// The command line that renders this region with all else as in `argv`, whose first word is the program's name. A
/// shell reads it as it stands.
pub fn command_of_rest(argv: &[OsString], region: Window) -> String {
    let Window { x, y, width, height } = region;
    let (program, mut words) = argv
        .split_first()
        .map_or(("raytracer".as_ref(), &[][..]), |(program, words)| (program.as_os_str(), words));
    let mut line = vec![shell_word(program)];
    while let Some((word, rest)) = words.split_first() {
        let count = rest.iter().take_while(|word| !is_flag(word.as_encoded_bytes())).count();
        let (values, after) = rest.split_at(count);
        line.extend(kept(word, values));
        words = after;
    }
    format!("{} -region {x} {y} {width} {height}", line.join(" "))
}

/// A flag and its values for the rest.
fn kept(word: &OsStr, values: &[OsString]) -> Vec<String> {
    let flag = named(word);
    if flag.is_some_and(is_dropped) {
        return vec![];
    }
    // The pictures of the rest get names of their own.
    let is_file =
        |index| flag.and_then(|flag| flag.values.get(index)).is_some_and(|value: &Value| value.is_output);
    let value = |(index, value): (usize, &OsString)| match is_file(index) {
        true if value != "-" => shell_word(beside(Path::new(value), REST)),
        _ => shell_word(value),
    };
    std::iter::once(shell_word(word)).chain(values.iter().enumerate().map(value)).collect()
}

/// The command line that makes a picture of the part that is there and its rest. `region` is what they make, if that is
/// not the whole.
pub fn command_of_merge(program: &OsStr, part: &Path, file: &Path, region: Option<Window>) -> String {
    let region = region
        .map_or(String::new(), |Window { x, y, width, height }| format!(" -region {x} {y} {width} {height}"));
    let [program, part, file, rest] =
        [program, part.as_ref(), file.as_ref(), beside(file, REST).as_ref()].map(shell_word::<&OsStr>);
    format!("{program} -merge {part} {rest} -output {file}{region}")
}

#[cfg(test)]
mod tests {
    use super::*;

    const REGION: Window = Window { x: 0, y: 7, width: 9, height: 2 };

    fn rest_of(words: &[&str]) -> String {
        command_of_rest(&words.iter().map(OsString::from).collect::<Vec<_>>(), REGION)
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
            assert_eq!(rest_of(&words), format!("{rest} -region 0 7 9 2"), "{line}");
        }
        let [program, scene, picture] = ["my tracer", "it's.txt", "a b.rest.tga"].map(shell_word);
        assert_eq!(
            rest_of(&["my tracer", "-input", "it's.txt", "-output", "a b.tga"]),
            format!("{program} -input {scene} -output {picture} -region 0 7 9 2")
        );
    }

    #[test]
    fn the_part_and_the_rest_become_the_picture() {
        let merge = |region| {
            command_of_merge("rt".as_ref(), Path::new("a b.partial.tga"), Path::new("a b.tga"), region)
        };
        let [part, rest, picture] = ["a b.partial.tga", "a b.rest.tga", "a b.tga"].map(shell_word);
        let whole = format!("rt -merge {part} {rest} -output {picture}");
        assert_eq!(merge(None), whole);
        assert_eq!(merge(Some(REGION)), format!("{whole} -region 0 7 9 2"));
    }
}
