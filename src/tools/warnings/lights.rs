//! Lights that no picture shows.

use super::{Warning, known};
use crate::math::aabb::Aabb;
use crate::primitive::shape::Shape;
use crate::scene::material::{Material, Paint, Phong};
use crate::scene::parser::Places;
use crate::scene::{Camera, Color, Light, MaterialId, Scene};
use crate::trace::{Effects, Shadows};
use crate::world::World;
use glam::DVec3;
use std::fmt;

/// Why a light has no effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// It is black.
    Black,
    /// Its attenuation is negative or zero at every distance, which the course takes for no light.
    NegativeAttenuation,
    /// Its attenuation leaves less than a quarter of a level at the nearest object.
    TooFar,
    /// It lies on a surface, which shadows everything.
    OnSurface,
    /// It stands inside a sphere that shadows everything else.
    Enclosed {
        /// The line of the sphere, if known.
        line: Option<u32>,
    },
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Black => f.write_str("its colour is 0 0 0"),
            Self::NegativeAttenuation => f.write_str("its attenuation is above 0 at no distance"),
            Self::TooFar => {
                f.write_str("its attenuation leaves less than a quarter of a level at the nearest object")
            }
            Self::OnSurface => f.write_str("it lies on a surface, which shadows everything from it"),
            Self::Enclosed { line: Some(line) } => {
                write!(f, "it stands inside the sphere in line {line}, and nothing else is lit with shadows")
            }
            Self::Enclosed { line: None } => {
                f.write_str("it stands inside a sphere, and nothing else is lit with shadows")
            }
        }
    }
}

/// The lights that have no effect on any picture of the scene.
pub fn without_effect(scene: &Scene, world: &World, places: &Places, effects: &Effects) -> Vec<Warning> {
    let lights = scene.lights.iter().enumerate();
    let brightest = world.materials.iter().map(brightness).fold(1.0, f64::max);
    let warning = |(index, light): (usize, &Light)| {
        let lies_on_surface = !world.primitives_at_light(index).is_empty();
        let reason = match reason(light, scene, world, brightest, effects) {
            None if lies_on_surface && effects.shadows == Shadows::Opaque => Reason::OnSurface,
            reason => reason?,
        };
        Some(Warning::IdleLight { at: known(places.lights.get(index)), reason })
    };
    lights.filter_map(warning).collect()
}

fn reason(light: &Light, scene: &Scene, world: &World, brightest: f64, effects: &Effects) -> Option<Reason> {
    let (Light::Directional { color, .. } | Light::Point { color, .. }) = *light;
    if color == Color::ZERO {
        return Some(Reason::Black);
    }
    let Light::Point { position, attenuation, .. } = *light else { return None };
    if attenuation.iter().all(|&coefficient| coefficient <= 0.0) {
        return Some(Reason::NegativeAttenuation);
    }
    if is_too_far(position, color * brightest, attenuation, world) {
        return Some(Reason::TooFar);
    }
    let sphere = enclosing_sphere(position, scene, world, effects)?;
    Some(Reason::Enclosed { line: line_of(sphere, scene) })
}

/// Whether the light changes no pixel by a quarter of a level, wherever it meets a surface from the front. `color` is that
/// of the light on the brightest material.
fn is_too_far(position: DVec3, color: Color, [a0, a1, a2]: [f64; 3], world: &World) -> bool {
    const QUARTER_LEVEL: f64 = 0.25 / 255.0;
    let brightest = color.abs().max_element();
    let is_dark =
        |distance: f64| brightest * (1.0 / (a0 + a1 * distance + a2 * distance * distance)) < QUARTER_LEVEL;
    let to_bounds = |bounds: Aabb| (position.clamp(bounds.min, bounds.max) - position).length();
    let (bounds, planes) = (world.bounds, &world.planes);
    // The light grows darker with the distance.
    [a0, a1, a2].into_iter().all(|coefficient| coefficient >= 0.0)
        && !(bounds.is_empty() && planes.is_empty())
        && (bounds.is_empty() || is_dark(to_bounds(bounds)))
        && planes.iter().all(|plane| is_dark(plane.ahead_of(position).abs()))
}

/// How bright a material is at most in the light of one, unless it is less than white.
fn brightness(material: &Material) -> f64 {
    let of = |diffuse: Color, phong: &Phong| (diffuse.abs() + phong.specular.abs()).max_element();
    match material {
        Material::Painted(phong, Paint::Pattern(_, colors)) => {
            colors.iter().map(|&color| of(color, phong)).fold(0.0, f64::max)
        }
        // The picture may be white.
        Material::Painted(phong, Paint::Image { .. }) => of(phong.diffuse.max(Color::ONE), phong),
        Material::Phong(phong) => of(phong.diffuse, phong),
        Material::Texture(_) => 0.0,
    }
}

/// The sphere around a light that lets none of it out, where no camera looks in. The sphere's index is
/// returned.
fn enclosing_sphere(position: DVec3, scene: &Scene, world: &World, effects: &Effects) -> Option<usize> {
    if effects.shadows == Shadows::None {
        return None;
    }
    let eye = match scene.camera {
        Camera::Perspective { center, .. } => Some(center),
        // Its rays start infinitely far away.
        Camera::Orthographic { .. } => None,
    };
    // A rounding more or less decides nothing here, and silence is right where it would.
    const CLEARLY: f64 = 1e-6;
    world.shapes.iter().enumerate().position(|(index, shape)| {
        let Shape::Sphere(sphere) = shape else { return false };
        let distance = |point: DVec3| (point - sphere.center).length() / sphere.radius;
        let id = (world.triangles.len() + index) as u32;
        distance(position) < 1.0 - CLEARLY
            && eye.is_none_or(|eye| distance(eye) > 1.0 + CLEARLY)
            && is_opaque(world.material_of(id), &world.materials)
    })
}

/// Whether no light passes through a material anywhere.
fn is_opaque(material: MaterialId, materials: &[Material]) -> bool {
    match &materials[material] {
        Material::Phong(phong) | Material::Painted(phong, _) => phong.transparent == Color::ZERO,
        // A texture only mixes materials before it. One of many levels is taken to let light through.
        Material::Texture(texture) => texture.children.iter().all(|&child| match &materials[child] {
            Material::Phong(phong) | Material::Painted(phong, _) => phong.transparent == Color::ZERO,
            Material::Texture(_) => false,
        }),
    }
}

/// The line of the sphere with this index among the shapes of the world, where each sphere is placed once.
fn line_of(sphere: usize, scene: &Scene) -> Option<u32> {
    let mut spheres = scene.objects.iter().zip(&scene.positions).filter_map(|(object, at)| match object {
        crate::scene::Object::Sphere { .. } => Some(at.line),
        _ => None,
    });
    spheres.nth(sphere)
}
