//! The results of a run that renders or compares, as a text and as a JSON document.

use super::compare::ComparisonResult;
use super::log::Log;
use super::outputs::Outputs;
use super::{End, Outcome, json};
use raytracer::cli::{Options, Output};
use raytracer::image_io::OutputFile;
use raytracer::render::renderer::Renderer;
use raytracer::stats::{self, Repeats};
use raytracer::tools::explain::{CostMap, PixelTree};
use std::fmt::Display;
use std::io::{Write, stderr};
use std::path::Path;

/// The results of a run. A comparison of two files has no scene.
#[derive(Default)]
pub struct Report<'r> {
    pub renderer: Option<&'r Renderer>,
    pub statistics: Option<stats::Report>,
    /// The times of all renderings, if there are several.
    pub repeats: Option<Repeats>,
    /// The costs of a cost map's pixels.
    pub costs: Option<CostMap>,
    /// The rays behind the pixel in question.
    pub pixel: Option<PixelTree>,
    pub comparison: Option<ComparisonResult>,
}

impl Report<'_> {
    /// Writes the document to its file, gives all files their names, and returns the outcome with the text to print.
    pub fn finish(
        &self,
        options: &Options,
        document: Option<OutputFile>,
        outputs: &Outputs,
        log: &Log,
    ) -> Result<Outcome, End> {
        if let Some(file) = document {
            outputs.add(file.text(&json::document(self, options, &log.messages()))?)?;
        }
        outputs.name_all()?;
        let mut text = if options.prints_json() { String::new() } else { self.text(options) };
        if options.outputs.iter().any(Output::is_standard_output) {
            let _ = stderr().write_all(text.as_bytes());
            text.clear();
        }
        let passes = self.comparison.as_ref().is_none_or(|compared| compared.passes() != Some(false));
        let written = options.written().map(Path::to_owned);
        Ok(Outcome { passes, ..Outcome::new(text, written, options.progress) })
    }

    fn text(&self, options: &Options) -> String {
        let blocks: [Option<&dyn Display>; 5] = [
            self.statistics.as_ref().filter(|_| options.stats).map(|statistics| statistics as _),
            self.repeats.as_ref().map(|repeats| repeats as _),
            self.costs.as_ref().map(|costs| costs as _),
            self.pixel.as_ref().map(|pixel| pixel as _),
            self.comparison.as_ref().map(|comparison| comparison as _),
        ];
        blocks.into_iter().flatten().map(ToString::to_string).collect()
    }
}
