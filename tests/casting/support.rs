//! What the tests share: worlds, casters and random numbers.

use raytracer::caster::Caster;
use raytracer::caster::choose::{Resolution, Structure};
use raytracer::math::instructions::Level;
use raytracer::scene::mesh::Mesh;
use raytracer::scene::obj::parse_obj;
use raytracer::scene::parser::parse;
use raytracer::world::World;
use std::path::{Path, PathBuf};

/// The folder of the project's scenes.
pub fn scene_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")
}

/// The rabbit of 5000 triangles.
pub fn rabbit() -> Mesh {
    parse_obj(&std::fs::read(scene_folder().join("bunny_5k.obj")).unwrap()).unwrap()
}

/// The world of objects in a scene's text. `meshes` are those that they name, in order.
pub fn world(objects: &[String], meshes: &[Mesh]) -> World {
    let text = format!(
        "OrthographicCamera {{ center 0 0 1 direction 0 0 -1 up 0 1 0 size 1 }}
         Group {{ numObjects {} Material {{ }} {} }}",
        objects.len(),
        objects.join("\n")
    );
    World::new(&parse(&text).unwrap(), meshes).unwrap()
}

/// The caster of `-grid auto` for this number of rays.
pub fn automatic(world: &World, rays: usize, level: Level) -> Caster<'_> {
    let layout = Structure::Grid(Resolution::Auto).layout(world, rays);
    Caster::with(world, layout, level).unwrap()
}

/// Random numbers from -0.5 to 0.5, from a linear congruential generator (Knuth, "The Art of Computer
/// Programming", vol. 2, 3.3.4).
pub fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }
}
