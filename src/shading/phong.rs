//! Blinn's and Phong's reflection models, and the material at a point of a surface, with its textures evaluated.

use super::light::{Incident, unit_or_zero};
use crate::picture::Color;
use crate::scene::material::Phong;
use crate::scene::model::Highlight;
use glam::DVec3;

/// A material evaluated at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointMaterial<'m> {
    /// The material of the scene, or the sum of several materials if a texture mixes them.
    pub phong: &'m Phong,
    /// The highlights of the other materials in a mixture. They are kept separate, because exponents cannot be mixed.
    further: &'m [Lobe],
}

/// The directions from which a surface is lit and seen.
#[derive(Clone, Copy, Debug)]
pub struct Geometry {
    /// The cosine of the angle between the normal and the direction to the light.
    pub cosine: f64,
    /// The normal on the side from which the surface is seen, a unit vector.
    pub normal: DVec3,
    /// The direction to the viewer, a unit vector.
    pub to_viewer: DVec3,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Lobe {
    color: Color,
    exponent: f64,
}

/// A mixture of several materials. It is reused from one point to the next. This avoids allocating memory and moving
/// the mixture.
#[derive(Debug, Default)]
pub struct Mixture {
    sum: Phong,
    further: Vec<Lobe>,
}

impl Mixture {
    /// Starts a new mixture with one part. The weights of all parts must add up to one.
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
            self.further.push(Lobe { color, exponent: phong.exponent });
        }
    }

    /// Returns the mixed material.
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
    /// Returns the light reflected to the viewer: Lambert's diffuse term and a specular term. As in the course, the
    /// specular term is not multiplied by the cosine.
    #[inline(always)]
    pub fn reflect(&self, highlight: Highlight, light: &Incident, view: &Geometry) -> Color {
        let mut reflected = self.phong.diffuse * diffuse_factor(highlight, view.cosine);
        if self.is_specular() {
            reflected += self.specular(highlight, light.direction, view);
        }
        light.color * reflected
    }

    /// Returns true if [`reflect`](Self::reflect) must be called, because it may return a colour other than black.
    #[inline(always)]
    pub fn shows(&self, highlight: Highlight, light: &Incident, cosine: f64) -> bool {
        let faces = cosine > 0.0 || highlight == Highlight::Phong && self.is_specular();
        faces && !self.is_black() && light.color != Color::ZERO
    }

    /// Returns the diffuse and the specular part of the result of [`reflect`](Self::reflect).
    pub fn parts(&self, highlight: Highlight, light: &Incident, view: &Geometry) -> [Color; 2] {
        let diffuse = self.phong.diffuse * diffuse_factor(highlight, view.cosine);
        [diffuse, self.specular(highlight, light.direction, view)].map(|part| light.color * part)
    }

    /// Returns the specular term per unit of light.
    #[inline(always)]
    fn specular(&self, highlight: Highlight, to_light: DVec3, view: &Geometry) -> Color {
        self.highlights(alignment(highlight, to_light, view).max(0.0))
    }

    /// Returns the highlights per unit of light. `alignment` is the cosine that is raised to their exponents.
    #[inline(always)]
    pub fn highlights(&self, alignment: f64) -> Color {
        let Phong { specular, exponent, .. } = *self.phong;
        let first = Lobe { color: specular, exponent }.strength(alignment);
        self.further.iter().fold(first, |sum, h| sum + h.strength(alignment))
    }

    /// Returns true if the material has a highlight.
    #[inline(always)]
    fn is_specular(&self) -> bool {
        self.phong.specular != Color::ZERO || !self.further.is_empty()
    }

    /// Returns true if the material reflects no light from any direction.
    #[inline(always)]
    pub fn is_black(&self) -> bool {
        self.phong.diffuse == Color::ZERO && !self.is_specular()
    }
}

impl Lobe {
    #[inline(always)]
    fn strength(&self, alignment: f64) -> Color {
        if self.color == Color::ZERO { Color::ZERO } else { self.color * power(alignment, self.exponent) }
    }
}

/// Returns the cosine that is raised to the exponent of a highlight.
#[inline(always)]
pub fn alignment(highlight: Highlight, to_light: DVec3, view: &Geometry) -> f64 {
    let Geometry { normal, to_viewer, .. } = *view;
    match highlight {
        Highlight::Blinn => normal.dot(unit_or_zero(to_light + to_viewer)),
        Highlight::Phong => to_light.dot(2.0 * to_viewer.dot(normal) * normal - to_viewer),
    }
}

/// Returns the factor of the diffuse colour. With [`Highlight::Blinn`] it is meaningful only if the surface faces the
/// light.
#[inline(always)]
fn diffuse_factor(highlight: Highlight, cosine: f64) -> f64 {
    match highlight {
        Highlight::Blinn => cosine,
        Highlight::Phong => cosine.max(0.0),
    }
}

/// Returns `base` to the power of `exponent`. Most exponents are integers, for which repeated squaring is faster than
/// the general power.
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

    fn seen(cosine: f64, normal: DVec3, to_viewer: DVec3) -> Geometry {
        Geometry { cosine, normal, to_viewer }
    }

    #[test]
    fn a_highlight_by_the_mirrored_direction_needs_no_surface_that_faces_the_light() {
        let phong = Phong { specular: Color::X, exponent: 2.0, ..Phong::default() };
        let viewer = DVec3::new(1.0, 1.0, 0.0).normalize();
        let light = |direction: DVec3| Incident { direction, distance: 1.0, color: Color::ONE };
        let (level, behind) = (light(DVec3::NEG_X), light(DVec3::new(-1.0, -0.1, 0.0).normalize()));
        let material = PointMaterial::from(&phong);
        let reflect = |light: &Incident| {
            material.reflect(Highlight::Phong, light, &seen(DVec3::Y.dot(light.direction), DVec3::Y, viewer))
        };
        // The mirrored direction is at 45 degrees to one light, and a little farther from the other.
        assert!((reflect(&level) - Color::new(0.5, 0.0, 0.0)).length() < 1e-15);
        let cosine = behind.direction.dot(DVec3::new(-1.0, 1.0, 0.0).normalize());
        assert!((reflect(&behind) - Color::X * cosine * cosine).length() < 1e-15);
        let shows = |highlight, light: &Incident| material.shows(highlight, light, light.direction.y);
        assert_eq!([Highlight::Phong, Highlight::Blinn].map(|law| shows(law, &behind)), [true, false]);
        // Zero to the power of zero is one.
        let even = Phong { exponent: 0.0, ..phong };
        let away = light(DVec3::new(1.0, -1.0, 0.0).normalize());
        let color =
            PointMaterial::from(&even).reflect(Highlight::Phong, &away, &seen(-0.7, DVec3::Y, viewer));
        assert_eq!(color, Color::X);
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
        let color = mix.reflect(Highlight::Blinn, &light, &seen(0.5, DVec3::Y, DVec3::Y));
        let highlights = 0.25 * one.specular * 0.5 + 0.75 * other.specular * 0.25;
        assert!((color - light.color * (0.5 * mix.phong.diffuse + highlights)).length() < 1e-15, "{color}");
        assert_eq!(
            mix.reflect(Highlight::Blinn, &light, &seen(0.5, DVec3::NEG_Y, DVec3::Y)),
            light.color * 0.5 * mix.phong.diffuse
        );
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
