//! Makes the meshes of `scenes/`: a cube, a rabbit at four levels of detail, letters, a gem, a vase and hollow glass.
//!
//! `cargo run --release --example make_meshes -- scenes` writes them; with `--check` it compares them with
//! the existing files instead.
//!
//! The rabbit is modelled as an implicit surface ([`rabbit`]), polygonised ([`polygonise`]) and simplified
//! ([`simplify`]), and so are the [`letters`]; the others are [`cut`]. Each mesh is checked to be the boundary of
//! solids ([`topology`]). The bytes are the same on every machine: all arithmetic is IEEE basic operations and
//! `libm`, in a fixed order.

mod cut;
mod letters;
mod polygonise;
mod rabbit;
mod simplify;
mod topology;

use glam::{DVec3, dvec3};
use letters::Letter;
use polygonise::{Lattice, polygonise, relax};
use rabbit::Rabbit;
use simplify::Simplifier;
use std::ffi::OsString;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use topology::{Mesh, check_closed};

/// The rabbits, the finest first, because each is made from the one before.
const RABBITS: [(&str, usize); 4] =
    [("bunny_40k.obj", 40_000), ("bunny_5k.obj", 5_000), ("bunny_1k.obj", 1_000), ("bunny_200.obj", 200)];
/// The height of the ground the rabbit sits on.
const GROUND: f64 = 0.0667;
/// The height of the rabbit, in scene units, per unit of its own frame.
const SCALE: f64 = 0.335;
/// The position of the origin of the rabbit's frame in the scene.
const POSITION: DVec3 = dvec3(-0.043, GROUND, 0.009);
/// The angle by which the nose is turned from -x towards the camera at +z, in radians.
const TURN: f64 = 0.45;
/// The distance between the points at which the implicit surface is sampled, in the rabbit's own units.
const STEP: f64 = 1.0 / 140.0;
/// The number of rounds of relaxation, which evens out the triangles.
const RELAX_ROUNDS: usize = 3;

/// The arguments of the command line.
struct Request {
    folder: PathBuf,
    check: bool,
}

fn main() -> ExitCode {
    match request(std::env::args_os().skip(1)).and_then(|request| run(&request)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("make_meshes: {message}");
            ExitCode::FAILURE
        }
    }
}

fn request(arguments: impl Iterator<Item = OsString>) -> Result<Request, String> {
    let (options, folders): (Vec<_>, Vec<_>) =
        arguments.partition(|argument| argument.to_string_lossy().starts_with('-'));
    if folders.len() > 1 || options.iter().any(|option| option != "--check") {
        return Err("usage: make_meshes [--check] [FOLDER]".to_string());
    }
    let folder = folders.first().map_or("scenes".into(), PathBuf::from);
    Ok(Request { folder, check: !options.is_empty() })
}

/// Writes all files, or compares them with the existing ones.
fn run(request: &Request) -> Result<(), String> {
    for (name, text) in make_all()? {
        let path = request.folder.join(name);
        if request.check {
            compare(&path, &text)?;
        } else {
            write(&path, &text)?;
        }
    }
    Ok(())
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    std::fs::write(path, text).map_err(|error| format!("cannot write {}: {error}", path.display()))
}

fn compare(path: &Path, text: &str) -> Result<(), String> {
    let present = std::fs::read(path).map_err(|error| format!("cannot read {}: {error}", path.display()))?;
    if present == text.as_bytes() { Ok(()) } else { Err(format!("{} differs", path.display())) }
}

/// The names and contents of all files.
fn make_all() -> Result<Vec<(&'static str, String)>, String> {
    let mut files = vec![
        ("cube.obj", checked_obj("cube.obj", &cube())?),
        ("gem.obj", checked_obj("gem.obj", &cut::gem())?),
        ("vase.obj", checked_obj("vase.obj", &cut::vase())?),
        ("glass_shell.obj", obj_text(&glass_shell()?)),
        ("letters.obj", obj_text(&word()?)),
    ];
    let rabbit = Rabbit::new();
    let field = |point| rabbit.distance(point);
    let mut sculpture = polygonise(&rabbit_lattice(), &field);
    relax(&mut sculpture, &field, RELAX_ROUNDS);
    let mut simplifier = Simplifier::new(sculpture, &|point| rabbit.importance(point));
    for (name, faces) in RABBITS {
        simplifier.reduce_to(faces).map_err(|error| format!("{name}: {error}"))?;
        let mesh = placed(simplifier.compacted());
        files.push((name, checked_obj(name, &mesh)?));
    }
    Ok(files)
}

/// A cube from -1 to 1. Bit n of a vertex's index is its side along axis n.
fn cube() -> Mesh {
    let side = |corner: u32, axis: u32| f64::from(corner >> axis & 1) * 2.0 - 1.0;
    let positions = (0..8).map(|corner| dvec3(side(corner, 0), side(corner, 1), side(corner, 2))).collect();
    let squares = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let faces = squares.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { positions, faces }
}

/// The box around the rabbit in its own frame, with a margin. No lattice plane
/// coincides with the ground, where all values would be zero.
fn rabbit_lattice() -> Lattice {
    let (min, max) = (dvec3(-0.6, -0.0331, -0.4), dvec3(0.6, 1.15, 0.4));
    let counts = ((max - min) / STEP).to_array().map(|count| count as usize + 1);
    Lattice { origin: min, step: STEP, counts }
}

/// Moves a rabbit from its own frame into the scene.
fn placed(mut mesh: Mesh) -> Mesh {
    let (sin, cos) = (libm::sin(TURN), libm::cos(TURN));
    let axes = [dvec3(-cos, 0.0, sin), DVec3::Y, dvec3(-sin, 0.0, -cos)];
    for position in &mut mesh.positions {
        let [x, y, z] = position.to_array();
        // Simplification may move a vertex slightly below the ground.
        *position = POSITION + (axes[0] * x + axes[1] * y.max(0.0) + axes[2] * z) * SCALE;
    }
    mesh
}

/// The letters side by side, the middle of the word at the origin.
fn word() -> Result<Mesh, String> {
    /// The distance between the middle lines of neighbouring letters.
    const GAP: f64 = 0.3;
    const FACES: usize = 900;
    let letters = Letter::all();
    let width = letters.iter().map(|letter| letter.width + GAP).sum::<f64>() - GAP;
    let mut left = -0.5 * width;
    let mut meshes = Vec::new();
    for letter in letters {
        let mut mesh = letter_mesh(&letter, FACES).map_err(|error| format!("letters.obj: {error}"))?;
        mesh.positions.iter_mut().for_each(|position| position.x += left);
        meshes.push(checked(&mesh, letter.holes).map_err(|error| format!("letters.obj: {error}"))?);
        left += letter.width + GAP;
    }
    Ok(Mesh::join(meshes))
}

fn letter_mesh(letter: &Letter, faces: usize) -> Result<Mesh, String> {
    /// The distance between the points at which a letter is sampled.
    const STEP: f64 = 1.0 / 61.0;
    let [min, max] = letter.bounds();
    let counts = ((max - min) / STEP).to_array().map(|count| count as usize + 1);
    let field = |point| letter.distance(point);
    let mut mesh = polygonise(&Lattice { origin: min, step: STEP, counts }, &field);
    relax(&mut mesh, &field, RELAX_ROUNDS);
    let mut simplifier = Simplifier::new(mesh, &|_| 1.0);
    simplifier.reduce_to(faces)?;
    Ok(simplifier.compacted())
}

/// A hollow ball of cut glass. The inner side of its wall is a surface that faces the hollow, so that a ray which
/// crosses it leaves the glass.
fn glass_shell() -> Result<Mesh, String> {
    const WALL: f64 = 0.04;
    let ball = |radius| {
        checked(&cut::cut_ball(radius, 12, 7), 0).map_err(|error| format!("glass_shell.obj: {error}"))
    };
    Ok(Mesh::join([ball(1.0)?, ball(1.0 - WALL)?.inside_out()]))
}

/// The text of a mesh without holes, after all checks.
fn checked_obj(name: &str, mesh: &Mesh) -> Result<String, String> {
    checked(mesh, 0).map(|mesh| obj_text(&mesh)).map_err(|error| format!("{name}: {error}"))
}

/// The mesh with its positions as they are rounded in the text, after all checks.
fn checked(mesh: &Mesh, holes: i64) -> Result<Mesh, String> {
    let rounded = |value: f64| (value * 1e6).round() / 1e6;
    let positions = mesh.positions.iter().map(|p| DVec3::from(p.to_array().map(rounded))).collect();
    let mesh = Mesh { positions, faces: mesh.faces.clone() };
    check_closed(&mesh, holes)?;
    Ok(mesh)
}

fn obj_text(mesh: &Mesh) -> String {
    let mut text = String::new();
    for DVec3 { x, y, z } in &mesh.positions {
        // Writing to a string cannot fail. Adding 0 turns -0 into 0.
        let _ = writeln!(text, "v {:.6} {:.6} {:.6}", x + 0.0, y + 0.0, z + 0.0);
    }
    for [a, b, c] in mesh.faces.iter().map(|face| face.map(|vertex| vertex + 1)) {
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    text
}
