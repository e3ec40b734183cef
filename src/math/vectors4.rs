//! Four vectors, one in each SIMD lane.

use super::f64x4::F64x4;
use glam::DVec3;

/// Four vectors, axis by axis. The operations are those of [`DVec3`] and give the same bits.
#[derive(Clone, Copy, Debug)]
pub struct Vectors4<F> {
    pub x: F,
    pub y: F,
    pub z: F,
}

impl<F: F64x4> Vectors4<F> {
    /// These vectors.
    #[inline(always)]
    pub fn new(proof: F::Proof, [a, b, c, d]: [&DVec3; 4]) -> Self {
        Self {
            x: F::new(proof, [a.x, b.x, c.x, d.x]),
            y: F::new(proof, [a.y, b.y, c.y, d.y]),
            z: F::new(proof, [a.z, b.z, c.z, d.z]),
        }
    }

    /// The same vector in all lanes.
    #[cfg_attr(not(feature = "fast"), allow(dead_code, reason = "only the fast twin needs it"))]
    #[inline(always)]
    pub fn splat(proof: F::Proof, v: DVec3) -> Self {
        Self { x: F::splat(proof, v.x), y: F::splat(proof, v.y), z: F::splat(proof, v.z) }
    }

    /// The four vectors.
    #[inline(always)]
    pub fn to_array(self) -> [DVec3; 4] {
        let ([a, b, c, d], [e, f, g, h]) = (self.x.to_array(), self.y.to_array());
        let [i, j, k, l] = self.z.to_array();
        [DVec3::new(a, e, i), DVec3::new(b, f, j), DVec3::new(c, g, k), DVec3::new(d, h, l)]
    }

    #[inline(always)]
    pub fn plus(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }

    #[inline(always)]
    pub fn minus(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }

    /// The products with these numbers.
    #[inline(always)]
    pub fn times(self, factor: F) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }

    /// The quotients by these numbers.
    #[inline(always)]
    pub fn over(self, divisor: F) -> Self {
        Self { x: self.x / divisor, y: self.y / divisor, z: self.z / divisor }
    }

    #[inline(always)]
    pub fn dot(self, other: Self) -> F {
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

    /// The absolute values.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self { x: self.x.abs(), y: self.y.abs(), z: self.z.abs() }
    }

    /// The maxima, axis by axis, as [`F64x4::max`] takes them.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self { x: self.x.max(other.x), y: self.y.max(other.y), z: self.z.max(other.z) }
    }

    /// The unit vectors.
    #[inline(always)]
    pub fn normalized(self) -> Self {
        self.times(self.dot(self).sqrt().recip())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::f64x4::Scalar;
    use crate::math::instructions::Portable;

    fn computes_as_single_vectors<F: F64x4>(proof: F::Proof) {
        let numbers = [0.0, -0.0, 1.0, -3.7, 1e-200, -1e200, f64::INFINITY, f64::NAN, 0.1, 7e-9];
        let vector =
            |k: usize| DVec3::new(numbers[k % 10], numbers[k / 3 % 10], numbers[(7 * k + k / 10) % 10]);
        for k in 0..2000 {
            let [p, q] = [0, 1009].map(|shift| [k, k + 1, k + 2, k + 3].map(|k| vector(5 * k + shift)));
            let [a, b] = [p, q].map(|v| Vectors4::<F>::new(proof, v.each_ref()));
            let factors = q.map(|v| v.y);
            let check = |found: Vectors4<F>, expected: fn(DVec3, DVec3) -> DVec3| {
                for (found, (p, q)) in found.to_array().into_iter().zip(p.into_iter().zip(q)) {
                    let bits = |v: DVec3| v.to_array().map(|x| if x.is_nan() { 0 } else { x.to_bits() });
                    assert_eq!(bits(found), bits(expected(p, q)), "{p} {q}");
                }
            };
            check(a, |p, _| p);
            check(Vectors4::splat(proof, DVec3::new(-3.7, -0.0, 1.0)), |_, _| DVec3::new(-3.7, -0.0, 1.0));
            check(a.plus(b), |p, q| p + q);
            check(a.minus(b), |p, q| p - q);
            check(a.times(F::new(proof, factors)), |p, q| p * q.y);
            check(a.over(F::new(proof, factors)), |p, q| p / q.y);
            check(Vectors4 { x: a.dot(b), y: a.x, z: b.z }, |p, q| DVec3::new(p.dot(q), p.x, q.z));
            check(a.cross(b), |p, q| p.cross(q));
            check(a.abs(), |p, _| p.abs());
            check(a.max(b), |p, q| {
                let max = crate::math::extremes::max;
                DVec3::new(max(p.x, q.x), max(p.y, q.y), max(p.z, q.z))
            });
            check(a.normalized(), |p, _| p.normalize());
        }
    }

    #[test]
    fn four_vectors_have_the_bits_of_single_ones() {
        computes_as_single_vectors::<Scalar>(Portable);
        #[cfg(target_arch = "x86_64")]
        if let Some(proof) = crate::math::instructions::Avx2::detect() {
            computes_as_single_vectors::<crate::math::avx::Avx>(proof);
        }
    }
}
