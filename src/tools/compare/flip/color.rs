//! The colour spaces of FLIP.

use glam::{DMat3, DVec3};

/// From linear sRGB to CIE XYZ under the illuminant D65, as in the reference implementation.
const TO_XYZ: [[f64; 3]; 3] = [
    [10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0],
    [2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0],
    [1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0],
];

/// Converts from sRGB to YCxCz, where the eye's blur is applied, and then to a space where distances are perceived
/// differences.
#[derive(Clone, Debug)]
pub struct ColorSpace {
    /// The linear value of each byte of sRGB.
    linear: [f64; 256],
    /// From linear sRGB to XYZ, relative to the white of the illuminant.
    to_relative_xyz: DMat3,
    from_relative_xyz: DMat3,
}

impl Default for ColorSpace {
    fn default() -> Self {
        let to_xyz = DMat3::from_cols_array_2d(&TO_XYZ).transpose();
        let white = to_xyz * DVec3::ONE;
        let to_relative_xyz = DMat3::from_diagonal(white.recip()) * to_xyz;
        Self {
            linear: std::array::from_fn(|byte| linear(byte as f64 / 255.0)),
            to_relative_xyz,
            from_relative_xyz: to_relative_xyz.inverse(),
        }
    }
}

impl ColorSpace {
    /// Converts to achromatic, red-green and blue-yellow coordinates, all linear in the light.
    pub fn to_ycxcz(&self, rgb: [u8; 3]) -> DVec3 {
        opponent(self.to_relative_xyz * DVec3::from_array(rgb.map(|byte| self.linear[usize::from(byte)])))
    }

    /// Converts YCxCz to L*a*b*, with the chroma scaled by the lightness (the Hunt effect: colours look more vivid in
    /// bright light). Colours outside sRGB are clamped.
    pub fn to_perceived(&self, ycxcz: DVec3) -> DVec3 {
        let rgb = self.from_relative_xyz * relative_xyz(ycxcz);
        self.linear_to_perceived(rgb.clamp(DVec3::ZERO, DVec3::ONE))
    }

    fn linear_to_perceived(&self, rgb: DVec3) -> DVec3 {
        let xyz = self.to_relative_xyz * rgb;
        let lab = opponent(DVec3::from_array(xyz.to_array().map(compressed)));
        DVec3::new(lab.x, 0.01 * lab.x * lab.y, 0.01 * lab.x * lab.z)
    }

    /// Returns the distance between green and blue, the two most distant colours of sRGB.
    pub fn largest_difference(&self) -> f64 {
        distance(self.linear_to_perceived(DVec3::Y), self.linear_to_perceived(DVec3::Z))
    }
}

/// Returns the HyAB distance: city block between lightness and chroma, Euclidean within chroma.
pub fn distance(a: DVec3, b: DVec3) -> f64 {
    let difference = a - b;
    difference.x.abs() + (difference.y * difference.y + difference.z * difference.z).sqrt()
}

/// Decodes a channel with the transfer function of sRGB.
fn linear(encoded: f64) -> f64 {
    match encoded <= 0.04045 {
        true => encoded / 12.92,
        false => libm::pow((encoded + 0.055) / 1.055, 2.4),
    }
}

/// Converts X, Y and Z to the axes of L*a*b*, or without the compression to YCxCz.
fn opponent(xyz: DVec3) -> DVec3 {
    DVec3::new(116.0 * xyz.y - 16.0, 500.0 * (xyz.x - xyz.y), 200.0 * (xyz.y - xyz.z))
}

/// The inverse of [`opponent`].
fn relative_xyz(axes: DVec3) -> DVec3 {
    let y = (axes.x + 16.0) / 116.0;
    DVec3::new(y + axes.y / 500.0, y, y - axes.z / 200.0)
}

/// Returns the compressed value of L*a*b*: the cube root, with a linear part near black.
fn compressed(value: f64) -> f64 {
    const DELTA: f64 = 6.0 / 29.0;
    match value > DELTA * DELTA * DELTA {
        true => libm::cbrt(value),
        false => value / (3.0 * DELTA * DELTA) + 4.0 / 29.0,
    }
}
