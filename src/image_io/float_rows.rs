//! Rows of numbers in single precision, neither clamped nor cut, for PFM and OpenEXR files.

use super::exr::{self, ChunkPlace};
use super::part::Part;
use crate::scene::Color;

/// What the colours of a picture mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Red, green and blue, or the coordinates of normals.
    Colors,
    /// Distances, equal in all channels, and infinite where there is nothing.
    Distances,
}

/// The pixels whose colours are not shown, or not as they are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Exceptional {
    /// Those that are black in a file of bytes because a channel is not a number.
    pub black: u64,
    /// Those that have a NaN in a file of floating-point numbers.
    pub nan: u64,
    /// Those with a number that is infinite in a file of floating-point numbers, or a distance that is 0 there, because
    /// single precision ends at about 3.4e38 and 1.4e-45.
    pub out_of_range: u64,
}

impl std::ops::AddAssign for Exceptional {
    fn add_assign(&mut self, other: Self) {
        self.black += other.black;
        self.nan += other.nan;
        self.out_of_range += other.out_of_range;
    }
}

/// Encodes the rows of one file.
pub(super) struct FloatRows {
    /// Whether the format is PFM, where three lines of text for the kind, the size and the byte order precede the
    /// rows; else it is OpenEXR.
    is_pfm: bool,
    content: Content,
    size: [u16; 2],
    /// OpenEXR says where a part lies.
    place: ChunkPlace,
    /// The number of rows that have been encoded.
    rows: usize,
    pub exceptional: Exceptional,
}

impl FloatRows {
    /// None if a side is longer than 65535 pixels.
    pub fn new(
        is_pfm: bool,
        content: Content,
        [width, height]: [usize; 2],
        part: Option<&Part>,
    ) -> Option<Self> {
        let size = [u16::try_from(width).ok()?, u16::try_from(height).ok()?];
        let short = |[x, y]: [u32; 2]| Some([u16::try_from(x).ok()?, u16::try_from(y).ok()?]);
        let place = match part {
            Some(part) => ChunkPlace { whole: short(part.whole)?, at: short(part.at)? },
            None => ChunkPlace { whole: size, at: [0, 0] },
        };
        Some(Self { is_pfm, content, size, place, rows: 0, exceptional: Exceptional::default() })
    }

    /// What precedes the rows.
    pub fn header(&self) -> Vec<u8> {
        let [width, height] = self.size;
        match (self.is_pfm, self.content) {
            // The negative number says that the lowest byte comes first.
            (true, Content::Colors) => format!("PF\n{width} {height}\n-1.0\n").into(),
            (true, Content::Distances) => format!("Pf\n{width} {height}\n-1.0\n").into(),
            (false, Content::Colors) => exr::header(self.size, self.place, &["B", "G", "R"]),
            (false, Content::Distances) => exr::header(self.size, self.place, &["Z"]),
        }
    }

    /// The length of each row in bytes.
    pub fn row_length(&self) -> usize {
        let start = if self.is_pfm { 0 } else { exr::row_start(0, 0).len() };
        start + self.numbers() * size_of::<f32>()
    }

    fn numbers(&self) -> usize {
        let channels = if self.content == Content::Colors { 3 } else { 1 };
        usize::from(self.size[0]) * channels
    }

    /// Replaces `bytes` by those of the next row from the top.
    pub fn encode(&mut self, colors: &[Color], bytes: &mut Vec<u8>) {
        bytes.clear();
        colors.iter().for_each(|&color| self.inspect(color));
        if !self.is_pfm {
            bytes.extend_from_slice(&exr::row_start(
                usize::from(self.place.at[1]) + self.rows,
                self.numbers(),
            ));
        }
        let mut push = |number: f64| bytes.extend_from_slice(&(number as f32).to_le_bytes());
        match (self.is_pfm, self.content) {
            (_, Content::Distances) => colors.iter().for_each(|color| push(color.x)),
            (true, Content::Colors) => colors.iter().flat_map(Color::to_array).for_each(push),
            (false, Content::Colors) => {
                [2, 1, 0]
                    .into_iter()
                    .for_each(|channel| colors.iter().for_each(|color| push(color[channel])));
            }
        }
        self.rows += 1;
    }

    fn inspect(&mut self, color: Color) {
        let single = color.as_vec3();
        if color.is_nan() {
            self.exceptional.nan += 1;
        } else if match self.content {
            Content::Colors => !single.is_finite(),
            // An infinite distance says that there is nothing.
            Content::Distances => {
                color.is_finite() && (!single.is_finite() || single.x == 0.0 && color.x != 0.0)
            }
        } {
            self.exceptional.out_of_range += 1;
        }
    }
}
