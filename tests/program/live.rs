//! The server of the live page, asked over plain sockets: who is let in, what is refused, and that it stays alive.

use crate::support::{Folder, program, scene, sphere};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::path::Path;
use std::process::{Child, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// A program that serves a page; it ends with the test.
pub struct Server {
    child: Child,
    port: u16,
    key: String,
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Server {
    /// Serves the scene `s.txt` of a folder with these flags.
    pub fn start(folder: &Path, flags: &str) -> Self {
        let line = format!("-input s.txt -gui -port 0 -no_browser -threads 2 {flags}");
        let mut command = program(folder, line.split_whitespace());
        let mut child =
            command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().expect("the program starts");
        let said = BufReader::new(child.stderr.take().expect("a pipe"));
        let found = said.lines().map_while(Result::ok).find_map(|line| {
            let (port, key) = line.strip_prefix("open http://127.0.0.1:")?.split_once("/?key=")?;
            Some((port.parse().expect("a port"), key.split(' ').next()?.to_owned()))
        });
        let (port, key) = found.expect("an address");
        Self { child, port, key }
    }

    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).expect("a connection");
        stream.set_read_timeout(Some(Duration::from_secs(60))).expect("a time limit");
        stream
    }

    /// The status and the body of the answer to these bytes; none if the connection is closed without one.
    pub fn send(&self, bytes: &[u8]) -> Option<(u16, Vec<u8>)> {
        let mut stream = self.connect();
        let _ = stream.write_all(bytes);
        let _ = stream.shutdown(Shutdown::Write);
        let mut answer = vec![];
        let _ = stream.read_to_end(&mut answer);
        let end = answer.windows(4).position(|four| four == b"\r\n\r\n")? + 4;
        let head = String::from_utf8(answer[..end].to_vec()).expect("a head");
        let status = head.split(' ').nth(1)?.parse().ok()?;
        Some((status, answer[end..].to_vec()))
    }

    /// A request of the page, with other headers in place of those of the same names, or more of them.
    fn request(&self, start: &str, headers: &[(&str, &str)], body: &[u8]) -> Vec<u8> {
        let (host, length) = (format!("127.0.0.1:{}", self.port), body.len().to_string());
        let usual = [
            ("Host", host.as_str()),
            ("X-Key", &self.key),
            ("Content-Length", &length),
            ("Connection", "close"),
        ];
        let is_replaced = |name: &str| headers.iter().any(|(other, _)| *other == name);
        let kept = usual.iter().filter(|(name, _)| !is_replaced(name)).chain(headers);
        let lines: String = kept.map(|(name, value)| format!("{name}: {value}\r\n")).collect();
        [format!("{start} HTTP/1.1\r\n{lines}\r\n").as_bytes(), body].concat()
    }

    fn post(&self, path: &str, headers: &[(&str, &str)], body: &[u8]) -> Option<(u16, Vec<u8>)> {
        self.send(&self.request(&format!("POST {path}"), headers, body))
    }

    /// The description and the bytes of an answer, or the reason why there is none.
    pub fn ask(&self, path: &str, question: &Value) -> Result<(Value, Vec<u8>), (u16, String)> {
        let (status, body) = self.post(path, &[], question.to_string().as_bytes()).expect("an answer");
        if status != 200 {
            return Err((status, String::from_utf8(body).expect("text")));
        }
        let (length, rest) = body.split_first_chunk::<4>().expect("a length");
        let (meta, bytes) = rest.split_at(u32::from_le_bytes(*length) as usize);
        Ok((serde_json::from_slice(meta).expect("a description"), bytes.to_vec()))
    }

    /// The pixels of a view, as red, green and blue.
    fn pixels(&self, view: Value) -> Vec<[u8; 3]> {
        let question = json!({ "page": 1, "turn": 1, "view": view, "sketch": null });
        let (_, bytes) = self.ask("/picture", &question).expect("a picture");
        bytes.chunks(4).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
    }

    fn is_alive(&self) -> bool {
        self.ask("/start", &json!({})).is_ok()
    }
}

fn view(revision: u64, words: &str) -> Value {
    let words: Vec<&str> = words.split_whitespace().collect();
    json!({ "scene": revision, "words": words, "camera": null, "show": "color" })
}

#[test]
fn a_picture_of_the_page_is_the_one_that_its_command_line_writes() {
    let folder =
        Folder::with_scene(&scene(2, "Sphere { center 0 0 0 radius .7 } Plane { normal 0 1 0 offset -.5 }"));
    let server = Server::start(folder.path(), "-output o.tga -size 30 20");
    for words in [
        "-size 30 20",
        "-size 33 21 -shadows -jittered_samples 5 -tent_filter 1 -grid auto",
        "-size 9 9 -grid 3 4 5 -visualize_grid",
    ] {
        let question = json!({ "page": 1, "turn": 1, "view": view(0, words), "sketch": null });
        let (meta, bytes) = server.ask("/picture", &question).expect("a picture");
        let line = meta["command"]
            .as_str()
            .expect("a command line")
            .strip_prefix("raytracer ")
            .expect("the program");
        folder.run(line).ok();
        let pixels: Vec<[u8; 3]> = bytes.chunks(4).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
        assert_eq!(folder.tga("o.tga").pixels, pixels, "{line}");
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
    for wrong in ["", "PerspectiveCamera {", "Group { numObjects 0 }", &format!("{block} {block}")] {
        moved["camera"] = json!(wrong);
        let question = json!({ "page": 1, "turn": 2, "view": moved, "sketch": null });
        assert_eq!(server.ask("/picture", &question).unwrap_err().0, 422, "{wrong}");
    }
}

#[test]
fn nobody_gets_in_without_the_key_the_name_and_the_origin() {
    let folder = Folder::with_scene(&sphere());
    let server = Server::start(folder.path(), "");
    let status = |headers: &[(&str, &str)]| server.post("/start", headers, b"{}").map(|(status, _)| status);
    let wrong = "0".repeat(32);
    let (short, long) = (&server.key[1..], format!("{}0", server.key));
    let own = format!("http://127.0.0.1:{}", server.port);
    assert_eq!(status(&[]), Some(200));
    assert_eq!(status(&[("Origin", &own)]), Some(200));
    for headers in [
        [("X-Key", "")],
        [("X-Key", wrong.as_str())],
        [("X-Key", short)],
        [("X-Key", &long)],
        [("Host", "evil.example")],
        [("Host", "localhost.evil.example:80")],
        [("Origin", "http://evil.example")],
        [("Origin", "null")],
        [("Origin", "http://127.0.0.1:1")],
    ] {
        assert_eq!(status(&headers), Some(403), "{headers:?}");
    }
    let get = |path: &str, key: &str| {
        let request = server.request(&format!("GET {path}{key}"), &[("X-Key", "")], b"");
        let request = String::from_utf8(request).expect("text").replace("X-Key: \r\n", "");
        server.send(request.as_bytes()).map(|(status, body)| (status, String::from_utf8(body).expect("text")))
    };
    let (status, page) = get("/", &format!("?key={}", server.key)).expect("a page");
    assert_eq!((status, page.contains("<canvas id=\"picture\"")), (200, true));
    for (path, key) in
        [("/", ""), ("/", "?key="), ("/", "?key=x"), ("/start", ""), ("/../s.txt", ""), ("/s.txt", "")]
    {
        let (status, text) = get(path, key).expect("an answer");
        assert_eq!((status, text.contains("canvas")), (403, false), "{path}{key}");
    }
    let (status, text) = get("/s.txt", &format!("?key={}", server.key)).expect("an answer");
    assert_eq!((status, text.as_str()), (404, "there is nothing here\n"));
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
    let status = |headers: &[(&str, &str)], body: &[u8]| {
        server.post("/scene", headers, body).map(|(status, _)| status)
    };
    assert_eq!(status(&[("Content-Length", "999999999")], b""), Some(413));
    assert_eq!(status(&[("Content-Length", "-1")], b""), Some(400));
    assert_eq!(status(&[("Content-Length", "99999999999999999999999")], b""), Some(400));
    assert_eq!(status(&[("Transfer-Encoding", "chunked")], b"0\r\n\r\n"), Some(411));
    assert_eq!(status(&[("A", &"a".repeat(20_000))], b""), Some(431));
    let many: Vec<(&str, &str)> = vec![("A", "a"); 100];
    assert_eq!(status(&many, b""), Some(431));
    for question in [json!({}), json!([]), json!("text"), json!({ "text": 3 })] {
        assert_eq!(server.ask("/scene", &question).unwrap_err().0, 400);
    }
    for words in [
        "-size 5000 5000",
        "-size 0 1",
        "-random_samples 65536",
        "-bounces 2000000000",
        "-grid 1290 1290 1290",
        "-box_filter 1000000",
        "-output x.png",
        "-threads 4096",
        "-json -",
        "-input /etc/passwd.txt",
        "-help",
        "x",
    ] {
        let question = json!({ "page": 1, "turn": 1, "view": view(0, words), "sketch": null });
        assert_eq!(server.ask("/picture", &question).unwrap_err().0, 422, "{words}");
    }
    let question = json!({ "page": 1, "turn": 1, "view": view(7, ""), "sketch": null });
    assert_eq!(server.ask("/picture", &question).unwrap_err().0, 410);
    let huge = json!({ "page": 1, "turn": 1, "view": view(0, ""), "sketch": [1_u64 << 40, 0] });
    let (meta, _) = server.ask("/picture", &huge).expect("a sketch of the largest size");
    assert_eq!(meta["size"], json!([2048, 1]));
    assert_eq!(folder.names(), ["s.txt"]);
}

#[test]
fn garbage_and_vanishing_browsers_do_no_harm() {
    let folder = Folder::with_scene(&sphere());
    let server = Server::start(folder.path(), "");
    let whole = server.request(
        "POST /picture",
        &[],
        json!({ "page": 1, "turn": 1, "view": view(0, ""), "sketch": null }).to_string().as_bytes(),
    );
    for garbage in [
        &b"\0\0\0\0"[..],
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
        b"GET",
        b"\r\n\r\n\r\n",
        b"GET / HTTP/9.9\r\n\r\n",
        b"POST / HTTP/1.1\r\nHost: \xff\xfe\r\n\r\n",
        b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
        &[b'a'; 100_000],
        &whole[..whole.len() - 3],
        &[&whole[..], b"rest"].concat(),
    ] {
        let answer = server.send(garbage);
        assert!(
            answer.is_none_or(|(status, _)| status == 200 || (400..=431).contains(&status)),
            "{garbage:?}"
        );
    }
    // Every part of a request, and then nobody; and a picture that nobody takes.
    for end in (0..whole.len()).step_by(7) {
        server.connect().write_all(&whole[..end]).expect("a part");
    }
    (0..20).for_each(|_| server.connect().write_all(&whole).expect("a request"));
    assert!(server.is_alive());
}

#[test]
fn idle_strangers_make_room() {
    let folder = Folder::with_scene(&sphere());
    let server = Server::start(folder.path(), "");
    let strangers: Vec<TcpStream> = (0..200).map(|_| server.connect()).collect();
    let start = Instant::now();
    assert!(server.is_alive() && start.elapsed() < Duration::from_secs(4));
    drop(strangers);
}

#[test]
fn a_later_picture_overtakes_an_earlier_one() {
    let folder = Folder::with_scene(&sphere());
    let server = Server::start(folder.path(), "");
    let question =
        |turn: u64, words: &str| json!({ "page": 1, "turn": turn, "view": view(0, words), "sketch": null });
    thread::scope(|scope| {
        let slow =
            scope.spawn(|| server.ask("/picture", &question(1, "-size 2000 2000 -random_samples 1024")));
        thread::sleep(Duration::from_millis(200));
        let (meta, _) = server.ask("/picture", &question(2, "-size 10 10")).expect("a picture");
        assert_eq!(meta["size"], json!([10, 10]));
        let (meta, _) = slow.join().expect("no panic").expect("an answer");
        assert_eq!(meta["overtaken"], json!(true));
    });
}

#[test]
fn it_ends_when_the_page_says_so() {
    let folder = Folder::with_scene(&sphere());
    let mut server = Server::start(folder.path(), "");
    assert_eq!(server.post("/quit", &[], b"").expect("an answer").0, 200);
    let start = Instant::now();
    while server.child.try_wait().expect("a child").is_none() {
        assert!(start.elapsed() < Duration::from_secs(20), "it goes on");
        thread::sleep(Duration::from_millis(10));
    }
    assert_eq!(server.child.wait().expect("a status").code(), Some(0));
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_it_at_once() {
    let folder = Folder::with_scene(&sphere());
    let mut server = Server::start(folder.path(), "");
    let slow = json!({ "page": 1, "turn": 1, "view": view(0, "-size 2000 2000 -random_samples 1024"), "sketch": null });
    server
        .connect()
        .write_all(&server.request("POST /picture", &[], slow.to_string().as_bytes()))
        .expect("a request");
    thread::sleep(Duration::from_millis(200));
    let signal = std::process::Command::new("kill").args(["-INT", &server.child.id().to_string()]).status();
    assert!(signal.expect("kill").success());
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
    let (meta, _) = server.ask("/save", &view(0, "-size 8 8 -shadows")).expect("saved");
    assert_eq!(meta["said"], "saved `o.tga`, `n.png`");
    assert!(folder.read("o.tga") != first && folder.tga("o.tga").width == 8);
    assert_eq!(folder.names(), ["n.png", "o.tga", "s.txt"]);
    let nothing = Server::start(folder.path(), "");
    assert_eq!(nothing.ask("/save", &view(0, "")).unwrap_err().0, 422);
}
