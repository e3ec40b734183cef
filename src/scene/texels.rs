//! The pictures of a scene: textures and the faces of a cube map.
//!
//! Lookups use single precision and the operations of the course's code. Many colours are exact bytes, so the rounding
//! decides whether truncation preserves them.

use crate::diagnostic::Position;
use crate::picture::Color;
use glam::{DVec3, Vec3};
use std::path::PathBuf;
use std::sync::Arc;

/// A picture that a scene names.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImageFile {
    /// The name as written. For a cube map, the folder followed by the file of the face.
    pub name: String,
    /// The position of its first mention in the scene.
    pub at: Position,
    /// Empty until the file is read.
    pub texels: Arc<Texels>,
    /// The path of the file, once found.
    pub file: Option<PathBuf>,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Texels {
    pub size: [usize; 2],
    /// Red, green and blue of each pixel, row by row from the top.
    pub rgb: Vec<u8>,
    /// True if colours are interpolated as bytes and then divided by 255; false if they are divided first.
    pub divides_last: bool,
}

impl Texels {
    /// Returns the colour at coordinates from 0 to 1, to the right and up. As in the course's code, it interpolates
    /// between the texel that contains the point and the next ones, without a shift by half a texel.
    pub fn color(&self, [s, t]: [f32; 2]) -> Color {
        let [width, height] = self.size;
        let ([i, next_i], a) = neighbours(s * width as f32, width);
        let ([j, next_j], b) = neighbours((1.0 - t) * height as f32, height);
        let color = self.texel(i, j) * ((1.0 - a) * (1.0 - b))
            + self.texel(next_i, j) * (a * (1.0 - b))
            + self.texel(i, next_j) * ((1.0 - a) * b)
            + self.texel(next_i, next_j) * (a * b);
        (if self.divides_last { color / 255.0 } else { color }).as_dvec3()
    }

    /// Returns the texel in this column and row, for interpolation.
    fn texel(&self, i: usize, j: usize) -> Vec3 {
        let Some([red, green, blue, ..]) = self.rgb.get(3 * (j * self.size[0] + i)..) else {
            return Vec3::ZERO;
        };
        let texel = Vec3::new((*red).into(), (*green).into(), (*blue).into());
        if self.divides_last { texel } else { texel / 255.0 }
    }
}

/// Returns the two texels around a coordinate, of `count` along an axis, and the distance from the first.
fn neighbours(at: f32, count: usize) -> ([usize; 2], f32) {
    // Beyond single precision the difference below would not be a number.
    let at = at.clamp(f32::MIN, f32::MAX);
    let (last, first) = (count.saturating_sub(1), at.trunc());
    // The conversion maps negative numbers and NaN to 0.
    ([first, first + 1.0].map(|place| (place as usize).min(last)), at - first)
}

/// The faces of a cube map, in the order of [`FACES`].
pub type CubeFaces = [usize; 6];
pub const FACES: [&str; 6] = ["right", "left", "up", "down", "front", "back"];

/// Returns the face of a cube that a direction meets, and the coordinates there. If coordinates are equal, x comes
/// before y and y before z.
pub fn face(direction: DVec3) -> (usize, [f32; 2]) {
    let direction = direction.as_vec3();
    let Vec3 { x, y, z } = direction;
    let size = direction.abs();
    let half = |ratio: f32| (ratio + 1.0) / 2.0;
    if size.x >= size.y && size.x >= size.z {
        let (s, t) = (half(z / x), half(y / x));
        if x > 0.0 { (0, [s, t]) } else { (1, [s, 1.0 - t]) }
    } else if size.y >= size.z {
        let (s, t) = (half(x / y), half(z / y));
        if y > 0.0 { (2, [s, t]) } else { (3, [1.0 - s, 1.0 - t]) }
    } else {
        let (s, t) = (half(x / z), half(y / z));
        if z > 0.0 { (4, [1.0 - s, t]) } else { (5, [s, 1.0 - t]) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns two rows of two texels.
    fn texels() -> Texels {
        let rgb = vec![255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255];
        Texels { size: [2, 2], rgb, divides_last: false }
    }

    #[test]
    fn texels_are_at_their_upper_left_corners() {
        let color = |s, t| texels().color([s, t]).to_array();
        assert_eq!(color(0.0, 1.0), [1.0, 0.0, 0.0]);
        assert_eq!(color(0.5, 1.0), [0.0, 1.0, 0.0]);
        assert_eq!(color(0.0, 0.5), [0.0, 0.0, 1.0]);
        assert_eq!(color(0.25, 1.0), [0.5, 0.5, 0.0]);
        assert_eq!(color(0.25, 0.75), [0.5, 0.5, 0.5]);
        // Beyond the last texel, the colour continues.
        assert_eq!(color(1.0, 0.0), [1.0, 1.0, 1.0]);
        assert_eq!(color(9.0, 1.0), [0.0, 1.0, 0.0]);
        assert_eq!(color(f32::INFINITY, f32::INFINITY), [0.0, 1.0, 0.0]);
        assert_eq!(color(f32::NAN, 0.5).map(f64::is_nan), [true; 3]);
        assert_eq!(Texels { divides_last: true, ..texels() }.color([0.25, 1.0]).to_array(), [0.5, 0.5, 0.0]);
        assert_eq!(Texels::default().color([0.5, 0.5]), Color::ZERO);
    }

    #[test]
    fn each_direction_meets_a_face() {
        for (direction, name, place) in [
            (DVec3::new(2.0, 1.0, 0.0), "right", [0.5, 0.75]),
            (DVec3::new(-2.0, 1.0, 0.0), "left", [0.5, 0.75]),
            (DVec3::new(1.0, 2.0, 1.0), "up", [0.75, 0.75]),
            (DVec3::new(1.0, -2.0, 1.0), "down", [0.75, 0.75]),
            (DVec3::new(1.0, 1.0, 2.0), "front", [0.25, 0.75]),
            (DVec3::new(1.0, 1.0, -2.0), "back", [0.25, 0.75]),
            (DVec3::ONE, "right", [1.0, 1.0]),
        ] {
            let (index, found) = face(direction);
            assert_eq!((FACES[index], found), (name, place), "{direction}");
        }
    }
}
