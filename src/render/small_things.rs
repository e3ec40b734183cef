//! Small things: estimates the part of each pixel that they cover, without casting rays. They may be hidden.
//!
//! All triangles and shapes are projected onto the pixels. Points along a thing that is narrower than a pixel or two share
//! its area, and each adds its share to its pixel.

use crate::base::patience::{Ended, Patience, Steps};
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

/// The covered parts of the pixels in some columns and rows, row by row.
struct CoveredParts {
    columns: Range<usize>,
    rows: Range<usize>,
    parts: Vec<f32>,
    /// The points since the last thing.
    points: usize,
}

/// Things narrower than this number of pixels are small.
const SMALL: f32 = 1.5;

/// Small things that cover more than this part of a pixel form a surface, which its samples do not miss.
const FULL: f32 = 0.5;

/// Across things narrower than this number of pixels, the middle is the only point. Wider things also get points near
/// both sides.
const THIN: f32 = 0.02;

/// The maximum number of steps along a thing. No picture has more pixels in a row.
const MOST_STEPS: f32 = 1e5;

impl<'a> SmallThings<'a> {
    pub fn new(camera: &Camera, world: &'a World) -> Self {
        let projection = camera.projection();
        let vertices = world.vertices.iter().map(|&vertex| projection.place(vertex).as_vec2()).collect();
        Self { world, projection, vertices }
    }

    /// Returns the part of each of these pixels that small things cover, row by row; `None` if they cover nothing or
    /// most of it. Fails if the patience is over.
    pub fn covered_parts(
        &self,
        columns: &Range<usize>,
        rows: &Range<usize>,
        patience: &dyn Patience,
    ) -> Result<Vec<Option<f32>>, Ended> {
        let mut steps = Steps::new(patience);
        let parts = vec![0.0; columns.len() * rows.len()];
        let mut found = CoveredParts { columns: columns.clone(), rows: rows.clone(), parts, points: 0 };
        let band = [rows.start as f32 - 1.0, rows.end as f32 + 1.0];
        for (id, triangle) in self.world.triangles.iter().enumerate() {
            steps.take(1 + std::mem::take(&mut found.points))?;
            let [a, b, c] = triangle.map(|vertex| self.vertices[vertex as usize]);
            let (min, max) = (a.min(b).min(c), a.max(b).max(c));
            let is_ahead = (a + b + c).is_finite();
            if !is_ahead || max.y < band[0] || min.y > band[1] || !self.world.may_be_seen(id as u32) {
                continue;
            }
            let double_area = (b - a).perp_dot(c - a).abs();
            if (max - min).max_element() < SMALL {
                found.add_box(min, max, 0.5 * double_area);
                continue;
            }
            let sides = [[a, b, c], [b, c, a], [c, a, b]];
            let [a, b, c] = sides.into_iter().fold(sides[0], |longest, side| {
                let is_longer = side[0].distance_squared(side[1]) > longest[0].distance_squared(longest[1]);
                if is_longer { side } else { longest }
            });
            let way = b - a;
            if double_area < SMALL * way.length() {
                let foot = ((c - a).dot(way) / way.length_squared()).clamp(0.01, 0.99);
                let height = c - a.lerp(b, foot);
                // `t` goes along the longest side, and `width` is the width there.
                found.add(0.5 * double_area, way.length(), height.length(), |t, u| {
                    let width = (t / foot).min((1.0 - t) / (1.0 - foot));
                    a + t * way + u * width * height
                });
            }
        }
        for shape in &self.world.shapes {
            steps.take(1 + std::mem::take(&mut found.points))?;
            let corners =
                shape.form().bounds().corners().map(|corner| self.projection.place(corner).as_vec2());
            let [min, max] =
                corners.into_iter().fold([Vec2::INFINITY, Vec2::NEG_INFINITY], |[min, max], at| {
                    // Keep NaN.
                    [Vec2::select(at.cmpge(min), min, at), Vec2::select(at.cmple(max), max, at)]
                });
            let size = max - min;
            if size.min_element() < SMALL && max.y > band[0] && min.y < band[1] {
                found.add_box(min, max, 0.8 * size.element_product());
            }
        }
        Ok(found.parts.into_iter().map(|part| (part > 0.0 && part < FULL).then_some(part)).collect())
    }
}

impl CoveredParts {
    /// Adds a thing with this area that fills a box.
    fn add_box(&mut self, min: Vec2, max: Vec2, area: f32) {
        let size = max - min;
        if size.x > size.y {
            self.add(area, size.x, size.y, |t, u| min + Vec2::new(t, u) * size);
        } else {
            self.add(area, size.y, size.x, |t, u| min + Vec2::new(u, t) * size);
        }
    }

    /// Adds a thing with this area, length and width. `at` returns its points, for a part of the length and a part of
    /// the width.
    fn add(&mut self, area: f32, length: f32, width: f32, at: impl Fn(f32, f32) -> Vec2) {
        let steps = if length < THIN { 0.0 } else { (2.0 * length).ceil().clamp(2.0, MOST_STEPS) };
        let across = if width < THIN { [0.5].as_slice() } else { &[0.5, 0.02, 0.98] };
        let part = area / ((steps + 1.0) * across.len() as f32);
        self.points += (steps as usize + 1) * across.len();
        for k in 0..=steps as u32 {
            let t = if steps > 0.0 { 0.01 + 0.98 * k as f32 / steps } else { 0.5 };
            for &u in across {
                let place = at(t, u);
                let [x, y] = [place.x.floor() as usize, place.y.floor() as usize];
                if place.min_element() >= 0.0 && self.columns.contains(&x) && self.rows.contains(&y) {
                    let index = (y - self.rows.start) * self.columns.len() + x - self.columns.start;
                    self.parts[index] += part;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::patience::Endless;
    use crate::scene::parser::parse;

    const ABOVE: &str = "OrthographicCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 size 8 }";
    /// With the same view of the plane z = 0.
    const AHEAD: &str = "PerspectiveCamera { center 0 0 4 direction 0 0 -1 up 0 1 0 angle 90 }";

    /// Returns the covered parts of eight rows of eight pixels of a scene with these objects, where they are not 0.
    fn covered(camera: &str, objects: &[&str]) -> Vec<([usize; 2], f32)> {
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
        let all = things.covered_parts(&(0..8), &(0..8), &Endless).unwrap();
        // A part of the picture has the same parts as the whole picture.
        let part = things.covered_parts(&(2..7), &(3..5), &Endless).unwrap();
        assert!((0..2).all(|y| part[5 * y..][..5] == all[8 * (y + 3) + 2..][..5]));
        let places = (0..64).map(|k| [k % 8, k / 8]);
        places.zip(all).filter_map(|(place, part)| Some((place, part?))).collect()
    }

    #[test]
    fn small_things_cover_parts_of_pixels() {
        let objects = [
            "Sphere { center 1.5 -1.5 0 radius 0.1 }",
            "Transform { Translate -2.5 2.5 0 Scale 0.2 0.1 0.01 Sphere { center 0 0 0 radius 1 } }",
            "Triangle { vertex0 2.4 2.4 0 vertex1 2.6 2.4 0 vertex2 2.4 2.6 0 }",
        ];
        for camera in [ABOVE, AHEAD] {
            let found = covered(camera, &objects);
            let expected = [([5, 2], 0.0314), ([1, 6], 0.0628), ([6, 6], 0.02)];
            assert_eq!(found.len(), 3, "{camera} {found:?}");
            for ((place, part), (expected, area)) in found.iter().zip(expected) {
                // In perspective, the box of a solid is larger than the area that the solid covers.
                assert!(*place == expected && (0.9..2.0).contains(&(part / area)), "{camera} {found:?}");
            }
        }
    }

    #[test]
    fn a_needle_covers_parts_of_pixels_along_it() {
        for camera in [ABOVE, AHEAD] {
            let needle = "Triangle { vertex0 -3.7 -2.73 0 vertex1 -3.7 -2.69 0 vertex2 3.6 2.2 0 }";
            let found = covered(camera, &[needle]);
            assert!((8..16).contains(&found.len()), "{found:?}");
            let area: f32 = found.iter().map(|(_, part)| part).sum();
            assert!((area - 0.146).abs() < 0.001, "{area}");
            for ([column, row], _) in &found {
                let [x, y] = [*column, *row].map(|k| k as f32 - 3.5);
                // The needle passes within half a pixel of the centre along both axes.
                assert!((y + 2.71 - (x + 3.7) * 4.91 / 7.3).abs() < 0.9, "{x} {y}");
            }
        }
    }

    #[test]
    fn large_things_and_those_behind_the_eye_leave_none() {
        let large = "Triangle { vertex0 -3.5 -3.5 0 vertex1 3.5 -3.5 0 vertex2 -3.5 3.5 0 }";
        assert_eq!(covered(ABOVE, &[large, "Sphere { center 0.5 0.5 0 radius 2.2 }"]), []);
        let behind = [
            "Triangle { vertex0 -1 0 9 vertex1 1 0 9 vertex2 0 0.01 9 }",
            "Sphere { center 0 0 9 radius 0.01 }",
        ];
        assert_eq!(covered(AHEAD, &behind), []);
        assert_eq!(
            covered(AHEAD, &["Triangle { vertex0 -100 -1 100 vertex1 100 -1 100 vertex2 0 -1 -4.1 }"]),
            []
        );
    }
}
