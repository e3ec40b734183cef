//! The errors of the command line, and their messages.

use super::flag::{Flag, Offer};
use super::flags;
use crate::escape::quoted;
use crate::scene::edition::Edition;
use std::ffi::OsString;
use std::fmt;
use std::path::PathBuf;

/// An error in the command line. It is displayed as one line that names the flag. Names of flags are stored
/// without the dash.
#[derive(Clone, Debug, PartialEq)]
pub enum CliError {
    /// No flag has this name.
    UnknownFlag {
        /// The flag.
        flag: String,
        /// The flag that may have been meant.
        nearest: Option<String>,
    },
    /// A word that is not a value of any flag.
    UnexpectedWord {
        /// The word as given.
        word: OsString,
        /// The flag that may be missing before it.
        meant: Option<&'static str>,
    },
    /// A flag and its value written as `-flag=value`.
    EqualsForm {
        /// The flag.
        flag: String,
    },
    /// A flag that is given more than once.
    GivenTwice {
        /// The flag.
        flag: &'static str,
    },
    /// Two flags that exclude each other.
    Conflict {
        /// The flag.
        flag: &'static str,
        /// The other flag.
        other: &'static str,
    },
    /// A flag with too few or too many values.
    WrongCount {
        /// The flag.
        flag: &'static str,
        /// The number of values that it was given.
        given: usize,
    },
    /// A value that is not valid for its flag.
    BadValue {
        /// The flag.
        flag: &'static str,
        /// The word as given.
        word: OsString,
        /// The reason why the value is not valid.
        problem: Problem,
    },
    /// `-filter` of a picture below three pixels a side.
    ReducedToNothing,
    /// A flag that the named edition does not have.
    OtherEdition {
        /// The flag.
        flag: &'static str,
        /// The edition that has it.
        has_it: Edition,
        /// The edition that is named.
        named: Edition,
    },
    /// `-depth` with a `t0` that is not below `t1`.
    DepthOrder {
        /// The depth that is shown white.
        t0: f64,
        /// The depth that is shown black.
        t1: f64,
    },
    /// `-depth` with finite `t0` and `t1` whose difference overflows.
    DepthRange,
    /// A grid with more cells than 31-bit indices can tell apart.
    TooManyCells {
        /// The number of cells along each axis.
        cells: [u32; 3],
    },
    /// `-visualize_grid` without `-grid`.
    GridNeeded,
    /// `-pixel` with a place outside the picture.
    PixelOutside {
        /// The last column and the last row of the picture.
        last: [usize; 2],
    },
    /// `-region` with pixels outside the picture.
    RegionOutside {
        /// Width and height of the picture.
        size: [usize; 2],
    },
    /// A flag without another one that it needs.
    Needed {
        /// The flag.
        flag: &'static str,
        /// The other flag with the names of its values.
        needed: String,
    },
    /// A picture of samples or of the filter with a side that is too long.
    EnlargedTooMuch {
        /// The flag.
        flag: &'static str,
    },
    /// A command line without `-input` that does not compare two pictures either.
    InputNeeded,
    /// A flag about a comparison, without a picture to compare.
    ComparisonNeeded {
        /// The flag.
        flag: &'static str,
    },
    /// `-grade` without anything to grade by.
    ReferencesNeeded,
    /// Two flags that name the same output file.
    SameFile {
        /// The flag.
        flag: &'static str,
        /// The other flag.
        other: &'static str,
        /// The file that both name.
        file: PathBuf,
    },
    /// Two flags that write to standard output.
    SameStream {
        /// The flag.
        flag: &'static str,
        /// The other flag.
        other: &'static str,
    },
}

/// The reason why a value is not valid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Problem {
    /// It is not an integer.
    NotWhole,
    /// It is outside the allowed range.
    Outside {
        /// The smallest allowed value.
        min: u32,
        /// The largest allowed value.
        max: u32,
    },
    /// It is not a finite number.
    NotFinite,
    /// It is negative.
    Negative,
    /// It does not have the file extension of a picture.
    NotPicture,
    /// It does not have the file extension of a picture of bytes.
    NotBytes,
    /// It does not have the file extension of a picture that may be a part.
    NotPart,
    /// It is not the name of a format.
    NotFormat,
    /// It is standard output, and no format follows.
    NoFormat,
    /// It is neither a dash nor does it have the file extension of a JSON document.
    NotJson,
    /// It does not have the file extension of a page.
    NotPage,
    /// It is outside the range of filter sizes.
    NotFilterSize,
    /// It is the name of no edition.
    NotEdition,
    /// It is no kind of cost.
    NotCost,
    /// It stands beside other values.
    NotAlone,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotWhole => f.write_str("is not a whole number"),
            Self::Outside { min, max } => write!(f, "is not between {min} and {max}"),
            Self::NotFinite => f.write_str("is not a finite number"),
            Self::Negative => f.write_str("is negative"),
            Self::NotPage => f.write_str("does not end in .html"),
            Self::NotFilterSize => f.write_str("is not between 0.000001 and 1000000 pixels"),
            Self::NotJson => f.write_str("is neither - nor ends in .json"),
            Self::NotAlone => f.write_str("stands alone, in place of the three numbers"),
            Self::NotEdition => write!(f, "is none of the editions {}", Edition::NAMES.join(", ")),
            Self::NotCost => f.write_str("is none of rays, tests and cells"),
            Self::NotPicture => f.write_str("ends in none of .tga, .png, .bmp, .ppm, .pfm and .exr"),
            Self::NotBytes => f.write_str("ends in none of .tga, .png, .bmp and .ppm"),
            Self::NotPart => f.write_str("ends in neither .tga nor .png, as parts do"),
            Self::NotFormat => f.write_str("is none of the formats tga, png, bmp, ppm, pfm and exr"),
            Self::NoFormat => f.write_str("needs its format as the next word, as in `- png`"),
        }
    }
}

impl fmt::Display for CliError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message())
    }
}

impl CliError {
    fn message(&self) -> String {
        match self {
            Self::UnknownFlag { flag, nearest } => unknown_flag(flag, nearest.as_deref()),
            Self::UnexpectedWord { word, meant } => unexpected_word(word, *meant),
            Self::EqualsForm { flag } => format!("`-{flag}` takes its values as separate words, without `=`"),
            Self::GivenTwice { flag } => format!("`-{flag}` given twice"),
            Self::Conflict { flag, other } => format!("`-{flag}` cannot be combined with `-{other}`"),
            Self::WrongCount { flag, given } => wrong_count(flag, *given),
            Self::BadValue { flag, word, problem } => format!("`-{flag}`: {} {problem}", quoted(word)),
            Self::ReducedToNothing => {
                "`-filter`: a third of the picture's width or height is no pixel".into()
            }
            Self::OtherEdition { flag, has_it, named } => {
                format!("`-{flag}` is a flag of the edition {has_it}, not of {named}: `-edition {has_it}`")
            }
            Self::DepthOrder { t0, t1 } => format!("`-depth`: t0 must be less than t1, but {t0} >= {t1}"),
            Self::DepthRange => "`-depth`: t1 - t0 is too large for a number".into(),
            Self::TooManyCells { cells: [x, y, z] } => {
                format!("`-grid`: {x} x {y} x {z} cells are too many, 2147483647 is the most")
            }
            Self::GridNeeded => "`-visualize_grid` needs `-grid nx ny nz`".into(),
            Self::PixelOutside { last: [x, y] } => {
                format!("`-pixel`: outside the picture, whose columns are 0 to {x} and rows 0 to {y}")
            }
            Self::RegionOutside { size: [w, h] } => {
                format!("`-region`: not within the picture of {w} x {h} pixels")
            }
            Self::Needed { flag, needed } => format!("`-{flag}` needs `{needed}`"),
            Self::EnlargedTooMuch { flag } => {
                format!("`-{flag}`: the enlarged picture would be above 65535 pixels a side")
            }
            Self::InputNeeded => "no scene: `-input file` is required (`-h` lists the usual flags)".into(),
            Self::ComparisonNeeded { flag } => {
                format!("`-{flag}` needs a picture: `-compare file` or `-reference file`")
            }
            Self::ReferencesNeeded => "`-grade` needs `-reference folder` or `-commands file`".into(),
            Self::SameFile { flag, other, file } => {
                format!("`-{flag}` and `-{other}` both write {}", quoted(file))
            }
            Self::SameStream { flag, other } => {
                format!("`-{flag}` and `-{other}` both write to standard output")
            }
        }
    }
}

impl std::error::Error for CliError {}

fn unknown_flag(flag: &str, nearest: Option<&str>) -> String {
    let shown = quoted(format!("-{flag}"));
    match nearest {
        Some(nearest) => {
            // Who knows it by another name may not know its values.
            let meant = flags::meant(&flag.to_lowercase()).map(Flag::usage);
            let meant = meant.unwrap_or_else(|| format!("-{nearest}"));
            format!("unknown flag {shown}; did you mean `{meant}`?")
        }
        None => format!("unknown flag {shown} (`-help` lists every flag)"),
    }
}

fn unexpected_word(word: &OsString, meant: Option<&str>) -> String {
    let shown = quoted(word);
    match (word.to_str().and_then(flags::find), meant) {
        (Some(flag), _) => format!("unexpected word {shown}; did you mean `-{}`?", flag.name),
        (None, Some(flag)) => {
            let line = format!("-{flag} {}", word.to_string_lossy());
            format!("unexpected word {shown}; did you mean {}?", quoted(line))
        }
        (None, None) => format!("unexpected word {shown} (not the value of any flag)"),
    }
}

fn wrong_count(name: &str, given: usize) -> String {
    let Some(flag) = flags::find(name) else { return format!("`-{name}` takes another number of values") };
    let (expected, example) = (flag.values.len(), flag.example_or_usage());
    let alone = match flag.values.first() {
        Some(value) if flag.fewest < expected => value.offer,
        _ => Offer::Nothing,
    };
    match alone {
        _ if expected == 1 => format!("`-{name}` needs a value, as in `{example}`"),
        Offer::Words(words) => format!(
            "`-{name}` takes {expected} values, as in `{example}`, or one, which is `{}`; {given} given",
            words.join("` or `")
        ),
        _ => format!("`-{name}` takes {expected} values, as in `{example}`; {given} given"),
    }
}
