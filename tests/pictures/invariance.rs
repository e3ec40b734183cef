//! Neither the grid, nor its resolution, nor the number of threads, nor counting changes a picture. Every
//! scene is rendered at a small size, each time by the program itself.

use super::commands::{program, scenes, succeed};
use std::fs;
use std::path::Path;
use tempfile::tempdir;

/// A small size, of sides that no number of threads or cells divides evenly. Without a grid every ray tests
/// every face, so there are fewer rays for the rabbit with 40,000 faces.
fn size_flags(scene: &str) -> &'static str {
    if scene.contains("40k") { "-size 13 11" } else { "-size 31 27" }
}

/// Every variant must give the same picture as the first: with few cells of uneven sides, and with many.
const VARIANTS: [&str; 4] =
    ["-threads 1", "-threads 7 -stats", "-threads 2 -grid 7 5 3 -stats", "-threads 7 -grid 40 40 33"];

/// More of them, for rays of each kind: with a single cell, and with thin slices along one axis. Samples only add more
/// rays of these kinds.
const GRIDS: [&str; 7] = [
    VARIANTS[0],
    VARIANTS[1],
    VARIANTS[2],
    VARIANTS[3],
    "-threads 1 -grid 1 1 1",
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

/// Renders every `step`th scene with `flags` and each variant.
fn same_pictures_with(flags: &str, variants: &[&str], step: usize) {
    let folder = tempdir().unwrap();
    let mut failures = Vec::new();
    for scene in scenes().into_iter().step_by(step) {
        let picture = |variant: &str| picture(&scene, &format!("{flags} {variant}"), folder.path());
        let first = picture(variants[0]);
        let differ = variants[1..].iter().filter(|variant| picture(variant) != first);
        failures.extend(differ.map(|variant| format!("{scene} {flags} {variant}")));
    }
    assert!(failures.is_empty(), "not as without a grid on one thread:\n{}", failures.join("\n"));
}

#[test]
fn some_pictures_stay_the_same() {
    same_pictures(8);
}

#[test]
#[ignore = "slow: a minute and a half"]
fn pictures_stay_the_same() {
    same_pictures(1);
}

/// Renders every `step`th scene with rays of each kind.
fn same_pictures(step: usize) {
    same_pictures_with("-bounces 0", &GRIDS, step);
    same_pictures_with("-shadows -bounces 3 -shade_back", &GRIDS, step);
    let random = "-jittered_samples 2 -gaussian_filter 0.5 -transparent_shadows -bounces 0";
    same_pictures_with(random, &VARIANTS, step);
    // No variant counts without a grid: every ray would test every primitive, a second for some scenes.
    let variants = [VARIANTS[0], "-threads 7 -grid 40 40 33 -stats", "-threads 2 -grid 7 5 3"];
    let adaptive = "-adaptive_samples 12 4 -tent_filter 0.8 -shadows -bounces 1 -shade_back";
    same_pictures_with(adaptive, &variants, step);
}
