//! The intersections of a line and a sphere: in double-double, as the reference, and by the textbook's
//! quadratic.

use super::double_double::{self as dd, Dd};
use super::exact::{dot, exact, exact3, sub};
use glam::{DVec3, Vec3};
use raytracer::math::ray::Ray;
use raytracer::world::sphere::Sphere;

/// The quadratic a t^2 - 2 b t + c = 0 of the crossings, and its discriminant b^2 - a c.
struct Quadratic {
    a: Dd,
    b: Dd,
    c: Dd,
    discriminant: Dd,
    /// The exact sign of the discriminant. If it is too close to zero for double-double, it is computed in
    /// rationals.
    sign: i32,
}

fn quadratic(sphere: &Sphere, ray: &Ray) -> Quadratic {
    let f = dd::sub(&dd::vector(ray.origin), &dd::vector(sphere.center));
    let d = dd::vector(ray.direction);
    let r: Dd = sphere.radius.into();
    let (a, b, c) = (dd::dot(&d, &d), -dd::dot(&f, &d), dd::dot(&f, &f) - r * r);
    let (bb, ac) = (b * b, a * c);
    let discriminant = bb - ac;
    // The error of twenty operations, each of 2^-100.
    let error_bound = 32.0 * 2f64.powi(-100) * (bb.abs() + a * dd::dot(&f, &f) + a * r * r).value();
    let sign =
        if discriminant.abs().value() > error_bound { discriminant.sign() } else { exact_sign(sphere, ray) };
    Quadratic { a, b, c, discriminant, sign }
}

/// The t of both crossings in ascending order, in double-double. None if the line misses, which is decided
/// exactly.
pub fn roots(sphere: &Sphere, ray: &Ray) -> Option<[Dd; 2]> {
    let Quadratic { a, b, c, discriminant, sign } = quadratic(sphere, ray);
    if sign < 0 {
        return None;
    }
    let root = discriminant.abs().sqrt();
    let q = if b.sign() < 0 { b - root } else { b + root };
    let (t0, t1) = if q.sign() == 0 { (Dd::ZERO, Dd::ZERO) } else { (c / q, q / a) };
    Some(if (t1 - t0).sign() > 0 { [t0, t1] } else { [t1, t0] })
}

/// Whether the line meets the sphere, and the distance of the line from a tangent, relative to the radius.
pub fn tangency(sphere: &Sphere, ray: &Ray) -> (bool, f64) {
    let Quadratic { a, discriminant, sign, .. } = quadratic(sphere, ray);
    let distance = discriminant.value() / (a.value() * sphere.radius * sphere.radius) / 2.0;
    (sign >= 0, distance.abs())
}

/// The sign of the discriminant: 1 if the line crosses, 0 if it touches, -1 if it misses.
fn exact_sign(sphere: &Sphere, ray: &Ray) -> i32 {
    let f = sub(&exact3(ray.origin), &exact3(sphere.center));
    let d = exact3(ray.direction);
    let b = dot(&f, &d);
    let r = exact(sphere.radius);
    let discriminant = &b * &b - dot(&d, &d) * (dot(&f, &f) - &r * &r);
    let zero = exact(0.0);
    (discriminant > zero) as i32 - (discriminant < zero) as i32
}

/// The t of the nearest crossing in front of the origin.
pub fn nearest(sphere: &Sphere, ray: &Ray) -> Option<Dd> {
    roots(sphere, ray)?.into_iter().find(|t| t.sign() >= 0)
}

/// The textbook's quadratic in f32: the smallest root that is not below `t_min`.
pub fn textbook32(sphere: &Sphere, ray: &Ray, t_min: f32) -> Option<f32> {
    let f: Vec3 = ray.origin.as_vec3() - sphere.center.as_vec3();
    let (d, r) = (ray.direction.as_vec3(), sphere.radius as f32);
    let (a, b, c) = (d.dot(d), 2.0 * f.dot(d), f.dot(f) - r * r);
    let discriminant = b * b - 4.0 * a * c;
    let root = (discriminant >= 0.0).then(|| discriminant.sqrt())?;
    [(-b - root) / (2.0 * a), (-b + root) / (2.0 * a)].into_iter().find(|&t| t >= t_min)
}

/// The same in f64.
pub fn textbook64(sphere: &Sphere, ray: &Ray) -> Option<f64> {
    let f: DVec3 = ray.origin - sphere.center;
    let (d, r) = (ray.direction, sphere.radius);
    let (a, b, c) = (d.dot(d), 2.0 * f.dot(d), f.dot(f) - r * r);
    let discriminant = b * b - 4.0 * a * c;
    let root = (discriminant >= 0.0).then(|| discriminant.sqrt())?;
    [(-b - root) / (2.0 * a), (-b + root) / (2.0 * a)].into_iter().find(|&t| t >= 0.0)
}
