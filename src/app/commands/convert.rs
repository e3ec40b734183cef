//! A run that writes a picture in another format.

use crate::app::complete_files::CompleteFiles;
use crate::app::pictures::{prepare_file, read_picture};
use crate::app::signals::Signals;
use crate::app::{End, Outcome, failed, told_files};
use raytracer::cli::Converting;
use raytracer::diagnostic::Diagnostic;
use raytracer::distinct_files::WrittenFiles;

/// Reads the picture and writes it. An error is the message that ends the program. Notes go to `tell`.
pub fn run(options: &Converting, signals: &Signals, tell: &dyn Fn(&Diagnostic)) -> Result<Outcome, End> {
    WrittenFiles::of_converting(options)?;
    let file = prepare_file(&options.output).map_err(failed)?;
    let picture = read_picture(&options.picture, "converted", tell)?;
    let files = CompleteFiles::default();
    files.add(file.complete(&picture).map_err(failed)?)?;
    files.finish(signals)?;
    let written = told_files(options.progress, [options.output.file.clone()]);
    Ok(Outcome { text: String::new(), written, passes: true })
}
