//! The place of a part in a whole picture, which the file of the part states.
//!
//! A TGA file says it in its image ID, which follows the header and which viewers show as a comment; a PNG file in a
//! text chunk called `Comment`. The place stands there too, beside TGA's fields for the origin and PNG's chunk `oFFs`,
//! which other programs read.

use std::fmt;

/// The keyword of the text in a PNG file that says which part of a larger picture it is.
pub(super) const PNG_COMMENT: &str = "Comment";

/// The place of a picture in a whole one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Width and height of the whole picture in pixels.
    pub whole: [usize; 2],
    /// The part's top left pixel: its column and row in the whole, from the top left.
    pub at: [usize; 2],
    /// A hash of everything that the bytes of the whole picture depend on.
    pub fingerprint: u128,
}

impl Part {
    /// Reads what [`Display`](fmt::Display) writes.
    pub fn parse(text: &str) -> Option<Self> {
        let words: Vec<&str> = text.split(' ').collect();
        let ["part", "of", width, "x", height, "at", x, y, "fingerprint", fingerprint] = words[..] else {
            return None;
        };
        let number = |word: &str| Some(word.trim_end_matches([',', ';']).parse::<u32>().ok()? as usize);
        let whole = [number(width)?, number(height)?];
        let fingerprint = u128::from_str_radix(fingerprint, 16).ok()?;
        let part = Self { whole, at: [number(x)?, number(y)?], fingerprint };
        // Numbers can be written in other ways too.
        (part.to_string() == text).then_some(part)
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { whole: [width, height], at: [x, y], fingerprint } = self;
        write!(f, "part of {width} x {height} at {x}, {y}; fingerprint {fingerprint:032x}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_text_of_a_part_is_read_back_and_any_other_refused() {
        let part = Part { whole: [65535, 7], at: [0, 65534], fingerprint: 0xabc };
        let text = "part of 65535 x 7 at 0, 65534; fingerprint 00000000000000000000000000000abc";
        assert_eq!((part.to_string().as_str(), Part::parse(text)), (text, Some(part)));
        for text in [
            "",
            "made by hand",
            &text[1..],
            &text[..text.len() - 32],
            &text.replace("65535", "-1"),
            &text.replace("65535", "+65535"),
            &text.to_uppercase(),
            &format!("{text} "),
        ] {
            assert_eq!(Part::parse(text), None, "{text}");
        }
    }
}
