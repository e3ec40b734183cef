//! The changes that mistakes make to finished pictures, requests and scenes.

use crate::picture::Color;
use crate::render::Request;
use crate::scene::material::{Material, Pattern, Phong};
use crate::scene::model::{FaceWeights, Highlight, Lighting, MeshNormals, NormalColors, Screen, Split};
use crate::scene::{Camera, Light, Scene};
use crate::trace::Shadows;
use std::f64::consts::PI;

/// The gamma of most screens.
pub const GAMMA: f64 = 2.2;

/// Changes the levels of a colour, 255 times its channels.
pub fn levels(color: Color, change: impl Fn(f64) -> f64) -> Color {
    (255.0 * color).map(change) / 255.0
}

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

fn camera<'r>(request: &'r mut Request, scene: &Scene) -> &'r mut Camera {
    request.camera.get_or_insert(scene.camera)
}

/// A camera of the opposite handedness sees everything rotated by 180 degrees.
pub fn turn_up_vector(request: &mut Request, scene: &Scene) {
    let (Camera::Orthographic { up, .. } | Camera::Perspective { up, .. }) = camera(request, scene);
    *up = -*up;
}

/// Lets the screen span the shorter side.
pub fn widen(request: &mut Request, scene: &Scene) {
    let [width, height] = request.size.map(|side| side as f64);
    if scene.screen == Screen::LongerSide && width != height {
        zoom(request, scene, width.max(height) / width.min(height));
    }
}

/// Makes the screen this many times as large.
pub fn zoom(request: &mut Request, scene: &Scene, factor: f64) {
    match camera(request, scene) {
        Camera::Orthographic { size, .. } => *size *= factor,
        Camera::Perspective { angle, .. } => {
            let half = libm::atan(factor * libm::tan(angle.to_radians() / 2.0));
            *angle = 2.0 * half.to_degrees();
        }
    }
}

/// Lets the screen of a perspective camera span the tangent of another half angle, possibly negative.
pub fn set_half_angle(request: &mut Request, scene: &Scene, radians: fn(f64) -> f64) {
    if let Camera::Perspective { angle, .. } = camera(request, scene) {
        *angle = 2.0 * libm::atan(libm::tan(radians(*angle))).to_degrees();
    }
}

pub fn replace_shadows(request: &mut Request, one: Shadows, other: Shadows) {
    if request.effects.shadows == one {
        request.effects.shadows = other;
    }
}

/// Filters the light of shadow rays if anything is transparent.
pub fn filter_light(request: &mut Request, scene: &Scene) {
    if has(scene, |phong| phong.transparent) {
        request.effects.shadows = Shadows::Transparent;
    }
}

/// Returns true if any material reflects or transmits light.
pub fn has_secondary_rays(scene: &Scene) -> bool {
    scene.materials.iter().any(Material::has_secondary_rays)
}

/// Returns true if any material has a colour of this kind that is not black.
fn has(scene: &Scene, color: fn(&Phong) -> Color) -> bool {
    scene.materials.iter().any(|material| match material {
        Material::Phong(phong) | Material::Painted(phong, _) => color(phong) != Color::ZERO,
        Material::Texture(_) => false,
    })
}

pub fn each_phong(scene: &mut Scene, change: impl Fn(&mut Phong)) {
    for material in &mut scene.materials {
        if let Material::Phong(phong) | Material::Painted(phong, _) = material {
            change(phong);
        }
    }
}

/// A scene without lights has a rule of its own for even lighting. This breaks that rule, too.
pub fn put_out_ambient(scene: &mut Scene) {
    if scene.lights.is_empty() {
        scene.lights.push(Light::Directional { direction: Color::X, color: Color::ZERO });
    }
    scene.background.ambient = Color::ZERO;
}

/// Changes the attenuation of point lights.
pub fn each_attenuation(scene: &mut Scene, change: impl Fn(&mut [f64; 3])) {
    for light in &mut scene.lights {
        if let Light::Point { attenuation, .. } = light {
            change(attenuation);
        }
    }
}

/// Replaces the constant term of the attenuation of lights with falloff. The 2003 and 2004 editions are excluded,
/// because there it is free.
pub fn set_falloff_from(scene: &mut Scene, constant: f64) {
    if scene.lighting != Lighting::default() {
        each_attenuation(scene, |[first, _, square]| {
            if *square > 0.0 {
                *first = constant;
            }
        });
    }
}

pub fn multiply_lights_by_pi(scene: &mut Scene) {
    for light in &mut scene.lights {
        let (Light::Directional { color, .. } | Light::Point { color, .. }) = light;
        *color *= PI;
    }
}

pub fn reverse_lights(scene: &mut Scene) {
    for light in &mut scene.lights {
        if let Light::Directional { direction, .. } = light {
            *direction = -*direction;
        }
    }
}

pub fn add_ambient_per_light(scene: &mut Scene) {
    scene.background.ambient *= scene.lights.len().max(1) as f64;
}

pub fn blacken_background(scene: &mut Scene) {
    scene.background.color = Color::ZERO;
    scene.cube_map = None;
}

/// Adds highlights where the edition has none.
pub fn add_highlights(scene: &mut Scene) {
    if scene.lighting.split == Split::Schlick {
        each_phong(scene, |phong| phong.specular = phong.reflective);
    }
}

pub fn invert_index(phong: &mut Phong) {
    if phong.transparent != Color::ZERO {
        phong.index_of_refraction = 1.0 / phong.index_of_refraction;
    }
}

/// Shows normals as (N + 1) / 2, which is usual only in later editions.
pub fn shift_normals(scene: &mut Scene) {
    if scene.lighting != Lighting::default() {
        scene.measure_colors.normals = NormalColors::Shifted;
    }
}

pub fn use_half_way_vectors(scene: &mut Scene) {
    if has(scene, |phong| phong.specular) {
        scene.lighting.highlight = Highlight::Blinn;
    }
}

pub fn weigh_faces_otherwise(scene: &mut Scene) {
    if let MeshNormals::Smooth { weights, .. } = &mut scene.mesh_normals {
        *weights = match weights {
            FaceWeights::Area => FaceWeights::Equal,
            FaceWeights::Equal => FaceWeights::Area,
        };
    }
}

pub fn swap_checkerboards(scene: &mut Scene) {
    for material in &mut scene.materials {
        match material {
            Material::Texture(texture) if texture.pattern == Pattern::Checkerboard => {
                texture.children.swap(0, 1);
            }
            _ => {}
        }
    }
}

/// Swaps pairs of neighbours in the order of the cube map's files. They are opposite faces.
pub fn swap_faces(scene: &mut Scene, pairs: &[usize]) {
    if let Some(faces) = &mut scene.cube_map {
        pairs.iter().for_each(|pair| faces.swap(2 * pair, 2 * pair + 1));
    }
}
