//! Parts of a picture are put together, row by row.

use super::error::ImageError;
use super::mosaic::first_gap;
use super::part::Part;
use super::part_file::{PartFile, Rows};
use super::writer::PictureWriter;
use crate::escape::quoted;
use crate::picture::CHANNELS;
use crate::render::{Progress, Window};
use std::fmt;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Parts that cover a picture, or a part of it.
#[derive(Debug)]
pub struct Merge {
    /// From the top.
    parts: Vec<PartFile>,
    target: Window,
}

/// Why parts are not put together.
#[derive(Debug)]
pub enum MergeError {
    /// A part cannot be read.
    Image(ImageError),
    /// Two parts whose wholes differ.
    Mixed {
        /// A part.
        part: PathBuf,
        /// The first part.
        first: PathBuf,
        /// In what they differ.
        difference: Difference,
    },
    /// What is to be put together is not in the picture.
    Outside {
        /// Width and height of the whole.
        whole: [u32; 2],
    },
    /// A part is missing.
    Gap(Window),
    /// Two parts that overlap, with different pixels.
    Disagree {
        /// The two files.
        files: [PathBuf; 2],
        /// Column and row of the first pixel that differs, in the whole.
        pixel: [usize; 2],
    },
    /// The watch has ended the work.
    Ended,
}

/// In what two parts of different pictures differ: what the one is, and what the other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Difference {
    /// The size of the whole.
    Size([u32; 2], [u32; 2]),
    /// What the picture shows.
    Kind(String, String),
    /// The scene, its meshes, the flags, or the version of the program.
    Fingerprint,
}

impl Difference {
    /// How a part's whole differs from that of another.
    fn of(part: &Part, other: &Part) -> Option<Self> {
        if part.whole != other.whole {
            Some(Self::Size(part.whole, other.whole))
        } else if part.kind != other.kind {
            Some(Self::Kind(part.kind.clone(), other.kind.clone()))
        } else {
            (part.fingerprint != other.fingerprint).then_some(Self::Fingerprint)
        }
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size([w, h], [w0, h0]) => write!(f, "of {w} x {h} pixels instead of {w0} x {h0}"),
            Self::Kind(kind, first) => write!(f, "of {} instead of {}", quoted(kind), quoted(first)),
            Self::Fingerprint => {
                f.write_str("of another scene, of other flags or of another version of this program")
            }
        }
    }
}

impl fmt::Display for MergeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Image(error) => error.fmt(f),
            Self::Mixed { part, first, difference } => {
                write!(
                    f,
                    "{} and {} do not belong together: the former is {difference}",
                    quoted(part),
                    quoted(first)
                )
            }
            Self::Outside { whole: [w, h] } => {
                write!(f, "`-region`: not within the whole picture of {w} x {h} pixels")
            }
            Self::Gap(Window { x, y, width, height }) => {
                write!(f, "a part is missing: `-region {x} {y} {width} {height}`")
            }
            Self::Disagree { files: [a, b], pixel: [x, y] } => {
                write!(f, "{} and {} overlap and differ at ({x}, {y})", quoted(a), quoted(b))
            }
            Self::Ended => f.write_str("ended before all parts were read; nothing is written"),
        }
    }
}

impl std::error::Error for MergeError {}

impl From<ImageError> for MergeError {
    fn from(error: ImageError) -> Self {
        Self::Image(error)
    }
}

impl Merge {
    /// Opens parts, in any order, and checks that they are parts of one picture and cover it, or the region of it that
    /// is asked for. Their pixels are not read yet.
    pub fn open(paths: &[PathBuf], region: Option<Window>) -> Result<Self, MergeError> {
        let mut parts = paths.iter().map(|path| PartFile::open(path)).collect::<Result<Vec<_>, _>>()?;
        let target = match Self::target(&parts, region) {
            Ok(target) => target,
            Err(error) => {
                // A part that is damaged may seem to lie elsewhere.
                parts.iter().try_for_each(PartFile::check)?;
                return Err(error);
            }
        };
        parts.retain(|part| overlap(&part.window(), &target));
        parts.sort_by_key(|part| part.part.at[1]);
        Ok(Self { parts, target })
    }

    /// The place of the result in the whole, which the parts cover.
    fn target(parts: &[PartFile], region: Option<Window>) -> Result<Window, MergeError> {
        let Some(first) = parts.first() else {
            return Err(MergeError::Gap(region.unwrap_or(Window { x: 0, y: 0, width: 1, height: 1 })));
        };
        for other in parts {
            if let Some(difference) = Difference::of(&other.part, &first.part) {
                let (part, first) = (other.path.clone(), first.path.clone());
                return Err(MergeError::Mixed { part, first, difference });
            }
        }
        let whole = first.part.whole;
        let [width, height] = whole.map(|n| n as usize);
        let target = region.unwrap_or(Window { x: 0, y: 0, width, height });
        if target.x + target.width > width || target.y + target.height > height {
            return Err(MergeError::Outside { whole });
        }
        let tiles: Vec<Window> = parts.iter().map(PartFile::window).collect();
        if let Some(gap) = first_gap(&tiles, target) {
            return Err(MergeError::Gap(gap));
        }
        Ok(target)
    }

    /// Width and height of the result in pixels.
    pub fn size(&self) -> [usize; 2] {
        [self.target.width, self.target.height]
    }

    /// What the result is a part of; none if it is the whole.
    pub fn part(&self) -> Option<Part> {
        let part = &self.parts.first()?.part;
        let Window { x, y, width, height } = self.target;
        let is_whole = part.whole.map(|n| n as usize) == [width, height];
        (!is_whole).then(|| Part { at: [x, y].map(|n| n as u32), ..part.clone() })
    }

    /// Hands the rows to the writer. The watch is told after each row, and may end the work. Only files that the
    /// current row crosses are open.
    pub fn write(
        &self,
        writer: &mut PictureWriter,
        watch: &dyn Fn(Progress) -> ControlFlow<()>,
    ) -> Result<(), MergeError> {
        let Window { y: top, height, width, .. } = self.target;
        let mut row = vec![0; width * CHANNELS];
        let mut waiting = self.parts.iter().peekable();
        let mut open: Vec<OpenPart> = Vec::new();
        for y in top..top + height {
            open.retain(|part| y < part.window.y + part.window.height);
            while let Some(part) = waiting.next_if(|part| part.window().y <= y) {
                if y < part.window().y + part.window().height {
                    open.push(OpenPart::at_row(part, y)?);
                }
            }
            open.sort_by_key(|part| part.window.x);
            self.fill(&mut row, y, &mut open)?;
            writer.row_of_bytes(&row)?;
            if y + 1 == top + height {
                open.iter_mut().try_for_each(|part| part.rows.check_rest())?;
            }
            if watch(Progress { done: y + 1 - top, rows: height, rays: 0 }).is_break() {
                return Err(MergeError::Ended);
            }
        }
        Ok(())
    }

    /// Puts row `y` together. The parts are sorted from the left, and leave no gap.
    fn fill(&self, row: &mut [u8], y: usize, parts: &mut [OpenPart]) -> Result<(), MergeError> {
        let left = self.target.x;
        let right = left + self.target.width;
        let mut filled = left;
        for index in 0..parts.len() {
            let part = &mut parts[index];
            part.rows.next(&mut part.row)?;
            let Window { x, width, .. } = part.window;
            let [start, end] = [x, x + width].map(|x| x.clamp(left, right));
            let own = |from: usize, to: usize| &part.row[(from - x) * CHANNELS..(to - x) * CHANNELS];
            let seam = filled.clamp(start, end);
            let known = &row[(start - left) * CHANNELS..(seam - left) * CHANNELS];
            let first = own(start, seam).iter().zip(known).position(|(a, b)| a != b);
            if let Some(byte) = first {
                let pixel = [start + byte / CHANNELS, y];
                return Err(disagreement(parts, index, pixel)?);
            }
            row[(seam - left) * CHANNELS..(end - left) * CHANNELS].copy_from_slice(own(seam, end));
            filled = filled.max(end);
        }
        Ok(())
    }
}

/// Whether two windows share a pixel.
fn overlap(a: &Window, b: &Window) -> bool {
    a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height
}

/// The part with this index has another pixel than one to its left. An error also if one of them is damaged.
fn disagreement(parts: &mut [OpenPart], index: usize, pixel: [usize; 2]) -> Result<MergeError, ImageError> {
    let has = |part: &&OpenPart| (part.window.x..part.window.x + part.window.width).contains(&pixel[0]);
    let other = parts[..index].iter().position(|part| has(&part)).unwrap_or(index);
    [other, index].into_iter().try_for_each(|index| parts[index].rows.check_rest())?;
    let files = [other, index].map(|index| parts[index].path.to_owned());
    Ok(MergeError::Disagree { files, pixel })
}

/// A part that is being read.
struct OpenPart<'p> {
    path: &'p Path,
    window: Window,
    rows: Rows,
    /// Its bytes of the current row.
    row: Vec<u8>,
}

impl<'p> OpenPart<'p> {
    /// A part whose next row is row `y` of the whole.
    fn at_row(part: &'p PartFile, y: usize) -> Result<Self, ImageError> {
        let (window, mut rows, mut row) = (part.window(), part.rows()?, Vec::new());
        (window.y..y).try_for_each(|_| rows.next(&mut row))?;
        Ok(Self { path: &part.path, window, rows, row })
    }
}
