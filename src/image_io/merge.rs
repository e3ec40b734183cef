//! Parts of a picture are put together, row by row.

use super::error::ImageError;
use super::part::{Part, PartFile, Rows};
use super::writer::PictureWriter;
use crate::base::escape::quoted;
use crate::picture::{CHANNELS, Window};
use std::path::PathBuf;

/// Parts that cover a picture, or a region of it.
#[derive(Debug)]
pub struct Merge {
    /// From the top.
    parts: Vec<PartFile>,
    /// The place of the result in the whole.
    target: Window,
    /// What the result is a part of, unless it is the whole.
    pub part: Option<Part>,
}

impl Merge {
    /// Opens parts, in any order, and checks that they are parts of one picture and cover it, or the region of it that
    /// is asked for. Their pixels are not read yet.
    pub fn open(paths: &[PathBuf], region: Option<Window>) -> Result<Self, ImageError> {
        let mut parts = paths.iter().map(|path| PartFile::open(path)).collect::<Result<Vec<_>, _>>()?;
        let failed = |problem| Err(ImageError::Parts(problem));
        let Some(PartFile { path, part: first, .. }) = parts.first().cloned() else {
            return failed("there are no parts".into());
        };
        for PartFile { path: other, part, .. } in &parts {
            let ([w, h], [w0, h0]) = (part.whole, first.whole);
            let difference = match part.fingerprint == first.fingerprint {
                _ if [w, h] != [w0, h0] => format!("of {w} x {h} pixels instead of {w0} x {h0}"),
                false => "of another layer, scene, mesh, flag or version of this program".into(),
                true => continue,
            };
            let [other, path] = [other, &path].map(quoted);
            return failed(format!("{other} and {path} do not belong together: the former is {difference}"));
        }
        let [width, height] = first.whole.map(|side| side as usize);
        let target = region.unwrap_or(Window { x: 0, y: 0, width, height });
        if !target.fits([width, height]) {
            return failed(format!("`-region`: not within the whole picture of {width} x {height} pixels"));
        }
        if let Some(Window { x, y, width, height }) = first_gap(&parts, target) {
            return failed(format!("a part is missing: `-region {x} {y} {width} {height}`"));
        }
        parts.retain(|part| part.window.overlaps(&target));
        parts.sort_by_key(|part| part.window.y);
        let is_part = [target.width, target.height] != [width, height];
        let part = is_part.then(|| Part { at: [target.x, target.y].map(|n| n as u32), ..first });
        Ok(Self { parts, target, part })
    }

    /// Width and height of the result in pixels.
    pub fn size(&self) -> [usize; 2] {
        [self.target.width, self.target.height]
    }

    /// Hands the rows to the writer, and calls `watch` with their number after each. Only files that the current row
    /// crosses are open.
    pub fn write(&self, writer: &mut PictureWriter, watch: &dyn Fn(usize)) -> Result<(), ImageError> {
        let mut row = vec![0; self.target.width * CHANNELS];
        let mut waiting = self.parts.iter().peekable();
        let mut open: Vec<OpenPart> = vec![];
        for y in self.target.y..self.target.bottom() {
            while let Some(file) = waiting.next_if(|part| part.window.y <= y) {
                let mut part = OpenPart { file, rows: Rows::open(&file.path)?, row: vec![] };
                (file.window.y..y).try_for_each(|_| part.rows.next(&mut part.row))?;
                open.push(part);
            }
            open.sort_by_key(|part| part.file.window.x);
            self.fill(&mut row, y, &mut open)?;
            writer.row_of_bytes(&row)?;
            open.retain(|part| part.file.window.bottom() > y + 1);
            watch(y + 1 - self.target.y);
        }
        Ok(())
    }

    /// Puts row `y` together. The parts are sorted from the left, and leave no gap. Where they overlap they must agree.
    fn fill(&self, row: &mut [u8], y: usize, parts: &mut [OpenPart]) -> Result<(), ImageError> {
        let (left, right) = (self.target.x, self.target.right());
        let mut filled = left;
        for index in 0..parts.len() {
            let OpenPart { file, rows, row: bytes } = &mut parts[index];
            rows.next(bytes)?;
            let [start, end] = [file.window.x, file.window.right()].map(|x| x.clamp(left, right));
            let seam = filled.clamp(start, end);
            let own = &bytes[(start - file.window.x) * CHANNELS..(end - file.window.x) * CHANNELS];
            let (known, new) = row[(start - left) * CHANNELS..(end - left) * CHANNELS]
                .split_at_mut((seam - start) * CHANNELS);
            if let Some(byte) = known.iter().zip(own).position(|(a, b)| a != b) {
                let x = start + byte / CHANNELS;
                let path = quoted(&file.path);
                let other = parts[..index].iter().find(|part| part.file.window.right() > x);
                let other = other.map_or(String::new(), |other| quoted(&other.file.path));
                return Err(ImageError::Parts(format!(
                    "{other} and {path} overlap and differ at ({x}, {y})"
                )));
            }
            new.copy_from_slice(&own[known.len()..]);
            filled = filled.max(end);
        }
        Ok(())
    }
}

/// A part that is being read.
struct OpenPart<'p> {
    file: &'p PartFile,
    rows: Rows,
    /// Its bytes of the current row.
    row: Vec<u8>,
}

/// Returns the first pixels of `target` that no part covers, by rows from the top and then from the left: the columns
/// that lack, in as many rows as lack them all.
fn first_gap(parts: &[PartFile], target: Window) -> Option<Window> {
    // A gap begins in the first row or where a part ends.
    let mut starts: Vec<usize> = parts.iter().map(|part| part.window.bottom()).chain([target.y]).collect();
    starts.retain(|y| (target.y..target.bottom()).contains(y));
    starts.sort_unstable();
    starts.into_iter().find_map(|y| {
        let windows = || parts.iter().map(|part| part.window);
        let mut row: Vec<Window> = windows().filter(|part| (part.y..part.bottom()).contains(&y)).collect();
        row.sort_unstable_by_key(|part| part.x);
        let x = row.iter().fold(target.x, |x, part| if part.x <= x { x.max(part.right()) } else { x });
        let end =
            row.iter().map(|part| part.x).find(|&start| start > x).unwrap_or(usize::MAX).min(target.right());
        let below = windows().filter(|part| part.y > y && part.x < end && x < part.right());
        let bottom = below.map(|part| part.y).min().unwrap_or(usize::MAX).min(target.bottom());
        (x < end).then(|| Window { x, y, width: end - x, height: bottom - y })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_gap_is_as_large_as_it_can_be() {
        let window = |[x, y, width, height]: [usize; 4]| Window { x, y, width, height };
        for (tiles, target, gap) in [
            (&[][..], [0, 0, 9, 7], Some([0, 0, 9, 7])),
            (&[[0, 0, 9, 7]], [0, 0, 9, 7], None),
            (&[[0, 0, 9, 3], [0, 3, 9, 4]], [0, 0, 9, 7], None),
            (&[[0, 4, 9, 3], [0, 0, 9, 3]], [0, 0, 9, 7], Some([0, 3, 9, 1])),
            (&[[0, 0, 4, 7], [5, 0, 4, 7]], [0, 0, 9, 7], Some([4, 0, 1, 7])),
            (&[[0, 0, 4, 7], [5, 0, 4, 4], [3, 5, 6, 2]], [0, 0, 9, 7], Some([4, 0, 1, 5])),
            (&[[0, 0, 9, 2], [0, 2, 3, 5], [6, 2, 3, 5], [3, 4, 1, 1]], [0, 0, 9, 7], Some([3, 2, 3, 2])),
            (&[[0, 0, 9, 5], [0, 3, 9, 4]], [0, 0, 9, 7], None),
            (&[[0, 0, 9, 7]], [2, 2, 9, 3], Some([9, 2, 2, 3])),
            (&[[0, 0, 2, 9], [20, 0, 2, 9]], [3, 2, 4, 3], Some([3, 2, 4, 3])),
            (&[[3, 2, 4, 3]], [3, 2, 4, 3], None),
            (&[[0, 0, 8, 7]], [0, 0, 9, 7], Some([8, 0, 1, 7])),
            (&[[0, 0, 9, 3], [0, 6, 9, 1]], [0, 0, 9, 7], Some([0, 3, 9, 3])),
        ] {
            let part = Part { whole: [9, 7], at: [0, 0], fingerprint: 0 };
            let file = |tile| PartFile { path: "a.tga".into(), part: part.clone(), window: window(tile) };
            let tiles: Vec<PartFile> = tiles.iter().copied().map(file).collect();
            assert_eq!(first_gap(&tiles, window(target)), gap.map(window), "{tiles:?}");
        }
    }
}
