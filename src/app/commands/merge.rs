//! A run that puts parts of a picture together.

use crate::app::complete_files::CompleteFiles;
use crate::app::pictures::prepare_file;
use crate::app::progress::{ProgressLine, rows_text};
use crate::app::signals::Signals;
use crate::app::{End, Outcome, failed, told_files};
use raytracer::cli::Merging;
use raytracer::distinct_files::WrittenFiles;
use raytracer::image_io::{Content, Merge};
use raytracer::render::Progress;

/// Reads the parts and writes the picture. An error is the message that ends the program.
pub fn run(options: &Merging, signals: &Signals) -> Result<Outcome, End> {
    WrittenFiles::of_merging(options)?;
    let file = prepare_file(&options.output).map_err(failed)?;
    let merge = Merge::open(&options.parts, options.region).map_err(failed)?;
    let mut writer = file
        .begin(options.output.format, merge.size(), Content::Colors, merge.part.as_ref())
        .map_err(failed)?;
    let progress = ProgressLine::new(options.progress);
    let watch = |done| {
        let rows = Progress { done, rows: merge.size()[1], rays: 0 };
        progress.show(|passed| rows_text("merging", rows, passed));
    };
    let merged = merge.write(&mut writer, &watch);
    progress.end();
    merged.map_err(failed)?;
    let files = CompleteFiles::default();
    files.add(writer.complete().map_err(failed)?)?;
    files.finish(signals)?;
    let written = told_files(options.progress, [options.output.file.clone()]);
    Ok(Outcome { text: String::new(), written, passes: true })
}
