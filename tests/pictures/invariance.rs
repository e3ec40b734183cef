//! What must not change a picture: the grid, its resolution, the number of threads, counting.
//! Every scene is rendered small, each time by the real program.

use super::commands::{program, scenes, succeed};
use std::fs;
use std::path::Path;
use tempfile::tempdir;

/// Small, and of sides that no number of threads or cells divides evenly. Without a grid every ray
/// tests every face, so the rabbit with 40,000 must do with fewer rays.
fn size_flags(scene: &str) -> &'static str {
    if scene.contains("40k") { "-size 13 11" } else { "-size 31 27" }
}

/// Each is to make the picture that the first makes. One cell for all; few and uneven; many; thin
/// slices along one axis and hardly any along another.
const VARIANTS: [&str; 7] = [
    "-threads 1",
    "-threads 7 -stats",
    "-threads 1 -grid 1 1 1",
    "-threads 2 -grid 7 5 3 -stats",
    "-threads 7 -grid 40 40 33",
    "-threads 1 -grid 40 40 33 -stats",
    "-threads 2 -grid 50 1 2",
];

/// The bytes of the scene's picture with these flags.
fn picture(scene: &str, flags: &str, folder: &Path) -> Vec<u8> {
    let path = folder.join("picture.tga");
    let mut program = program();
    program.args(["-input", scene, "-output"]).arg(&path);
    program.args(size_flags(scene).split_whitespace()).args(flags.split_whitespace());
    succeed(program);
    fs::read(path).unwrap()
}

/// Renders every scene with `flags` and each variant.
fn same_pictures_with(flags: &str) {
    let folder = tempdir().unwrap();
    let mut failures = Vec::new();
    for scene in scenes() {
        let [first, rest @ ..] = VARIANTS.map(|variant| {
            let flags = format!("{flags} {variant}");
            (picture(&scene, &flags, folder.path()), flags)
        });
        let differ = rest.into_iter().filter(|(bytes, _)| *bytes != first.0);
        failures.extend(differ.map(|(_, flags)| format!("{scene} {flags}")));
    }
    assert!(failures.is_empty(), "not as without a grid on one thread:\n{}", failures.join("\n"));
}

#[test]
fn plain_pictures_stay_the_same() {
    same_pictures_with("");
}

#[test]
fn pictures_with_shadows_and_secondary_rays_stay_the_same() {
    same_pictures_with("-shadows -bounces 3 -shade_back");
}

#[test]
fn pictures_with_random_samples_stay_the_same() {
    same_pictures_with("-jittered_samples 2 -gaussian_filter 0.5 -transparent_shadows");
}
