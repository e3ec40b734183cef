//! Runs with little memory: each stage of a run ends with its result or with one line, never by a signal.
#![cfg(target_os = "linux")]

#[cfg(feature = "gui")]
use crate::live_server::{Server, view};
#[cfg(feature = "gui")]
use crate::support::sphere;
use crate::support::{CAMERA, Folder, Run, finish, only_line, scene};
#[cfg(feature = "gui")]
use serde_json::json;
use std::fmt::Write;
use std::thread;

/// Runs the program, which may take this number of kilobytes of address space.
fn run_within(folder: &Folder, kilobytes: usize, line: &str) -> Run {
    finish(&mut folder.command_within(&format!("-v {kilobytes}"), line))
}

/// The least memory, in kilobytes, with which the system loads the program.
fn least(folder: &Folder) -> usize {
    let starts = |kilobytes: &usize| run_within(folder, *kilobytes, "-version").status == Some(0);
    (2000..).step_by(500).find(starts).expect("the program starts")
}

/// Where this number of spheres stand.
fn spheres(count: usize) -> String {
    (0..count).fold(String::new(), |mut text, k| {
        let _ = writeln!(text, "Sphere {{ center {} {} 0 radius .01 }}", k % 100, k / 100);
        text
    })
}

/// A strip of triangles, as an OBJ file in which each corner has this suffix.
fn strip(count: usize, suffix: &str) -> String {
    let mut text = "vn 0 0 1\n".repeat(usize::from(!suffix.is_empty()));
    for k in 0..count + 2 {
        let _ = writeln!(text, "v {} {} 0", k as f64 / count as f64, k % 2);
    }
    for k in 1..=count {
        let _ = writeln!(text, "f {k}{suffix} {}{suffix} {}{suffix}", k + 1, k + 2);
    }
    text
}

/// Each stage, with a scene and files that make it take most of the memory.
const STAGES: &[(&str, &str)] = &[
    ("a list of spheres", "-input spheres.txt -grid none -size 5 5 -output o.tga"),
    ("materials", "-input materials.txt -output o.tga"),
    ("transforms in transforms", "-input deep.txt -output o.tga"),
    ("groups in groups", "-input groups.txt -output o.tga"),
    ("copies of a mesh", "-input copies.txt -grid none -size 5 5 -output o.tga"),
    ("a plain mesh", "-input plain.txt -grid none -size 9 9 -output o.tga"),
    ("a mesh with normals", "-input normals.txt -grid none -size 9 9 -output o.tga"),
    ("an automatic grid", "-input spheres.txt -grid auto -output o.png"),
    ("cells", "-input one.txt -grid 150 150 150 -output o.tga"),
    ("a view of cells", "-input one.txt -grid 150 150 150 -visualize_grid -size 20 20 -output o.tga"),
    ("a wide filter", "-input one.txt -size 900 60 -gaussian_filter 20 -output o.tga"),
    ("adaptive samples", "-input one.txt -size 3000 30 -adaptive_samples 8 4 -output o.tga"),
    ("layers", "-input one.txt -size 1200 400 -depth 0 9 d.tga -normals n.png -output o.tga"),
    ("enlarged samples", "-input one.txt -size 300 90 -random_samples 2 -render_samples o.tga 9"),
    ("a map of costs", "-input one.txt -size 600 600 -cost_map rays o.tga"),
    ("pictures compared", "-compare a.png -reference b.tga -difference o.png"),
    ("a cause", "-input one.txt -size 700 500 -compare a.png"),
    ("a pixel", "-input plain.txt -size 9 9 -pixel 4 4"),
    ("a document", "-input one.txt -size 9 9 -random_samples 500 -pixel 4 4 -json o.json"),
    ("threads", "-input one.txt -size 9 9 -threads 40 -output o.tga"),
];

fn folder() -> Folder {
    const DEPTH: usize = 20_000;
    let nested = |open: &str| {
        let inner = "Sphere { center 0 0 0 radius 1 }";
        scene(1, &format!("{}{inner}{}", open.repeat(DEPTH), "}".repeat(DEPTH)))
    };
    let mesh = |name: &str| scene(1, &format!("TriangleMesh {{ obj_file {name} }}"));
    let folder = Folder::new();
    folder.write("one.txt", scene(1, "Sphere { center 0 0 0 radius .7 }"));
    folder.write("spheres.txt", scene(20_000, &spheres(20_000)));
    let materials = format!("Materials {{ numMaterials 20000 {} }}", "Material { }\n".repeat(20_000));
    folder.write("materials.txt", format!("{CAMERA}{materials}Group {{ numObjects 0 }}"));
    folder.write("deep.txt", nested("Transform { Translate 0 0 0 "));
    folder.write("groups.txt", nested("Group { numObjects 1 "));
    folder.write("plain.txt", mesh("plain.obj"));
    folder.write("plain.obj", strip(30_000, ""));
    folder.write("normals.txt", mesh("normals.obj"));
    folder.write("normals.obj", strip(30_000, "//1"));
    folder.write("copies.txt", scene(1001, &"TriangleMesh { obj_file short.obj }\n".repeat(1001)));
    folder.write("short.obj", strip(300, ""));
    folder.run("-input one.txt -size 700 500 -output a.png").ok();
    folder.run("-input one.txt -size 700 500 -shade_back -grid 2 2 2 -normals b.tga").ok();
    folder
}

/// What is wrong with a run that may fail for want of memory only; nothing if all is well.
fn fault(run: &Run, line: &str, is_complete: bool) -> Option<&'static str> {
    let is_error = |line: &&str| line.contains("error: ");
    let last = run.stderr.lines().last().filter(is_error);
    // Warnings may stand before it.
    let is_one_line =
        run.stderr.lines().filter(is_error).count() == 1 && last.is_some_and(|line| line.contains("memory"));
    match run.status {
        Some(0) if is_complete => None,
        Some(0) => Some("a file is missing"),
        Some(1) if line.contains("-threads") && run.stderr.starts_with("error: `-threads`: ") => None,
        Some(1) if is_one_line => None,
        Some(1) => Some("not one line about memory"),
        _ => Some("neither status 0 nor 1"),
    }
}

/// Every third stage, with fewer amounts of memory.
#[test]
fn some_stages_end_well_with_any_amount_of_memory() {
    try_stages(3, 2);
}

#[test]
#[ignore = "slow: a minute"]
fn every_stage_ends_well_with_any_amount_of_memory() {
    try_stages(1, 8);
}

/// Tries every `step`th stage with more and more memory, which grows by one `part`th each time.
fn try_stages(step: usize, part: usize) {
    let folder = folder();
    let files = folder.names();
    let least = least(&folder);
    let mut wrong = String::new();
    for (stage, line) in STAGES.iter().step_by(step) {
        let outputs = ["o.tga", "o.png", "o.json", "d.tga", "n.png"];
        let outputs: Vec<&str> = outputs.into_iter().filter(|name| line.contains(name)).collect();
        let mut failures = 0;
        let mut kilobytes = least;
        loop {
            let run = run_within(&folder, kilobytes, line);
            let written = outputs.iter().filter(|name| folder.path().join(name).exists()).count();
            if let Some(fault) = fault(&run, line, written == outputs.len()) {
                let _ = writeln!(wrong, "{stage}, {kilobytes} kB: {fault}: {run:?}");
            }
            outputs.iter().for_each(|name| drop(std::fs::remove_file(folder.path().join(name))));
            if folder.names() != files {
                let _ = writeln!(wrong, "{stage}, {kilobytes} kB: files are left: {:?}", folder.names());
            }
            if run.status == Some(0) || kilobytes > 4_000_000 {
                break;
            }
            failures += 1;
            kilobytes += kilobytes / part;
        }
        assert!(failures > 0, "{stage}: needs no memory");
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

#[test]
fn a_refusal_says_how_much_would_be_needed() {
    let folder = folder();
    for (line, needed) in [("-input plain.txt", "3.1 MB"), ("-input copies.txt", "10.8 MB")] {
        let message = run_within(&folder, least(&folder) + 1500, line).message(1);
        let error = format!("error: not enough memory: at least {needed} are needed");
        assert!(message.contains(&error) && message.matches("error: ").count() == 1, "{line}\n{message}");
    }
}

/// The blocks of a grid take many times as much as its cells.
#[test]
fn the_blocks_of_a_grid_are_asked_for() {
    let folder = Folder::new();
    let triangle = |k: usize| {
        let [x, y] = [k as f64 / 40.0, 1.0 - k as f64 / 40.0];
        format!("Triangle {{ vertex0 {x} -1 {y} vertex1 -{y} {x} -1 vertex2 1 {y} {x} }}\n")
    };
    folder.write("s.txt", scene(40, &(0..40).map(triangle).collect::<String>()));
    let kilobytes = least(&folder) + 10_000;
    let grid = |cells: usize| {
        let line = format!("-input s.txt -size 5 5 -output o.tga -threads 1 -grid {cells} {cells} {cells}");
        run_within(&folder, kilobytes, &line)
    };
    grid(10).ok();
    let message = grid(60).message(1);
    assert!(only_line(&message).starts_with("error: the grid does not fit into memory"), "{message}");
}

/// A block of an EXR file may take a thousand times as much as in the file.
#[test]
fn a_compressed_block_is_asked_for() {
    let folder = Folder::with_scene(&scene(1, "Sphere { center 0 0 0 radius 1 }"));
    folder.run("-input s.txt -size 1 1 -output small.exr").ok();
    let mut bytes = folder.read("small.exr");
    let after = |bytes: &[u8], text: &[u8]| {
        bytes.windows(text.len()).position(|part| part == text).expect("the attribute") + text.len()
    };
    let compression = after(&bytes, b"compression\0compression\0\x01\0\0\0");
    let window_end = after(&bytes, b"dataWindow\0box2i\0\x10\0\0\0") + 8;
    let places = after(&bytes, b"screenWindowWidth\0float\0\x04\0\0\0\0\0\x80\x3f\0");
    // One block of ZIP with 16 rows of 300,000 pixels, of three floats each.
    let block = fdeflate::compress_to_vec(&vec![0; 300_000 * 16 * 12]);
    bytes[compression] = 3;
    bytes[window_end..window_end + 8].copy_from_slice([299_999_i32, 15].map(i32::to_le_bytes).as_flattened());
    bytes.truncate(places + 8);
    bytes.extend([0, block.len() as i32].map(i32::to_le_bytes).as_flattened());
    bytes.extend(block);
    folder.write("large.exr", bytes);
    let convert = |kilobytes| run_within(&folder, kilobytes, "-convert large.exr -output o.png");
    convert(least(&folder) + 300_000).ok();
    let message = convert(least(&folder) + 30_000).message(1);
    assert!(only_line(&message).contains("large.exr") && message.contains("memory"), "{message}");
}

#[cfg(feature = "gui")]
#[test]
fn the_live_page_refuses_beforehand_and_goes_on() {
    let folder = Folder::with_scene(&sphere());
    folder.write("m.obj", format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{}", "f 1 2 3\n".repeat(30_000)));
    // It is not read.
    std::fs::File::create(folder.path().join("large.obj"))
        .and_then(|file| file.set_len(1 << 26))
        .expect("a file");
    let line = "-input s.txt -gui -port 0 -no_browser -threads 2";
    let server = Server::of(folder.command_within("-v 200000", line));
    let picture = |words: &str| {
        let question = json!({ "view": view(0, words), "sketch": null });
        server.ask("/picture", &question).map(drop)
    };
    let typed = |count: usize, file: &str| {
        let text = scene(count, &format!("TriangleMesh {{ obj_file {file} }}\n").repeat(count));
        let said = server.ask("/scene", &json!({ "text": text })).expect("an answer").0;
        said["error"]["problem"].as_str().map(str::to_owned)
    };
    let refused = |size: &str| format!("not enough memory: at least {size} are needed");
    assert_eq!(picture("-size 2000 2000").unwrap_err().1.trim_end(), refused("256.0 MB"));
    assert_eq!(typed(1, "large.obj"), Some(refused("174.5 MB")));
    assert_eq!(typed(30, "m.obj"), Some(refused("230.4 MB")));
    assert_eq!((typed(1, "m.obj"), picture("-size 20 20")), (None, Ok(())));
}

#[cfg(feature = "gui")]
#[test]
fn many_requests_at_once_do_not_end_the_live_page() {
    let folder = Folder::with_scene(&sphere());
    let line = "-input s.txt -gui -port 0 -no_browser -threads 2";
    let server = Server::of(folder.command_within("-v 300000", line));
    let question =
        json!({ "view": view(0, "-size 300 300 -jittered_samples 9"), "sketch": null }).to_string();
    let ask = || server.post("/picture", &[], question.as_bytes()).map(|(status, _)| status);
    for _ in 0..2 {
        let answers: Vec<Option<u16>> = thread::scope(|scope| {
            let all: Vec<_> = (0..20).map(|_| scope.spawn(ask)).collect();
            all.into_iter().map(|one| one.join().expect("an answer")).collect()
        });
        // A request for which there is no memory, or no thread, is refused.
        assert!(answers.iter().all(|status| matches!(status, Some(200 | 422 | 503))), "{answers:?}");
    }
    assert!(server.is_alive());
    assert_eq!(ask(), Some(200));
}

/// The variable that the library of threads reads has no effect: `-threads` and the picture's rows decide.
#[test]
fn the_environment_does_not_choose_the_number_of_threads() {
    let folder = Folder::new();
    folder.write("one.txt", scene(1, "Sphere { center 0 0 0 radius .7 }"));
    let threads = |flags: &str, variable: &str| -> usize {
        let line = format!("-input one.txt -stats {flags}");
        let run = finish(folder.command(&line).env("RAYON_NUM_THREADS", variable)).ok();
        run.value("threads").parse().unwrap()
    };
    assert_eq!((threads("-threads 3", "7"), threads("-threads 1", "100000")), (3, 1));
    // Those that begin when all rows are done do not count, so that there may be fewer than cores.
    let cores = std::thread::available_parallelism().unwrap().get();
    assert!((1..=cores).contains(&threads("", "100000")));
    assert!(threads("-size 8 8 -threads 4096", "1") <= cores.max(8));
}
