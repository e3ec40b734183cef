//! Output files that are complete or not there at all.

use super::Format;
use super::error::ImageError;
use crate::picture::Picture;
use image::ImageEncoder;
use image::codecs::png::PngEncoder;
use std::ffi::OsStr;
use std::fs::{self, File, Metadata, OpenOptions, Permissions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// A picture file that is known to be writable but not yet written.
///
/// The picture goes to a temporary file beside the target, which then takes the target's name in one
/// step. Nothing stays on disk between [`OutputFile::prepare`] and [`OutputFile::write`], so that a
/// program killed while it renders leaves nothing behind.
#[derive(Debug)]
pub struct OutputFile {
    /// As the user named it, for messages.
    path: PathBuf,
    format: Format,
    sink: Sink,
}

#[derive(Debug)]
enum Sink {
    /// A regular file or none yet, links followed. `permissions` are those of the existing file.
    Replace { target: PathBuf, permissions: Option<Permissions> },
    /// A pipe or a device, which must not be replaced by a file.
    Direct(File),
}

impl OutputFile {
    /// Checks that a picture can be written to `path`: its ending, its folder, permissions.
    ///
    /// Opens a pipe or device, which waits for a reader where the system does so.
    pub fn prepare(path: &Path) -> Result<Self, ImageError> {
        let format = Format::of(path).ok_or_else(|| ImageError::Ending { path: path.to_owned() })?;
        let failed = |error| ImageError::io("write", path, error);
        let sink = match fs::metadata(path) {
            Ok(found) if found.is_dir() => return Err(ImageError::Folder { path: path.to_owned() }),
            Ok(found) => existing(path, &found).map_err(failed)?,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                Sink::Replace { target: follow_links(path).map_err(failed)?, permissions: None }
            }
            Err(error) => return Err(failed(error)),
        };
        sink.probe().map_err(failed)?;
        Ok(Self { path: path.to_owned(), format, sink })
    }

    /// Writes the whole picture or, where the target is a regular file, nothing at all.
    pub fn write(self, picture: &Picture) -> Result<(), ImageError> {
        match &self.sink {
            Sink::Direct(file) => self.encode(picture, file),
            Sink::Replace { target, permissions } => {
                let failed = |error| ImageError::io("write", &self.path, error);
                let temporary = temporary_beside(target).map_err(failed)?;
                self.encode(picture, temporary.as_file())?;
                install(temporary, target, permissions.as_ref()).map_err(failed)
            }
        }
    }

    fn encode(&self, picture: &Picture, file: &File) -> Result<(), ImageError> {
        let mut writer = BufWriter::with_capacity(1 << 16, file);
        match self.format {
            Format::Tga => self.encode_tga(picture, &mut writer)?,
            Format::Png => encode_png(picture, &mut writer)
                .map_err(|error| ImageError::coding("write", &self.path, error))?,
        }
        writer.flush().map_err(|error| ImageError::io("write", &self.path, error))
    }

    fn encode_tga(&self, picture: &Picture, writer: &mut impl Write) -> Result<(), ImageError> {
        let (width, height) = (picture.width(), picture.height());
        let header =
            tga_header(width, height).ok_or(ImageError::Sides { path: self.path.clone(), width, height })?;
        write_tga(&header, picture, writer).map_err(|error| ImageError::io("write", &self.path, error))
    }
}

impl Sink {
    /// Finds out whether a file can be made beside the target, by making one.
    fn probe(&self) -> io::Result<()> {
        match self {
            Self::Replace { target, .. } => temporary_beside(target).map(drop),
            Self::Direct(_) => Ok(()),
        }
    }
}

/// Opening without cutting finds a write-protected file, which a rename would replace regardless.
fn existing(path: &Path, found: &Metadata) -> io::Result<Sink> {
    let file = OpenOptions::new().write(true).open(path)?;
    match found.is_file() {
        true => Ok(Sink::Replace { target: fs::canonicalize(path)?, permissions: Some(found.permissions()) }),
        false => Ok(Sink::Direct(file)),
    }
}

/// Where a link to a file that does not exist yet leads; the path itself if it is no link.
fn follow_links(path: &Path) -> io::Result<PathBuf> {
    const MOST: usize = 40;
    let mut target = path.to_owned();
    for _ in 0..MOST {
        match fs::read_link(&target) {
            Ok(next) => target = folder_of(&target).join(next),
            // Not a link, or nothing there.
            Err(_) => return Ok(target),
        }
    }
    Err(io::Error::other("too many links"))
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != OsStr::new("") => folder,
        _ => Path::new("."),
    }
}

/// A new file in the target's folder with a new file's usual permissions, removed when dropped.
fn temporary_beside(target: &Path) -> io::Result<NamedTempFile> {
    let open = |path: &Path| OpenOptions::new().write(true).create_new(true).open(path);
    tempfile::Builder::new().prefix(".raytracer-").make_in(folder_of(target), open)
}

/// Gives the complete file its name. It is not forced to the disk first: that takes many times as
/// long as a small picture takes to render.
fn install(temporary: NamedTempFile, target: &Path, permissions: Option<&Permissions>) -> io::Result<()> {
    if let Some(permissions) = permissions {
        temporary.as_file().set_permissions(permissions.clone())?;
    }
    temporary.persist(target).map(drop).map_err(|error| error.error)
}

/// Rows are encoded from the top, three bytes a pixel, without alpha.
fn encode_png(picture: &Picture, writer: &mut impl Write) -> image::ImageResult<()> {
    let color = image::ExtendedColorType::Rgb8;
    PngEncoder::new(writer).write_image(picture.pixels(), picture.width(), picture.height(), color)
}

/// The course's header: uncompressed true colour, 24 bits, rows from the top. `None` above 65535.
fn tga_header(width: u32, height: u32) -> Option<[u8; 18]> {
    let [w0, w1] = u16::try_from(width).ok()?.to_le_bytes();
    let [h0, h1] = u16::try_from(height).ok()?.to_le_bytes();
    Some([0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, w0, w1, h0, h1, 24, 32])
}

/// The image crate's encoder writes the same bytes (a test compares them) but copies the picture
/// first, and the program aborts if there is no memory for that; this needs one row.
fn write_tga(header: &[u8; 18], picture: &Picture, writer: &mut impl Write) -> io::Result<()> {
    writer.write_all(header)?;
    let mut bgr = Vec::new();
    for row in picture.pixels().chunks_exact(picture.width() as usize * 3) {
        bgr.clear();
        bgr.extend_from_slice(row);
        bgr.chunks_exact_mut(3).for_each(|pixel| pixel.swap(0, 2));
        writer.write_all(&bgr)?;
    }
    Ok(())
}
