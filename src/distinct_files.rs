//! No file is written twice in a run, and none that is read: names are compared by the files that they lead to.

use crate::failed;
use raytracer::cli::{JsonTarget, Options};
use raytracer::escape::quoted;
use raytracer::image_io::FileId;
use std::path::Path;

/// An error if two of the files that a run writes are the same.
pub fn check_outputs(options: &Options) -> Result<(), String> {
    let files: Vec<_> = outputs(options).map(|path| (path, id(path))).collect();
    for (index, (path, id)) in files.iter().enumerate() {
        if let Some((other, _)) = files[..index].iter().find(|(_, other)| id.is_some() && other == id) {
            return Err(failed(format!("{} and {} are the same file", shown(other), shown(path))));
        }
    }
    Ok(())
}

/// An error if one of the files that a run writes is this one, which it reads.
pub fn check_input(options: &Options, kind: &str, input: &Path) -> Result<(), String> {
    let Some(read) = FileId::of(input) else { return Ok(()) };
    match outputs(options).find(|path| id(path).as_ref() == Some(&read)) {
        Some(path) => {
            let message = format!("{} is the {kind} {}, which would be lost", shown(path), quoted(input));
            Err(failed(message))
        }
        None => Ok(()),
    }
}

/// The files that a run writes.
fn outputs(options: &Options) -> impl Iterator<Item = &Path> {
    let pictures = options.outputs.iter().map(|output| output.file.as_path());
    let difference = options.comparison.as_ref().and_then(|comparison| comparison.difference.as_deref());
    let document = match &options.json {
        Some(JsonTarget::File(path)) => Some(path.as_path()),
        Some(JsonTarget::StandardOutput) | None => None,
    };
    pictures.chain(difference).chain(document)
}

fn id(path: &Path) -> Option<FileId> {
    FileId::of(if path == Path::new("-") { Path::new("/dev/stdout") } else { path })
}

fn shown(path: &Path) -> String {
    if path == Path::new("-") { "standard output".into() } else { quoted(path) }
}
