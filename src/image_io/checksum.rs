//! The checksum of a part of a picture.

use super::part::Part;
use crate::picture::CHANNELS;
use siphasher::sip::SipHasher13;
use std::fmt;
use std::hash::Hasher;
use std::str::FromStr;

/// What a file says about the part that it has, with its checksum. Its length does not depend on the checksum.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct CheckedPart {
    pub part: Part,
    /// That of the finished [`PartHasher`].
    pub checksum: u64,
}

const SEPARATOR: &str = "; checksum ";
impl fmt::Display for CheckedPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{SEPARATOR}{:016x}", self.part, self.checksum)
    }
}

/// Why a text is not that of a part with a checksum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unchecked {
    /// It is not that of a part.
    NotPart,
    /// The part has no checksum.
    NoChecksum,
}

impl FromStr for CheckedPart {
    type Err = Unchecked;

    fn from_str(text: &str) -> Result<Self, Unchecked> {
        let Some((part, checksum)) = text.split_once(SEPARATOR) else {
            let is_part = text.parse::<Part>().is_ok();
            return Err(if is_part { Unchecked::NoChecksum } else { Unchecked::NotPart });
        };
        let part = part.parse().map_err(|_| Unchecked::NotPart)?;
        let checksum = u64::from_str_radix(checksum, 16).map_err(|_| Unchecked::NotPart)?;
        let found = Self { part, checksum };
        // Numbers can be written in other ways too.
        if found.to_string() == text { Ok(found) } else { Err(Unchecked::NotPart) }
    }
}

/// Adds up the checksum of a part: SipHash-1-3 with 64 bits and a key of zeros, of what the part says about itself, its
/// width and height, and its rows from the top as bytes of red, green and blue. So it is the same in every format.
#[derive(Clone, Debug)]
pub(super) struct PartHasher(SipHasher13);

impl PartHasher {
    /// Width and height are in pixels.
    pub fn new(part: &Part, size: [u32; 2]) -> Self {
        let mut hasher = SipHasher13::new();
        let text = part.to_string();
        hasher.write(&(text.len() as u64).to_le_bytes());
        hasher.write(text.as_bytes());
        size.iter().for_each(|side| hasher.write(&side.to_le_bytes()));
        Self(hasher)
    }

    /// Adds the next row.
    pub fn row(&mut self, rgb: &[u8]) {
        self.0.write(rgb);
    }

    /// Adds the next row, in which blue comes first.
    pub fn row_of_bgr(&mut self, bgr: &[u8]) {
        const PIXELS: usize = 256;
        let mut rgb = [0; PIXELS * CHANNELS];
        for block in bgr.chunks(rgb.len()) {
            let rgb = &mut rgb[..block.len()];
            rgb.copy_from_slice(block);
            rgb.chunks_exact_mut(CHANNELS).for_each(|pixel| pixel.swap(0, 2));
            self.0.write(rgb);
        }
    }

    /// The checksum of all rows.
    pub fn finish(&self) -> u64 {
        self.0.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part() -> Part {
        Part { whole: [9, 7], at: [0, 3], kind: "color".into(), fingerprint: 0xabc }
    }

    #[test]
    fn the_text_is_read_back_and_any_other_refused() {
        let checked = CheckedPart { part: part(), checksum: 0x1f };
        let text = checked.to_string();
        assert!(text.ends_with("abc; checksum 000000000000001f"), "{text}");
        assert_eq!(text.parse(), Ok(checked));
        assert_eq!(part().to_string().parse::<CheckedPart>(), Err(Unchecked::NoChecksum));
        for other in
            [text.to_uppercase(), text.replace('f', "F"), format!("{text} "), text.replace("9", "+9")]
        {
            assert_eq!(other.parse::<CheckedPart>(), Err(Unchecked::NotPart), "{other}");
        }
    }

    #[test]
    fn the_checksum_tells_of_place_size_and_rows() {
        let of = |part: &Part, size, rows: &[&[u8]]| {
            let mut hasher = PartHasher::new(part, size);
            rows.iter().for_each(|row| hasher.row(row));
            hasher.finish()
        };
        let plain = of(&part(), [2, 1], &[&[1, 2, 3, 4, 5, 6]]);
        assert_eq!(plain, of(&part(), [2, 1], &[&[1, 2, 3], &[4, 5, 6]]));
        assert_ne!(plain, of(&part(), [1, 2], &[&[1, 2, 3], &[4, 5, 6]]));
        assert_ne!(plain, of(&Part { at: [0, 4], ..part() }, [2, 1], &[&[1, 2, 3, 4, 5, 6]]));
        assert_ne!(plain, of(&part(), [2, 1], &[&[1, 2, 3, 4, 5, 7]]));
        let mut swapped = PartHasher::new(&part(), [2, 1]);
        swapped.row_of_bgr(&[3, 2, 1, 6, 5, 4]);
        assert_eq!(plain, swapped.finish());
        let long: Vec<u8> = (0..3 * 1000).map(|i| (i % 251) as u8).collect();
        let mut bgr = long.clone();
        bgr.chunks_exact_mut(3).for_each(|pixel| pixel.swap(0, 2));
        let mut swapped = PartHasher::new(&part(), [1000, 1]);
        swapped.row_of_bgr(&bgr);
        assert_eq!(of(&part(), [1000, 1], &[&long]), swapped.finish());
    }
}
