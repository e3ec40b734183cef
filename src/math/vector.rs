//! Vectors of numbers in one or in four lanes.

use super::simd::{FourLanes, Number};
use fearless_simd::{Simd, SimdFrom, f64x4};
use glam::DVec3;
use std::ops::{Add, Div, Mul, Sub};

/// One vector, or one in each of several lanes, axis by axis. The operations match [`DVec3`] and give the same bits.
#[derive(Clone, Copy, Debug)]
pub struct Vector<N> {
    pub x: N,
    pub y: N,
    pub z: N,
}

impl<N: Number> Vector<N> {
    /// Returns the same vector in all lanes.
    #[inline(always)]
    pub fn splat(simd: N::Proof, v: DVec3) -> Self {
        Self { x: N::splat(simd, v.x), y: N::splat(simd, v.y), z: N::splat(simd, v.z) }
    }

    #[inline(always)]
    pub fn dot(self, other: Self) -> N {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    /// Returns the absolute values.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self { x: self.x.abs(), y: self.y.abs(), z: self.z.abs() }
    }

    /// Returns the maxima, axis by axis, as defined by [`Number::max`].
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self { x: self.x.max(other.x), y: self.y.max(other.y), z: self.z.max(other.z) }
    }

    /// Returns the unit vectors.
    #[inline(always)]
    pub fn normalized(self) -> Self {
        self * self.dot(self).sqrt().recip()
    }
}

impl<S: Simd> Vector<f64x4<S>> {
    /// Loads four vectors, one in each lane.
    #[inline(always)]
    pub fn new(simd: S, [a, b, c, d]: [&DVec3; 4]) -> Self {
        Self {
            x: f64x4::simd_from(simd, [a.x, b.x, c.x, d.x]),
            y: f64x4::simd_from(simd, [a.y, b.y, c.y, d.y]),
            z: f64x4::simd_from(simd, [a.z, b.z, c.z, d.z]),
        }
    }

    /// Returns the four vectors.
    #[inline(always)]
    pub fn to_array(self) -> [DVec3; 4] {
        let ([a, b, c, d], [e, f, g, h]) = (self.x.to_array(), self.y.to_array());
        let [i, j, k, l] = self.z.to_array();
        [DVec3::new(a, e, i), DVec3::new(b, f, j), DVec3::new(c, g, k), DVec3::new(d, h, l)]
    }
}

impl From<DVec3> for Vector<f64> {
    #[inline(always)]
    fn from(DVec3 { x, y, z }: DVec3) -> Self {
        Self { x, y, z }
    }
}

impl From<Vector<f64>> for DVec3 {
    #[inline(always)]
    fn from(Vector { x, y, z }: Vector<f64>) -> Self {
        Self { x, y, z }
    }
}

impl<N: Number> Add for Vector<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<N: Number> Sub for Vector<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl<N: Number> Mul<N> for Vector<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: N) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}

impl<N: Number> Div<N> for Vector<N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, divisor: N) -> Self {
        Self { x: self.x / divisor, y: self.y / divisor, z: self.z / divisor }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::instructions;
    use fearless_simd::dispatch;

    /// Returns the results of every operation on two vectors and a number.
    fn results<N: Number>([p, q]: [Vector<N>; 2], factor: N) -> [Vector<N>; 9] {
        let splat = Vector::splat(factor.proof(), DVec3::new(-3.7, -0.0, 1.0));
        let dot = Vector { x: p.dot(q), ..p };
        [p + q, p - q, p * factor, p / factor, dot, p.cross(q), p.abs(), p.max(q), p.normalized() + splat]
    }

    /// Returns the results of the library for these operations.
    fn expected([p, q]: [DVec3; 2], factor: f64) -> [DVec3; 9] {
        let splat = DVec3::new(-3.7, -0.0, 1.0);
        let max = |axis: usize| crate::math::extremes::max(p[axis], q[axis]);
        let (dot, max) = (DVec3 { x: p.dot(q), ..p }, DVec3::new(max(0), max(1), max(2)));
        [p + q, p - q, p * factor, p / factor, dot, p.cross(q), p.abs(), max, p.normalize() + splat]
    }

    fn computes_as_the_library<S: Simd>(simd: S) {
        let numbers = [0.0, -0.0, 1.0, -3.7, 1e-200, -1e200, f64::INFINITY, f64::NAN, 0.1, 7e-9];
        let vector =
            |k: usize| DVec3::new(numbers[k % 10], numbers[k / 3 % 10], numbers[(7 * k + k / 10) % 10]);
        let bits = |v: DVec3| v.to_array().map(|x| if x.is_nan() { 0 } else { x.to_bits() });
        for k in 0..2000 {
            let [p, q] = [0, 1009].map(|shift| [k, k + 1, k + 2, k + 3].map(|k| vector(5 * k + shift)));
            let four = [p, q].map(|v| Vector::<f64x4<S>>::new(simd, v.each_ref()));
            let found = results(four, f64x4::simd_from(simd, q.map(|v| v.y))).map(Vector::to_array);
            for lane in 0..4 {
                let (p, q) = (p[lane], q[lane]);
                let expected = expected([p, q], q.y).map(bits);
                assert_eq!(
                    results([p.into(), q.into()], q.y).map(DVec3::from).map(bits),
                    expected,
                    "{p} {q}"
                );
                assert_eq!(found.map(|four| four[lane]).map(bits), expected, "{p} {q}");
            }
        }
    }

    #[test]
    fn one_vector_and_four_have_the_bits_of_the_library_s() {
        for level in instructions::available() {
            dispatch!(level, simd => computes_as_the_library(simd));
        }
    }
}
