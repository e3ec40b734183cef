//! Measures numerical error apart from sampling error. The same samples are traced by brute force in double precision
//! with exact decisions, by this program, and by a textbook's tracer in single precision.

mod brute_force;
mod single;

use super::plan::brute_force_tests;
use crate::base::patience::Patience;
use crate::math::ray::Ray;
use crate::picture::{BadSize, FloatPicture};
use crate::render::renderer::{Prepared, Renderer};
use crate::render::{Layer, Request, Window};
use crate::sampling::sampler::{Pattern, Sampler};
use crate::tools::causes::hits::Hits;
use crate::tools::causes::paint::Painter;
use crate::tools::causes::student::{MAX_BOUNCES, Student};
use brute_force::BruteForce;
use glam::DVec2;
use single::SinglePrecision;
use std::ops::ControlFlow;

/// The effect of rounding on the samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numerical {
    /// The size of the part of the picture traced, in pixels.
    pub size: [usize; 2],
    pub samples: u32,
    pub program: Deviation,
    /// The errors of a textbook's tracer in single precision.
    pub single: Deviation,
}

/// The differences of colours and hits from brute force.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// The number of bytes of the picture that differ.
    pub bytes: u64,
    /// The largest difference of a byte, in levels.
    pub largest: u8,
    /// The root mean square difference of the colours, in levels.
    pub error: f64,
    /// The number of camera rays that hit a different primitive.
    pub hits: u64,
}

/// The approximate largest number of ray-primitive tests made by each tracer.
const MOST_TESTS: f64 = 5e8;

/// Measures the samples of the request's picture, or of a window in its middle if brute force would take too long.
/// `None` if there are too many bounces for the recursion. The renderer must have kept the meshes. The result is
/// unspecified if the patience ends.
pub fn measure(
    renderer: &Renderer,
    prepared: &Prepared,
    request: &Request,
    patience: &dyn Patience,
) -> Result<Option<Numerical>, BadSize> {
    if request.effects.bounces > MAX_BOUNCES {
        return Ok(None);
    }
    let request = affordable(renderer, request);
    let world = renderer.world();
    let (brute_force, single) = (BruteForce { world }, SinglePrecision { world });
    let student = Student { patience, ..Student::new(renderer, &brute_force, request.effects) };
    let rough = Student { hits: &single, ..student };
    let [exact, rough] = [student, rough].map(|student| Painter::new(&student, &request, &[]).picture());
    let (exact, rough) = (exact?, rough?);
    let watch = |_| if patience.is_over() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let Ok((mut own, _)) = prepared.render_watched(&request, &watch) else { return Ok(None) };
    let own = own.remove(0);
    let Ok(caster) = prepared.caster(patience) else { return Ok(None) };
    let deviation_of = |picture, hits: &dyn Hits| Deviation {
        hits: other_hits(&student, &request, hits),
        ..deviation(picture, &exact)
    };
    let (program, single) = (deviation_of(&own, &caster), deviation_of(&rough, &single));
    Ok(Some(Numerical { size: exact.size, samples: request.sampler.count(), program, single }))
}

/// Returns the request with four samples per pixel. If that takes too long, uses one sample, or only a window in the
/// middle.
fn affordable(renderer: &Renderer, request: &Request) -> Request {
    let tests = |samples| brute_force_tests(renderer.world(), request, samples);
    let samples = if tests(4) <= MOST_TESTS { 4 } else { 1 };
    let share = (MOST_TESTS / tests(samples)).sqrt().min(1.0);
    let [width, height] = request.size.map(|side| ((side as f64 * share) as usize).max(1));
    let [x, y] = [(request.size[0] - width) / 2, (request.size[1] - height) / 2];
    Request {
        sampler: Sampler::new(Pattern::Jittered, samples, request.sampler.rng()),
        adaptive: None,
        window: Some(Window { x, y, width, height }),
        layers: vec![Layer::Color],
        ..request.clone()
    }
}

/// Compares two pictures. They must have the same size.
fn deviation(picture: &FloatPicture, exact: &FloatPicture) -> Deviation {
    let [bytes, expected] = [picture, exact].map(|picture| picture.to_bytes().0);
    let differences = bytes.iter().zip(&expected).map(|(a, b)| a.abs_diff(*b));
    let squares = picture.colors.iter().zip(&exact.colors).map(|(a, b)| {
        let difference = super::reference::shown(*a) - super::reference::shown(*b);
        difference.length_squared()
    });
    Deviation {
        bytes: differences.clone().filter(|&levels| levels > 0).count() as u64,
        largest: differences.max().unwrap_or(0),
        error: super::reference::levels(squares.sum(), picture),
        hits: 0,
    }
}

/// Returns the number of camera rays that hit other primitives than those of a student.
fn other_hits(student: &Student, request: &Request, other: &dyn Hits) -> u64 {
    use rayon::prelude::*;
    let camera = student.renderer.camera(request);
    let height = request.size[1];
    let differs = |ray: &Ray| {
        let exact = student.hits.nearest(ray, None).map(|visible| visible.primitive);
        !student.patience.is_over() && exact != other.nearest(ray, None).map(|visible| visible.primitive)
    };
    let of_column = |i: usize| {
        let rays = request.rows().flat_map(|j| {
            let pixel = DVec2::new(i as f64, j as f64);
            request.sampler.offsets((i * height + j) as u64).map(move |offset| (pixel, offset))
        });
        rays.filter(|&(pixel, offset)| differs(&camera.ray(pixel, offset))).count() as u64
    };
    request.columns().into_par_iter().map(of_column).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::patience::Endless;
    use crate::render::renderer::Meshes;
    use crate::scene::load::load;
    use crate::trace::{Effects, Shadows};
    use std::path::Path;

    fn measured(scene: &str, bounces: u32) -> Numerical {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene);
        let renderer = Renderer::new(load(&path).unwrap(), Meshes::Kept).unwrap();
        measured_by(&renderer, bounces)
    }

    fn measured_by(renderer: &Renderer, bounces: u32) -> Numerical {
        let effects = Effects { shadows: Shadows::Opaque, bounces, ..Effects::default() };
        let request = Request { effects, ..Request::new([24, 18]) };
        let prepared = renderer.prepare(&request).unwrap();
        measure(renderer, &prepared, &request, &Endless).unwrap().unwrap()
    }

    #[test]
    fn this_program_decides_as_brute_force_does_and_single_precision_does_not() {
        let mut single = 0.0;
        for (scene, bounces) in [
            ("scene6_04_bunny_mesh_200.txt", 0),
            ("scene6_10_nested_transformations.txt", 0),
            ("scene6_11_mirrored_floor.txt", 2),
            ("scene6_14_glass_sphere.txt", 3),
        ] {
            let Numerical { size, samples, program, single: rough } = measured(scene, bounces);
            assert_eq!((size, samples), ([24, 18], 4));
            assert_eq!((program.hits, program.bytes), (0, 0), "{scene}");
            assert!(program.error < 1e-9, "{scene}: {program:?}");
            assert!(rough.error > program.error && rough.error < 3.0, "{scene}: {rough:?}");
            single += rough.error;
        }
        assert!(single > 1e-3);
    }

    #[test]
    fn scenes_of_later_editions_mean_what_their_models_say() {
        for (scene, bounces) in [
            ("editions/screen_2012a4.txt", 0),
            ("editions/glass_2012a5.txt", 2),
            ("editions/mirrors_2019.txt", 2),
        ] {
            let Numerical { program, single: rough, .. } = measured(scene, bounces);
            assert_eq!((program.hits, program.bytes), (0, 0), "{scene}: {program:?}");
            // A flat surface, or another epsilon, would cause an error of many levels.
            assert!(rough.error < 0.5, "{scene}: {rough:?}");
        }
    }

    #[test]
    fn what_would_take_too_long_is_a_window_in_the_middle() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/scene6_05_bunny_mesh_1k.txt");
        let renderer = Renderer::new(load(&path).unwrap(), Meshes::Kept).unwrap();
        let request = affordable(&renderer, &Request::new([1000, 1000]));
        let window = request.window.unwrap();
        assert!(request.sampler.count() == 1 && window.width < 1000 && window.width == window.height);
        let rays = window.width * window.height * (1 + renderer.world().lights.len());
        assert!(rays as f64 * renderer.world().finite_count() as f64 <= MOST_TESTS);
    }
}
