//! Writes a picture in another format, or joins the parts of one.

use super::compare::log_notes;
use super::log::Log;
use super::outputs::Outputs;
use super::progress::{ProgressLine, rows_text};
use super::signals::Signals;
use super::{End, Outcome, refused};
use crate::cli::{Converting, Source};
use crate::image_io::{
    Content, Merge, OutputFile, ReadFile, Rows, Wanted, check_distinct, convert, read_pixels,
};
use crate::render::Progress;

/// Reads the picture or the parts, and writes the picture.
pub fn run(options: &Converting, signals: &Signals, log: &Log) -> Result<Outcome, End> {
    let Converting { source, output, progress } = options;
    let read: Vec<ReadFile> = match source {
        Source::Picture(picture) => vec![("picture", picture.clone())],
        Source::Parts(parts, _) => parts.iter().map(|part| ("part", part.clone())).collect(),
    };
    check_distinct([output.file.clone()], read).map_err(refused)?;
    let file = OutputFile::prepare(&output.file)?;
    let complete = match source {
        Source::Picture(picture) => match Rows::open(picture) {
            // Only one row at a time is in memory.
            Ok(rows) => convert(rows, file, output.format)?,
            Err(_) => {
                let (read, remarks) = read_pixels(picture, Wanted::Bytes)?;
                log_notes(&remarks, picture, "converted", log);
                file.picture(output.format, &read.bytes())?
            }
        },
        Source::Parts(parts, region) => {
            let merge = Merge::open(parts, *region)?;
            let mut writer = file.begin(output.format, merge.size(), Content::Colors, merge.part.as_ref())?;
            let line = ProgressLine::new(*progress);
            merge.write(&mut writer, &|done| {
                let rows = Progress { done, rows: merge.size()[1], rays: 0 };
                line.show(|passed| rows_text("merging", rows, passed));
            })?;
            writer.complete()?
        }
    };
    Outputs::new(vec![complete], signals)?.name_all()?;
    Ok(Outcome::new(String::new(), [output.file.clone()], *progress))
}
