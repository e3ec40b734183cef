//! Picture files: TGA, PNG, BMP, PPM, PFM and OpenEXR. The writer takes rows, and the files of a run appear together
//! when all are complete. The reader takes any common variant. Parts of a picture say where they lie, and are put
//! together.

mod common_to_readers;
mod distinct_files;
mod exr;
mod format;
mod merge;
mod netpbm;
mod output;
mod part;
mod reader;
mod rows;
mod writer;
mod written_headers;

pub use common_to_readers::{ReadNotes, Wanted};
pub use distinct_files::{ReadFile, Written, check_distinct};
pub use format::{Content, Format};
pub use merge::Merge;
pub use output::{CompleteFile, NAMING, OutputFile, put_in_place};
pub use part::Part;
pub use reader::{load_pixels, read_picture, read_picture_from, read_pixels};
pub use rows::{PartFile, Rows};
pub use writer::{Exceptional, PictureWriter, convert, part_beside};

use crate::base::escape::quoted;
use crate::diagnostic::Diagnostic;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Returns the name of a file beside another: `o.rest.tga` beside `o.tga` for the word `rest`.
pub fn beside(path: &Path, word: &str) -> PathBuf {
    let mut name = OsString::from(path.file_stem().unwrap_or_default());
    name.push(".");
    name.push(word);
    if let Some(extension) = path.extension() {
        name.extend([".".as_ref(), extension]);
    }
    path.with_file_name(name)
}

/// Puts "cannot", a verb such as "read" and the path before the reason of an error.
fn cannot(action: &str, path: &Path, reason: impl Into<Diagnostic>) -> Diagnostic {
    let reason = reason.into();
    Diagnostic { message: format!("cannot {action} {}: {}", quoted(path), reason.message), ..reason }
}
