//! Listens, and answers the requests of each connection in turn.

use super::access::Key;
use super::http::{Connection, Head, Response};
use super::limits::*;
use super::lock;
use super::session::Session;
use crate::base::memory;
use crate::cli::Options;
use crate::diagnostic::Diagnostic;
use askama::Template;
use std::io;
use std::net::{Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::path::Path;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

/// A page that is being served.
pub struct Server {
    listener: TcpListener,
    /// The address to open, with the key.
    pub url: String,
    key: Key,
    session: Session,
    /// The connections, the oldest first.
    open: Mutex<Vec<Arc<Open>>>,
}

struct Open {
    stream: TcpStream,
    rank: Mutex<Rank>,
}

/// The state of a connection. Where there are too many, one of the lowest rank makes room; one that asks never does.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Rank {
    HasNoKey,
    Rests,
    Asks,
}

impl Server {
    /// Opens the scene of a command line, and listens on the loopback interface at this port, where 0 is any free one.
    /// An error is a line, or the message for a scene.
    pub fn open(options: &Options, input: &Path, port: u16) -> Result<Self, Diagnostic> {
        let session = Session::open(options, input)?;
        let listen = || {
            let (listener, key) = (TcpListener::bind((Ipv4Addr::LOCALHOST, port))?, Key::new()?);
            let url = format!("http://{}/?key={}", listener.local_addr()?, key.0);
            Ok(Self { listener, url, key, session, open: Mutex::default() })
        };
        listen().map_err(|error: io::Error| Diagnostic::error(format!("cannot serve the page: {error}")))
    }

    /// Serves the page until it is ended there.
    pub fn run(self) {
        let (end, ended) = channel();
        let accept = move || {
            let server = Arc::new(self);
            for stream in server.listener.incoming() {
                // Connections wait until the requests that are being ended have given their memory back.
                while memory::keep_reserve().and_then(|()| memory::ask(2 * STACK_BYTES)).is_err() {
                    thread::sleep(Duration::from_millis(20));
                }
                // There may be no file descriptors or threads left; some will be free again.
                if stream.and_then(|stream| server.serve(stream, end.clone())).is_err() {
                    thread::sleep(Duration::from_millis(20));
                }
            }
        };
        if thread::Builder::new().spawn(accept).is_ok() {
            let _ = ended.recv();
        }
    }

    /// Serves a connection on a thread of its own until it is closed. One without room is closed at once.
    fn serve(self: &Arc<Self>, stream: TcpStream, end: Sender<()>) -> io::Result<()> {
        let own = Arc::new(Open { stream, rank: Mutex::new(Rank::HasNoKey) });
        // Here, not on its thread: connections make room in the order in which they came.
        if !self.add(own.clone()) {
            return Ok(());
        }
        let deadline = Instant::now() + HEAD_TIME;
        loop {
            let (server, served, end) = (self.clone(), own.clone(), end.clone());
            let serve = move || {
                // A browser that has vanished reads no response.
                let _ = server.answer_all(&served, &end);
                server.close(&served);
            };
            let thread = thread::Builder::new().name("connection".into()).stack_size(STACK_BYTES as usize);
            match thread.spawn(serve) {
                Ok(_) => return Ok(()),
                // There is no room for a thread until another ends.
                Err(_) if Instant::now() < deadline => thread::sleep(Duration::from_millis(20)),
                Err(error) => {
                    self.close(&own);
                    return Err(error);
                }
            }
        }
    }

    fn close(&self, own: &Arc<Open>) {
        let _ = own.stream.shutdown(Shutdown::Both);
        lock(&self.open).retain(|other| !Arc::ptr_eq(other, own));
    }

    /// Takes a connection in. Where there are too many, the oldest that has not shown the key makes room, or else the
    /// oldest that asks for nothing. Returns false if there is no room.
    fn add(&self, own: Arc<Open>) -> bool {
        let mut open = lock(&self.open);
        if open.len() >= MAX_CONNECTIONS {
            let ranks = open.iter().map(|other| *lock(&other.rank)).enumerate();
            let first = ranks.filter(|&(_, rank)| rank < Rank::Asks).min_by_key(|&(_, rank)| rank);
            let Some((place, _)) = first else { return false };
            let _ = open.remove(place).stream.shutdown(Shutdown::Both);
        }
        open.push(own);
        true
    }

    /// Answers the requests of a connection until one side closes it. Sends to `end` if the page ends the program.
    fn answer_all(&self, own: &Open, end: &Sender<()>) -> io::Result<()> {
        own.stream.set_nodelay(true)?;
        let mut connection = Connection::new(&own.stream);
        let mut time = HEAD_TIME;
        loop {
            let head = connection.head(Instant::now() + time)?;
            let (head, length) = match head.and_then(|head| self.admitted(head)) {
                Ok(admitted) => admitted,
                Err(response) => return connection.refuse(&response),
            };
            time = IDLE_TIME;
            // The connection asks for something only when the body has arrived.
            *lock(&own.rank) = Rank::Rests;
            let body = connection.body(length, Instant::now() + BODY_TIME)?;
            let response = match (head.is_post, head.path.as_str()) {
                (false, "/") => page()?,
                (false, _) => Response::text(404, "there is nothing here"),
                (true, "/quit") => Response::text(200, "ended"),
                (true, "/alive") => alive(&connection),
                (true, path) => {
                    *lock(&own.rank) = Rank::Asks;
                    let mut has_left = || connection.has_left();
                    let found = self.session.answer(path, &head.query, &body, &mut has_left);
                    found.unwrap_or_else(|refusal| refusal)
                }
            };
            connection.send(&response, head.closes)?;
            *lock(&own.rank) = Rank::Rests;
            if head.is_post && head.path == "/quit" {
                let _ = end.send(());
            }
            if head.closes {
                return Ok(());
            }
        }
    }

    /// Returns the head of a request that may be answered, and the length of its body.
    fn admitted(&self, head: Head) -> Result<(Head, usize), Response> {
        self.key.admit(&head)?;
        let most = if head.path == "/reference" { MAX_PICTURE_FILE_BYTES } else { MAX_QUESTION_BYTES };
        match head.length {
            Some(length) if length > most => Err(Response::text(413, &format!("at most {most} bytes"))),
            None if head.is_post => Err(Response::text(411, "the length of the body must be given")),
            length => Ok((head, length.unwrap_or(0))),
        }
    }
}

/// Answers late: a page that waits for it notices at once when the program ends, since the connection breaks.
fn alive(connection: &Connection) -> Response {
    let end = Instant::now() + ALIVE_TIME;
    while Instant::now() < end && !connection.has_left() {
        thread::sleep(Duration::from_millis(500));
    }
    Response::text(200, "alive")
}

/// The page: one document, whose own parts have a mark that is new each time.
#[derive(Template)]
#[template(path = "live.html")]
struct Page {
    mark: String,
}

/// Returns the page. Its policy lets nothing run or be loaded but its own parts.
fn page() -> io::Result<Response> {
    let page = Page { mark: Key::new()?.0 };
    let policy = format!(
        "default-src 'none'; script-src 'nonce-{0}'; style-src 'nonce-{0}'; connect-src 'self'; img-src data:; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
        page.mark
    );
    let body = page.render().map_err(io::Error::other)?.into_bytes();
    Ok(Response { status: 200, content_type: "text/html; charset=utf-8", policy, body })
}
