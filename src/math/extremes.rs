//! The lesser and the greater of numbers, in one instruction each: unlike the library's, these have no
//! opinion on NaN, and give the second where either is one.

use glam::DVec3;

/// The lesser of two.
#[inline(always)]
pub fn lesser<T: PartialOrd>(a: T, b: T) -> T {
    if a < b { a } else { b }
}

/// The greater of two.
#[inline(always)]
pub fn greater<T: PartialOrd>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

/// The least of three.
#[inline(always)]
pub fn least<T: PartialOrd>([a, b, c]: [T; 3]) -> T {
    lesser(lesser(a, b), c)
}

/// The greatest of three.
#[inline(always)]
pub fn greatest<T: PartialOrd>([a, b, c]: [T; 3]) -> T {
    greater(greater(a, b), c)
}

/// The corners of the box around three points.
#[inline(always)]
pub fn box_corners([a, b, c]: [DVec3; 3]) -> [DVec3; 2] {
    let axis = |axis: usize| [a[axis], b[axis], c[axis]];
    let (x, y, z) = (axis(0), axis(1), axis(2));
    [DVec3::new(least(x), least(y), least(z)), DVec3::new(greatest(x), greatest(y), greatest(z))]
}
