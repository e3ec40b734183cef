//! What becomes of the rows of each layer: a file, a picture that is kept, or a map of costs.

use crate::failed;
use raytracer::explain::CostMap;
use raytracer::image_io::{ImageError, OutputFile, PictureWriter};
use raytracer::memory::with_room;
use raytracer::picture::{CHANNELS, Picture, RED_FIRST, truncate_to_bytes};
use raytracer::render::{Cost, Layer, Request};
use raytracer::scene::Color;
use std::time::{Duration, Instant};

/// Takes the rows of a render.
pub struct Products {
    /// One for each layer of the request.
    layers: Vec<Product>,
    /// The time that taking the rows has taken.
    pub encoding: Duration,
}

enum Product {
    /// A picture file, written row by row.
    File(Box<PictureWriter>),
    /// The bytes of a picture.
    Kept(Vec<u8>),
    /// What each pixel costs; the file gets the finished map.
    Costs(OutputFile, Cost, Vec<u64>),
}

/// What is left of a render when all files are written.
#[derive(Default)]
pub struct Finished {
    pub kept: Option<Picture>,
    pub costs: Option<CostMap>,
    /// How many of the colours in the files are not numbers.
    pub nans: u64,
}

impl Products {
    /// The files of the first layers of a request.
    pub fn begin(files: Vec<OutputFile>, request: &Request) -> Result<Self, String> {
        let begin = |(file, layer): (OutputFile, &Layer)| match *layer {
            Layer::Cost(cost) => {
                let [width, height] = request.window_size();
                Ok(Product::Costs(file, cost, with_room(width * height).map_err(failed)?))
            }
            _ => Ok(Product::File(Box::new(file.begin(layer.size(request.window_size())).map_err(failed)?))),
        };
        let layers = files.into_iter().zip(&request.layers).map(begin).collect::<Result<_, String>>()?;
        Ok(Self { layers, encoding: Duration::ZERO })
    }

    /// Keeps the colours of one more layer. `size` is the width and height of the picture in pixels.
    pub fn keep(&mut self, [width, height]: [usize; 2]) -> Result<(), String> {
        self.layers.push(Product::Kept(with_room(width * height * CHANNELS).map_err(failed)?));
        Ok(())
    }

    pub fn take_row(&mut self, layer: usize, row: &[Color]) -> Result<(), ImageError> {
        let start = Instant::now();
        match &mut self.layers[layer] {
            Product::File(writer) => writer.row(row)?,
            Product::Kept(bytes) => {
                let before = bytes.len();
                bytes.resize(before + row.len() * CHANNELS, 0);
                truncate_to_bytes::<RED_FIRST>(row, &mut bytes[before..]);
            }
            Product::Costs(_, _, counts) => counts.extend(row.iter().map(|cost| cost.x as u64)),
        }
        self.encoding += start.elapsed();
        Ok(())
    }

    /// Completes the files. `size` is the width and height of the picture in pixels.
    pub fn finish(self, size: [usize; 2]) -> Result<Finished, String> {
        let mut finished = Finished::default();
        for product in self.layers {
            match product {
                Product::File(writer) => finished.nans += writer.finish().map_err(failed)?,
                Product::Kept(bytes) => {
                    let [width, height] = size.map(|n| n as u32);
                    finished.kept = Some(Picture::from_rgb(width, height, bytes));
                }
                Product::Costs(file, cost, counts) => {
                    let map = CostMap { cost, size, counts };
                    file.write(&map.draw().map_err(failed)?).map_err(failed)?;
                    finished.costs = Some(map);
                }
            }
        }
        Ok(finished)
    }
}
