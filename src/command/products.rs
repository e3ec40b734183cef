//! What becomes of the rows of each layer: a file, a picture that is kept, or a map of costs.

use raytracer::base::memory::with_room;
use raytracer::diagnostic::Diagnostic;
use raytracer::image_io::{CompleteFile, Content, Exceptional, Format, OutputFile, Part, PictureWriter};
use raytracer::picture::{CHANNELS, Color, Picture, RED_FIRST, truncate_to_bytes};
use raytracer::render::{Cost, Layer, Request};
use raytracer::scene::Scene;
use raytracer::scene::model::{NormalColors, Shows};
use raytracer::tools::explain::CostMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Takes the rows of a render.
pub struct Products {
    /// One for each layer of the request.
    layers: Vec<Product>,
    /// The time that taking the rows has taken.
    pub encoding: Duration,
    /// For each layer the colour where nothing is hit, unless the layer shows something else.
    blank: Vec<Option<Color>>,
    /// Whether all rows so far have only that colour.
    is_blank: bool,
}

enum Product {
    /// A picture file, written row by row.
    File(Box<PictureWriter>),
    /// Width and height in pixels, and the bytes of a picture.
    Kept([usize; 2], Vec<u8>),
    /// What each pixel costs; the file gets the finished map.
    Costs(OutputFile, Format, Cost, Vec<u64>),
}

/// The file with the complete rows of a picture, if there is one.
pub type KeptPart = Option<PathBuf>;

/// What is left of a render when all rows are taken.
#[derive(Default)]
pub struct FinishedLayers {
    pub files: Vec<CompleteFile>,
    pub kept: Option<Picture>,
    pub costs: Option<CostMap>,
}

impl Products {
    /// The files of the first layers of a request. `part` tells of each layer's picture which part of the whole it is.
    pub fn begin(
        files: Vec<(OutputFile, Format)>,
        request: &Request,
        part: &dyn Fn(Layer) -> Option<Part>,
    ) -> Result<Self, Diagnostic> {
        let begin = |((file, format), layer): ((OutputFile, Format), &Layer)| match *layer {
            Layer::Cost(cost) => {
                let [width, height] = request.window_size();
                Ok(Product::Costs(file, format, cost, with_room(width * height)?))
            }
            layer => {
                let content = if layer.is_distance() { Content::Distances } else { Content::Colors };
                let part = part(layer);
                let writer = file.begin(format, request.layer_size(&layer), content, part.as_ref());
                Ok(Product::File(Box::new(writer?)))
            }
        };
        let layers = files.into_iter().zip(&request.layers).map(begin).collect::<Result<_, Diagnostic>>()?;
        Ok(Self { layers, encoding: Duration::ZERO, blank: vec![], is_blank: false })
    }

    /// Watches whether the pictures show nothing but what rays show that hit nothing. In a scene that `is_empty` they do.
    pub fn watch_for_blank(&mut self, request: &Request, scene: &Scene, is_empty: bool) {
        self.blank = request.layers.iter().map(|layer| blank(layer, scene)).collect();
        // A part of a picture may well show nothing.
        self.is_blank = request.window.is_none() && self.blank.iter().any(Option::is_some);
        if is_empty {
            self.blank.fill(None);
        }
    }

    /// Keeps one more layer, whose picture has this width and height in pixels.
    pub fn keep(&mut self, size @ [width, height]: [usize; 2]) -> Result<(), Diagnostic> {
        self.layers.push(Product::Kept(size, with_room(width * height * CHANNELS)?));
        Ok(())
    }

    pub fn take_row(&mut self, layer: usize, row: &[Color]) -> Result<(), Diagnostic> {
        let start = Instant::now();
        if self.is_blank
            && let Some(blank) = self.blank[layer]
        {
            self.is_blank = row.iter().all(|&color| color == blank);
        }
        match &mut self.layers[layer] {
            Product::File(writer) => writer.row(row)?,
            Product::Kept(_, bytes) => {
                let before = bytes.len();
                bytes.resize(before + row.len() * CHANNELS, 0);
                truncate_to_bytes::<RED_FIRST>(row, &mut bytes[before..]);
            }
            Product::Costs(_, _, _, counts) => counts.extend(row.iter().map(|cost| cost.x as u64)),
        }
        self.encoding += start.elapsed();
        Ok(())
    }

    /// Writes the complete rows of a render that was cancelled, for each layer of the request. `part` tells which
    /// part of the whole they are.
    pub fn keep_parts(
        self,
        request: &Request,
        part: &dyn Fn(Layer) -> Option<Part>,
    ) -> Result<Vec<KeptPart>, Diagnostic> {
        let keep = |(product, &layer): (Product, &Layer)| match (product, part(layer)) {
            (Product::File(writer), Some(part)) => Ok(writer.write_part(&part)?),
            // The picture of a filter is complete before the first row is rendered. Nobody is waited for.
            (Product::File(writer), None) if matches!(layer, Layer::Filter { .. }) => {
                let file = writer.complete()?;
                if !file.is_stream() {
                    file.put_in_place()?;
                }
                Ok(None)
            }
            _ => Ok(None),
        };
        self.layers.into_iter().zip(&request.layers).map(keep).collect()
    }

    /// Whether a picture of the scene was taken in which every pixel is as if nothing had been hit.
    pub fn shows_nothing(&self) -> bool {
        self.is_blank
    }

    /// The colours so far that the files do not show as they are.
    pub fn exceptional(&self) -> Exceptional {
        let mut all = Exceptional::default();
        for product in &self.layers {
            if let Product::File(writer) = product {
                all += writer.exceptional;
            }
        }
        all
    }

    /// Completes the files. `size` is the width and height of a map of costs in pixels.
    pub fn finish(self, size: [usize; 2]) -> Result<FinishedLayers, Diagnostic> {
        let mut finished = FinishedLayers::default();
        for product in self.layers {
            match product {
                Product::File(writer) => finished.files.push(writer.complete()?),
                Product::Kept(size, bytes) => {
                    let [width, height] = size.map(|n| n as u32);
                    finished.kept = Some(Picture::from_rgb(width, height, bytes));
                }
                Product::Costs(file, format, cost, counts) => {
                    let map = CostMap { cost, size, counts };
                    let picture = map.draw()?;
                    finished.files.push(file.picture(format, &picture)?);
                    finished.costs = Some(map);
                }
            }
        }
        Ok(finished)
    }
}

/// The colour that a layer shows where nothing is hit.
fn blank(layer: &Layer, scene: &Scene) -> Option<Color> {
    match layer {
        Layer::Color if scene.model.shows == Shows::Places => None,
        Layer::Color => Some(scene.background.color).filter(|_| scene.cube_map.is_none()),
        Layer::Normals if scene.model.normal_colors == NormalColors::Shifted => Some(Color::splat(0.5)),
        Layer::Depth { .. } | Layer::Normals | Layer::SignedNormals => Some(Color::ZERO),
        Layer::Distance => Some(Color::INFINITY),
        Layer::Samples { .. } | Layer::Cost(_) | Layer::Filter { .. } => None,
    }
}
