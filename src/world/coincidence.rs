//! Surfaces in one place: decides which of them a ray sees.
//!
//! Each pair of surfaces is either united or not. The surfaces decide this, not each ray. Of united surfaces, a ray sees
//! the one that comes first in the scene ([`World::comes_first`]); of others, it sees the nearer one. The t of two hits
//! close to each other differ by roundings, so they are computed in double-double arithmetic.

use super::point_error::weights;
use super::{Primitive, World};
use crate::base::patience::{Ended, Steps};
use crate::math::double_double::{Dd, dot, minus};
use crate::math::exact::{Scaled, area_vector, volume};
use crate::math::ray::Ray;
use crate::math::robust::UNIT_ROUNDOFF;
use crate::world::plane::Plane;
use crate::world::shape::{Shape, UnitSphereMaps};
use crate::world::sphere::Sphere;
use glam::{DMat3, DVec3};

/// The largest error of the numbers in a scene against what the author meant, in roundings. Numbers that a program
/// computed have more than the one rounding of a decimal number. Surfaces are united if such errors and the flattening
/// errors may have moved them apart.
pub(super) const WRITTEN_ROUNDINGS: f64 = 4.0;

/// Other hits in the same place are looked for behind the nearest hit. The search distance is the sum of these parts of
/// its t, of the largest coordinate of the finite primitives, and of the largest flattening error.
///
/// The t of two hits in the same place differ by the distance of the surfaces over the cosine between the ray and their
/// normal. The search distance is enough for cosines down to a millionth.
const PER_T: f64 = 1.0 / (1 << 20) as f64;
const PER_COORDINATE: f64 = 1.0 / (1 << 30) as f64;
const PER_FLATTENING_ERROR: f64 = (1 << 20) as f64;

/// Two t are the same if they differ by less than this part of the coordinates along the path over the coordinates of
/// the direction. It has room for the errors in `proofs/coincidence.g` at all but grazing angles.
const SAME_T: f64 = 1.0 / (1u128 << 92) as f64;

/// The number of hits behind each one with which it is compared. More than that are united through those between.
const NEIGHBOURS: usize = 64;

impl World {
    /// Returns the largest difference between the t of a hit and the t of hits on coincident surfaces.
    #[inline(always)]
    pub fn coincidence_reach(&self, t: f64) -> f64 {
        PER_T * t.abs() + self.coincidence_margin
    }

    /// Returns the coefficients of [`World::coincidence_reach`] as a polynomial in |t|.
    pub fn coincidence_reach_by_t(&self) -> [f64; 2] {
        [self.coincidence_margin, PER_T]
    }

    /// Returns the part of [`World::coincidence_reach`] that does not depend on t.
    pub(super) fn find_coincidence_margin(&self) -> f64 {
        PER_COORDINATE * self.max_abs_coord + PER_FLATTENING_ERROR * self.largest_flattening_error()
    }

    /// Returns the primitive that a ray sees, with its t, if the ray hits several close to each other, at these t.
    /// Among the primitives that are united with the nearest one, directly or through others, it is the one that comes
    /// first. `None` if the work should end.
    #[cold]
    pub fn foremost(&self, ray: &Ray, mut hits: Vec<(f64, u32)>, steps: &mut Steps) -> Option<(f64, u32)> {
        steps.take(hits.len()).ok()?;
        hits.sort_unstable_by_key(|&(_, id)| id);
        hits.dedup();
        let places = self.places(&hits, steps).ok()?;
        let first = (0..hits.len()).min_by(|&i, &j| hits[i].0.total_cmp(&hits[j].0))?;
        // If all are united, it does not matter which is the nearest.
        let are_united = places.iter().all(|place| *place == places[0]);
        let seen = if are_united { first } else { self.nearest(ray, &hits, hits[first].0) };
        let united = hits.iter().zip(&places).filter(|(_, place)| **place == places[seen]);
        let united = united.map(|(hit, _)| *hit);
        united.reduce(|one, other| if self.comes_first(other.1, one.1) { other } else { one })
    }

    /// Returns for each hit a number of its place, which it shares with all hits whose surfaces are united with its own,
    /// directly or through others. Only hits whose t are neighbours are compared.
    fn places(&self, hits: &[(f64, u32)], steps: &mut Steps) -> Result<Vec<usize>, Ended> {
        let mut by_t: Vec<usize> = (0..hits.len()).collect();
        by_t.sort_by(|&i, &j| hits[i].0.total_cmp(&hits[j].0));
        let mut places = DisjointSets::new(hits.len());
        for (k, &i) in by_t.iter().enumerate() {
            let neighbours = &by_t[k + 1..hits.len().min(k + 1 + NEIGHBOURS)];
            steps.take(1 + neighbours.len())?;
            for &j in neighbours {
                if places.of(i) != places.of(j) && self.coincide(hits[i].1, hits[j].1) {
                    places.unite(i, j);
                }
            }
        }
        Ok((0..hits.len()).map(|i| places.of(i)).collect())
    }

    /// Returns the index of the nearest hit. `first` is the smallest t, as rounded.
    fn nearest(&self, ray: &Ray, hits: &[(f64, u32)], first: f64) -> usize {
        let behind: Vec<Dd> = hits.iter().map(|&hit| self.behind(ray, hit, first)).collect();
        // A ray hits several triangles at the same t where they meet, and round surfaces where they cross others. Planes
        // are told apart however close they are.
        let way = (ray.origin.abs() + first.abs() * ray.direction.abs()).max_element();
        let same = SAME_T * way / ray.direction.abs().max_element();
        let is_nearer = |i: usize, j: usize| {
            let (one, other, apart) = (hits[i].1, hits[j].1, (behind[i] - behind[j]).value());
            let are_triangles = self.is_triangle(one) && self.is_triangle(other);
            let is_round = self.is_shape(one) || self.is_shape(other);
            let is_same = apart.abs() <= if are_triangles || is_round { same } else { 0.0 };
            if is_same { self.comes_first(one, other) } else { apart < 0.0 }
        };
        (0..hits.len()).reduce(|i, j| if is_nearer(j, i) { j } else { i }).unwrap_or(0)
    }

    /// Returns the difference between the t of a hit and `first`, in double-double arithmetic. It takes one step of
    /// Newton's method from the rounded t. For a flat surface any starting t works, so it starts from `first`; this
    /// tells parallel planes apart however close they are. `proofs/coincidence.g` bounds the error.
    fn behind(&self, ray: &Ray, (t, id): (f64, u32), first: f64) -> Dd {
        let t = if let Primitive::Shape(_) = self.primitive(id) { t } else { first };
        let direction = ray.direction.to_array().map(Dd::from);
        let origin = ray.origin.to_array();
        let point = [0, 1, 2].map(|k| Dd::from(t) * direction[k] + origin[k].into());
        // A function of the point that is zero on the surface, and its slope along the ray.
        let [height, slope] = match self.primitive(id) {
            Primitive::Triangle(i) => {
                let normal = self.precise_normal(i);
                [dot(normal, minus(point, self.corners(i)[0])), dot(normal, direction)]
            }
            Primitive::Plane(i) => {
                let Plane { normal, offset } = self.planes[i];
                let normal = normal.to_array().map(Dd::from);
                [dot(normal, point) - offset.into(), dot(normal, direction)]
            }
            Primitive::Shape(i) => self.shapes[i].form().height_and_slope(point, direction),
        };
        let (behind, step) = (Dd::difference(t, first), height / slope);
        if step.value().is_finite() { behind - step } else { behind }
    }

    /// Returns true if the surfaces of two primitives that a ray hits in the same place are united: they are the same
    /// plane, or the same sphere or ellipsoid, within the errors of their numbers.
    #[cold]
    pub fn coincide(&self, one: u32, other: u32) -> bool {
        use Primitive::{Plane, Shape, Triangle};
        // Ordered by id, so that rounding does not depend on the order of the arguments.
        let (one, other) = (one.min(other), one.max(other));
        match (self.primitive(one), self.primitive(other)) {
            (Triangle(i), Triangle(j)) => self.triangles_coincide([i, j]),
            (Triangle(i), Plane(k)) => self.lies_in_plane(i, k),
            (Plane(i), Plane(j)) => {
                let (one, other) = (self.planes[i], self.planes[j]);
                one == other || one == other.reversed()
            }
            (Shape(i), Shape(j)) => self.shapes_coincide([&self.shapes[i], &self.shapes[j]], [one, other]),
            _ => false,
        }
    }

    /// Returns true if the vertices of the smaller of two triangles lie in the plane of the larger one.
    fn triangles_coincide(&self, [i, j]: [usize; 2]) -> bool {
        let double_area = |i: usize| {
            let [a, b, c] = self.corners(i);
            (b - a).cross(c - a).length_squared()
        };
        let [larger, smaller] = if double_area(i) >= double_area(j) { [i, j] } else { [j, i] };
        let (base, corners) = (self.corners(larger), self.corners(smaller));
        let normal = area_vector(base);
        let largest = Scaled::largest(normal);
        let errors = base.map(|corner| self.corner_error(larger, corner));
        let direction = DVec3::from_array(normal.map(|coordinate| coordinate.over(largest)));
        corners.into_iter().all(|corner| {
            // The height above the plane times the length of `direction`.
            let height = volume(corner, base).over(largest).abs();
            // A corner of the larger triangle moves the plane at this point in proportion to its weight.
            let [u, v, w] = weights(corner, base);
            let of_plane = u * errors[0] + v * errors[1] + w * errors[2];
            // If all corners have the same coordinate, they move together.
            let is_shared = base[0].cmpeq(base[1]) & base[1].cmpeq(base[2]);
            let of_plane = DVec3::select(is_shared, errors[0].max(errors[1]).max(errors[2]), of_plane);
            height <= direction.abs().dot(self.corner_error(smaller, corner) + of_plane)
        })
    }

    /// Returns the largest distance along each axis at which a triangle's corner still counts as lying in a plane.
    fn corner_error(&self, triangle: usize, corner: DVec3) -> DVec3 {
        self.flattening_error(triangle as u32, corner) + WRITTEN_ROUNDINGS * UNIT_ROUNDOFF * corner.abs()
    }

    /// Returns true if a triangle's corners lie in a plane.
    fn lies_in_plane(&self, triangle: usize, plane: usize) -> bool {
        let error = self.plane_error(plane);
        let plane = &self.planes[plane];
        self.corners(triangle).into_iter().all(|corner| {
            let of_corner = plane.normal.abs().dot(self.corner_error(triangle, corner));
            plane.ahead_of(corner).abs() <= of_corner + error.at(corner)
        })
    }

    /// Returns true if two shapes have the same surface: each is the unit sphere in the space of the other.
    fn shapes_coincide(&self, shapes: [&Shape; 2], ids: [u32; 2]) -> bool {
        let moved = ids.map(|id| self.flattening_error(id, DVec3::ZERO));
        if let [Shape::Sphere(one), Shape::Sphere(other)] = shapes {
            return spheres_coincide([one, other], moved[0] + moved[1]);
        }
        let [maps, other_maps] = shapes.map(|shape| shape.form().unit_sphere_maps());
        let error = |UnitSphereMaps { center, linear, .. }, moved: DVec3| {
            let size = linear.x_axis.length() + linear.y_axis.length() + linear.z_axis.length();
            let rounding = 16.0 * WRITTEN_ROUNDINGS * UNIT_ROUNDOFF * (center.abs().max_element() + size);
            moved.max_element() + rounding
        };
        let errors = error(maps, moved[0]) + error(other_maps, moved[1]);
        let relative = 8.0 * errors * largest_number(maps.inverse);
        let map = maps.inverse * other_maps.linear;
        let moved = maps.inverse * (other_maps.center - maps.center);
        let deviation = map * map.transpose() - DMat3::IDENTITY;
        largest_number(deviation) <= relative && moved.abs().max_element() <= relative
    }
}

/// Sets of indices, each known by one of them (Tarjan 1975, with path halving).
struct DisjointSets(Vec<usize>);

impl DisjointSets {
    /// Returns this number of sets of one index each.
    fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    /// Returns the index by which the set of `i` is known.
    fn of(&mut self, mut i: usize) -> usize {
        while self.0[i] != i {
            self.0[i] = self.0[self.0[i]];
            i = self.0[i];
        }
        i
    }

    fn unite(&mut self, i: usize, j: usize) {
        let (i, j) = (self.of(i), self.of(j));
        self.0[i] = j;
    }
}

/// Returns true if two spheres agree within their errors, both in their centres and in their radii. Their points have
/// `moved` that far.
fn spheres_coincide([one, other]: [&Sphere; 2], moved: DVec3) -> bool {
    let rounding = 2.0 * WRITTEN_ROUNDINGS * UNIT_ROUNDOFF;
    let of_center = moved + rounding * one.center.abs().max(other.center.abs());
    // Both the centre and the points at the radius have moved.
    let of_radius = 2.0 * moved.max_element() + rounding * one.radius.max(other.radius);
    (one.center - other.center).abs().cmple(of_center).all() && (one.radius - other.radius).abs() <= of_radius
}

fn largest_number(m: DMat3) -> f64 {
    m.to_cols_array().into_iter().fold(0.0, |largest, x| f64::max(largest, x.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::patience::tests::Counted;
    use crate::world::test_worlds::world_of;

    fn coincide(one: &str, other: &str) -> bool {
        let world = world_of(&[one, other]);
        assert_eq!(world.coincide(0, 1), world.coincide(1, 0));
        world.coincide(0, 1)
    }

    #[test]
    fn surfaces_farther_apart_than_roundings_do_not_coincide() {
        const LOW: &str = "Triangle { vertex0 0 0 0.1 vertex1 1 0 0.1 vertex2 0 1 0.1 }";
        let above = format!("Triangle {{ vertex0 7 0 {0} vertex1 9 0 {0} vertex2 7 1 {0} }}", 0.1 + 1e-12);
        let under = |list: &str, object: &str| format!("Transform {{ {list} {object} }}");
        let sphere = |list: &str| under(list, "Sphere { center 0 0 0 radius 1 }");
        let plane = |turn: &str, offset: f64| {
            under(&format!("XRotate 33 {turn}"), &format!("Plane {{ normal 0 0 1 offset {offset} }}"))
        };
        for (one, other) in [
            (LOW.into(), above),
            (LOW.into(), LOW.replace("0 1 0.1", "0 1 0.10000001")),
            (LOW.into(), "Plane { normal 0 0 1 offset 0.10000000000001 }".into()),
            (LOW.into(), "Plane { normal 0 1e-6 1 offset 0.1 }".into()),
            // A large error along the plane does not move the plane.
            (LOW.into(), under("Scale 4e20 0.2 0.2", "Plane { normal 0 0 1 offset 1 }")),
            (LOW.into(), sphere("")),
            (plane("", 0.1), plane("ZRotate 71", 0.1 + 1e-13)),
            (sphere("UniformScale 1.0000000000001"), sphere("YRotate 10")),
            (sphere("Translate 1e-6 0 0"), sphere("YRotate 10")),
            (sphere("Scale 1 2 0.5"), sphere("Scale 2 1 0.5 ZRotate 90")),
            (sphere("Scale 1 2 0.5"), sphere("Scale 1 2 0.5000000001")),
        ] {
            assert!(!coincide(&one, &other), "{one} and {other}");
        }
    }

    #[test]
    fn the_steps_of_uniting_grow_with_the_hits() {
        let questions = |count: usize| {
            let spheres: Vec<String> = (0..count)
                .map(|i| format!("Sphere {{ center 0 0 0 radius {} }}", 1.0 - 4e-16 * i as f64))
                .collect();
            let world = world_of(&spheres);
            let ray = Ray::new(DVec3::new(0.1, 0.2, 5.0), -DVec3::Z);
            let hits = world.ids().map(|id| (world.crossing(&ray, id).unwrap(), id)).collect();
            let patience = Counted::up_to(usize::MAX);
            let (_, seen) = world.foremost(&ray, hits, &mut Steps::new(&patience)).unwrap();
            assert_eq!(seen, 0);
            patience.asked()
        };
        let [few, many] = [1000, 4000].map(questions);
        assert!(many <= 5 * few, "{few} {many}");
    }

    /// The roundings of a far corner matter little near the others, with a transform and without one.
    #[test]
    fn a_far_corner_makes_nothing_coincide_near_the_others() {
        let near = "Triangle { vertex0 -0.25 -0.25 0.5 vertex1 0.25 -0.25 0.5 vertex2 0 0.25 0.5 }";
        for far in ["1e9", "1e16", "1e30", "1e90"] {
            let triangle =
                format!("Triangle {{ vertex0 -0.5 1.2 0 vertex1 0.5 1.2 0 vertex2 0.3 -{far} -{far} }}");
            for transform in ["", "XRotate 20 ZRotate 30", "Scale 1 2 0.3 YRotate 7"] {
                let under = |object: &str| match transform {
                    "" => object.to_string(),
                    _ => format!("Transform {{ {transform} {object} }}"),
                };
                assert!(!coincide(&under(near), &under(&triangle)), "{far} {transform}");
                assert!(
                    !coincide(&under(&triangle), "Plane { normal 0 1 -1 offset 1.3 }"),
                    "{far} {transform}"
                );
                assert!(coincide(&under(&triangle), &under(&triangle)));
            }
        }
    }
}
