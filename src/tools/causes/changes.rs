//! The changes that mistakes make to finished pictures, cameras and scenes.

use crate::picture::Color;
use crate::scene::material::{Material, Pattern, Phong};
use crate::scene::model::{FaceWeights, Highlight, Lighting, MeshNormals, NormalColors, Screen, Split};
use crate::scene::{Camera, Light, Scene};
use crate::trace::{Effects, Shadows};
use std::f64::consts::PI;

/// The gamma of most screens.
pub const GAMMA: f64 = 2.2;

/// Returns a level of a picture whose colours are raised to a power.
pub fn powered(level: f64, power: f64) -> f64 {
    255.0 * libm::pow(level.max(0.0) / 255.0, power)
}

/// Encodes a level by the curve of sRGB (IEC 61966-2-1).
pub fn srgb_encoded(level: f64) -> f64 {
    if level <= 255.0 * 0.003_130_8 {
        12.92 * level
    } else {
        1.055 * powered(level, 1.0 / 2.4) - 255.0 * 0.055
    }
}

pub fn upside_down(pixels: &mut [Color], width: usize) {
    pixels.reverse();
    mirrored(pixels, width);
}

pub fn mirrored(pixels: &mut [Color], width: usize) {
    pixels.chunks_exact_mut(width).for_each(<[Color]>::reverse);
}

/// Returns the camera with the opposite handedness. It sees everything rotated by 180 degrees.
pub fn of_other_handedness(mut camera: Camera) -> Camera {
    let (Camera::Orthographic { up, .. } | Camera::Perspective { up, .. }) = &mut camera;
    *up = -*up;
    camera
}

/// Returns the camera whose screen spans the shorter side. `None` for a square or stretched picture.
pub fn widened(camera: Camera, screen: Screen, size: [usize; 2]) -> Option<Camera> {
    let [shorter, longer] = [size[0].min(size[1]), size[0].max(size[1])].map(|side| side as f64);
    let ratio = longer / shorter;
    (screen == Screen::LongerSide && ratio > 1.0).then_some(zoomed(camera, ratio))
}

/// Returns the camera whose screen is this many times as large.
pub fn zoomed(camera: Camera, factor: f64) -> Camera {
    match camera {
        Camera::Orthographic { center, direction, up, size } => {
            Camera::Orthographic { center, direction, up, size: size * factor }
        }
        Camera::Perspective { center, direction, up, angle } => {
            let half = libm::atan(factor * libm::tan(angle.to_radians() / 2.0));
            Camera::Perspective { center, direction, up, angle: 2.0 * half.to_degrees() }
        }
    }
}

/// Returns the camera whose screen spans the tangent of another half angle, possibly negative. `None` without an angle.
pub fn with_half_angle(camera: Camera, radians: fn(f64) -> f64) -> Option<Camera> {
    let Camera::Perspective { center, direction, up, angle } = camera else { return None };
    let half = libm::atan(libm::tan(radians(angle)));
    Some(Camera::Perspective { center, direction, up, angle: 2.0 * half.to_degrees() })
}

/// Filters the light of shadow rays if anything is transparent.
pub fn filter_light(effects: &mut Effects, scene: &Scene) {
    if has(scene, |phong| phong.transparent) {
        effects.shadows = Shadows::Transparent;
    }
}

pub fn change_bounces(effects: &mut Effects, scene: &Scene, change: fn(u32, u32) -> u32) {
    if has_secondary_rays(scene) {
        effects.bounces = change(effects.bounces, 1);
    }
}

/// Returns true if any material reflects or transmits light.
pub fn has_secondary_rays(scene: &Scene) -> bool {
    scene.materials.iter().any(Material::has_secondary_rays)
}

/// Returns true if any material has a colour of this kind that is not black.
pub fn has(scene: &Scene, color: fn(&Phong) -> Color) -> bool {
    scene.materials.iter().any(|material| match material {
        Material::Phong(phong) | Material::Painted(phong, _) => color(phong) != Color::ZERO,
        Material::Texture(_) => false,
    })
}

/// Sets `place` to `other` if it equals `value`.
pub fn replace<T: PartialEq>(place: &mut T, value: T, other: T) {
    if *place == value {
        *place = other;
    }
}

/// Replaces a value. Returns true if the new value differs.
pub fn replaced<T: PartialEq>(place: &mut T, value: T) -> bool {
    let changes = *place != value;
    *place = value;
    changes
}

/// Changes all items. Returns true if any changed.
pub fn any<T>(all: &mut [T], change: impl Fn(&mut T) -> bool) -> bool {
    all.iter_mut().fold(false, |changes, one| change(one) | changes)
}

pub fn any_phong(scene: &mut Scene, change: impl Fn(&mut Phong) -> bool) -> bool {
    any(&mut scene.materials, |material| match material {
        Material::Phong(phong) | Material::Painted(phong, _) => change(phong),
        Material::Texture(_) => false,
    })
}

pub fn scale_exponent(phong: &mut Phong, factor: f64) -> bool {
    let exponent = factor * phong.exponent;
    phong.specular != Color::ZERO && replaced(&mut phong.exponent, exponent)
}

/// A scene without lights has a rule of its own for even lighting. This breaks that rule, too.
pub fn put_out_ambient(scene: &mut Scene) -> bool {
    if scene.lights.is_empty() {
        scene.lights.push(Light::Directional { direction: Color::X, color: Color::ZERO });
        scene.background.ambient = Color::ZERO;
        return true;
    }
    replaced(&mut scene.background.ambient, Color::ZERO)
}

/// Changes the attenuation of point lights.
pub fn any_attenuation(scene: &mut Scene, change: impl Fn(&mut [f64; 3]) -> bool) -> bool {
    any(&mut scene.lights, |light| match light {
        Light::Point { attenuation, .. } => change(attenuation),
        Light::Directional { .. } => false,
    })
}

/// Replaces the constant term of the attenuation of lights with falloff. The 2003 and 2004 editions are excluded,
/// because there it is free.
pub fn falls_off_from(scene: &mut Scene, constant: f64) -> bool {
    scene.lighting != Lighting::default()
        && any_attenuation(scene, |[first, _, square]| *square > 0.0 && replaced(first, constant))
}

pub fn multiply_lights_by_pi(scene: &mut Scene) -> bool {
    any(&mut scene.lights, |light| {
        let (Light::Directional { color, .. } | Light::Point { color, .. }) = light;
        let brighter = PI * *color;
        replaced(color, brighter)
    })
}

pub fn reverse_lights(scene: &mut Scene) -> bool {
    any(&mut scene.lights, |light| match light {
        Light::Directional { direction, .. } => replaced(direction, -*direction),
        Light::Point { .. } => false,
    })
}

pub fn add_ambient_per_light(scene: &mut Scene) -> bool {
    let ambient = scene.lights.len().max(1) as f64 * scene.background.ambient;
    replaced(&mut scene.background.ambient, ambient)
}

pub fn blacken_background(scene: &mut Scene) -> bool {
    replaced(&mut scene.background.color, Color::ZERO) | scene.cube_map.take().is_some()
}

/// Adds highlights where the edition has none.
pub fn add_highlights(scene: &mut Scene) -> bool {
    let is_meant = scene.lighting.split == Split::Schlick;
    is_meant && any_phong(scene, |phong| replaced(&mut phong.specular, phong.reflective))
}

pub fn invert_index(phong: &mut Phong) -> bool {
    let index = phong.index_of_refraction;
    phong.transparent != Color::ZERO && replaced(&mut phong.index_of_refraction, 1.0 / index)
}

/// Shows normals as (N + 1) / 2, which is usual only in later editions.
pub fn shift_normals(scene: &mut Scene) -> bool {
    scene.lighting != Lighting::default()
        && replaced(&mut scene.measure_colors.normals, NormalColors::Shifted)
}

pub fn use_half_way_vectors(scene: &mut Scene) -> bool {
    has(scene, |phong| phong.specular) && replaced(&mut scene.lighting.highlight, Highlight::Blinn)
}

pub fn flatten_meshes(scene: &mut Scene) -> bool {
    !scene.meshes.is_empty() && replaced(&mut scene.mesh_normals, MeshNormals::Flat)
}

pub fn weigh_faces_otherwise(scene: &mut Scene) -> bool {
    let MeshNormals::Smooth { weights, .. } = &mut scene.mesh_normals else { return false };
    *weights = match weights {
        FaceWeights::Area => FaceWeights::Equal,
        FaceWeights::Equal => FaceWeights::Area,
    };
    !scene.meshes.is_empty()
}

pub fn swap_checkerboard(material: &mut Material) -> bool {
    match material {
        Material::Texture(texture) if texture.pattern == Pattern::Checkerboard => {
            texture.children.swap(0, 1);
            true
        }
        _ => false,
    }
}

/// Swaps pairs of neighbours in the order of the cube map's files. They are opposite faces.
pub fn swap_faces(scene: &mut Scene, pairs: &[usize]) -> bool {
    let Some(faces) = &mut scene.cube_map else { return false };
    pairs.iter().for_each(|pair| faces.swap(2 * pair, 2 * pair + 1));
    true
}
