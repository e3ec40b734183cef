//! Causes of the difference from a picture of which no scene is known, or no colours of a scene.

use super::finding::{Finding, find_causes};
use super::{Cause, PixelChange};
use crate::picture::{Color, FloatPicture, Picture};
use crate::tools::compare::colors;

/// A finished picture.
#[derive(Clone, Debug)]
pub struct FinishedPicture {
    colors: FloatPicture,
    changes: &'static [PixelChange],
}

impl FinishedPicture {
    /// A picture as it was rendered.
    pub fn of_colors(colors: FloatPicture) -> Self {
        Self { colors, changes: &PixelChange::ALL }
    }

    /// A picture that was read from a file. Mistakes in how colours become bytes are not tried.
    pub fn of_picture(picture: &Picture) -> Self {
        let size = [picture.width() as usize, picture.height() as usize];
        // Halfway between two bytes, so that rounding cannot change what the colours are cut to.
        let channel = |byte: u8| (f64::from(byte) + 0.5) / 255.0;
        let colors = colors(picture).iter().map(|pixel| Color::from_array(pixel.map(channel))).collect();
        Self { colors: FloatPicture { size, colors }, changes: &PixelChange::OF_BYTES }
    }

    /// Why each wrong picture differs from this one. All are of one size.
    pub fn explain(&self, wrong: &[Picture]) -> Vec<Finding> {
        let picture = |cause| match cause {
            Cause::Pixels(change) => Some(change.apply(&self.colors)),
            _ => Some(self.colors.to_picture()),
        };
        find_causes(
            self.changes.iter().copied().map(Cause::Pixels),
            picture,
            wrong,
            &self.colors.to_picture(),
        )
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
        let equal = Finding::Equal { cause: Cause::Pixels(PixelChange::Mirrored), pixels: 0 };
        assert_eq!(found, [equal, Finding::Unknown { tried: 8 }]);
    }
}
