//! Spheres, intersected by a form of the quadratic that stays accurate for distant rays (Haines, Guenther and
//! Akenine-Moeller, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems, ch. 7, 2019).

use super::shape::{Form, UnitSphereMaps};
use crate::math::double_double::{Dd, SquaredSine, difference, dot, minus};
use crate::math::{aabb::Aabb, ray::Ray, robust::UNIT_ROUNDOFF, robust::unit};
use glam::{DMat3, DVec3};

/// The points at the distance `radius` from `center`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// The centre.
    pub center: DVec3,
    /// The radius, which is positive.
    pub radius: f64,
}

/// The error bound of a point's power, in roundings of the sum of both squares (`proofs/sphere_power.g`).
const POWER_ROUNDINGS: f64 = 8.0;

/// The error bound of a point at a radius from a centre, in roundings of both: three for the unit normal, one for the
/// product and one for the sum (`proofs/checkerboard.g`).
const AT_RADIUS_ROUNDINGS: f64 = 6.0;

/// The multiple of the power's error bound by which the line of a ray must be outside the sphere to miss it surely,
/// however b and the direction's squared length are rounded.
const BESIDE: f64 = 3.0;

/// The quadratic a t^2 - 2 b t + c, whose roots are c / q and q / a.
struct Quadratic {
    a: f64,
    b: f64,
    q: f64,
}

impl Sphere {
    /// Returns the power of a point, and a bound on its error in double precision.
    #[inline(always)]
    fn power_and_error_bound(&self, from_center: DVec3) -> (f64, f64) {
        let (distance, square) = (from_center.length_squared(), self.radius * self.radius);
        // The smallest normal number covers the loss in subnormal products.
        (distance - square, POWER_ROUNDINGS * UNIT_ROUNDOFF * (distance + square) + f64::MIN_POSITIVE)
    }

    /// Returns the two t at which a line crosses the sphere, in order.
    ///
    /// The discriminant is computed from the line's distance to the centre, and the second root from the product of the
    /// roots, so that neither suffers from cancellation. Two differences can still cancel: the discriminant if the line
    /// is almost tangent to the sphere, and the origin's power with respect to the sphere if the origin is almost on
    /// it. In these cases they are computed in double-double arithmetic.
    #[inline(always)]
    fn crossings(&self, origin: DVec3, direction: DVec3) -> Option<[f64; 2]> {
        let Quadratic { a, q, .. } = self.quadratic(origin, direction)?;
        let c = self.power(origin, origin - self.center);
        let (t0, t1) = if q == 0.0 { (0.0, 0.0) } else { (c / q, q / a) };
        Some(if t0 < t1 { [t0, t1] } else { [t1, t0] })
    }

    /// Returns the quadratic a t^2 - 2 b t + c of a line, except for c; `None` if it has no roots.
    #[inline(always)]
    fn quadratic(&self, origin: DVec3, direction: DVec3) -> Option<Quadratic> {
        let from_center = origin - self.center;
        let a = direction.length_squared();
        let b = -from_center.dot(direction);
        let nearest = from_center + (b / a) * direction;
        let mut discriminant = self.radius * self.radius - nearest.length_squared();
        if discriminant.abs() <= self.radius * self.discriminant_error_bound(from_center) {
            discriminant = self.precise_discriminant(origin, direction);
        }
        if discriminant < 0.0 || discriminant.is_nan() {
            return None;
        }
        Some(Quadratic { a, b, q: b + f64::copysign((a * discriminant).sqrt(), b) })
    }

    /// Returns the error bound of the discriminant, divided by the radius. A discriminant below it times the radius may
    /// have lost more than half of its digits.
    fn discriminant_error_bound(&self, from_center: DVec3) -> f64 {
        const CLOSE: f64 = 1.0 / (1 << 20) as f64;
        CLOSE * self.radius + 64.0 * UNIT_ROUNDOFF * from_center.abs().max_element()
    }

    /// Returns the squared radius minus the squared distance of the line from the centre, in double-double arithmetic.
    #[cold]
    fn precise_discriminant(&self, origin: DVec3, direction: DVec3) -> f64 {
        let f = difference(origin, self.center);
        let d = direction.to_array().map(Dd::from);
        let r = Dd::from(self.radius);
        let (a, b) = (dot(d, d), dot(f, d));
        (b * b - a * (dot(f, f) - r * r)).value() / a.value()
    }

    /// Returns the power of the origin: its squared distance from the centre minus the squared radius.
    fn power(&self, origin: DVec3, from_center: DVec3) -> f64 {
        const CLOSE: f64 = 1.0 / (1 << 10) as f64;
        let square = self.radius * self.radius;
        let power = from_center.length_squared() - square;
        if power.abs() > CLOSE * square { power } else { self.precise_power(origin) }
    }

    /// Returns the sine of the angle between a line and the normal where it crosses the sphere: the line's distance
    /// from the centre over the radius.
    pub fn sine(&self, origin: DVec3, direction: DVec3) -> SquaredSine {
        let exponent = -libm::frexp(self.radius).1;
        let radius = Dd::from(self.radius).times_exp2(exponent);
        let from_center = difference(origin, self.center).map(|x| x.times_exp2(exponent));
        let of_center = SquaredSine::of(direction, from_center);
        let direction = direction.to_array().map(Dd::from);
        SquaredSine { denominator: dot(direction, direction) * (radius * radius), ..of_center }
    }

    /// Returns the normal and the point where a ray hits the sphere at `t`, computed along the ray and moved onto the
    /// sphere. The point's error is relative to its own coordinates, however far away the centre is.
    #[cold]
    pub fn precise_surface(&self, ray: &Ray, t: f64) -> (DVec3, DVec3) {
        let along = ray.at(t);
        let normal = unit(along - self.center);
        (normal, along - self.precise_power(along) / (2.0 * self.radius) * normal)
    }

    #[cold]
    fn precise_power(&self, origin: DVec3) -> f64 {
        let f = difference(origin, self.center);
        let r = Dd::from(self.radius);
        (dot(f, f) - r * r).value()
    }
}

impl Form for Sphere {
    fn bounds(&self) -> Aabb {
        Aabb { min: self.center - self.radius, max: self.center + self.radius }
    }

    /// Returns the nearest t on the ray: the smaller root, or the larger one if the smaller is not on the ray.
    ///
    /// The origin's power decides most rays that start on the sphere, and those that pass beside it, without
    /// double-double arithmetic or divisions. `proofs/sphere_power.g` proves the error bound.
    fn intersect(&self, ray: &Ray) -> Option<f64> {
        let from_center = ray.origin - self.center;
        let (power, bound) = self.power_and_error_bound(from_center);
        let starts_here = ray.t_min >= 0.0;
        if power > bound {
            let b = -from_center.dot(ray.direction);
            let is_beside = b * b < ray.direction.length_squared() * (power - BESIDE * bound);
            // Both roots have the sign of b.
            if is_beside || starts_here && b <= 0.0 {
                return None;
            }
        }
        if power < -bound && starts_here {
            // One root is negative. The other one does not depend on the power if b is positive.
            let Quadratic { a, b, q } = self.quadratic(ray.origin, ray.direction)?;
            if b > 0.0 {
                return Some(q / a).filter(|&t| ray.covers(t));
            }
        }
        first_on_ray(self.crossings(ray.origin, ray.direction)?, ray)
    }

    /// If the radius is smaller than the rounding error of the centre, the point may be the centre itself. Then the
    /// normal points against the ray.
    #[inline(always)]
    fn surface(&self, ray: &Ray, t: f64) -> (DVec3, DVec3) {
        let outward = ray.at(t) - self.center;
        let normal = unit(if outward == DVec3::ZERO { -ray.direction } else { outward });
        (normal, self.center + self.radius * normal)
    }

    #[inline(always)]
    fn extent(&self) -> f64 {
        self.center.abs().max_element() + self.radius
    }

    fn point_roundings(&self) -> DVec3 {
        AT_RADIUS_ROUNDINGS * (self.center.abs() + self.radius)
    }

    fn roots(&self, ray: &Ray) -> Option<[f64; 2]> {
        self.crossings(ray.origin, ray.direction)
    }

    fn height_and_slope(&self, point: [Dd; 3], direction: [Dd; 3]) -> [Dd; 2] {
        let (from_center, radius) = (minus(point, self.center), Dd::from(self.radius));
        let slope = dot(from_center, direction);
        [dot(from_center, from_center) - radius * radius, slope + slope]
    }

    fn unit_sphere_maps(&self) -> UnitSphereMaps {
        let scale = |factor: f64| DMat3::from_diagonal(DVec3::splat(factor));
        let [linear, inverse] = [self.radius, 1.0 / self.radius].map(scale);
        UnitSphereMaps { center: self.center, linear, inverse }
    }
}

/// Returns the smaller of two ordered roots that lies on the ray.
pub fn first_on_ray(roots: [f64; 2], ray: &Ray) -> Option<f64> {
    roots.into_iter().find(|&t| ray.covers(t))
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_rational::BigRational;
    use num_traits::{Signed, ToPrimitive};

    #[test]
    fn a_tangent_has_a_double_root_and_a_line_that_misses_has_none() {
        let sphere = Sphere { center: DVec3::ZERO, radius: 1.0 };
        let from = |y| sphere.crossings(DVec3::new(0.0, y, -5.0), DVec3::Z);
        assert_eq!(from(1.0), Some([5.0, 5.0]));
        assert_eq!([from(1.0 + f64::EPSILON), from(1.5), from(f64::NAN)], [None; 3]);
        assert_eq!(sphere.crossings(DVec3::new(0.0, 0.0, -5.0), DVec3::ZERO), None);
    }

    fn exact(x: f64) -> BigRational {
        BigRational::from_float(x).unwrap()
    }

    fn float(x: &BigRational) -> f64 {
        x.to_f64().unwrap()
    }

    /// Returns the coefficients of the quadratic in exact arithmetic: the direction's squared length, its dot product
    /// with the vector to the centre, the origin's power, and the discriminant.
    fn quadratic(sphere: &Sphere, origin: DVec3, direction: DVec3) -> [BigRational; 4] {
        let f = [0, 1, 2].map(|i| exact(origin[i]) - exact(sphere.center[i]));
        let d = direction.to_array().map(exact);
        let dot = |a: &[BigRational; 3], b: &[BigRational; 3]| {
            a.iter().zip(b).map(|(a, b)| a * b).fold(exact(0.0), |sum, product| sum + product)
        };
        let (a, b) = (dot(&d, &d), -dot(&f, &d));
        let power = dot(&f, &f) - exact(sphere.radius) * exact(sphere.radius);
        let discriminant = &b * &b - &a * &power;
        [a, b, power, discriminant]
    }

    /// Returns a sphere and a line. The line's origin is `away` radii from the sphere, and its distance from the centre
    /// is `1 - inside` times the radius.
    fn grazing(i: u32, radius: f64, away: f64, inside: f64) -> (Sphere, DVec3, DVec3) {
        let spread = |step: f64| (i as f64 * step).fract() - 0.5;
        let along = DVec3::new(spread(2f64.sqrt()), spread(3f64.sqrt()), 0.75);
        let normal = along.cross(DVec3::new(spread(5f64.sqrt()), 1.0, spread(7f64.sqrt()))).normalize();
        let sphere = Sphere { center: radius * DVec3::new(0.1, 0.7, -0.3), radius };
        let touched = sphere.center + radius * (1.0 - inside) * normal;
        (sphere, touched - away * radius * along.normalize(), along)
    }

    #[test]
    fn whether_a_line_meets_a_sphere_is_decided_exactly() {
        let (mut met, mut missed) = (0, 0);
        for (i, radius) in (1..1200).zip([1e-3, 1.0, 1e8].into_iter().cycle()) {
            let away = [3.0, 1e3, 1e6, 1e11][i as usize % 4];
            let inside = (i as f64 * 2f64.sqrt()).fract() - 0.5;
            let (sphere, origin, along) = grazing(i, radius, away, inside * away * UNIT_ROUNDOFF);
            let [.., discriminant] = quadratic(&sphere, origin, along);
            let meets = !discriminant.is_negative();
            assert_eq!(sphere.crossings(origin, along).is_some(), meets, "{i}");
            if meets { met += 1 } else { missed += 1 }
        }
        assert!(met > 100 && missed > 100, "{met} {missed}");
    }

    #[test]
    fn a_short_chord_keeps_half_of_its_digits() {
        for (i, radius) in (1..400).zip([1e-3, 1.0, 1e3].into_iter().cycle()) {
            let inside = 2f64.powi(-10 - (i as i32 % 30));
            let (sphere, origin, along) = grazing(i, radius, 2.0, inside);
            let [a, _, _, discriminant] = quadratic(&sphere, origin, along);
            let chord = 2.0 * float(&discriminant).sqrt() / float(&a);
            let [near, far] = sphere.crossings(origin, along).unwrap();
            assert!((far - near - chord).abs() < 2f64.powi(-26) * chord, "{i}: {} {chord}", far - near);
        }
    }

    #[test]
    fn both_crossings_are_right_from_however_close_to_the_surface() {
        for (i, radius) in (1..400).zip([1e-3, 1.0, 1e3].into_iter().cycle()) {
            let (sphere, start, along) = grazing(i, radius, 2.0, 0.5);
            let near = sphere.crossings(start, along).unwrap()[0];
            let height = (i as f64 * 3f64.sqrt()).fract() * 10f64.powi(-(i as i32 % 14));
            let origin = start + (near - height * radius) * along;
            let [a, b, power, discriminant] = quadratic(&sphere, origin, along);
            let q = float(&b) + float(&discriminant).sqrt();
            let [found, other] = sphere.crossings(origin, along).unwrap();
            let (near, far) = (float(&power) / q, q / float(&a));
            // The power may lose ten bits to cancellation before it is computed in double-double arithmetic.
            let bits = 2f64.powi(12);
            assert!((found - near).abs() <= bits * UNIT_ROUNDOFF * near.abs(), "{i}: {found} {near}");
            assert!((other - far).abs() <= 16.0 * UNIT_ROUNDOFF * far, "{i}: {other} {far}");
        }
    }

    /// Returns the nearest t on a ray from both roots, without the shortcuts by the origin's power.
    fn by_roots(sphere: &Sphere, ray: &Ray) -> Option<f64> {
        first_on_ray(sphere.crossings(ray.origin, ray.direction)?, ray)
    }

    #[test]
    fn a_start_on_the_surface_is_decided_as_by_both_roots() {
        let (mut hits, mut misses) = (0, 0);
        for (i, radius) in (1..20_000).zip([1e-3, 1.0, 1e3, 1e-160].into_iter().cycle()) {
            let (sphere, start, along) = grazing(i, radius, 2.0, 0.5);
            let Some([near, _]) = sphere.crossings(start, along) else { continue };
            let nudge = f64::from(i % 23) - 11.0;
            let origin = (start + near * along) * (1.0 + nudge * UNIT_ROUNDOFF);
            for direction in [along, -along, along.cross(DVec3::X), along.any_orthonormal_vector()] {
                for t_min in [0.0, f64::NEG_INFINITY] {
                    let ray = Ray { t_min, ..Ray::new(origin, direction) };
                    let expected = by_roots(&sphere, &ray);
                    assert_eq!(sphere.intersect(&ray), expected, "{i} {sphere:?} {ray:?}");
                    if expected.is_some() { hits += 1 } else { misses += 1 }
                }
            }
        }
        assert!(hits > 10_000 && misses > 10_000, "{hits} {misses}");
    }

    #[test]
    fn a_line_beside_the_sphere_is_decided_as_by_both_roots() {
        let mut hits = 0;
        for (i, radius) in (1..20_000).zip([1e-3, 1.0, 1e3].into_iter().cycle()) {
            let away = [1.5, 3.0, 50.0, 1e6][i as usize % 4];
            let inside = ((i as f64 * 2f64.sqrt()).fract() - 0.5) * away * [1.0, 64.0][i as usize / 4 % 2];
            let (sphere, origin, along) = grazing(i, radius, away, inside * UNIT_ROUNDOFF);
            for ray in [Ray::new(origin, along), Ray::new(origin, along.normalize())] {
                assert_eq!(sphere.intersect(&ray), by_roots(&sphere, &ray), "{i} {sphere:?} {ray:?}");
                hits += u32::from(sphere.intersect(&ray).is_some());
            }
        }
        assert!((10_000..30_000).contains(&hits), "{hits}");
    }

    #[test]
    fn the_normal_of_a_sphere_too_small_for_its_place_points_against_the_ray() {
        let sphere = Sphere { center: DVec3::X, radius: 1e-30 };
        let ray = Ray::new(DVec3::new(1.0, 0.0, -5.0), DVec3::Z);
        assert_eq!(sphere.surface(&ray, 5.0), (DVec3::NEG_Z, DVec3::new(1.0, 0.0, -1e-30)));
        let beside = Ray { origin: DVec3::new(1.0, 3.0, -5.0), ..ray };
        assert!((sphere.surface(&beside, 9.0).0 - DVec3::new(0.0, 0.6, 0.8)).length() < 1e-15);
    }
}
