//! Admits a request if it has the key and comes from the page itself, under a name of this machine.

use super::http::{Head, Response};
use std::io;
use subtle::ConstantTimeEq;

/// The number of random bits in the key.
const BITS: usize = 128;

/// A random number in hexadecimal digits, which only the address shows.
pub struct Key(pub String);

impl Key {
    /// Returns a new key from the system's random numbers.
    pub fn new() -> io::Result<Self> {
        let mut bytes = [0; BITS / 8];
        getrandom::fill(&mut bytes).map_err(|error| io::Error::other(error.to_string()))?;
        Ok(Self(bytes.map(|byte| format!("{byte:02x}")).concat()))
    }

    /// Lets a request in, or says why not. The reason does not depend on how wrong the key is.
    ///
    /// A page of another origin can send requests here, and a name of its own can be made to resolve to this machine
    /// (DNS rebinding). The first has another `Origin`, the second another `Host`. Ports are not compared, since a
    /// tunnel may have another one at its end.
    pub fn admit(&self, head: &Head) -> Result<(), Response> {
        let host = head.host.as_deref().ok_or_else(|| Response::text(400, "the request names no host"))?;
        if !is_this_machine(host) {
            return Err(Response::text(403, "this page is served to this machine only"));
        }
        if head.origin.as_ref().is_some_and(|origin| origin.strip_prefix("http://") != Some(host)) {
            return Err(Response::text(403, "another page cannot use this one"));
        }
        // A form of another page can post to an address that it guesses, but cannot set a header.
        let in_query = head.query.strip_prefix("key=").filter(|_| !head.is_post);
        let given = head.key.as_deref().or(in_query).unwrap_or_default();
        // The time that this takes does not tell how much of the key is right.
        match self.0.as_bytes().ct_eq(given.as_bytes()).into() {
            true => Ok(()),
            false => Err(Response::text(403, "open the address that the program prints: it has the key")),
        }
    }
}

/// Returns true for a loopback name with or without a port.
fn is_this_machine(host: &str) -> bool {
    let is_port = |port: &str| !port.is_empty() && port.bytes().all(|byte| byte.is_ascii_digit());
    ["127.0.0.1", "localhost", "[::1]"]
        .into_iter()
        .filter_map(|name| host.strip_prefix(name))
        .any(|rest| rest.is_empty() || rest.strip_prefix(':').is_some_and(is_port))
}
