//! What a picture file says about the whole that it is a part of.
//!
//! A TGA file says it in its image ID, which viewers show as a comment and which follows the header, so that the file
//! may have any length; a PNG file in a text chunk called `Comment`. The place stands there too, beside TGA's fields
//! for the origin and PNG's chunk `oFFs`, which other programs read. A checksum follows it.

use std::fmt;
use std::str::FromStr;

/// The place of a picture in a whole one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Width and height of the whole picture in pixels.
    pub whole: [u32; 2],
    /// The part's top left pixel: its column and row in the whole, from the top left.
    pub at: [u32; 2],
    /// What the picture shows, in one word.
    pub kind: String,
    /// A hash of everything that the bytes of the whole picture depend on.
    pub fingerprint: u128,
}

/// The length of the longest text of a part, in bytes.
pub(super) const MAX_TEXT: usize = 255;

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { whole: [width, height], at: [x, y], kind, fingerprint } = self;
        write!(f, "part of {width} x {height} at {x}, {y}; {kind}; fingerprint {fingerprint:032x}")
    }
}

/// A text that is not that of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotPart;

impl FromStr for Part {
    type Err = NotPart;

    fn from_str(text: &str) -> Result<Self, NotPart> {
        parse(text).ok_or(NotPart)
    }
}

fn parse(text: &str) -> Option<Part> {
    let (whole, rest) = text.strip_prefix("part of ")?.split_once(" at ")?;
    let (at, rest) = rest.split_once("; ")?;
    let (kind, fingerprint) = rest.split_once("; fingerprint ")?;
    let fingerprint = u128::from_str_radix(fingerprint, 16).ok()?;
    Some(Part { whole: pair(whole, " x ")?, at: pair(at, ", ")?, kind: kind.into(), fingerprint })
}

fn pair(text: &str, separator: &str) -> Option<[u32; 2]> {
    let (a, b) = text.split_once(separator)?;
    Some([a.parse().ok()?, b.parse().ok()?])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part() -> Part {
        Part { whole: [65535, 7], at: [0, 65534], kind: "color".into(), fingerprint: 0xabc }
    }

    #[test]
    fn the_text_of_a_part_is_read_back() {
        let text = "part of 65535 x 7 at 0, 65534; color; fingerprint 00000000000000000000000000000abc";
        assert_eq!((part().to_string().as_str(), text.parse()), (text, Ok(part())));
        let longest = Part { whole: [u32::MAX; 2], at: [u32::MAX; 2], fingerprint: u128::MAX, ..part() };
        assert!(longest.to_string().len() < MAX_TEXT);
    }

    #[test]
    fn other_texts_are_no_parts() {
        let text = part().to_string();
        for text in ["", "made by hand", &text[1..], &text[..text.len() - 32], &text.replace("65535", "-1")] {
            assert_eq!(text.parse::<Part>(), Err(NotPart), "{text}");
        }
    }
}
