//! The limits of a request, and of all requests together.

use std::time::Duration;

/// The bytes and the headers of a request's head.
pub const MAX_HEAD: usize = 1 << 14;
pub const MAX_HEADERS: usize = 64;
/// The bytes of a question, with the text of a scene, and of a picture that is dropped on the page.
pub const MAX_QUESTION: usize = 1 << 21;
pub const MAX_PICTURE_FILE: usize = 1 << 25;

/// Connections at the same time.
pub const MAX_CONNECTIONS: usize = 32;
/// The time for a connection to get a thread and for the head of a request to arrive, for its body, and for an answer to
/// be received.
pub const HEAD_TIME: Duration = Duration::from_secs(5);
pub const BODY_TIME: Duration = Duration::from_secs(20);
pub const SEND_TIME: Duration = Duration::from_secs(60);
/// The time that a connection with the key may rest, and that a page waits to hear that the program is still there.
pub const IDLE_TIME: Duration = Duration::from_secs(120);
pub const ALIVE_TIME: Duration = Duration::from_secs(30);

/// The bytes that requests take together. A request that takes more waits until it is alone; one that takes few does
/// not wait.
pub const MAX_BYTES: u64 = 400_000_000;
pub const FEW_BYTES: u64 = 8_000_000;
/// The stack of a thread, of a connection or of a request.
pub const STACK: u64 = 1 << 21;
/// The memory in bytes, with something to spare: of a view for each pixel, of a copy of a scene for each primitive, of a
/// grid while it is built for each primitive in a cell, of reading a picture or meshes, and of reading a scene's text for
/// each byte.
pub const BYTES_PER_PIXEL: u64 = 64;
pub const BYTES_PER_PRIMITIVE: u64 = 256;
pub const BYTES_PER_REFERENCE: u64 = 64;
pub const BYTES_OF_FILES: u64 = 200_000_000;
pub const BYTES_PER_CHARACTER: u64 = 40;

/// The longer side of a picture in pixels.
pub const MAX_SIDE: usize = 2048;
/// Primitives in the cells of a grid, each counted once for each cell: building it takes less than a second.
pub const MAX_REFERENCES: u64 = 1 << 22;
/// Camera rays of a picture for whose difference a cause is looked for: the search renders it several times.
pub const MAX_CAUSE_RAYS: usize = 1 << 22;

/// The triangles, shapes and planes of a scene that is typed in, including its meshes, and of all such scenes together
/// that are open or prepared.
pub const MAX_PRIMITIVES: usize = 1_000_000;
/// The bytes of the mesh files that it names: reading them takes about a second.
pub const MAX_MESH_BYTES: u64 = 1 << 26;
/// Scenes that were typed in and stay open, so that each of a few pages has its own, and scenes that stay prepared.
pub const MAX_SCENES: usize = 4;
pub const MAX_PREPARED: usize = 3;
