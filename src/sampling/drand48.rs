//! The 48-bit linear congruential generator of the C library's `drand48`, X <- (0x5DEECE66D X + 0xB) mod
//! 2^48. The course's pictures were made with its random numbers.

use rand::TryRng;
use std::convert::Infallible;

const MULTIPLIER: u64 = 0x5_DEEC_E66D;
const INCREMENT: u64 = 0xB;
const MASK: u64 = (1 << 48) - 1;

/// The generator. Its words hold X in their upper 48 bits, and `random::<f64>()` returns X / 2^48.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Drand48 {
    state: u64,
}

impl Drand48 {
    /// The state X = 0, the initial state of a C program that never seeds the generator, such as the course's.
    pub const UNSEEDED: Self = Self { state: 0 };

    /// Returns the state after C's `srand48(seed)`.
    pub const fn seeded(seed: u32) -> Self {
        Self { state: (seed as u64) << 16 | 0x330E }
    }

    /// Returns the seed that gives this state. `None` if there is none, as for the unseeded generator.
    pub fn seed(self) -> Option<u32> {
        (self.state & 0xFFFF == 0x330E).then_some((self.state >> 16) as u32)
    }

    /// Returns the state X, which is below 2^48.
    #[inline(always)]
    pub(super) fn state(self) -> u64 {
        self.state
    }

    /// Returns the generator after `steps` draws.
    pub fn jumped(self, steps: u64) -> Self {
        self.after(Jump::of(steps))
    }

    /// Returns the generator after a jump.
    #[inline(always)]
    pub fn after(self, jump: Jump) -> Self {
        Self { state: affine(jump.factor, jump.addend, self.state) }
    }
}

/// Many draws at once, as the map x -> factor x + addend of the generator's state.
#[derive(Clone, Copy, Debug)]
pub struct Jump {
    factor: u64,
    addend: u64,
}

impl Jump {
    /// Returns a jump of `steps` draws, in as many operations as `steps` has bits (Brown, "Random Number Generation
    /// with Arbitrary Strides", Trans. Am. Nucl. Soc. 71, 1994).
    pub fn of(mut steps: u64) -> Self {
        let mut all = Self { factor: 1, addend: 0 };
        // A jump of 2^k steps at bit k.
        let mut power = Self { factor: MULTIPLIER, addend: INCREMENT };
        while steps > 0 {
            if steps & 1 == 1 {
                all = all.then(power);
            }
            power = power.then(power);
            steps >>= 1;
        }
        all
    }

    /// Returns this jump followed by `next`.
    fn then(self, next: Self) -> Self {
        let factor = next.factor.wrapping_mul(self.factor) & MASK;
        Self { factor, addend: affine(next.factor, next.addend, self.addend) }
    }
}

fn affine(factor: u64, addend: u64, x: u64) -> u64 {
    factor.wrapping_mul(x).wrapping_add(addend) & MASK
}

impl TryRng for Drand48 {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok((self.try_next_u64()? >> 32) as u32)
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        self.state = affine(MULTIPLIER, INCREMENT, self.state);
        Ok(self.state << 16)
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        // A word has six random bytes, since its lower 16 bits are zero.
        for chunk in bytes.chunks_mut(6) {
            let word = self.try_next_u64()?.to_be_bytes();
            chunk.copy_from_slice(&word[..chunk.len()]);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, RngExt};

    #[test]
    fn the_first_numbers_of_an_unseeded_c_program() {
        let mut rng = Drand48::UNSEEDED;
        let first: [f64; 6] = std::array::from_fn(|_| rng.random());
        let known = [3.9e-14, 0.000985395, 0.041631, 0.176643, 0.364602, 0.0913306];
        assert_eq!(first[0], 11.0 / (1u64 << 48) as f64);
        assert!(first.iter().zip(known).skip(1).all(|(a, b)| (a - b).abs() < 1e-6), "{first:?}");
    }

    #[test]
    fn a_jump_is_as_many_draws() {
        let start = Drand48::seeded(42);
        let mut rng = start;
        for steps in 0..200 {
            assert_eq!(start.jumped(steps), rng);
            let _: f64 = rng.random();
        }
        let far = 123_456_789_012_345;
        assert_eq!(start.jumped(far).jumped(far), start.jumped(2 * far));
        assert_eq!(start.jumped(1 << 48), start, "the period is 2^48");
    }

    #[test]
    fn words_and_bytes_are_the_upper_digits_of_the_state() {
        let mut states = Drand48::seeded(7);
        let mut state = || {
            states = states.jumped(1);
            states.state
        };
        let mut rng = Drand48::seeded(7);
        assert_eq!(rng.next_u64(), state() << 16);
        assert_eq!(rng.next_u32(), (state() >> 16) as u32);
        let mut bytes = [0; 8];
        rng.fill_bytes(&mut bytes);
        assert_eq!(bytes[..6], state().to_be_bytes()[2..]);
        assert_eq!(bytes[6..], state().to_be_bytes()[2..4]);
    }

    #[test]
    fn a_seed_fills_the_upper_32_bits() {
        assert_eq!(Drand48::seeded(1).state, 0x1_330E);
        assert_eq!(Drand48::seeded(u32::MAX).state, 0xFFFF_FFFF_330E);
    }
}
