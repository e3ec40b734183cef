//! The decisions of adaptive sampling: which pixels decide for which others, and how many samples the latter get. The
//! header of [`super`] has the rules.

use std::ops::Range;

/// The weight of doubt in the estimate.
const DOUBT: f64 = 2.0;

/// The limits of the growth of all samples in a pass.
const GROWTH: Range<f64> = 1.3..2.5;

/// The side of a square of pixels of one group.
const SQUARE: usize = 8;
/// The number of squares after which the groups repeat along each axis.
const TURNS: usize = 4;
pub const GROUPS: usize = TURNS * TURNS;
/// The number of places along an axis that differ in the groups around: the middle of a square, or its border with the
/// next one.
const SIDES: usize = 2 * TURNS;
pub const SURROUNDINGS: usize = SIDES * SIDES;

/// The number of classes for a doubling of w.
const STEPS: i32 = 8;
/// The D of the first class.
const LEAST_D: f32 = 1e-7;
/// The number of classes of pixels by w, up to 2^28 times the least w. Greater ones do not differ.
pub const CLASSES: usize = 224;

/// With this scale no pixel gets more samples.
pub const LEAST_SCALE: i32 = -(CLASSES as i32);

/// Sums of pixels.
#[derive(Clone, Copy, Default)]
pub struct Sums {
    /// The number of pixels, the sum of their estimated squared errors and the sum of the errors' squares.
    pub pixels: f64,
    pub error: f64,
    pub squares: f64,
}

/// Pixels of a class that decide for a group, all with the same number of samples.
pub struct Deciding {
    /// The number of samples, as its logarithm to base 2.
    pub doublings: u8,
    pub class: usize,
    pub sums: Sums,
}

/// The pixels that decide for a group.
pub struct DecidingPixels {
    /// The logarithm to base 2 of the largest number of samples.
    pub most: u8,
    pub parts: Vec<Deciding>,
}

impl DecidingPixels {
    /// Returns the estimated squared error, with doubt, if all these pixels had at least the numbers of samples that
    /// follow from this scale, and the number of their samples then.
    pub fn expected(&self, scale: i32) -> [f64; 2] {
        let [mut pixels, mut samples, mut error, mut squares] = [0.0; 4];
        for Deciding { doublings: before, class, sums } in &self.parts {
            let doublings = grown(*before, scale, *class, self.most);
            let less = LESS[usize::from(doublings - before)];
            pixels += sums.pixels;
            samples += sums.pixels * f64::from(1u32 << doublings);
            error += less * sums.error;
            squares += less * less * sums.squares;
        }
        [(error + DOUBT * squares.sqrt()) / f64::max(pixels, 1.0), samples]
    }

    /// Returns the scale above this one that leaves this error, within the limits of growth.
    pub fn next_scale(&self, scale: i32, aim: f64) -> i32 {
        let [_, samples_before] = self.expected(scale);
        let is_enough = |scale: i32| {
            let [error, samples] = self.expected(scale);
            let growth = samples / samples_before;
            growth >= GROWTH.start && (error <= aim || growth >= GROWTH.end)
        };
        // With the last scale all pixels get the most.
        let (mut low, mut high) = (scale, STEPS * (i32::from(self.most) + 1));
        while high - low > 1 {
            let middle = (low + high) / 2;
            if is_enough(middle) { high = middle } else { low = middle }
        }
        high
    }
}

/// The error with twice as many samples, with four times as many and so on, over the error without them: 2^-1.5k.
const LESS: [f64; 11] = {
    let mut less = [1.0; 11];
    let mut k = 1;
    while k < less.len() {
        less[k] = 0.5 * std::f64::consts::FRAC_1_SQRT_2 * less[k - 1];
        k += 1;
    }
    less
};

/// Returns the group of the pixel at this place in its tile.
pub fn group([x, y]: [usize; 2]) -> usize {
    y / SQUARE % TURNS * TURNS + x / SQUARE % TURNS
}

/// Returns the index of the surroundings of the pixel at this place in its tile: its sides along both axes. The pixels on
/// both sides of the border before square t are on side 2t, and the other pixels of square t are on side 2t + 1.
pub fn surroundings(place: [usize; 2]) -> u8 {
    let [x, y] = place.map(|k| (k + 1) / SQUARE % TURNS * 2 + usize::from((k + 1) % SQUARE >= 2));
    (SIDES * y + x) as u8
}

/// Returns true if this group leaves pixels with these surroundings out: they or their neighbours are of the group.
pub fn is_left_out(surroundings: usize, group: usize) -> bool {
    let is_on = |side: usize, turn: usize| {
        turn == side / 2 || (side.is_multiple_of(2) && (turn + 1) % TURNS == side / 2)
    };
    is_on(surroundings % SIDES, group % TURNS) && is_on(surroundings / SIDES, group / TURNS)
}

/// Returns the class of a pixel with this D.
pub fn class(d: f32) -> usize {
    // The bits of a float are about its logarithm to base 2, times 2^23.
    let doublings = d.max(LEAST_D).to_bits() - LEAST_D.to_bits();
    let steps = (u64::from(doublings) * (2 * STEPS as u64) / 5) >> 23;
    (steps as usize).min(CLASSES - 1)
}

/// Returns a D in the middle of a class.
pub fn middle(class: usize) -> f32 {
    let steps = ((2 * class as u64 + 1) << 22) * 5 / (2 * STEPS as u64);
    if class == 0 { 0.0 } else { f32::from_bits(LEAST_D.to_bits() + steps as u32) }
}

/// Returns the larger number of samples of these, and k w rounded to a power of two, as logarithms to base 2. `scale` is
/// the logarithm of k, in steps of the classes.
pub fn grown(doublings: u8, scale: i32, class: usize, most: u8) -> u8 {
    let wanted = (scale + class as i32 + STEPS / 2).div_euclid(STEPS);
    doublings.max(wanted.clamp(0, i32::from(most)) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_group_leaves_out_its_pixels_and_their_neighbours() {
        for [x, y] in (0..80usize).flat_map(|y| (0..80usize).map(move |x| [x, y])) {
            let rows = y.saturating_sub(1)..y + 2;
            let near = rows.flat_map(|y| (x.saturating_sub(1)..x + 2).map(move |x| 1u32 << group([x, y])));
            let found = (0..GROUPS).filter(|&group| is_left_out(usize::from(surroundings([x, y])), group));
            let found = found.fold(0, |all, group| all | 1 << group);
            let near = near.fold(0, |all, bit| all | bit);
            // At the first column and row of a tile, more are left out.
            assert!(found == near || ((x == 0 || y == 0) && found & near == near), "{x} {y}");
        }
    }

    #[test]
    fn classes_are_even_steps_of_w() {
        assert_eq!([0.0, LEAST_D].map(class), [0, 0]);
        for doublings in 0..20usize {
            // w doubles if D becomes 2^2.5 times as large.
            let d = LEAST_D * (2.5 * doublings as f32).exp2();
            assert!(class(d).abs_diff(doublings * STEPS as usize) <= 1, "{doublings}");
        }
        assert_eq!(class(f32::MAX), CLASSES - 1);
        assert!((1..CLASSES).all(|k| class(middle(k)) == k) && middle(0) == 0.0);
    }

    #[test]
    fn numbers_of_samples_grow_to_the_nearest_power_of_two() {
        let scale = |k: f64| (k.log2() * f64::from(STEPS)).round() as i32;
        for (k, doublings) in [(0.1, 2), (4.0, 2), (10.0, 3), (12.0, 4), (900.0, 10), (1e5, 10)] {
            assert_eq!(grown(2, scale(k), 0, 10), doublings, "{k}");
        }
        assert_eq!(grown(3, LEAST_SCALE, CLASSES - 1, 10), 3);
    }

    #[test]
    fn the_next_scale_leaves_the_error_that_is_aimed_at() {
        let part = |doublings: u8, class: usize, pixels: f64, error: f64| {
            let sums = Sums { pixels, error, squares: error * error / pixels };
            Deciding { doublings, class, sums }
        };
        let parts = vec![part(1, 0, 900.0, 1.0), part(1, 40, 100.0, 50.0), part(3, 80, 50.0, 20.0)];
        let others = DecidingPixels { most: 10, parts };
        let [before, samples] = others.expected(LEAST_SCALE);
        for part in [0.9, 0.5, 0.1] {
            let scale = others.next_scale(LEAST_SCALE, part * before);
            let ([error, more], [less, _]) = (others.expected(scale), others.expected(scale - 1));
            assert!(error <= part * before || more >= GROWTH.end * samples, "{part}");
            assert!(more >= GROWTH.start * samples && (less > error || scale == LEAST_SCALE + 1), "{part}");
        }
    }
}
