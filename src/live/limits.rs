//! How much one request may ask for, and all of them together.

use std::time::Duration;

/// The bytes of a request's head.
pub const MAX_HEAD: usize = 1 << 14;
/// The headers of a request.
pub const MAX_HEADERS: usize = 64;
/// The bytes of a question, with the text of a scene.
pub const MAX_QUESTION: usize = 1 << 21;
/// The bytes of a picture that is dropped on the page.
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

/// Requests that are worked on at the same time. The last place is kept for short ones.
pub const MAX_PLACES: usize = 5;
/// The bytes that these take together, without those that take few. One that takes more by itself is worked on alone.
pub const MAX_BYTES: u64 = 400_000_000;
pub const FEW_BYTES: u64 = 32_000_000;

/// Longer than anybody waits for the scene of the command line.
pub const FOREVER: Duration = Duration::from_secs(1 << 30);

/// How long the answer to a question may take, with the time for which it waits for others.
pub fn answer_time(path: &str) -> Duration {
    Duration::from_secs(match path {
        "/picture" | "/compare" | "/cause" => 60,
        // The command line may name pictures that no page would show.
        "/save" => 600,
        _ => 20,
    })
}

/// The longer side of a picture in pixels, unless the command line itself asks for more; `settings` has limits of this
/// kind that are not needed elsewhere.
pub const MAX_SIDE: usize = 2048;
/// Primitives in the cells of a grid, each counted once for each cell: building it takes less than a second.
pub const MAX_REFERENCES: u64 = 1 << 22;
/// Camera rays of a picture for whose difference a cause is looked for: the search renders it some fifty times.
pub const MAX_CAUSE_RAYS: usize = 1 << 22;

/// The triangles, shapes and planes of a scene that is typed in, with those of its meshes, and of all such scenes that
/// are open.
pub const MAX_PRIMITIVES: usize = 1_000_000;
/// The lights of such a scene times its primitives: it is looked for which of them lie on each other.
pub const MAX_LIGHT_PAIRS: usize = 1 << 24;
/// The mesh files that it names.
pub const MAX_MESHES: usize = 32;
/// The bytes of these files together: reading them takes about a second.
pub const MAX_MESH_BYTES: u64 = 1 << 26;
/// Scenes that were typed in and stay open, so that each of a few pages has its own.
pub const MAX_SCENES: usize = 4;
/// Scenes that stay prepared.
pub const MAX_PREPARED: usize = 3;

/// The memory in bytes of a picture for each pixel, of a copy of a scene for each primitive, of a grid while it is built
/// for each primitive in a cell, and of reading a picture, with something to spare.
pub const BYTES_PER_PIXEL: u64 = 32;
pub const BYTES_PER_PRIMITIVE: u64 = 256;
pub const BYTES_PER_REFERENCE: u64 = 64;
pub const BYTES_OF_READING: u64 = 100_000_000;
