//! A program whose allocator refuses one block: every list of the pipeline that grows with its input asks for its
//! memory, so that a refusal is an error, or makes no difference.
//!
//! Small blocks are not refused. Names, messages and the structures of libraries take them without asking.

use glam::DVec3;
use rayon::{ThreadPool, ThreadPoolBuilder};
use raytracer::caster::choose::{Resolution, Structure};
use raytracer::image_io::{OutputFile, read_picture};
use raytracer::render::{Layer, Request, Tracing};
use raytracer::renderer::{Meshes, Renderer};
use raytracer::sampling::adaptive::Adaptive;
use raytracer::sampling::drand48::Drand48;
use raytracer::sampling::filter::Filter;
use raytracer::sampling::sampler::Sampler;
use raytracer::scene_io;
use raytracer::tools::compare::Comparison;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::ops::ControlFlow;
use std::path::Path;
use std::ptr;
use tempfile::TempDir;

#[global_allocator]
static ALLOCATOR: Refusing = Refusing;

/// The system's allocator, except that one block is refused.
struct Refusing;

/// Blocks of at least this number of bytes are counted.
const LARGE: usize = 16 << 10;

thread_local! {
    /// How many large blocks this thread may take before one is refused; none to take all.
    static LEFT: Cell<Option<usize>> = const { Cell::new(None) };
}

/// Whether this block is the one that is refused.
fn is_refused(layout: Layout) -> bool {
    if layout.size() < LARGE {
        return false;
    }
    let left = LEFT.get();
    LEFT.set(left.and_then(|left| left.checked_sub(1)));
    left == Some(0)
}

// SAFETY: every block comes from the system's allocator and returns to it, or is null, as an allocator may say.
unsafe impl GlobalAlloc for Refusing {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller promises what the system's allocator requires.
        if is_refused(layout) { ptr::null_mut() } else { unsafe { System.alloc(layout) } }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the block comes from the system's allocator.
        unsafe { System.dealloc(memory, layout) }
    }
}

/// Does some work again and again, with the first large block refused, then the second, and so on, until all are given.
/// Each time it must fail for want of memory, or have the result that it has with enough. Returns how often it failed.
fn refuse_each<T: PartialEq>(what: &str, work: impl Fn() -> Result<T, String>) -> usize {
    let expected = work().unwrap_or_else(|error| panic!("{what}: {error}"));
    let mut failures = 0;
    for number in 0.. {
        // An abort ends the whole test, so that what is not captured tells where.
        let _ = writeln!(std::io::stderr(), "{what}: block {number} is refused");
        LEFT.set(Some(number));
        let result = work();
        let is_over = LEFT.replace(None).is_some();
        match result {
            Ok(found) => assert!(found == expected, "{what}, block {number}: another result"),
            Err(error) => {
                assert!(error.contains("memory"), "{what}, block {number}: {error}");
                failures += 1;
            }
        }
        if is_over {
            break;
        }
    }
    failures
}

/// All work is done on the thread that asks for it, whose blocks are counted.
fn this_thread() -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(1).use_current_thread().build().unwrap()
}

/// The camera, a light, and an object of each kind with materials between them, repeated.
fn mixed_scene(count: usize) -> String {
    let mut text = "PerspectiveCamera { center 0 0 9 direction 0 0 -1 up 0 1 0 angle 40 }
        Lights { numLights 1 DirectionalLight { direction 0 -1 -1 color 1 1 1 } }\n"
        .to_owned();
    let _ = writeln!(text, "Materials {{ numMaterials {count} {} }}", "Material { }\n".repeat(count));
    let _ = writeln!(text, "Group {{ numObjects {count}");
    for k in 0..count {
        let [x, y] = [k % 40, k / 40].map(|n| n as f64 / 10.0 - 2.0);
        let _ = match k % 4 {
            0 => writeln!(text, "MaterialIndex {k} Sphere {{ center {x} {y} 0 radius .05 }}"),
            1 => writeln!(text, "Triangle {{ vertex0 {x} {y} 0 vertex1 {y} {x} 1 vertex2 0 {y} 2 }}"),
            2 => writeln!(text, "Transform {{ Scale 1 2 1 Sphere {{ center {x} {y} 0 radius .05 }} }}"),
            _ => writeln!(text, "Group {{ numObjects 1 Box {{ min {x} {y} 0 max {x} {y} 1 }} }}"),
        };
    }
    text + "}\n"
}

/// A square of this number of quads along each side, each of two triangles.
fn mesh(side: usize) -> String {
    let mut text = String::new();
    for k in 0..(side + 1) * (side + 1) {
        let point = DVec3::new((k % (side + 1)) as f64, (k / (side + 1)) as f64, 0.0) / side as f64;
        let _ = writeln!(text, "v {} {} {}", 4.0 * point.x - 2.0, 4.0 * point.y - 2.0, point.x * point.y);
    }
    for k in 0..side * side {
        let corner = k / side * (side + 1) + k % side + 1;
        let (right, above) = (corner + 1, corner + side + 1);
        let _ = writeln!(text, "f {corner} {right} {above}\nf {right} {} {above}", above + 1);
    }
    text
}

const MESH_SCENE: &str = "PerspectiveCamera { center 0 0 9 direction 0 0 -1 up 0 1 0 angle 40 }
    Lights { numLights 1 DirectionalLight { direction 0 -1 -1 color 1 1 1 } }
    Group { numObjects 2 Material { } TriangleMesh { obj_file mesh.obj }
    Transform { Translate 0 0 -1 TriangleMesh { obj_file mesh.obj } } }";

/// The bytes of the picture that a scene is rendered to. Nothing else may be left in the folder.
fn rendered(folder: &Path, structure: Structure, request: &Request) -> Result<Vec<Vec<u8>>, String> {
    let before = fs::read_dir(folder).unwrap().count();
    let files: Vec<_> = (0..request.layers.len()).map(|k| folder.join(format!("{k}.tga"))).collect();
    let pictures = render(folder, structure, request, &files);
    // What this test itself takes is given.
    let left = LEFT.take();
    let read = |()| files.iter().map(|file| fs::read(file).unwrap()).collect::<Vec<_>>();
    let pictures = pictures.map(read);
    LEFT.set(left);
    files.iter().for_each(|file| drop(fs::remove_file(file)));
    assert_eq!(fs::read_dir(folder).unwrap().count(), before, "a file is left");
    pictures
}

fn render(
    folder: &Path,
    structure: Structure,
    request: &Request,
    files: &[std::path::PathBuf],
) -> Result<(), String> {
    let loaded = scene_io::load(&folder.join("s.txt")).map_err(|error| error.to_string())?;
    let renderer = Renderer::new(loaded, Meshes::Kept).map_err(|error| error.to_string())?;
    let prepared =
        renderer.prepare_for(structure, request, Tracing::Fast).map_err(|error| error.to_string())?;
    let begin = |(file, layer): (&std::path::PathBuf, &Layer)| {
        let file = OutputFile::prepare(file)?;
        file.begin(layer.size(request.window_size()), None)
    };
    let writers = files.iter().zip(&request.layers).map(begin).collect::<Result<Vec<_>, _>>();
    let mut writers = writers.map_err(|error| error.to_string())?;
    let mut failure = None;
    let mut take_row = |layer: usize, row: &[DVec3]| match writers[layer].row(row) {
        Ok(()) => ControlFlow::Continue(()),
        Err(error) => {
            failure = Some(error);
            ControlFlow::Break(())
        }
    };
    let goes_on = |_| ControlFlow::Continue(());
    let done = prepared.render_rows(request, &goes_on, &mut take_row);
    failure.map_or(Ok(()), |error| Err(error.to_string()))?;
    done.map_err(|error| error.to_string())?;
    writers.into_iter().try_for_each(|writer| writer.finish().map(drop)).map_err(|error| error.to_string())
}

fn folder_with(scene: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("s.txt"), scene).unwrap();
    folder
}

#[test]
fn a_refused_block_is_an_error_or_makes_no_difference() {
    let threads = this_thread();
    let mixed = folder_with(&mixed_scene(1000));
    let mesh_folder = folder_with(MESH_SCENE);
    fs::write(mesh_folder.path().join("mesh.obj"), mesh(40)).unwrap();
    let colors = Request { layers: vec![Layer::Color], ..Request::new([30, 20]) };
    let filter = Filter::Gaussian { sigma: 2.0 };
    let filtered = Request { filter, layers: vec![Layer::Color, Layer::Color], ..Request::new([150, 20]) };
    let measured = [Layer::Depth { near: 5.0, far: 12.0 }, Layer::Normals, Layer::Samples { zoom: 5 }];
    let measured = Request { layers: measured.to_vec(), ..Request::new([200, 10]) };
    let (adaptive, sampler) =
        (Some(Adaptive { most: 16, error: 1.0 }), Sampler::first_of_adaptive(Drand48::seeded(0)));
    let adaptive = Request { adaptive, sampler, layers: vec![Layer::Color], ..Request::new([700, 3]) };
    let grid = |structure| Structure::Grid(structure);
    let (auto, cells) = (grid(Resolution::Auto), grid(Resolution::Cells([20, 20, 10])));
    let cases = [
        ("a list", &mixed, Structure::List, &colors),
        ("cells", &mixed, cells, &colors),
        ("an automatic grid", &mixed, auto, &colors),
        ("a mesh", &mesh_folder, Structure::Any, &colors),
        ("a mesh in a grid", &mesh_folder, auto, &filtered),
        ("layers", &mesh_folder, cells, &measured),
        ("adaptive samples", &mesh_folder, cells, &adaptive),
    ];
    for (what, folder, structure, request) in cases {
        let work = || threads.install(|| rendered(folder.path(), structure, request));
        let failures = refuse_each(what, work);
        assert!(failures > 5, "{what}: only {failures} refusals were noticed");
    }
    let [one, other] = ["1.tga", "2.tga"].map(|name| mixed.path().join(name));
    render(mixed.path(), Structure::List, &colors, std::slice::from_ref(&one)).unwrap();
    render(mixed.path(), cells, &colors, std::slice::from_ref(&other)).unwrap();
    let compare = || {
        let read = |file| read_picture(file).map_err(|error| error.to_string());
        let (a, b) = (read(&one)?, read(&other)?);
        let compared =
            threads.install(|| Comparison::of_each(&[a], &b)).map_err(|error| error.to_string())?;
        Ok(compared[0].pixels_that_differ())
    };
    refuse_each("a comparison", compare);
}
