//! What a part of a picture says about the whole, so that parts of different pictures are told apart.

use raytracer::image_io::Part;
use raytracer::render::renderer::Prepared;
use raytracer::render::{Layer, Request, Window};
use siphasher::sip128::{Hasher128, SipHasher13};
use std::hash::Hasher;

/// Returns the part in this window of a layer's picture. `None` if the layer has no parts, because it shows the
/// filter, is reduced or scaled by the most expensive pixel.
pub fn part(prepared: &Prepared, request: &Request, window: Window, layer: Layer) -> Option<Part> {
    let is_reduced = layer == Layer::Color && request.is_reduced;
    if is_reduced || matches!(layer, Layer::Filter { .. } | Layer::Cost(_)) {
        return None;
    }
    let pixels = |pair: [usize; 2]| layer.size(pair).map(|n| u32::try_from(n).unwrap_or(u32::MAX));
    let fingerprint = fingerprint(prepared, request, layer);
    Some(Part { whole: pixels(request.size), at: pixels([window.x, window.y]), fingerprint })
}

/// Returns a hash of all that the bytes of a layer's whole picture depend on: the version of the program, the text of
/// the scene and what it means, its meshes and pictures, and those of the flags that change the layer.
///
/// It is SipHash-1-3 with 128 bits and a key of zeros, which is the same on every machine and in every version of its
/// crate. It tells apart what was mixed up by mistake, not by malice.
fn fingerprint(prepared: &Prepared, request: &Request, layer: Layer) -> u128 {
    let (scene, world) = (&prepared.renderer().scene, prepared.renderer().world());
    let Request { size, effects, sampler, adaptive, filter, .. } = request;
    let sampling = matches!(layer, Layer::Color | Layer::Samples { .. }).then_some((sampler, adaptive));
    let shading = sampling.map(|_| (effects, filter, prepared.drawn_cells()));
    // These values have no maps and no errors of their own, so that they can always be written.
    let flags = serde_json::to_vec(&(size, layer, sampling, shading)).unwrap_or_default();
    let mut hasher = SipHasher13::new();
    // Bytes with their number, so that no two lists of blocks are the same bytes.
    let mut write = |bytes: &[u8]| {
        hasher.write(&(bytes.len() as u64).to_le_bytes());
        hasher.write(bytes);
    };
    write(env!("CARGO_PKG_VERSION").as_bytes());
    write(prepared.renderer().source.text.as_bytes());
    write(&flags);
    write(format!("{:?}", scene.model).as_bytes());
    scene.images.iter().for_each(|image| write(&image.texels.rgb));
    world.vertices.iter().for_each(|vertex| write(vertex.to_array().map(f64::to_le_bytes).as_flattened()));
    world.triangles.iter().for_each(|corners| write(corners.map(u32::to_le_bytes).as_flattened()));
    for mesh in &scene.meshes {
        write(&mesh.vertices.to_le_bytes());
        let corners = mesh.texture_coordinates.iter().flatten().flatten();
        corners.for_each(|corner| write(corner.to_array().map(f64::to_le_bytes).as_flattened()));
    }
    hasher.finish128().as_u128()
}
