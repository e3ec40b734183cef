//! Random small scenes: with a grid of any resolution every ray has the same hit as by testing every
//! primitive, pictures are identical to the byte, and no colour, depth or normal is NaN. Some scenes are
//! ordinary, and in others any number may be as small or as large as a scene allows.
//!
//! `PROPTEST_CASES` sets the number of scenes.

use super::fuzz_findings::checks::{bytes_and_nans, meshes};
use super::strategies::{Range, rays, scene};
use glam::DVec3;
use proptest::prelude::*;
use raytracer::caster::choose::Layout;
use raytracer::caster::{Caster, RayOrigin};
use raytracer::math::instructions::{self, Level};
use raytracer::math::ray::{Hit, Ray};
use raytracer::math::robust::rescaled;
use raytracer::render::Tracing;
use raytracer::scene::Scene;
use raytracer::world::World;

/// The same rays, with their directions scaled by a power of two to a length of about one, like those of the
/// renderer.
fn of_unit_length(rays: Vec<Ray>) -> Vec<Ray> {
    rays.into_iter().map(|ray| Ray { direction: rescaled(ray.direction), ..ray }).collect()
}

/// The same rays aimed at the world's vertices and primitives, where decisions are close.
fn aimed(rays: &[Ray], world: &World) -> Vec<Ray> {
    let shapes = world.boxes().map(|bounds| DVec3 { x: bounds.max.x, ..0.5 * (bounds.min + bounds.max) });
    let targets: Vec<DVec3> = world.vertices.iter().copied().chain(shapes).collect();
    let aim = |(ray, i): (&Ray, usize)| {
        let direction = *targets.get(i % targets.len().max(1))? - ray.origin;
        (direction != DVec3::ZERO).then_some(Ray { direction, ..*ray })
    };
    rays.iter().zip(0..).filter_map(aim).collect()
}

/// The bytes of every layer with every effect, and how many of their colours are not numbers.
fn pictures(scene: &Scene, caster: &Caster, tracing: Tracing) -> (Vec<u8>, u64) {
    bytes_and_nans(scene, caster, tracing, [12, 9], [0.5, 6.0])
}

/// A ray's nearest hit. An error if the query for any hit disagrees.
fn hit(caster: &Caster, ray: &Ray) -> Result<Option<Hit>, TestCaseError> {
    let hit = caster.closest(ray);
    prop_assert_eq!(hit.is_some(), caster.any(ray, RayOrigin::FREE), "{:?}: any", ray);
    Ok(hit)
}

/// Checks that all ways to find hits agree in a scene, for these rays and in pictures.
fn check(scene: &Scene, rays: &[Ray], cells: [usize; 3]) -> Result<(), TestCaseError> {
    let Ok(world) = World::new(scene, &meshes()) else { return Ok(()) };
    let (fastest, portable) = (instructions::available()[0], Level::baseline());
    let plain = Caster::new(&world, None).expect("no grid");
    let ways = [
        (Layout::Grid(cells), fastest),
        (Layout::Grid(cells), portable),
        (Layout::Tree, fastest),
        (Layout::Tree, portable),
        (Layout::List, portable),
    ];
    let casters = ways.map(|(layout, level)| Caster::with(&world, layout, level).expect("small grids"));
    let aimed = aimed(rays, &world);
    for ray in rays.iter().chain(&of_unit_length(aimed)) {
        let expected = hit(&plain, ray)?;
        prop_assert!(expected.is_none_or(|hit| hit.t.is_finite()), "{ray:?}: {expected:?}");
        for (caster, way) in casters.iter().zip(&ways) {
            let found = hit(caster, ray)?;
            prop_assert!(found == expected, "{ray:?}: {way:?} {found:?}, without a grid {expected:?}");
        }
    }
    let expected = pictures(scene, &plain, Tracing::Fast);
    prop_assert_eq!(expected.1, 0, "colours that are not numbers");
    for (caster, way) in casters.iter().zip(&ways) {
        prop_assert!(pictures(scene, caster, Tracing::Fast) == expected, "the pictures differ: {way:?}");
    }
    prop_assert!(pictures(scene, &plain, Tracing::Counted) == expected, "counting changes the pictures");
    Ok(())
}

/// A few seconds' worth of scenes, unless another number is requested.
fn config(usual: u32) -> ProptestConfig {
    let default = ProptestConfig::default();
    let cases = if std::env::var_os("PROPTEST_CASES").is_some() { default.cases } else { usual };
    // By default proptest would shrink a failing case for many minutes.
    ProptestConfig { cases, max_shrink_iters: 200, ..default }
}

fn cells() -> impl Strategy<Value = [usize; 3]> {
    [1..9usize, 1..9usize, 1..9usize]
}

proptest! {
    #![proptest_config(config(200))]

    #[test]
    fn a_grid_changes_nothing(scene in scene(Range::Ordinary), rays in rays(Range::Ordinary), cells in cells()) {
        prop_assert!(World::new(&scene, &meshes()).is_ok(), "its transforms are not singular");
        check(&scene, &rays, cells)?;
    }
}

proptest! {
    #![proptest_config(config(200))]

    #[test]
    fn a_grid_changes_nothing_at_any_scale(
        scene in scene(Range::Extreme),
        rays in rays(Range::Extreme),
        cells in cells(),
    ) {
        check(&scene, &of_unit_length(rays), cells)?;
    }
}
