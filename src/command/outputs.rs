//! The files that a run writes: checked at its start, and named together at its end or before a signal ends it.

use super::log::Log;
use super::signals::Signals;
use super::{End, parts, refused};
use crate::base::lock;
use crate::base::stdio::STDIO;
use crate::cli::{Options, Output};
use crate::diagnostic::Diagnostic;
use crate::image_io::{
    CompleteFile, OutputFile, ReadFile, Written, check_distinct, part_beside, put_in_place,
};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// Checks that a page and the table beside it can be written.
pub fn prepare_report(files: &[PathBuf; 2]) -> Result<[OutputFile; 2], Diagnostic> {
    let [page, table] = files.each_ref().map(|file| OutputFile::prepare(file));
    Ok([page?, table?])
}

/// Refuses a run that renders or compares if it would write a file twice, or one that it reads. `in_scene` are the
/// files that the scene names.
pub fn check(options: &Options, in_scene: Vec<ReadFile>) -> Result<(), End> {
    let standard_output = Path::new(STDIO);
    let prints = options.has_text() && !options.written().any(|file| file == standard_output);
    let named = options.written().chain(prints.then_some(standard_output));
    let named = named.map(|file| Written::Named(file.to_owned()));
    // A stopped run writes a part of a picture.
    let request = options.request();
    let part = |output: &Output| {
        let has_parts = !output.is_standard_output() && parts::has_parts(&request, output.layer);
        let part = part_beside(&output.file, output.format).filter(|_| has_parts)?;
        Some(Written::PartOf { picture: output.file.clone(), part })
    };
    let written = named.chain(options.outputs.iter().filter_map(part));
    check_distinct(written, options.files().chain(in_scene)).map_err(refused)
}

/// Regular files that are complete and have no names yet.
#[derive(Default)]
pub struct Outputs(Arc<Mutex<Vec<CompleteFile>>>);

impl Outputs {
    /// Writes to pipes, devices and standard output at once, and keeps the other files. A reader may never come, so from
    /// now on a signal ends the program, once the kept files have their names.
    pub fn new(files: Vec<CompleteFile>, signals: &Signals) -> Result<Self, End> {
        let (streams, regular) = files.into_iter().partition(CompleteFile::is_stream);
        let all = Self(Arc::new(Mutex::new(regular)));
        let own = Self(all.0.clone());
        signals.before_end(move || {
            if let Err(error) = own.name_all() {
                Log::default().log(error);
            }
        });
        if let Err(end) = signals.end_at_once() {
            all.name_all()?;
            return Err(end);
        }
        Vec::into_iter(streams).try_for_each(|stream| all.add(stream))?;
        Ok(all)
    }

    /// Adds a file. A pipe, a device or standard output is written at once, which may wait for a reader.
    pub fn add(&self, file: CompleteFile) -> Result<(), Diagnostic> {
        let regular = file.write_stream()?;
        lock(&self.0).extend(regular);
        Ok(())
    }

    /// Gives all files their names, or none if one fails.
    pub fn name_all(&self) -> Result<(), Diagnostic> {
        // The lock is held, so that a second thread waits until all have their names.
        let mut files = lock(&self.0);
        put_in_place(std::mem::take(&mut files))
    }
}
