//! A map of the cost of each pixel.

use super::color_scale::cubehelix;
use super::digits::{self, set};
use crate::picture::{BadSize, Picture};
use crate::render::layer::Cost;

/// The cost of each pixel of a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CostMap {
    /// The quantity counted.
    pub cost: Cost,
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// The count of each pixel, row by row from the top.
    pub counts: Vec<u64>,
}

/// Columns between the picture and the scale, and between the scale and its labels.
const GAP: usize = 4;
/// Columns of the scale.
const SCALE: usize = 12;

impl CostMap {
    /// Returns the sum of all counts.
    pub fn total(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Returns the first of the most expensive pixels, by column and row from the top left, and its count.
    pub fn most_expensive(&self) -> ([usize; 2], u64) {
        let most = self.counts.iter().copied().max().unwrap_or(0);
        let index = self.counts.iter().position(|&count| count == most).unwrap_or(0);
        ([index % self.size[0].max(1), index / self.size[0].max(1)], most)
    }

    /// Draws the map in false colours, from black for 0 to white for the most expensive pixel. The scale to its right
    /// is labelled with the largest count at its top, half of it in the middle, and 0 at the bottom.
    pub fn draw(&self) -> Result<Picture, BadSize> {
        let [width, height] = self.size;
        let (_, most) = self.most_expensive();
        let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let labels = width + GAP + SCALE + GAP;
        let mut picture = Picture::new(side(labels + digits::width(most)), side(height))?;
        let color = |count: u64| cubehelix(count as f64 / most.max(1) as f64);
        for (index, &count) in self.counts.iter().enumerate() {
            set(&mut picture, [index % width, index / width], color(count));
        }
        let last = height.saturating_sub(1);
        for y in 0..height {
            let value = if last == 0 { 1.0 } else { (last - y) as f64 / last as f64 };
            (0..SCALE).for_each(|x| set(&mut picture, [width + GAP + x, y], cubehelix(value)));
        }
        let lowest = height.saturating_sub(digits::HEIGHT);
        for (number, y) in [(most, 0), (most / 2, lowest / 2), (0, lowest)] {
            digits::draw(&mut picture, [labels, y], number);
        }
        Ok(picture)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map() -> CostMap {
        let counts = (0..40 * 30).map(|i| if i == 5 * 40 + 7 { 260 } else { i % 11 }).collect();
        CostMap { cost: Cost::Tests, size: [40, 30], counts }
    }

    #[test]
    fn the_first_of_the_most_expensive_pixels_is_named() {
        assert_eq!(map().most_expensive(), ([7, 5], 260));
        let flat = CostMap { counts: vec![3; 1200], ..map() };
        assert_eq!((flat.most_expensive(), flat.total()), (([0, 0], 3), 3600));
    }

    #[test]
    fn the_scale_stands_beside_the_pixels() {
        let picture = map().draw().unwrap();
        assert_eq!((picture.width(), picture.height()), (40 + 4 + 12 + 4 + 12, 30));
        let at = |x: u32, y: u32| picture.get(x, 29 - y).unwrap();
        assert_eq!((at(7, 5), at(8, 5)), ([255; 3], cubehelix(208.0 % 11.0 / 260.0)));
        assert_eq!((at(45, 0), at(45, 29), at(42, 3)), ([255; 3], [0; 3], [0; 3]));
    }

    #[test]
    fn nothing_at_all_is_black() {
        let empty = CostMap { cost: Cost::Cells, size: [3, 2], counts: vec![0; 6] };
        let picture = empty.draw().unwrap();
        assert!((0..3).all(|x| picture.get(x, 0) == Some([0; 3])));
    }
}
