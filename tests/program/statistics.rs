//! The counters of `-stats`, compared with counts made by hand.

use crate::support::{Folder, Run, course, finish, program};
use std::path::Path;

/// The counters of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Counted {
    rays: u64,
    shadow_rays: u64,
    intersections: u64,
    cells: u64,
}

impl Counted {
    fn of(run: Run) -> Self {
        let run = run.ok();
        let value = |label| run.value(label).parse().expect("a number");
        Self {
            rays: value("num non-shadow rays"),
            shadow_rays: value("num shadow rays"),
            intersections: value("total intersections"),
            cells: value("total cells traversed"),
        }
    }
}

/// Objects in front of an orthographic camera that looks down the z axis at a square of side 4.
fn scene(lights: usize, material: &str, count: usize, objects: &str) -> Folder {
    let light = "DirectionalLight { direction 0 -1 -1 color 1 1 1 }\n";
    Folder::with_scene(&format!(
        "OrthographicCamera {{ center 0 0 5 direction 0 0 -1 up 0 1 0 size 4 }}
         Lights {{ numLights {lights} {} }}
         Group {{ numObjects {count} Material {{ {material} }} {objects} }}",
        light.repeat(lights)
    ))
}

fn count(folder: &Folder, flags: &str) -> Counted {
    Counted::of(folder.run(&format!("-input s.txt -stats {flags}")))
}

/// A triangle that covers the right half of the view, seen from outside.
const RIGHT_HALF: &str = "Triangle { vertex0 0 -9 0 vertex1 9 0 0 vertex2 0 9 0 }";
/// The same triangle, seen from inside.
const RIGHT_HALF_BACK: &str = "Triangle { vertex0 0 9 0 vertex1 9 0 0 vertex2 0 -9 0 }";
const WALL: &str = "Plane { normal 0 0 1 offset -1 }";

#[test]
fn a_mesh_counts_as_its_triangles_and_transforms_as_nothing() {
    let objects = "Transform { Scale 2 1 1 Group { numObjects 2
        TriangleMesh { obj_file m.obj } Transform { ZRotate 9 Sphere { center 0 0 0 radius 1 } } } }";
    let folder = scene(0, "", 1, objects);
    folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\nf 1 3 2\n");
    assert_eq!(count(&folder, "-size 5 5").intersections, 25 * 4);
}

#[test]
fn a_triangle_without_area_counts_as_any_other() {
    let line = "Triangle { vertex0 0 0 1 vertex1 1 0 1 vertex2 2 0 1 }";
    let folder = scene(1, "", 2, &format!("{RIGHT_HALF} {line}"));
    for flags in ["-size 10 10", "-size 10 10 -grid 1 1 1"] {
        let (counted, without) = (count(&folder, flags), count(&scene(1, "", 1, RIGHT_HALF), flags));
        assert_eq!(counted.rays, without.rays);
        assert!(counted.intersections > without.intersections, "{flags}: {counted:?} {without:?}");
    }
}

#[test]
fn each_sample_is_a_ray() {
    let folder = scene(0, "", 1, WALL);
    for (flags, rays) in [
        ("-random_samples 7 -tent_filter 3", 7 * 24),
        ("-jittered_samples 9 -output o.tga -render_samples s.tga 2", 9 * 24),
    ] {
        let counted = count(&folder, &format!("-size 6 4 {flags}"));
        assert_eq!((counted.rays, counted.intersections), (rays, rays), "{flags}");
    }
}

#[test]
fn each_light_takes_a_shadow_ray_at_each_shaded_hit() {
    for lights in [1, 3] {
        let folder = scene(lights, "", 1, RIGHT_HALF);
        let shadow_rays = lights as u64 * 50;
        let lit = Counted { rays: 100, shadow_rays, intersections: 100 + shadow_rays, cells: 0 };
        assert_eq!(count(&folder, "-size 10 10 -shadows"), lit);
        assert_eq!(count(&folder, "-size 10 10").shadow_rays, 0);
        let unlit = scene(lights, "", 1, RIGHT_HALF_BACK);
        assert_eq!(count(&unlit, "-size 10 10 -shadows").shadow_rays, 0, "its inside is black");
        assert_eq!(count(&unlit, "-size 10 10 -shadows -shade_back").shadow_rays, shadow_rays);
    }
}

#[test]
fn glass_lets_a_ray_in_and_out() {
    let sphere = "Sphere { center 0 0 0 radius 9 }";
    let folder = scene(1, "transparentColor 1 1 1 indexOfRefraction 1", 1, sphere);
    let glass = |flags: &str| count(&folder, &format!("-size 4 4 {flags}")).rays;
    // The camera is inside, but its rays start infinitely far behind it, so that each enters first.
    assert_eq!([glass(""), glass("-bounces 1"), glass("-bounces 2"), glass("-bounces 9")], [16, 32, 48, 48]);
}

/// A sphere of radius 1 whose bounds fill the view exactly.
fn boxed_sphere(direction: &str, up: &str) -> Folder {
    Folder::with_scene(&format!(
        "OrthographicCamera {{ center 0 0 0 direction {direction} up {up} size 2 }}
         Lights {{ numLights 1 DirectionalLight {{ direction 0 -1 -1 color 1 1 1 }} }}
         Group {{ numObjects 1 Material {{ }} Sphere {{ center 0 0 0 radius 1 }} }}"
    ))
}

#[test]
fn cells_traversed_are_the_steps_to_a_next_cell() {
    // Of the 4 x 4 rays the four in the corners miss, and step through every cell until they leave the grid.
    // Four hit the sphere at a distance of .935 from its centre plane, and eight at .612.
    for (direction, up, grid, steps) in [
        ("0 0 -1", "0 1 0", "1 1 1", 4),
        ("0 0 -1", "0 1 0", "4 4 4", 4 * 4),
        ("0 0 1", "0 1 0", "4 4 4", 4 * 4),
        ("0 0 -1", "1 0 0", "8 2 4", 4 * 4),
        // The first of 7 cells ends at a distance of .714, so that the eight rays visit one more cell.
        ("0 0 -1", "0 1 0", "4 4 7", 4 * 7 + 8),
        // The first of 20 cells ends at a distance of .9, and .612 is in the fourth.
        ("1 0 0", "0 0 1", "20 3 6", 4 * 20 + 8 * 3),
        ("0 -1 0", "0 0 1", "3 20 6", 4 * 20 + 8 * 3),
    ] {
        let counted = count(&boxed_sphere(direction, up), &format!("-size 4 4 -grid {grid}"));
        assert_eq!((counted.rays, counted.cells), (16, steps), "{direction}, {grid}");
    }
}

/// The rows of the table in docs/performance.md of rays and tests: the number of a scene, the flags, the rays and the
/// tests.
fn documented_rows() -> Vec<(&'static str, &'static str, u64, u64)> {
    let lines = include_str!("../../docs/performance.md").lines();
    let table = lines.skip_while(|line| !line.starts_with("| Scene | Flags | Rays")).skip(2);
    let mut scene = "";
    let row = |line: &'static str| {
        let columns: Vec<&str> = line.split('|').map(str::trim).collect();
        let number = |column: usize| columns[column].replace(',', "").parse().expect("a number");
        scene = columns[1].split('`').nth(1).unwrap_or(scene);
        (scene, columns[2].trim_matches('`'), number(3), number(4))
    };
    table.take_while(|line| line.starts_with('|')).map(row).collect()
}

/// Every ray is cast and every step counted, without the shortcuts of the fast mode.
#[test]
fn the_documented_rays_and_tests() {
    let folder = Folder::new();
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let rows = documented_rows();
    assert!(rows.len() >= 4);
    for (scene, flags, rays, tests) in rows {
        let files = std::fs::read_dir(&scenes).expect("the scenes").flatten().map(|entry| entry.path());
        let name = |path: &Path| path.file_name().is_some_and(|n| n.to_string_lossy().starts_with(scene));
        let file = files.into_iter().find(|path| name(path)).expect(scene);
        let counted = Counted::of(
            folder.run(&format!("-input {} -output o.tga -size 200 200 -stats {flags}", file.display())),
        );
        let found = (counted.rays + counted.shadow_rays, counted.intersections);
        assert_eq!(found, (rays, tests), "{scene} {flags}");
    }
}

/// The counters of that command of the course that writes `picture`.
fn count_course(course: &Path, picture: &str) -> Counted {
    let commands = std::fs::read_to_string(course.join("commands.txt")).unwrap();
    let line = commands.lines().find(|line| line.contains(picture)).unwrap_or_else(|| panic!("{picture}"));
    let target = Folder::new();
    let words = line.split_whitespace().skip(1).map(|word| match word == picture {
        true => target.path().join(word).into_os_string(),
        false => word.into(),
    });
    let counted = Counted::of(finish(&mut program(&course.join("scenes"), words)));
    assert_eq!(target.names(), [picture]);
    counted
}

/// Equality within 0.1%, because a few rays are decided by the epsilon of the course's program.
fn near(actual: u64, expected: u64) -> bool {
    actual.abs_diff(expected) * 1000 <= expected
}

#[test]
fn the_course_s_counters_without_a_grid() {
    let Some(course) = course() else { return };
    let count = |picture| count_course(&course, picture);
    assert_eq!(count("output6_04a.tga").intersections, 8040000);
    for (picture, shadow_rays, intersections) in
        [("output6_02c.tga", 16250, 168750), ("output6_03c.tga", 35000, 150000)]
    {
        let expected = Counted { rays: 40000, shadow_rays, intersections, cells: 0 };
        assert_eq!(count(picture), expected, "{picture}");
    }
    for (picture, rays, shadow_rays, intersections) in
        [("output6_04c.tga", 40000, 66576, 21421776), ("output6_11a.tga", 66225, 70308, 5188254)]
    {
        let counted = count(picture);
        assert!(near(counted.rays, rays), "{picture}: {counted:?}");
        assert!(near(counted.shadow_rays, shadow_rays), "{picture}: {counted:?}");
        assert!(near(counted.intersections, intersections), "{picture}: {counted:?}");
    }
}

#[test]
fn the_course_s_cells_traversed() {
    let Some(course) = course() else { return };
    assert_eq!(count_course(&course, "output6_01b.tga").cells, 21192);
    for (picture, cells) in [("output6_04b.tga", 104266), ("output6_07.tga", 1040216)] {
        let counted = count_course(&course, picture);
        assert!(near(counted.cells, cells), "{picture}: {counted:?}");
    }
}

#[test]
fn the_blocks_have_their_lines() {
    let folder = scene(1, "", 2, "Sphere { center 0 0 0 radius 1.5 } Plane { normal 0 0 1 offset -9 }");
    let said =
        folder.run("-input s.txt -stats -size 20 10 -shadows -threads 2 -repeat 3 -grid 9 8 7").ok().stdout;
    let lines: Vec<(&str, &str)> =
        said.lines().filter_map(|line| line.trim_start().split_once("  ")).collect();
    let value = |label: &str| {
        let found = lines.iter().find(|(name, _)| *name == label);
        found.unwrap_or_else(|| panic!("no {label}: {said}")).1.trim_start()
    };
    for (label, expected) in [
        ("num pixels", "200 (20x10)"),
        ("scene bounds", "-1.500000 -1.500000 -1.500000  -> 1.500000 1.500000 1.500000"),
        ("num grid cells", "504 (9x8x7)"),
        ("num non-shadow rays", "200"),
        ("rays per pixel", "2.0"),
        ("threads", "2"),
        ("rendered", "3 times"),
    ] {
        assert_eq!(value(label), expected, "{label}");
    }
    for label in ["reading", "building", "rendering", "writing", "least", "median", "spread"] {
        assert!(value(label).strip_suffix(" ms").is_some_and(|time| time.parse::<f64>().is_ok()), "{label}");
    }
    let [rays, tests, cells] = ["rays per second", "intersections per ray", "cells traversed per ray"]
        .map(|label| value(label).parse::<f64>().expect("a number"));
    assert!(rays > 0.0 && tests > 0.5 && cells > 1.0, "{said}");
    assert!(value("total time").starts_with("0:00:0"), "{said}");
    assert!(folder.run("-input s.txt -repeat 2").ok().stdout.starts_with("  rendered  "));
}
