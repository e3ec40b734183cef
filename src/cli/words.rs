//! The words of a command line: as clap reads them, with two dashes before a flag, and as users write them, with one.

use super::flags::{NOT_OF_PARTS, command, shapes};
use crate::base::shell::Shell;
use crate::base::stdio::STDIO;
use crate::image_io::beside;
use crate::render::Window;
use clap::parser::ValueSource;
use clap::{Arg, ArgMatches};
use std::ffi::{OsStr, OsString};
use std::path::Path;

/// The word before the extension of the file with the rest of a picture: `o.rest.tga` for `o.tga`.
const REST: &str = "rest";

/// Converts a word for clap: `-word` to `--word`, a negative number to the form that clap takes for one, and any other
/// word with a dash to the name of a file.
pub(super) fn double(word: &OsStr) -> OsString {
    let with = |start: &str| {
        let mut long = OsString::from(start);
        long.push(word);
        long
    };
    match word.as_encoded_bytes() {
        [b'-', letter, ..] if letter.is_ascii_alphabetic() => with("-"),
        [b'-', second, ..] if *second != b'-' => {
            match word.to_str().map(|text| (text, text.parse::<f64>())) {
                Some((text, Ok(number))) if number.is_finite() && text.contains(['.', 'e', 'E']) => {
                    number.to_string().into()
                }
                Some((_, Ok(_))) => word.to_owned(),
                _ => with("./"),
            }
        }
        _ => word.to_owned(),
    }
}

/// Writes a text of clap with one dash before each flag.
pub(super) fn single(text: &str) -> String {
    let mut parts = text.split("--");
    let mut single = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let starts_word = !single.ends_with(|c: char| c.is_alphanumeric());
        single += if starts_word && part.starts_with(|c: char| c.is_ascii_alphabetic()) { "-" } else { "--" };
        single += part;
    }
    single
}

/// Returns the flags that were given and for which `is_kept` holds, each with its values, in the order of the help.
fn given(
    flags: &clap::Command,
    matches: &ArgMatches,
    is_kept: impl Fn(&Arg) -> bool,
) -> Vec<(Arg, Vec<OsString>)> {
    let given = flags.get_arguments().filter(|flag| {
        let source = matches.value_source(flag.get_id().as_str());
        source == Some(ValueSource::CommandLine) && is_kept(flag)
    });
    let with_values = |flag: &Arg| {
        // clap gives a value to flags that have none.
        let values = matches.get_raw(flag.get_id().as_str()).filter(|_| flag.get_action().takes_values());
        (flag.clone(), values.into_iter().flatten().map(OsStr::to_owned).collect())
    };
    given.map(with_values).collect()
}

/// Returns the given flags that shape the colour picture, with their values.
pub(super) fn shaping_words(flags: &clap::Command, matches: &ArgMatches) -> Vec<String> {
    let mut words = vec![];
    for (flag, values) in given(flags, matches, shapes) {
        words.push(format!("-{}", flag.get_id()));
        words.extend(values.iter().map(|value| value.to_string_lossy().into_owned()));
    }
    words
}

/// Returns the command line that renders this region with all else as in `argv`, whose first word is the program's
/// name. The pictures get names of their own.
pub fn command_of_rest(argv: &[OsString], region: Window, shell: Shell) -> String {
    let Some((program, words)) = argv.split_first() else { return String::new() };
    let mut flags = command();
    let words = words.iter().map(|word| double(word));
    let Ok(matches) = flags.try_get_matches_from_mut(words) else { return String::new() };
    let is_kept = |flag: &Arg| flag.get_id() != "region" && !NOT_OF_PARTS.contains(&flag.get_id().as_str());
    let mut given = given(&flags, &matches, is_kept);
    given.sort_by_key(|(flag, _)| matches.index_of(flag.get_id().as_str()));
    let mut line = shell.program(program);
    for (flag, values) in given {
        line += &format!(" -{}", flag.get_id());
        let names = flag.get_value_names().unwrap_or_default();
        for (index, value) in values.iter().enumerate() {
            let is_file = value != STDIO && names.get(index).is_some_and(|name| name == "picture");
            let value = if is_file { beside(Path::new(value), REST).into() } else { value.clone() };
            line += &format!(" {}", shell.word(value));
        }
    }
    line + &words_of(region)
}

fn words_of(Window { x, y, width, height }: Window) -> String {
    format!(" -region {x} {y} {width} {height}")
}

/// Returns the command line that joins the part that is there and its rest. `region` is the part of the picture that
/// they are, unless they are the whole.
pub fn command_of_merge(
    program: &OsStr,
    [part, file]: [&Path; 2],
    region: Option<Window>,
    shell: Shell,
) -> String {
    let [part, file, rest] = [part, file, &beside(file, REST)].map(|file| shell.word(file));
    let (program, region) = (shell.program(program), region.map(words_of).unwrap_or_default());
    format!("{program} -merge {part} {rest} -output {file}{region}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_numbers_and_files_are_told_apart() {
        for (word, doubled) in [
            ("-size", "--size"),
            ("--size", "--size"),
            ("-h", "--h"),
            ("-", "-"),
            ("--", "--"),
            ("-3", "-3"),
            ("-.5", "-0.5"),
            ("-1e-3", "-0.001"),
            ("-3.", "-3"),
            ("-99999999999999999999", "-99999999999999999999"),
            ("-5.tga", "./-5.tga"),
            ("a-b", "a-b"),
        ] {
            assert_eq!(double(OsStr::new(word)), OsStr::new(doubled), "{word}");
        }
    }

    #[test]
    fn only_dashes_before_flags_go() {
        assert_eq!(single("'--size <w>' a--b -- --x"), "'-size <w>' a--b -- -x");
    }

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
                "./rt -depth -3 -0.5 d/o.rest.png -normals n.rest.TGA -render_samples s.rest.tga 4 -input s.txt",
            ),
            ("rt -region 1 2 3 4 -shadows -input s.txt", "rt -shadows -input s.txt"),
            (
                "rt -input s.txt -shadows -compare a.tga -tolerance 0 0 -cost_map rays c.tga -output o.tga",
                "rt -input s.txt -shadows -output o.rest.tga",
            ),
            ("rt -output - tga -normals n png -input -", "rt -output - tga -normals n.rest png -input -"),
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
    fn the_part_and_the_rest_become_the_picture() {
        let merge = |region| {
            command_of_merge("rt".as_ref(), ["a.partial.tga", "a.tga"].map(Path::new), region, Shell::Posix)
        };
        let whole = "rt -merge a.partial.tga a.rest.tga -output a.tga";
        assert_eq!(merge(None), whole);
        assert_eq!(merge(Some(REGION)), format!("{whole} -region 0 7 9 2"));
    }
}
