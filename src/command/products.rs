//! Takes the rows of each layer, for a file, a picture in memory, or a cost map.

use super::parts::{part, window};
use crate::diagnostic::Diagnostic;
use crate::image_io::{CompleteFile, Exceptional, Format, OutputFile, PictureWriter};
use crate::picture::{Color, Pixels};
use crate::render::renderer::Prepared;
use crate::render::{Cost, Layer, Request, Window};
use crate::tools::explain::CostMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Takes the rows of a render.
pub struct Products<'r> {
    prepared: &'r Prepared<'r>,
    request: &'r Request,
    /// In the order of the layers of the request.
    layers: Vec<Product>,
    /// The time that was spent on taking rows.
    pub encoding: Duration,
    /// The first colour of each layer.
    first: Vec<Option<Color>>,
    /// True if the scene's layers have one colour each so far, as if no ray had hit anything.
    pub is_blank: bool,
}

enum Product {
    /// A picture file, written row by row.
    File(Box<PictureWriter>),
    /// A picture, and the number of its rows so far.
    Kept { picture: Pixels, rows: usize },
    /// The file that gets the map of the costs.
    Costs { file: OutputFile, format: Format, cost: Cost },
}

/// The results of a render whose rows are all taken.
#[derive(Default)]
pub struct Finished {
    pub files: Vec<CompleteFile>,
    pub costs: Option<CostMap>,
    /// The last layer without a file.
    pub picture: Option<Pixels>,
}

impl<'r> Products<'r> {
    /// Begins the files of the first layers of a request. The picture of a layer without a file is kept, in numbers if
    /// `keeps_numbers`.
    pub fn begin(
        files: Vec<(OutputFile, Format)>,
        prepared: &'r Prepared<'r>,
        request: &'r Request,
        keeps_numbers: bool,
    ) -> Result<Self, Diagnostic> {
        let mut files = files.into_iter();
        let begin = |&layer: &Layer| {
            let size = request.layer_size(&layer);
            Ok(match (files.next(), layer) {
                (None, _) => Product::Kept { picture: Pixels::zeros(size, keeps_numbers)?, rows: 0 },
                (Some((file, format)), Layer::Cost(cost)) => Product::Costs { file, format, cost },
                (Some((file, format)), layer) => {
                    let part = request.window.and_then(|window| part(prepared, request, window, layer));
                    Product::File(Box::new(file.begin(format, size, layer.content(), part.as_ref())?))
                }
            })
        };
        let layers = request.layers.iter().map(begin).collect::<Result<Vec<_>, Diagnostic>>()?;
        // A part of a picture may well show nothing.
        let is_blank = request.window.is_none() && request.layers.iter().any(shows_scene);
        let first = vec![None; layers.len()];
        Ok(Self { prepared, request, layers, encoding: Duration::ZERO, first, is_blank })
    }

    /// Takes the next row of a layer.
    pub fn take_row(&mut self, layer: usize, row: &[Color]) -> Result<(), Diagnostic> {
        let start = Instant::now();
        if self.is_blank && shows_scene(&self.request.layers[layer]) {
            let first = *self.first[layer].get_or_insert(row[0]);
            self.is_blank = row.iter().all(|&color| color == first);
        }
        match &mut self.layers[layer] {
            Product::File(writer) => writer.row(row)?,
            Product::Kept { picture, rows } => {
                picture.set([0, *rows], row);
                *rows += 1;
            }
            // Costs have no rows.
            Product::Costs { .. } => {}
        }
        self.encoding += start.elapsed();
        Ok(())
    }

    /// Counts the colours so far that the files do not show as they are.
    pub fn exceptional(&self) -> Exceptional {
        let mut all = Exceptional::default();
        for product in &self.layers {
            if let Product::File(writer) = product {
                all += writer.exceptional;
            }
        }
        all
    }

    /// Writes the rows of a render that was cancelled after this number of them. Returns the file of each layer's part.
    pub fn keep_parts(self, rows: usize) -> Result<Vec<Option<PathBuf>>, Diagnostic> {
        let Self { prepared, request, layers, .. } = self;
        let upper = Window { height: rows, ..window(request) };
        let keep =
            |(product, &layer): (Product, &Layer)| match (product, part(prepared, request, upper, layer)) {
                (Product::File(writer), Some(part)) => Ok(writer.write_part(&part)?),
                // The picture of a filter is drawn before the first row is rendered. A pipe may have no reader.
                (Product::File(writer), None)
                    if matches!(layer, Layer::Filter { .. }) && writer.has_all_rows() =>
                {
                    let file = writer.complete()?;
                    if !file.is_stream() {
                        file.put_in_place()?;
                    }
                    Ok(None)
                }
                _ => Ok(None),
            };
        layers.into_iter().zip(&request.layers).map(keep).collect()
    }

    /// Completes the files. `counts` are the costs of the pixels, if they are a layer.
    pub fn finish(self, mut counts: Vec<u64>) -> Result<Finished, Diagnostic> {
        let mut finished = Finished::default();
        for product in self.layers {
            match product {
                Product::File(writer) => finished.files.push(writer.complete()?),
                Product::Kept { picture: Pixels::Numbers(picture), .. } => {
                    finished.picture = Some(Pixels::Numbers(picture.in_single_precision()));
                }
                Product::Kept { picture, .. } => finished.picture = Some(picture),
                Product::Costs { file, format, cost } => {
                    let counts = std::mem::take(&mut counts);
                    let map = CostMap::new(cost, counts, self.prepared, self.request);
                    finished.files.push(file.picture(format, &map.draw()?)?);
                    finished.costs = Some(map);
                }
            }
        }
        Ok(finished)
    }
}

/// Returns false for a layer that shows samples, costs or the filter.
fn shows_scene(layer: &Layer) -> bool {
    !matches!(layer, Layer::Samples { .. } | Layer::Cost(_) | Layer::Filter { .. })
}
