//! Finds the pictures in the files of a name.

use crate::image_io::Format;
use serde::{Serialize, Serializer};
use std::collections::{HashMap, HashSet};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// A file or a folder, by its path from the folder of its name.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Listed {
    pub path: PathBuf,
    pub kind: Kind,
}

/// The kind of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    Regular,
    /// A folder whose files are listed too.
    Folder,
    /// Not read, whatever its name. A link may lead to another name's picture.
    Refused(Reason),
}

/// The files that are taken for the wanted pictures, and the others.
#[derive(Clone, Debug)]
pub struct Pairing {
    /// For each wanted picture, its file.
    pub taken: Vec<Option<PathBuf>>,
    pub others: Vec<NotGraded>,
}

/// A file that is not graded.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NotGraded {
    /// The name in whose folder it is, if it is in one.
    pub name: Option<String>,
    /// Its path in that folder.
    pub file: String,
    pub reason: Reason,
    /// The picture that it is probably meant for.
    pub meant_for: Option<String>,
}

/// The reason why a file is not graded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reason {
    /// It does not lie in the folder of a name.
    OutsideFolders,
    /// Another file is graded as the picture that it is meant for.
    OtherIsGraded,
    NoReference,
    UnreadFormat,
    NoPicture,
    Link,
    Special,
    /// A folder in which no files are looked for.
    Unlisted,
    Unreadable,
}

/// The number of files that are named for a picture that they may be meant for.
const NAMED: usize = 2;
/// The largest number of letters in which a misspelt name differs.
const MISSPELT: usize = 2;
/// A name of fewer letters is not recognised if it is misspelt.
const SHORTEST_MISSPELT: usize = 5;

impl Reason {
    pub fn words(self) -> &'static str {
        match self {
            Self::OutsideFolders => "not in the folder of a name",
            Self::OtherIsGraded => "another file is graded",
            Self::NoReference => "no reference",
            Self::UnreadFormat => "its format is not read",
            Self::NoPicture => "not a picture",
            Self::Link => "it is a link",
            Self::Special => "it is not a regular file",
            Self::Unlisted => "a folder that is too deep or has too many files",
            Self::Unreadable => "the folder cannot be read",
        }
    }
}

impl Serialize for Reason {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.words())
    }
}

impl NotGraded {
    /// Returns the reason and the picture that it is probably meant for.
    pub fn words(&self) -> String {
        let reason = self.reason.words();
        match &self.meant_for {
            Some(picture) if self.reason == Reason::OtherIsGraded => format!("{reason} as {picture}"),
            Some(picture) => format!("{reason}; probably {picture}"),
            None => reason.to_owned(),
        }
    }

    /// Returns its path from the folder of all names.
    pub fn path(&self) -> String {
        let folder = self.name.as_ref().map_or(String::new(), |name| format!("{name}/"));
        folder + &self.file
    }
}

impl Pairing {
    /// Finds the wanted pictures among the files of a name.
    pub fn new(name: &OsStr, files: &[Listed], wanted: &[&OsStr]) -> Self {
        let mut of_stem: HashMap<String, Vec<&Listed>> = HashMap::new();
        for file in files {
            of_stem.entry(stem(file.path.as_os_str()).to_lowercase()).or_default().push(file);
        }
        let names: HashSet<&OsStr> = wanted.iter().copied().collect();
        let taken_for = |picture: &&OsStr| {
            let files = of_stem.get(&stem(picture).to_lowercase())?;
            taken_for(picture, files, &names)
        };
        let taken: Vec<Option<PathBuf>> = wanted.iter().map(taken_for).collect();

        let all_parts: Vec<Vec<String>> = wanted.iter().map(|name| parts(name)).collect();
        let taken_paths: HashSet<&PathBuf> = taken.iter().flatten().collect();
        let not_graded = |Listed { path, kind }: &Listed| {
            let is_read = Format::of_input(path).is_some();
            let is_picture = is_read || Format::is_unread_picture(path);
            let meant_for = meant_for(path, is_picture, &all_parts);
            let reason = match kind {
                Kind::Folder => return None,
                Kind::Refused(reason) => *reason,
                Kind::Regular if meant_for.is_some_and(|index| taken[index].is_some()) => {
                    Reason::OtherIsGraded
                }
                Kind::Regular if is_read => Reason::NoReference,
                Kind::Regular if is_picture || meant_for.is_some() => Reason::UnreadFormat,
                Kind::Regular => Reason::NoPicture,
            };
            Some(NotGraded {
                name: Some(text(name)),
                file: text(path.as_os_str()),
                reason,
                meant_for: meant_for.map(|index| text(wanted[index])),
            })
        };
        let others = files.iter().filter(|file| !taken_paths.contains(&file.path));
        let others = others.filter_map(not_graded).collect();
        Self { taken, others }
    }

    /// Returns the files that are not taken but are probably meant for a wanted picture, and the reason of the first.
    pub fn meant_for(&self, picture: &OsStr) -> Option<String> {
        let picture = text(picture);
        let is_meant = |file: &&NotGraded| file.meant_for.as_ref() == Some(&picture);
        let meant: Vec<&NotGraded> = self.others.iter().filter(is_meant).collect();
        let reason = meant.first()?.reason.words();
        let named: Vec<&str> = meant.iter().take(NAMED).map(|file| file.file.as_str()).collect();
        let more = meant.len().saturating_sub(NAMED);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        Some(format!("{}{more}: {reason}", named.join(", ")))
    }
}

fn text(name: &OsStr) -> String {
    name.to_string_lossy().into_owned()
}

/// Returns the last name of a path without its ending.
fn stem(path: &OsStr) -> String {
    Path::new(path).file_stem().map_or(String::new(), text)
}

/// Returns the path of the file that is taken for this picture: the picture's own name, or else a file whose name has
/// another ending or case, or that lies in a folder. The files have the picture's name without its ending, in any case.
fn taken_for(picture: &OsStr, files: &[&Listed], wanted: &HashSet<&OsStr>) -> Option<PathBuf> {
    if files.iter().any(|file| file.path == Path::new(picture)) {
        return Some(picture.into());
    }
    let pictures = files.iter().filter(|file| file.kind == Kind::Regular).map(|file| &file.path);
    let pictures = pictures.filter(|path| Format::of_input(path).is_some());
    let alike = pictures.filter_map(|path| Some((mismatch(path, picture, wanted)?, path)));
    alike.min().map(|(_, path)| path.clone())
}

/// The difference between the path of a file and a picture's name. The first field that differs decides which of two is
/// less.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Mismatch {
    /// The number of folders around the file.
    depth: usize,
    has_other_case: bool,
    has_other_ending: bool,
}

/// Returns the difference between the path of a file and a picture's name, or `None` if the file is another wanted
/// picture.
fn mismatch(file: &Path, picture: &OsStr, wanted: &HashSet<&OsStr>) -> Option<Mismatch> {
    let name = file.file_name()?;
    let depth = file.components().count() - 1;
    if wanted.contains(name) && (depth == 0 || name != picture) {
        return None;
    }
    Some(Mismatch {
        depth,
        has_other_case: stem(name) != stem(picture),
        has_other_ending: Path::new(name).extension() != Path::new(picture).extension(),
    })
}

/// Returns the index of the only wanted picture whose name has the words and numbers of this file's name; or else of the
/// one whose words and numbers occur in it in a row, as in "Copy of o 1.tga". A picture may also have the same numbers
/// alone, or be misspelt. `all` are the words and numbers of each wanted picture.
fn meant_for(file: &Path, is_picture: bool, all: &[Vec<String>]) -> Option<usize> {
    let own = parts(file.file_name()?);
    let only = |is_like: &dyn Fn(&[String]) -> bool| {
        let mut like = (0..all.len()).filter(|&index| is_like(&all[index]));
        like.next().filter(|_| like.next().is_none())
    };
    let contains = |parts: &[String]| {
        let is_telling = parts.len() > 1 || own.starts_with(parts);
        is_telling && !parts.is_empty() && own.windows(parts.len()).any(|some| some == parts)
    };
    let longest = all.iter().filter(|parts| contains(parts)).map(Vec::len).max();
    let found = only(&|parts| parts == own)
        .or_else(|| only(&|parts| Some(parts.len()) == longest && contains(parts)));
    if found.is_some() || !is_picture {
        return found;
    }
    let own_numbers = numbers(&own);
    let own_letters = letters(&own);
    let is_misspelt = |parts: &[String]| {
        let letters = letters(parts);
        letters.len() >= SHORTEST_MISSPELT && strsim::levenshtein(&letters, &own_letters) <= MISSPELT
    };
    let has_numbers = |parts: &[String]| numbers(parts) == own_numbers;
    only(&|parts| has_numbers(parts) && is_misspelt(parts))
        .or_else(|| only(&|parts| has_numbers(parts) && !own_numbers.is_empty()))
}

/// Returns the words and numbers of a name, in small letters and without zeros before a number. Leaves out the endings,
/// of which a file such as `o.tga.bak` has several, and "copy of".
fn parts(name: &OsStr) -> Vec<String> {
    let name = name.to_string_lossy().to_lowercase();
    let mut stem = name.trim_end_matches('~');
    while let Some((rest, ending)) = stem.rsplit_once('.') {
        let is_ending = ending.len() <= 5 && ending.starts_with(char::is_alphabetic);
        if rest.is_empty() || !is_ending {
            break;
        }
        stem = rest;
    }
    let mut parts: Vec<String> = vec![];
    let mut last = ' ';
    for character in stem.chars() {
        let goes_on = last.is_alphanumeric() && last.is_numeric() == character.is_numeric();
        match parts.last_mut() {
            _ if !character.is_alphanumeric() => {}
            Some(part) if goes_on => part.push(character),
            _ => parts.push(character.into()),
        }
        last = character;
    }
    for part in parts.iter_mut().filter(|part| is_number(part)) {
        let digits = part.trim_start_matches('0');
        *part = if digits.is_empty() { "0".into() } else { digits.into() };
    }
    match parts.as_slice() {
        [copy, of, rest @ ..] if copy == "copy" && of == "of" => rest.to_vec(),
        _ => parts,
    }
}

fn is_number(part: &str) -> bool {
    part.starts_with(char::is_numeric)
}

fn numbers(parts: &[String]) -> Vec<&String> {
    parts.iter().filter(|part| is_number(part)).collect()
}

fn letters(parts: &[String]) -> String {
    parts.iter().filter(|part| !is_number(part)).map(String::as_str).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const WANTED: [&str; 5] =
        ["output4_02.tga", "output4_13.tga", "output4_1.tga", "output6_02_depth.tga", "output6_02.tga"];

    fn pairing(files: &[&str]) -> Pairing {
        let listed = |path: &&str| Listed { path: path.into(), kind: Kind::Regular };
        let files: Vec<Listed> = files.iter().map(listed).collect();
        Pairing::new(OsStr::new("ann"), &files, &WANTED.map(OsStr::new))
    }

    #[test]
    fn files_that_are_not_graded_have_a_reason_and_a_picture_that_they_may_be_meant_for() {
        use Reason::{NoPicture, NoReference, UnreadFormat};
        for (file, reason, meant_for) in [
            ("output4_02 (1).tga", NoReference, Some(0)),
            ("Copy of output4_02.tga", NoReference, Some(0)),
            ("output4_02 - Copy.png", NoReference, Some(0)),
            ("output4_02_final2.tga", NoReference, Some(0)),
            ("deep/output4_2.tga", NoReference, Some(0)),
            ("outptu4_02.tga", NoReference, Some(0)),
            ("4_02.ppm", NoReference, Some(0)),
            ("scene4_13.png", NoReference, Some(1)),
            ("output4_13.JPG", UnreadFormat, Some(1)),
            ("output4_13.tga.bak", UnreadFormat, Some(1)),
            ("output4_13.tga~", UnreadFormat, Some(1)),
            ("output4_13.webp", UnreadFormat, Some(1)),
            ("output6_02_depth (2).tga", NoReference, Some(3)),
            ("output6_02 (2).tga", NoReference, Some(4)),
            ("output4_14.tga", NoReference, None),
            ("output4_130.tga", NoReference, None),
            ("holiday.gif", UnreadFormat, None),
            ("tracer.cpp", NoPicture, None),
            ("scene4_13.txt", NoPicture, None),
            ("Makefile", NoPicture, None),
        ] {
            let found = pairing(&[file]);
            let meant_for = meant_for.map(|index: usize| WANTED[index].to_owned());
            let expected = NotGraded { name: Some("ann".into()), file: file.into(), reason, meant_for };
            assert_eq!((found.taken, found.others), (vec![None; 5], vec![expected]), "{file}");
        }
    }

    #[test]
    fn only_regular_files_are_taken_under_other_names() {
        let kind = Kind::Refused(Reason::Link);
        let pairing = |path: &str| {
            let file = Listed { path: path.into(), kind };
            Pairing::new(OsStr::new("ann"), &[file], &WANTED.map(OsStr::new))
        };
        let found = pairing("a/output4_02.tga");
        assert_eq!((found.taken[0].clone(), found.others[0].reason), (None, Reason::Link));
        assert_eq!(pairing("output4_02.tga").taken[0], Some("output4_02.tga".into()));
    }
}
