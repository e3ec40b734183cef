//! The connections that are open, a bounded number of them.

use super::limits::MAX_CONNECTIONS;
use std::net::{Shutdown, TcpStream};
use std::sync::{Mutex, PoisonError};

/// The open connections. Where there are too many, the oldest that has not shown the key makes room, or else the oldest
/// that asks for nothing.
#[derive(Default)]
pub struct Connections {
    open: Mutex<Vec<Open>>,
}

struct Open {
    id: u64,
    stream: TcpStream,
    has_shown_key: bool,
    rests: bool,
}

impl Connections {
    /// Takes a connection in; an error if there is no room for it.
    pub fn add(&self, id: u64, stream: &TcpStream) -> std::io::Result<()> {
        let stream = stream.try_clone()?;
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        if open.len() >= MAX_CONNECTIONS {
            let stranger = open.iter().position(|other| !other.has_shown_key);
            let first = stranger.or_else(|| open.iter().position(|other| other.rests));
            let first = first.ok_or(std::io::ErrorKind::ConnectionRefused)?;
            let _ = open.remove(first).stream.shutdown(Shutdown::Both);
        }
        open.push(Open { id, stream, has_shown_key: false, rests: true });
        Ok(())
    }

    /// The connection has shown the key, and asks for something or rests.
    pub fn trust(&self, id: u64, rests: bool) {
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        let known = open.iter_mut().filter(|other| other.id == id);
        known.for_each(|other| (other.has_shown_key, other.rests) = (true, rests));
    }

    /// The connection has ended.
    pub fn remove(&self, id: u64) {
        self.open.lock().unwrap_or_else(PoisonError::into_inner).retain(|other| other.id != id);
    }
}
