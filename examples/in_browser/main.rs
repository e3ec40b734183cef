//! The library alone, without threads, files that are written and what else the program takes from the system: it takes
//! the words of a command line, and writes the pictures of that line one after the other to standard output, as PPM.
//!
//! Compiled for WebAssembly it runs in a browser, or under Node.js by `run.mjs`, with the same bytes.

use raytracer::cli::{self, Command};
use raytracer::render::renderer::{Meshes, Renderer};
use raytracer::scene::load;
use std::error::Error;
use std::io::{Write, stdout};

fn main() -> Result<(), Box<dyn Error>> {
    let Command::Render(options) = cli::parse(std::env::args_os())? else {
        return Err("only lines that render are understood".into());
    };
    let input = options.input.as_deref().ok_or("no scene")?;
    let loaded = load::load(input)?;
    let options = options.in_edition(loaded.choice.edition);
    let renderer = Renderer::new(loaded, Meshes::Kept)?;
    let request = options.request();
    let prepared = options.prepare(&renderer, &request)?;
    let mut output = stdout().lock();
    for picture in prepared.render(&request)? {
        let [width, height] = picture.size;
        write!(output, "P6\n{width} {height}\n255\n")?;
        output.write_all(&picture.to_bytes().0)?;
    }
    Ok(())
}
