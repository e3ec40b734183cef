//! Blinn-Phong reflection, and the material that a point of a surface has once textures are mixed.

use super::light::Incident;
use crate::scene::{Color, material::Phong};
use glam::DVec3;

/// A material evaluated at one point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointMaterial {
    pub diffuse: Color,
    pub reflective: Color,
    pub transparent: Color,
    pub index_of_refraction: f64,
    highlight: Highlight,
    /// The highlights of the other materials mixed in by a texture; exponents do not mix.
    further: Vec<Highlight>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Highlight {
    color: Color,
    exponent: f64,
}

impl From<&Phong> for PointMaterial {
    fn from(p: &Phong) -> Self {
        Self {
            diffuse: p.diffuse,
            reflective: p.reflective,
            transparent: p.transparent,
            index_of_refraction: p.index_of_refraction,
            highlight: Highlight { color: p.specular, exponent: p.exponent },
            further: Vec::new(),
        }
    }
}

impl PointMaterial {
    /// A part of a mixture; the weights of all its parts sum to one.
    pub fn weighted(mut self, weight: f64) -> Self {
        self.diffuse *= weight;
        self.reflective *= weight;
        self.transparent *= weight;
        self.index_of_refraction *= weight;
        self.highlight.color *= weight;
        self
    }

    /// The sum of two weighted materials.
    pub fn plus(mut self, other: Self) -> Self {
        self.diffuse += other.diffuse;
        self.reflective += other.reflective;
        self.transparent += other.transparent;
        self.index_of_refraction += other.index_of_refraction;
        self.further.push(other.highlight);
        self
    }

    /// The light sent to the viewer: Lambert's and Blinn's terms. `to_viewer` and `normal` are unit
    /// vectors, and the light stands above the surface; the highlight is not multiplied by its
    /// cosine, as in the course.
    pub fn reflect(&self, light: &Incident, cosine: f64, normal: DVec3, to_viewer: DVec3) -> Color {
        let half = (light.direction + to_viewer).normalize_or_zero();
        let alignment = normal.dot(half).max(0.0);
        let highlights = std::iter::once(&self.highlight).chain(&self.further);
        let specular: Color = highlights.map(|h| h.strength(alignment)).sum();
        light.color * (self.diffuse * cosine + specular)
    }

    /// Whether light from any direction could show.
    pub fn is_black(&self) -> bool {
        let no_highlight =
            std::iter::once(&self.highlight).chain(&self.further).all(|h| h.color == Color::ZERO);
        self.diffuse == Color::ZERO && no_highlight
    }
}

impl Highlight {
    fn strength(&self, alignment: f64) -> Color {
        if self.color == Color::ZERO { Color::ZERO } else { self.color * power(alignment, self.exponent) }
    }
}

/// `base` to the `exponent`: by squaring for the usual whole exponents, which is faster than the
/// general power and the same on every machine.
fn power(base: f64, exponent: f64) -> f64 {
    const LARGEST: f64 = 65536.0;
    if exponent.fract() != 0.0 || !(0.0..=LARGEST).contains(&exponent) {
        return libm::pow(base, exponent);
    }
    let (mut square, mut left, mut product) = (base, exponent as u32, 1.0);
    while left > 0 {
        if left & 1 == 1 {
            product *= square;
        }
        square *= square;
        left >>= 1;
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_powers_agree_with_the_general_power() {
        for exponent in [0.0, 1.0, 2.0, 10.0, 100.0, 65536.0, 2.5, 1e6] {
            for base in [0.0, 0.3, 0.9999, 1.0] {
                let (ours, general) = (power(base, exponent), libm::pow(base, exponent));
                assert!((ours - general).abs() <= 1e-11 * general, "{base}^{exponent}: {ours} {general}");
            }
        }
    }

    #[test]
    fn a_highlight_is_not_scaled_by_the_cosine() {
        let phong = Phong { diffuse: Color::ZERO, specular: Color::ONE, exponent: 1.0, ..Phong::default() };
        let light = Incident { direction: DVec3::X, distance: 1.0, color: Color::ONE };
        let color = PointMaterial::from(&phong).reflect(&light, 1e-9, DVec3::Y, DVec3::Y);
        assert!((color.x - 0.5f64.sqrt()).abs() < 1e-15);
    }
}
