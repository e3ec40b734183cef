//! Signals while a run waits for a pipe, and at random moments: it ends at once, keeps what is complete, and leaves no
//! temporary file.
#![cfg(target_os = "linux")]

#[cfg(feature = "gui")]
use crate::live_server::{Server, view};
#[cfg(feature = "gui")]
use crate::support::scene;
use crate::support::{Folder, send, sphere};
use nix::fcntl::{FcntlArg, OFlag, fcntl};
use nix::sys::signal::Signal;
#[cfg(feature = "gui")]
use serde_json::json;
use std::fs::OpenOptions;
use std::io::{PipeWriter, Write, pipe};
use std::os::fd::AsFd;
use std::os::unix::fs::OpenOptionsExt;
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::{self, sleep};
use std::time::{Duration, Instant};

const ENDING: [(Signal, i32); 3] = [(Signal::SIGINT, 130), (Signal::SIGTERM, 143), (Signal::SIGHUP, 129)];

/// The status of a run that ends by itself; none if it does not.
fn end(child: &mut Child) -> Option<ExitStatus> {
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(20) {
        if let Some(status) = child.try_wait().expect("a status") {
            return Some(status);
        }
        sleep(Duration::from_millis(1));
    }
    let _ = child.kill();
    let _ = child.wait();
    None
}

/// Does something for each signal and the status with which it ends a run. All wait at the same time.
fn for_each_signal(work: impl Fn(Signal, i32) + Sync) {
    thread::scope(|scope| {
        for (signal, status) in ENDING {
            let work = &work;
            scope.spawn(move || work(signal, status));
        }
    });
}

/// Sends a signal to a run that waits. What it is waiting for never comes.
fn interrupt(command: &mut Command, signal: Signal) -> Option<i32> {
    let mut child = command.stderr(Stdio::null()).spawn().expect("the program starts");
    // It has nothing to do, so that it sleeps when it has come to the pipe.
    let is_asleep = |child: &Child| {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", child.id())).unwrap_or_default();
        stat.rsplit(')').next().is_some_and(|rest| rest.trim_start().starts_with('S'))
    };
    let mut times = 0;
    while times < 20 {
        sleep(Duration::from_millis(10));
        times = if is_asleep(&child) { times + 1 } else { 0 };
    }
    send(signal, &child);
    end(&mut child).and_then(|status| status.code())
}

#[test]
fn a_signal_ends_the_wait_for_a_scene() {
    let folder = Folder::with_scene(&sphere());
    folder.make_pipe("p");
    for_each_signal(|signal, status| {
        let line = "-input p -output o.tga";
        assert_eq!(interrupt(&mut folder.command(line), signal), Some(status), "{signal} {line}");
        let line = "-input - -output o.tga";
        // A part of the scene has come.
        let (input, mut output) = pipe().expect("a pipe");
        output.write_all(b"OrthographicCamera {").unwrap();
        assert_eq!(interrupt(folder.command(line).stdin(input), signal), Some(status), "{signal} {line}");
    });
    assert_eq!(folder.names(), ["p", "s.txt"]);
}

#[test]
fn a_signal_ends_the_wait_for_the_reader_of_a_pipe() {
    let folder = Folder::with_scene(&sphere());
    for name in ["p", "p.json", "p.html"] {
        folder.make_pipe(name);
    }
    folder.run("-input s.txt -size 4 4 -region 0 0 4 4 -output a.tga").ok();
    std::fs::create_dir_all(folder.path().join("name")).unwrap();
    for_each_signal(|signal, status| {
        for line in [
            "-input s.txt -normals n.tga -output p tga",
            "-input s.txt -normals n.tga -json p.json",
            "-merge a.tga -output p tga",
            "-grade . -reference . -report p.html",
        ] {
            assert_eq!(interrupt(&mut folder.command(line), signal), Some(status), "{signal} {line}");
        }
    });
    assert_eq!(folder.names(), ["a.tga", "name", "p", "p.html", "p.json", "s.txt"]);
}

#[test]
fn a_signal_ends_the_wait_for_room_in_a_pipe_and_complete_pictures_are_kept() {
    // Readers that do not read, of a pipe without room.
    let open = |folder: &Folder, name: &str| {
        let open = |options: &mut OpenOptions| {
            options.custom_flags(nix::libc::O_NONBLOCK).open(folder.path().join(name)).unwrap()
        };
        let reader = open(OpenOptions::new().read(true));
        let mut writer = open(OpenOptions::new().write(true));
        while writer.write(&[0; 4096]).is_ok() {}
        (reader, writer)
    };
    for_each_signal(|signal, status| {
        let folder = Folder::with_scene(&sphere());
        folder.run("-input s.txt -size 200 200 -normals expected.tga").ok();
        folder.run("-input s.txt -size 200 200 -output b.tga").ok();
        let _readers = ["p", "p.json", "d.png"].map(|name| {
            folder.make_pipe(name);
            open(&folder, name)
        });
        for line in [
            "-input s.txt -size 200 200 -output p tga -normals n.tga -depth 1 2 d.tga",
            "-input s.txt -size 200 200 -normals n.tga -json p.json",
            "-input s.txt -size 200 200 -normals n.tga -compare b.tga -difference d.png",
        ] {
            folder.write("n.tga", "an earlier picture");
            let mut command = folder.command(line);
            assert_eq!(interrupt(command.stdout(Stdio::null()), signal), Some(status), "{signal} {line}");
            assert!(folder.read("n.tga") == folder.read("expected.tga"), "{signal} {line}");
        }
        let (_reader, output) = pipe().expect("a pipe");
        let line = "-input s.txt -size 200 200 -output - tga";
        assert_eq!(interrupt(folder.command(line).stdout(output), signal), Some(status), "{signal} {line}");
        // A text that nobody reads.
        let (_reader, mut output) = pipe().expect("a pipe");
        fill_up(&mut output);
        let line = "-input s.txt -size 4 4 -stats";
        assert_eq!(interrupt(folder.command(line).stdout(output), signal), Some(status), "{signal} {line}");
        assert!(folder.names().iter().all(|name| !name.starts_with('.')), "{:?}", folder.names());
    });
}

/// Writes to a pipe until there is no room in it.
fn fill_up(output: &mut PipeWriter) {
    let own = output.as_fd().try_clone_to_owned().unwrap();
    let flags = OFlag::from_bits_retain(fcntl(&own, FcntlArg::F_GETFL).unwrap());
    fcntl(&own, FcntlArg::F_SETFL(flags | OFlag::O_NONBLOCK)).unwrap();
    while output.write(&[0; 1]).is_ok() {}
    fcntl(&own, FcntlArg::F_SETFL(flags)).unwrap();
}

#[test]
fn a_run_that_is_told_to_outlive_its_terminal_does() {
    let folder = Folder::with_scene(&sphere());
    let program = env!("CARGO_BIN_EXE_raytracer");
    let line = "-input s.txt -size 20 60000 -random_samples 1000 -output o.tga";
    let script = format!("trap '' HUP; exec {program} {line}");
    let mut child = Command::new("sh")
        .args(["-c", &script])
        .current_dir(folder.path())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    sleep(Duration::from_millis(300));
    send(Signal::SIGHUP, &child);
    sleep(Duration::from_millis(300));
    assert!(child.try_wait().unwrap().is_none(), "SIGHUP was to be ignored");
    send(Signal::SIGTERM, &child);
    assert_eq!(end(&mut child).and_then(|status| status.code()), Some(143));
}

/// Ends runs, each at another moment.
#[test]
fn no_ending_signal_leaves_a_temporary_file() {
    const RUNS: u32 = 60;
    let folder = Folder::with_scene(&sphere());
    let line = "-input s.txt -size 9 9 -threads 2 -output a.tga -normals b.png -depth 1 9 c.exr -render_samples d.tga 2";
    let pictures = ["a.tga", "b.png", "c.exr", "d.tga", "s.txt"];
    let times = (0..9).map(|_| {
        let start = Instant::now();
        folder.run(line).ok();
        start.elapsed()
    });
    let whole = times.min().unwrap_or_default();
    let mut ended = 0;
    for run in 0..RUNS {
        let mut child = folder.command(line).stderr(Stdio::null()).spawn().expect("the program starts");
        sleep(whole * (run % 50) / 40);
        send(ENDING[run as usize % ENDING.len()].0, &child);
        let status = end(&mut child).expect("the run ends");
        ended += u32::from(status.signal().is_some() || status.code() != Some(0));
        let left = folder.names();
        let is_known = |name: &&String| pictures.contains(&name.as_str()) || name.contains(".partial.");
        assert!(left.iter().filter(|name| !is_known(name)).count() == 0, "run {run}: {left:?}");
    }
    // On a busy machine most signals come when the run is over.
    assert!(60 * ended > RUNS, "only {ended} runs were ended");
}

#[cfg(feature = "gui")]
#[test]
fn a_page_ends_by_a_signal_and_saves_no_picture_over_what_is_read() {
    let folder = Folder::with_scene(&scene(1, "TriangleMesh { obj_file m.obj }"));
    folder.write("m.obj", "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n");
    let saved = json!({ "view": view(0, "-size 8 8") });
    for (signal, status) in ENDING {
        let mut server = Server::start(folder.path(), "-output o.tga -normals n.png -size 8 8");
        for (name, target, message) in [
            ("o.tga", "s.txt", "`o.tga` would overwrite the scene `s.txt`"),
            ("n.png", "m.obj", "`n.png` would overwrite the mesh `m.obj`"),
            ("n.png", "o.tga", "`o.tga` and `n.png` are the same file"),
        ] {
            let path = folder.path().join(name);
            std::fs::remove_file(&path).unwrap();
            std::os::unix::fs::symlink(target, &path).unwrap();
            let (status, body) = server.ask("/save", &saved).unwrap_err();
            assert!(status == 422 && body.contains(message), "{status} {body}");
            std::fs::remove_file(&path).unwrap();
            folder.write(name, "");
        }
        server.ask("/save", &saved).expect("saved");
        send(signal, &server.child);
        assert_eq!(end(&mut server.child).and_then(|status| status.code()), Some(status));
        assert_eq!(folder.names(), ["m.obj", "n.png", "o.tga", "s.txt"]);
    }
}
