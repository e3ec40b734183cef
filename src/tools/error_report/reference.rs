//! The reference: two independent pictures with many samples, so that their own noise cancels.

use crate::picture::{Color, FloatPicture, Picture};
use crate::sampling::drand48::Drand48;
use crate::sampling::sampler::{Pattern, Sampler};

/// The number of jittered samples per pixel in each half.
pub const SAMPLES: u32 = 1024;

/// The number of levels of a byte above zero.
const LEVELS: f64 = 255.0;

/// Returns the samplers of the two halves. Their seeds differ from the measured pictures' seed.
pub fn samplers(measured: Drand48) -> [Sampler; 2] {
    let mut seeds = (1..).map(Drand48::seeded).filter(|&seed| seed != measured);
    [(); 2].map(|()| Sampler::new(Pattern::Jittered, SAMPLES, seeds.next().unwrap_or(measured)))
}

#[derive(Clone, Debug)]
pub struct Reference {
    halves: [FloatPicture; 2],
    /// The mean of the halves.
    pub picture: Picture,
    /// The root mean square error of one half, in levels.
    pub noise: f64,
}

impl Reference {
    /// Creates a reference. The halves must have the same size.
    pub fn new(halves: [FloatPicture; 2]) -> Self {
        let [first, second] = &halves;
        let colors = first.colors.iter().zip(&second.colors).map(|(a, b)| (shown(*a) + shown(*b)) / 2.0);
        let mean = FloatPicture { size: first.size, colors: colors.collect() };
        let differences = first.colors.iter().zip(&second.colors).map(|(a, b)| shown(*a) - shown(*b));
        let sum: f64 = differences.map(Color::length_squared).sum();
        // The variance of a difference is the sum of both variances.
        let noise = levels(sum / 2.0, first);
        let picture = mean.to_picture();
        Self { halves, picture, noise }
    }

    /// Returns the root mean square error of a picture of the same size, in levels, over all channels of all pixels. It
    /// is the root of MSE = mean((I - R1) (I - R2)), where the independent errors of R1 and R2 cancel on average.
    /// Returns 0 if their remaining noise makes the mean negative.
    pub fn error(&self, picture: &FloatPicture) -> f64 {
        let [first, second] = &self.halves;
        let colors = picture.colors.iter().zip(&first.colors).zip(&second.colors);
        let products = colors.map(|((color, a), b)| {
            let color = shown(*color);
            (color - shown(*a)).dot(color - shown(*b))
        });
        levels(products.sum::<f64>().max(0.0), picture)
    }
}

/// Returns a colour as a picture file shows it, except for rounding: clamped, and black if it is not a number.
pub fn shown(color: Color) -> Color {
    Color::from_array(
        color.to_array().map(|channel| if channel.is_nan() { 0.0 } else { channel.clamp(0.0, 1.0) }),
    )
}

/// Returns the root of a sum divided by the number of a picture's channels, in levels.
pub fn levels(sum: f64, picture: &FloatPicture) -> f64 {
    LEVELS * (sum / (3 * picture.colors.len()) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(values: &[f64]) -> FloatPicture {
        FloatPicture { size: [values.len(), 1], colors: values.iter().copied().map(Color::splat).collect() }
    }

    #[test]
    fn the_noise_of_the_reference_cancels() {
        // The errors of the halves have opposite signs in half of the pixels, and equal signs in the others.
        let reference = Reference::new([picture(&[0.6, 0.6, 0.4, 0.4]), picture(&[0.6, 0.4, 0.6, 0.4])]);
        assert!((reference.noise - 255.0 * (0.08f64 / 2.0 / 4.0).sqrt()).abs() < 1e-9);
        assert!(reference.error(&picture(&[0.5; 4])) < 1e-5);
        assert!((reference.error(&picture(&[0.8; 4])) - 255.0 * 0.3).abs() < 1e-9);
    }

    #[test]
    fn what_a_picture_does_not_show_is_no_error() {
        let reference = Reference::new([picture(&[1.0, 0.0, 0.0]), picture(&[1.0, 0.0, 0.0])]);
        assert_eq!(reference.error(&picture(&[7.0, -2.0, f64::NAN])), 0.0);
    }

    #[test]
    fn the_halves_have_seeds_of_their_own() {
        for measured in [Drand48::UNSEEDED, Drand48::seeded(1), Drand48::seeded(2)] {
            let [first, second] = samplers(measured).map(|sampler| sampler.rng());
            assert!(first != second && first != measured && second != measured);
        }
    }
}
