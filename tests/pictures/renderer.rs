//! The library's front door: one scene, opened once and rendered in many ways.

use raytracer::caster::choose::{Resolution, Structure};
use raytracer::diagnostic::Diagnostic;
use raytracer::picture::{Color, FloatPicture};
use raytracer::render::renderer::{Meshes, Prepared, Renderer};
use raytracer::render::{Layer, Progress, Request, Stopped, Tracing, Window};
use raytracer::sampling::drand48::Drand48;
use raytracer::sampling::filter::Filter;
use raytracer::sampling::sampler::{Pattern, Sampler};
use raytracer::scene::Camera;
use raytracer::scene::load;
use raytracer::trace::{Effects, Shadows};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

const SIZE: [usize; 2] = [46, 34];

fn scene(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name)
}

fn glass() -> Renderer {
    Renderer::open(&scene("scene6_14_glass_sphere.txt")).expect("a scene")
}

/// Every layer, with samples at random places, a filter that reaches two pixels, shadows and bounces.
fn request() -> Request {
    let effects = Effects { shadows: Shadows::Opaque, shade_back: true, bounces: 3, min_weight: 0.01 };
    let depth = Layer::Depth { near: 5.0, far: 15.0 };
    Request {
        effects,
        sampler: Sampler::new(Pattern::Jittered, 5, Drand48::UNSEEDED),
        filter: Filter::Gaussian { sigma: 0.9 },
        layers: vec![Layer::Color, depth, Layer::Normals, Layer::Samples { zoom: 3 }],
        ..Request::new(SIZE)
    }
}

/// The part of a picture that shows a window, where each pixel is a square of `zoom` by `zoom`.
fn crop(picture: &FloatPicture, window: Window, zoom: usize) -> Vec<Color> {
    let rows = picture.colors.chunks(picture.size[0]).skip(window.y * zoom).take(window.height * zoom);
    rows.flat_map(|row| row[window.x * zoom..][..window.width * zoom].to_vec()).collect()
}

fn same_in_all_windows(prepared: &Prepared, request: &Request) {
    let whole = prepared.render(request).expect("small pictures");
    for [x, y, width, height] in
        [[0, 0, 46, 34], [0, 0, 1, 1], [45, 33, 1, 1], [7, 3, 20, 9], [20, 30, 26, 4]]
    {
        let window = Window { x, y, width, height };
        let part =
            prepared.render(&Request { window: Some(window), ..request.clone() }).expect("small pictures");
        for ((layer, whole), part) in request.layers.iter().zip(&whole).zip(&part) {
            let zoom = if let Layer::Samples { zoom } = layer { *zoom } else { 1 };
            assert_eq!(part.size, [width * zoom, height * zoom]);
            assert!(part.colors == crop(whole, window, zoom), "{layer:?} {window:?}");
        }
    }
}

#[test]
fn a_window_shows_the_pixels_of_the_whole_picture() {
    let renderer = glass();
    let structure = Structure::Grid(Resolution::Cells([5, 4, 3]));
    let prepared = renderer.prepare(&Request { structure, ..request() }).expect("a small grid");
    same_in_all_windows(&prepared, &request());
    let centers = Request { sampler: Sampler::CENTER, filter: Filter::PIXEL, ..request() };
    same_in_all_windows(&prepared, &centers);
    same_in_all_windows(&prepared, &Request { filter: Filter::Box { radius: 0.5 }, ..request() });
}

#[test]
fn neither_grid_nor_counting_nor_threads_change_a_number() {
    let expected = glass().prepare(&request()).expect("no grid").render(&request()).expect("small pictures");
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let renderer = glass();
        let grids = [Resolution::Auto, Resolution::Cells([6, 6, 6])].map(Structure::Grid);
        for structure in [Structure::List, grids[0], grids[1]] {
            for tracing in [Tracing::Fast, Tracing::Counted] {
                let request = Request { structure, tracing, ..request() };
                let prepared = pool.install(|| renderer.prepare(&request)).expect("a small grid");
                assert!(pool.install(|| prepared.render(&request)).expect("small pictures") == expected);
            }
        }
    }
}

#[test]
fn a_structure_is_chosen_where_none_is_asked_for() {
    let renderer = Renderer::open(&scene("scene6_05_bunny_mesh_1k.txt")).expect("a scene");
    let plain = Request::new([20, 15]);
    let shadows =
        Request { effects: Effects { shadows: Shadows::Opaque, ..Effects::default() }, ..plain.clone() };
    let fast = |structure, request: &Request| {
        renderer.prepare(&Request { structure, ..request.clone() }).expect("a small grid")
    };
    let (any, list) = (fast(Structure::Any, &shadows), fast(Structure::List, &shadows));
    assert_eq!((any.cells(), list.cells()), (None, None));
    assert!(
        any.render(&shadows).expect("a small picture") == list.render(&shadows).expect("a small picture")
    );
    let counted = Request { tracing: Tracing::Counted, ..shadows };
    let course = renderer.prepare(&counted).expect("no grid");
    assert_eq!(course.cells(), None);
}

#[test]
fn a_moved_camera_shows_what_a_scene_with_that_camera_shows() {
    let renderer = glass();
    let Camera::Perspective { center, direction, up, .. } = renderer.scene.camera else {
        panic!("perspective")
    };
    let camera = Camera::Perspective { center: 0.8 * center, direction, up, angle: 40.0 };
    let moved = Request { camera: Some(camera), ..request() };
    let mut loaded = load::load(&scene("scene6_14_glass_sphere.txt")).expect("a scene");
    loaded.scene.camera = camera;
    let other = Renderer::new(loaded, Meshes::Moved).expect("a scene");
    let [shown, expected] = [(&renderer, &moved), (&other, &request())].map(|(renderer, request)| {
        renderer.prepare(request).expect("no grid").render(request).expect("small pictures")
    });
    assert!(shown == expected);
    assert!(renderer.prepare(&request()).expect("no grid").render(&request()).expect("small") != expected);
}

#[test]
fn progress_counts_every_row_once() {
    let renderer = glass();
    let window = Some(Window { x: 3, y: 5, width: 7, height: 20 });
    let request = Request { window, tracing: Tracing::Counted, ..request() };
    let prepared = renderer.prepare(&request).expect("no grid");
    let told = Mutex::new(Vec::new());
    let watch = |progress: Progress| {
        told.lock().expect("no panic").push(progress);
        ControlFlow::Continue(())
    };
    let mut rows = [0; 4];
    let mut take_row = |layer: usize, _: &[Color]| {
        rows[layer] += 1;
        Ok(())
    };
    let counts = prepared.render_rows(&request, &watch, &mut take_row).expect("all rows").counts;
    let mut done: Vec<usize> = told.into_inner().expect("no panic").iter().map(|p| p.done).collect();
    done.sort_unstable();
    assert_eq!(done, (1..=20).collect::<Vec<_>>());
    assert_eq!(rows, [20, 20, 20, 60]);
    // The samples of the pixels within the filter's reach of the window's columns, and the rays that they branch to.
    assert!(counts.non_shadow_rays >= 20 * 11 * 5, "{counts:?}");
}

#[test]
fn the_watch_and_the_output_end_a_render() {
    let renderer = glass();
    let prepared = renderer.prepare(&request()).expect("no grid");
    let ends = |progress: Progress| {
        if progress.done >= 10 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let mut taken = 0;
    let mut take_row = |_: usize, _: &[Color]| {
        taken += 1;
        Ok(())
    };
    let stopped = prepared.render_rows(&request(), &ends, &mut take_row).err();
    assert_eq!(stopped, Some(Stopped::Cancelled { rows: 0 }), "the rows are one strip");
    assert_eq!(taken, 0);
    let goes_on = |_| ControlFlow::Continue(());
    let refusal = || Diagnostic::error("not taken");
    let mut refuses = |_: usize, _: &[Color]| Err(refusal());
    let stopped = prepared.render_rows(&request(), &goes_on, &mut refuses).err();
    assert_eq!(stopped, Some(Stopped::Output(refusal())));
}

#[test]
fn the_cells_need_the_meshes_and_show_what_the_flag_shows() {
    let loaded = load::load(&scene("scene6_04_bunny_mesh_200.txt")).expect("a scene");
    let renderer = Renderer::new(loaded, Meshes::Kept).expect("a scene");
    let structure = Structure::Grid(Resolution::Cells([4, 5, 6]));
    let request = Request { structure, draws_cells: true, ..Request::new(SIZE) };
    let cells = renderer.prepare(&request).expect("few cells");
    assert_eq!(cells.cells(), Some([4, 5, 6]));
    let shown = cells.render(&Request::new(SIZE)).expect("a small picture");
    let scene =
        renderer.prepare(&Request::new(SIZE)).expect("no grid").render(&Request::new(SIZE)).expect("small");
    assert!(shown != scene);
    let background = renderer.scene.background.color;
    assert!(shown[0].colors.iter().any(|&color| color != background));
}
