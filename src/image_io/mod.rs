//! Picture files: TGA, PNG, BMP, PPM, PFM and OpenEXR. The writer takes rows, and the files of a run appear together
//! when all are complete. The reader takes any common variant. Parts of a picture say where they lie, and are put
//! together.

mod distinct_files;
mod error;
mod exr;
mod file_id;
mod format;
mod header;
mod merge;
mod netpbm;
mod output;
mod part;
mod reader;
mod writer;

pub use distinct_files::{ReadFile, SameFile, Written, check_distinct};
pub use error::ImageError;
pub use format::Format;
pub use merge::Merge;
pub use output::{CompleteFile, OutputFile, put_in_place};
pub use part::{Part, PartFile};
pub use reader::{Remarks, read_picture, read_picture_from, read_remarked_picture};
pub use writer::{Content, Exceptional, PictureWriter, part_beside};

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
