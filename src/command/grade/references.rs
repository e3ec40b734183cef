//! What pictures are graded by: files, or what command lines render.

use super::folder::entries;
use raytracer::base::escape::quoted;
use raytracer::caster::choose::Structure;
use raytracer::cli::{self, Options, parse_commands};
use raytracer::diagnostic::Diagnostic;
use raytracer::image_io::{Format, ReadFile, read_picture};
use raytracer::picture::{FloatPicture, Picture};
use raytracer::render::renderer::{Meshes, Renderer};
use raytracer::render::{Layer, Request, Tracing};
use raytracer::scene::load;
use raytracer::scene::model::Shows;
use raytracer::tools::causes::{Finding, FinishedPicture, Mistake, Original};
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// The references, each of which is made when it is needed.
pub struct References {
    all: Vec<(OsString, Origin)>,
}

/// Where a reference comes from.
enum Origin {
    File(PathBuf),
    Rendered(Box<Options>, Layer),
}

/// A reference, and how differences from it are explained.
pub struct Reference<'r> {
    pub picture: Picture,
    pub source: Source<'r>,
}

/// What is known of a reference.
pub enum Source<'r> {
    /// The scene.
    Scene(Box<Original<'r>>),
    /// The colours, which are not those of a scene.
    Colors(FloatPicture),
    /// The picture alone.
    File,
}

impl Source<'_> {
    /// Why each wrong picture differs from the reference.
    pub fn explain(&mut self, wrong: &[Picture], reference: &Picture) -> Vec<Option<Finding>> {
        let finished = match self {
            Self::Scene(original) => {
                return original.explain_parts(wrong, reference).into_iter().map(Some).collect();
            }
            Self::Colors(colors) => FinishedPicture::of_colors(colors.clone()),
            Self::File => FinishedPicture::of_picture(reference),
        };
        finished.explain(wrong).into_iter().map(Some).collect()
    }
}

impl References {
    /// Lists the folder's pictures, or those that the command lines write. Where two lines write the same file, the
    /// later one counts, as it would on the disk.
    pub fn open(from: &cli::References) -> Result<Self, Diagnostic> {
        let all = match from {
            cli::References::Folder(folder) => files(folder)?,
            cli::References::Commands(file) => rendered(file)?,
        };
        match all.is_empty() {
            true => Err(Diagnostic::error("there is no picture to grade by")),
            false => Ok(Self { all }),
        }
    }

    /// The files that are read for them: pictures, or scenes with their meshes.
    pub fn files(&self) -> impl Iterator<Item = ReadFile> {
        self.all.iter().flat_map(|(_, origin)| match origin {
            Origin::File(path) => vec![("picture", path.clone())],
            Origin::Rendered(options, _) => {
                let scenes = options.input.iter();
                let meshes = scenes.clone().flat_map(|scene| load::mesh_files(scene, &options.hints()));
                let meshes = meshes.map(|mesh| ("mesh", mesh));
                scenes.map(|scene| ("scene", scene.clone())).chain(meshes).collect()
            }
        })
    }

    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// The files' names, in order.
    pub fn names(&self) -> impl Iterator<Item = &OsStr> {
        self.all.iter().map(|(name, _)| name.as_os_str())
    }

    pub fn has(&self, name: &OsStr) -> bool {
        self.names().any(|other| other == name)
    }

    /// Makes a reference, and does some work with it or with the reason why there is none. Too little memory for a picture
    /// is an error.
    pub fn with<T>(
        &self,
        index: usize,
        work: impl FnOnce(Result<Reference, String>) -> Result<T, Diagnostic>,
    ) -> Result<T, Diagnostic> {
        match &self.all[index].1 {
            Origin::File(path) => match read_picture(path) {
                Ok(picture) => work(Ok(Reference { picture, source: Source::File })),
                Err(error) if error.kind() == std::io::ErrorKind::OutOfMemory => Err(error.into()),
                Err(error) => work(Err(error.to_string())),
            },
            Origin::Rendered(options, layer) => match renderer(options) {
                Ok((renderer, options)) => work(render(&renderer, &options, *layer)),
                Err(error) => work(Err(error)),
            },
        }
    }
}

/// The scene, and the options as its edition settles them.
fn renderer(options: &Options) -> Result<(Renderer, Options), String> {
    let input = options.input.as_deref().ok_or("there is no scene")?;
    let loaded = load::load_with(input, &options.hints());
    let renderer = loaded.and_then(|loaded| {
        let options = options.in_edition(loaded.choice.edition);
        Ok((Renderer::new(loaded, Meshes::Kept)?, options))
    });
    renderer.map_err(|error| error.headline())
}

fn render<'r>(renderer: &'r Renderer, options: &Options, layer: Layer) -> Result<Reference<'r>, String> {
    let request = Request { layers: vec![layer], ..options.request() };
    let shows_scene = !options.visualize_grid && renderer.scene.model.shows == Shows::Scene;
    let source = if layer.is_of_scene() && shows_scene {
        let original = Original::new(renderer, Structure::Any, &request);
        Source::Scene(Box::new(original.ok_or("there is no memory for the picture")?))
    } else {
        Source::Colors(colors(renderer, options, &request)?)
    };
    let picture = match &source {
        Source::Scene(original) => original.picture(Mistake::Unchanged),
        Source::Colors(colors) => Some(colors.to_picture()),
        Source::File => None,
    };
    let picture = picture.ok_or("there is no memory for the picture")?;
    Ok(Reference { picture, source })
}

/// The colours of a layer that is not the picture of a scene.
fn colors(renderer: &Renderer, options: &Options, request: &Request) -> Result<FloatPicture, String> {
    let prepared = match options.structure {
        Structure::Grid(grid) if options.visualize_grid => {
            renderer.prepare_cells(grid, request.camera_rays(), Tracing::Fast)
        }
        _ => renderer.prepare_for(Structure::Any, request, Tracing::Fast),
    };
    let pictures = prepared.map_err(|error| error.to_string())?.render(request);
    pictures.map_err(|error| error.to_string())?.pop().ok_or_else(|| "nothing is rendered".into())
}

/// The pictures in a folder.
fn files(folder: &Path) -> Result<Vec<(OsString, Origin)>, Diagnostic> {
    let mut names = entries(folder)?;
    names.retain(|name| Format::of_input(Path::new(name)).is_some());
    Ok(names.into_iter().map(|name| (name.clone(), Origin::File(folder.join(name)))).collect())
}

/// The pictures of the command lines in a file, in the order in which they are first written.
fn rendered(file: &Path) -> Result<Vec<(OsString, Origin)>, Diagnostic> {
    let shown = quoted(file);
    if file.exists() && !file.is_file() {
        return Err(Diagnostic::error(format!("cannot read the commands {shown}: it is not a regular file")));
    }
    let text = std::fs::read_to_string(file);
    let text =
        text.map_err(|error| Diagnostic::error(format!("cannot read the commands {shown}: {error}")))?;
    let commands = parse_commands(&text).map_err(|error| Diagnostic::error(format!("{shown}, {error}")))?;
    let mut all: Vec<(OsString, Origin)> = Vec::new();
    for options in commands {
        for output in &options.outputs {
            let Some(name) = output.file.file_name() else { continue };
            let origin = Origin::Rendered(Box::new(options.clone()), output.layer);
            match all.iter_mut().find(|(other, _)| other == name) {
                Some((_, earlier)) => *earlier = origin,
                None => all.push((name.to_owned(), origin)),
            }
        }
    }
    Ok(all)
}
