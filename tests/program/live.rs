//! The server of the live page, asked over plain sockets: who is let in, what is refused, and that it stays alive.

use crate::live_server::{Server, view};
use crate::support::{Folder, scene, sphere, sphere_in_perspective};
use serde_json::json;
use std::io::{Read, Write};
use std::net::Shutdown;
use std::thread;
use std::time::{Duration, Instant};

#[test]
fn a_picture_of_the_page_is_the_one_that_its_command_line_writes() {
    let folder =
        Folder::with_scene(&scene(2, "Sphere { center 0 0 0 radius .7 } Plane { normal 0 1 0 offset -.5 }"));
    let server = Server::start(folder.path(), "-output o.tga -size 30 20");
    for words in [
        "-size 33 21 -shadows -jittered_samples 5 -tent_filter 1 -grid auto",
        "-size 9 9 -grid 3 4 5 -visualize_grid",
    ] {
        let question = json!({ "view": view(0, words) });
        let (meta, bytes) = server.ask("/picture", &question).expect("a picture");
        let line = meta["command"].as_str().and_then(|line| line.strip_prefix("raytracer ")).expect("a line");
        folder.run(line).ok();
        let pixels: Vec<[u8; 3]> = bytes.chunks(4).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
        assert_eq!(folder.tga("o.tga").pixels, pixels, "{line}");
    }
}

#[test]
fn the_page_takes_the_size_of_the_picture_to_compare_with() {
    let folder = Folder::with_scene(&sphere_in_perspective());
    folder.run("-input s.txt -size 27 18 -output small.png").ok();
    folder.run("-input s.txt -size 2100 3 -output wide.png").ok();
    for (flags, size) in [
        ("-reference small.png -size 40x30 -shadows", "27x18"),
        ("-compare small.png -size 27 18 -shadows", "27x18"),
        ("-compare wide.png", "2100x3"),
    ] {
        let server = Server::start(folder.path(), flags);
        let (said, _) = server.ask("/start", &json!({})).expect("a start");
        let words = format!("-size {} {}", said["reference"]["size"][0], said["reference"]["size"][1]);
        let question = json!({ "view": view(0, &words) });
        let (found, _) = server.ask("/compare", &question).expect("a comparison");
        let block = found["block"].as_str().expect("a block");
        assert!(block.contains(size), "{flags}: {block}");
    }
    // What the line itself asks for is not left to the page.
    for flags in ["-tolerance 0 0", "-difference d.png"] {
        let line = format!("-input s.txt -gui -port 0 -no_browser -compare small.png {flags}");
        assert!(folder.run(&line).message(1).contains("differ in size"), "{flags}");
    }
}

#[test]
fn a_moved_camera_is_the_one_of_its_block() {
    let text = sphere();
    let folder = Folder::with_scene(&text);
    let server = Server::start(folder.path(), "");
    let block = "PerspectiveCamera { center .1 .2 3 direction 0 -.1 -1 up 0 1 0 angle 33.3 }";
    let mut moved = view(0, "-size 20 20");
    moved["camera"] = json!(block);
    let (_, rest) = text.split_once('\n').expect("the camera has a line");
    folder.write("s.txt", format!("{block}\n{rest}"));
    assert_eq!(server.pixels(moved.clone()), folder.render("-size 20 20").pixels);
    for wrong in
        ["", "Group { numObjects 0 }", &format!("{block} {block}"), "PerspectiveCamera {\n  center x"]
    {
        moved["camera"] = json!(wrong);
        let (status, why) = server.ask("/picture", &json!({ "view": moved })).unwrap_err();
        assert!(status == 422 && why.starts_with("camera:"), "{wrong}: {status} {why}");
    }
}

#[test]
fn nobody_gets_in_without_the_key_the_name_and_the_origin() {
    let folder = Folder::with_scene(&sphere());
    let server = Server::start(folder.path(), "");
    let status = |headers: &[(&str, &str)]| server.post("/start", headers, b"{}").map(|(status, _)| status);
    let (short, long) = (&server.key[1..], format!("{}0", server.key));
    let own = format!("http://127.0.0.1:{}", server.port);
    assert_eq!([status(&[]), status(&[("Origin", &own)])], [Some(200); 2]);
    for header in [
        ("X-Key", ""),
        ("X-Key", "00000000000000000000000000000000"),
        ("X-Key", short),
        ("X-Key", &long),
        ("Host", "evil.example"),
        ("Host", "localhost.evil.example:80"),
        ("Host", "localhost:80x"),
        ("Host", "localhost:"),
        ("Origin", "http://evil.example"),
        ("Origin", "null"),
        ("Origin", "http://127.0.0.1:1"),
    ] {
        assert_eq!(status(&[header]), Some(403), "{header:?}");
    }
    let right = format!("?key={}", server.key);
    for (path, key, expected) in [
        ("/", right.as_str(), 200),
        ("/s.txt", &right, 404),
        ("/", "", 403),
        ("/", "?key=", 403),
        ("/start", "", 403),
        ("/../s.txt", "", 403),
    ] {
        let request = server.request(&format!("GET {path}{key}"), &[("X-Key", "")], b"");
        let request = String::from_utf8(request).expect("text").replace("X-Key: \r\n", "");
        let (status, body) = server.send(request.as_bytes()).expect("an answer");
        let is_page = String::from_utf8(body).expect("text").contains("<canvas id=\"picture\"");
        assert_eq!((status, is_page), (expected, expected == 200), "{path}{key}");
    }
}

#[test]
fn it_listens_on_the_loopback_interface_alone() {
    let folder = Folder::with_scene(&sphere());
    let server = Server::start(folder.path(), "");
    let table = std::fs::read_to_string("/proc/net/tcp").unwrap_or_default();
    let port = format!(":{:04X} ", server.port);
    let listening: Vec<&str> =
        table.lines().filter(|line| line.contains(&port) && line.contains(" 0A ")).collect();
    assert!(listening.iter().all(|line| line.contains("0100007F:")), "{listening:?}");
}

#[test]
fn limits_are_kept() {
    let folder = Folder::with_scene(&sphere());
    let server = Server::start(folder.path(), "");
    let status = |header: (&str, &str)| server.post("/scene", &[header], b"").map(|(status, _)| status);
    assert_eq!(status(("Content-Length", "999999999")), Some(413));
    assert_eq!(status(("Transfer-Encoding", "chunked")), Some(411));
    assert_eq!(status(("A", &"a".repeat(20_000))), Some(431));
    for question in [json!([]), json!({ "text": 3 })] {
        assert_eq!(server.ask("/scene", &question).unwrap_err().0, 400);
    }
    for words in [
        "-size 5000 5000",
        "-random_samples 65536",
        "-bounces 2000000000",
        "-grid 1290 1290 1290",
        "-box_filter 1000000",
        "-output x.png",
        "-threads 4096",
        "-json -",
        "-input /etc/passwd.txt",
        "-help",
    ] {
        let question = json!({ "view": view(0, words) });
        assert_eq!(server.ask("/picture", &question).unwrap_err().0, 422, "{words}");
    }
    assert_eq!(server.ask("/picture", &json!({ "view": view(7, "") })).unwrap_err().0, 410);
    let huge = json!({ "view": view(0, ""), "sketch": [1_u64 << 40, 0] });
    let (meta, _) = server.ask("/picture", &huge).expect("a sketch of the largest size");
    assert_eq!(meta["size"], json!([2048, 1]));
    assert_eq!(folder.names(), ["s.txt"]);
}

#[test]
fn garbage_and_vanishing_browsers_do_no_harm() {
    let folder = Folder::with_scene(&sphere());
    let server = Server::start(folder.path(), "");
    let whole = server.request("POST /picture", &[], json!({ "view": view(0, "") }).to_string().as_bytes());
    for garbage in [
        &b"\0\0\0\0"[..],
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
        b"\r\n\r\n\r\n",
        b"GET / HTTP/9.9\r\n\r\n",
        b"POST / HTTP/1.1\r\nHost: \xff\xfe\r\n\r\n",
        &[b'a'; 100_000],
        &whole[..whole.len() - 3],
        &[&whole[..], b"rest"].concat(),
    ] {
        let mut stream = server.connect();
        let _ = stream.write_all(garbage);
        let _ = stream.shutdown(Shutdown::Write);
        let mut answer = vec![];
        let _ = stream.read_to_end(&mut answer);
        let answer = String::from_utf8_lossy(&answer);
        let status = answer.strip_prefix("HTTP/1.1 ").and_then(|rest| rest.get(..3)?.parse().ok());
        let is_known = status.is_some_and(|status: u16| status == 200 || (400..=431).contains(&status));
        assert!(answer.is_empty() || is_known && answer.contains("\r\n\r\n"), "{garbage:?}");
    }
    // Every part of a request, and then nobody; and a picture that nobody takes.
    for end in (0..whole.len()).step_by(7) {
        server.connect().write_all(&whole[..end]).expect("a part");
    }
    (0..20).for_each(|_| server.connect().write_all(&whole).expect("a request"));
    assert!(server.is_alive());
}

#[test]
fn a_request_that_drips_is_not_waited_for() {
    let folder = Folder::with_scene(&sphere());
    let server = Server::start(folder.path(), "");
    let whole = server.request("POST /start", &[], b"{}");
    let mut stream = server.connect();
    stream.set_read_timeout(Some(Duration::from_millis(100))).expect("a time limit");
    // At this pace the whole request would take much longer than its head may.
    let ended = whole.iter().cycle().take(400).any(|byte| {
        let is_closed = stream.write_all(std::slice::from_ref(byte)).is_err();
        is_closed || !matches!(stream.read(&mut [0]), Err(error) if is_timeout(&error))
    });
    assert!(ended && server.is_alive());
}

fn is_timeout(error: &std::io::Error) -> bool {
    matches!(error.kind(), std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut)
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_it_at_once() {
    let folder = Folder::with_scene(&sphere());
    let mut server = Server::start(folder.path(), "");
    let slow = json!({ "view": view(0, "-size 2000 2000 -random_samples 1024") }).to_string();
    let request = server.request("POST /picture", &[], slow.as_bytes());
    server.connect().write_all(&request).expect("a request");
    thread::sleep(Duration::from_millis(200));
    crate::support::send(nix::sys::signal::Signal::SIGINT, &server.child);
    let start = Instant::now();
    while server.child.try_wait().expect("a child").is_none() {
        assert!(start.elapsed() < Duration::from_secs(20), "it goes on");
        thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn only_the_pictures_of_the_line_are_written() {
    let folder = Folder::with_scene(&sphere());
    let server = Server::start(folder.path(), "-output o.tga -normals n.png -size 9 9");
    let first = folder.read("o.tga");
    let (meta, _) = server.ask("/save", &json!({ "view": view(0, "-size 8 8 -shadows") })).expect("saved");
    assert_eq!(meta["said"], "saved `o.tga`, `n.png`");
    assert!(folder.read("o.tga") != first && folder.tga("o.tga").width == 8);
    assert_eq!(folder.names(), ["n.png", "o.tga", "s.txt"]);
    let nothing = Server::start(folder.path(), "");
    assert_eq!(nothing.ask("/save", &json!({ "view": view(0, "") })).unwrap_err().0, 422);
}

#[cfg(target_os = "linux")]
#[test]
fn a_page_that_is_ended_removes_the_file_that_opened_it() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::with_scene(&sphere());
    folder.write("xdg-open", "#!/bin/sh\n");
    let opener = folder.path().join("xdg-open");
    std::fs::set_permissions(opener, PermissionsExt::from_mode(0o755)).unwrap();
    let temporary = folder.path().join("temporary");
    std::fs::create_dir(&temporary).unwrap();
    let mut command = folder.command("-input s.txt -gui -port 0 -threads 1");
    let path = format!("{}:{}", folder.path().display(), std::env::var("PATH").unwrap());
    command.env("PATH", path).env("DISPLAY", ":0").env("TMPDIR", &temporary);
    let mut server = Server::of(command);
    let files = || std::fs::read_dir(&temporary).unwrap().count();
    while files() == 0 {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    assert_eq!(server.post("/quit", &[], b"{}").expect("an answer").0, 200);
    assert!(server.child.wait().unwrap().success());
    assert_eq!(files(), 0);
}
