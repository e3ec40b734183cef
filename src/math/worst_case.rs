//! Searches for inputs whose rounding errors come close to an error bound, for tests that the bound is needed. The
//! result does not depend on the machine.

use glam::DVec3;

/// Splitmix64 (Steele, Lea, Flood, OOPSLA 2014).
pub struct Rng(pub u64);

impl Rng {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Returns an integer from 0 to n - 1.
    pub fn below(&mut self, n: u64) -> usize {
        (self.next() % n) as usize
    }

    /// Returns a uniform number in [-1, 1).
    pub fn signed(&mut self) -> f64 {
        (self.next() >> 10) as f64 / (1u64 << 53) as f64 - 1.0
    }

    /// Returns a uniform number in [0, 1].
    pub fn unit(&mut self) -> f64 {
        self.signed().abs()
    }

    /// Returns a uniform point in the cube from -1 to 1.
    pub fn vector(&mut self) -> DVec3 {
        DVec3::new(self.signed(), self.signed(), self.signed())
    }
}

/// The numbers of an input, three at a time.
pub type Input<const N: usize> = [DVec3; N];

/// Returns a copy in which one coordinate, or all three of one vector, are changed by a random amount.
fn changed<const N: usize>(mut input: Input<N>, rng: &mut Rng) -> Input<N> {
    let vector = &mut input[rng.below(N as u64)];
    let size = libm::exp10(-17.0 * rng.unit());
    match rng.below(3) {
        0 => *vector += size * rng.vector(),
        1 => vector[rng.below(3)] += size * rng.signed(),
        _ => {
            let x = &mut vector[rng.below(3)];
            *x = f64::from_bits((x.to_bits() as i64 + rng.below(17) as i64 - 8) as u64);
        }
    }
    input
}

/// Climbs from a random input to ever larger values, in `steps` steps. The value is `None` for an input that does not
/// count. Returns the largest value and its input.
pub fn climb<const N: usize>(
    seed: u64,
    steps: usize,
    start: impl Fn(&mut Rng) -> Input<N>,
    value: impl Fn(&Input<N>) -> Option<f64>,
) -> (f64, Input<N>) {
    let rng = &mut Rng(seed);
    let mut input = start(rng);
    let mut best = value(&input);
    for _ in 0..steps {
        let next = if best.is_none() { start(rng) } else { changed(input, rng) };
        let found = value(&next);
        if found.is_some() && found >= best {
            (input, best) = (next, found);
        }
    }
    (best.unwrap_or(0.0), input)
}

/// Returns the largest result of [`climb`] from several starts.
pub fn search<const N: usize>(
    starts: u64,
    steps: usize,
    start: impl Fn(&mut Rng) -> Input<N>,
    value: impl Fn(&Input<N>) -> Option<f64>,
) -> (f64, Input<N>) {
    let climbed = (0..starts).map(|seed| climb(seed, steps, &start, &value));
    climbed.max_by(|(x, _), (y, _)| x.total_cmp(y)).expect("a start")
}
