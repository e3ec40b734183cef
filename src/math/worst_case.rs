//! Random numbers for tests. They do not depend on the machine.

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
