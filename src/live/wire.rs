//! What the server and its workers say to each other over pipes: a head in JSON, and parts of bytes.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::io::{self, Read, Write};

/// What the server says.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Order {
    /// The worker opens the scene of the command line. The part is its text, where it is known already: the file may
    /// have changed.
    Open,
    /// It answers a question. The parts are the question's body, and what the question brings along.
    Answer(Question),
    /// Nobody waits for the answer to this question any more.
    Stop { number: u64 },
}

/// A question of the page.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Question {
    /// Grows with each question to the worker.
    pub number: u64,
    pub path: String,
    pub query: String,
    /// The revision of a scene that is to be opened; the page's question with its text is the second part.
    pub opens: Option<u64>,
    /// The name of a picture to compare with; its file is the last part.
    pub reference: Option<String>,
}

/// What the worker says. The part is the answer.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reply {
    /// Of the question; 0 for the scene of the command line.
    pub number: u64,
    pub status: u16,
    /// Whether the text that was typed in is a scene, which is open now.
    pub has_opened: bool,
}

/// Sends a head and its parts.
pub fn send(to: &mut impl Write, head: &impl Serialize, parts: &[&[u8]]) -> io::Result<()> {
    let head = serde_json::to_vec(head)?;
    let mut lengths = (head.len() as u64).to_le_bytes().to_vec();
    lengths.extend((parts.len() as u64).to_le_bytes());
    parts.iter().for_each(|part| lengths.extend((part.len() as u64).to_le_bytes()));
    to.write_all(&lengths)?;
    to.write_all(&head)?;
    parts.iter().try_for_each(|part| to.write_all(part))?;
    to.flush()
}

/// Receives a head and its parts, from whom they are believed.
pub fn receive<H: DeserializeOwned>(from: &mut impl Read) -> io::Result<(H, Vec<Vec<u8>>)> {
    let head = number(from)?;
    let lengths = (0..number(from)?).map(|_| number(&mut *from)).collect::<io::Result<Vec<u64>>>()?;
    let head = serde_json::from_slice(&part(from, head)?)?;
    Ok((head, lengths.into_iter().map(|length| part(from, length)).collect::<io::Result<_>>()?))
}

fn number(from: &mut impl Read) -> io::Result<u64> {
    let mut bytes = [0; 8];
    from.read_exact(&mut bytes)?;
    Ok(u64::from_le_bytes(bytes))
}

fn part(from: &mut impl Read, length: u64) -> io::Result<Vec<u8>> {
    let mut bytes = vec![];
    match from.take(length).read_to_end(&mut bytes)? as u64 {
        count if count == length => Ok(bytes),
        _ => Err(io::ErrorKind::UnexpectedEof.into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_sent_is_received() {
        let order = Order::Answer(Question { number: 3, path: "/a".into(), ..Question::default() });
        let mut pipe = vec![];
        send(&mut pipe, &order, &[b"one", b"", b"three"]).unwrap();
        send(&mut pipe, &Order::Stop { number: 3 }, &[]).unwrap();
        let from = &mut pipe.as_slice();
        let parts = vec![b"one".to_vec(), vec![], b"three".to_vec()];
        assert_eq!(receive::<Order>(from).unwrap(), (order, parts));
        assert_eq!(receive::<Order>(from).unwrap(), (Order::Stop { number: 3 }, vec![]));
        assert!(receive::<Order>(from).is_err());
        assert!(receive::<Order>(&mut &pipe[..20]).is_err());
    }
}
