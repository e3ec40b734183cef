//! Regression tests for findings of fuzzing. The fuzz targets are in `fuzz/`. This runs their checks on their
//! seeds and on every text that once failed.

#[path = "../../fuzz/checks.rs"]
pub mod checks;

use std::fs;
use std::path::Path;

/// The contents of the files in a folder of `fuzz/seeds`.
fn seeds(target: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds").join(target);
    let files = fs::read_dir(folder).expect("the seeds");
    files.map(|file| fs::read(file.expect("a file").path()).expect("a readable file")).collect()
}

#[test]
fn scene_seeds() {
    seeds("scene_text").iter().for_each(|s| checks::check_scene(std::str::from_utf8(s).expect("text")));
}

#[test]
fn mesh_seeds() {
    seeds("obj").iter().for_each(|s| checks::check_obj(s));
}

/// More threads than rows once made the renderer panic.
#[test]
fn fewer_rows_than_threads() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(16).build().expect("threads");
    pool.install(|| {
        checks::check_scene(
            "PerspectiveCamera { center 0 0 9 direction 0 0 -1 up 0 1 0 angle 30 } Group { numObjects 0 }",
        )
    });
}

/// Every ray of this camera was once NaN, since the square of the direction's length underflows to 0.
#[test]
fn vectors_whose_square_underflows() {
    checks::check_scene(
        "PerspectiveCamera { center 0 0 9 direction 0 0 -1e-200 up 0 1e-200 0 angle 30 }
         Lights { numLights 1 DirectionalLight { direction 0 -1e-200 -1e-200 color 1 1 1 } }
         Group { numObjects 2 Material { } Plane { normal 0 1e-200 0 offset -1 } Sphere { center 0 0 0 radius 1e-170 } }",
    );
}

/// An orthographic ray parallel to a plane once hit it at minus infinity.
#[test]
fn an_orthographic_view_along_a_plane() {
    checks::check_scene(
        "OrthographicCamera { center 0 1 0 direction 0 0 -1 up 0 1 0 size 5 }
         Group { numObjects 1 Material { } Plane { normal 0 1 0 offset 0 } }",
    );
}
