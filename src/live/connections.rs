//! The connections that are open, a bounded number of them.

use super::limits::MAX_CONNECTIONS;
use std::net::{Shutdown, TcpStream};
use std::sync::{Mutex, PoisonError};

/// The open connections. Where there are too many, the oldest that has not shown the key makes room.
#[derive(Default)]
pub struct Connections {
    open: Mutex<Vec<Open>>,
}

struct Open {
    id: u64,
    stream: TcpStream,
    has_shown_key: bool,
}

impl Connections {
    /// Takes a connection in; an error if there is no room for it.
    pub fn add(&self, id: u64, stream: &TcpStream) -> std::io::Result<()> {
        let stream = stream.try_clone()?;
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        if open.len() >= MAX_CONNECTIONS {
            let stranger = open.iter().position(|other| !other.has_shown_key);
            let stranger = stranger.ok_or(std::io::ErrorKind::ConnectionRefused)?;
            let _ = open.remove(stranger).stream.shutdown(Shutdown::Both);
        }
        open.push(Open { id, stream, has_shown_key: false });
        Ok(())
    }

    /// The connection has shown the key.
    pub fn trust(&self, id: u64) {
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        open.iter_mut().filter(|other| other.id == id).for_each(|other| other.has_shown_key = true);
    }

    /// The connection has ended.
    pub fn remove(&self, id: u64) {
        self.open.lock().unwrap_or_else(PoisonError::into_inner).retain(|other| other.id != id);
    }
}
