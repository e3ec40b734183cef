//! A program whose allocator refuses one block: if it is asked for this is an error, or makes no difference, and
//! otherwise the program ends, as the application does. No file is left half written or behind.
//!
//! Small blocks are not refused: they are many, and end the program as others do.

use glam::DVec3;
use rayon::{ThreadPool, ThreadPoolBuilder};
use raytracer::caster::choose::{Resolution, Structure};
use raytracer::image_io::{Content, Format, OutputFile, read_picture};
use raytracer::memory;
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
use std::io::Write as _;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::{Command, exit};
use std::{env, fs, ptr};
use tempfile::TempDir;

#[global_allocator]
static ALLOCATOR: Refusing = Refusing;

/// The system's allocator, except that one block is refused. This ends the program, unless the block is asked
/// for.
struct Refusing;

/// The exit status of a program that its allocator has ended. No other has it.
const ENDED: i32 = 9;

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
    if left == Some(0) && !memory::is_asked_for(layout) {
        exit(ENDED);
    }
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

/// What is done while blocks are refused.
enum Work {
    Render(Structure, Box<Request>),
    Compare,
}

/// The work, its name, and the folder that it is done in.
fn works() -> Vec<(&'static str, &'static str, Work)> {
    let colors = Request { layers: vec![Layer::Color], ..Request::new([30, 20]) };
    let filter = Filter::Gaussian { sigma: 2.0 };
    let filtered = Request { filter, layers: vec![Layer::Color, Layer::Color], ..Request::new([150, 20]) };
    let measured = [Layer::Depth { near: 5.0, far: 12.0 }, Layer::Normals, Layer::Samples { zoom: 5 }];
    let measured = Request { layers: measured.to_vec(), ..Request::new([200, 10]) };
    let (adaptive, sampler) =
        (Some(Adaptive { most: 16, error: 1.0 }), Sampler::of_adaptive(Drand48::seeded(0)));
    let adaptive = Request { adaptive, sampler, layers: vec![Layer::Color], ..Request::new([700, 3]) };
    let grid = |structure| Structure::Grid(structure);
    let (auto, cells) = (grid(Resolution::Auto), grid(Resolution::Cells([20, 20, 10])));
    let render = |structure, request| Work::Render(structure, Box::new(request));
    vec![
        ("a list", "mixed", render(Structure::List, colors.clone())),
        ("cells", "mixed", render(cells, colors.clone())),
        ("an automatic grid", "mixed", render(auto, colors.clone())),
        ("a mesh", "mesh", render(Structure::Any, colors)),
        ("a mesh in a grid", "mesh", render(auto, filtered)),
        ("layers", "mesh", render(cells, measured)),
        ("adaptive samples", "mesh", render(cells, adaptive)),
        ("a comparison", "mixed", Work::Compare),
    ]
}

impl Work {
    fn run(&self, folder: &Path) -> Result<Vec<Vec<u8>>, String> {
        match self {
            Self::Render(structure, request) => rendered(folder, *structure, request),
            Self::Compare => {
                let read = |name| read_picture(&folder.join(name)).map_err(|error| error.to_string());
                let (a, b) = (read("a.tga")?, read("b.tga")?);
                let compared = Comparison::of_each(&[a], &b).map_err(|error| error.to_string())?;
                Ok(vec![compared[0].pixels_that_differ().to_le_bytes().to_vec()])
            }
        }
    }
}

/// Does some work again and again, with the large block of this number refused, then the next one, and so on, until all
/// are given. Each time it must fail for want of memory, or have the result that it has with enough. Says to standard
/// error which block is refused, and whether that was an error.
fn refuse_from(first: usize, folder: &Path, work: &Work) {
    let expected = work.run(folder).unwrap();
    for number in first.. {
        let _ = writeln!(std::io::stderr(), "{REFUSED}{number}");
        LEFT.set(Some(number));
        let result = work.run(folder);
        let is_over = LEFT.replace(None).is_some();
        match result {
            Ok(found) => assert!(found == expected, "another result"),
            Err(error) => {
                assert!(error.contains("memory"), "{error}");
                let _ = writeln!(std::io::stderr(), "{ERROR}");
            }
        }
        if is_over {
            break;
        }
    }
}

const REFUSED: &str = "refused: ";
const ERROR: &str = "that was an error";

/// The variables that make this program one that refuses blocks: the name of the work, its folder and the first block.
const VARIABLES: [&str; 3] = ["WORK", "FOLDER", "FIRST"];

/// Refuses one block after the other, in programs of their own, since most of them end it. Returns how many were errors
/// and how many ended it.
fn refuse_each(what: &str, folder: &Path) -> [usize; 2] {
    let names = || {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        names
    };
    let (before, mut first, mut errors, mut ends) = (names(), 0, 0, 0);
    loop {
        let mut program = Command::new(env::current_exe().unwrap());
        program.args([
            "--exact",
            "a_refused_block_is_an_error_or_the_end_or_makes_no_difference",
            "--nocapture",
        ]);
        program.envs(VARIABLES.into_iter().zip([what, folder.to_str().unwrap(), &first.to_string()]));
        let output = program.output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(names(), before, "{what}: a file is left\n{said}");
        errors += said.lines().filter(|&line| line == ERROR).count();
        match output.status.code() {
            Some(0) => return [errors, ends],
            Some(ENDED) => ends += 1,
            _ => panic!("{what}: {:?}\n{said}", output.status),
        }
        let last = said.lines().rev().find_map(|line| line.strip_prefix(REFUSED));
        first = last.unwrap().parse::<usize>().unwrap() + 1;
    }
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

/// The bytes of the pictures that a scene is rendered to. Nothing else may be left in the folder.
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

fn render(folder: &Path, structure: Structure, request: &Request, files: &[PathBuf]) -> Result<(), String> {
    let loaded = scene_io::load(&folder.join("s.txt")).map_err(|error| error.to_string())?;
    let renderer = Renderer::new(loaded, Meshes::Kept).map_err(|error| error.to_string())?;
    let prepared =
        renderer.prepare_for(structure, request, Tracing::Fast).map_err(|error| error.to_string())?;
    let begin = |(file, layer): (&PathBuf, &Layer)| {
        let file = OutputFile::prepare(file)?;
        file.begin(Format::Tga, layer.size(request.window_size()), Content::Colors, None)
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

#[test]
fn a_refused_block_is_an_error_or_the_end_or_makes_no_difference() {
    let threads = this_thread();
    let works = works();
    if let [Ok(what), Ok(folder), Ok(first)] = VARIABLES.map(env::var) {
        let (_, _, work) = works.iter().find(|(name, ..)| *name == what).unwrap();
        return threads.install(|| refuse_from(first.parse().unwrap(), Path::new(&folder), work));
    }
    let folder = TempDir::new().unwrap();
    let [mixed, meshes] = ["mixed", "mesh"].map(|name| folder.path().join(name));
    for (folder, scene) in [(&mixed, mixed_scene(1000).as_str()), (&meshes, MESH_SCENE)] {
        fs::create_dir(folder).unwrap();
        fs::write(folder.join("s.txt"), scene).unwrap();
    }
    fs::write(meshes.join("mesh.obj"), mesh(40)).unwrap();
    let compared = Request { layers: vec![Layer::Color], ..Request::new([100, 80]) };
    for (name, structure) in [("a.tga", Structure::List), ("b.tga", Structure::Any)] {
        threads.install(|| render(&mixed, structure, &compared, &[mixed.join(name)])).unwrap();
    }
    let mut all = [0; 2];
    for (what, name, _) in &works {
        let found = refuse_each(what, &folder.path().join(name));
        assert!(found[0] + found[1] > 1, "{what}: {found:?}");
        all = [0, 1].map(|k| all[k] + found[k]);
    }
    assert!(all.iter().all(|&count| count > 0), "{all:?}");
}
