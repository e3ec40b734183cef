//! Puts parts of a picture together.

use super::complete_files::{CompleteFiles, prepare};
use super::progress::{ProgressLine, rows_text};
use super::signals::Signals;
use super::{End, Outcome, refused};
use raytracer::cli::Merging;
use raytracer::image_io::{Content, Merge, Written, check_distinct};
use raytracer::render::Progress;

/// Reads the parts and writes the picture.
pub fn run(options: &Merging, signals: &Signals) -> Result<Outcome, End> {
    let output = &options.output;
    check_distinct(
        [Written::Named(output.file.clone())],
        options.parts.iter().map(|part| ("part", part.clone())),
    )
    .map_err(refused)?;
    let file = prepare(output)?;
    let merge = Merge::open(&options.parts, options.region)?;
    let mut writer = file.begin(output.format, merge.size(), Content::Colors, merge.part.as_ref())?;
    let progress = ProgressLine::new(options.progress);
    let watch = |done| {
        let rows = Progress { done, rows: merge.size()[1], rays: 0 };
        progress.show(|passed| rows_text("merging", rows, passed));
    };
    let merged = merge.write(&mut writer, &watch);
    progress.end();
    merged?;
    let files = CompleteFiles::default();
    files.add(writer.complete()?)?;
    files.finish(signals)?;
    Ok(Outcome::of_text(String::new()).tell_of([output.file.clone()], options.progress))
}
