//! A picture from elsewhere that the view is compared with.

use super::painter::Subject;
use crate::image_io::read_picture_from;
use crate::picture::Picture;
use crate::render::{Layer, Request};
use crate::tools::causes::Original;
use crate::tools::compare::{Comparison, DifferencePicture};
use std::path::Path;

/// The most camera rays of a picture for which a cause is looked for: the search renders it some fifty times.
const MAX_CAUSE_RAYS: usize = 1 << 22;

/// The picture in the bytes of a file with this name; an error is a line.
pub fn decode(name: &str, bytes: &[u8]) -> Result<Picture, String> {
    read_picture_from(Path::new(name), bytes).map_err(|error| error.to_string())
}

/// The block of the comparison, and the pixels of the amplified difference.
pub fn compare(reference: &Picture, own: &Picture) -> Result<(String, u8, Picture), String> {
    let comparison = Comparison::new(reference, own).map_err(|error| error.to_string())?;
    let shown = DifferencePicture::new(reference, own).map_err(|error| error.to_string())?;
    Ok((comparison.to_string(), shown.amplification, last_panel(&shown.picture, reference.width())))
}

/// The last of the panels that stand side by side.
fn last_panel(panels: &Picture, width: u32) -> Picture {
    let [all, width_bytes] = [panels.width(), width].map(|side| 3 * side as usize);
    let rows = panels.pixels().chunks_exact(all).flat_map(|row| row[all - width_bytes..].iter().copied());
    Picture::from_rgb(width, panels.height(), rows.collect())
}

/// What makes the difference, in the words of the command line; none where nothing can be tried.
pub fn cause(reference: &Picture, own: &Picture, subject: &Subject) -> Option<String> {
    let request = Request { layers: vec![Layer::Color], camera: subject.camera, ..subject.options.request() };
    let can_try = !subject.options.visualize_grid
        && subject.options.adaptive.is_none()
        && request.camera_rays() <= MAX_CAUSE_RAYS
        && reference.pixels() != own.pixels();
    let renderer = &subject.scene.renderer;
    let find = || {
        let original = Original::new(renderer, subject.options.structure, &request)?;
        Some(original.explain(reference, own).to_string())
    };
    can_try.then(|| renderer.on_own_threads(find))?
}
