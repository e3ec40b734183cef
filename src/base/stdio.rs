//! The path `-`, which stands for standard input or standard output.

use std::path::Path;

/// The name of both streams as a path.
pub const STDIO: &str = "-";

/// Returns true if the path stands for standard input or standard output.
pub fn is_stdio(path: &Path) -> bool {
    path == Path::new(STDIO)
}
