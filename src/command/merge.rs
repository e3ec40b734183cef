//! Joins parts of a picture.

use super::outputs::Outputs;
use super::progress::{ProgressLine, rows_text};
use super::signals::Signals;
use super::{End, Outcome, refused};
use raytracer::cli::Merging;
use raytracer::image_io::{Content, Merge, OutputFile, check_distinct};
use raytracer::render::Progress;

/// Reads the parts and writes the picture.
pub fn run(options: &Merging, signals: &Signals) -> Result<Outcome, End> {
    let Merging { parts, output, region, progress } = options;
    let read = parts.iter().map(|part| ("part", part.clone()));
    check_distinct([output.file.clone()], read).map_err(refused)?;
    let file = OutputFile::prepare(&output.file)?;
    let merge = Merge::open(parts, *region)?;
    let mut writer = file.begin(output.format, merge.size(), Content::Colors, merge.part.as_ref())?;
    let line = ProgressLine::new(*progress);
    merge.write(&mut writer, &|done| {
        let rows = Progress { done, rows: merge.size()[1], rays: 0 };
        line.show(|passed| rows_text("merging", rows, passed));
    })?;
    drop(line);
    Outputs::new(vec![writer.complete()?], signals)?.name_all()?;
    Ok(Outcome::new(String::new(), [output.file.clone()], *progress))
}
