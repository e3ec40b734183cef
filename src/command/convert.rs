//! Writes a picture in another format.

use super::compare::read_picture;
use super::log::Log;
use super::outputs::Outputs;
use super::signals::Signals;
use super::{End, Outcome, refused};
use raytracer::cli::Converting;
use raytracer::image_io::{OutputFile, Rows, check_distinct, convert};

/// Reads the picture and writes it.
pub fn run(options: &Converting, signals: &Signals, log: &Log) -> Result<Outcome, End> {
    let Converting { picture, output, progress } = options;
    check_distinct([output.file.clone()], [("picture", picture.clone())]).map_err(refused)?;
    let file = OutputFile::prepare(&output.file)?;
    let converted = match Rows::open(picture) {
        // Only one row at a time is in memory.
        Ok(rows) => convert(rows, file, output.format)?,
        Err(_) => file.picture(output.format, &read_picture(picture, "converted", log)?)?,
    };
    Outputs::new(vec![converted], signals)?.name_all()?;
    Ok(Outcome::new(String::new(), [output.file.clone()], *progress))
}
