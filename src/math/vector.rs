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
