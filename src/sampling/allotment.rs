//! Adaptive sampling: uses probes to allot the number of samples that reaches the target error.
//!
//! Pixel corners miss details between them: dots, hairs, shadows, highlights, reflections. Probes at random positions
//! find them. The distance of a probe's colour from the range of its pixel's corners estimates the variance around it.
//! A pixel's own probes do not influence its number of samples, so they give an unbiased estimate of the plan's error.
//! All pixels get more samples until the estimate reaches the target. There are two plans, one from the probes around
//! each pixel and one from the mean of all probes. The plan with fewer samples is used.

use super::adaptive::{Adaptive, Contents, DETAIL_POWER, EDGE_POWER};
use crate::picture::Color;

/// A probe that found a colour outside the range of its pixel's corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Find {
    /// The index of the pixel.
    pub pixel: usize,
    /// The squared distance from the corners' colours.
    pub square: f32,
}

/// The knowledge about some rows of pixels.
#[derive(Clone, Debug)]
pub struct Known {
    /// The number of pixels in a row.
    pub width: usize,
    /// The contents of each pixel that corners and small things show, row by row.
    pub contents: Vec<Contents>,
    /// The probes that found something.
    pub finds: Vec<Find>,
    /// The average number of probes per pixel.
    pub probes: f64,
    /// The largest contrast assumed for details that the probes missed.
    pub contrast: f32,
    /// True if colours brighter than white count in full.
    pub has_floats: bool,
    /// The ratio of the squared error of details to that of random samples.
    pub gain: f64,
}

/// The fraction of the target squared error permitted for details that all probes are likely to miss, and the fraction
/// permitted for the rest. Their sum is above 1, because the error is mostly smaller than expected.
const MISSED: f64 = 0.5;
const ALLOWED: f64 = 0.65;

/// The number of probes around a pixel that estimate its variance, and the number of them that has the weight of all
/// others.
const AROUND: f64 = 128.0;
const OF_ALL: f64 = 16.0;

/// The largest average number of probes per pixel.
const MOST_PROBES: f64 = 16.0;

/// In the coarsest plan, one more sample of a pixel reduces its squared error by this times the cube of the target
/// error. Then edges get about as many samples as there are corners and probes, which are cast anyway.
const WORTH: f64 = 4.0;

/// The factor by which each plan is finer than the one before it, and the number of plans.
const FINER: f32 = 1.5;
const PLANS: i32 = 40;

impl Adaptive {
    /// Returns the number of probes per pixel that is worth casting in `pixels` pixels, if details may have this
    /// contrast.
    ///
    /// A detail of contrast c that covers a fraction p of the pixels leaves a squared error of p c^2 / n with n samples
    /// in each. m probes in each of k pixels hit it m k p times. If they hit it once, the error is c^2 / (k m n), so
    /// m = n is the cheapest way to make it small.
    pub fn probes(self, pixels: usize, contrast: f32) -> f64 {
        let product = self.missed(contrast) / pixels as f64;
        // If all pixels get the maximum, probes have nothing to decide.
        let is_open = product < MOST_PROBES * f64::from(self.most);
        if is_open { product.min(product.sqrt()).min(MOST_PROBES) } else { 0.0 }
    }

    /// Returns the number of samples per pixel times the number of all probes for which a detail of this contrast, hit
    /// by one probe, leaves no more than the permitted error.
    fn missed(self, contrast: f32) -> f64 {
        f64::from(contrast * contrast) / (MISSED * self.square())
    }
}

impl Known {
    /// Returns the number of samples that each pixel needs to reach the target error.
    pub fn allot(&self, settings: Adaptive) -> Vec<u16> {
        let side = (AROUND / self.probes).sqrt().ceil().clamp(1.0, self.width as f64);
        let local = self.allot_by(settings, &self.variances(side as usize));
        // Nothing was found, so nothing can be uneven.
        if self.finds.is_empty() {
            return local;
        }
        let mean = self.finds.iter().map(|find| self.visible(find)).sum::<f64>() / self.all_probes();
        let even = self.allot_by(settings, &vec![mean as f32; self.contents.len()]);
        if total(&even) < total(&local) { even } else { local }
    }

    /// Returns the coarsest plan that reaches the target error if pixels have at least these variances.
    fn allot_by(&self, settings: Adaptive, variances: &[f32]) -> Vec<u16> {
        let most = settings.most as f32;
        let floor = ((settings.missed(self.contrast) / self.all_probes()).ceil() as f32).clamp(1.0, most);
        let needs = self.contents.iter().zip(variances).map(|(contents, &variance)| {
            Contents { variance: contents.variance.max(variance), ..*contents }.needs()
        });
        let needs: Vec<[f32; 2]> = needs.collect();
        let coarsest = WORTH * libm::pow(settings.square(), 1.5);
        let samples = |plan: i32| {
            let inverse = FINER.powi(plan) / coarsest as f32;
            let [edges, details] = [EDGE_POWER, DETAIL_POWER].map(|power| libm::powf(inverse, power));
            let count = |need: &[f32; 2]| {
                // `max` and `min` drop a NaN. It comes from infinity, where more samples do not help.
                let count = (need[0] * edges).max(need[1] * details).max(floor).min(most);
                // Faster than `ceil`.
                let whole = count as u16;
                whole + u16::from(f32::from(whole) < count)
            };
            needs.iter().map(count).collect::<Vec<u16>>()
        };
        let (mut coarse, mut fine) = (0, PLANS);
        while coarse < fine {
            let plan = (coarse + fine) / 2;
            let is_enough = self.error(&samples(plan)) <= ALLOWED * settings.square();
            if is_enough { fine = plan } else { coarse = plan + 1 }
        }
        samples(fine)
    }

    /// Returns the variance around each pixel found by other pixels' probes, in the square of this side that it is in.
    fn variances(&self, side: usize) -> Vec<f32> {
        let cell =
            |pixel: usize| pixel / self.width / side * self.width.div_ceil(side) + pixel % self.width / side;
        let pixels = self.contents.len();
        let (mut own, mut cells) = (vec![0.0; pixels], vec![[0.0; 2]; cell(pixels - 1) + 1]);
        for find in &self.finds {
            own[find.pixel] += self.visible(find);
            cells[cell(find.pixel)][0] += self.visible(find);
        }
        (0..pixels).for_each(|pixel| cells[cell(pixel)][1] += self.probes);
        let all: f64 = own.iter().sum();
        let of_pixel = |(pixel, own): (usize, &f64)| {
            let [found, probes] = cells[cell(pixel)];
            let mean = (all - own) / (self.all_probes() - self.probes).max(1.0);
            ((found - own + OF_ALL * mean) / (probes - self.probes + OF_ALL)).max(0.0) as f32
        };
        own.iter().enumerate().map(of_pixel).collect()
    }

    /// Returns the square of a find as far as the picture shows it: in bytes, nothing is brighter than white.
    fn visible(&self, find: &Find) -> f64 {
        f64::from(if self.has_floats { find.square } else { find.square.min(1.0) })
    }

    /// Returns the total number of probes.
    fn all_probes(&self) -> f64 {
        (self.probes * self.contents.len() as f64).max(1.0)
    }

    /// Returns the squared error that these samples leave, with one standard error of the part that probes found.
    fn error(&self, samples: &[u16]) -> f64 {
        let of_pixels =
            self.contents.iter().zip(samples).map(|(contents, &count)| contents.errors(count.into()));
        let [edges, details] = of_pixels.fold([0.0; 2], |[a, b], [edge, detail]| [a + edge, b + detail]);
        let add = |[sum, squares]: [f64; 2], error| [sum + error, squares + error * error];
        let [found, squares] = self.finds.iter().map(|find| self.error_of(find, samples)).fold([0.0; 2], add);
        let pixels = self.contents.len() as f64;
        edges / pixels + self.gain * (details / pixels + (found + squares.sqrt()) / self.all_probes())
    }

    /// Returns the squared error of random samples in the area that a probe stands for.
    fn error_of(&self, find: &Find, samples: &[u16]) -> f64 {
        let count = f32::from(samples[find.pixel]);
        // In pictures of bytes, a pixel that one sample makes white has an error of at most white minus black.
        f64::from((find.square / count).min(if self.has_floats { f32::MAX } else { count }))
    }

    /// Chooses pixels with frequencies proportional to the errors expected of details. They are in order, and some may
    /// be chosen repeatedly.
    pub fn to_test(&self, samples: &[u16], count: usize) -> Vec<usize> {
        let of_pixels = self.contents.iter().zip(samples);
        let mut errors: Vec<f64> =
            of_pixels.map(|(contents, &count)| contents.errors(count.into())[1]).collect();
        // White cannot get brighter.
        for find in self.finds.iter().filter(|find| self.has_floats || find.square <= 1.0) {
            errors[find.pixel] += self.error_of(find, samples) / self.probes;
        }
        let step = errors.iter().sum::<f64>() / count as f64;
        let (mut sum, mut chosen) = (0.0, vec![]);
        for (pixel, error) in errors.iter().enumerate() {
            sum += error;
            while (chosen.len() as f64 + 0.5) * step < sum {
                chosen.push(pixel);
            }
        }
        chosen
    }
}

/// Returns the ratio of the squared error of the mean of a pixel's samples to that of random samples, estimated from
/// two sets of them.
pub fn gain_of(sets: [&[Color]; 2]) -> f64 {
    let count = sets[0].len() as f64;
    let [one, other] = sets.map(|set| set.iter().sum::<Color>() / count);
    let mean = 0.5 * (one + other);
    let squares: f64 = sets.into_iter().flatten().map(|&color| (color - mean).length_squared()).sum();
    let random = squares / (count * (2.0 * count - 1.0));
    if random > 0.0 { 0.5 * (one - other).length_squared() / random } else { 1.0 }
}

/// Returns the total number of samples.
pub fn total(samples: &[u16]) -> u64 {
    samples.iter().map(|&count| u64::from(count)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::drand48::Drand48;
    use rand::RngExt;

    const SIDE: usize = 60;

    /// Returns probes of white details on black that cover a part of each pixel and that corners miss.
    fn probed(part: impl Fn(usize) -> f64, probes: usize) -> Known {
        let mut rng = Drand48::seeded(5);
        let mut finds = vec![];
        for pixel in 0..SIDE * SIDE {
            let hits = (0..probes).filter(|_| rng.random::<f64>() < part(pixel)).count();
            finds.extend((0..hits).map(|_| Find { pixel, square: 1.0 }));
        }
        let contents = vec![Contents::default(); SIDE * SIDE];
        let probes = probes as f64;
        Known { width: SIDE, contents, finds, probes, contrast: 1.0, has_floats: false, gain: 1.0 }
    }

    const SETTINGS: Adaptive = Adaptive { most: 1024, error: 4.0 };

    /// Returns the squared error of random samples divided by the target.
    fn left(part: impl Fn(usize) -> f64, samples: &[u16]) -> f64 {
        let error = |(pixel, &count): (usize, &u16)| part(pixel) * (1.0 - part(pixel)) / f64::from(count);
        samples.iter().enumerate().map(error).sum::<f64>() / samples.len() as f64 / SETTINGS.square()
    }

    #[test]
    fn samples_are_as_many_as_what_probes_find_needs() {
        let flat = probed(|_| 0.0, 2).allot(SETTINGS);
        assert!(flat.iter().all(|&count| count <= 2));
        // Details everywhere, and in a quarter of the pixels only.
        let even = |_| 0.05;
        let corner = |pixel: usize| if pixel % SIDE < 30 && pixel / SIDE < 30 { 0.2 } else { 0.0 };
        let [of_even, of_corner] = [probed(even, 4), probed(corner, 4)].map(|known| known.allot(SETTINGS));
        assert!(total(&of_corner) < total(&of_even) / 2);
        for error in [left(even, &of_even), left(corner, &of_corner)] {
            assert!((0.4..1.0).contains(&error), "{error}");
        }
        // One pixel in a hundred, scattered.
        let scattered = |pixel: usize| if pixel * 7919 % 100 == 3 { 0.4 } else { 0.0 };
        let error = left(scattered, &probed(scattered, 4).allot(SETTINGS));
        assert!((0.1..1.1).contains(&error), "{error}");
    }

    #[test]
    fn no_probes_are_cast_where_all_pixels_get_the_most() {
        let probes = |error, pixels| Adaptive { most: 64, error }.probes(pixels, 1.0);
        assert_eq!([probes(0.0, 100), probes(1.0, 100)], [0.0; 2]);
        assert!(probes(2.0, 100) > 0.0 && probes(2.0, 10_000) > probes(2.0, 60_000));
        let none = Known { probes: 0.0, ..probed(|_| 0.0, 0) };
        assert_eq!(none.allot(Adaptive { most: 64, error: 0.0 }), [64; SIDE * SIDE]);
    }

    #[test]
    fn one_find_does_not_take_the_most_samples() {
        let finds = vec![Find { pixel: 1234, square: 1.0 }];
        let known = Known { finds, ..probed(|_| 0.0, 3) };
        assert!(total(&known.allot(SETTINGS)) < 4 * (SIDE * SIDE) as u64);
    }

    #[test]
    fn a_pixels_own_probes_do_not_count_for_it() {
        let mut known = probed(|_| 0.0, 2);
        known.finds = vec![Find { pixel: 30 * SIDE + 30, square: 1.0 }];
        let variances = known.variances(2);
        let mean = 1.0 / (2.0 * (SIDE * SIDE) as f32);
        assert!(variances[30 * SIDE + 30] < 0.1 * mean);
        assert!(variances[30 * SIDE + 31] > 10.0 * mean && variances[0] > 0.0);
    }

    #[test]
    fn smaller_errors_than_expected_save_samples_and_bright_things_take_more() {
        let known = probed(|_| 0.05, 4);
        let all = |known: Known| total(&known.allot(SETTINGS));
        let usual = all(known.clone());
        assert!(all(Known { gain: 0.25, ..known.clone() }) < usual / 3);
        let flat = probed(|_| 0.0, 2);
        assert!(all(Known { contrast: 9.0, ..flat.clone() }) > 20 * all(flat));
        // A detail that makes a pixel of bytes white with any sample causes no larger error.
        let bright = |has_floats| {
            let finds = vec![Find { pixel: 7, square: 900.0 }];
            let known = Known { finds, has_floats, ..probed(|_| 0.0, 2) };
            total(&known.allot(Adaptive { most: 1024, error: 8.0 })) / (SIDE * SIDE) as u64
        };
        let counts = [false, true].map(bright);
        assert!(counts[0] < 10 && (200..600).contains(&counts[1]), "{counts:?}");
        assert_eq!(all(Known { contrast: f32::MAX, ..known }), 1024 * (SIDE * SIDE) as u64);
    }

    #[test]
    fn tests_tell_how_errors_compare_with_those_of_random_samples() {
        let mut rng = Drand48::seeded(2);
        let mut set = |in_strata: bool| -> Vec<Color> {
            let place = |k: usize, random: f64| if in_strata { (k as f64 + random) / 16.0 } else { random };
            (0..16).map(|k| Color::splat(f64::from(u8::from(place(k, rng.random()) < 0.53)))).collect()
        };
        for (in_strata, range) in [(false, 0.85..1.15), (true, 0.04..0.1)] {
            let mean = (0..400).map(|_| gain_of([&set(in_strata), &set(in_strata)])).sum::<f64>() / 400.0;
            assert!(range.contains(&mean), "{in_strata} {mean}");
        }
        assert_eq!(gain_of([&[Color::ONE], &[Color::ONE]]), 1.0);
    }

    #[test]
    fn pixels_are_tested_in_proportion_to_their_errors() {
        let known = probed(|pixel| if pixel < 60 { 0.5 } else { 0.0 }, 4);
        let tested = known.to_test(&[4; SIDE * SIDE], 28);
        assert!(tested.len() == 28 && tested.iter().all(|&pixel| pixel < 60));
        assert_eq!(probed(|_| 0.0, 4).to_test(&[4; SIDE * SIDE], 28), [0; 0]);
        let mut contents = vec![Contents::default(); SIDE * SIDE];
        (contents[1].variance, contents[3].variance) = (0.3, 0.1);
        let known = Known { contents, ..probed(|_| 0.0, 4) };
        assert_eq!(known.to_test(&[4; SIDE * SIDE], 4), [1, 1, 1, 3]);
    }
}
