//! Writes a picture in another format.

use super::compare::read_picture;
use super::complete_files::{CompleteFiles, prepare};
use super::log::Log;
use super::signals::Signals;
use super::{End, Outcome, refused};
use raytracer::cli::Converting;
use raytracer::image_io::{Rows, Written, check_distinct};

/// Reads the picture and writes it.
pub fn run(options: &Converting, signals: &Signals, log: &Log) -> Result<Outcome, End> {
    let output = &options.output;
    check_distinct([Written::Named(output.file.clone())], [("picture", options.picture.clone())])
        .map_err(refused)?;
    let file = prepare(output)?;
    let converted = match Rows::open(&options.picture) {
        // One row of it is in memory at a time.
        Ok(rows) => rows.convert(file, output.format)?,
        Err(_) => file.picture(output.format, &read_picture(&options.picture, "converted", log)?)?,
    };
    let files = CompleteFiles::default();
    files.add(converted)?;
    files.finish(signals)?;
    Ok(Outcome::of_text(String::new()).tell_of([output.file.clone()], options.progress))
}
