//! The changes that mistakes make to finished pictures, requests and scenes.

use super::regions::{largest_region, window_around};
use crate::picture::{Color, Window};
use crate::render::Request;
use crate::scene::material::{Material, Paint, Pattern, Phong, Texture};
use crate::scene::model::{FaceWeights, Highlight, Lighting, MeshNormals, Screen, Split};
use crate::scene::{Camera, Light, MaterialId, Object, ObjectId, Scene};
use crate::tools::compare::Rgb;
use crate::trace::Shadows;
use crate::world::PlacedObject;
use glam::DVec2;
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
    if let Camera::Orthographic { size, .. } = camera(request, scene) {
        *size *= factor;
    }
    set_half_tangent(request, scene, |angle| factor * libm::tan(0.5 * angle));
}

/// Lets the screen of a perspective camera span another tangent, possibly negative, in place of the one of half the
/// angle. `tangent` is given the whole angle in radians.
pub fn set_half_tangent(request: &mut Request, scene: &Scene, tangent: impl Fn(f64) -> f64) {
    if let Camera::Perspective { angle, .. } = camera(request, scene) {
        *angle = 2.0 * libm::atan(tangent(angle.to_radians())).to_degrees();
    }
}

/// Moves a point of the picture's shorter side as if that side spanned the whole screen, too.
pub fn stretched(point: DVec2, size: DVec2) -> DVec2 {
    (point - 0.5 * size) * (size.max_element() / size - 1.0)
}

/// Moves a point of the picture as if the sides were stretched by the inverse of their ratio.
pub fn wrongly_stretched(point: DVec2, size: DVec2) -> DVec2 {
    let factor = size.max_element() / size;
    (point - 0.5 * size) * (factor * factor - 1.0)
}

/// Moves the centres of the pixels so that the outer ones lie on the borders of the picture.
pub fn spread_to_borders(point: DVec2, size: DVec2) -> DVec2 {
    (point - 0.5) * size / (size - 1.0).max(DVec2::ONE) - point
}

/// Moves the centres of the pixels as if the picture had one column and one row fewer.
pub fn spread_beyond_borders(point: DVec2, size: DVec2) -> DVec2 {
    point * size / (size - 1.0).max(DVec2::ONE) - point
}

pub fn drop_shadows(request: &mut Request, _: &Scene) {
    request.effects.shadows = Shadows::None;
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

pub fn drop_highlights(scene: &mut Scene) {
    each_phong(scene, |phong| phong.specular = Color::ZERO);
}

/// A scene without lights has a rule of its own for even lighting. This breaks that rule, too.
pub fn put_out_ambient(scene: &mut Scene) {
    if scene.lights.is_empty() {
        scene.lights.push(Light::Directional { direction: Color::X, color: Color::ZERO });
    }
    scene.background.ambient = Color::ZERO;
}

/// Changes the attenuation of point lights: the constant, the factor of d, and the factor of d^2.
pub fn each_attenuation(scene: &mut Scene, change: impl Fn([f64; 3]) -> [f64; 3]) {
    for light in &mut scene.lights {
        if let Light::Point { attenuation, .. } = light {
            *attenuation = change(*attenuation);
        }
    }
}

/// Replaces the constant term of the attenuation of lights with falloff. The 2003 and 2004 editions are excluded,
/// because there it is free.
pub fn set_falloff_from(scene: &mut Scene, constant: f64) {
    if scene.lighting != Lighting::default() {
        each_attenuation(scene, |[first, linear, square]| {
            [if square > 0.0 { constant } else { first }, linear, square]
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

/// Gives each object the material with another index. `change` is given its own index and the last one.
pub fn each_material(scene: &mut Scene, change: fn(MaterialId, MaterialId) -> MaterialId) {
    let last = scene.materials.len().saturating_sub(1);
    for object in &mut scene.objects {
        match object {
            Object::Group(_) | Object::Transform { .. } => {}
            Object::Sphere { material, .. }
            | Object::Plane { material, .. }
            | Object::Triangle { material, .. }
            | Object::Box { material, .. }
            | Object::Grid { material, .. }
            | Object::Mesh { material, .. } => *material = change(*material, last),
        }
    }
}

/// Makes highlights white where there are any.
pub fn whiten_highlight(phong: &mut Phong) {
    if phong.specular != Color::ZERO {
        phong.specular = Color::ONE;
    }
}

pub fn each_texture(scene: &mut Scene, change: impl Fn(&mut Texture)) {
    for material in &mut scene.materials {
        if let Material::Texture(texture) = material {
            change(texture);
        }
    }
}

pub fn invert_matrix(texture: &mut Texture) {
    let inverse = texture.world_to_texture.map.inverse();
    if inverse.is_finite() {
        texture.world_to_texture = inverse.into();
    }
}

pub fn each_octaves(scene: &mut Scene, change: fn(u32) -> u32) {
    for octaves in scene.materials.iter_mut().filter_map(Material::octaves_mut) {
        *octaves = change(*octaves);
    }
}

/// Swaps the materials or the colours of checkerboards, or else of all other textures.
pub fn swap_children(scene: &mut Scene, of_checkerboards: bool) {
    let is_swapped = |pattern: Pattern| (pattern == Pattern::Checkerboard) == of_checkerboards;
    for material in &mut scene.materials {
        match material {
            Material::Texture(texture) if is_swapped(texture.pattern) => texture.children.swap(0, 1),
            Material::Painted(_, Paint::Pattern(pattern, colors)) if is_swapped(*pattern) => {
                colors.swap(0, 1)
            }
            _ => {}
        }
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

/// Swaps pairs of neighbours in the order of the cube map's files. They are opposite faces.
pub fn swap_faces(scene: &mut Scene, pairs: &[usize]) {
    if let Some(faces) = &mut scene.cube_map {
        pairs.iter().for_each(|pair| faces.swap(2 * pair, 2 * pair + 1));
    }
}

/// Changes the children of each group that has any.
pub fn each_group(scene: &mut Scene, change: fn(&mut Vec<ObjectId>)) {
    for object in &mut scene.objects {
        if let Object::Group(children) = object {
            change(children);
        }
    }
}

/// A part of a scene that a tracer may leave out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    Object(ObjectId),
    /// The first or the last triangle of an object, or of each mesh.
    Triangle {
        of: Option<ObjectId>,
        is_last: bool,
    },
    Light(usize),
}

impl Part {
    /// Returns the primitive of this object that is left out of the world.
    pub fn hidden(self, object: &PlacedObject, scene: &Scene) -> Option<u32> {
        let Self::Triangle { of, is_last } = self else { return None };
        let is_mesh = || matches!(scene.objects[object.id], Object::Mesh { .. });
        let mut triangles =
            object.primitives.clone().filter(|_| of.map_or_else(is_mesh, |id| id == object.id));
        if is_last { triangles.next_back() } else { triangles.next() }
    }
}

/// Leaves out an object or a light. The indices of the others stay.
pub fn leave_out(scene: &mut Scene, part: Part) {
    match part {
        Part::Object(id) => scene.objects[id] = Object::Group(vec![]),
        Part::Light(light) => {
            let (Light::Directional { color, .. } | Light::Point { color, .. }) = &mut scene.lights[light];
            *color = Color::ZERO;
        }
        // Triangles are left out of the world.
        Part::Triangle { .. } => {}
    }
}

/// Pixels of a finished picture that were never set, so that they have one colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unset {
    pub window: Window,
    pub color: Rgb,
}

impl Unset {
    /// Finds pixels that may never have been set: a window at the border of the picture around the largest region that
    /// is wrong, which has one colour.
    pub fn find(picture: &[Rgb], size: [usize; 2], wrong: &[usize]) -> Option<Self> {
        let region = largest_region(wrong, size);
        let color = picture[*region.first()?];
        let window = window_around(&region, size[0]);
        let is_at_border =
            window.x == 0 || window.y == 0 || window.right() == size[0] || window.bottom() == size[1];
        let mut rows = picture.chunks_exact(size[0]).skip(window.y).take(window.height);
        let is_plain = rows.all(|row| row[window.x..window.right()].iter().all(|pixel| *pixel == color));
        (is_at_border && is_plain && window.width * window.height < picture.len())
            .then_some(Self { window, color })
    }
}
