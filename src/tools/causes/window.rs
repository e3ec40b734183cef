//! Parts of pictures, used to judge causes when rendering whole pictures takes too long.

use crate::picture::{FloatPicture, Picture, Window};
use crate::tools::compare::{Rgb, colors};

/// Chooses windows with this side, in pixels, to search in, each with the indices of the pictures whose difference it
/// shows. A picture is assigned to a window with at least half as many of its differing pixels as any other window.
/// `differences` has the difference of each picture's pixels, 0 if there is none.
pub fn telling_windows(differences: &[Vec<u8>], size: [usize; 2], side: usize) -> Vec<(Window, Vec<usize>)> {
    let columns = size[0].div_ceil(side);
    let tiles = columns * size[1].div_ceil(side);
    // The number of differing pixels in each tile.
    let count = |differences: &[u8]| {
        let mut counts = vec![0; tiles];
        for at in (0..differences.len()).filter(|&at| differences[at] > 0) {
            counts[at / size[0] / side * columns + at % size[0] / side] += 1;
        }
        counts
    };
    let counts: Vec<Vec<usize>> = differences.iter().map(|differences| count(differences)).collect();
    let shows = |picture: usize, tile: usize| {
        let most = counts[picture].iter().copied().max().unwrap_or(0);
        counts[picture][tile] > 0 && 2 * counts[picture][tile] >= most
    };
    let mut rest: Vec<usize> = (0..differences.len()).collect();
    let mut windows = Vec::new();
    loop {
        let shown = |&tile: &usize| rest.iter().filter(|&&picture| shows(picture, tile)).count();
        let Some(tile) = (0..tiles).max_by_key(shown) else { return windows };
        let (pictures, others): (Vec<usize>, _) = rest.iter().partition(|&&picture| shows(picture, tile));
        if pictures.is_empty() {
            return windows;
        }
        let [x, y] = [tile % columns * side, tile / columns * side];
        let [width, height] = [size[0] - x, size[1] - y].map(|rest| rest.min(side));
        windows.push((Window { x, y, width, height }, pictures));
        rest = others;
    }
}

/// Returns the window whose pixels move into this one when a picture of this size is flipped left to right, and upside
/// down.
pub fn flipped(window: Window, size: [usize; 2], [across, down]: [bool; 2]) -> Window {
    let Window { mut x, mut y, width, height } = window;
    if across {
        x = size[0] - width - x;
    }
    if down {
        y = size[1] - height - y;
    }
    Window { x, y, width, height }
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
pub fn part_of_rows<T: Copy>(pixels: &[T], width: usize, window: Window) -> Vec<T> {
    let rows = pixels.chunks_exact(width).skip(window.y).take(window.height);
    rows.flat_map(|row| &row[window.x..][..window.width]).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the pixels of a picture of 90 by 50 pixels with these different.
    fn differences(at: &[[usize; 2]]) -> Vec<u8> {
        let mut all = vec![0; 90 * 50];
        at.iter().for_each(|&[x, y]| all[y * 90 + x] = 255);
        all
    }

    #[test]
    fn a_window_is_where_most_pictures_differ_most() {
        let pictures = [
            differences(&[[1, 1], [50, 3]]),
            differences(&[[89, 49]]),
            differences(&[]),
            differences(&[[46, 0], [46, 1], [46, 2], [0, 0]]),
        ];
        let windows = telling_windows(&pictures, [90, 50], 45);
        let expected = [
            (Window { x: 45, y: 0, width: 45, height: 45 }, vec![0, 3]),
            (Window { x: 45, y: 45, width: 45, height: 5 }, vec![1]),
        ];
        assert_eq!(windows, expected);
    }

    #[test]
    fn a_part_is_what_the_window_shows() {
        let window = Window { x: 45, y: 45, width: 45, height: 5 };
        let white = differences(&[[45, 45], [89, 49], [44, 45], [45, 44]]);
        let picture = Picture::from_rgb(90, 50, white.iter().flat_map(|&byte| [byte; 3]).collect());
        let found = part(&picture, window);
        let white: Vec<usize> = (0..225).filter(|&at| colors(&found)[at] == [255; 3]).collect();
        assert_eq!(([found.width(), found.height()], white), ([45, 5], vec![0, 224]));
    }
}
