//! Tracers without an epsilon: some rays hit the surface that they leave.

use super::{Case, named};
use crate::math::ray::Ray;
use crate::render::Request;
use crate::tools::causes::paint::paint;
use crate::tools::causes::student::{Departure, ObjectSpaces, Start, Student};
use crate::tools::causes::{Finding, Mistake, SelfHitting};
use crate::trace::{Effects, Shadows};
use crate::world::SurfacePoint;
use glam::{DVec2, DVec3};

/// Starts a ray on either side of the surface that it leaves, like the rounding of a tracer without an epsilon.
/// `density` is the share of rays on the wrong side.
fn rounded_start(
    density: f64,
    rays: SelfHitting,
    why: Departure,
    surface: &SurfacePoint,
    direction: DVec3,
) -> Option<Start> {
    let bits = (surface.position + 0.37 * direction).to_array().map(f64::to_bits);
    let hash = bits
        .iter()
        .fold(0_u64, |hash, bits| (hash ^ bits).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29));
    let random = (hash.wrapping_mul(0xd134_2543_de82_ef95) >> 11) as f64 / (1_u64 << 53) as f64;
    if why == Departure::Onwards || !why.is_one_of(rays) || random >= density {
        return None;
    }
    let side = -surface.normal.dot(direction).signum();
    Some((Ray::new(surface.position + 1e-7 * side * surface.normal, direction), None))
}

#[test]
fn speckles_are_known_at_any_density() {
    let shadows = Effects { shadows: Shadows::Opaque, ..Effects::default() };
    let mirrors = Effects { bounces: 2, ..Effects::default() };
    let picture = |effects| Request { effects, ..Request::new([96, 96]) };
    let rows = [
        ("scene6_03_sphere_plane.txt", shadows, SelfHitting::Shadow),
        ("scene4_02_colored_shadows.txt", shadows, SelfHitting::Shadow),
        ("scene6_11_mirrored_floor.txt", mirrors, SelfHitting::Secondary),
        ("scene7_05_glass_sphere.txt", Effects { shade_back: true, ..mirrors }, SelfHitting::Secondary),
        ("scene6_11_mirrored_floor.txt", Effects { bounces: 2, ..shadows }, SelfHitting::All),
    ];
    for (name, effects, rays) in rows {
        let case = Case::new(name, picture(effects));
        let original = case.original();
        let right = original.picture(Mistake::Unchanged).unwrap();
        let prepared = &original.prepared;
        // With glass, few pixels are away from edges.
        let least = if name.contains("glass") { 0.1 } else { 0.02 };
        for density in [least, 0.1, 0.3, 0.5, 0.7, 0.8, 0.95, 1.0] {
            let starts = |why, surface: &SurfacePoint, direction| {
                rounded_start(density, rays, why, surface, direction)
            };
            let spaces =
                &ObjectSpaces::new(&case.renderer.scene, case.renderer.meshes(), case.renderer.world());
            let student = Student::new(&case.renderer, prepared.caster(), effects, spaces);
            let student = Student { starts: Some(&starts), ..student };
            let camera = case.renderer.camera(&case.request);
            let color = |ray: &Ray| student.color(ray);
            let wrong = paint(&camera, &case.request, DVec2::ZERO, &color, &|| false).unwrap().to_picture();
            let found = original.explain(&wrong, &right);
            println!("{name} {rays:?} {density}: {found}");
            let is_known = match found {
                Finding::Speckles { .. } => true,
                _ => matches!(named(&found), Some(Mistake::NoEpsilon { .. } | Mistake::ReflectionFromBelow)),
            };
            assert!(is_known, "{name} {rays:?} {density}: {found}");
        }
    }
}
