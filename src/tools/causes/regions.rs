//! Connected regions of pixels.

use crate::picture::Window;

/// Returns the largest connected region of these pixels of a picture of this size, where diagonal neighbours touch. The
/// pixels are in ascending order, in the region too.
pub fn largest_region(pixels: &[usize], size: [usize; 2]) -> Vec<usize> {
    let mut is_open = vec![false; size[0] * size[1]];
    pixels.iter().for_each(|&at| is_open[at] = true);
    let mut largest = vec![];
    for &start in pixels {
        if !std::mem::take(&mut is_open[start]) {
            continue;
        }
        let (mut region, mut next) = (vec![start], 0);
        while let Some(&at) = region.get(next) {
            next += 1;
            region.extend(neighbours(at, size).filter(|&neighbour| std::mem::take(&mut is_open[neighbour])));
        }
        if region.len() > largest.len() {
            largest = region;
        }
    }
    largest.sort_unstable();
    largest
}

/// Returns the pixels that touch a pixel of a picture of this size, and the pixel.
pub fn neighbours(at: usize, [width, height]: [usize; 2]) -> impl Iterator<Item = usize> {
    let (x, y) = (at % width, at / width);
    let columns = x.saturating_sub(1)..(x + 2).min(width);
    let rows = y.saturating_sub(1)..(y + 2).min(height);
    rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
}

/// Returns the smallest window around some pixels of a picture of this width.
pub fn window_around(pixels: &[usize], width: usize) -> Window {
    let columns = || pixels.iter().map(|at| at % width);
    let rows = || pixels.iter().map(|at| at / width);
    let [x, y] = [columns().min(), rows().min()].map(Option::unwrap_or_default);
    let [right, bottom] = [columns().max(), rows().max()].map(Option::unwrap_or_default);
    Window { x, y, width: right + 1 - x, height: bottom + 1 - y }
}
