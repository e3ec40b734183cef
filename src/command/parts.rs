//! Parts of pictures: what a part says about the whole, and the lines about the parts that a stopped run keeps.

use crate::base::escape::escape;
use crate::base::shell::Shell;
use crate::cli::{Options, command_of_merge, command_of_rest};
use crate::image_io::Part;
use crate::render::renderer::Prepared;
use crate::render::{Layer, Request, Window};
use crate::sampling::sampler::Sampler;
use siphasher::sip128::{Hasher128, SipHasher13};
use std::ffi::{OsStr, OsString};
use std::hash::Hasher;
use std::path::{Path, PathBuf};

/// Returns true if a layer has parts. It has none if it shows the filter, is scaled by the most expensive pixel, or its
/// pixels are reduced or displaced.
pub fn has_parts(request: &Request, layer: Layer) -> bool {
    let is_whole = request.is_reduced || request.sampler == Sampler::DISPLACED;
    !is_whole && !matches!(layer, Layer::Filter { .. } | Layer::Cost(_))
}

/// Returns what the part in this window says about the whole picture of a layer. `None` if the layer has no parts.
pub fn part(prepared: &Prepared, request: &Request, window: Window, layer: Layer) -> Option<Part> {
    if !has_parts(request, layer) {
        return None;
    }
    let (whole, at) = (layer.size(request.size), layer.size([window.x, window.y]));
    Some(Part { whole, at, fingerprint: fingerprint(prepared, request, layer) })
}

/// Raised if the same command line draws other bytes than before, within one version of the program.
const PICTURES: &[u8] = b"4";

/// Returns a hash of everything that the bytes of a layer's whole picture depend on: the version of the program, the
/// text and the model of the scene, its meshes and pictures, and the flags that change the layer.
///
/// It is SipHash-1-3 with 128 bits and a key of zeros, which is the same on every machine and in every version of its
/// crate. It finds parts that are mixed up by mistake, not forged ones.
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
    write(PICTURES);
    write(prepared.renderer().source.text.as_bytes());
    write(&flags);
    let rules = (scene.screen, scene.lighting, scene.mesh_normals, scene.measure_colors, scene.shows);
    write(format!("{rules:?}").as_bytes());
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

/// Returns the window of a request, which may be the whole picture.
pub fn window(request: &Request) -> Window {
    request.window.unwrap_or(Window::whole(request.size))
}

/// Returns the lines after a stop at this row: the part that was kept of each picture, and the commands for the rest.
pub fn lines(argv: &[OsString], options: &Options, rows: usize, kept: &[Option<PathBuf>]) -> Vec<String> {
    let all = window(&options.request());
    let stopped = format!("stopped at row {rows} of {}", all.height);
    let (mut written, mut lost, mut merges) = (vec![], String::new(), vec![]);
    let program = argv.first().map_or(OsStr::new("raytracer"), OsString::as_os_str);
    for (output, part) in options.outputs.iter().zip(kept) {
        if let Some(part) = part {
            written.push(shown(part));
            let region = options.region.map(|region| enlarged(region, output.layer));
            let merge = command_of_merge(program, [part, &output.file], region, Shell::OF_SYSTEM);
            merges.push(format!("then: {merge}"));
        } else if !matches!(output.layer, Layer::Filter { .. }) {
            // The picture of a filter is complete, and was written.
            lost += &format!(", nothing of {}", shown(&output.file));
        }
    }
    if written.is_empty() {
        return vec![format!("{stopped}; wrote nothing")];
    }
    let rest = Window { y: all.y + rows, height: all.height - rows, ..all };
    let rest = command_of_rest(argv, rest, Shell::OF_SYSTEM);
    let first = format!("{stopped}; wrote {}{lost}; the rest: {rest}", written.join(", "));
    [vec![first], merges].concat()
}

/// Scales a window of the colour picture to a layer's picture.
fn enlarged(Window { x, y, width, height }: Window, layer: Layer) -> Window {
    let ([x, y], [width, height]) = (layer.size([x, y]), layer.size([width, height]));
    Window { x, y, width, height }
}

fn shown(path: &Path) -> String {
    escape(&path.to_string_lossy())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::{Command, parse};

    fn lines_of(line: &str, rows: usize, kept: &[Option<&str>]) -> Vec<String> {
        let argv: Vec<OsString> = line.split(' ').map(OsString::from).collect();
        let Ok(Command::Render(options)) = parse(argv.iter().cloned()) else { panic!("{line}") };
        let kept: Vec<_> = kept.iter().map(|part| part.map(PathBuf::from)).collect();
        lines(&argv, &options, rows, &kept)
    }

    #[test]
    fn what_has_no_parts_is_told() {
        let line = "rt -input s.txt -output o.tga -render_filter f.tga 2 -cost_map rays c.tga";
        assert_eq!(
            lines_of(line, 5, &[Some("o.partial.tga"), None, None])[0],
            "stopped at row 5 of 100; wrote o.partial.tga, nothing of c.tga; the rest: rt -input s.txt \
             -output o.rest.tga -region 0 5 100 95"
        );
    }
}
