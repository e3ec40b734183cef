//! A picture that shows where two pictures differ.

use super::{Rgb, colors, common_size, largest_channel_difference};
use crate::diagnostic::Diagnostic;
use crate::picture::{BadSize, Picture};

/// Columns between the panels.
const GAP: usize = 4;
/// The colour of the columns between the panels.
const GAP_COLOR: Rgb = [90; 3];

/// A, B and their difference, from left to right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DifferencePicture {
    /// Three panels of the size of A, separated by four grey columns. The third panel shows the absolute difference per
    /// channel, times the amplification.
    pub picture: Picture,
    /// The largest power of two for which all differences fit into a byte. The largest difference is then between half
    /// and full brightness. 1 if there is no difference.
    pub amplification: u8,
}

impl DifferencePicture {
    /// Draws the three panels. Fails if the sizes differ.
    pub fn new(a: &Picture, b: &Picture) -> Result<Self, Diagnostic> {
        let size = common_size(a, b)?;
        let pairs = colors(a).iter().zip(colors(b));
        let largest = pairs.map(|(&a, &b)| largest_channel_difference(a, b)).max().unwrap_or(0);
        let amplification = amplification(largest);
        let mut picture = canvas(size)?;
        let width = size[0] as usize;
        let rows = colors(a).chunks_exact(width).zip(colors(b).chunks_exact(width)).rev();
        rows.enumerate().for_each(|(j, (a, b))| draw_row(picture.row_mut(j), a, b, amplification));
        Ok(Self { picture, amplification })
    }
}

fn amplification(largest: u8) -> u8 {
    match largest {
        0 => 1,
        largest => 1 << largest.leading_zeros(),
    }
}

/// Returns a black picture with room for the panels and the gaps.
fn canvas([width, height]: [u32; 2]) -> Result<Picture, BadSize> {
    let total = width.checked_mul(3).and_then(|panels| panels.checked_add(2 * GAP as u32));
    Picture::new(total.ok_or(BadSize { width: usize::MAX, height: height as usize })?, height)
}

/// Draws one row of the canvas from the rows of A and B.
fn draw_row(row: &mut [u8], a: &[Rgb], b: &[Rgb], amplification: u8) {
    let differences = a.iter().zip(b).map(|(a, b)| {
        [0, 1, 2].map(|channel: usize| a[channel].abs_diff(b[channel]).saturating_mul(amplification))
    });
    let gap = [GAP_COLOR; GAP];
    let panels = a.iter().chain(&gap).chain(b).chain(&gap).copied().chain(differences);
    row.as_chunks_mut().0.iter_mut().zip(panels).for_each(|(pixel, color)| *pixel = color);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_difference_is_at_least_half_bright_and_none_is_cut() {
        for largest in 1..=255 {
            let shown = u32::from(largest) * u32::from(amplification(largest));
            assert!((128..256).contains(&shown), "{largest} is shown as {shown}");
        }
        assert_eq!(amplification(0), 1);
    }

    #[test]
    fn a_b_and_the_difference_lie_side_by_side() {
        let a = Picture::from_rgb(1, 2, vec![10, 20, 30, 1, 2, 3]);
        let b = Picture::from_rgb(1, 2, vec![12, 20, 30, 1, 33, 2]);
        let shown = DifferencePicture::new(&a, &b).unwrap();
        assert_eq!(shown.amplification, 8);
        let row = |panels: [Rgb; 3]| panels.join([GAP_COLOR; GAP].as_flattened());
        let expected =
            [row([[10, 20, 30], [12, 20, 30], [16, 0, 0]]), row([[1, 2, 3], [1, 33, 2], [0, 248, 8]])]
                .concat();
        assert_eq!(shown.picture, Picture::from_rgb(11, 2, expected));
    }

    #[test]
    fn sizes_that_differ_are_an_error() {
        let [a, b] = [1, 2].map(|width| Picture::new(width, 1).unwrap());
        assert!(DifferencePicture::new(&a, &b).is_err_and(|error| error.message.contains("differ in size")));
    }

    #[test]
    fn panels_that_exceed_the_widest_picture_are_an_error() {
        assert!(canvas([u32::MAX / 3, 1]).is_err());
        assert!(canvas([u32::MAX, 1]).is_err());
    }
}
