//! The ranges of a scene's numbers within which no result overflows or becomes a NaN.
//!
//! Geometry multiplies up to three coordinates, and the inverse of a radius. Shading multiplies the colours
//! of lights and materials along the path of secondary rays and shadows. Within these limits all products
//! stay below the largest f64.

use super::error::{Problem, SceneError};
use super::material::{Material, Phong, Texture};
use super::{Camera, Color, Light, Position, Scene};
use glam::DVec3;

/// The largest magnitude of a number in a scene, and of a coordinate in world space.
pub const LARGEST: f64 = 1e100;

/// The smallest radius of a sphere, or semi-axis of an ellipsoid, in world space.
pub const SMALLEST_RADIUS: f64 = 1e-100;

/// The largest magnitude of a colour channel.
pub const BRIGHTEST: f64 = 1e30;

/// Whether the magnitudes of all coordinates are at most [`LARGEST`]. A NaN is out of range.
pub fn are_in_range(coordinates: DVec3) -> bool {
    coordinates.abs().cmple(DVec3::splat(LARGEST)).all()
}

fn is_color(color: Color) -> bool {
    color.abs().cmple(DVec3::splat(BRIGHTEST)).all()
}

fn is_in_range(number: f64) -> bool {
    number.abs() <= LARGEST
}

/// Checks the numbers of the camera, the lights, the background and the materials. This matters for scenes
/// made by a program, since the reader refuses text with such numbers. Objects are checked when they are
/// placed in the world.
pub fn check(scene: &Scene) -> Result<(), SceneError> {
    let is_valid = is_camera(&scene.camera)
        && is_color(scene.background.color)
        && is_color(scene.background.ambient)
        && scene.lights.iter().all(is_light)
        && scene.materials.iter().all(is_material);
    let error = SceneError::new(Position { line: 1, column: 1 }, Problem::NumbersOutOfRange);
    if is_valid { Ok(()) } else { Err(error) }
}

fn is_camera(camera: &Camera) -> bool {
    let (Camera::Orthographic { center, direction, up, size: screen }
    | Camera::Perspective { center, direction, up, angle: screen }) = *camera;
    // The lengths of `direction` and `up` do not matter, because they are normalised.
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
