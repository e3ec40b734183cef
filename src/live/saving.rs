//! Writes the pictures that the command line names, and no others.

use super::painter::{Painted, Subject, Unpainted};
use crate::caster::choose::Structure;
use crate::cli::Output;
use crate::distinct_files::{ReadAs, SameFile, WrittenFiles};
use crate::escape::quoted;
use crate::image_io::{CompleteFile, Content, ImageError, OutputFile, put_in_place};
use crate::render::{Layer, Request, Tracing};
use crate::renderer::{Prepared, Renderer};
use crate::scene::edition::Edition;
use crate::scene_io::mesh_places;
use std::fs;
use std::path::{Path, PathBuf};

type Paint<'a> = dyn FnMut(&Subject) -> Result<Painted, Unpainted> + 'a;

/// Writes these pictures of a view, all or none, and returns a line that says so; an error is a line too.
/// `compared` has the pictures that the command line compares.
pub fn save(
    subject: &Subject,
    outputs: &[Output],
    compared: &[PathBuf],
    paint: &mut Paint,
) -> Result<String, String> {
    if outputs.is_empty() {
        return Err("the command line names no picture to write; copy the one below".into());
    }
    check(subject, outputs, compared).map_err(|error| error.to_string())?;
    let files = outputs.iter().map(|output| complete(subject, output, paint));
    let files = files.collect::<Result<_, _>>()?;
    put_in_place(files).map_err(|error| error.to_string())?;
    let names: Vec<String> = outputs.iter().map(|output| quoted(&output.file)).collect();
    Ok(format!("saved {}", names.join(", ")))
}

/// An error if two pictures go to one file, or if one goes to a file that is read.
fn check(subject: &Subject, outputs: &[Output], compared: &[PathBuf]) -> Result<(), SameFile> {
    let files = WrittenFiles::of_saving(outputs)?;
    let renderer = &subject.scene.renderer;
    let scene = &renderer.source.path;
    files.check_read(ReadAs::Scene, scene)?;
    let folder = scene.parent().unwrap_or(Path::new(""));
    let places = |name| Edition::ALL.into_iter().flat_map(move |edition| mesh_places(name, folder, edition));
    let mut meshes = renderer.scene.meshes.iter().flat_map(|mesh| places(mesh.name.as_str()));
    meshes.try_for_each(|mesh| files.check_read(ReadAs::Mesh, &mesh))?;
    let mut images = renderer.scene.images.iter().flat_map(|image| places(image.name.as_str()));
    images.try_for_each(|image| files.check_read(ReadAs::Picture, &image))?;
    compared.iter().try_for_each(|picture| files.check_read(ReadAs::Picture, picture))
}

fn complete(subject: &Subject, output: &Output, paint: &mut Paint) -> Result<CompleteFile, String> {
    // A pipe would wait for a reader.
    if fs::metadata(&output.file).is_ok_and(|found| !found.is_file()) {
        return Err(format!("{} is no file", quoted(&output.file)));
    }
    let file = OutputFile::prepare(&output.file).map_err(|error| error.to_string())?;
    let failed = |error: ImageError| error.to_string();
    if let Layer::Cost(cost) = output.layer {
        let subject = Subject { cost: Some(cost), sketch: None, ..subject.clone() };
        let painted = paint(&subject).map_err(|error| error.to_string())?;
        return file.picture(output.format, &painted.picture).map_err(failed);
    }
    let request = Request { camera: subject.camera, layers: vec![output.layer], ..subject.options.request() };
    let prepared = prepare(&subject.scene.renderer, subject, &request)?;
    let pictures = prepared.render(&request).map_err(|error| error.to_string())?;
    let picture = pictures.first().ok_or("nothing was rendered")?;
    let content = if output.layer.is_distance() { Content::Distances } else { Content::Colors };
    let mut writer = file.begin(output.format, picture.size, content, None).map_err(failed)?;
    picture.colors.chunks_exact(picture.size[0]).try_for_each(|row| writer.row(row)).map_err(failed)?;
    writer.complete().map_err(failed)
}

fn prepare<'r>(renderer: &'r Renderer, subject: &Subject, request: &Request) -> Result<Prepared<'r>, String> {
    let prepared = match subject.options.structure {
        Structure::Grid(grid) if subject.options.visualize_grid => {
            renderer.prepare_cells(grid, request.camera_rays(), Tracing::Fast)
        }
        structure => renderer.prepare_for(structure, request, Tracing::Fast),
    };
    prepared.map_err(|error| error.to_string())
}
