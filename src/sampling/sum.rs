//! The weighted sum of the samples of one pixel.

use crate::math::simd::{FourLanes, Number};
use crate::picture::Color;
use fearless_simd::{Simd, SimdFrom, f64x4};

/// The weighted sum of the samples of one pixel: red, green, blue, and the weights themselves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sum([f64; 4]);

impl Sum {
    /// Adds a sample that represents this part of its pixel.
    pub fn add(&mut self, weight: f64, color: Color, part: f64) {
        let color = part * color;
        self.add_part(weight, [color.x, color.y, color.z, part]);
    }

    /// Adds a sample whose colour is already multiplied by the part of the pixel that it represents, with the part as
    /// fourth number.
    fn add_part(&mut self, weight: f64, color: [f64; 4]) {
        // A sample of weight zero is skipped, since its product with a NaN or an infinity would be a NaN.
        if weight != 0.0 {
            self.join(Sum(color.map(|channel| weight * channel)));
        }
    }

    /// Adds samples in the form used by `add_part`. If `are_finite`, none of them is infinite or NaN.
    #[inline(always)]
    pub(super) fn add_all<S: Simd>(
        &mut self,
        simd: S,
        weights: &[f64],
        colors: &[[f64; 4]],
        are_finite: bool,
    ) {
        if !are_finite {
            let samples = weights.iter().zip(colors);
            return samples.for_each(|(weight, color)| self.add_part(*weight, *color));
        }
        // A product with a weight of zero is zero and changes no sum, since no sum is -0.
        let product =
            |(weight, color): (&f64, &[f64; 4])| f64x4::splat(simd, *weight) * f64x4::simd_from(simd, *color);
        let mut sum = f64x4::simd_from(simd, self.0);
        for sample in weights.iter().zip(colors) {
            sum += product(sample);
        }
        self.0 = sum.to_array();
    }

    /// Adds the sum of other samples.
    pub fn join(&mut self, other: Sum) {
        self.0.iter_mut().zip(other.0).for_each(|(a, b)| *a += b);
    }

    /// Returns the weighted mean of the samples, or black if no sample has weight.
    pub fn color(&self) -> Color {
        let [red, green, blue, weight] = self.0;
        let color = Color::new(red, green, blue);
        match weight {
            0.0 => Color::ZERO,
            // The usual case of a single sample needs no division.
            1.0 => color,
            weight => color / weight,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Sum {
        /// Returns the bits of the numbers, with all NaNs equal.
        pub fn bits(&self) -> [u64; 4] {
            self.0.map(|x| if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() })
        }
    }

    #[test]
    fn a_sample_of_weight_zero_is_ignored() {
        let mut sum = Sum::default();
        sum.add(0.0, Color::NAN, 1.0);
        assert_eq!(sum.color(), Color::ZERO);
        sum.add(0.5, Color::ONE, 1.0);
        sum.add(1.5, Color::splat(3.0), 1.0);
        assert_eq!(sum.color(), Color::splat(2.5));
    }
}
