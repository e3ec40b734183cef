//! Finds the edges in a picture: silhouettes, shadow borders, the lines of a texture.

use super::{Rgb, colors, largest_channel_difference};
use crate::picture::Picture;

/// The fraction of a picture's range of levels, as 1 / n, that a step between neighbours must exceed to be an edge.
/// Shading across a surface stays below it: otherwise brightness would span the whole range within eight pixels.
const EDGE_PART: i32 = 8;

/// The pixels that differ from a horizontal or vertical neighbour by more than an eighth of the picture's range, from
/// its smallest byte to its largest.
///
/// The threshold is relative. So a dark or pale picture has the same edges as with full contrast: multiplying or
/// shifting all bytes by a constant does not change them.
pub struct EdgeMap {
    width: usize,
    height: usize,
    is_edge: Vec<bool>,
}

impl EdgeMap {
    pub fn new(picture: &Picture) -> Self {
        let [width, height] = picture.size();
        let mut map = Self { width, height, is_edge: vec![false; width * height] };
        let (pixels, range) = (colors(picture), range(picture));
        for (y, row) in pixels.chunks_exact(width).enumerate() {
            let starts = y * width;
            (1..width).for_each(|x| map.mark(pixels, range, [starts + x - 1, starts + x]));
            (0..row.len())
                .filter(|_| y > 0)
                .for_each(|x| map.mark(pixels, range, [starts - width + x, starts + x]));
        }
        map
    }

    /// Marks both of two neighbours as edges if the step between them is large.
    fn mark(&mut self, pixels: &[Rgb], range: i32, neighbours: [usize; 2]) {
        let [a, b] = neighbours.map(|at| pixels[at]);
        if i32::from(largest_channel_difference(a, b)) * EDGE_PART > range {
            neighbours.into_iter().for_each(|at| self.is_edge[at] = true);
        }
    }

    /// Returns true if the pixel, or one of the eight around it, is an edge.
    pub fn is_near_edge(&self, x: usize, y: usize) -> bool {
        let columns = x.saturating_sub(1)..(x + 2).min(self.width);
        let mut rows = y.saturating_sub(1)..(y + 2).min(self.height);
        rows.any(|row| self.is_edge[row * self.width..][columns.clone()].contains(&true))
    }
}

/// Returns the difference between the largest and the smallest byte.
fn range(picture: &Picture) -> i32 {
    let bytes = picture.pixels();
    let [smallest, largest] =
        [bytes.iter().min(), bytes.iter().max()].map(|byte| byte.map_or(0, |&b| i32::from(b)));
    largest - smallest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(width: u32, rows: &[&[u8]]) -> Picture {
        let bytes = rows.concat().into_iter().flat_map(|level| [level; 3]).collect();
        Picture::from_rgb(width, rows.len() as u32, bytes)
    }

    fn edges(picture: &Picture) -> Vec<bool> {
        EdgeMap::new(picture).is_edge
    }

    #[test]
    fn a_step_marks_the_pixels_on_both_sides() {
        let across = grey(4, &[&[0, 0, 80, 80]]);
        assert_eq!(edges(&across), [false, true, true, false]);
        let down = grey(1, &[&[0], &[0], &[80], &[80]]);
        assert_eq!(edges(&down), [false, true, true, false]);
    }

    #[test]
    fn an_eighth_of_the_range_is_no_edge_and_more_is() {
        assert_eq!(edges(&grey(4, &[&[0, 10, 20, 80]])), [false, false, true, true]);
        assert_eq!(edges(&grey(4, &[&[0, 11, 20, 80]])), [true, true, true, true]);
    }

    #[test]
    fn one_channel_is_enough() {
        let picture = Picture::from_rgb(3, 1, vec![9, 9, 9, 9, 9, 200, 9, 9, 200]);
        assert_eq!(edges(&picture), [true, true, false]);
    }

    #[test]
    fn contrast_and_brightness_move_no_edge() {
        let levels: Vec<u8> = (0..64).map(|i| (i + 40 * (i * i % 7 / 3)) as u8 / 2).collect();
        let picture = |change: fn(u8) -> u8| {
            let changed: Vec<u8> = levels.iter().map(|&level| change(level)).collect();
            grey(8, &changed.chunks(8).collect::<Vec<_>>())
        };
        let expected = edges(&picture(|level| level));
        assert!(expected.contains(&true) && expected.contains(&false));
        assert_eq!(edges(&picture(|level| level * 5)), expected);
        assert_eq!(edges(&picture(|level| level + 200)), expected);
    }

    #[test]
    fn near_is_one_pixel_each_way_and_diagonally() {
        let mut levels = [0; 49];
        levels[..2].fill(255);
        levels[7..9].fill(255);
        // The edges are columns 0 to 2 of rows 0 to 2, except the corners (0, 0) and (2, 2).
        let map = EdgeMap::new(&grey(7, &levels.chunks(7).collect::<Vec<_>>()));
        let near: Vec<(usize, usize)> =
            (0..49).map(|i| (i % 7, i / 7)).filter(|&(x, y)| map.is_near_edge(x, y)).collect();
        let expected: Vec<(usize, usize)> =
            (0..49).map(|i| (i % 7, i / 7)).filter(|&(x, y)| x < 4 && y < 4 && (x, y) != (3, 3)).collect();
        assert_eq!(near, expected);
    }
}
