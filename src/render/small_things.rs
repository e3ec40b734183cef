//! Finds the small things in a picture without casting rays: points in pixels at which there may be something that
//! rays through the corners miss.
//!
//! All triangles and shapes are projected onto the pixels. A thing narrower than a pixel or two that fills little of a
//! pixel gets a point there. A probe through this point finds out if the thing is visible, and how much it differs
//! from its surroundings.

use crate::camera::{Camera, Projection};
use crate::world::World;
use glam::Vec2;
use std::ops::Range;

/// The small things of a picture.
pub struct SmallThings<'a> {
    world: &'a World,
    projection: Projection,
    /// The projected vertices of the triangles, in pixels from the lower left corner; NaN if not ahead of the eye.
    vertices: Vec<Vec2>,
}

/// Something small in a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Speck {
    /// The approximate part of the pixel that small things cover.
    pub part: f32,
    /// A point in one of them, in pixels from the pixel's centre.
    pub offset: Vec2,
}

/// The specks of some columns and rows of pixels.
struct Specks<'p> {
    columns: &'p Range<usize>,
    rows: &'p Range<usize>,
    specks: Vec<Speck>,
}

/// Things narrower than this number of pixels are small.
const SMALL: f32 = 1.5;

/// Small things that fill more than this part of a pixel form a surface, which corners and other probes do not miss.
const FULL: f32 = 0.5;

/// The number of points per pixel along a thing, and the largest number in all. No picture has more pixels in a row.
const POINTS: f32 = 4.0;
const MOST_POINTS: f32 = 4e5;

/// The step of points across a thing: the golden ratio spreads them evenly.
const ACROSS: f32 = 0.618_034;

impl<'a> SmallThings<'a> {
    pub fn new(camera: &Camera, world: &'a World) -> Self {
        let projection = camera.projection();
        let vertices = world.vertices.iter().map(|&vertex| projection.place(vertex).as_vec2()).collect();
        Self { world, projection, vertices }
    }

    /// Returns the specks in these pixels, row by row.
    pub fn specks(&self, columns: &Range<usize>, rows: &Range<usize>) -> Vec<Speck> {
        let mut specks = Specks { columns, rows, specks: vec![Speck::default(); columns.len() * rows.len()] };
        let [low, high] = [[columns.start, rows.start], [columns.end, rows.end]]
            .map(|[x, y]| Vec2::new(x as f32, y as f32));
        for (id, triangle) in self.world.triangles.iter().enumerate() {
            let [a, b, c] = triangle.map(|vertex| self.vertices[vertex as usize]);
            // All comparisons with NaN are false.
            let is_inside = a.max(b).max(c).cmpge(low).all() && a.min(b).min(c).cmplt(high).all();
            if !is_inside || !(a + b + c).is_finite() || !self.world.may_be_hit(id as u32) {
                continue;
            }
            // `a` is opposite the shortest side.
            let sides = [[a, b, c], [b, c, a], [c, a, b]];
            let [a, b, c] = sides.into_iter().fold(sides[0], |best, side| {
                let is_shorter = side[1].distance_squared(side[2]) < best[1].distance_squared(best[2]);
                if is_shorter { side } else { best }
            });
            let (length, double_area) = (a.distance(b).max(a.distance(c)), (b - a).perp_dot(c - a).abs());
            if double_area <= SMALL * length {
                let at = |t: f32, u: f32| a.lerp(b.lerp(c, u), t.sqrt());
                specks.add(0.5 * double_area, length, at);
            }
        }
        for shape in &self.world.shapes {
            let corners =
                shape.form().bounds().corners().map(|corner| self.projection.place(corner).as_vec2());
            let (min, max) = corners
                .into_iter()
                .fold((corners[0], corners[0]), |(min, max), corner| (min.min(corner), max.max(corner)));
            let is_inside = max.cmpge(low).all() && min.cmplt(high).all();
            let size = max - min;
            if is_inside && corners.into_iter().all(Vec2::is_finite) && size.min_element() < SMALL {
                // A sphere fills about 0.8 of its box, and contains the inner part of the box.
                let (min, inner) = (min + 0.15 * size, 0.7 * size);
                let at = |t: f32, u: f32| {
                    min + inner * if size.x > size.y { Vec2::new(t, u) } else { Vec2::new(u, t) }
                };
                specks.add(0.8 * size.element_product(), size.max_element(), at);
            }
        }
        specks.specks
    }
}

impl Specks<'_> {
    /// Adds a thing with this area and length. `at` returns its points, for two numbers from 0 to 1.
    fn add(&mut self, area: f32, length: f32, at: impl Fn(f32, f32) -> Vec2) {
        let count = (POINTS * length + 1.0).floor().min(MOST_POINTS);
        for k in 0..count as u32 {
            let k = k as f32;
            let place = at((k + 0.5) / count, 0.02 + 0.96 * (ACROSS * k + 0.5).fract());
            let [x, y] = [place.x as usize, place.y as usize];
            if place.min_element() >= 0.0 && self.columns.contains(&x) && self.rows.contains(&y) {
                let speck =
                    &mut self.specks[(y - self.rows.start) * self.columns.len() + x - self.columns.start];
                speck.part += area / count;
                speck.offset = place.fract() - 0.5;
            }
        }
    }
}

impl Speck {
    /// Returns true if small things cover some of the pixel, but not most of it.
    pub fn is_alone(self) -> bool {
        self.part > 0.0 && self.part < FULL
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parser::parse;

    const ABOVE: &str = "OrthographicCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 size 8 }";
    /// With the same view of the plane z = 0.
    const AHEAD: &str = "PerspectiveCamera { center 0 0 4 direction 0 0 -1 up 0 1 0 angle 90 }";

    /// Returns the specks in eight rows of eight pixels of a scene with these objects.
    fn specks(camera: &str, objects: &[&str]) -> Vec<([usize; 2], Speck)> {
        let text = format!(
            "{camera} Materials {{ numMaterials 1 Material {{ }} }}
             Group {{ numObjects {} MaterialIndex 0 {} }}",
            objects.len(),
            objects.join(" ")
        );
        let scene = parse(&text).unwrap();
        let world = World::new(&scene, &[]).unwrap();
        let camera = Camera::new(&scene.camera, [8, 8]);
        let things = SmallThings::new(&camera, &world);
        let all = things.specks(&(0..8), &(0..8));
        // A part of the picture has the same specks as the whole picture.
        let part = things.specks(&(2..7), &(3..5));
        assert!((0..2).all(|y| part[5 * y..][..5] == all[8 * (y + 3) + 2..][..5]));
        let places = (0..64).map(|k| [k % 8, k / 8]);
        places.zip(all).filter(|(_, speck)| speck.part > 0.0).collect()
    }

    #[test]
    fn small_things_leave_specks_of_what_they_cover() {
        let objects = [
            "Sphere { center 1.5 -1.5 0 radius 0.1 }",
            "Transform { Translate -2.5 2.5 0 Scale 0.2 0.1 0.01 Sphere { center 0 0 0 radius 1 } }",
            "Triangle { vertex0 2.4 2.4 0 vertex1 2.6 2.4 0 vertex2 2.4 2.6 0 }",
        ];
        for camera in [ABOVE, AHEAD] {
            let found = specks(camera, &objects);
            let expected = [([5, 2], 0.0314), ([1, 6], 0.0628), ([6, 6], 0.02)];
            assert_eq!(found.len(), 3, "{camera} {found:?}");
            for ((place, speck), (expected, part)) in found.iter().zip(expected) {
                // In perspective, the box of a solid is larger than the area that the solid covers.
                assert!(
                    *place == expected && (0.9..2.0).contains(&(speck.part / part)),
                    "{camera} {found:?}"
                );
                assert!(speck.offset.abs().max_element() < 0.1, "{camera} {found:?}");
            }
        }
    }

    #[test]
    fn a_needle_has_specks_along_its_middle() {
        for camera in [ABOVE, AHEAD] {
            let needle = "Triangle { vertex0 -3.7 -2.73 0 vertex1 -3.7 -2.69 0 vertex2 3.6 2.2 0 }";
            let found = specks(camera, &[needle]);
            assert!((8..16).contains(&found.len()), "{found:?}");
            let area: f32 = found.iter().map(|(_, speck)| speck.part).sum();
            assert!((area - 0.146).abs() < 0.001, "{area}");
            for ([column, row], speck) in &found {
                let [x, y] = [(*column, speck.offset.x), (*row, speck.offset.y)]
                    .map(|(k, offset)| k as f32 - 3.5 + offset);
                assert!((y + 2.71 - (x + 3.7) * 4.91 / 7.3).abs() < 0.02, "{x} {y}");
            }
        }
    }

    #[test]
    fn large_things_and_those_behind_the_eye_leave_none() {
        let large = "Triangle { vertex0 -3.5 -3.5 0 vertex1 3.5 -3.5 0 vertex2 -3.5 3.5 0 }";
        assert_eq!(specks(ABOVE, &[large, "Sphere { center 0.5 0.5 0 radius 2.2 }"]), []);
        let behind = [
            "Triangle { vertex0 -1 0 9 vertex1 1 0 9 vertex2 0 0.01 9 }",
            "Sphere { center 0 0 9 radius 0.01 }",
        ];
        assert_eq!(specks(AHEAD, &behind), []);
        assert_eq!(
            specks(AHEAD, &["Triangle { vertex0 -100 -1 100 vertex1 100 -1 100 vertex2 0 -1 -4.1 }"]),
            []
        );
    }
}
