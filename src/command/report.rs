//! The end of a run that renders or compares: the JSON document and the text.

use super::compare::ComparisonResult;
use super::complete_files::CompleteFiles;
use super::log::Log;
use super::render::Rendered;
use super::signals::Signals;
use super::{End, Outcome, json};
use raytracer::cli::Options;
use raytracer::image_io::OutputFile;
use std::io::{Write, stderr};
use std::path::Path;

/// What a run found out.
#[derive(Default)]
pub struct Report<'a> {
    pub rendered: Option<Rendered<'a>>,
    pub compared: Option<ComparisonResult>,
}

impl Report<'_> {
    /// Writes the document to its file, gives all files their names, and returns the text to print.
    pub fn finish(
        &self,
        options: &Options,
        document: Option<OutputFile>,
        files: CompleteFiles,
        signals: &Signals,
        log: &Log,
    ) -> Result<Outcome, End> {
        let json =
            || json::document(options, &log.messages(), self.rendered.as_ref(), self.compared.as_ref());
        if let Some(file) = document {
            files.add(file.text(&json())?)?;
        }
        let mut text = if options.prints_json() { json() } else { self.text(options) };
        files.finish(signals)?;
        if options.has_standard_output() {
            let _ = stderr().write_all(text.as_bytes());
            text.clear();
        }
        let passes = self.compared.as_ref().is_none_or(|compared| compared.passes != Some(false));
        let outcome = Outcome::of_text(text).tell_of(options.written().map(Path::to_owned), options.progress);
        Ok(Outcome { passes, ..outcome })
    }

    /// Returns the blocks of the rendering, then the block of the comparison.
    fn text(&self, options: &Options) -> String {
        let rendered = self.rendered.as_ref().map(|rendered| rendered.text(options));
        rendered.into_iter().chain(self.compared.as_ref().map(ComparisonResult::text)).collect()
    }
}
