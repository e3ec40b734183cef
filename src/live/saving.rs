//! Writes the pictures that the command line names, and no others.

use super::http::Answer;
use super::painter::{Painter, Subject};
use crate::base::escape::quoted;
use crate::cli::Output;
use crate::diagnostic::Diagnostic;
use crate::image_io::{CompleteFile, Content, OutputFile, Written, check_distinct, put_in_place};
use crate::picture::Color;
use crate::render::{Layer, Progress};
use crate::scene::edition::Edition;
use crate::scene::load::mesh_places;
use crate::tools::explain::Stop;
use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Writes these pictures of a view, all or none, and returns a line that says so. `compared` has the pictures that the
/// command line compares.
pub fn save(
    subject: &Subject,
    outputs: &[Output],
    compared: &[PathBuf],
    painter: &Painter,
    stop: &Stop,
) -> Result<String, Answer> {
    if outputs.is_empty() {
        let reason = "the command line names no picture to write; copy the one below";
        return Err(Answer::impossible(reason));
    }
    check(subject, outputs, compared)?;
    let complete = |output| complete(subject, output, painter, stop);
    put_in_place(outputs.iter().map(complete).collect::<Result<_, _>>()?)?;
    let names: Vec<String> = outputs.iter().map(|output| quoted(&output.file)).collect();
    Ok(format!("saved {}", names.join(", ")))
}

/// An error if two pictures go to one file, or if one goes to a file that is read.
fn check(subject: &Subject, outputs: &[Output], compared: &[PathBuf]) -> Result<(), Diagnostic> {
    let renderer = &subject.scene.renderer;
    let scene = &renderer.source.path;
    let folder = scene.parent().unwrap_or(Path::new(""));
    let places = |name| Edition::ALL.into_iter().flat_map(move |edition| mesh_places(name, folder, edition));
    let meshes = renderer.scene.meshes.iter().flat_map(|mesh| places(mesh.name.as_str()));
    let images = renderer.scene.images.iter().flat_map(|image| places(image.name.as_str()));
    let pictures = images.chain(compared.iter().cloned()).map(|picture| ("picture", picture));
    let read =
        [("scene", scene.clone())].into_iter().chain(meshes.map(|mesh| ("mesh", mesh))).chain(pictures);
    check_distinct(outputs.iter().map(|output| Written::Named(output.file.clone())), read)
}

fn complete(
    subject: &Subject,
    output: &Output,
    painter: &Painter,
    stop: &Stop,
) -> Result<CompleteFile, Answer> {
    // A pipe would wait for a reader.
    if fs::metadata(&output.file).is_ok_and(|found| !found.is_file()) {
        return Err(Answer::impossible(format!("{} is no file", quoted(&output.file))));
    }
    let file = OutputFile::prepare(&output.file)?;
    if let Layer::Cost(cost) = output.layer {
        let painted = painter.paint(&Subject { cost: Some(cost), ..subject.clone() }, stop)?;
        return Ok(file.picture(output.format, &painted.picture)?);
    }
    let request = subject.request(output.layer);
    let ready = painter.ready(subject, false, subject.options.visualize_grid)?;
    let content = if output.layer.is_distance() { Content::Distances } else { Content::Colors };
    let size = request.layer_size(&output.layer);
    let mut writer = file.begin(output.format, size, content, None)?;
    let mut written = Ok(());
    let mut take_row = |_: usize, row: &[Color]| {
        written = writer.row(row);
        if written.is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    let watch = |progress: Progress| stop.watch(progress);
    let rendered = ready.borrow_dependent().render_rows(&request, &watch, &mut take_row);
    written?;
    rendered?;
    Ok(writer.complete()?)
}
