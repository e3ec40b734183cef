//! Mistakes that show in the finished picture alone.

use crate::picture::{Color, FloatPicture, Picture};
use crate::tools::compare::{Rgb, colors as pixels_of};
use serde::Serialize;
use std::fmt;

/// A change of the finished picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "name", rename_all = "snake_case")]
pub enum PixelChange {
    /// The rows are in the opposite order.
    UpsideDown,
    /// The columns are in the opposite order.
    Mirrored,
    /// The picture is turned by 180 degrees, as by a camera of the other handedness.
    Turned,
    /// Blue stands where red belongs.
    RedAndBlueSwapped,
    /// 255 times a channel is rounded to the nearest byte.
    Rounded,
    /// 255 times a channel is rounded up.
    RoundedUp,
    /// Every byte is one more, up to 255.
    OneLevelBrighter,
    /// Every byte is one less, down to 0.
    OneLevelDarker,
    /// Bytes above 255 start again at 0.
    Wrapped,
    /// A channel is multiplied by 256 instead of 255.
    Times256,
    /// Every channel is raised to the power 1 / 2.2.
    GammaEncoded,
    /// The same, by a program that reads the bytes.
    BytesGammaEncoded,
    /// Every channel is raised to the power 2.2.
    GammaDecoded,
}

/// The gamma of most screens.
const GAMMA: f64 = 2.2;

impl PixelChange {
    pub(super) const ALL: [Self; 12] = [
        Self::UpsideDown,
        Self::Mirrored,
        Self::RedAndBlueSwapped,
        Self::Rounded,
        Self::RoundedUp,
        Self::OneLevelBrighter,
        Self::OneLevelDarker,
        Self::Wrapped,
        Self::Times256,
        Self::GammaEncoded,
        Self::BytesGammaEncoded,
        Self::GammaDecoded,
    ];

    /// The changes of a picture of which only the bytes are known.
    pub(super) const OF_BYTES: [Self; 8] = [
        Self::UpsideDown,
        Self::Mirrored,
        Self::Turned,
        Self::RedAndBlueSwapped,
        Self::OneLevelBrighter,
        Self::OneLevelDarker,
        Self::BytesGammaEncoded,
        Self::GammaDecoded,
    ];

    /// Whether pixels change their places.
    pub(super) fn moves(self) -> bool {
        matches!(self, Self::UpsideDown | Self::Mirrored | Self::Turned)
    }

    /// The changed picture of these colours.
    pub(super) fn apply(self, colors: &FloatPicture) -> Picture {
        let width = colors.size[0];
        let channels = |change: fn(f64) -> f64| {
            let changed = colors.colors.iter().map(|color| Color::from_array(color.to_array().map(change)));
            FloatPicture { size: colors.size, colors: changed.collect() }.to_picture()
        };
        match self {
            Self::UpsideDown => {
                rearranged(colors, |pixels| pixels.chunks_exact(width).rev().flatten().copied().collect())
            }
            Self::Mirrored => rearranged(colors, |pixels| {
                pixels.chunks_exact(width).flat_map(|row| row.iter().rev()).copied().collect()
            }),
            Self::Turned => rearranged(colors, |pixels| pixels.iter().rev().copied().collect()),
            Self::RedAndBlueSwapped => rearranged(colors, |pixels| {
                pixels.iter().map(|&[red, green, blue]| [blue, green, red]).collect()
            }),
            Self::Rounded => channels(|channel| channel + 0.5 / 255.0),
            Self::RoundedUp => channels(|channel| ((255.0 * channel).ceil() + 0.5) / 255.0),
            Self::OneLevelBrighter => bytes(colors, |byte| byte.saturating_add(1)),
            Self::OneLevelDarker => bytes(colors, |byte| byte.saturating_sub(1)),
            Self::Wrapped => {
                let wrapped = |color: &Color| color.to_array().map(|channel| (255.0 * channel) as i64 as u8);
                let pixels: Vec<Rgb> = colors.colors.iter().map(wrapped).collect();
                let [width, height] = colors.size.map(|side| side as u32);
                Picture::from_rgb(width, height, pixels.into_flattened())
            }
            Self::Times256 => channels(|channel| 256.0 / 255.0 * channel),
            Self::GammaEncoded => channels(|channel| libm::pow(channel.max(0.0), 1.0 / GAMMA)),
            Self::BytesGammaEncoded => {
                let table: Vec<u8> = (0..=u8::MAX).map(encoded).collect();
                bytes(colors, |byte| table[usize::from(byte)])
            }
            Self::GammaDecoded => channels(|channel| libm::pow(channel.max(0.0), GAMMA)),
        }
    }
}

fn encoded(byte: u8) -> u8 {
    (255.0 * libm::pow(f64::from(byte) / 255.0, 1.0 / GAMMA)).round() as u8
}

/// The picture of these colours with every byte changed.
fn bytes(colors: &FloatPicture, change: impl Fn(u8) -> u8) -> Picture {
    rearranged(colors, |pixels| pixels.iter().map(|pixel| pixel.map(&change)).collect())
}

/// The picture of these colours with other pixels in place of its own.
fn rearranged(colors: &FloatPicture, rearrange: impl Fn(&[Rgb]) -> Vec<Rgb>) -> Picture {
    let picture = colors.to_picture();
    let pixels = rearrange(pixels_of(&picture));
    Picture::from_rgb(picture.width(), picture.height(), pixels.into_flattened())
}

impl fmt::Display for PixelChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::UpsideDown => "upside down",
            Self::Mirrored => "mirrored left to right",
            Self::Turned => "turned by 180 degrees",
            Self::RedAndBlueSwapped => "with red and blue swapped",
            Self::Rounded => "with colours rounded to bytes instead of cut",
            Self::RoundedUp => "with colours rounded up to bytes instead of cut",
            Self::OneLevelBrighter => "one level brighter everywhere",
            Self::OneLevelDarker => "one level darker everywhere",
            Self::Wrapped => "with bytes that start again at 0 above 255",
            Self::Times256 => "with colours times 256 instead of 255",
            Self::GammaEncoded => "with a gamma of 2.2",
            Self::BytesGammaEncoded => "with a gamma of 2.2 applied to its bytes",
            Self::GammaDecoded => "with an inverse gamma of 2.2",
        })
    }
}
