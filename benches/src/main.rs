//! Casts the same rays into the same meshes with this project's caster and with its peers, on one
//! thread.
//!
//! `cargo run --release --manifest-path benches/Cargo.toml -- [--markdown] [--rounds N] [--meshes N]`

mod contestant;
mod measure;
mod mesh;
mod ours;
/// The program's allocator, for all contestants.
#[path = "../../src/allocator.rs"]
mod allocator;
mod peers;
mod report;
mod stage;

use contestant::Contestant;
use measure::{built, race};
use raytracer::scene::mesh::Mesh;
use raytracer::world::World;
use report::Row;
use stage::Stage;
use std::error::Error;
use std::path::Path;

/// The contestants, in the order of the tables.
const NAMES: [&str; 4] = ["raytracer", "`obvhs`", "`parry3d`", "`bvh`"];
/// For meshes of more faces than this the structure is built once, instead of as many times as rays are cast.
const BUILT_OFTEN: usize = 100_000;

/// The arguments of the command line.
struct Options {
    markdown: bool,
    /// The number of times that each contestant casts the rays.
    rounds: usize,
    /// The number of meshes that are used, starting with the fewest faces.
    meshes: usize,
}

impl Options {
    fn parse(mut words: impl Iterator<Item = String>) -> Result<Self, Box<dyn Error>> {
        let mut options = Self { markdown: false, rounds: 5, meshes: mesh::COUNT };
        while let Some(word) = words.next() {
            let mut number = || -> Result<usize, Box<dyn Error>> {
                Ok(words.next().ok_or("a number is missing")?.parse()?)
            };
            match word.as_str() {
                "--markdown" => options.markdown = true,
                "--rounds" => options.rounds = number()?.max(1),
                "--meshes" => options.meshes = number()?.clamp(1, mesh::COUNT),
                _ => return Err(format!("no such flag: {word}").into()),
            }
        }
        Ok(options)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse(std::env::args().skip(1))?;
    // Only this thread works, so that its clock measures the whole build.
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global()?;
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let stage = Stage::load(&scenes)?;
    let mut rows = vec![];
    for number in 0..options.meshes {
        let row = measure_mesh(&stage, mesh::rabbit(&scenes, number)?, options.rounds)?;
        // The tables come at the end, and this shows the progress.
        eprint!("{}", report::plain(&NAMES, &row));
        rows.push(row);
    }
    if options.markdown {
        println!("{}", report::markdown(&NAMES, &rows));
    }
    Ok(())
}

/// Measures all contestants for one mesh.
fn measure_mesh(stage: &Stage, mesh: Mesh, rounds: usize) -> Result<Row, Box<dyn Error>> {
    let meshes = [mesh];
    let [mesh] = &meshes;
    let world = World::new(&stage.scene, &meshes).map_err(|error| format!("{error:?}"))?;
    let builds = if mesh.triangles.len() > BUILT_OFTEN { 1 } else { rounds };
    let (ours, our_build) = built(builds, || ours::caster(&world));
    let ours = ours.map_err(|error| error.to_string())?;
    let (obvhs, obvhs_build) = built(builds, || peers::Obvhs::new(mesh));
    let (parry, parry_build) = built(builds, || peers::Parry::new(mesh));
    let (boxes, boxes_build) = built(builds, || peers::Boxes::new(mesh));
    let contestants: [&dyn Contestant; NAMES.len()] = [&ours, &obvhs, &parry, &boxes];
    let rays = stage.rays(mesh, &ours);
    Ok(Row {
        faces: mesh.triangles.len(),
        build: vec![our_build, obvhs_build, parry_build, boxes_build],
        results: race(&contestants, &rays, rounds),
    })
}
