//! Causes of the difference from a picture without a known scene, or without the colours of a scene.

use super::finding::{Finding, find_causes};
use super::mistakes::{Make, Mistake};
use crate::picture::{Color, FloatPicture, Picture};
use crate::tools::compare::colors;

/// A finished picture.
#[derive(Clone, Debug)]
pub struct FinishedPicture {
    colors: FloatPicture,
    /// True if the colours are known, not only their bytes.
    has_colors: bool,
}

impl FinishedPicture {
    /// Creates a finished picture from rendered colours.
    pub fn of_colors(colors: FloatPicture) -> Self {
        Self { colors, has_colors: true }
    }

    /// Creates a finished picture from a file. Mistakes in converting colours to bytes are then not tried.
    pub fn of_picture(picture: &Picture) -> Self {
        let size = [picture.width() as usize, picture.height() as usize];
        // Halfway between two bytes, so that rounding does not change the truncated value.
        let channel = |byte: u8| (f64::from(byte) + 0.5) / 255.0;
        let colors = colors(picture).iter().map(|pixel| Color::from_array(pixel.map(channel))).collect();
        Self { colors: FloatPicture { size, colors }, has_colors: false }
    }

    /// Finds why each wrong picture differs from this one. All pictures have the same size.
    pub fn explain(&self, wrong: &[Picture]) -> Vec<Finding> {
        let picture = |mistake: Mistake| match mistake.make()? {
            Make::Pixels(change) => Some(change(&self.colors)),
            _ => None,
        };
        find_causes(Mistake::of_pixels(self.has_colors), picture, wrong, &self.colors.to_picture())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_became_of_a_file_is_named() {
        let pixels: Vec<u8> = (0..=255).flat_map(|byte| [byte, 255 - byte, byte / 3]).collect();
        let right = Picture::from_rgb(16, 16, pixels);
        let mirrored =
            colors(&right).chunks(16).flat_map(|row| row.iter().rev()).copied().collect::<Vec<_>>();
        let mirrored = Picture::from_rgb(16, 16, mirrored.into_flattened());
        let black = Picture::new(16, 16).unwrap();
        let found = FinishedPicture::of_picture(&right).explain(&[mirrored, black]);
        let equal = Finding::Equal { cause: Mistake::Mirrored, pixels: 0 };
        assert_eq!(found, [equal, Finding::Unknown { tried: 8 }]);
    }
}
