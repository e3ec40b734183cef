//! Joins the parts of a picture row by row.

use super::part::Part;
use super::rows::{PartFile, Rows};
use super::writer::PictureWriter;
use crate::base::escape::quoted;
use crate::diagnostic::Diagnostic;
use crate::picture::{CHANNELS, Window};
use std::path::PathBuf;

/// Parts that cover a picture, or a region of it.
#[derive(Debug)]
pub struct Merge {
    /// From the top.
    parts: Vec<PartFile>,
    /// The place of the result in the whole.
    target: Window,
    /// The place of the result in the whole picture; `None` if it is the whole.
    pub part: Option<Part>,
}

impl Merge {
    /// Opens parts, in any order, and checks that they are parts of one picture and cover it, or the region of it that
    /// is asked for. Their pixels are not read yet.
    pub fn open(paths: &[PathBuf], region: Option<Window>) -> Result<Self, Diagnostic> {
        let mut parts = paths.iter().map(|path| PartFile::open(path)).collect::<Result<Vec<_>, _>>()?;
        let failed = |problem: String| Err(Diagnostic::error(problem));
        let Some(first) = parts.first().cloned() else {
            return failed("there are no parts".into());
        };
        for part in &parts {
            let ([w, h], [w0, h0]) = (part.whole, first.whole);
            let difference = match part.fingerprint == first.fingerprint {
                _ if [w, h] != [w0, h0] => format!("of {w} x {h} pixels instead of {w0} x {h0}"),
                false => "of another layer, scene, mesh, flag or version of this program".into(),
                true => continue,
            };
            let [other, path] = [&part.path, &first.path].map(quoted);
            return failed(format!(
                "{other} and {path} are not parts of one picture: the first is {difference}"
            ));
        }
        let PartFile { whole, fingerprint, .. } = first;
        let target = region.unwrap_or(Window::whole(whole));
        if !target.fits(whole) {
            let [width, height] = whole;
            return failed(format!(
                "`-region` reaches beyond the whole picture of {width} x {height} pixels"
            ));
        }
        if let Some(Window { x, y, width, height }) = first_gap(&parts, target) {
            return failed(format!("a part is missing: `-region {x} {y} {width} {height}`"));
        }
        parts.retain(|part| part.window.overlaps(&target));
        parts.sort_by_key(|part| part.window.y);
        let is_part = target != Window::whole(whole);
        let part = is_part.then_some(Part { whole, at: [target.x, target.y], fingerprint });
        Ok(Self { parts, target, part })
    }

    /// Returns the width and height of the result in pixels.
    pub fn size(&self) -> [usize; 2] {
        [self.target.width, self.target.height]
    }

    /// Hands the rows to the writer, and calls `watch` with their number after each. Only files that the current row
    /// crosses are open.
    pub fn write(&self, writer: &mut PictureWriter, watch: &dyn Fn(usize)) -> Result<(), Diagnostic> {
        let target = self.target;
        let mut row = vec![[0; CHANNELS]; target.width];
        let mut bytes = vec![];
        let mut waiting = self.parts.iter().peekable();
        let mut open: Vec<(&PartFile, Rows)> = vec![];
        for y in target.y..target.bottom() {
            while let Some(part) = waiting.next_if(|part| part.window.y <= y) {
                let mut rows = Rows::open(&part.path)?;
                (part.window.y..y).try_for_each(|_| rows.next(&mut bytes))?;
                open.push((part, rows));
            }
            // The part from which each pixel comes. Where parts overlap they must agree.
            let mut sources: Vec<Option<&PartFile>> = vec![None; target.width];
            for (part, rows) in &mut open {
                rows.next(&mut bytes)?;
                let pixels = (part.window.x..).zip(bytes.as_chunks().0);
                for (x, &pixel) in pixels.filter(|&(x, _)| target.contains([x, y])) {
                    let known = &mut row[x - target.x];
                    match sources[x - target.x].replace(part) {
                        Some(other) if *known != pixel => {
                            let [other, path] = [&other.path, &part.path].map(quoted);
                            let problem = format!("{other} and {path} overlap and differ at ({x}, {y})");
                            return Err(Diagnostic::error(problem));
                        }
                        _ => *known = pixel,
                    }
                }
            }
            writer.row_of_bytes(row.as_flattened())?;
            open.retain(|(part, _)| part.window.bottom() > y + 1);
            watch(y + 1 - target.y);
        }
        Ok(())
    }
}

/// Returns the first window of `target` that no part covers, by rows from the top and then from the left. It has the
/// missing columns of its first row, and ends where a part covers one of them.
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
            let file = |&tile| PartFile {
                path: "a.tga".into(),
                whole: [9, 7],
                window: window(tile),
                fingerprint: 0,
            };
            let tiles: Vec<PartFile> = tiles.iter().map(file).collect();
            assert_eq!(first_gap(&tiles, window(target)), gap.map(window), "{tiles:?}");
        }
    }
}
