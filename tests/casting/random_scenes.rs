//! Random small scenes: a grid of any resolution gives every ray the very hit that testing
//! everything gives, pictures are the same to the byte, and no colour, depth or normal is NaN. Some scenes
//! are ordinary, in others any number may be as small or as large as a scene allows.
//!
//! `PROPTEST_CASES` sets how many scenes are tried.

use super::strategies::{Range, meshes, rays, scene};
use glam::DVec3;
use proptest::prelude::*;
use raytracer::camera::Camera;
use raytracer::grid::options::{CellRule, GridOptions};
use raytracer::grid::{Caster, Instructions};
use raytracer::math::ray::{Hit, Ray};
use raytracer::math::robust::rescaled;
use raytracer::render::{Request, View, render};
use raytracer::sampling::{filter::Filter, sampler::Sampler};
use raytracer::scene::Scene;
use raytracer::stats::{Counts, Probe, Quiet};
use raytracer::trace::{Effects, Shadows};
use raytracer::world::World;

/// The same rays with their directions scaled by a power of two to a length of about one, as all of the
/// renderer's are.
fn of_unit_length(rays: Vec<Ray>) -> Vec<Ray> {
    rays.into_iter().map(|ray| Ray { direction: rescaled(ray.direction), ..ray }).collect()
}

/// The same rays aimed at what the world is made of, where decisions are close.
fn aimed(rays: &[Ray], world: &World) -> Vec<Ray> {
    let spheres = world.spheres.iter().map(|s| s.center + s.radius * DVec3::X);
    let targets: Vec<DVec3> = world.vertices.iter().copied().chain(spheres).collect();
    let aim = |(ray, i): (&Ray, usize)| {
        let direction = *targets.get(i % targets.len().max(1))? - ray.origin;
        (direction != DVec3::ZERO).then_some(Ray { direction, ..*ray })
    };
    rays.iter().zip(0..).filter_map(aim).collect()
}

/// The pictures of every effect, and how many of their colours are NaN.
fn pictures<P: Probe>(scene: &Scene, caster: &Caster) -> (Vec<u8>, u64) {
    let size = [12, 9];
    let effects = Effects { shadows: Shadows::Transparent, shade_back: true, bounces: 3, min_weight: 0.01 };
    let request = Request {
        size,
        view: View::Scene(effects),
        sampler: Sampler::CENTER,
        filter: Filter::PIXEL,
        color: true,
        depth: Some([0.5, 6.0]),
        normals: true,
        samples: None,
    };
    let camera = Camera::new(&scene.camera, size);
    let (pictures, _) = render::<P>(&camera, caster, &request).expect("a small picture");
    let all = [pictures.color, pictures.depth, pictures.normals];
    (all.into_iter().flatten().flat_map(|p| p.pixels().to_vec()).collect(), pictures.nans)
}

/// A ray's nearest hit; an error where asking for any hit says something else.
fn hit<P: Probe>(caster: &Caster, ray: &Ray) -> Result<Option<Hit>, TestCaseError> {
    let hit = caster.closest(ray, &mut P::default());
    prop_assert_eq!(hit.is_some(), caster.any(ray, &mut P::default()), "{:?}: any", ray);
    Ok(hit)
}

/// Whether every way to find hits finds the same in a scene, by these rays and in pictures.
fn check(scene: &Scene, rays: &[Ray], cells: [usize; 3]) -> Result<(), TestCaseError> {
    let Ok(world) = World::new(scene, &meshes()) else { return Ok(()) };
    let (fastest, portable) = (Instructions::available()[0], Instructions::Portable);
    let plain = Caster::new(&world, None).expect("no grid");
    // Nearly every cell is a crowd then.
    let nested = |options: GridOptions| GridOptions { rule: CellRule::Nested { max_per_cell: 2 }, ..options };
    let ways = [
        (GridOptions::uniform(cells), fastest),
        (GridOptions::uniform(cells), portable),
        (nested(GridOptions::uniform(cells.map(|n| n.div_ceil(3)))), fastest),
        (nested(GridOptions::automatic(&world, 1 << 20)), portable),
        (GridOptions::NONE, portable),
    ];
    let casters =
        ways.map(|(options, instructions)| Caster::with(&world, options, instructions).expect("small grids"));
    let rule = CellRule::Course { is_bounded: false };
    let counted = [None, Some(cells)]
        .map(|cells| Caster::with(&world, GridOptions { cells, rule }, fastest).expect("a small grid"));
    let aimed = aimed(rays, &world);
    for ray in rays.iter().chain(&of_unit_length(aimed)) {
        let expected = hit::<Quiet>(&plain, ray)?;
        prop_assert!(expected.is_none_or(|hit| hit.t.is_finite()), "{ray:?}: {expected:?}");
        for (caster, way) in casters.iter().zip(&ways) {
            let found = hit::<Quiet>(caster, ray)?;
            prop_assert!(found == expected, "{ray:?}: {way:?} {found:?}, without a grid {expected:?}");
        }
        for caster in &counted {
            let found = hit::<Counts>(caster, ray)?;
            prop_assert!(found == expected, "{ray:?}: counting {found:?}, without {expected:?}");
        }
    }
    let expected = pictures::<Quiet>(scene, &plain);
    prop_assert_eq!(expected.1, 0, "colours that are not numbers");
    for (caster, way) in casters.iter().zip(&ways) {
        prop_assert!(pictures::<Quiet>(scene, caster) == expected, "the pictures differ: {way:?}");
    }
    for caster in &counted {
        prop_assert!(pictures::<Counts>(scene, caster) == expected, "counting changes the pictures");
    }
    Ok(())
}

/// A few seconds' worth of scenes, where nobody asks for another number.
fn config(usual: u32) -> ProptestConfig {
    let default = ProptestConfig::default();
    let cases = if std::env::var_os("PROPTEST_CASES").is_some() { default.cases } else { usual };
    // Left to itself a failing case is made smaller for many minutes.
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
