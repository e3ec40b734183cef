//! Exact rational arithmetic on the bits of floats.

use glam::DVec3;
use num_rational::BigRational;

/// The exact value of a finite float.
pub fn exact(x: f64) -> BigRational {
    BigRational::from_float(x).expect("a finite float")
}

pub fn exact3(v: DVec3) -> [BigRational; 3] {
    v.to_array().map(exact)
}

pub fn dot(a: &[BigRational; 3], b: &[BigRational; 3]) -> BigRational {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

pub fn sub(a: &[BigRational; 3], b: &[BigRational; 3]) -> [BigRational; 3] {
    [&a[0] - &b[0], &a[1] - &b[1], &a[2] - &b[2]]
}

pub fn cross(a: &[BigRational; 3], b: &[BigRational; 3]) -> [BigRational; 3] {
    let at = |i: usize, j: usize| &a[i] * &b[j] - &a[j] * &b[i];
    [at(1, 2), at(2, 0), at(0, 1)]
}
