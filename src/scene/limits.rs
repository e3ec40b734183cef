//! How large and how small a scene's numbers may be, so that nothing made of them is not a number.
//!
//! Geometry takes products of three coordinates and of the inverse of a radius, shading those of a light's
//! colour, a material's and what secondary rays and shadows leave of them. Within these bounds all stay
//! below the largest f64.

use super::error::{Problem, SceneError};
use super::material::{Material, Phong, Texture};
use super::{Camera, Color, Light, Position, Scene};
use glam::DVec3;

/// The largest absolute value of a number in a scene, and of a coordinate in the world.
pub const LARGEST: f64 = 1e100;

/// The least radius of a sphere, and half axis of an ellipsoid, in the world.
pub const SMALLEST_RADIUS: f64 = 1e-100;

/// The largest absolute value of a colour's channels.
pub const BRIGHTEST: f64 = 1e30;

/// Whether all coordinates are numbers within bounds.
pub fn are_in_range(coordinates: DVec3) -> bool {
    coordinates.abs().cmple(DVec3::splat(LARGEST)).all()
}

fn is_color(color: Color) -> bool {
    color.abs().cmple(DVec3::splat(BRIGHTEST)).all()
}

fn is_in_range(number: f64) -> bool {
    number.abs() <= LARGEST
}

/// An error where a number of the camera, the lights, the background or a material is beyond its bound.
/// A scene from text has none: the reader refuses them. Objects are checked where they are placed.
pub fn check(scene: &Scene) -> Result<(), SceneError> {
    let is_sound = is_camera(&scene.camera)
        && is_color(scene.background.color)
        && is_color(scene.background.ambient)
        && scene.lights.iter().all(is_light)
        && scene.materials.iter().all(is_material);
    let error = SceneError::new(Position { line: 1, column: 1 }, Problem::NumbersOutOfRange);
    if is_sound { Ok(()) } else { Err(error) }
}

fn is_camera(camera: &Camera) -> bool {
    let (Camera::Orthographic { center, direction, up, size: screen }
    | Camera::Perspective { center, direction, up, angle: screen }) = *camera;
    // Of direction and up the length does not count.
    are_in_range(center) && direction.is_finite() && up.is_finite() && is_in_range(screen)
}

fn is_light(light: &Light) -> bool {
    match *light {
        Light::Directional { direction, color } => direction.is_finite() && is_color(color),
        Light::Point { position, color, attenuation } => {
            are_in_range(position) && is_color(color) && attenuation.into_iter().all(is_in_range)
        }
    }
}

fn is_material(material: &Material) -> bool {
    match material {
        Material::Phong(phong) => is_phong(phong),
        Material::Texture(Texture { world_to_texture, .. }) => world_to_texture.is_finite(),
    }
}

fn is_phong(phong: &Phong) -> bool {
    [phong.diffuse, phong.specular, phong.reflective, phong.transparent].into_iter().all(is_color)
        && (0.0..=LARGEST).contains(&phong.exponent)
        && phong.index_of_refraction > 0.0
        && is_in_range(phong.index_of_refraction)
}
