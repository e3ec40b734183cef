//! The ray-triangle tests of the textbooks, in f32 and f64, as they are usually written.

use glam::DVec3;
use num_traits::Float;

pub type V<T> = [T; 3];

/// A point in the precision of a textbook method.
#[inline]
pub fn lower<T: Float>(v: DVec3) -> V<T> {
    let float = |x: f64| T::from(x).expect("a float fits into a float");
    [float(v.x), float(v.y), float(v.z)]
}

#[inline]
pub fn lower_triangle<T: Float>([a, b, c]: [DVec3; 3]) -> [V<T>; 3] {
    [lower(a), lower(b), lower(c)]
}

#[inline]
fn sub<T: Float>(a: V<T>, b: V<T>) -> V<T> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline]
fn add<T: Float>(a: V<T>, b: V<T>) -> V<T> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline]
fn dot<T: Float>(a: V<T>, b: V<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
fn cross<T: Float>(a: V<T>, b: V<T>) -> V<T> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Moeller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", JGT 2(1), 1997; with
/// the determinant compared to an epsilon, which is 1e-6 in the paper.
pub fn moller_trumbore<T: Float>(o: V<T>, d: V<T>, [a, b, c]: [V<T>; 3], epsilon: T) -> Option<T> {
    let (e1, e2) = (sub(b, a), sub(c, a));
    let p = cross(d, e2);
    let determinant = dot(e1, p);
    if determinant.abs() <= epsilon {
        return None;
    }
    let s = sub(o, a);
    let u = dot(s, p) / determinant;
    let q = cross(s, e1);
    let v = dot(d, q) / determinant;
    let inside = u >= T::zero() && v >= T::zero() && u + v <= T::one();
    inside.then(|| dot(e2, q) / determinant)
}

/// Baldwin and Weber, "Fast Ray-Triangle Intersections by Coordinate Transformation", JCGT 5(3),
/// 2016: the ray is taken to the space where the triangle is the unit one.
pub fn baldwin_weber<T: Float>(o: V<T>, d: V<T>, [a, b, c]: [V<T>; 3]) -> Option<T> {
    let (e1, e2) = (sub(b, a), sub(c, a));
    let n = cross(e1, e2);
    let axis = if n[0].abs() > n[1].abs() && n[0].abs() > n[2].abs() {
        0
    } else if n[1].abs() > n[2].abs() {
        1
    } else {
        2
    };
    let mut free = [T::zero(); 3];
    free[axis] = T::one();
    // The rows of the inverse of the matrix with the columns e1, e2 and the free axis.
    let rows = [cross(e2, free), cross(free, e1), n].map(|r| r.map(|x| x / n[axis]));
    let shift = rows.map(|r| -dot(r, a));
    let t = -(dot(rows[2], o) + shift[2]) / dot(rows[2], d);
    let p = add(o, d.map(|x| x * t));
    let (x, y) = (dot(rows[0], p) + shift[0], dot(rows[1], p) + shift[1]);
    (x >= T::zero() && y >= T::zero() && x + y <= T::one()).then_some(t)
}

/// Plucker coordinates relative to the ray's origin, with an error margin of one rounding, as in
/// the robust mode of a well-known library.
pub fn plucker<T: Float>(o: V<T>, d: V<T>, triangle: [V<T>; 3]) -> Option<T> {
    let [a, b, c] = triangle.map(|v| sub(v, o));
    let edge = |p: V<T>, q: V<T>| dot(cross(sub(p, q), add(p, q)), d);
    let (u, v, w) = (edge(c, a), edge(a, b), edge(b, c));
    let margin = T::epsilon() * (u + v + w).abs();
    if u.min(v).min(w) < -margin && u.max(v).max(w) > margin {
        return None;
    }
    let n = cross(sub(b, a), sub(c, a));
    let t = dot(a, n) / dot(d, n);
    t.is_finite().then_some(t)
}

/// The variants of the published watertight test.
#[derive(Clone, Copy, PartialEq)]
pub enum Edges {
    /// As published, but without the fallback to double precision: zero counts as inside.
    Inclusive,
    /// With `a * b - c * d` contracted to a fused multiply-add, as some compilers do.
    Contracted,
}

/// Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013.
pub fn woop<T: Float>(o: V<T>, d: V<T>, triangle: [V<T>; 3], edges: Edges) -> Option<T> {
    let z = (0..3).fold(0, |best, i| if d[i].abs() > d[best].abs() { i } else { best });
    let (x, y) = ((z + 1) % 3, (z + 2) % 3);
    let (sx, sy, sz) = (d[x] / d[z], d[y] / d[z], T::one() / d[z]);
    let shear = |v: V<T>| {
        let v = sub(v, o);
        [v[x] - sx * v[z], v[y] - sy * v[z], sz * v[z]]
    };
    let [a, b, c] = [shear(triangle[0]), shear(triangle[1]), shear(triangle[2])];
    let area = |p: V<T>, q: V<T>| match edges {
        Edges::Inclusive => p[0] * q[1] - p[1] * q[0],
        Edges::Contracted => p[0].mul_add(q[1], -(p[1] * q[0])),
    };
    let (u, v, w) = (area(c, b), area(a, c), area(b, a));
    let zero = T::zero();
    let outside = (u < zero || v < zero || w < zero) && (u > zero || v > zero || w > zero);
    let sum = u + v + w;
    if outside || sum == zero {
        return None;
    }
    Some((u * a[2] + v * b[2] + w * c[2]) / sum)
}
