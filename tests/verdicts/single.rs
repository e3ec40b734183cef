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

const REFLECTION: [Mistake; 4] =
    [ReflectionSquared, ReflectionTwice, ReflectionSubtracted, ReflectionBlended];
const REFRACTION: [Mistake; 4] =
    [RefractionSquared, RefractionTwice, RefractionSubtracted, RefractionBlended];

/// Renders a layer of a scene of the edition 2004 with these mistakes.
pub fn render(loaded: &LoadedScene, options: &Options, layer: Layer, mistakes: &[Mistake]) -> Picture {
    let tracer = Tracer::new(loaded, options.effects, mistakes);
    let [width, height] = options.size;
    let row = |j: usize| (0..width).map(|i| tracer.pixel([i, j], options.size, layer)).collect();
    let rows: Vec<Vec<Vec3>> = (0..height).into_par_iter().map(row).collect();
    let mut picture = Picture::new(width as u32, height as u32).unwrap();
    for (j, colors) in rows.iter().enumerate() {
        let j = tracer.pick(j, [(UpsideDown, height - 1 - j)]);
        let (pixels, _) = picture.row_mut(j).as_chunks_mut();
        for (i, &color) in colors.iter().enumerate() {
            pixels[tracer.pick(i, [(Mirrored, width - 1 - i)])] = tracer.bytes(color);
        }
    }
    picture
}

struct Tracer {
    scene: Scene,
    objects: Objects,
    effects: Effects,
    /// Hits of secondary rays nearer than this are ignored.
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
        // In a scene without lights all surfaces have their diffuse colour.
        let ambient = if scene.lights.is_empty() { Color::ONE } else { scene.background.ambient };
        scene.background.ambient = mistakes.pick(ambient, [(NoAmbient, Color::ZERO)]);
        if mistakes.has(LastLightMissing) {
            scene.lights.pop();
        }
        effects.shadows = mistakes.pick(effects.shadows, [(NoShadows, Shadows::None)]);
        let n = effects.bounces;
        effects.bounces = mistakes.pick(n, [(OneBounceMore, n + 1), (OneBounceFewer, n.saturating_sub(1))]);
        let objects = Objects::new(&scene, &loaded.meshes, mistakes);
        let epsilon = mistakes.pick(1e-4, [(EpsilonZero, 0.0), (EpsilonOfTenth, 0.1)]);
        Self { scene, objects, effects, epsilon, mistakes }
    }

    fn makes(&self, mistake: Mistake) -> bool {
        self.mistakes.has(mistake)
    }

    fn pick<T, const N: usize>(&self, right: T, wrong: [(Mistake, T); N]) -> T {
        self.mistakes.pick(right, wrong)
    }

    /// Returns the colour of the pixel in this column and row from the bottom left.
    fn pixel(&self, [i, j]: [usize; 2], size: [usize; 2], layer: Layer) -> Vec3 {
        let is_missing = self.makes(FirstRowMissing) && j == 0
            || self.makes(LastRowMissing) && j == size[1] - 1
            || self.makes(CornerMissing) && i == 0 && j == 0
            || self.makes(CornerBlockMissing) && i < 5 && j < 5;
        let (ray, t_min) = self.camera_ray([i, j].map(|n| n as f32), size.map(|n| n as f32));
        let hit = || self.objects.nearest(&ray, t_min, f32::INFINITY);
        match layer {
            _ if is_missing => Vec3::ZERO,
            Layer::Depth { near, far } => hit().map_or(Vec3::ZERO, |Hit { t, .. }| {
                let [near, far] = [near as f32, far as f32];
                let grey = (far - t.clamp(near, far)) / (far - near);
                Vec3::splat(self.pick(grey, [(DepthInverted, 1.0 - grey)]))
            }),
            Layer::Normals => hit().map_or(Vec3::ZERO, |Hit { normal: n, .. }| {
                self.pick(n.abs(), [(NormalsHalved, (n + 1.0) / 2.0), (NormalsClamped, n.max(Vec3::ZERO))])
            }),
            _ => {
                let color = self.color(&ray, t_min, Path { bounces: 0, weight: 1.0, index: 1.0 });
                let root = |gamma: f32| color.max(Vec3::ZERO).powf(1.0 / gamma);
                let mapped = color / (1.0 + color);
                self.pick(color, [(GammaOfTwo, root(2.0)), (Gamma, root(2.2)), (ToneMapped, mapped)])
            }
        }
    }

    /// Returns the ray through a pixel's centre, and its smallest t.
    fn camera_ray(&self, [i, j]: [f32; 2], [width, height]: [f32; 2]) -> (Ray, f32) {
        let over_last = [i * width / (width - 1.0), j * height / (height - 1.0)];
        let wrong = [(PixelsOverWidthMinusOne, over_last), (PixelCorners, [i, j])];
        let [x, y] = self.pick([i + 0.5, j + 0.5], wrong);
        let sides = self.pick([width.max(height); 2], [(SidesNotInProportion, [width, height])]);
        let zoom = self.pick(1.0, [(ViewLarger, 1.02)]);
        let [x, y] = [zoom * (x - width / 2.0) / sides[0], zoom * (y - height / 2.0) / sides[1]];
        let (Camera::Orthographic { center, direction, up, .. }
        | Camera::Perspective { center, direction, up, .. }) = self.scene.camera;
        let [center, direction, up] = [center, direction, up].map(|v| v.as_vec3());
        let direction = direction.normalize();
        let right = direction.cross(up).normalize();
        let offset = x * right + y * right.cross(direction);
        match self.scene.camera {
            Camera::Orthographic { size, .. } => {
                (Ray { origin: center + size as f32 * offset, direction }, f32::NEG_INFINITY)
            }
            Camera::Perspective { angle, .. } => {
                let half = (angle as f32).to_radians() / 2.0;
                let tan = |factor: f32| (factor * half).tan();
                let wrong = [(WholeAngle, tan(2.0)), (QuarterOfAngle, tan(0.5)), (AngleWithoutTangent, half)];
                let direction = (direction + 2.0 * self.pick(tan(1.0), wrong) * offset).normalize();
                (Ray { origin: center, direction }, 0.0)
            }
        }
    }

    /// Returns the colour along a ray.
    fn color(&self, ray: &Ray, t_min: f32, path: Path) -> Vec3 {
        let Some(hit) = self.objects.nearest(ray, t_min, f32::INFINITY) else {
            let is_black = self.makes(BackgroundBlack) && path.bounces > 0;
            return if is_black { Vec3::ZERO } else { self.scene.background.color.as_vec3() };
        };
        let origin = ray.at(hit.t);
        let color = self.local_color(ray, &hit, origin);
        if path.bounces == self.effects.bounces {
            return color;
        }
        let reflective = self.mixed(hit.material, origin, &|phong| phong.reflective.as_vec3());
        let direction = reflected(ray.direction, hit.normal);
        let color = self.with_secondary(color, &Ray { origin, direction }, reflective, path, REFLECTION);
        let transparent = self.mixed(hit.material, origin, &|phong| phong.transparent.as_vec3());
        let index = |phong: &Phong| Vec3::splat(phong.index_of_refraction as f32);
        let inside = self.mixed(hit.material, origin, &index).x;
        match self.refracted(ray.direction, hit.normal, [path.index, inside]) {
            None => color,
            Some((direction, index)) => {
                let (ray, path) = (Ray { origin, direction }, Path { index, ..path });
                self.with_secondary(color, &ray, transparent, path, REFRACTION)
            }
        }
    }

    /// Adds k times the colour along a secondary ray, unless the ray's weight is too small.
    fn with_secondary(&self, local: Vec3, ray: &Ray, k: Vec3, path: Path, mistakes: [Mistake; 4]) -> Vec3 {
        let weight = path.weight * k.length();
        if weight <= self.effects.min_weight as f32 {
            return local;
        }
        let seen = self.color(ray, self.epsilon, Path { bounces: path.bounces + 1, weight, ..path });
        let [squared, twice, subtracted, blended] = mistakes;
        let local = self.pick(local, [(blended, (1.0 - k) * local)]);
        local + self.pick(k, [(squared, k * k), (twice, 2.0 * k), (subtracted, -k)]) * seen
    }

    /// Returns the direction of the refracted ray, and the index of refraction around it. Returns `None` at total
    /// internal reflection.
    fn refracted(&self, direction: Vec3, normal: Vec3, [index, inside]: [f32; 2]) -> Option<(Vec3, f32)> {
        let is_entering = direction.dot(normal) < 0.0;
        let (normal, behind) = if is_entering { (normal, inside) } else { (-normal, 1.0) };
        let wrong = [(RefractionIndicesSwapped, behind / index), (RefractionFromOutsideOnly, 1.0 / inside)];
        let ratio = self.pick(index / behind, wrong);
        let cosine = -direction.dot(normal);
        let squared = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
        if self.makes(RefractionStraight) {
            Some((direction, behind))
        } else if squared >= 0.0 {
            let bent = (ratio * cosine - squared.sqrt()) * normal + ratio * direction;
            Some((bent.normalize(), behind))
        } else {
            self.makes(TotalReflectionMirrored).then(|| (reflected(direction, normal), index))
        }
    }

    /// Returns the light that a surface itself reflects.
    fn local_color(&self, ray: &Ray, hit: &Hit, point: Vec3) -> Vec3 {
        let is_inside = hit.normal.dot(ray.direction) > 0.0;
        if is_inside && !self.effects.shade_back {
            return Vec3::ZERO;
        }
        let normal = if is_inside { -hit.normal } else { hit.normal };
        let diffuse = self.mixed(hit.material, point, &|phong| phong.diffuse.as_vec3());
        let mut color = self.scene.background.ambient.as_vec3() * diffuse;
        let lights: Vec<_> = self.scene.lights.iter().map(|light| self.incident(light, point)).collect();
        let is_blocked = |light: &Incident| self.is_blocked(light, point, normal);
        let are_all_blocked = self.makes(ShadowsOfAnyLight) && lights.iter().any(is_blocked);
        for (index, light) in lights.iter().enumerate() {
            let has_shadows = index == 0 || !self.makes(ShadowsOfFirstLight);
            let is_dark = are_all_blocked || has_shadows && is_blocked(light);
            let passed = if is_dark { self.pick(0.0, [(ShadowsHalve, 0.5)]) } else { 1.0 };
            let reflect = |phong: &Phong| self.reflect(phong, normal, light.direction, -ray.direction);
            let reflected = passed * light.color * self.mixed(hit.material, point, &reflect);
            if passed > 0.0 {
                color = self.pick(color + reflected, [(LightsOverwritten, reflected)]);
            }
        }
        color
    }

    fn incident(&self, light: &Light, point: Vec3) -> Incident {
        let (Light::Directional { color, .. } | Light::Point { color, .. }) = *light;
        let color = self.pick(1.0, [(LightsDimmer, 0.99)]) * color.as_vec3();
        match *light {
            Light::Directional { direction, .. } => {
                Incident { direction: -direction.as_vec3().normalize(), distance: f32::INFINITY, color }
            }
            Light::Point { position, attenuation, .. } => {
                let to_light = position.as_vec3() - point;
                let d = to_light.length();
                let [a, b, c] = attenuation.map(|coefficient| coefficient as f32);
                let [a, b, c] = self.pick([a, b, c], [(AttenuationReversed, [c, b, a])]);
                let falloff = a + b * d + c * self.pick(d * d, [(AttenuationByDistance, d)]);
                let factor = if falloff > 0.0 { 1.0 / falloff } else { 0.0 };
                let factor = self.pick(factor, [(AttenuationTwice, factor * factor)]);
                Incident { direction: to_light / d, distance: d, color: factor * color }
            }
        }
    }

    /// Returns true if an object is between the point and the light.
    fn is_blocked(&self, light: &Incident, point: Vec3, normal: Vec3) -> bool {
        let biased = |bias: f32| (point + bias * normal, 0.0);
        let wrong = [(ShadowBiasOfHundredth, biased(0.01)), (ShadowBiasOfTenth, biased(0.1))];
        let (origin, t_min) = self.pick((point, self.epsilon), wrong);
        let ray = Ray { origin, direction: light.direction };
        self.effects.shadows != Shadows::None && self.objects.nearest(&ray, t_min, light.distance).is_some()
    }

    /// Returns the part of the light that a material reflects to the viewer, by Blinn's model.
    fn reflect(&self, phong: &Phong, normal: Vec3, to_light: Vec3, to_viewer: Vec3) -> Vec3 {
        let cosine = normal.dot(to_light);
        let cosine = self.pick(cosine, [(CosineAbsolute, cosine.abs())]);
        let [diffuse, specular] = [phong.diffuse.as_vec3(), phong.specular.as_vec3()];
        let scattered = self.pick(cosine.max(0.0), [(CosineNotClamped, cosine)]) * diffuse;
        if cosine <= 0.0 && !self.makes(HighlightsUngated) {
            return scattered;
        }
        // Compute the cosine of the highlight.
        let by_half_way = normal.dot((to_light + to_viewer).normalize());
        let by_mirror = (2.0 * cosine * normal - to_light).dot(to_viewer);
        let by_wrong = (2.0 * cosine * (normal - to_light)).dot(to_viewer);
        let wrong = [(HighlightsByReflection, by_mirror), (HighlightsByWrongReflection, by_wrong)];
        let alignment = self.pick(by_half_way, wrong).max(0.0);
        // Compute its exponent.
        let larger = self.pick(1.0, [(ExponentDoubled, 2.0), (ExponentTimesFour, 4.0)]);
        let n = larger * phong.exponent as f32;
        let n = self.pick(n, [(ExponentQuartered, n / 4.0), (ExponentHalved, n / 2.0)]);
        // Compute its colour.
        let [by_two, by_eight] = [(n + 2.0) / (2.0 * PI), (n + 8.0) / (8.0 * PI)];
        let normalised = [(HighlightsNormalisedByTwo, by_two), (HighlightsNormalisedByEight, by_eight)];
        let white = if specular == Vec3::ZERO { Vec3::ZERO } else { Vec3::ONE };
        let wrong = [(HighlightsWhite, white), (HighlightsTimesDiffuse, specular * diffuse)];
        let color = self.pick(self.pick(specular, wrong), [(HighlightsWithoutColor, Vec3::ONE)]);
        scattered + self.pick(1.0, normalised) * alignment.powf(n) * color
    }

    /// Returns a value of a material at a point. Textures mix the values of two other materials.
    fn mixed(&self, material: usize, point: Vec3, value: &dyn Fn(&Phong) -> Vec3) -> Vec3 {
        match &self.scene.materials[material] {
            Material::Phong(phong) | Material::Painted(phong, _) => value(phong),
            Material::Texture(texture) => {
                let weight = first_weight(texture, point, &self.mistakes);
                let [first, second] = texture.children.map(|child| self.mixed(child, point, value));
                first * weight + second * (1.0 - weight)
            }
        }
    }

    /// Converts a colour to bytes. The conversion to `u8` truncates and clamps.
    fn bytes(&self, color: Vec3) -> [u8; 3] {
        let [red, green, blue] = color.to_array().map(|channel| {
            let level = 255.0 * channel;
            let [rounded, higher, wrapped] = [level + 0.5, 256.0 * channel, level.trunc().rem_euclid(256.0)];
            let level = self.pick(level, [(Rounded, rounded), (Times256, higher), (Wrapped, wrapped)]);
            level as u8
        });
        self.pick([red, green, blue], [(RedAndBlueSwapped, [blue, green, red])])
    }
}

fn reflected(direction: Vec3, normal: Vec3) -> Vec3 {
    (direction - 2.0 * direction.dot(normal) * normal).normalize()
}

/// Returns the text of a scene, which has no comments, with other angles of rotations.
fn with_angles(text: &str, change: fn(f64) -> f64) -> String {
    let mut last = "";
    let words = text.split_whitespace().map(|word| {
        let is_angle = ["XRotate", "YRotate", "ZRotate"].contains(&std::mem::replace(&mut last, word));
        if is_angle { change(word.parse().unwrap()).to_string() } else { word.to_owned() }
    });
    words.collect::<Vec<_>>().join(" ")
}
