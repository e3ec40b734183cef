//! Warns about scenes without lights, and about lights without effect.

use crate::diagnostic::{Diagnostic, Severity, limited};
use crate::picture::Color;
use crate::scene::{Light, Scene};
use crate::trace::{Effects, Shadows};
use crate::world::World;

/// Warns about a scene without lights, in the words of the course's program.
pub fn no_lights(scene: &Scene) -> Option<Diagnostic> {
    let warning = Diagnostic::warning("No lights specified");
    scene.lights.is_empty().then_some(Diagnostic { severity: Severity::CourseWarning, ..warning })
}

/// Warns about lights that have no effect on any picture of the scene.
pub fn lights_without_effect(scene: &Scene, world: &World, effects: &Effects) -> Vec<Diagnostic> {
    let warning = |(index, light): (usize, &Light)| {
        let (Light::Directional { color, .. } | Light::Point { color, .. }) = *light;
        let reason = match light {
            _ if color == Color::ZERO => "its colour is 0 0 0",
            Light::Point { attenuation, .. } if attenuation.iter().all(|&factor| factor <= 0.0) => {
                "its attenuation is above 0 at no distance"
            }
            _ if effects.shadows == Shadows::Opaque && !world.primitives_at_light(index).is_empty() => {
                "it lies on a surface, which shadows everything from it"
            }
            _ => return None,
        };
        let at = scene.positions.lights.get(index).copied().unwrap_or_default();
        Some(Diagnostic::warning(format!("the light has no effect: {reason}")).at(at))
    };
    limited(scene.lights.iter().enumerate().filter_map(warning).collect())
}
