//! Blinn-Phong reflection, and the material at a point of a surface after its textures are evaluated.

use super::light::{Incident, unit_or_zero};
use crate::scene::{Color, material::Phong};
use glam::DVec3;

/// A material evaluated at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointMaterial<'m> {
    /// The material: the scene's own, unless a texture mixes several.
    pub phong: &'m Phong,
    /// The highlights of the other materials in a mixture. They stay separate, because exponents cannot be
    /// mixed.
    further: &'m [Highlight],
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Highlight {
    color: Color,
    exponent: f64,
}

/// A mixture of several materials. It is kept from one point to the next, so that neither memory is allocated nor the
/// mixture moved.
#[derive(Debug, Default)]
pub struct Mixture {
    sum: Phong,
    further: Vec<Highlight>,
}

impl Mixture {
    /// Replaces what it was by a part of a new mixture. The weights of all parts must add up to one.
    #[inline(always)]
    pub fn start(&mut self, phong: &Phong, weight: f64) {
        self.sum = Phong {
            diffuse: phong.diffuse * weight,
            specular: phong.specular * weight,
            exponent: phong.exponent,
            reflective: phong.reflective * weight,
            transparent: phong.transparent * weight,
            index_of_refraction: phong.index_of_refraction * weight,
        };
        self.further.clear();
    }

    /// Adds another part.
    #[inline(always)]
    pub fn add(&mut self, phong: &Phong, weight: f64) {
        self.sum.diffuse += phong.diffuse * weight;
        self.sum.reflective += phong.reflective * weight;
        self.sum.transparent += phong.transparent * weight;
        self.sum.index_of_refraction += phong.index_of_refraction * weight;
        let color = phong.specular * weight;
        if color != Color::ZERO {
            self.further.push(Highlight { color, exponent: phong.exponent });
        }
    }

    /// The material that the parts make together.
    #[inline(always)]
    pub fn material(&self) -> PointMaterial<'_> {
        PointMaterial { phong: &self.sum, further: &self.further }
    }
}

impl<'m> From<&'m Phong> for PointMaterial<'m> {
    #[inline(always)]
    fn from(phong: &'m Phong) -> Self {
        Self { phong, further: &[] }
    }
}

impl PointMaterial<'_> {
    /// The light reflected to the viewer: Lambert's diffuse and Blinn's specular term. `normal` and
    /// `to_viewer` are unit vectors, and `cosine`, between the normal and the direction to the light, is
    /// positive. As in the course the specular term is not multiplied by the cosine.
    #[inline(always)]
    pub fn reflect(&self, light: &Incident, cosine: f64, normal: DVec3, to_viewer: DVec3) -> Color {
        let mut reflected = self.phong.diffuse * cosine;
        if self.is_specular() {
            reflected += self.specular(light.direction, normal, to_viewer);
        }
        light.color * reflected
    }

    /// Whether [`reflect`](Self::reflect) returns anything but black.
    #[inline(always)]
    pub fn shows(&self, light: &Incident, cosine: f64) -> bool {
        cosine > 0.0 && !self.is_black() && light.color != Color::ZERO
    }

    /// The diffuse and the specular part of what [`reflect`](Self::reflect) returns, for whoever wants to know.
    pub fn parts(&self, light: &Incident, cosine: f64, normal: DVec3, to_viewer: DVec3) -> [Color; 2] {
        [self.phong.diffuse * cosine, self.specular(light.direction, normal, to_viewer)]
            .map(|part| light.color * part)
    }

    /// Blinn's specular term, per unit of light.
    #[inline(always)]
    fn specular(&self, to_light: DVec3, normal: DVec3, to_viewer: DVec3) -> Color {
        let half = unit_or_zero(to_light + to_viewer);
        self.highlights(normal.dot(half).max(0.0))
    }

    /// The highlights per unit of light, where `alignment` is the cosine that is raised to their exponents.
    #[inline(always)]
    pub fn highlights(&self, alignment: f64) -> Color {
        let Phong { specular, exponent, .. } = *self.phong;
        let first = Highlight { color: specular, exponent }.strength(alignment);
        self.further.iter().fold(first, |sum, h| sum + h.strength(alignment))
    }

    /// Whether the material has a highlight at all.
    #[inline(always)]
    fn is_specular(&self) -> bool {
        self.phong.specular != Color::ZERO || !self.further.is_empty()
    }

    /// Whether the material reflects no light from any direction.
    #[inline(always)]
    pub fn is_black(&self) -> bool {
        self.phong.diffuse == Color::ZERO && !self.is_specular()
    }
}

impl Highlight {
    #[inline(always)]
    fn strength(&self, alignment: f64) -> Color {
        if self.color == Color::ZERO { Color::ZERO } else { self.color * power(alignment, self.exponent) }
    }
}

/// `base` to the power of `exponent`. Integer exponents, which are usual, are computed by repeated squaring,
/// which is faster than the general power.
#[inline(always)]
fn power(base: f64, exponent: f64) -> f64 {
    const MAX_INTEGER_EXPONENT: u32 = 65536;
    let mut left = exponent as u32;
    if left as f64 != exponent || left > MAX_INTEGER_EXPONENT {
        // Rounding may leave a base slightly above 1, whose powers could overflow.
        return libm::pow(base.min(1.0), exponent);
    }
    let (mut square, mut product) = (base, 1.0);
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

    fn mixed() -> (Phong, Phong) {
        let one = Phong {
            diffuse: Color::new(1.0, 0.5, 0.25),
            specular: Color::new(0.0, 1.0, 0.0),
            exponent: 2.0,
            reflective: Color::splat(0.5),
            transparent: Color::X,
            index_of_refraction: 1.5,
        };
        let other = Phong {
            diffuse: Color::new(0.0, 1.0, 0.5),
            specular: Color::new(1.0, 0.0, 0.5),
            exponent: 4.0,
            reflective: Color::Z,
            transparent: Color::splat(0.25),
            index_of_refraction: 1.25,
        };
        (one, other)
    }

    #[test]
    fn colours_mix_by_weight_and_highlights_stay_separate() {
        let (one, other) = mixed();
        let mut mixture = Mixture::default();
        mixture.start(&one, 0.25);
        mixture.add(&other, 0.75);
        let mix = mixture.material();
        assert_eq!(mix.phong.diffuse, 0.25 * one.diffuse + 0.75 * other.diffuse);
        assert_eq!(mix.phong.reflective, 0.25 * one.reflective + 0.75 * other.reflective);
        assert_eq!(mix.phong.transparent, 0.25 * one.transparent + 0.75 * other.transparent);
        assert_eq!(mix.phong.index_of_refraction, 0.25 * 1.5 + 0.75 * 1.25);
        // The cosine between the normal and the vector half way between light and viewer is sqrt(1/2).
        let light = Incident { direction: DVec3::X, distance: 1.0, color: Color::new(1.0, 0.5, 2.0) };
        let color = mix.reflect(&light, 0.5, DVec3::Y, DVec3::Y);
        let highlights = 0.25 * one.specular * 0.5 + 0.75 * other.specular * 0.25;
        assert!((color - light.color * (0.5 * mix.phong.diffuse + highlights)).length() < 1e-15, "{color}");
        assert_eq!(mix.reflect(&light, 0.5, DVec3::NEG_Y, DVec3::Y), light.color * 0.5 * mix.phong.diffuse);
    }

    #[test]
    fn a_material_without_diffuse_colour_and_highlight_is_black() {
        let black = Phong { diffuse: Color::ZERO, ..Phong::default() };
        let shining = Phong { specular: Color::X, ..black };
        let is_black = |phong| PointMaterial::from(&phong).is_black();
        assert_eq!([is_black(black), is_black(shining), is_black(Phong::default())], [true, false, false]);
        let mut mixture = Mixture::default();
        for (other, is_black) in [(&shining, false), (&black, true)] {
            mixture.start(&black, 0.5);
            mixture.add(other, 0.5);
            assert_eq!((mixture.material().is_black(), mixture.further.is_empty()), (is_black, is_black));
        }
    }

    #[test]
    fn the_largest_whole_power_is_still_taken_by_squaring() {
        for base in [0.9999, 0.99999, 0.999999] {
            assert_eq!(power(base, 65536.0), (0..16).fold(base, |square, _| square * square));
        }
    }
}
