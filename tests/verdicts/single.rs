//! A ray tracer as a good student of the course writes it: in single precision, without any acceleration, and with a
//! fixed epsilon. On request it makes mistakes.

use super::mistake::Mistake::{self, *};
use super::mistake::Mistakes;
use super::objects::{Hit, Objects, Ray};
use super::textures::first_weight;
use glam::Vec3;
use rayon::prelude::*;
use raytracer::cli::Options;
use raytracer::picture::{Color, Picture};
use raytracer::render::Layer;
use raytracer::scene::load::LoadedScene;
use raytracer::scene::material::{Material, Phong};
use raytracer::scene::parser::parse;
use raytracer::scene::{Camera, Light, Scene};
use raytracer::trace::{Effects, Shadows};
use std::f32::consts::PI;
use std::ops::{Add, Mul};

/// Renders a layer of a scene with these mistakes. The options belong to the scene's edition, 2004 or 2003.
pub fn render(loaded: &LoadedScene, options: &Options, layer: Layer, mistakes: &[Mistake]) -> Picture {
    let tracer = Tracer::new(loaded, options.effects, mistakes);
    let [width, height] = options.size;
    let row = |j: usize| (0..width).map(|i| tracer.pixel([i, j], options.size, layer)).collect();
    let rows: Vec<Vec<Vec3>> = (0..height).into_par_iter().map(row).collect();
    let mut picture = Picture::new(width as u32, height as u32).unwrap();
    for (j, colors) in rows.iter().enumerate() {
        let to = if tracer.makes(UpsideDown) { height - 1 - j } else { j };
        let (pixels, _) = picture.row_mut(to).as_chunks_mut();
        for (i, color) in colors.iter().enumerate() {
            let to = if tracer.makes(Mirrored) { width - 1 - i } else { i };
            pixels[to] = tracer.bytes(*color);
        }
    }
    picture
}

struct Tracer {
    scene: Scene,
    objects: Objects,
    effects: Effects,
    epsilon: f32,
    mistakes: Mistakes,
}

/// The history of a ray since it left the camera.
#[derive(Clone, Copy)]
struct Path {
    bounces: u32,
    weight: f32,
    /// The index of refraction of the medium around the ray.
    index: f32,
}

/// The light that arrives at a point from one source.
struct Incident {
    direction: Vec3,
    distance: f32,
    color: Vec3,
}

impl Tracer {
    fn new(loaded: &LoadedScene, mut effects: Effects, mistakes: &[Mistake]) -> Self {
        let mistakes = Mistakes::new(mistakes);
        let mut scene = match &loaded.source.text {
            text if mistakes.has(RotationsInRadians) => parse(&with_angles(text, f64::to_degrees)).unwrap(),
            text if mistakes.has(RotationsReversed) => parse(&with_angles(text, |angle| -angle)).unwrap(),
            _ => loaded.scene.clone(),
        };
        if mistakes.has(LastLightMissing) {
            scene.lights.pop();
        }
        // In a scene without lights all surfaces have their diffuse colour.
        if loaded.scene.lights.is_empty() {
            scene.background.ambient = Color::ONE;
        }
        if mistakes.has(NoAmbient) {
            scene.background.ambient = Color::ZERO;
        }
        if mistakes.has(NoShadows) {
            effects.shadows = Shadows::None;
        }
        if mistakes.has(OneBounceMore) {
            effects.bounces += 1;
        }
        if mistakes.has(OneBounceFewer) {
            effects.bounces = effects.bounces.saturating_sub(1);
        }
        let epsilon = match () {
            _ if mistakes.has(EpsilonZero) => 0.0,
            _ if mistakes.has(EpsilonOfTenth) => 0.1,
            _ => 1e-4,
        };
        let objects = Objects::new(&scene, &loaded.meshes, mistakes);
        Self { scene, objects, effects, epsilon, mistakes }
    }

    fn makes(&self, mistake: Mistake) -> bool {
        self.mistakes.has(mistake)
    }

    /// Returns the colour of the pixel in this column and row from the bottom left.
    fn pixel(&self, [i, j]: [usize; 2], size: [usize; 2], layer: Layer) -> Vec3 {
        let is_missing = self.makes(FirstRowMissing) && j == 0
            || self.makes(LastRowMissing) && j == size[1] - 1
            || self.makes(CornerMissing) && i == 0 && j == 0
            || self.makes(CornerBlockMissing) && i < 5 && j < 5;
        if is_missing {
            return Vec3::ZERO;
        }
        let (ray, t_min) = self.camera_ray([i, j].map(|n| n as f32), size.map(|n| n as f32));
        let hit = || self.objects.nearest(&ray, t_min, f32::INFINITY);
        match layer {
            Layer::Depth { near, far } => {
                hit().map_or(Vec3::ZERO, |hit| self.depth(hit.t, [near as f32, far as f32]))
            }
            Layer::Normals => hit().map_or(Vec3::ZERO, |hit| self.normal_color(hit.normal)),
            _ => self.shown(self.color(&ray, t_min, Path { bounces: 0, weight: 1.0, index: 1.0 })),
        }
    }

    /// Returns the ray through a pixel's centre, and its smallest t.
    fn camera_ray(&self, [i, j]: [f32; 2], [width, height]: [f32; 2]) -> (Ray, f32) {
        let [x, y] = match () {
            _ if self.makes(PixelsOverWidthMinusOne) => {
                [i * width / (width - 1.0), j * height / (height - 1.0)]
            }
            _ if self.makes(PixelCorners) => [i, j],
            _ => [i + 0.5, j + 0.5],
        };
        let sides = if self.makes(SidesNotInProportion) { [width, height] } else { [width.max(height); 2] };
        let zoom = if self.makes(ViewLarger) { 1.02 } else { 1.0 };
        let [x, y] = [zoom * (x - width / 2.0) / sides[0], zoom * (y - height / 2.0) / sides[1]];
        match self.scene.camera {
            Camera::Orthographic { center, direction, up, size } => {
                let [direction, right, up] = axes(direction.as_vec3(), up.as_vec3());
                let origin = center.as_vec3() + size as f32 * (x * right + y * up);
                (Ray { origin, direction }, f32::NEG_INFINITY)
            }
            Camera::Perspective { center, direction, up, angle } => {
                let [direction, right, up] = axes(direction.as_vec3(), up.as_vec3());
                let angle = (angle as f32).to_radians();
                let half_width = match () {
                    _ if self.makes(WholeAngle) => angle.tan(),
                    _ if self.makes(QuarterOfAngle) => (angle / 4.0).tan(),
                    _ if self.makes(AngleWithoutTangent) => angle / 2.0,
                    _ => (angle / 2.0).tan(),
                };
                let direction = direction + 2.0 * half_width * (x * right + y * up);
                (Ray { origin: center.as_vec3(), direction: direction.normalize() }, 0.0)
            }
        }
    }

    /// Returns the colour along a ray.
    fn color(&self, ray: &Ray, t_min: f32, path: Path) -> Vec3 {
        let Some(hit) = self.objects.nearest(ray, t_min, f32::INFINITY) else {
            let is_black = self.makes(BackgroundBlack) && path.bounces > 0;
            return if is_black { Vec3::ZERO } else { self.scene.background.color.as_vec3() };
        };
        let point = ray.at(hit.t);
        let color = self.local_color(ray, &hit, point);
        if path.bounces == self.effects.bounces {
            return color;
        }
        let color = self.with_reflection(color, ray, &hit, path);
        self.with_refraction(color, ray, &hit, path)
    }

    fn with_reflection(&self, color: Vec3, ray: &Ray, hit: &Hit, path: Path) -> Vec3 {
        let origin = ray.at(hit.t);
        let reflective = self.mixed(hit.material, origin, &|phong| phong.reflective.as_vec3());
        let weight = path.weight * reflective.length();
        if weight <= self.effects.min_weight as f32 {
            return color;
        }
        let reflected = Ray { origin, direction: reflected(ray.direction, hit.normal) };
        let seen = self.color(&reflected, self.epsilon, Path { bounces: path.bounces + 1, weight, ..path });
        let mistakes = [ReflectionSquared, ReflectionTwice, ReflectionSubtracted, ReflectionBlended];
        self.combined(color, reflective, seen, mistakes)
    }

    fn with_refraction(&self, color: Vec3, ray: &Ray, hit: &Hit, path: Path) -> Vec3 {
        let origin = ray.at(hit.t);
        let transparent = self.mixed(hit.material, origin, &|phong| phong.transparent.as_vec3());
        let weight = path.weight * transparent.length();
        if weight <= self.effects.min_weight as f32 {
            return color;
        }
        let inside = self.mixed(hit.material, origin, &|phong| phong.index_of_refraction as f32);
        let is_entering = ray.direction.dot(hit.normal) < 0.0;
        let behind = if is_entering { inside } else { 1.0 };
        let ratio = match () {
            _ if self.makes(RefractionIndicesSwapped) => behind / path.index,
            _ if self.makes(RefractionFromOutsideOnly) => 1.0 / inside,
            _ => path.index / behind,
        };
        let normal = if is_entering { hit.normal } else { -hit.normal };
        let (direction, index) = match refracted(ray.direction, normal, ratio) {
            _ if self.makes(RefractionStraight) => (ray.direction, behind),
            Some(direction) => (direction, behind),
            None if self.makes(TotalReflectionMirrored) => (reflected(ray.direction, normal), path.index),
            None => return color,
        };
        let path = Path { bounces: path.bounces + 1, weight, index };
        let seen = self.color(&Ray { origin, direction }, self.epsilon, path);
        let mistakes = [RefractionSquared, RefractionTwice, RefractionSubtracted, RefractionBlended];
        self.combined(color, transparent, seen, mistakes)
    }

    /// Adds the colour that is seen along a secondary ray, times the material's factor.
    fn combined(&self, color: Vec3, factor: Vec3, seen: Vec3, mistakes: [Mistake; 4]) -> Vec3 {
        match mistakes.map(|mistake| self.makes(mistake)) {
            [true, ..] => color + factor * factor * seen,
            [_, true, ..] => color + 2.0 * factor * seen,
            [_, _, true, _] => color - factor * seen,
            [.., true] => (Vec3::ONE - factor) * color + factor * seen,
            _ => color + factor * seen,
        }
    }

    /// Returns the light that a surface itself reflects.
    fn local_color(&self, ray: &Ray, hit: &Hit, point: Vec3) -> Vec3 {
        let is_inside = hit.normal.dot(ray.direction) > 0.0;
        if is_inside && !self.effects.shade_back {
            return Vec3::ZERO;
        }
        let normal = if is_inside { -hit.normal } else { hit.normal };
        let ambient =
            if self.makes(NoAmbient) { Vec3::ZERO } else { self.scene.background.ambient.as_vec3() };
        let mut color = ambient * self.mixed(hit.material, point, &|phong| phong.diffuse.as_vec3());
        let lights: Vec<Incident> =
            self.scene.lights.iter().map(|light| self.incident(light, point)).collect();
        let is_blocked: Vec<bool> = lights
            .iter()
            .enumerate()
            .map(|(index, light)| self.is_blocked(index, light, point, normal))
            .collect();
        if self.makes(ShadowsOfAnyLight) && is_blocked.contains(&true) {
            return color;
        }
        for (light, is_blocked) in lights.iter().zip(is_blocked) {
            let passed = match is_blocked {
                true if self.makes(ShadowsHalve) => 0.5,
                true => continue,
                false => 1.0,
            };
            let reflect = |phong: &Phong| self.reflect(phong, normal, light.direction, -ray.direction);
            let reflected = passed * light.color * self.mixed(hit.material, point, &reflect);
            color = if self.makes(LightsOverwritten) { reflected } else { color + reflected };
        }
        color
    }

    fn incident(&self, light: &Light, point: Vec3) -> Incident {
        let brightness = if self.makes(LightsDimmer) { 0.99 } else { 1.0 };
        match *light {
            Light::Directional { direction, color } => {
                let direction = -direction.as_vec3().normalize();
                Incident { direction, distance: f32::INFINITY, color: brightness * color.as_vec3() }
            }
            Light::Point { position, color, attenuation } => {
                let to_light = position.as_vec3() - point;
                let distance = to_light.length();
                let factor = self.attenuation(attenuation.map(|number| number as f32), distance);
                let color = brightness * factor * color.as_vec3();
                Incident { direction: to_light / distance, distance, color }
            }
        }
    }

    fn attenuation(&self, mut coefficients: [f32; 3], distance: f32) -> f32 {
        if self.makes(AttenuationReversed) {
            coefficients.reverse();
        }
        let [constant, linear, quadratic] = coefficients;
        let square = if self.makes(AttenuationByDistance) { distance } else { distance * distance };
        let falloff = constant + linear * distance + quadratic * square;
        let factor = if falloff > 0.0 { 1.0 / falloff } else { 0.0 };
        if self.makes(AttenuationTwice) { factor * factor } else { factor }
    }

    /// Returns true if an object is between the point and the light.
    fn is_blocked(&self, index: usize, light: &Incident, point: Vec3, normal: Vec3) -> bool {
        if self.effects.shadows == Shadows::None || self.makes(ShadowsOfFirstLight) && index > 0 {
            return false;
        }
        let (origin, t_min) = match () {
            _ if self.makes(ShadowBiasOfHundredth) => (point + 0.01 * normal, 0.0),
            _ if self.makes(ShadowBiasOfTenth) => (point + 0.1 * normal, 0.0),
            _ => (point, self.epsilon),
        };
        let ray = Ray { origin, direction: light.direction };
        self.objects.nearest(&ray, t_min, light.distance).is_some()
    }

    /// Returns the part of the light that a material reflects to the viewer, by Blinn's model.
    fn reflect(&self, phong: &Phong, normal: Vec3, to_light: Vec3, to_viewer: Vec3) -> Vec3 {
        let cosine = normal.dot(to_light);
        let cosine = if self.makes(CosineAbsolute) { cosine.abs() } else { cosine };
        let diffuse = if self.makes(CosineNotClamped) { cosine } else { cosine.max(0.0) };
        let has_highlight = cosine > 0.0 || self.makes(HighlightsUngated);
        let highlight =
            if has_highlight { self.highlight(phong, normal, to_light, to_viewer) } else { Vec3::ZERO };
        diffuse * phong.diffuse.as_vec3() + highlight
    }

    fn highlight(&self, phong: &Phong, normal: Vec3, to_light: Vec3, to_viewer: Vec3) -> Vec3 {
        let cosine = normal.dot(to_light);
        let alignment = match () {
            _ if self.makes(HighlightsByReflection) => (2.0 * cosine * normal - to_light).dot(to_viewer),
            _ if self.makes(HighlightsByWrongReflection) => {
                (2.0 * cosine * (normal - to_light)).dot(to_viewer)
            }
            _ => (to_light + to_viewer).normalize().dot(normal),
        };
        let exponent = match phong.exponent as f32 {
            exponent if self.makes(ExponentQuartered) => exponent / 4.0,
            exponent if self.makes(ExponentHalved) => exponent / 2.0,
            exponent if self.makes(ExponentDoubled) => exponent * 2.0,
            exponent if self.makes(ExponentTimesFour) => exponent * 4.0,
            exponent => exponent,
        };
        let scale = match () {
            _ if self.makes(HighlightsNormalisedByTwo) => (exponent + 2.0) / (2.0 * PI),
            _ if self.makes(HighlightsNormalisedByEight) => (exponent + 8.0) / (8.0 * PI),
            _ => 1.0,
        };
        let color = match phong.specular.as_vec3() {
            _ if self.makes(HighlightsWithoutColor) => Vec3::ONE,
            color if self.makes(HighlightsWhite) && color != Vec3::ZERO => Vec3::ONE,
            color if self.makes(HighlightsTimesDiffuse) => color * phong.diffuse.as_vec3(),
            color => color,
        };
        scale * alignment.max(0.0).powf(exponent) * color
    }

    /// Returns a value of a material at a point. Textures mix the values of two other materials.
    fn mixed<T>(&self, material: usize, point: Vec3, value: &impl Fn(&Phong) -> T) -> T
    where
        T: Mul<f32, Output = T> + Add<Output = T>,
    {
        match &self.scene.materials[material] {
            Material::Phong(phong) | Material::Painted(phong, _) => value(phong),
            Material::Texture(texture) => {
                let weight = first_weight(texture, point, &self.mistakes);
                let [first, second] = texture.children.map(|child| self.mixed(child, point, value));
                first * weight + second * (1.0 - weight)
            }
        }
    }

    fn depth(&self, t: f32, [near, far]: [f32; 2]) -> Vec3 {
        let grey = (far - t.clamp(near, far)) / (far - near);
        Vec3::splat(if self.makes(DepthInverted) { 1.0 - grey } else { grey })
    }

    fn normal_color(&self, normal: Vec3) -> Vec3 {
        match () {
            _ if self.makes(NormalsHalved) => (normal + 1.0) / 2.0,
            _ if self.makes(NormalsClamped) => normal.max(Vec3::ZERO),
            _ => normal.abs(),
        }
    }

    /// Returns a colour as the picture shows it.
    fn shown(&self, color: Vec3) -> Vec3 {
        match () {
            _ if self.makes(GammaOfTwo) => color.max(Vec3::ZERO).powf(1.0 / 2.0),
            _ if self.makes(Gamma) => color.max(Vec3::ZERO).powf(1.0 / 2.2),
            _ if self.makes(ToneMapped) => color / (1.0 + color),
            _ => color,
        }
    }

    fn bytes(&self, color: Vec3) -> [u8; 3] {
        // The conversion to u8 truncates and clamps.
        let [red, green, blue] = color.to_array().map(|channel| match () {
            _ if self.makes(Rounded) => (255.0 * channel + 0.5) as u8,
            _ if self.makes(Times256) => (256.0 * channel) as u8,
            _ if self.makes(Wrapped) => (255.0 * channel) as i32 as u8,
            _ => (255.0 * channel) as u8,
        });
        if self.makes(RedAndBlueSwapped) { [blue, green, red] } else { [red, green, blue] }
    }
}

/// Returns the camera's direction, and the directions to the right and up.
fn axes(direction: Vec3, up: Vec3) -> [Vec3; 3] {
    let direction = direction.normalize();
    let right = direction.cross(up).normalize();
    [direction, right, right.cross(direction)]
}

fn reflected(direction: Vec3, normal: Vec3) -> Vec3 {
    (direction - 2.0 * direction.dot(normal) * normal).normalize()
}

/// Returns the direction of a refracted ray, or `None` at total internal reflection. The normal points against the
/// ray, and the ratio is the index in front of the surface over the one behind it.
fn refracted(direction: Vec3, normal: Vec3, ratio: f32) -> Option<Vec3> {
    let cosine = -direction.dot(normal);
    let squared = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    let along_normal = ratio * cosine - squared.sqrt();
    (squared >= 0.0).then(|| (along_normal * normal + ratio * direction).normalize())
}

/// Returns the text of a scene with other angles of rotations.
fn with_angles(text: &str, change: fn(f64) -> f64) -> String {
    let (mut changed, mut last) = (String::new(), "");
    for word in text.split_inclusive(char::is_whitespace) {
        match word.trim().parse() {
            Ok(angle) if ["XRotate", "YRotate", "ZRotate"].contains(&last) => {
                changed += &format!("{} ", change(angle))
            }
            _ => changed += word,
        }
        last = if word.trim().is_empty() { last } else { word.trim() };
    }
    changed
}
