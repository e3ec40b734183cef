//! Requests and responses of HTTP/1.1, as far as a page needs them.
//!
//! The head of a request, which is easy to get wrong, is parsed by `httparse`, the parser of hyper. This module decides
//! what is allowed and how long it may take. No crate with a whole server limits the time of whole requests.

use super::limits::{MAX_HEAD_BYTES, MAX_HEADERS, SEND_TIME};
use crate::diagnostic::Diagnostic;
use httparse::{EMPTY_HEADER, Error, Request, Status};
use serde_json::Value;
use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

/// The head of a request.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Head {
    pub is_post: bool,
    pub path: String,
    /// The part of the target after the question mark.
    pub query: String,
    pub host: Option<String>,
    pub origin: Option<String>,
    pub key: Option<String>,
    /// The length of the body.
    pub length: Option<usize>,
    pub closes: bool,
}

/// A connection, on which requests follow each other.
pub struct Connection<'s> {
    stream: &'s TcpStream,
    /// The bytes that have been received and not been used.
    received: Vec<u8>,
}

impl<'s> Connection<'s> {
    pub fn new(stream: &'s TcpStream) -> Self {
        Self { stream, received: vec![] }
    }

    /// Returns the head of the next request, or why it is refused. All of it must arrive before the deadline.
    pub fn head(&mut self, deadline: Instant) -> io::Result<Result<Head, Response>> {
        loop {
            match parse_head(&self.received) {
                Ok(Some((head, length))) => {
                    self.received.drain(..length);
                    return Ok(Ok(head));
                }
                Ok(None) if self.received.len() >= MAX_HEAD_BYTES => {
                    return Ok(Err(Response::text(431, "the head of the request is too long")));
                }
                Ok(None) => self.receive(MAX_HEAD_BYTES, deadline)?,
                Err(response) => return Ok(Err(response)),
            }
        }
    }

    /// Returns a body of this length, which must arrive before the deadline.
    pub fn body(&mut self, length: usize, deadline: Instant) -> io::Result<Vec<u8>> {
        while self.received.len() < length {
            self.receive(length, deadline)?;
        }
        let rest = self.received.split_off(length);
        Ok(std::mem::replace(&mut self.received, rest))
    }

    /// Receives at least one byte, and no more than `most` in all.
    fn receive(&mut self, most: usize, deadline: Instant) -> io::Result<()> {
        let mut part = [0; 1 << 14];
        let room = most.saturating_sub(self.received.len()).min(part.len());
        let mut stream = self.stream;
        stream.set_read_timeout(Some(until(deadline)?))?;
        match stream.read(&mut part[..room])? {
            0 => Err(io::ErrorKind::UnexpectedEof.into()),
            count => {
                self.received.extend_from_slice(&part[..count]);
                Ok(())
            }
        }
    }

    /// Returns true if the other side has closed the connection, and so no longer waits for its response.
    pub fn has_left(&self) -> bool {
        let found = self.stream.set_nonblocking(true).and_then(|()| self.stream.peek(&mut [0]));
        match self.stream.set_nonblocking(false).and(found) {
            Ok(count) => count == 0,
            Err(error) => error.kind() != io::ErrorKind::WouldBlock,
        }
    }

    /// Sends a response. The other side may take a while to receive it, but not for ever.
    pub fn send(&self, response: &Response, closes: bool) -> io::Result<()> {
        let (mut stream, deadline) = (self.stream, Instant::now() + SEND_TIME);
        for mut rest in [response.head(closes).as_bytes(), &response.body] {
            while !rest.is_empty() {
                stream.set_write_timeout(Some(until(deadline)?))?;
                rest = &rest[stream.write(rest)?..];
            }
        }
        Ok(())
    }

    /// Says why, and waits a little for the other side to read it before the connection is closed.
    pub fn refuse(&mut self, response: &Response) -> io::Result<()> {
        const ENOUGH: usize = 1 << 16;
        self.send(response, true)?;
        self.stream.shutdown(Shutdown::Write)?;
        self.body(ENOUGH, Instant::now() + Duration::from_millis(500)).map(drop)
    }
}

/// Returns the time until a deadline; an error if it is over.
fn until(deadline: Instant) -> io::Result<Duration> {
    let left = deadline.saturating_duration_since(Instant::now());
    if left.is_zero() { Err(io::ErrorKind::TimedOut.into()) } else { Ok(left) }
}

/// Parses the head at the start of these bytes. Returns it with its length, or `None` if it is not complete.
fn parse_head(bytes: &[u8]) -> Result<Option<(Head, usize)>, Response> {
    let mut headers = [EMPTY_HEADER; MAX_HEADERS];
    let mut request = Request::new(&mut headers);
    let end = match request.parse(bytes) {
        Ok(Status::Complete(end)) => end,
        Ok(Status::Partial) => return Ok(None),
        Err(Error::TooManyHeaders) => return Err(Response::text(431, "too many headers")),
        Err(error) => return Err(Response::text(400, &format!("not a request: {error}"))),
    };
    let is_post = match request.method {
        Some("GET") => false,
        Some("POST") => true,
        _ => return Err(Response::text(405, "only GET and POST")),
    };
    let target = request.path.unwrap_or_default();
    let (path, query) = target.split_once('?').unwrap_or((target, ""));
    let header = |name| header(request.headers, name);
    // A number may have a sign, but a length has none.
    let number = |text: String| text.parse().ok().filter(|_| !text.starts_with('+'));
    let unclear = || Response::text(400, "the length of the body is unclear");
    let length = header("content-length")?.map(|text| number(text).ok_or_else(unclear)).transpose()?;
    if header("transfer-encoding")?.is_some() {
        return Err(Response::text(411, "the length of the body must be given"));
    }
    let is_close = |text: String| text.to_ascii_lowercase().contains("close");
    let head = Head {
        is_post,
        path: path.into(),
        query: query.into(),
        host: header("host")?,
        origin: header("origin")?,
        key: header("x-key")?,
        length,
        closes: request.version == Some(0) || header("connection")?.is_some_and(is_close),
    };
    Ok(Some((head, end)))
}

/// Returns the value of a header. Refuses one that could be read in two ways.
fn header(headers: &[httparse::Header], name: &str) -> Result<Option<String>, Response> {
    let mut found = headers.iter().filter(|header| header.name.eq_ignore_ascii_case(name));
    let (Some(header), second) = (found.next(), found.next()) else { return Ok(None) };
    match std::str::from_utf8(header.value) {
        Ok(text) if second.is_none() => Ok(Some(text.trim().to_owned())),
        Ok(_) => Err(Response::text(400, &format!("the header `{name}` is given twice"))),
        Err(_) => Err(Response::text(400, &format!("the header `{name}` is not text"))),
    }
}

/// A response to a request, or the reason why it is refused.
#[derive(Debug, PartialEq, Eq)]
pub struct Response {
    pub status: u16,
    pub content_type: &'static str,
    /// The content security policy.
    pub policy: String,
    pub body: Vec<u8>,
}

impl Response {
    fn new(status: u16, content_type: &'static str, body: Vec<u8>) -> Self {
        Self { status, content_type, policy: "default-src 'none'; frame-ancestors 'none'".into(), body }
    }

    /// Returns a line of text. With the status 422 it says why a question that is understood cannot be answered.
    pub fn text(status: u16, text: &str) -> Self {
        Self::new(status, "text/plain; charset=utf-8", format!("{text}\n").into_bytes())
    }

    /// Returns a description in JSON and the bytes that it describes, for the page's script: the length of the first as
    /// four bytes, the lowest one first, and then both.
    pub fn described(meta: &Value, parts: &[&[u8]]) -> Self {
        let meta = meta.to_string().into_bytes();
        let length = (meta.len() as u32).to_le_bytes();
        let body = [&length, &meta[..]].iter().chain(parts).copied().collect::<Vec<_>>().concat();
        Self::new(200, "application/octet-stream", body)
    }

    fn head(&self, closes: bool) -> String {
        let Self { status, content_type, policy, body } = self;
        format!(
            "HTTP/1.1 {status} {}\r\nContent-Type: {content_type}\r\nContent-Length: {}\r\n\
             Content-Security-Policy: {policy}\r\nX-Content-Type-Options: nosniff\r\nX-Frame-Options: DENY\r\n\
             Referrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n\
             Cross-Origin-Opener-Policy: same-origin\r\nCache-Control: no-store\r\n{}\r\n",
            if *status == 200 { "OK" } else { "Refused" },
            body.len(),
            if closes { "Connection: close\r\n" } else { "" },
        )
    }
}

impl<E: Into<Diagnostic>> From<E> for Response {
    fn from(error: E) -> Self {
        Self::text(422, &error.into().in_one_line())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Option<Head>, u16> {
        parse_head(text.as_bytes())
            .map(|found| found.map(|(head, _)| head))
            .map_err(|response| response.status)
    }

    #[test]
    fn what_can_be_read_in_two_ways_is_refused() {
        for (headers, status) in [
            ("Host: a\r\nHost: b", 400),
            ("X-Key: a\r\nx-key: a", 400),
            ("Content-Length: 3\r\nContent-Length: 3", 400),
            ("Content-Length: +3", 400),
            ("Content-Length: 99999999999999999999", 400),
            ("Transfer-Encoding: chunked", 411),
            ("Host: \u{fffd}\u{0}", 400),
            (" folded", 400),
        ] {
            assert_eq!(parse(&format!("GET / HTTP/1.1\r\n{headers}\r\n\r\n")), Err(status), "{headers}");
        }
        assert_eq!(parse("PUT / HTTP/1.1\r\n\r\n"), Err(405));
        assert_eq!(parse("\u{16}\u{3}\u{1} TLS\r\n\r\n"), Err(400));
        let many = "a: b\r\n".repeat(MAX_HEADERS + 1);
        assert_eq!(parse(&format!("GET / HTTP/1.1\r\n{many}\r\n")), Err(431));
        assert_eq!(parse("GET / HTTP/1.1\r\nHost: a"), Ok(None));
    }

    #[test]
    fn a_connection_of_an_old_client_closes() {
        assert!(parse("GET / HTTP/1.0\r\n\r\n").unwrap().unwrap().closes);
    }
}
