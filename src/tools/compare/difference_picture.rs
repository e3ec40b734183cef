//! A picture that shows where two pictures differ.

use super::numbers::{Number, difference};
use super::{Rgb, colors, largest_channel_difference, same_size};
use crate::diagnostic::Diagnostic;
use crate::picture::{BadSize, Color, FloatPicture, Picture, Pixels};
use serde::Serialize;
use std::fmt;

/// Columns between the panels.
const GAP: usize = 4;
/// The colour of the columns between the panels.
const GAP_COLOR: Rgb = [90; 3];
/// The colour of a NaN, and of a difference of what is not finite.
const NOT_FINITE: Rgb = [255, 0, 255];

/// A, B and their difference, from left to right.
#[derive(Clone, Debug, PartialEq)]
pub struct DifferencePicture {
    /// Three panels of the size of A, separated by four grey columns. The third panel shows the absolute difference per
    /// channel.
    pub picture: Picture,
    /// How bright they are drawn.
    pub brightness: Brightness,
}

/// The brightness of the panels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Brightness {
    /// Differences of bytes are multiplied by this. It is the largest power of two for which all fit into a byte, so that
    /// the largest difference is between half and full brightness. 1 if there is no difference.
    Amplified(u8),
    /// Numbers are drawn on a scale, and differences up to this one.
    Scaled(Scale, f64),
}

/// A linear scale on which numbers are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Scale {
    /// The number that is black.
    pub black: f64,
    /// The number that is white.
    pub white: f64,
}

impl DifferencePicture {
    /// Draws the three panels. Fails if the sizes differ.
    pub fn new(a: &Pixels, b: &Pixels) -> Result<Self, Diagnostic> {
        match (a, b) {
            (Pixels::Numbers(a), Pixels::Numbers(b)) => Self::of_numbers(a, b),
            _ => {
                let (picture, amplification) = Self::of_bytes(&a.bytes(), &b.bytes())?;
                Ok(Self { picture, brightness: Brightness::Amplified(amplification) })
            }
        }
    }

    /// Draws the panels of pictures of bytes. Returns also the amplification of their difference. Fails if the sizes
    /// differ.
    pub fn of_bytes(a: &Picture, b: &Picture) -> Result<(Picture, u8), Diagnostic> {
        same_size([a.size(), b.size()])?;
        let pairs = || colors(a).iter().zip(colors(b));
        let largest = pairs().map(|(&a, &b)| largest_channel_difference(a, b)).max().unwrap_or(0);
        let amplification = amplification(largest);
        let mut difference = Picture::new(a.width(), a.height())?;
        for (shown, (a, b)) in difference.pixels_mut().as_chunks_mut().0.iter_mut().zip(pairs()) {
            *shown = [0, 1, 2].map(|channel: usize| a[channel].abs_diff(b[channel]) * amplification);
        }
        Ok((side_by_side([a, b, &difference])?, amplification))
    }

    fn of_numbers(a: &FloatPicture, b: &FloatPicture) -> Result<Self, Diagnostic> {
        same_size([a.size, b.size])?;
        let mut differences = FloatPicture::with_room(a.size)?;
        for (a, b) in a.colors.iter().zip(&b.colors) {
            let color = Color::from([0, 1, 2].map(|channel| difference(a[channel], b[channel])));
            differences.colors.push(if color.is_finite() { color } else { Color::NAN });
        }
        let scale = Scale::of(&[a, b]);
        let largest = differences.colors.iter().flat_map(Color::to_array).fold(0.0, f64::max);
        let in_difference = Scale { black: 0.0, white: if largest > 0.0 { largest } else { 1.0 } };
        let panels = [scale.draw(a)?, scale.draw(b)?, in_difference.draw(&differences)?];
        let picture = side_by_side(panels.each_ref())?;
        Ok(Self { picture, brightness: Brightness::Scaled(scale, largest) })
    }
}

impl Scale {
    /// Returns a scale for these pictures: from 0 to 1 if that shows all of their finite numbers, otherwise from the
    /// smallest to the largest.
    pub fn of(pictures: &[&FloatPicture]) -> Self {
        let channels = pictures.iter().flat_map(|picture| &picture.colors).flat_map(Color::to_array);
        let (mut smallest, mut largest) = (0.0f64, 1.0f64);
        let (mut black, mut white) = (f64::INFINITY, f64::NEG_INFINITY);
        for number in channels.filter(|number| number.is_finite()) {
            (smallest, largest) = (smallest.min(number), largest.max(number));
            (black, white) = (black.min(number), white.max(number));
        }
        let shows_all = (smallest, largest) == (0.0, 1.0) || black == white;
        if shows_all { Self { black: smallest, white: largest } } else { Self { black, white } }
    }

    /// Draws a picture. Infinities are black and white, and a NaN is magenta.
    pub fn draw(&self, picture: &FloatPicture) -> Result<Picture, BadSize> {
        let [width, height] = picture.size.map(|n| n as u32);
        let mut drawn = Picture::new(width, height)?;
        // Halves do not overflow.
        let span = self.white / 2.0 - self.black / 2.0;
        for (pixel, color) in drawn.pixels_mut().as_chunks_mut().0.iter_mut().zip(&picture.colors) {
            let shown = (color / 2.0 - self.black / 2.0) / span;
            *pixel = if color.is_nan() { NOT_FINITE } else { (255.0 * shown).to_array().map(|x| x as u8) };
        }
        Ok(drawn)
    }
}

impl fmt::Display for Scale {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "from {} in black to {} in white", Number(self.black), Number(self.white))
    }
}

impl fmt::Display for Brightness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Amplified(factor) => write!(f, "differences times {factor}"),
            Self::Scaled(scale, largest) => {
                write!(f, "{scale}; differences up to {} in white", Number(*largest))
            }
        }
    }
}

fn amplification(largest: u8) -> u8 {
    match largest {
        0 => 1,
        largest => 1 << largest.leading_zeros(),
    }
}

/// Draws pictures of the same size side by side.
fn side_by_side(panels: [&Picture; 3]) -> Result<Picture, BadSize> {
    let mut picture = canvas([panels[0].width(), panels[0].height()])?;
    let bytes = 3 * panels[0].width() as usize;
    let row_bytes = 3 * picture.width() as usize;
    for (y, row) in picture.pixels_mut().chunks_exact_mut(row_bytes).enumerate() {
        let parts = panels.map(|panel| &panel.pixels()[y * bytes..][..bytes]);
        row.copy_from_slice(&parts.join([GAP_COLOR; GAP].as_flattened()));
    }
    Ok(picture)
}

/// Returns a black picture with room for the panels and the gaps.
fn canvas([width, height]: [u32; 2]) -> Result<Picture, BadSize> {
    let total = width.checked_mul(3).and_then(|panels| panels.checked_add(2 * GAP as u32));
    Picture::new(total.ok_or(BadSize { width: usize::MAX, height: height as usize })?, height)
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
        let (shown, amplification) = DifferencePicture::of_bytes(&a, &b).unwrap();
        assert_eq!(amplification, 8);
        let row = |panels: [Rgb; 3]| panels.join([GAP_COLOR; GAP].as_flattened());
        let expected =
            [row([[10, 20, 30], [12, 20, 30], [16, 0, 0]]), row([[1, 2, 3], [1, 33, 2], [0, 248, 8]])]
                .concat();
        assert_eq!(shown, Picture::from_rgb(11, 2, expected));
    }

    #[test]
    fn panels_that_exceed_the_widest_picture_are_an_error() {
        assert!(canvas([u32::MAX / 3, 1]).is_err());
        assert!(canvas([u32::MAX, 1]).is_err());
    }

    #[test]
    fn numbers_are_drawn_on_a_scale_that_shows_all() {
        let picture = |numbers: &[f64]| {
            let colors = numbers.iter().map(|&number| Color::splat(number)).collect();
            Pixels::Numbers(FloatPicture { size: [numbers.len(), 1], colors })
        };
        let (nan, inf) = (f64::NAN, f64::INFINITY);
        let [a, b] = [picture(&[6.0, 8.0, nan, inf]), picture(&[6.0, 10.0, nan, 7.0])];
        let shown = DifferencePicture::new(&a, &b).unwrap();
        let scale = Scale { black: 6.0, white: 10.0 };
        assert_eq!(shown.brightness, Brightness::Scaled(scale, 2.0));
        let greys = |levels: [u8; 4]| levels.map(|level| if level == 1 { NOT_FINITE } else { [level; 3] });
        let panels = [[0, 127, 1, 255], [0, 255, 1, 63], [0, 255, 0, 1]].map(greys);
        let expected = panels.each_ref().map(|panel| panel.as_slice()).join(&[GAP_COLOR; GAP][..]);
        assert_eq!(colors(&shown.picture), expected);
        let text = "from 6 in black to 10 in white; differences up to 2 in white";
        assert_eq!(shown.brightness.to_string(), text);
        for (numbers, expected) in [
            (&[0.2, 0.4][..], (0.0, 1.0)),
            (&[7.0, inf], (0.0, 7.0)),
            (&[nan], (0.0, 1.0)),
            (&[-1e308, 1e308], (-1e308, 1e308)),
        ] {
            let Pixels::Numbers(numbers) = picture(numbers) else { unreachable!() };
            let scale = Scale::of(&[&numbers]);
            assert_eq!((scale.black, scale.white), expected);
            assert!(scale.draw(&numbers).is_ok());
        }
    }
}
