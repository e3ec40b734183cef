//! What a part of a picture says about the whole, so that parts of different pictures are told apart.

use raytracer::image_io::Part;
use raytracer::render::{Layer, Request, Window};
use raytracer::renderer::{Prepared, Renderer};
use raytracer::world::World;
use siphasher::sip128::{Hasher128, SipHasher13};
use std::hash::Hasher;

/// The part in this window of a layer's picture; none if the layer has no parts, because it shows the filter, is reduced
/// or scaled by the most expensive pixel.
pub fn part(prepared: &Prepared, request: &Request, window: Window, layer: Layer) -> Option<Part> {
    let (kind, zoom) = match layer {
        // A reduced picture is not put together.
        Layer::Color if request.is_reduced => return None,
        Layer::Color => ("color", 1),
        Layer::Depth { .. } => ("depth", 1),
        Layer::Distance => ("distance", 1),
        Layer::Normals => ("normals", 1),
        Layer::SignedNormals => ("signed_normals", 1),
        Layer::Samples { zoom } => ("samples", zoom),
        Layer::Filter { .. } | Layer::Cost(_) => return None,
    };
    let pixels = |pair: [usize; 2]| pair.map(|n| u32::try_from(n * zoom).unwrap_or(u32::MAX));
    let fingerprint = fingerprint(prepared, request, layer);
    Some(Part {
        whole: pixels(request.size),
        at: pixels([window.x, window.y]),
        kind: kind.into(),
        fingerprint,
    })
}

/// A hash of all that the bytes of a layer's whole picture depend on: the version of the program, the text of the
/// scene, its meshes in world space, and those of the flags that change the layer.
///
/// It is SipHash-1-3 with 128 bits and a key of zeros, which is the same on every machine and in every version of its
/// crate. It tells apart what was mixed up by mistake, not by malice.
fn fingerprint(prepared: &Prepared, request: &Request, layer: Layer) -> u128 {
    let renderer = prepared.renderer();
    let mut hasher = SipHasher13::new();
    write_block(&mut hasher, env!("CARGO_PKG_VERSION").as_bytes());
    write_block(&mut hasher, renderer.source.text.as_bytes());
    write_triangles(&mut hasher, renderer.world());
    write_model(&mut hasher, renderer);
    let Request { size, effects, sampler, adaptive, filter, .. } = request;
    let sampling = matches!(layer, Layer::Color | Layer::Samples { .. }).then_some((sampler, adaptive));
    let shading = sampling.map(|_| (effects, filter, prepared.drawn_cells()));
    let flags = serde_json::to_vec(&(size, layer, sampling, shading));
    // These values have no maps and no errors of their own, so that they can always be written.
    write_block(&mut hasher, &flags.unwrap_or_default());
    hasher.finish128().as_u128()
}

/// Bytes with their number, so that no two lists of blocks are the same bytes.
fn write_block(hasher: &mut SipHasher13, bytes: &[u8]) {
    hasher.write_u64(bytes.len() as u64);
    hasher.write(bytes);
}

/// What the scene means, if that is not what it does in 2004, and the pictures that it names.
fn write_model(hasher: &mut SipHasher13, renderer: &Renderer) {
    if renderer.world().is_of_course() {
        return;
    }
    write_block(hasher, format!("{:?}", renderer.scene.model).as_bytes());
    renderer.scene.images.iter().for_each(|image| write_block(hasher, &image.texels.rgb));
    renderer.scene.meshes.iter().for_each(|mesh| hasher.write_u64(mesh.vertices as u64));
    let coordinates = renderer.scene.meshes.iter().flat_map(|mesh| mesh.texture_coordinates.iter());
    for coordinate in coordinates.flatten().flatten().flat_map(|corner| corner.to_array()) {
        hasher.write(&coordinate.to_le_bytes());
    }
}

/// All triangles, most of which come from meshes. The text of the scene has all else.
fn write_triangles(hasher: &mut SipHasher13, world: &World) {
    hasher.write_u64(world.vertices.len() as u64);
    for vertex in &world.vertices {
        vertex.to_array().iter().for_each(|coordinate| hasher.write(&coordinate.to_le_bytes()));
    }
    for triangle in &world.triangles {
        triangle.iter().for_each(|index| hasher.write(&index.to_le_bytes()));
    }
}
