//! Renders views, for the page and for files.

use super::http::Response;
use super::prepared::{PreparedScenes, Ready};
use super::view::View;
use crate::cli::Output;
use crate::image_io::{CompleteFile, OutputFile};
use crate::picture::{Color, Picture, Pixels};
use crate::render::{Layer, Progress, Stop, TakeRow};
use crate::tools::explain::CostMap;
use std::sync::Arc;

/// A picture that is finished.
pub struct Painted {
    pub picture: Picture,
    /// The costs of its pixels, if they are shown.
    pub costs: Option<CostMap>,
    /// The number of colours that are not numbers.
    pub nans: u64,
}

/// Paints a view, unless it is stopped.
pub fn paint(scenes: &PreparedScenes, view: &View, stop: &Stop) -> Result<Painted, Response> {
    let layer = view.cost.map_or(Layer::Color, Layer::Cost);
    let request = view.request(layer);
    let mut picture = Pixels::zeros(request.layer_size(&layer), false)?;
    let (mut rows, mut nans) = (0, 0);
    let mut take_row = |_: usize, row: &[Color]| {
        nans += picture.set([0, rows], row);
        rows += 1;
        Ok(())
    };
    let (ready, counts) = render(scenes, view, layer, stop, &mut take_row)?;
    let costs = view.cost.map(|cost| CostMap::new(cost, counts, ready.borrow_dependent(), &request));
    let picture = match &costs {
        Some(map) => map.draw()?,
        None => picture.into_bytes(),
    };
    Ok(Painted { picture, costs, nans })
}

/// Returns a complete file with one of the pictures that the command line names, of this view.
pub fn complete(
    scenes: &PreparedScenes,
    view: &View,
    output: &Output,
    stop: &Stop,
) -> Result<CompleteFile, Response> {
    let (file, layer) = (OutputFile::prepare(&output.file)?, output.layer);
    if let Layer::Cost(cost) = layer {
        let painted = paint(scenes, &View { cost: Some(cost), ..view.clone() }, stop)?;
        return Ok(file.picture(output.format, &painted.picture)?);
    }
    let size = view.request(layer).layer_size(&layer);
    let mut writer = file.begin(output.format, size, layer.content(), None)?;
    render(scenes, view, layer, stop, &mut |_, row| writer.row(row))?;
    Ok(writer.complete()?)
}

/// Renders a layer. Returns the prepared scene and the costs of the pixels, if they are the layer.
fn render(
    scenes: &PreparedScenes,
    view: &View,
    layer: Layer,
    stop: &Stop,
    take_row: TakeRow,
) -> Result<(Arc<Ready>, Vec<u64>), Response> {
    let request = view.request(layer);
    let ready = scenes.get(view, request.tracing, view.options.visualize_grid, stop)?;
    let watch = |progress: Progress| stop.watch(progress);
    let rendered = ready.borrow_dependent().render_rows(&request, &watch, take_row)?;
    Ok((ready, rendered.costs))
}
