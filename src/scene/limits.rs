//! The ranges of a scene's numbers that guarantee results without overflow or NaN.
//!
//! Geometry multiplies up to three coordinates, and the inverse of a radius. Shading multiplies the colours of lights
//! and materials along the path of secondary rays and shadows. Within these limits all products stay below the largest
//! f64.

use super::material::{Material, Paint};
use super::{Camera, Light, Scene};
use crate::diagnostic::Diagnostic;
use crate::picture::Color;
use glam::DVec3;

/// The largest magnitude of a number in a scene, and of a coordinate in world space.
pub const LARGEST: f64 = 1e100;

/// The smallest radius of a sphere, or semi-axis of an ellipsoid, in world space.
pub const SMALLEST_RADIUS: f64 = 1e-100;

/// The largest magnitude of a colour channel.
pub const BRIGHTEST: f64 = 1e30;

/// Returns true if the magnitudes of all coordinates are at most [`LARGEST`]. A NaN is out of range.
pub fn are_in_range(coordinates: DVec3) -> bool {
    coordinates.abs().cmple(DVec3::splat(LARGEST)).all()
}

fn is_color(color: Color) -> bool {
    color.abs().cmple(DVec3::splat(BRIGHTEST)).all()
}

fn is_in_range(number: f64) -> bool {
    number.abs() <= LARGEST
}

/// Checks the numbers of the camera, lights, background and materials of a scene built by a program. The reader rejects
/// such numbers in text. Objects are checked when they are placed in the world.
pub fn check(scene: &Scene) -> Result<(), Diagnostic> {
    let (Camera::Orthographic { center, direction, up, size: screen }
    | Camera::Perspective { center, direction, up, angle: screen }) = scene.camera;
    // The lengths of `direction` and `up` do not matter, because both are normalised.
    let is_valid = are_in_range(center)
        && direction.is_finite()
        && up.is_finite()
        && is_in_range(screen)
        && is_color(scene.background.color)
        && is_color(scene.background.ambient)
        && scene.lights.iter().all(is_light)
        && scene.materials.iter().all(is_material);
    if is_valid { Ok(()) } else { Err(Diagnostic::error("a number in the scene is out of range")) }
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
    let (phong, paint) = match material {
        Material::Texture(texture) => return texture.world_to_texture.is_finite(),
        Material::Phong(phong) => (phong, None),
        Material::Painted(phong, paint) => (phong, Some(paint)),
    };
    let mut colors = vec![phong.diffuse, phong.specular, phong.reflective, phong.transparent];
    if let Some(Paint::Pattern(_, painted)) = paint {
        colors.extend(painted);
    }
    colors.into_iter().all(is_color)
        && (0.0..=LARGEST).contains(&phong.exponent)
        && phong.index_of_refraction > 0.0
        && is_in_range(phong.index_of_refraction)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rounded::RoundedAffine;
    use crate::scene::material::{Pattern, Phong, Texture};
    use crate::scene::parser::parse;

    /// Returns a scene with both kinds of lights and of materials.
    fn scene(camera: &str) -> Scene {
        let text = format!(
            "{camera} Background {{ color 0 0 0 ambientLight 0 0 0 }}
             Lights {{ numLights 2 DirectionalLight {{ direction 0 0 -1 color 1 1 1 }}
             PointLight {{ position 0 0 1 color 1 1 1 attenuation 1 0 0 }} }}
             Materials {{ numMaterials 2 Material {{ }}
             Noise {{ materialIndex 0 materialIndex 0 octaves 2 }} }} Group {{ numObjects 0 }}"
        );
        parse(&text).unwrap()
    }

    fn orthographic() -> Scene {
        scene("OrthographicCamera { center 0 0 1 direction 0 0 -1 up 0 1 0 size 2 }")
    }

    /// Asserts that the scene after `change` is rejected for every number in `refused` and valid for every number in
    /// `accepted`.
    fn check_number(change: impl Fn(&mut Scene, f64), refused: &[f64], accepted: &[f64]) {
        let is_valid = |number: f64| {
            let mut scene = orthographic();
            change(&mut scene, number);
            check(&scene).is_ok()
        };
        assert!(refused.iter().all(|&number| !is_valid(number)), "{refused:?}");
        assert!(accepted.iter().all(|&number| is_valid(number)), "{accepted:?}");
    }

    fn change_phong(scene: &mut Scene, change: impl Fn(&mut Phong)) {
        match &mut scene.materials[0] {
            Material::Phong(phong) => change(phong),
            Material::Texture(_) | Material::Painted(..) => unreachable!(),
        }
    }

    /// Returns numbers just above `bound`, infinities and a NaN.
    fn refused(bound: f64) -> [f64; 5] {
        [bound.next_up(), -bound.next_up(), f64::INFINITY, f64::NEG_INFINITY, f64::NAN]
    }

    #[test]
    fn cameras_are_refused_for_each_number_out_of_range() {
        let perspective = scene("PerspectiveCamera { center 0 0 1 direction 0 0 -1 up 0 1 0 angle 50 }");
        for base in [orthographic(), perspective] {
            let changed = |change: fn(&mut DVec3, &mut DVec3, &mut DVec3, &mut f64, f64), number: f64| {
                let mut scene = base.clone();
                match &mut scene.camera {
                    Camera::Orthographic { center, direction, up, size: screen }
                    | Camera::Perspective { center, direction, up, angle: screen } => {
                        change(center, direction, up, screen, number);
                    }
                }
                check(&scene).is_ok()
            };
            let coordinates = refused(LARGEST).map(|x| {
                [changed(|center, _, _, _, x| center.y = x, x), changed(|_, _, _, screen, x| *screen = x, x)]
            });
            assert_eq!(coordinates, [[false; 2]; 5]);
            assert!(changed(|center, _, _, screen, x| (center.y, *screen) = (-x, x), LARGEST));
            let vectors = [f64::INFINITY, f64::NAN].map(|x| {
                [changed(|_, direction, _, _, x| direction.z = x, x), changed(|_, _, up, _, x| up.z = x, x)]
            });
            assert_eq!(vectors, [[false; 2]; 2]);
            assert!(changed(|_, direction, up, _, x| (direction.x, up.z) = (x, x), f64::MAX));
        }
    }

    #[test]
    fn lights_and_backgrounds_are_refused_for_each_number_out_of_range() {
        let colors = [BRIGHTEST, -BRIGHTEST];
        check_number(|scene, x| scene.background.color.x = x, &refused(BRIGHTEST), &colors);
        check_number(|scene, x| scene.background.ambient.y = x, &refused(BRIGHTEST), &colors);
        for light in 0..2 {
            let change = |scene: &mut Scene, x: f64| {
                let (Light::Directional { color, .. } | Light::Point { color, .. }) =
                    &mut scene.lights[light];
                color.z = x;
            };
            check_number(change, &refused(BRIGHTEST), &colors);
        }
        let change = |scene: &mut Scene, x: f64| match &mut scene.lights[0] {
            Light::Directional { direction, .. } => direction.y = x,
            Light::Point { .. } => unreachable!(),
        };
        check_number(change, &[f64::INFINITY, f64::NAN], &[f64::MAX]);
        for number in 0..4 {
            let change = |scene: &mut Scene, x: f64| match &mut scene.lights[1] {
                Light::Point { position, .. } if number == 3 => position.y = x,
                Light::Point { attenuation, .. } => attenuation[number] = x,
                Light::Directional { .. } => unreachable!(),
            };
            check_number(change, &refused(LARGEST), &[LARGEST, -LARGEST]);
        }
    }

    #[test]
    fn materials_are_refused_for_each_number_out_of_range() {
        for color in 0..4 {
            let change = |scene: &mut Scene, x: f64| {
                change_phong(scene, |phong| {
                    let Phong { diffuse, specular, reflective, transparent, .. } = phong;
                    [diffuse, specular, reflective, transparent][color].y = x;
                });
            };
            check_number(change, &refused(BRIGHTEST), &[BRIGHTEST, -BRIGHTEST]);
        }
        let change = |scene: &mut Scene, x: f64| change_phong(scene, |phong| phong.exponent = x);
        check_number(change, &[LARGEST.next_up(), -1e-300, f64::NAN], &[0.0, LARGEST]);
        let change = |scene: &mut Scene, x: f64| change_phong(scene, |phong| phong.index_of_refraction = x);
        check_number(change, &[LARGEST.next_up(), 0.0, -1.0, f64::NAN], &[5e-324, LARGEST]);
        let change = |scene: &mut Scene, x: f64| {
            let mut world_to_texture = RoundedAffine::IDENTITY;
            world_to_texture.map.translation.z = x;
            let (pattern, children) = (Pattern::Checkerboard, [0; 2]);
            scene.materials[1] =
                Material::Texture(Texture { pattern, world_to_texture, factors: Box::default(), children });
        };
        check_number(change, &[f64::INFINITY, f64::NAN], &[f64::MAX]);
    }
}
