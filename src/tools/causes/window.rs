//! Parts of pictures, used to judge causes when rendering whole pictures takes too long.

use super::search::Search;
use crate::picture::{FloatPicture, Picture, Window};
use crate::tools::compare::{Rgb, colors};

/// The shortest side of a window, in pixels.
const MIN_SIDE: usize = 8;
/// The largest number of windows in a picture.
const MAX_WINDOWS: usize = 3;

/// Chooses windows of at most this many pixels to search in, each with the indices of the pictures whose difference it
/// shows. A picture is assigned to a window with at least half as many of its differing pixels as any other window. A
/// few pictures may have no window.
pub fn telling_windows(
    searches: &[&mut Search],
    size: [usize; 2],
    pixels: usize,
) -> Vec<(Window, Vec<usize>)> {
    let is_whole = size[0] * size[1] <= pixels;
    let side = if is_whole { size[0].max(size[1]) } else { pixels.isqrt().max(MIN_SIDE) };
    let lattice = Lattice { side, size };
    let counts: Vec<Vec<usize>> = searches.iter().map(|search| lattice.differing(search)).collect();
    let shows = |picture: usize, tile: usize| {
        let counts: &[usize] = &counts[picture];
        counts[tile] > 0 && 2 * counts[tile] >= counts.iter().copied().max().unwrap_or(0)
    };
    let mut rest: Vec<usize> = (0..searches.len()).collect();
    let mut windows = Vec::new();
    while !rest.is_empty() && windows.len() < MAX_WINDOWS {
        let shown = |tile: usize| rest.iter().filter(|&&picture| shows(picture, tile)).count();
        // The last of several equally good tiles is taken.
        let Some(tile) = (0..lattice.tiles()).max_by_key(|&tile| shown(tile)) else { break };
        let (pictures, others): (Vec<usize>, _) =
            rest.iter().copied().partition(|&picture| shows(picture, tile));
        windows.push((lattice.window(tile), pictures));
        rest = others;
    }
    windows.retain(|(_, pictures)| !pictures.is_empty());
    windows
}

/// Tiles that cover a picture, row by row from the top left.
struct Lattice {
    side: usize,
    /// The size of the picture.
    size: [usize; 2],
}

impl Lattice {
    fn columns(&self) -> usize {
        self.size[0].div_ceil(self.side)
    }

    fn tiles(&self) -> usize {
        self.columns() * self.size[1].div_ceil(self.side)
    }

    fn window(&self, tile: usize) -> Window {
        let [column, row] = [tile % self.columns(), tile / self.columns()];
        let [x, y] = [column * self.side, row * self.side];
        let [width, height] = [self.size[0] - x, self.size[1] - y].map(|rest| rest.min(self.side));
        Window { x, y, width, height }
    }

    /// Returns the number of differing pixels in each tile.
    fn differing(&self, search: &Search) -> Vec<usize> {
        let mut counts = vec![0; self.tiles()];
        for at in (0..self.size[0] * self.size[1]).filter(|&at| search.differs(at)) {
            let [x, y] = [at % self.size[0], at / self.size[0]];
            counts[y / self.side * self.columns() + x / self.side] += 1;
        }
        counts
    }
}

/// Returns the part of a picture in a window.
pub fn part(picture: &Picture, window: Window) -> Picture {
    let pixels: Vec<Rgb> = part_of_rows(colors(picture), picture.width() as usize, window);
    Picture::from_rgb(window.width as u32, window.height as u32, pixels.into_flattened())
}

/// Returns the part of a picture of colours in a window.
pub fn part_of_colors(picture: &FloatPicture, window: Window) -> FloatPicture {
    let colors = part_of_rows(&picture.colors, picture.size[0], window);
    FloatPicture { size: [window.width, window.height], colors }
}

/// Copies the window's pixels. The window must lie in the picture.
fn part_of_rows<T: Copy>(pixels: &[T], width: usize, window: Window) -> Vec<T> {
    let rows = pixels.chunks_exact(width).skip(window.y).take(window.height);
    rows.flat_map(|row| &row[window.x..][..window.width]).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tools::causes::{of_bytes, search::Made};
    use std::borrow::Cow;
    use std::rc::Rc;

    /// Returns a black picture of 90 by 50 pixels with these pixels white.
    fn picture(white: &[[usize; 2]]) -> Picture {
        let mut pixels = vec![[0; 3]; 90 * 50];
        white.iter().for_each(|&[x, y]| pixels[y * 90 + x] = [255; 3]);
        Picture::from_rgb(90, 50, pixels.into_flattened())
    }

    #[test]
    fn a_window_is_where_most_pictures_differ_most() {
        let wrong = [
            picture(&[[1, 1], [50, 3]]),
            picture(&[[89, 49]]),
            picture(&[[46, 0], [46, 1], [46, 2], [0, 0]]),
        ];
        let black = Rc::new(Made::new(&of_bytes(&picture(&[]))));
        let mut searches = wrong.map(|wrong| Search::new(Cow::Owned(wrong), black.clone()));
        let windows = telling_windows(&searches.iter_mut().collect::<Vec<_>>(), [90, 50], 2048);
        let expected = [
            (Window { x: 45, y: 0, width: 45, height: 45 }, vec![0, 2]),
            (Window { x: 45, y: 45, width: 45, height: 5 }, vec![1]),
        ];
        assert_eq!(windows, expected);
    }

    #[test]
    fn a_part_is_what_the_window_shows() {
        let window = Window { x: 45, y: 45, width: 45, height: 5 };
        let found = part(&picture(&[[45, 45], [89, 49], [44, 45], [45, 44]]), window);
        let white: Vec<usize> = (0..225).filter(|&at| colors(&found)[at] == [255; 3]).collect();
        assert_eq!(([found.width(), found.height()], white), ([45, 5], vec![0, 224]));
    }
}
