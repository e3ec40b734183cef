//! Listens, and answers one request after the other on each connection.

use super::access::Key;
use super::http::{Answer, Connection, Head};
use super::limits::*;
use super::session::Session;
use crate::cli::Options;
use crate::diagnostic::Diagnostic;
use askama::Template;
use std::fmt::Display;
use std::io;
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::path::Path;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// A page that is being served.
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    shared: Arc<Shared>,
}

/// What the connections share.
struct Shared {
    key: Key,
    session: Arc<Session>,
    state: Mutex<State>,
    /// Wakes those who wait to hear that the program ends.
    ending: Condvar,
}

#[derive(Default)]
struct State {
    has_ended: bool,
    /// The connections, the oldest first.
    open: Vec<Open>,
}

struct Open {
    id: u64,
    stream: TcpStream,
    has_shown_key: bool,
    rests: bool,
}

impl Server {
    /// Opens the scene of a command line, which has a page that starts with these words, and listens on the loopback
    /// interface at this port, where 0 is any free one. An error is a line, or the message for a scene.
    pub fn open(options: &Options, input: &Path, words: &[String], port: u16) -> Result<Self, Diagnostic> {
        let failed = |error: &dyn Display| Diagnostic::error(format!("cannot serve the page: {error}"));
        let session = Arc::new(Session::open(options, input, words)?);
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(|error| failed(&error))?;
        let address = listener.local_addr().map_err(|error| failed(&error))?;
        let key = Key::new().map_err(|error| failed(&error))?;
        let (state, ending) = Default::default();
        Ok(Self { listener, address, shared: Arc::new(Shared { key, session, state, ending }) })
    }

    /// The address to open, with the key.
    pub fn url(&self) -> String {
        format!("http://{}/?key={}", self.address, self.shared.key.0)
    }

    /// Serves the page until it is ended there.
    pub fn run(self) {
        for (id, stream) in (0..).zip(self.listener.incoming()) {
            if self.shared.lock().has_ended {
                return;
            }
            // There may be no file descriptors or threads left; some will be free again.
            let started = stream.and_then(|stream| self.start(id, stream));
            if started.is_err() {
                thread::sleep(Duration::from_millis(20));
            }
        }
    }

    /// Starts a thread for a connection. One without room is closed.
    fn start(&self, id: u64, stream: TcpStream) -> io::Result<()> {
        if self.shared.lock().add(id, &stream).is_err() {
            return Ok(());
        }
        let (shared, address) = (self.shared.clone(), self.address);
        let serve = move || {
            let _ = stream.set_nodelay(true);
            // A browser that has vanished reads no answer.
            let _ = shared.serve(id, &stream);
            let _ = stream.shutdown(Shutdown::Both);
            let mut state = shared.lock();
            state.open.retain(|other| other.id != id);
            if state.has_ended {
                // Wakes the thread that waits for connections.
                let _ = TcpStream::connect(address);
            }
        };
        let thread = thread::Builder::new().name("connection".into()).spawn(serve);
        thread.map(drop).inspect_err(|_| self.shared.lock().open.retain(|other| other.id != id))
    }
}

impl State {
    /// Takes a connection in. Where there are too many, the oldest that has not shown the key makes room, or else the
    /// oldest that asks for nothing. An error if there is no room.
    fn add(&mut self, id: u64, stream: &TcpStream) -> io::Result<()> {
        let stream = stream.try_clone()?;
        if self.open.len() >= MAX_CONNECTIONS {
            let stranger = self.open.iter().position(|other| !other.has_shown_key);
            let first = stranger.or_else(|| self.open.iter().position(|other| other.rests));
            let first = first.ok_or(io::ErrorKind::ConnectionRefused)?;
            let _ = self.open.remove(first).stream.shutdown(Shutdown::Both);
        }
        self.open.push(Open { id, stream, has_shown_key: false, rests: true });
        Ok(())
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Notes that a connection has shown the key, and whether it asks for something.
    fn trust(&self, id: u64, rests: bool) {
        let mut state = self.lock();
        let known = state.open.iter_mut().filter(|other| other.id == id);
        known.for_each(|other| (other.has_shown_key, other.rests) = (true, rests));
    }

    /// Answers the requests of a connection until it is closed.
    fn serve(&self, id: u64, stream: &TcpStream) -> io::Result<()> {
        let mut connection = Connection::new(stream);
        let mut time = HEAD_TIME;
        while let Some(head) = connection.head(Instant::now() + time)? {
            let (head, length) = match head.and_then(|head| self.admitted(head)) {
                Ok(admitted) => admitted,
                Err(answer) => return refuse(&answer, &mut connection, stream),
            };
            time = IDLE_TIME;
            // One that sends no body asks for nothing yet.
            self.trust(id, true);
            let body = connection.body(length, Instant::now() + BODY_TIME)?;
            self.trust(id, head.path == "/alive");
            let answer = self.answer(&head, body, &mut || connection.has_left());
            connection.send(&answer, head.closes)?;
            self.trust(id, true);
            if head.closes || self.lock().has_ended {
                break;
            }
        }
        Ok(())
    }

    /// Returns the head of a request that may be answered, and the length of its body.
    fn admitted(&self, head: Head) -> Result<(Head, usize), Answer> {
        self.key.admit(&head)?;
        let most = if head.path == "/reference" { MAX_PICTURE_FILE } else { MAX_QUESTION };
        match head.length {
            Some(length) if length > most => Err(Answer::text(413, &format!("at most {most} bytes"))),
            Some(length) => Ok((head, length)),
            None if head.is_post => Err(Answer::text(411, "the length of the body must be given")),
            None => Ok((head, 0)),
        }
    }

    fn answer(&self, head: &Head, body: Vec<u8>, has_left: &mut dyn FnMut() -> bool) -> Answer {
        match (head.is_post, head.path.as_str()) {
            (false, "/") => page(),
            (true, "/quit") => {
                self.lock().has_ended = true;
                self.ending.notify_all();
                Answer::text(200, "ended")
            }
            (true, "/alive") => self.alive(has_left),
            (true, path) => {
                let found = self.session.answer(path, &head.query, body, has_left);
                found.unwrap_or_else(|refusal| refusal)
            }
            (false, _) => Answer::text(404, "there is nothing here"),
        }
    }

    /// Answers late: a page that waits for it learns at once that the program has ended.
    fn alive(&self, has_left: &mut dyn FnMut() -> bool) -> Answer {
        const LOOK: Duration = Duration::from_millis(500);
        let end = Instant::now() + ALIVE_TIME;
        while Instant::now() < end && !has_left() {
            let goes_on = |state: &mut State| !state.has_ended;
            let waited = self.ending.wait_timeout_while(self.lock(), LOOK, goes_on);
            if waited.unwrap_or_else(PoisonError::into_inner).0.has_ended {
                return Answer::text(200, "ended");
            }
        }
        Answer::text(200, "alive")
    }
}

/// Says why, and waits a little for the other side to read it before the connection is closed.
fn refuse(answer: &Answer, connection: &mut Connection, stream: &TcpStream) -> io::Result<()> {
    const ENOUGH: usize = 1 << 16;
    connection.send(answer, true)?;
    stream.shutdown(Shutdown::Write)?;
    let _ = connection.body(ENOUGH, Instant::now() + Duration::from_millis(500));
    Ok(())
}

/// The page: one document, whose own parts have a mark that is new each time.
#[derive(Template)]
#[template(path = "live.html")]
struct Page {
    mark: String,
}

/// Returns the page. Its policy lets nothing run or be loaded but its own parts.
fn page() -> Answer {
    let page = Key::new().ok().map(|Key(mark)| Page { mark });
    let Some((page, text)) = page.and_then(|page| page.render().ok().map(|text| (page, text))) else {
        return Answer::text(503, "there are no random numbers");
    };
    let policy = format!(
        "default-src 'none'; script-src 'nonce-{0}'; style-src 'nonce-{0}'; connect-src 'self'; img-src data:; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
        page.mark
    );
    Answer { status: 200, content_type: "text/html; charset=utf-8", policy, body: text.into_bytes() }
}
