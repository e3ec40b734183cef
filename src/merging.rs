//! A run that puts parts of a picture together.

use crate::job::Outcome;
use crate::products::unless_reader_is_gone;
use crate::progress::{Progress, rows_text};
use crate::rendering::prepare_file;
use crate::signals::Signals;
use crate::{End, failed};
use raytracer::cli::Merging;
use raytracer::image_io::Merge;
use std::ops::ControlFlow;

/// Reads the parts and writes the picture. An error is the message that ends the program.
pub fn run(options: &Merging) -> Result<Outcome, End> {
    let mut signals = Signals::hold().map_err(failed)?;
    let file = prepare_file(&options.output).map_err(failed)?;
    signals.end_at_once()?;
    let merge = Merge::open(&options.parts, options.region).map_err(failed)?;
    let mut writer = file.begin(merge.size(), merge.part().as_ref()).map_err(failed)?;
    let progress = Progress::new(options.progress);
    let watch = |rows| {
        progress.show(|passed| rows_text("merging", rows, passed));
        ControlFlow::Continue(())
    };
    let merged = merge.write(&mut writer, &watch);
    progress.end();
    merged.map_err(failed)?;
    // Until now there was no file with a name.
    signals.hold_again();
    unless_reader_is_gone(writer.finish())?;
    Ok(Outcome { text: String::new(), passes: true })
}
