//! The program: command line in, pictures and statistics out. The only place that prints and exits.

#[cfg(target_os = "linux")]
mod pages;

use raytracer::camera::Camera;
use raytracer::cli::{self, Command, Options};
use raytracer::grid::options::GridOptions;
use raytracer::grid::{Caster, Instructions};
use raytracer::image_io::{ImageError, OutputFile};
use raytracer::picture::Picture;
use raytracer::render::grid_view::Occupancy;
use raytracer::render::{Pictures, View, render, render_filter};
use raytracer::scene_io::{self, LoadedScene};
use raytracer::stats::{Counts, Probe, Quiet, Report, Timings};
use raytracer::world::World;
use std::fmt::Display;
use std::io::Write;
use std::mem;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    match cli::parse(std::env::args_os()) {
        Ok(Command::Help(text) | Command::Version(text)) => print(&text),
        Ok(Command::Render(options)) => match set_threads(&options).and_then(|()| run(&options)) {
            Ok(Some(report)) => print(&report.to_string()),
            Ok(None) => ExitCode::SUCCESS,
            Err(message) => {
                tell(&message);
                ExitCode::FAILURE
            }
        },
        Err(error) => {
            tell(&failed(error));
            ExitCode::from(2)
        }
    }
}

/// Prints to standard output; a reader that went away is no reason to panic.
fn print(text: &str) -> ExitCode {
    match std::io::stdout().write_all(text.as_bytes()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(_) => ExitCode::FAILURE,
    }
}

/// Prints a line to standard error. Where nobody reads it there is nobody to tell, and `eprintln!` would panic.
fn tell(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

fn failed(error: impl Display) -> String {
    format!("error: {error}")
}

/// Makes as many threads as the options ask for, or as there are processors. This one is among them:
/// for one thread none is started, and calls from here neither wake another nor wait for it.
fn set_threads(options: &Options) -> Result<(), String> {
    const AS_MANY_AS_PROCESSORS: usize = 0;
    let threads = options.threads.unwrap_or(AS_MANY_AS_PROCESSORS);
    rayon::ThreadPoolBuilder::new().num_threads(threads).use_current_thread().build_global().map_err(failed)
}

/// Does what the options ask for; gives the statistics if they were asked for, or the message of
/// the error that ends the program.
fn run(options: &Options) -> Result<Option<Report>, String> {
    if options.preview {
        tell("note: this build has no preview; the picture is rendered directly");
    }
    let outputs = Outputs::prepare(options).map_err(failed)?;
    let start = Instant::now();
    let loaded = scene_io::load(&options.input).map_err(|error| error.to_string())?;
    if loaded.scene.lights.is_empty() {
        tell("WARNING:  No lights specified");
    }
    let timings = Timings { reading: start.elapsed(), ..Timings::default() };
    if options.stats {
        draw::<Counts>(options, loaded, outputs, timings).map(Some)
    } else {
        draw::<Quiet>(options, loaded, outputs, timings).map(|_| None)
    }
}

/// The files to write, checked before any work is done.
struct Outputs {
    color: Option<OutputFile>,
    depth: Option<OutputFile>,
    normals: Option<OutputFile>,
    samples: Option<OutputFile>,
    filter: Option<OutputFile>,
}

impl Outputs {
    fn prepare(options: &Options) -> Result<Self, ImageError> {
        let file = |path: Option<&PathBuf>| path.map(|path| OutputFile::prepare(path)).transpose();
        Ok(Self {
            color: file(options.output.as_ref())?,
            depth: file(options.depth.as_ref().map(|depth| &depth.file))?,
            normals: file(options.normals.as_ref())?,
            samples: file(options.samples.as_ref().map(|picture| &picture.file))?,
            filter: file(options.filter_picture.as_ref().map(|picture| &picture.file))?,
        })
    }

    fn write(self, options: &Options, pictures: &Pictures) -> Result<(), String> {
        let filter = options.filter_picture.as_ref();
        let filter = filter.map(|picture| render_filter(options.filter, options.size, picture.zoom));
        let filter: Option<Picture> = filter.transpose().map_err(failed)?;
        for (file, picture) in [
            (self.color, &pictures.color),
            (self.depth, &pictures.depth),
            (self.normals, &pictures.normals),
            (self.samples, &pictures.samples),
            (self.filter, &filter),
        ] {
            if let (Some(file), Some(picture)) = (file, picture) {
                file.write(picture).map_err(failed)?;
            }
        }
        Ok(())
    }
}

/// Builds, renders and writes.
fn draw<P: Probe>(
    options: &Options,
    LoadedScene { scene, mut meshes, source }: LoadedScene,
    outputs: Outputs,
    mut timings: Timings,
) -> Result<Report, String> {
    let start = Instant::now();
    let own = if options.visualize_grid { meshes.clone() } else { mem::take(&mut meshes) };
    let world = World::of_meshes(&scene, own).map_err(|error| source.render(&error))?;
    let rays = options.size[0] * options.size[1] * options.sampler.count() as usize;
    let asked = GridOptions::new(options.grid, &world, rays, P::COUNTS);
    let cast = if options.visualize_grid { GridOptions::NONE } else { asked };
    let caster = Caster::with(&world, cast, Instructions::available()[0]).map_err(failed)?;
    let occupancy = match asked.cells {
        Some(cells) if options.visualize_grid => {
            Some(Occupancy::new(&scene, &meshes, world.bounds, cells).map_err(failed)?)
        }
        _ => None,
    };
    timings.building = start.elapsed();

    let start = Instant::now();
    let camera = Camera::new(&scene.camera, options.size);
    let view = occupancy.as_ref().map_or(View::Scene(options.effects), View::Cells);
    let (pictures, probe) = render::<P>(&camera, &caster, &options.request(view)).map_err(failed)?;
    timings.rendering = start.elapsed();
    if pictures.nans > 0 {
        tell(&format!("warning: the colours of {} pixels are not numbers; they are black", pictures.nans));
    }

    let start = Instant::now();
    outputs.write(options, &pictures)?;
    timings.writing = start.elapsed();
    Ok(Report {
        size: options.size,
        bounds: (!world.bounds.is_empty()).then_some(world.bounds),
        grid: caster.cells().or(asked.cells),
        counts: probe.counts(),
        timings,
        threads: rayon::current_num_threads(),
    })
}
