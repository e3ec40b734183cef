//! Listens, and answers one request after the other on each connection.

use super::admission::admit;
use super::connections::Connections;
use super::desk::Desk;
use super::http::{Answer, Head, Refusal, Requests};
use super::key::Key;
use super::limits::{ALIVE_TIME, BODY_TIME, HEAD_TIME, IDLE_TIME};
use super::page::page;
use super::workers::Workers;
use std::fmt::Display;
use std::io;
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
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
    desk: Desk,
    connections: Connections,
    has_ended: AtomicBool,
}

impl Server {
    /// Has the scene opened, and listens on the loopback interface at this port, where 0 is any free one. The work is
    /// done by processes that `worker` starts, which call [`work`](super::work). An error is a line, or the message for
    /// a scene.
    pub fn open(
        port: u16,
        worker: impl Fn() -> io::Result<Command> + Send + Sync + 'static,
    ) -> Result<Self, String> {
        let failed = |error: &dyn Display| format!("error: cannot serve the page: {error}");
        let desk = Desk::new(Workers::new(worker));
        desk.open()?;
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(|error| failed(&error))?;
        let address = listener.local_addr().map_err(|error| failed(&error))?;
        let key = Key::new().map_err(|error| failed(&error))?;
        let shared =
            Shared { key, desk, connections: Connections::default(), has_ended: AtomicBool::new(false) };
        Ok(Self { listener, address, shared: Arc::new(shared) })
    }

    /// The address to open, with the key.
    pub fn url(&self) -> String {
        format!("http://{}/?key={}", self.address, self.shared.key.digits())
    }

    /// Serves the page until it is ended there.
    pub fn run(self) {
        for (id, stream) in (0..).zip(self.listener.incoming()) {
            if self.shared.has_ended.load(Ordering::Relaxed) {
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
        if self.shared.connections.add(id, &stream).is_err() {
            return Ok(());
        }
        let (shared, address) = (self.shared.clone(), self.address);
        let serve = move || {
            let _ = stream.set_nodelay(true);
            // A browser that has vanished is nobody to tell.
            let _ = shared.serve(id, &stream);
            let _ = stream.shutdown(Shutdown::Both);
            shared.connections.remove(id);
            if shared.has_ended.load(Ordering::Relaxed) {
                // Wakes the thread that waits for connections.
                let _ = TcpStream::connect(address);
            }
        };
        let thread = thread::Builder::new().name("connection".into()).spawn(serve);
        thread.map(drop).inspect_err(|_| self.shared.connections.remove(id))
    }
}

impl Shared {
    /// Answers the requests of a connection until it is closed.
    fn serve(&self, id: u64, stream: &TcpStream) -> io::Result<()> {
        let mut requests = Requests::new(stream);
        let mut patience = HEAD_TIME;
        while let Some(head) = requests.head(Instant::now() + patience)? {
            let (head, length) = match head.and_then(|head| self.admitted(head)) {
                Ok(admitted) => admitted,
                Err(refusal) => return refuse(refusal, stream),
            };
            // One that sends no body asks for nothing yet.
            self.connections.trust(id, true);
            patience = IDLE_TIME;
            let body = requests.body(length, Instant::now() + BODY_TIME)?;
            self.connections.trust(id, head.path == "/alive");
            let mut waiting = requests.waiting();
            let answer = self.answer(&head, body, &mut || waiting.has_left());
            answer.send(stream, head.closes, waiting.sent())?;
            self.connections.trust(id, true);
            if head.closes || self.has_ended.load(Ordering::Relaxed) {
                break;
            }
        }
        Ok(())
    }

    /// The head of a request that may be answered, and the length of its body.
    fn admitted(&self, head: Head) -> Result<(Head, usize), Refusal> {
        admit(&head, &self.key)?;
        let most = Desk::longest_body(&head.path);
        match head.length {
            Some(length) if length > most => Err(Refusal::new(413, format!("at most {most} bytes"))),
            Some(length) => Ok((head, length)),
            None if head.is_post => Err(Refusal::new(411, "the length of the body must be given")),
            None => Ok((head, 0)),
        }
    }

    fn answer(&self, head: &Head, body: Vec<u8>, has_left: &mut dyn FnMut() -> bool) -> Answer {
        match (head.is_post, head.path.as_str()) {
            (false, "/") => page(),
            (true, "/quit") => {
                self.has_ended.store(true, Ordering::Relaxed);
                Answer::text(200, "ended")
            }
            (true, "/alive") => self.alive(has_left),
            (true, path) => self.desk.answer(path, &head.query, body, has_left).unwrap_or_else(Answer::from),
            (false, _) => Answer::text(404, "there is nothing here"),
        }
    }
}

impl Shared {
    /// Answers late: a page that waits for it learns at once that the program has ended.
    fn alive(&self, has_left: &mut dyn FnMut() -> bool) -> Answer {
        let end = Instant::now() + ALIVE_TIME;
        while !self.has_ended.load(Ordering::Relaxed) && Instant::now() < end && !has_left() {
            thread::sleep(Duration::from_millis(50));
        }
        match self.has_ended.load(Ordering::Relaxed) {
            true => Answer::text(200, "ended"),
            false => Answer::text(200, "alive"),
        }
    }
}

/// Says why, and waits a little for the other side to read it before the connection is closed.
fn refuse(refusal: Refusal, stream: &TcpStream) -> io::Result<()> {
    Answer::from(refusal).send(stream, true, 0)?;
    stream.shutdown(Shutdown::Write)?;
    let mut rest = Requests::new(stream);
    const ENOUGH: usize = 1 << 16;
    let _ = rest.body(ENOUGH, Instant::now() + Duration::from_millis(500));
    Ok(())
}
