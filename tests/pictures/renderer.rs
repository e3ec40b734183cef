//! The library's front door: one scene, opened once and rendered in many ways.

use raytracer::caster::choose::{Resolution, Structure};
use raytracer::render::renderer::{Meshes, Renderer};
use raytracer::render::{Layer, Request, Tracing};
use raytracer::sampling::drand48::Drand48;
use raytracer::sampling::filter::Filter;
use raytracer::sampling::sampler::{Pattern, Sampler};
use raytracer::scene::Camera;
use raytracer::scene::load;
use raytracer::trace::{Effects, Shadows};
use std::path::{Path, PathBuf};

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
