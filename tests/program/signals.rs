//! Ctrl-C, SIGTERM and SIGHUP: what a run leaves, what it says, and how it ends.
#![cfg(unix)]

use crate::support::{Folder, Run, send, sphere};
use nix::sys::signal::Signal;
use raytracer::image_io::{PartFile, read_picture};
use std::io::Read;
use std::process::{Child, Stdio};
use std::thread::sleep;
use std::time::Duration;

/// A picture of so many rows that no test waits for all of them, each of which takes a moment.
const LONG: &str = "-input s.txt -size 20 60000 -random_samples 1000 -shadows";
/// A picture of one row, for which no test waits.
const ONE_ROW: &str = "-input s.txt -size 60000 1 -random_samples 65536 -output o.tga";

fn start(folder: &Folder, line: &str) -> Child {
    folder.command(line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts")
}

fn wait(mut child: Child) -> Run {
    let status = child.wait().expect("the program ends").code();
    let [mut stdout, mut stderr] = [String::new(), String::new()];
    child.stdout.unwrap().read_to_string(&mut stdout).unwrap();
    child.stderr.unwrap().read_to_string(&mut stderr).unwrap();
    Run { status, stdout, stderr }
}

/// Tries with more and more time before the first signal, until it comes while rows are rendered.
fn try_longer<T>(mut attempt: impl FnMut(Duration) -> Option<T>) -> T {
    (0..12).find_map(|k| attempt(Duration::from_millis(100 << k))).expect("a row in seven minutes")
}

/// A run that is stopped by a signal when some rows are complete, and their number.
fn stopped(folder: &Folder, line: &str, signal: Signal) -> (Run, usize) {
    try_longer(|patience| {
        let child = start(folder, line);
        sleep(patience);
        send(signal, &child);
        let run = wait(child);
        let rows = run.stderr.strip_prefix("stopped at row ")?.split(' ').next()?.parse().ok()?;
        run.stderr.contains("; wrote o.partial.tga").then_some((run, rows))
    })
}

#[test]
fn complete_rows_are_kept_as_parts() {
    let pictures = "-output o.tga -depth 1 9 d.png -normals n.tga -render_samples s.png 1";
    for (signal, status) in [(Signal::SIGINT, 130), (Signal::SIGTERM, 143), (Signal::SIGHUP, 129)] {
        let folder = Folder::with_scene(&sphere());
        folder.write("o.tga", "an earlier picture");
        let (run, rows) = stopped(&folder, &format!("{LONG} {pictures}"), signal);
        assert_eq!((run.status, run.stdout.as_str()), (Some(status), ""));
        let expected = ["d.partial.png", "n.partial.tga", "o.partial.tga", "o.tga", "s.partial.png", "s.txt"];
        assert_eq!(folder.names(), expected);
        assert_eq!(folder.read("o.tga"), b"an earlier picture");

        // They are the files that these rows alone make.
        folder.run(&format!("{LONG} {pictures} -region 0 0 20 {rows}")).ok();
        for (kept, own) in [("o.partial.tga", "o.tga"), ("n.partial.tga", "n.tga")] {
            assert!(folder.read(kept) == folder.read(own), "{kept}");
        }
        for (kept, own) in [("d.partial.png", "d.png"), ("s.partial.png", "s.png")] {
            let [kept, own] = [kept, own].map(|name| folder.path().join(name));
            assert_eq!(read_picture(&kept).unwrap(), read_picture(&own).unwrap());
            let own = PartFile { path: kept.clone(), ..PartFile::open(&own).unwrap() };
            assert_eq!(PartFile::open(&kept).unwrap(), own);
        }
    }
}

#[test]
fn the_printed_lines_make_the_picture() {
    let folder = Folder::with_scene(&sphere());
    let names = ["o.tga", "d.png", "s.png"];
    let written = "-output o.tga -depth 1 9 d.png -render_samples s.png 3";
    for region in ["", " -region 3 50 9 400"] {
        // The picture takes about as long as the signal, whatever the machine.
        let (mut samples, mut patience) = (64, Duration::from_millis(100));
        let (flags, run) = (0..24)
            .find_map(|_| {
                let flags = format!("-input s.txt -size 20 500 -random_samples {samples} {written}{region}");
                let child = start(&folder, &flags);
                sleep(patience);
                send(Signal::SIGINT, &child);
                let run = wait(child);
                match (run.status, run.stderr.contains("; the rest: ")) {
                    (Some(130), true) => return Some((flags, run)),
                    (Some(0), _) => samples = (2 * samples).min(60_000),
                    _ => patience *= 2,
                }
                None
            })
            .expect("a row in time");
        let lines = run.stderr.lines().map(|line| line.split_once(": ").expect("a command").1);
        for line in lines.map(|line| line.rsplit("the rest: ").next().expect("a line")) {
            let program = env!("CARGO_BIN_EXE_raytracer");
            folder.run(line.strip_prefix(program).expect("the program").trim()).ok();
        }
        let made = names.map(|name| read_picture(&folder.path().join(name)).expect("a picture"));
        folder.run(&flags).ok();
        for (name, made) in names.iter().zip(made) {
            assert!(made == read_picture(&folder.path().join(name)).expect("a picture"), "{name}{region}");
        }
    }
}

#[test]
fn the_second_signal_ends_at_once() {
    // Either of two signals that come together may be taken first.
    for (first, second, statuses) in
        [(Signal::SIGINT, Signal::SIGTERM, [130, 143]), (Signal::SIGHUP, Signal::SIGINT, [129, 130])]
    {
        let folder = Folder::with_scene(&sphere());
        // Within a few hundred rays, the first one would end the run, too.
        let run = try_longer(|patience| {
            let child = start(&folder, ONE_ROW);
            sleep(patience);
            send(first, &child);
            send(second, &child);
            Some(wait(child)).filter(|run| run.stderr.is_empty())
        });
        assert!(statuses.map(Some).contains(&run.status), "{run:?}");
        assert_eq!(run.stdout, "");
        assert_eq!(folder.names(), ["s.txt"]);
    }
}

/// A ray that is mirrored two thousand million times within a box, and one that splits a thousand times.
#[test]
fn a_pixel_that_takes_too_long_is_left_in_the_middle() {
    for (material, bounces) in [("", 2147483647), ("transparentColor 1 1 1", 1000)] {
        let folder = Folder::with_scene(&format!(
            "PerspectiveCamera {{ center .1 .2 .3 direction 3 2 1 up 0 1 0 angle 40 }}
             Lights {{ numLights 0 }} Materials {{ numMaterials 1
             Material {{ diffuseColor .5 .5 .5 reflectiveColor 1 1 1 {material} }} }}
             Group {{ numObjects 2 MaterialIndex 0 Box {{ min -1 -1 -1 max 1 1 1 }}
             Box {{ min -2 -2 -2 max 2 2 2 }} }}"
        ));
        for flags in ["-stats", "-output o.tga -gaussian_filter 0.4 -random_samples 4"] {
            let line = format!("-input s.txt -size 1 1 -bounces {bounces} -shade_back {flags}");
            let run = try_longer(|patience| {
                let child = start(&folder, &line);
                sleep(patience);
                send(Signal::SIGTERM, &child);
                Some(wait(child)).filter(|run| run.stderr.contains("stopped"))
            });
            assert_eq!((run.status, run.stdout.as_str()), (Some(143), ""), "{line}");
            assert!(run.stderr.ends_with("stopped at row 0 of 1; wrote nothing\n"), "{line}: {}", run.stderr);
            assert_eq!(folder.names(), ["s.txt"]);
        }
    }
}

/// Scenes of which one ray takes long: 4000 ellipsoids in almost one place, and 4000 lights in the plane of 4000
/// triangles.
fn scenes_of_long_rays() -> [String; 2] {
    let camera = "PerspectiveCamera { center 0 0 8 direction 0 0 -1 up 0 1 0 angle 40 }";
    let ellipsoid = |k: usize| {
        let radius = 1.0 - k as f64 * 4e-16;
        format!("Transform {{ Scale 1 .5 2 Sphere {{ center 0 0 0 radius {radius} }} }}\n")
    };
    let light = |k: usize| {
        let [x, y] = [k % 64, k / 64].map(|k| k as f64 / 64.0 - 0.5);
        format!("PointLight {{ position {x} {y} 1 color 1 1 1 }}\n")
    };
    let triangles = "Triangle { vertex0 -1 -1 1 vertex1 3 -1 1 vertex2 -1 3 1 }\n".repeat(4000);
    let ellipsoids: String = (0..4000).map(ellipsoid).collect();
    let lights: String = (0..4000).map(light).collect();
    [(ellipsoids, String::new()), (triangles, lights)].map(|(objects, lights)| {
        let number = lights.lines().count();
        format!(
            "{camera} Lights {{ numLights {number} {lights} }}
             Group {{ numObjects 4000 Material {{ }} {objects} }}"
        )
    })
}

#[test]
fn a_ray_that_takes_long_is_left_in_the_middle() {
    leave_rays(&["-shadows"]);
}

#[test]
#[ignore = "slow: twenty seconds"]
fn a_ray_that_takes_long_is_left_in_the_middle_with_any_flags() {
    leave_rays(&["-shadows -stats -grid 20 20 20", "-transparent_shadows", "-adaptive_samples 64 2"]);
}

/// Ends runs with these flags, in which single rays take long.
fn leave_rays(all_flags: &[&str]) {
    for scene in scenes_of_long_rays() {
        let folder = Folder::with_scene(&scene);
        for flags in all_flags {
            let child = start(&folder, &format!("-input s.txt -size 900 900 -output o.tga {flags}"));
            // The picture would take hours.
            sleep(Duration::from_secs(2));
            send(Signal::SIGTERM, &child);
            let run = wait(child);
            assert_eq!((run.status, run.stdout.as_str()), (Some(143), ""), "{flags}");
            assert!(!folder.names().contains(&"o.tga".to_string()), "{flags}");
        }
    }
}
