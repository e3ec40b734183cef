//! The live page behind `-gui`: the scene in a browser, ray-traced anew whenever the hand moves.
//!
//! This module is the only one of the library that talks to a network, and it reads and writes files for the page:
//! meshes beside the scene, and the pictures that the command line names. It listens on the loopback interface alone,
//! and answers only who knows the key in the address that it prints.
//!
//! The server itself only takes questions and knows how long their answers may take. Other processes of the same program
//! answer them, which can be ended at any point of their work.
//!
//! The page asks in the program's own words: the flags of a command line, and the camera's block of scene text. So
//! each of its pictures is one that a command line writes, byte for byte, and messages are those of the parsers.

// Both sides. A module uses only those before it in these lists.
mod limits;
mod http;
mod questions;
mod wire;

// The workers.
mod settings;
mod stage;
mod camera_block;
mod cancel;
mod painter;
mod objects;
mod rays;
mod reference;
mod saving;
mod answers;
mod work;

// The server.
mod key;
mod page;
mod admission;
mod connections;
mod turns;
mod workers;
mod desk;
mod server;

pub use answers::Setup;
pub use server::Server;
pub use work::work;
