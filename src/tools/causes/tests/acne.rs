//! Tracers without an epsilon: some rays hit the surface that they leave.

use super::{Case, named};
use crate::render::Request;
use crate::tools::causes::paint::colors;
use crate::tools::causes::student::Student;
use crate::tools::causes::{Finding, Mistake, SelfHitting};
use crate::trace::{Effects, Shadows};
use crate::world::SurfacePoint;
use glam::DVec3;
use rayon::prelude::*;

/// Lets a ray hit the surface that it leaves, like the rounding of a tracer without an epsilon. `density` is the share
/// of these rays.
fn hits_itself(density: f64, surface: &SurfacePoint, direction: DVec3) -> bool {
    let bits = (surface.position + 0.37 * direction).to_array().map(f64::to_bits);
    let hash = bits
        .iter()
        .fold(0_u64, |hash, bits| (hash ^ bits).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29));
    let random = (hash.wrapping_mul(0xd134_2543_de82_ef95) >> 11) as f64 / (1_u64 << 53) as f64;
    random < density
}

#[test]
fn speckles_are_known_at_any_density() {
    let shadows = Effects { shadows: Shadows::Opaque, ..Effects::default() };
    let mirrors = Effects { bounces: 2, ..Effects::default() };
    let rows = [
        ("scene6_03_sphere_plane.txt", shadows, SelfHitting::Shadow),
        ("scene4_02_colored_shadows.txt", shadows, SelfHitting::Shadow),
        ("scene6_11_mirrored_floor.txt", mirrors, SelfHitting::Secondary),
        ("scene7_05_glass_sphere.txt", Effects { shade_back: true, ..mirrors }, SelfHitting::Secondary),
        ("scene6_11_mirrored_floor.txt", Effects { bounces: 2, ..shadows }, SelfHitting::All),
    ];
    rows.into_par_iter().for_each(|(name, effects, rays)| {
        let case = Case::new(name, Request { effects, ..Request::new([96, 96]) });
        let original = case.original();
        let right = original.picture(Mistake::Unchanged).unwrap();
        // With glass, few pixels are away from edges.
        let least = if name.contains("glass") { 0.1 } else { 0.02 };
        let densities = [least, 0.3, 0.5, 0.7, 0.8, 0.95, 1.0];
        let wrong = densities.map(|density| {
            let hits_itself = |why, surface: &SurfacePoint, direction| {
                rays.has(why) && hits_itself(density, surface, direction)
            };
            let student = Student::new(&case.renderer, original.prepared.caster(), effects);
            let student = Student { hits_itself: Some(&hits_itself), ..student };
            colors(&student, &case.request, &|| false).unwrap().to_picture()
        });
        for (found, density) in original.explain_all_with(&wrong, &right, &[]).into_iter().zip(densities) {
            let is_known = match found {
                Finding::Speckles { .. } => true,
                _ => matches!(named(&found), Some(Mistake::NoEpsilon { .. } | Mistake::ReflectionFromBelow)),
            };
            assert!(is_known, "{name} {rays:?} {density}: {found}");
        }
    });
}
