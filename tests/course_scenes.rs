//! The course's own scenes, where they are at hand: `COURSE_DIR` names a directory with them in
//! `scenes/`. They are not part of this project, so without it these tests pass vacuously.

use raytracer::scene_io::load;
use std::path::PathBuf;

/// The course's scene files, none when they are not at hand.
fn scenes() -> Vec<PathBuf> {
    let Some(course) = std::env::var_os("COURSE_DIR") else { return Vec::new() };
    let entries = std::fs::read_dir(PathBuf::from(course).join("scenes")).expect("COURSE_DIR has scenes");
    let paths = entries.map(|entry| entry.expect("a readable directory").path());
    let scenes: Vec<_> =
        paths.filter(|path| path.extension().is_some_and(|extension| extension == "txt")).collect();
    assert!(!scenes.is_empty());
    scenes
}

#[test]
fn every_scene_of_the_course_loads() {
    for path in scenes() {
        let loaded = load(&path).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(loaded.meshes.len(), loaded.scene.meshes.len());
        for mesh in &loaded.meshes {
            assert!(
                mesh.triangles.as_flattened().iter().all(|&index| (index as usize) < mesh.vertices.len())
            );
        }
    }
}
