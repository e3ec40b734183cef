//! The additive feedback generator of the GNU C library's `rand`: s(n) = s(n - 3) + s(n - 31) mod 2^32. A draw is the
//! upper 31 bits. The pictures of assignment 5 of 2012 were made with its numbers.

use glam::DVec2;

/// The number of words of the state.
const WORDS: usize = 31;
/// The distance of the nearer summand.
const NEAR: usize = 3;
/// The number of draws that the library discards after seeding.
const DISCARDED: u64 = 310;

/// A polynomial of degree below [`WORDS`], as coefficients from the constant term on.
type Polynomial = [u32; WORDS];

/// The generator.
#[derive(Clone, Debug)]
pub struct CRand {
    /// The last words of the sequence, in a ring.
    words: [u32; WORDS],
    /// The index of the oldest word.
    oldest: usize,
}

impl CRand {
    /// Returns the state after `srand(1)`, the initial state of a C program that never seeds the generator.
    pub fn unseeded() -> Self {
        let mut words = [1; WORDS];
        for i in 1..WORDS {
            words[i] = (u64::from(words[i - 1]) * 16_807 % 0x7fff_ffff) as u32;
        }
        // The library starts with its indices three apart, so words are used from the fourth on.
        let mut generator = Self { words, oldest: 0 };
        for _ in 0..NEAR {
            let oldest = generator.words[generator.oldest];
            generator.push(oldest);
        }
        generator.jumped(DISCARDED)
    }

    /// Returns the generator after `steps` draws. The word that many steps away is a linear combination of the words in
    /// the state. Its coefficients are those in x^steps modulo the recurrence's polynomial, x^31 - x^28 - 1.
    pub fn jumped(&self, steps: u64) -> Self {
        let mut combination = [0; WORDS];
        combination[0] = 1;
        for bit in (0..u64::BITS - steps.leading_zeros()).rev() {
            combination = product(&combination, &combination);
            if steps >> bit & 1 == 1 {
                combination = times_x(&combination);
            }
        }
        let mut following = self.clone();
        let words = std::array::from_fn(|_| {
            let word = following
                .in_order()
                .zip(combination)
                .fold(0u32, |sum, (word, factor)| sum.wrapping_add(word.wrapping_mul(factor)));
            following.step();
            word
        });
        Self { words, oldest: 0 }
    }

    /// Returns a number from 0 to 1, both included, like `rand() / RAND_MAX`.
    fn next_number(&mut self) -> f64 {
        f64::from(self.step() >> 1) / f64::from(i32::MAX)
    }

    /// Returns the offset of a pixel's sample from its centre. As in the course's program, y is drawn first.
    pub fn next_offset(&mut self) -> DVec2 {
        let (y, x) = (self.next_number(), self.next_number());
        DVec2::new(x, y) - 0.5
    }

    /// Computes the next word of the sequence, which replaces the oldest.
    fn step(&mut self) -> u32 {
        let near = (self.oldest + WORDS - NEAR) % WORDS;
        let word = self.words[self.oldest].wrapping_add(self.words[near]);
        self.push(word);
        word
    }

    fn push(&mut self, word: u32) {
        self.words[self.oldest] = word;
        self.oldest = (self.oldest + 1) % WORDS;
    }

    fn in_order(&self) -> impl Iterator<Item = u32> {
        let (later, earlier) = self.words.split_at(self.oldest);
        earlier.iter().chain(later).copied()
    }
}

fn product(one: &Polynomial, other: &Polynomial) -> Polynomial {
    let mut all = [0u32; 2 * WORDS - 1];
    for (i, a) in one.iter().enumerate() {
        for (j, b) in other.iter().enumerate() {
            all[i + j] = all[i + j].wrapping_add(a.wrapping_mul(*b));
        }
    }
    for degree in (WORDS..all.len()).rev() {
        let factor = all[degree];
        for lower in [degree - NEAR, degree - WORDS] {
            all[lower] = all[lower].wrapping_add(factor);
        }
    }
    std::array::from_fn(|i| all[i])
}

fn times_x(one: &Polynomial) -> Polynomial {
    let highest = one[WORDS - 1];
    let mut shifted = std::array::from_fn(|i| if i == 0 { highest } else { one[i - 1] });
    shifted[WORDS - NEAR] = shifted[WORDS - NEAR].wrapping_add(highest);
    shifted
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The output of a C program that calls `rand` without `srand`.
    const FIRST: [u32; 6] =
        [1_804_289_383, 846_930_886, 1_681_692_777, 1_714_636_915, 1_957_747_793, 424_238_335];

    #[test]
    fn the_first_numbers_are_those_of_the_library() {
        let mut generator = CRand::unseeded();
        assert_eq!([(); 6].map(|()| generator.step() >> 1), FIRST);
    }

    #[test]
    fn a_jump_is_as_many_draws() {
        for steps in [0, 1, 2, 3, 30, 31, 32, 1000, 123_457] {
            let mut drawn = CRand::unseeded();
            (0..steps).for_each(|_| _ = drawn.step());
            let mut jumped = CRand::unseeded().jumped(steps);
            for _ in 0..100 {
                assert_eq!(jumped.step(), drawn.step(), "{steps}");
            }
        }
    }
}
