//! The limits of a request, and of all requests together.

use std::time::Duration;

/// The head of a request.
pub const MAX_HEAD_BYTES: usize = 1 << 14;
/// The headers in it.
pub const MAX_HEADERS: usize = 64;
/// The body of a question. It may have the text of a scene.
pub const MAX_QUESTION_BYTES: usize = 1 << 21;
/// The file of a picture that is dropped on the page.
pub const MAX_PICTURE_FILE_BYTES: usize = 1 << 25;

/// Connections at the same time.
pub const MAX_CONNECTIONS: usize = 32;
/// The time for a connection to get a thread, and for the head of a request to arrive.
pub const HEAD_TIME: Duration = Duration::from_secs(5);
/// The time for the body of a request to arrive.
pub const BODY_TIME: Duration = Duration::from_secs(20);
/// The time for a response to be received.
pub const SEND_TIME: Duration = Duration::from_secs(60);
/// The time that a connection with the key may rest.
pub const IDLE_TIME: Duration = Duration::from_secs(120);
/// The time that a page waits to hear that the program is still there.
pub const ALIVE_TIME: Duration = Duration::from_secs(30);

/// The memory of all requests together. A request that takes more waits until it is alone.
pub const MAX_BYTES: u64 = 400_000_000;
/// A request that takes no more memory than this does not wait.
pub const FEW_BYTES: u64 = 8_000_000;
/// The stack of a thread, of a connection or of a request.
pub const STACK_BYTES: u64 = 1 << 21;

// Estimates of memory, with something to spare.

/// A view, for each pixel.
pub const VIEW_BYTES_PER_PIXEL: u64 = 64;
/// A copy of a scene, for each primitive.
pub const SCENE_BYTES_PER_PRIMITIVE: u64 = 256;
/// A grid while it is built, for each primitive in a cell.
pub const GRID_BYTES_PER_REFERENCE: u64 = 64;
/// Reading a picture, or the meshes of a scene.
pub const FILE_BYTES: u64 = 200_000_000;
/// Reading the text of a scene, for each byte.
pub const PARSER_BYTES_PER_BYTE: u64 = 40;

/// The longer side of a picture.
pub const MAX_SIDE_PIXELS: usize = 2048;
/// Primitives in the cells of a grid, each counted once for each cell: building it takes less than a second.
pub const MAX_REFERENCES: u64 = 1 << 22;
/// Camera rays of a picture for whose difference a cause is looked for: the search renders it several times.
pub const MAX_CAUSE_RAYS: usize = 1 << 22;

/// The triangles, shapes and planes of a scene that is typed in, including its meshes, and of all such scenes together
/// that are open or prepared.
pub const MAX_PRIMITIVES: usize = 1_000_000;
/// The mesh files of a scene that is typed in: reading them takes about a second.
pub const MAX_MESH_BYTES: u64 = 1 << 26;
/// Scenes that were typed in and stay open, so that each of a few pages has its own.
pub const MAX_SCENES: usize = 4;
/// Scenes that stay prepared.
pub const MAX_PREPARED: usize = 3;
