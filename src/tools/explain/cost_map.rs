//! A map of the cost of each pixel.

use crate::caster::Fullness;
use crate::picture::{BadSize, Picture};
use crate::render::renderer::Prepared;
use crate::render::{Cost, Request};
use crate::stats::RULE;
use std::f64::consts::TAU;
use std::fmt;

/// The cost of each pixel of a picture. `Display` prints a block in the form of the statistics.
#[derive(Clone, Debug)]
pub struct CostMap {
    pub cost: Cost,
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// The count of each pixel, row by row from the top.
    pub counts: Vec<u64>,
    /// The occupancy of the grid's cells. `None` without a grid.
    pub cells: Option<Fullness>,
}

/// Columns between the picture and the scale, and between the scale and its labels.
const GAP: usize = 4;
/// Columns of the scale.
const SCALE: usize = 12;
/// Columns from one digit to the next.
const ADVANCE: usize = 4;
/// Rows of a digit.
const DIGIT_HEIGHT: usize = 5;

/// The pixels of each digit from 0 to 9: three columns and five rows, row by row from the top left. The first pixel is
/// the highest of 15 bits.
const GLYPHS: [u16; 10] = [
    0b111_101_101_101_111,
    0b010_110_010_010_111,
    0b111_001_111_100_111,
    0b111_001_111_001_111,
    0b101_101_111_001_001,
    0b111_100_111_001_111,
    0b111_100_111_101_111,
    0b111_001_010_010_010,
    0b111_101_111_101_111,
    0b111_101_111_001_111,
];

impl CostMap {
    /// Creates the map of a rendered request from the costs of its pixels.
    pub fn new(cost: Cost, counts: Vec<u64>, prepared: &Prepared, request: &Request) -> Self {
        /// The number of the fullest cells that are named.
        const FULLEST: usize = 5;
        Self { cost, size: request.window_size(), counts, cells: prepared.fullness(FULLEST) }
    }

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
        let (last, lowest) = (height.saturating_sub(1), height.saturating_sub(DIGIT_HEIGHT));
        let scale = width + GAP..width + GAP + SCALE;
        let labels = [(0, most), (lowest / 2, most / 2), (lowest, 0)];
        let left = scale.end + GAP;
        let is_label = |x: usize, y: usize| {
            labels.iter().any(|&(top, number)| y >= top && is_white(number, x - left, y - top))
        };
        let value = |x: usize, y: usize| match x {
            _ if x < width => self.counts[y * width + x] as f64 / most.max(1) as f64,
            _ if scale.contains(&x) && last == 0 => 1.0,
            _ if scale.contains(&x) => (last - y) as f64 / last as f64,
            _ => f64::from(x >= left && is_label(x, y)),
        };
        let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let digits = most.to_string().len();
        let mut picture = Picture::new(side(left + digits * ADVANCE), side(height))?;
        for y in 0..height {
            let pixels = picture.row_mut(last - y).as_chunks_mut().0;
            pixels.iter_mut().enumerate().for_each(|(x, pixel)| *pixel = cubehelix(value(x, y)));
        }
        Ok(picture)
    }
}

impl fmt::Display for CostMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{RULE}\nCOST MAP")?;
        let mut line = |label: &str, value: String| writeln!(f, "  {label:<27}{value}");
        let ([x, y], most) = self.most_expensive();
        let pixels = self.counts.len().max(1);
        let total = self.total();
        line("cost", self.cost.name().into())?;
        line("total", total.to_string())?;
        line("per pixel", format!("{:.1}", total as f64 / pixels as f64))?;
        line("most expensive pixel", format!("{most} at ({x}, {y})"))?;
        if let Some(Fullness { fullest, empty, cells }) = &self.cells {
            line("empty cells", format!("{:.1}%", 100.0 * *empty as f64 / (*cells).max(1) as f64))?;
            for ([i, j, k], primitives) in fullest {
                line("full cell", format!("{primitives} primitives at ({i}, {j}, {k})"))?;
            }
        }
        writeln!(f, "{RULE}")
    }
}

/// Returns the colour of a value from 0 (black) to 1 (white): Green's cubehelix, "A colour scheme for the display of
/// astronomical intensity images", Bulletin of the Astronomical Society of India 39, 2011, section 3, with its default
/// parameters. Values outside the range are clamped.
pub fn cubehelix(value: f64) -> [u8; 3] {
    const START: f64 = 0.5;
    const ROTATIONS: f64 = -1.5;
    let value = value.clamp(0.0, 1.0);
    let angle = TAU * (START / 3.0 + 1.0 + ROTATIONS * value);
    let amplitude = 0.5 * value * (1.0 - value);
    let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
    [[-0.14861, 1.78277], [-0.29227, -0.90649], [1.97294, 0.0]]
        .map(|[c, s]| (255.0 * (value + amplitude * (c * cosine + s * sine))).round() as u8)
}

/// Returns true if the pixel in this column and row of a number is white.
fn is_white(number: u64, column: usize, row: usize) -> bool {
    let (place, column) = (column / ADVANCE, column % ADVANCE);
    let is_lit = |&digit: &u8| GLYPHS[usize::from(digit - b'0')] >> (14 - 3 * row - column) & 1 == 1;
    column < 3 && row < DIGIT_HEIGHT && number.to_string().as_bytes().get(place).is_some_and(is_lit)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map() -> CostMap {
        let counts = (0..40 * 30).map(|i| if i == 5 * 40 + 7 { 260 } else { i % 11 }).collect();
        CostMap { cost: Cost::Tests, size: [40, 30], counts, cells: None }
    }

    #[test]
    fn the_first_of_the_most_expensive_pixels_is_named() {
        assert_eq!(map().most_expensive(), ([7, 5], 260));
        let flat = CostMap { counts: vec![3; 1200], ..map() };
        assert_eq!((flat.most_expensive(), flat.total()), (([0, 0], 3), 3600));
    }

    #[test]
    fn a_number_stands_digit_by_digit() {
        let shown = [0, 1, 2, 3, 4, 5].map(|row| {
            (0..8).map(|column| if is_white(17, column, row) { '#' } else { '.' }).collect::<String>()
        });
        assert_eq!(shown, [".#..###.", "##....#.", ".#...#..", ".#...#..", "###..#..", "........"]);
    }

    #[test]
    fn the_perceived_brightness_grows_with_the_value() {
        let brightness = |value: f64| {
            let [red, green, blue] = cubehelix(value).map(f64::from);
            0.30 * red + 0.59 * green + 0.11 * blue
        };
        for i in 0..64 {
            let [value, next] = [i, i + 1].map(|i| f64::from(i) / 64.0);
            let step = brightness(next) - brightness(value);
            assert!((2.0..6.0).contains(&step), "{value}: {step}");
        }
        assert_eq!((cubehelix(0.0), cubehelix(1.0), cubehelix(9.0)), ([0; 3], [255; 3], [255; 3]));
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
        let empty = CostMap { cost: Cost::Cells, size: [3, 2], counts: vec![0; 6], cells: None };
        let picture = empty.draw().unwrap();
        assert!((0..3).all(|x| picture.get(x, 0) == Some([0; 3])));
    }
}
