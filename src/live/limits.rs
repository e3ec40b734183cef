//! How much one request may ask for.

use std::time::Duration;

/// The bytes of a request's head.
pub const MAX_HEAD: usize = 1 << 14;
/// The headers of a request.
pub const MAX_HEADERS: usize = 64;
/// The bytes of a question of the page, with the text of a scene.
pub const MAX_QUESTION: usize = 1 << 21;
/// The bytes of a picture that is dropped in.
pub const MAX_PICTURE_FILE: usize = 1 << 25;
/// Connections at the same time.
pub const MAX_CONNECTIONS: usize = 32;
/// How long the head of a request may take to arrive.
pub const HEAD_TIME: Duration = Duration::from_secs(5);
/// How long a connection that has shown the key may rest.
pub const IDLE_TIME: Duration = Duration::from_secs(120);
/// How long a body may take to arrive.
pub const BODY_TIME: Duration = Duration::from_secs(20);
/// How long an answer may take to be received.
pub const SEND_TIME: Duration = Duration::from_secs(60);
/// How long a page waits to hear that the program is still there.
pub const ALIVE_TIME: Duration = Duration::from_secs(30);
/// Processes that answer questions. One of them is kept for short ones.
pub const MAX_WORKERS: usize = 5;

/// How long the answer to a question may take, with the time for which it waits for others.
pub fn answer_time(path: &str) -> Duration {
    Duration::from_secs(match path {
        "/picture" | "/compare" | "/cause" => 60,
        // The command line may name pictures that no page would show.
        "/save" => 600,
        _ => 20,
    })
}

/// The longer side of a picture in pixels, and the limits below, unless the command line itself asks for more.
pub const MAX_SIDE: usize = 2048;
/// Samples of a pixel.
pub const MAX_SAMPLES: u32 = 1024;
/// Reflections and refractions: each may double the rays.
pub const MAX_BOUNCES: u32 = 16;
/// Pixels that a filter reaches.
pub const MAX_SUPPORT: usize = 16;
/// Cells of a grid.
pub const MAX_CELLS: usize = 1 << 21;

/// The triangles, spheres and planes of a scene that is typed in, with those of its meshes.
pub const MAX_PRIMITIVES: usize = 2_000_000;
/// The mesh files that it names.
pub const MAX_MESHES: usize = 32;
/// The bytes of such a file.
pub const MAX_MESH_FILE: u64 = 1 << 28;

/// The memory in bytes that a picture takes for each pixel, a scene for each primitive, and a grid for each primitive in a
/// cell while it is built, with something to spare.
/// What one request takes is asked for beforehand, so that too little of it does not end the program for all pages.
pub const BYTES_PER_PIXEL: u64 = 64;
pub const BYTES_PER_PRIMITIVE: u64 = 256;
pub const BYTES_PER_REFERENCE: u64 = 8;
