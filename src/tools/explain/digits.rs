//! Small digits for the labels of a scale.

use crate::picture::Picture;

/// Columns from one digit to the next.
pub const ADVANCE: usize = 4;
/// Rows of a digit.
pub const HEIGHT: usize = 5;

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

/// Returns the width of a number in pixels.
pub fn width(number: u64) -> usize {
    number.to_string().len() * ADVANCE
}

/// Draws a number in white, with its top left corner in column `x` and row `y` from the top. Parts outside the picture
/// are cut off.
pub fn draw(picture: &mut Picture, [x, y]: [usize; 2], number: u64) {
    for (place, digit) in number.to_string().bytes().enumerate() {
        let glyph = GLYPHS[usize::from(digit - b'0')];
        for (row, column) in (0..HEIGHT).flat_map(|row| (0..3).map(move |column| (row, column))) {
            if glyph >> (14 - 3 * row - column) & 1 == 1 {
                set(picture, [x + ADVANCE * place + column, y + row], [255; 3]);
            }
        }
    }
}

/// Colours the pixel in column `x` and row `y` from the top, if it exists.
pub fn set(picture: &mut Picture, [x, y]: [usize; 2], color: [u8; 3]) {
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    if x < width && y < height {
        picture.row_mut(height - 1 - y)[3 * x..][..3].copy_from_slice(&color);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_stands_digit_by_digit() {
        let mut picture = Picture::new(width(17) as u32, 6).unwrap();
        draw(&mut picture, [0, 1], 17);
        let shown: Vec<String> = (0..6)
            .map(|y| {
                (0..8).map(|x| if picture.get(x, 5 - y) == Some([255; 3]) { '#' } else { '.' }).collect()
            })
            .collect();
        assert_eq!(shown, ["........", ".#..###.", "##....#.", ".#...#..", ".#...#..", "###..#.."]);
    }
}
