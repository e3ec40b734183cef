//! A program that serves the live page, and the questions that a page asks, over plain sockets.

use crate::support::program;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// A program that serves a page; it ends with the test.
pub struct Server {
    pub child: Child,
    pub port: u16,
    pub key: String,
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
        Self::of(program(folder, line.split_whitespace()))
    }

    /// Serves the page of a command that says its address.
    pub fn of(mut command: Command) -> Self {
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
        let mut answer = vec![];
        let _ = stream.read_to_end(&mut answer);
        let end = answer.windows(4).position(|four| four == b"\r\n\r\n")? + 4;
        let head = String::from_utf8(answer[..end].to_vec()).expect("a head");
        let status = head.split(' ').nth(1)?.parse().ok()?;
        Some((status, answer[end..].to_vec()))
    }

    /// A request of the page, with other headers in place of those of the same names, or more of them.
    pub fn request(&self, start: &str, headers: &[(&str, &str)], body: &[u8]) -> Vec<u8> {
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

    pub fn post(&self, path: &str, headers: &[(&str, &str)], body: &[u8]) -> Option<(u16, Vec<u8>)> {
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
    pub fn pixels(&self, view: Value) -> Vec<[u8; 3]> {
        let question = json!({ "view": view });
        let (_, bytes) = self.ask("/picture", &question).expect("a picture");
        bytes.chunks(4).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
    }

    pub fn is_alive(&self) -> bool {
        self.ask("/start", &json!({})).is_ok()
    }
}

/// A view with these flags and the scene's own camera.
pub fn view(revision: u64, words: &str) -> Value {
    let words: Vec<&str> = words.split_whitespace().collect();
    json!({ "scene": revision, "words": words, "camera": null, "cost": null })
}
