//! Small pictures: windows, strips, and renders that end early.

mod layers;

use super::*;
use crate::camera::Camera;
use crate::caster::choose::Layout;
use crate::caster::{Caster, LazyCaster};
use crate::render::adaptive::Adaptive;
use crate::sampling::drand48::Drand48;
use crate::sampling::filter::Filter;
use crate::sampling::sampler::{Pattern, Sampler};
use crate::scene::parser::parse;
use crate::world::World;
use std::sync::Mutex;

/// Returns the text of a scene with a tetrahedron's faces in front of a floor, seen in perspective, and the object
/// `other` if it is not empty.
fn scene(other: &str) -> String {
    let count = 4 + usize::from(!other.is_empty());
    format!(
        "PerspectiveCamera {{ center 0.1 0.4 4 direction 0 -0.1 -1 up 0 1 0 angle 40 }}
         Background {{ color 0.2 0.1 0.3 ambientLight 0.1 0.1 0.1 }}
         Lights {{ numLights 2 DirectionalLight {{ direction -1 -2 -1 color 0.9 0.8 0.7 }}
         PointLight {{ position 1 2 3 color 0.5 0.6 0.9 attenuation 0.3 0.2 0.1 }} }}
         Materials {{ numMaterials 2 Material {{ diffuseColor 1 0.5 0.2 specularColor 1 1 1 exponent 9 }}
         Material {{ diffuseColor 0.2 0.5 1 }} }}
         Group {{ numObjects {count} MaterialIndex 0
         Triangle {{ vertex0 -1 -0.5 0 vertex1 0.2 -0.4 1 vertex2 0 1 0 }}
         Triangle {{ vertex0 0.2 -0.4 1 vertex1 1 -0.6 0 vertex2 0 1 0 }} MaterialIndex 1
         Triangle {{ vertex0 -0.9 0.3 -1 vertex1 0.9 0.7 -1 vertex2 0.1 1.2 0.5 }}
         Plane {{ normal 0 1 0.02 offset -0.5 }} {other} }}"
    )
}

const SPHERE: &str = "Sphere { center 0.8 0.2 0.6 radius 0.4 }";

fn jittered(count: u32) -> Sampler {
    Sampler::new(Pattern::Jittered, count, Drand48::UNSEEDED)
}

/// The output of a render: its result, and the layer and the colours of each row.
type HandedOut = (Result<Counts, Stopped>, Vec<(usize, Vec<Color>)>);

/// Renders a scene on one thread, so that the heights of strips are the same on every machine.
fn render_scene(
    text: &str,
    request: &Request,
    tracing: Tracing,
    watch: Watch,
    take_row: TakeRow,
) -> Result<Counts, Stopped> {
    let scene = parse(text).unwrap();
    let world = World::new(&scene, &[]).unwrap();
    let caster = LazyCaster::new(Caster::of_planes(&world), Layout::List);
    let shot = Shot { camera: Camera::new(&scene.camera, request.size), caster: &caster, view: View::Scene };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let request = &Request { tracing, ..request.clone() };
    pool.install(|| render(&shot, request, watch, take_row)).map(|all| all.counts)
}

fn goes_on(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// The error of a callback that takes no more rows.
fn refusal() -> Diagnostic {
    Diagnostic::error("not taken").with_hint("kept")
}

/// Returns all rows of a render, until `fails_at` rows have been taken.
fn rows(text: &str, request: &Request, tracing: Tracing, fails_at: usize) -> HandedOut {
    let mut rows = vec![];
    let mut take_row = |layer: usize, colors: &[Color]| {
        rows.push((layer, colors.to_vec()));
        if rows.len() == fails_at { Err(refusal()) } else { Ok(()) }
    };
    let result = render_scene(text, request, tracing, &goes_on, &mut take_row);
    (result, rows)
}

/// Marks a request whose samples are adaptive. [`further`] returns the settings.
const ADAPTIVE: Sampler = Sampler::of_adaptive(Drand48::UNSEEDED);

fn further(sampler: Sampler) -> Option<Adaptive> {
    (sampler == ADAPTIVE).then_some(Adaptive { most: 40, error: 2.0 })
}

#[test]
fn a_window_without_pixels_is_refused() {
    let request = |layer, window| Request { layers: vec![layer], window, ..Request::new([5, 4]) };
    let text = parse(&scene("")).unwrap();
    let world = World::new(&text, &[]).unwrap();
    let caster = &LazyCaster::new(Caster::of_planes(&world), Layout::List);
    for (layer, size) in [(Layer::Color, [0, 2]), (Layer::Samples { zoom: 7 }, [0, 14])] {
        let request = request(layer, Some(Window { x: 5, y: 1, width: 3, height: 2 }));
        let shot = Shot { camera: Camera::new(&text.camera, request.size), caster, view: View::Scene };
        let result = render_in_memory(&shot, &request, &goes_on);
        assert_eq!(result.err(), Some(Stopped::Size(BadSize { width: size[0], height: size[1] })));
    }
}

/// A layer of samples so large that eight rows of pixels fill the memory of a strip.
const LARGE: Layer = Layer::Samples { zoom: 78 };
const LARGE_SIZE: [usize; 2] = [40, 20];
const STRIP_ROWS: usize = 8;

/// Returns the FNV-1a hash over the bits of the colours.
fn hash(row: &[Color]) -> u64 {
    let bits = row.iter().flat_map(|color| color.to_array().map(f64::to_bits));
    bits.fold(0xCBF2_9CE4_8422_2325, |hash, bits| (hash ^ bits).wrapping_mul(0x100_0000_01B3))
}

/// Returns the hashes of the rows of two layers.
fn hashes(request: &Request) -> [Vec<u64>; 2] {
    let mut hashes = [vec![], vec![]];
    let mut take_row = |layer: usize, row: &[Color]| {
        hashes[layer].push(hash(row));
        Ok(())
    };
    render_scene(&scene(SPHERE), request, Tracing::Fast, &goes_on, &mut take_row).unwrap();
    hashes
}

#[test]
fn strips_of_several_rows_make_the_picture_of_strips_of_one_row() {
    for (sampler, filter) in [
        (Sampler::CENTER, Filter::PIXEL),
        (jittered(2), Filter::PIXEL),
        (jittered(2), Filter::Tent { radius: 1.4 }),
        (ADAPTIVE, Filter::PIXEL),
        (ADAPTIVE, Filter::Tent { radius: 1.4 }),
    ] {
        let (adaptive, layers) = (further(sampler), vec![Layer::Color, LARGE]);
        let whole = Request { sampler, adaptive, filter, layers, ..Request::new(LARGE_SIZE) };
        let mut row_by_row = [vec![], vec![]];
        for y in 0..LARGE_SIZE[1] {
            let window = Window { x: 0, y, width: LARGE_SIZE[0], height: 1 };
            let row = hashes(&Request { window: Some(window), ..whole.clone() });
            row_by_row.iter_mut().zip(row).for_each(|(all, row)| all.extend(row));
        }
        assert_eq!(row_by_row.each_ref().map(Vec::len), [LARGE_SIZE[1], 78 * LARGE_SIZE[1]]);
        assert!(hashes(&whole) == row_by_row, "{sampler:?} {filter:?}");
    }
}

#[test]
fn the_watch_is_told_of_each_row_and_ends_the_render_after_whole_strips() {
    let request = Request {
        filter: Filter::Tent { radius: 1.4 },
        layers: vec![LARGE, Layer::Color],
        ..Request::new(LARGE_SIZE)
    };
    for (last, handed_out) in [(1, 0), (7, 0), (9, STRIP_ROWS), (17, 2 * STRIP_ROWS), (20, 20), (21, 20)] {
        let told = Mutex::new(vec![]);
        let watch = |progress: Progress| {
            told.lock().unwrap().push(progress);
            if progress.done == last { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let mut taken = 0;
        let mut take_row = |layer: usize, _: &[Color]| {
            taken += layer;
            Ok(())
        };
        let result = render_scene(&scene(""), &request, Tracing::Fast, &watch, &mut take_row);
        let expected = (handed_out < LARGE_SIZE[1]).then_some(Stopped::Cancelled { rows: handed_out });
        assert_eq!((result.err(), taken), (expected, handed_out), "{last}");
        let expected: Vec<_> = (1..=last.min(LARGE_SIZE[1]))
            .map(|done| Progress { done, rows: LARGE_SIZE[1], rays: (done * LARGE_SIZE[0]) as u64 })
            .collect();
        // Long work within a row asks the watch, too.
        let mut told = told.into_inner().unwrap();
        told.retain(|progress| progress.done > 0);
        told.dedup();
        assert_eq!(told, expected);
    }
}

#[test]
fn the_watch_ends_a_long_row_before_its_end() {
    for tracing in [Tracing::Fast, Tracing::Counted] {
        let layers = vec![Layer::Color];
        let request = Request { sampler: jittered(1024), layers, ..Request::new([64, 1]) };
        let asked = Mutex::new(vec![]);
        let watch = |progress: Progress| {
            asked.lock().unwrap().push(progress.done);
            ControlFlow::Break(())
        };
        let result = render_scene(&scene(""), &request, tracing, &watch, &mut |_, _| Ok(()));
        assert_eq!(
            (result.err(), asked.into_inner().unwrap()),
            (Some(Stopped::Cancelled { rows: 0 }), vec![0])
        );
    }
}

/// Covers a picture whose samples contribute to their own rows only.
#[test]
fn rows_that_need_no_others_are_handed_out_as_far_as_they_are_done() {
    let request = Request { layers: vec![Layer::Color], ..Request::new([3, 150]) };
    for last in [1, 63, 64, 65, 129] {
        let watch = |progress: Progress| {
            if progress.done >= last { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let mut taken = 0;
        let mut take_row = |_: usize, _: &[Color]| {
            taken += 1;
            Ok(())
        };
        let result = render_scene(&scene(""), &request, Tracing::Fast, &watch, &mut take_row);
        // Rows in flight are finished.
        assert!((last..last + rayon::current_num_threads()).contains(&taken), "{last} {taken}");
        assert_eq!(result.err(), Some(Stopped::Cancelled { rows: taken }), "{last}");
    }
}

#[test]
fn a_row_that_is_not_taken_ends_the_render() {
    let layers = vec![Layer::Samples { zoom: 2 }, Layer::Filter { zoom: 2 }, Layer::Color];
    let request = Request { layers, ..Request::new([3, 4]) };
    // The seven columns and nine rows of the filter come first, then the layers of each row of pixels.
    let order: Vec<usize> = [vec![1; 9], [0, 0, 2].repeat(4)].concat();
    let order_of = |rows: &[(usize, Vec<Color>)]| rows.iter().map(|(layer, _)| *layer).collect::<Vec<_>>();
    let (result, all) = rows(&scene(""), &request, Tracing::Fast, usize::MAX);
    assert!(result.is_ok());
    assert_eq!(order_of(&all), order);
    assert_eq!(
        all.iter().map(|(_, row)| row.len()).collect::<Vec<_>>(),
        [vec![7; 9], [6, 6, 3].repeat(4)].concat()
    );
    for count in 1..=order.len() {
        let (result, taken) = rows(&scene(""), &request, Tracing::Fast, count);
        assert_eq!(result.map_err(Diagnostic::from), Err(refusal()));
        assert_eq!(taken, all[..count]);
    }
}

#[test]
fn the_counts_of_every_strip_are_added_up_once() {
    for (sampler, filter, samples) in
        [(Sampler::CENTER, Filter::PIXEL, 1), (jittered(3), Filter::Tent { radius: 1.4 }, 3)]
    {
        let request = Request { sampler, filter, layers: vec![Layer::Color], ..Request::new([40, 30]) };
        let (result, _) = rows(&scene(""), &request, Tracing::Counted, usize::MAX);
        assert_eq!(result.unwrap().non_shadow_rays, 40 * 30 * samples);
        let (rays, _) = rows(&scene(""), &request, Tracing::Fast, usize::MAX);
        assert_eq!(rays.unwrap().rays(), 40 * 30 * samples);
        // If the filter reaches beyond a window, samples around it are traced, but only its rows count.
        let window = Some(Window { x: 0, y: 10, width: 40, height: 2 });
        let (result, _) = rows(&scene(""), &Request { window, ..request }, Tracing::Counted, usize::MAX);
        assert_eq!(result.unwrap().non_shadow_rays, 40 * 2 * samples);
    }
}
