//! The live page under attack: whatever is asked of it ends within a second after its client has left or its time is
//! over, in every phase of the work, and others are served meanwhile.
#![cfg(target_os = "linux")]

use crate::live_server::{Server, view};
use crate::support::{Folder, scene, sphere};
use serde_json::{Value, json};
use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::thread::{self, sleep};
use std::time::{Duration, Instant};

/// Glass within glass, whose rays double at every surface.
const GLASS: &str = "PerspectiveCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 angle 40 }
    Lights { numLights 1 DirectionalLight { direction -1 -1 -1 color 1 1 1 } }
    Materials { numMaterials 1 Material { diffuseColor 1 0 0 reflectiveColor 1 1 1 transparentColor 1 1 1
    indexOfRefraction 1.5 } }
    Group { numObjects 3 MaterialIndex 0 Sphere { center 0 0 0 radius 10 } Sphere { center 0 0 0 radius 5.5 }
    Sphere { center 1 0 0 radius 1 } }";
const DEEP: &str = "-bounces 16 -random_samples 1024";
const SECOND: Duration = Duration::from_secs(1);

/// The time for which a server has used processors, in seconds.
fn work_of(server: &Server) -> f64 {
    let stat = fs::read_to_string(format!("/proc/{}/stat", server.child.id())).expect("a process");
    let fields: Vec<&str> = stat.rsplit(')').next().expect("fields").split_whitespace().collect();
    fields[11..13].iter().map(|time| time.parse::<f64>().expect("ticks")).sum::<f64>() / 100.0
}

/// Asks, and leaves after a while, while there is work to do. There must be nothing to do a second later.
fn leave(server: &Server, path: &str, body: &[u8], after: Duration) {
    let mut stream = server.connect();
    stream.write_all(&server.request(&format!("POST {path}"), &[], body)).expect("a request");
    sleep(after);
    stream.set_nonblocking(true).expect("no waiting");
    assert!(stream.peek(&mut [0]).is_err(), "{path}: there is an answer already");
    drop(stream);
    let (start, mut more) = (Instant::now(), f64::INFINITY);
    while more > 0.05 && start.elapsed() < 2 * SECOND {
        let before = work_of(server);
        sleep(SECOND / 4);
        more = work_of(server) - before;
    }
    assert!(more <= 0.05, "{path}: {more} s of work in a quarter of a second, after its client has left");
}

/// Asks a question `count` times. Returns the connections, which do not wait for their answers.
fn asked(server: &Server, path: &str, body: &[u8], count: usize) -> Vec<TcpStream> {
    let request = server.request(&format!("POST {path}"), &[], body);
    let ask = |_| {
        let mut stream = server.connect();
        stream.write_all(&request).expect("a request");
        stream.set_nonblocking(true).expect("a stream that does not wait");
        stream
    };
    (0..count).map(ask).collect()
}

fn wanted(view: &Value) -> Value {
    json!({ "view": view })
}

fn bytes(question: &Value) -> Vec<u8> {
    question.to_string().into_bytes()
}

/// A grid of triangles as a mesh, with so many along each side.
fn sheet(side: usize) -> String {
    let corners = (0..side * side).map(|k| format!("v {} {} {}\n", k % side, k / side, (k * k) % 7));
    let faces = (0..side * side).filter(|k| k % side + 1 < side && k / side + 1 < side);
    let quads = faces.map(|k| format!("f {} {} {} {}\n", k + 1, k + 2, k + side + 2, k + side + 1));
    corners.chain(quads).collect()
}

#[test]
fn a_small_file_with_a_vast_picture_is_refused() {
    let folder = Folder::with_scene(GLASS);
    let server = Server::start(folder.path(), "-size 4 4");
    // Runs of 128 black pixels, of which there are 8000 x 8000.
    let head = [0, 0, 10, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x40, 0x1f, 0x40, 0x1f, 24, 0x20];
    let file = [&head[..], &[0xff, 0, 0, 0].repeat(8000 * 8000 / 128)].concat();
    let (status, said) = server.post("/reference?name=a.tga", &[], &file).expect("an answer");
    let said = String::from_utf8(said).expect("text");
    assert!(status == 422 && said.contains("8000 x 8000 pixels take 192.0 MB, above the limit"), "{said}");
}

#[test]
fn work_ends_with_its_client_in_every_phase() {
    let folder = Folder::with_scene(GLASS);
    let server = Server::start(folder.path(), "-size 4 4");
    let (short, long) = (Duration::from_millis(50), Duration::from_millis(700));
    let deep = |size: &str| view(0, &format!("-size {size} {DEEP}"));
    // Rendering, also where a pixel takes long.
    leave(&server, "/picture", &bytes(&wanted(&deep("2048 2048"))), long);
    leave(&server, "/picture", &bytes(&wanted(&deep("1 1"))), short);
    // Saving is refused at once where no picture is named.
    assert_eq!(server.ask("/save", &json!({ "view": deep("9 9") })).unwrap_err().0, 422);
    // An explanation.
    leave(&server, "/trace", &bytes(&json!({ "view": deep("9 9"), "pixel": [4, 4] })), long);
    // A comparison, and its cause.
    let tga = |side: u16| {
        let [low, high] = side.to_le_bytes();
        let head = [0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, low, high, low, high, 24, 0x20];
        let noise = (0..3 * usize::from(side).pow(2)).map(|k| (k.wrapping_mul(2_654_435_761) >> 13) as u8);
        head.into_iter().chain(noise).collect::<Vec<u8>>()
    };
    assert_eq!(server.post("/reference?name=a.tga", &[], &tga(2048)).expect("an answer").0, 200);
    leave(&server, "/compare", &bytes(&wanted(&view(0, "-size 2048 2048"))), long / 2);
    assert_eq!(server.post("/reference?name=a.tga", &[], &tga(1500)).expect("an answer").0, 200);
    leave(&server, "/cause", &bytes(&wanted(&view(0, "-size 1500 1500 -bounces 6"))), Duration::from_secs(3));
    // A scene that takes long to be read and built, and its tree and its grid.
    folder.write("a.obj", sheet(300));
    let text = scene(1, "TriangleMesh { obj_file a.obj }");
    let typed = bytes(&json!({ "text": text }));
    leave(&server, "/scene", &typed, short / 2);
    let (said, _) = server.ask("/scene", &json!({ "text": text })).expect("a scene");
    let revision = said["scene"]["revision"].as_u64().expect("a revision");
    // What building a grid takes is bounded beforehand.
    let cells = wanted(&view(revision, "-size 9 9 -grid 120 120 120"));
    let (status, said) = server.ask("/picture", &cells).map(drop).expect_err("too large");
    assert!(status == 422 && said.contains("choose fewer"), "{status} {said}");
    for words in ["-size 2048 2048 -bounces 9", "-size 2048 2048 -bounces 9 -grid auto"] {
        leave(&server, "/picture", &bytes(&wanted(&view(revision, words))), short);
    }
    let whole = json!({ "view": view(revision, "-size 2048 2048") });
    leave(&server, "/objects", &bytes(&whole), short);
    assert!(server.is_alive());
}

#[test]
fn rays_that_meet_much_end_with_their_client() {
    // Every ray meets half of the triangles, and casts a ray to each light.
    let corner = |k: usize| format!("{} {} {}", (k * 7919) % 997, (k * 104_729) % 991, k % 13);
    let triangles = (0..16_000).map(|k| {
        let [a, b, c] = [k, k + 1, k + 2].map(corner);
        format!("Triangle {{ vertex0 {a} vertex1 {b} vertex2 {c} }}")
    });
    let lights = "DirectionalLight { direction 0 0 -1 color 1 1 1 }".repeat(20);
    let folder = Folder::with_scene(&format!(
        "OrthographicCamera {{ center 500 500 100 direction 0 0 -1 up 0 1 0 size 900 }}
        Lights {{ numLights 20 {lights} }}
        Group {{ numObjects 16000 Material {{ diffuseColor 1 1 1 reflectiveColor 1 1 1 }} {} }}",
        triangles.collect::<String>()
    ));
    let server = Server::start(folder.path(), "-size 4 4");
    let wide = view(0, "-size 2048 2 -bounces 9 -shadows -shade_back -random_samples 99 -grid none");
    leave(&server, "/picture", &bytes(&wanted(&wide)), SECOND);
    leave(&server, "/trace", &bytes(&json!({ "view": wide, "pixel": [1000, 1] })), SECOND / 4);
    let adaptive = view(0, "-size 9 9 -bounces 9 -shadows -shade_back -adaptive_samples 1024 .1 -grid none");
    leave(&server, "/trace", &bytes(&json!({ "view": adaptive, "pixel": [4, 4] })), SECOND / 4);
}

/// The cells of a grid, and surfaces of which a ray meets thousands in almost one place.
#[test]
fn scenes_that_take_long_end_with_their_client_and_block_no_other() {
    let folder = Folder::with_scene(&sphere());
    let server = Server::start(folder.path(), "-size 4 4");
    let grid =
        "Grid { min -1 -1 -1 max 1 1 1 numCells 256 256 256 rasterizeSphere { center 0 0 0 radius 1 } }";
    let typed = bytes(&json!({ "text": scene(1, grid) }));
    leave(&server, "/scene", &typed, SECOND / 20);
    // Several that read and build do not keep others from it.
    let streams = asked(&server, "/scene", &typed, 8);
    sleep(SECOND / 20);
    let ellipsoid = |k: usize| {
        let radius = 1.0 - k as f64 * 4e-16;
        format!("Transform {{ Scale 1 .5 2 Sphere {{ center 0 0 0 radius {radius} }} }}\n")
    };
    let ellipsoids = scene(4000, &(0..4000).map(ellipsoid).collect::<String>());
    let (said, _) = server.ask("/scene", &json!({ "text": ellipsoids })).expect("a scene");
    let waits = |mut stream: &TcpStream| stream.read(&mut [0]).is_err();
    assert!(streams.iter().filter(|stream| waits(stream)).count() > 4);
    drop(streams);
    let revision = said["scene"]["revision"].as_u64().expect("a revision");
    for (path, flags) in
        [("/picture", "-shadows"), ("/picture", "-grid none -bounces 4"), ("/objects", "-shadows")]
    {
        let question = wanted(&view(revision, &format!("-size 500 500 {flags}")));
        leave(&server, path, &bytes(&question), SECOND);
    }
}

#[test]
#[ignore = "slow: the deadline is twenty seconds"]
fn an_answer_comes_within_a_second_of_its_deadline() {
    let folder = Folder::with_scene(GLASS);
    let server = Server::start(folder.path(), "-size 4 4");
    // With this filter the samples of 25 pixels count.
    let wide = view(0, &format!("-size 2048 2048 {DEEP} -mitchell_filter 2"));
    let start = Instant::now();
    let traced = server.ask("/trace", &json!({ "view": wide, "pixel": [1000, 1000] }));
    let (status, said) = traced.map(drop).expect_err("no answer");
    let took = start.elapsed();
    assert!(status == 422 && said.contains("longer than a page may"), "{status} {said}");
    assert!(took > 19 * SECOND && took < 21 * SECOND, "{took:?}");
}

#[test]
fn a_short_question_waits_for_no_long_one() {
    let folder = Folder::with_scene(GLASS);
    let server = Server::start(folder.path(), "-size 4 4");
    let deep = view(0, &format!("-size 2048 2048 {DEEP}"));
    let streams = asked(&server, "/picture", &bytes(&wanted(&deep)), 8);
    sleep(SECOND / 2);
    server.ask("/picture", &wanted(&view(0, "-size 20 20"))).expect("a picture");
    // None of the others has been answered before, not even that it takes too long.
    for mut stream in &streams {
        let found = stream.read(&mut [0]).map_err(|error| error.kind());
        assert_eq!(found, Err(std::io::ErrorKind::WouldBlock));
    }
}

#[test]
fn the_page_keeps_its_text_when_the_file_changes() {
    let folder = Folder::with_scene(&sphere());
    let server = Server::start(folder.path(), "-size 4 4");
    let before = server.pixels(view(0, "-size 30 30"));
    folder.write("s.txt", "nothing");
    assert_eq!(server.pixels(view(0, "-size 30 30")), before);
    assert_eq!(server.ask("/start", &json!({})).expect("a start").0["text"], sphere());
}

#[test]
fn many_connections_and_slow_ones_make_room() {
    let folder = Folder::with_scene(&sphere());
    let server = Server::start(folder.path(), "-size 4 4");
    // Some have the key and rest, some say a part of a head or no body, and some wait to hear that the program lives.
    let with_key = |start: &str, body: &[u8]| {
        let mut stream = server.connect();
        let request = server.request(start, &[("Connection", "keep-alive")], body);
        let _ = stream.write_all(&request);
        stream
    };
    let resting: Vec<TcpStream> = (0..40).map(|_| with_key("POST /start", b"{}")).collect();
    let listening: Vec<TcpStream> = (0..40).map(|_| with_key("POST /alive", b"")).collect();
    let bodiless = server.request("POST /scene", &[("Content-Length", "1000")], b"");
    let dripping: Vec<TcpStream> = (0..80)
        .map(|k| {
            let mut stream = server.connect();
            let _ = stream.write_all(if k % 2 == 0 { &bodiless[..20] } else { &bodiless });
            stream
        })
        .collect();
    let start = Instant::now();
    assert!(server.is_alive() && start.elapsed() < 4 * SECOND);
    let huge = server.request("POST /start", &[("Cookie", &"c".repeat(1 << 20))], b"");
    assert!(server.send(&huge).is_none_or(|(status, _)| status == 431));
    let long = server.request("POST /scene", &[("Content-Length", "2000000000")], b"x");
    assert_eq!(server.send(&long).map(|(status, _)| status), Some(413));
    assert!(server.is_alive());
    drop((resting, listening, dripping));
}

#[test]
fn the_page_learns_that_the_program_ends() {
    let folder = Folder::with_scene(&sphere());
    let server = Server::start(folder.path(), "-size 4 4");
    thread::scope(|scope| {
        let alive = scope.spawn(|| server.post("/alive", &[], b""));
        sleep(SECOND / 2);
        assert_eq!(server.post("/quit", &[], b"").expect("an answer").0, 200);
        let start = Instant::now();
        // The connection breaks.
        assert_eq!(alive.join().expect("no panic"), None);
        assert!(start.elapsed() < SECOND);
    });
}
