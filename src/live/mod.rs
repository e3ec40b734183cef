//! The live page behind `-gui`: the scene in a browser, ray-traced anew whenever the hand moves.
//!
//! This module is the only one of the library that talks to a network, and it reads and writes files for the page:
//! meshes beside the scene, and the pictures that the command line names. It listens on the loopback interface alone,
//! and answers only a request with the key in the address that it prints.
//!
//! The page asks in the program's own words: the flags of a command line, and the camera's block of scene text. So
//! each of its pictures is one that a command line writes, byte for byte, and messages come from the parsers. Requests
//! are worked on by threads, and end when their client has left; what cannot be ended is bounded beforehand.

mod access;
mod flags;
mod http;
mod limits;
mod objects;
mod painting;
mod prepared;
mod rays;
mod scenes;
mod server;
mod session;
mod view;
mod workers;

pub use server::Server;

use crate::base::lock;
