//! Adaptive sampling: uses probes to allot the number of samples that reaches the target error.
//!
//! Pixel corners miss details between them: dots, hairs, shadows, highlights, reflections. Probes at random positions
//! find them. The distance of a probe's colour from the range of its pixel's corners estimates the variance around it.
//! A pixel's own probes do not influence its number of samples, so they give an unbiased estimate of the plan's error.
//! All pixels get more samples, in proportion to their needs, until the estimate reaches the target. There are two
//! plans, one from the probes around each pixel and one from the mean of all probes. The plan with fewer samples is
//! used.
//!
//! Stratified samples leave less error than expected where details are larger than strata. The ratio is measured in
//! some pixels if it may save many samples.

use super::adaptive::{Adaptive, Contents};
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
    /// The contents of each pixel, row by row.
    pub contents: Vec<Contents>,
    /// The probes that found something.
    pub finds: Vec<Find>,
    /// The average number of probes per pixel.
    pub probes: f64,
    /// The largest contrast assumed for details that the probes missed.
    pub contrast: f32,
    /// True if colours brighter than white count in full.
    pub has_floats: bool,
    /// The ratios of measured to expected squared errors, for errors estimated from contents and from finds.
    pub gains: [f64; 2],
}

/// The numbers of samples of some pixels.
#[derive(Clone, Debug)]
pub struct Allotment {
    /// The number of samples of each pixel.
    pub samples: Vec<u16>,
    /// The fraction of the squared error due to the uncertainty of the estimate.
    pub doubt: f64,
}

/// A pixel used to test a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tested {
    /// The index of the pixel.
    pub pixel: usize,
    /// The expected squared error. `None` if it is the error of random samples.
    pub expected: Option<f64>,
}

/// The fraction of the target squared error permitted for details that all probes are likely to miss, and the fraction
/// permitted for the rest.
const MISSED: f64 = 0.5;
const ALLOWED: f64 = 0.65;

/// The number of probes around a pixel that estimate its variance, and the number of them that has the weight of all
/// others.
const AROUND: f64 = 64.0;
const OF_ALL: f64 = 16.0;

/// The largest average number of probes per pixel, apart from those added when few have found much.
const MOST_PROBES: f64 = 16.0;

/// The index of the finest plan, the ratio of fineness between successive plans, and the index of the usual one.
const FINEST: u32 = 64;
const FINER: f32 = 1.5;
const USUAL: u32 = 10;

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
    pub fn allot(&self, settings: Adaptive) -> Allotment {
        let side = ((AROUND / self.probes).sqrt() / 3.0).ceil().clamp(1.0, self.contents.len() as f64);
        let local = self.allot_by(settings, &self.variances(side as usize));
        // Nothing was found, so nothing can be uneven.
        if self.finds.is_empty() {
            return local;
        }
        let mean = self.finds.iter().map(|find| f64::from(find.square)).sum::<f64>() / self.all_probes();
        let even = self.allot_by(settings, &vec![mean as f32; self.contents.len()]);
        if even.total() < local.total() { even } else { local }
    }

    /// Returns the allotment if pixels have at least these variances.
    fn allot_by(&self, settings: Adaptive, variances: &[f32]) -> Allotment {
        let need = settings.needs();
        let needs = self.contents.iter().zip(variances);
        let needs: Vec<[f32; 4]> =
            needs.map(|(contents, &variance)| need(contents.with_variance(variance))).collect();
        let floor = (settings.missed(self.contrast) / self.all_probes()).ceil();
        let (floor, most) = (floor.clamp(1.0, settings.most.into()) as f32, settings.most as f32);
        let by_fineness = |step: u32| {
            let fineness = FINER.powi(step as i32 - USUAL as i32);
            // Known details never get fewer samples than usual.
            let root = fineness.max(1.0).sqrt().sqrt();
            let by = [root * root.sqrt(), root, root * root, fineness.sqrt()];
            let count = |need: &[f32; 4]| {
                let [a, b, c, d] = [0, 1, 2, 3].map(|k| need[k] * by[k]);
                // `max` and `min` drop a NaN. It comes from infinity or 0 / 0, where more samples do not help.
                let count = a.max(b).max(c).max(d).max(floor).min(most);
                // Faster than `ceil`.
                let whole = count as u16;
                whole + u16::from(f32::from(whole) < count)
            };
            let samples: Vec<u16> = needs.iter().map(count).collect();
            let [error, doubt] = self.error(&samples);
            let is_enough = error <= ALLOWED * settings.square();
            (is_enough, Allotment { samples, doubt: doubt / error.max(f64::MIN_POSITIVE) })
        };
        let (is_enough, coarsest) = by_fineness(0);
        if is_enough {
            return coarsest;
        }
        let (mut coarse, mut fine, mut best) = (0, FINEST, None);
        while fine - coarse > 1 {
            let step = (coarse + fine) / 2;
            match by_fineness(step) {
                (true, allotment) => (fine, best) = (step, Some(allotment)),
                (false, _) => coarse = step,
            }
        }
        best.unwrap_or_else(|| by_fineness(FINEST).1)
    }

    /// Returns the variance around each pixel found by other pixels' probes, in the nine cells of this side around it.
    fn variances(&self, side: usize) -> Vec<f32> {
        let Self { width, probes, .. } = *self;
        let height = self.contents.len() / width;
        let [columns, rows] = [width, height].map(|count| count.div_ceil(side));
        let cell = move |pixel: usize| pixel / width / side * columns + pixel % width / side;
        let (mut own, mut cells) = (vec![0.0f32; self.contents.len()], vec![0.0f64; columns * rows]);
        for find in &self.finds {
            own[find.pixel] += find.square;
            cells[cell(find.pixel)] += f64::from(find.square);
        }
        let total: f64 = cells.iter().sum();
        let around = |cell: usize, count: usize, pixels: usize| {
            let cells = cell.saturating_sub(1)..(cell + 2).min(count);
            (cells.clone(), (cells.end * side).min(pixels) - cells.start * side)
        };
        let of_cell = |k: usize| {
            let (i, across) = around(k % columns, columns, width);
            let (j, along) = around(k / columns, rows, height);
            let found = j.map(|j| cells[j * columns..][i.clone()].iter().sum::<f64>()).sum::<f64>();
            [found, (across * along - 1) as f64 * probes]
        };
        let sums: Vec<[f64; 2]> = (0..cells.len()).map(of_cell).collect();
        let others = ((own.len() - 1) as f64 * probes).max(1.0);
        let of_pixel = |(pixel, &own): (usize, &f32)| {
            let ([found, number], own) = (sums[cell(pixel)], f64::from(own));
            let mean = (total - own) / others;
            ((found - own + OF_ALL * mean) / (number + OF_ALL)).max(0.0) as f32
        };
        own.iter().enumerate().map(of_pixel).collect()
    }

    /// Returns the total number of probes.
    fn all_probes(&self) -> f64 {
        (self.probes * self.contents.len() as f64).max(1.0)
    }

    /// Returns the expected squared errors of pixels from their contents.
    fn by_contents(&self, samples: &[u16]) -> impl Iterator<Item = f64> {
        self.contents.iter().zip(samples).map(|(contents, &count)| contents.error(count.into()).into())
    }

    /// Returns the expected squared errors at finds.
    fn by_finds(&self, samples: &[u16]) -> impl Iterator<Item = f64> {
        self.finds.iter().map(|find| {
            let count = f32::from(samples[find.pixel]);
            // In pictures of bytes, a pixel that one sample makes white has an error of at most white minus black.
            f64::from((find.square / count).min(if self.has_floats { f32::MAX } else { count }))
        })
    }

    /// Returns the squared error that these samples leave, and the part of it that is uncertainty.
    fn error(&self, samples: &[u16]) -> [f64; 2] {
        let [of_contents, of_finds] = self.gains;
        let by_contents = self.by_contents(samples).sum::<f64>() / self.contents.len() as f64;
        let add = |[sum, squares]: [f64; 2], error| [sum + error, squares + error * error];
        let [sum, squares] = self.by_finds(samples).fold([0.0; 2], add);
        let [found, doubt] = [sum, squares.sqrt()].map(|sum| of_finds * sum / self.all_probes());
        [of_contents * by_contents + found + doubt, doubt]
    }

    /// Chooses pixels to test a plan in, with frequencies proportional to the errors expected from contents, and from
    /// finds.
    pub fn to_test(&self, samples: &[u16]) -> [Vec<Tested>; 2] {
        let count = (self.contents.len() / 128).clamp(16, 64);
        let by_contents: Vec<f64> = self.by_contents(samples).collect();
        // White cannot get brighter.
        let counts = |find: &Find| self.has_floats || find.square <= 1.0;
        let by_finds = self.finds.iter().zip(self.by_finds(samples));
        let by_finds: Vec<f64> =
            by_finds.map(|(find, error)| if counts(find) { error } else { 0.0 }).collect();
        let of_pixel = |pixel: usize| Tested { pixel, expected: Some(by_contents[pixel]) };
        let of_find = |k: usize| Tested { pixel: self.finds[k].pixel, expected: None };
        [
            evenly(&by_contents, count).into_iter().map(of_pixel).collect(),
            evenly(&by_finds, count).into_iter().map(of_find).collect(),
        ]
    }
}

impl Allotment {
    /// Returns the total number of samples.
    pub fn total(&self) -> u64 {
        self.samples.iter().map(|&count| u64::from(count)).sum()
    }
}

/// Returns the indices at even steps in the cumulative sum of `weights`.
fn evenly(weights: &[f64], count: usize) -> Vec<usize> {
    let step = weights.iter().sum::<f64>() / count as f64;
    let (mut sum, mut next, mut chosen) = (0.0, 0.5 * step, vec![]);
    for (k, weight) in weights.iter().enumerate() {
        sum += weight;
        while next < sum {
            chosen.push(k);
            next += step;
        }
    }
    chosen
}

/// Returns the squared error of the mean of a pixel's samples, estimated from two sets of them, and the squared error
/// of the same number of random samples.
pub fn own_and_random_error(sets: [&[Color]; 2]) -> [f64; 2] {
    let count = sets[0].len() as f64;
    let [one, other] = sets.map(|set| set.iter().sum::<Color>() / count);
    let mean = 0.5 * (one + other);
    let squares: f64 = sets.into_iter().flatten().map(|&color| (color - mean).length_squared()).sum();
    [(one - other).length_squared() / 6.0, squares / (3.0 * count * (2.0 * count - 1.0))]
}

/// Returns the mean ratio of measured to expected squared errors plus its standard error, or 1 if none was tested.
pub fn gain(tested: &[Tested], errors: impl Fn(usize) -> [f64; 2]) -> f64 {
    let ratio = |&Tested { pixel, expected }: &Tested| {
        let [own, random] = errors(pixel);
        let expected = expected.unwrap_or(random);
        if expected > 0.0 { own / expected } else { 1.0 }
    };
    let add = |[sum, squares]: [f64; 2], ratio| [sum + ratio, squares + ratio * ratio];
    let count = tested.len() as f64;
    let [mean, square] = tested.iter().map(ratio).fold([0.0; 2], add).map(|sum| sum / count);
    if count > 0.0 { mean + ((square - mean * mean).max(0.0) / count).sqrt() } else { 1.0 }
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
        let (probes, gains) = (probes as f64, [1.0; 2]);
        Known { width: SIDE, contents, finds, probes, contrast: 1.0, has_floats: false, gains }
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
        assert!(flat.samples.iter().all(|&count| count <= 2) && flat.doubt == 0.0);
        // Details everywhere, and in a quarter of the pixels only.
        let even = |_| 0.05;
        let corner = |pixel: usize| if pixel % SIDE < 30 && pixel / SIDE < 30 { 0.2 } else { 0.0 };
        let totals = [probed(even, 4), probed(corner, 4)].map(|known| known.allot(SETTINGS).total());
        assert!(totals[1] < totals[0] / 2, "{totals:?}");
        for error in [
            left(even, &probed(even, 4).allot(SETTINGS).samples),
            left(corner, &probed(corner, 4).allot(SETTINGS).samples),
        ] {
            assert!((0.4..1.0).contains(&error), "{error}");
        }
        // One pixel in a hundred, scattered.
        let scattered = |pixel: usize| if pixel * 7919 % 100 == 3 { 0.4 } else { 0.0 };
        let error = left(scattered, &probed(scattered, 4).allot(SETTINGS).samples);
        assert!((0.1..1.1).contains(&error), "{error}");
    }

    #[test]
    fn no_probes_are_cast_where_all_pixels_get_the_most() {
        let probes = |error, pixels| Adaptive { most: 64, error }.probes(pixels, 1.0);
        assert_eq!([probes(0.0, 100), probes(1.0, 100)], [0.0; 2]);
        assert!(probes(2.0, 100) > 0.0 && probes(2.0, 10_000) > probes(2.0, 60_000));
        let none = Known { probes: 0.0, ..probed(|_| 0.0, 0) };
        assert_eq!(none.allot(Adaptive { most: 64, error: 0.0 }).samples, [64; SIDE * SIDE]);
    }

    #[test]
    fn one_find_does_not_take_the_most_samples() {
        let finds = vec![Find { pixel: 1234, square: 1.0 }];
        let known = Known { finds, ..probed(|_| 0.0, 3) };
        let allotment = known.allot(SETTINGS);
        assert!(allotment.total() < 4 * (SIDE * SIDE) as u64 && allotment.doubt > 0.4);
    }

    #[test]
    fn a_pixels_own_probes_do_not_count_for_it() {
        let mut known = probed(|_| 0.0, 2);
        known.finds = vec![Find { pixel: 30 * SIDE + 30, square: 1.0 }];
        let variances = known.variances(2);
        assert_eq!(variances[30 * SIDE + 30], 0.0);
        assert!(variances[30 * SIDE + 31] > 0.0 && variances[0] > 0.0);
    }

    #[test]
    fn smaller_errors_than_expected_save_samples_and_bright_things_take_more() {
        let known = probed(|_| 0.05, 4);
        let total = |known: Known| known.allot(SETTINGS).total();
        let usual = total(known.clone());
        assert!(total(Known { gains: [1.0, 0.25], ..known.clone() }) < usual / 3);
        let flat = probed(|_| 0.0, 2);
        assert!(total(Known { contrast: 9.0, ..flat.clone() }) > 20 * total(flat));
        // A detail that makes a pixel of bytes white with any sample causes no larger error.
        let bright = |has_floats| {
            let finds = vec![Find { pixel: 7, square: 900.0 }];
            let known = Known { finds, has_floats, ..probed(|_| 0.0, 2) };
            known.allot(Adaptive { most: 1024, error: 8.0 }).total()
        };
        let counts = [false, true].map(|has_floats| bright(has_floats) / (SIDE * SIDE) as u64);
        assert!(counts[0] < 5 && (200..600).contains(&counts[1]), "{counts:?}");
        assert!(total(Known { contrast: f32::MAX, ..known }) == 1024 * (SIDE * SIDE) as u64);
    }

    #[test]
    fn tests_tell_how_errors_compare_with_those_of_random_samples() {
        let mut rng = Drand48::seeded(2);
        let mut set = |in_strata: bool| -> Vec<Color> {
            let place = |k: usize, random: f64| if in_strata { (k as f64 + random) / 16.0 } else { random };
            (0..16).map(|k| Color::splat(f64::from(u8::from(place(k, rng.random()) < 0.53)))).collect()
        };
        let tested: Vec<Tested> = (0..400).map(|pixel| Tested { pixel, expected: None }).collect();
        for (in_strata, range) in [(false, 0.9..1.2), (true, 0.05..0.1)] {
            let errors: Vec<[f64; 2]> =
                (0..400).map(|_| own_and_random_error([&set(in_strata), &set(in_strata)])).collect();
            let found = gain(&tested, |pixel| errors[pixel]);
            assert!(range.contains(&found), "{in_strata} {found}");
        }
        assert_eq!(gain(&[], |_| [0.0; 2]), 1.0);
    }

    #[test]
    fn pixels_are_tested_in_proportion_to_their_errors() {
        assert_eq!(evenly(&[0.0, 3.0, 0.0, 1.0], 4), [1, 1, 1, 3]);
        assert_eq!(evenly(&[0.0; 3], 4), [0; 0]);
        let known = probed(|pixel| if pixel < 60 { 0.5 } else { 0.0 }, 4);
        let [by_contents, by_finds] = known.to_test(&[4; SIDE * SIDE]);
        assert!(by_contents.is_empty() && (27..=29).contains(&by_finds.len()));
        assert!(by_finds.iter().all(|tested| tested.pixel < 60 && tested.expected.is_none()));
    }
}
