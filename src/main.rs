//! The program: command line in, pictures and statistics out. The only place that prints and exits.

#[cfg(target_os = "linux")]
mod pages;

use raytracer::cli::{self, Command, Options};
use raytracer::image_io::{ImageError, OutputFile, PictureWriter};
use raytracer::mode::{Course, Fast, Mode};
use raytracer::renderer::{Meshes, Renderer};
use raytracer::scene::Color;
use raytracer::scene_io;
use raytracer::stats::{Counts, Probe, Quiet, Report, Timings};
use std::fmt::Display;
use std::io::Write;
use std::ops::ControlFlow;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::{Duration, Instant};

fn main() -> ExitCode {
    match cli::parse(std::env::args_os()) {
        Ok(Command::Help(text) | Command::Version(text)) => print(&text),
        Ok(Command::Render(options)) => match run(&options) {
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

/// Does what the options ask for; returns the statistics if they were asked for, or the message of the error that
/// ends the program.
fn run(options: &Options) -> Result<Option<Report>, String> {
    if options.stats {
        render::<Course, Counts>(options).map(Some)
    } else {
        render::<Fast, Quiet>(options).map(|_| None)
    }
}

/// Reads, prepares, renders and writes.
fn render<M: Mode, P: Probe>(options: &Options) -> Result<Report, String> {
    // This thread is among them: for one thread none is started, and calls from here neither wake another nor wait.
    let threads =
        rayon::ThreadPoolBuilder::new().num_threads(options.threads.unwrap_or(0)).use_current_thread();
    let threads = Arc::new(threads.build().map_err(failed)?);
    if options.preview {
        tell("note: this build has no preview; the picture is rendered directly");
    }
    let files = options.outputs.iter().map(|output| OutputFile::prepare(&output.file));
    let files: Vec<OutputFile> = files.collect::<Result<_, _>>().map_err(failed)?;

    let mut clock = Clock(Instant::now());
    let loaded = scene_io::load(&options.input).map_err(|error| error.to_string())?;
    if loaded.scene.lights.is_empty() {
        tell("WARNING:  No lights specified");
    }
    let reading = clock.lap();
    let meshes = if options.visualize_grid { Meshes::Kept } else { Meshes::Moved };
    let renderer = Renderer::new(loaded, meshes).map_err(|error| error.to_string())?;
    let renderer = renderer.on_threads(threads.clone());
    let rays = options.size[0] * options.size[1] * options.sampler.count() as usize;
    let prepared = match options.grid {
        Some(grid) if options.visualize_grid => renderer.prepare_cells::<M>(grid, rays),
        grid => renderer.prepare::<M>(grid, rays),
    };
    let prepared = prepared.map_err(failed)?;
    let building = clock.lap();

    let request = options.request();
    let sizes = request.layers.iter().map(|layer| layer.size(request.window_size()));
    let writers = files.into_iter().zip(sizes).map(|(file, size)| file.begin(size));
    let mut writers: Vec<PictureWriter> = writers.collect::<Result<_, _>>().map_err(failed)?;
    let mut encoding = Duration::ZERO;
    let mut take_row = |layer: usize, row: &[Color]| -> Result<(), ImageError> {
        let start = Instant::now();
        let taken = writers[layer].row(row);
        encoding += start.elapsed();
        taken
    };
    let probe: P =
        prepared.render_rows(&request, &|_| ControlFlow::Continue(()), &mut take_row).map_err(failed)?;
    let rendering = clock.lap() - encoding;

    let finished = writers.into_iter().map(PictureWriter::finish);
    let nans: u64 = finished.sum::<Result<_, _>>().map_err(failed)?;
    if nans > 0 {
        tell(&format!("warning: the colours of {nans} pixels are not numbers; they are black"));
    }
    Ok(Report {
        size: options.size,
        bounds: renderer.bounds(),
        grid: prepared.cells(),
        counts: probe.counts(),
        timings: Timings { reading, building, rendering, writing: encoding + clock.lap() },
        threads: threads.current_num_threads(),
    })
}

/// Measures one stage after the other.
struct Clock(Instant);

impl Clock {
    /// The time since the last lap.
    fn lap(&mut self) -> Duration {
        let now = Instant::now();
        now - std::mem::replace(&mut self.0, now)
    }
}
