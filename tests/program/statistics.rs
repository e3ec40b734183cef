//! The counters of `-stats`, compared with counts made by hand, and the layout of the block.

use crate::support::{Folder, Run, course, finish, program, sphere};
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
        let text = run.ok().stdout;
        let value = |label: &str| {
            let line = text.lines().find_map(|line| line.trim().strip_prefix(label));
            line.and_then(|rest| rest.trim().parse().ok()).unwrap_or_else(|| panic!("{label} in {text}"))
        };
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
fn without_a_grid_every_ray_meets_every_primitive() {
    for spheres in [1, 2, 7] {
        let objects = "Sphere { center 0 0 0 radius 1 } ".repeat(spheres);
        let folder = scene(0, "", spheres + 2, &format!("{objects} {WALL} {RIGHT_HALF}"));
        let counted = count(&folder, "-size 20 10");
        let expected =
            Counted { rays: 200, shadow_rays: 0, intersections: 200 * (spheres as u64 + 2), cells: 0 };
        assert_eq!(counted, expected);
    }
}

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
        ("-uniform_samples 4", 4 * 24),
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

/// As in the course's program.
#[test]
fn a_light_behind_the_surface_takes_a_shadow_ray() {
    let away = "Plane { normal 0 -1 .5 offset 0 }";
    let folder = scene(1, "", 1, away);
    assert_eq!(count(&folder, "-size 10 10 -shadows").shadow_rays, 100);
    assert!(folder.render("-size 10 10").greys().iter().all(|&grey| grey == 0));
}

#[test]
fn a_mirror_doubles_the_rays_that_hit_it() {
    let folder = scene(1, "reflectiveColor .5 .5 .5", 1, RIGHT_HALF);
    let mirrored = |flags: &str| count(&folder, &format!("-size 10 10 {flags}")).rays;
    assert_eq!(mirrored("-bounces 0"), 100);
    assert_eq!(mirrored("-bounces 1"), 150);
    assert_eq!(mirrored("-bounces 5"), 150, "what is reflected meets nothing more");
    // The weight of a reflected ray is the length of the colour, .5 sqrt(3) = .866.
    assert_eq!(mirrored("-bounces 1 -weight .86"), 150);
    assert_eq!(mirrored("-bounces 1 -weight .87"), 100);
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

#[test]
fn threads_change_no_counter() {
    let folder = scene(2, "reflectiveColor .4 .4 .4", 2, &format!("{RIGHT_HALF} {WALL}"));
    let flags = "-size 33 17 -shadows -bounces 3 -random_samples 3 -grid 3 3 3";
    let one = count(&folder, &format!("{flags} -threads 1"));
    for threads in [2, 7] {
        assert_eq!(count(&folder, &format!("{flags} -threads {threads}")), one);
    }
}

/// `text`, with `#` for every digit in the values of these labels.
fn masked(text: &str, labels: &[&str]) -> String {
    let mask = |line: &str| {
        let timed = labels.iter().any(|label| line.trim_start().starts_with(label));
        if timed { line.replace(|c: char| c.is_ascii_digit(), "#") } else { line.to_owned() }
    };
    text.split_inclusive('\n').map(mask).collect()
}

/// Runs of `#` are merged, because times differ in their number of digits.
fn squeezed(mut text: String) -> String {
    while text.contains("##") {
        text = text.replace("##", "#");
    }
    text
}

#[test]
fn the_blocks_are_laid_out_byte_for_byte() {
    let folder = scene(1, "", 2, "Sphere { center 0 0 0 radius 1.5 } Plane { normal 0 0 1 offset -9 }");
    let run = folder.run("-input s.txt -stats -size 20 10 -shadows -threads 2").ok();
    let times = ["total time", "rays per second", "reading", "building", "rendering", "writing"];
    assert_eq!(
        squeezed(masked(&run.stdout, &times)),
        "\
********************************************
RAY TRACING STATISTICS
  total time                 #:#:#.#
  num pixels                 200 (20x10)
  scene bounds               -1.500000 -1.500000 -1.500000  -> 1.500000 1.500000 1.500000
  num grid cells             NULL
  num non-shadow rays        200
  num shadow rays            200
  total intersections        800
  total cells traversed      0
  rays per second            #.#
  rays per pixel             2.0
  intersections per ray      2.0
  cells traversed per ray    0.0
********************************************
  reading                    #.# ms
  building                   #.# ms
  rendering                  #.# ms
  writing                    #.# ms
  threads                    2
"
    );
    let time = run.stdout.lines().nth(2).unwrap().trim_start_matches("  total time").trim_start();
    assert_eq!(masked(time, &[""]), "#:##:##.###");
    let run = folder.run("-input s.txt -stats -size 20 10 -grid 10 10 7").ok();
    assert!(run.stdout.contains("\n  num grid cells             700 (10x10x7)\n"));
}

#[test]
fn repeated_renderings_have_their_times_in_a_block_of_their_own() {
    let folder = Folder::with_scene(&sphere());
    let block = "  rendered                   3 times\n  least                      #.# ms\n  \
                 median                     #.# ms\n  spread                     #.# ms\n";
    let labels = ["least", "median", "spread"];
    let alone = folder.run("-input s.txt -size 20 10 -repeat 3 -output o.tga").ok();
    assert_eq!(squeezed(masked(&alone.stdout, &labels)), block);
    let with_stats = folder.run("-input s.txt -size 20 10 -repeat 3 -stats").ok().stdout;
    assert!(squeezed(masked(&with_stats, &labels)).ends_with(block), "{with_stats}");
    // The picture and the counters are those of one rendering.
    let once = folder.run("-input s.txt -size 20 10 -stats -output p.tga").ok().stdout;
    assert!(folder.read("o.tga") == folder.read("p.tga"));
    let counters =
        |text: &str| text.lines().filter(|line| line.contains("num ")).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(counters(&with_stats), counters(&once));
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
