//! The lines that a stopped run prints: what it kept, and how to make the rest.

use super::products::KeptPart;
use raytracer::base::escape::escape;
use raytracer::base::shell::Shell;
use raytracer::cli::{Options, Output, command_of_merge, command_of_rest};
use raytracer::render::{Layer, Request, Window};
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// The part of a request that these rows from its top are.
pub fn upper(request: &Request, rows: usize) -> Window {
    Window { height: rows, ..whole(request.size, request.window) }
}

/// The rendered part of a picture.
fn whole([width, height]: [usize; 2], region: Option<Window>) -> Window {
    region.unwrap_or(Window { x: 0, y: 0, width, height })
}

/// The lines after so many rows. `kept` has what was kept of each picture.
pub fn lines(argv: &[OsString], options: &Options, rows: usize, kept: &[KeptPart]) -> Vec<String> {
    let all = whole(options.request().size, options.region);
    let stopped = format!("stopped at row {rows} of {}", all.height);
    let pairs = || options.outputs.iter().zip(kept);
    let parts: Vec<(&Output, &PathBuf)> =
        pairs().filter_map(|(output, part)| Some((output, part.as_ref()?))).collect();
    if parts.is_empty() {
        return vec![format!("{stopped}; wrote nothing")];
    }
    let written: Vec<String> = parts.iter().map(|(_, part)| shown(part)).collect();
    // The picture of a filter is complete, and was written.
    let is_lost = |(output, part): &(&Output, &KeptPart)| {
        part.is_none() && !matches!(output.layer, Layer::Filter { .. })
    };
    let lost = pairs().filter(is_lost).map(|(output, _)| format!(", nothing of {}", shown(&output.file)));
    let lost: String = lost.collect();
    let rest = Window { y: all.y + rows, height: all.height - rows, ..all };
    let rest = command_of_rest(argv, rest, Shell::OF_SYSTEM);
    let program = argv.first().map_or(OsStr::new("raytracer"), OsString::as_os_str);
    let merge = |(output, part): &(&Output, &PathBuf)| {
        let region = options.region.map(|region| enlarged(region, output.layer));
        format!("then: {}", command_of_merge(program, [part, &output.file], region, Shell::OF_SYSTEM))
    };
    let first = format!("{stopped}; wrote {}{lost}; the rest: {rest}", written.join(", "));
    std::iter::once(first).chain(parts.iter().map(merge)).collect()
}

/// The part of a layer's picture that shows this part of the scene's.
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
    use raytracer::cli::{Command, parse};

    fn lines_of(line: &str, rows: usize, kept: &[Option<&str>]) -> Vec<String> {
        let argv: Vec<OsString> = line.split(' ').map(OsString::from).collect();
        let Ok(Command::Render(options)) = parse(argv.iter().cloned()) else { panic!("{line}") };
        let kept: Vec<KeptPart> = kept.iter().map(|part| part.map(PathBuf::from)).collect();
        lines(&argv, &options, rows, &kept)
    }

    #[test]
    fn the_lines_tell_what_is_there_and_how_the_rest_is_made() {
        assert_eq!(
            lines_of(
                "raytracer -input s.txt -size 4000 4000 -output long.tga -shadows",
                1480,
                &[Some("long.partial.tga")]
            ),
            [
                "stopped at row 1480 of 4000; wrote long.partial.tga; the rest: raytracer -input s.txt -size 4000 4000 \
                 -output long.rest.tga -shadows -region 0 1480 4000 2520",
                "then: raytracer -merge long.partial.tga long.rest.tga -output long.tga",
            ]
        );
        assert_eq!(
            lines_of("rt -input s.txt -output o.tga", 0, &[None]),
            ["stopped at row 0 of 100; wrote nothing"]
        );
        assert_eq!(lines_of("rt -input s.txt -stats", 7, &[]), ["stopped at row 7 of 100; wrote nothing"]);
    }

    #[test]
    fn the_rest_of_a_region_is_a_region() {
        let line = "rt -input s.txt -region 10 20 30 40 -output o.tga -normals n.png";
        assert_eq!(
            lines_of(line, 5, &[Some("o.partial.tga"), Some("n.partial.png")]),
            [
                "stopped at row 5 of 40; wrote o.partial.tga, n.partial.png; the rest: rt -input s.txt \
                 -output o.rest.tga -normals n.rest.png -region 10 25 30 35",
                "then: rt -merge o.partial.tga o.rest.tga -output o.tga -region 10 20 30 40",
                "then: rt -merge n.partial.png n.rest.png -output n.png -region 10 20 30 40",
            ]
        );
    }

    #[test]
    fn the_region_of_an_enlarged_picture_is_enlarged() {
        let line = "rt -input s.txt -region 10 20 30 40 -output o.tga -render_samples s.png 3";
        assert_eq!(
            lines_of(line, 5, &[Some("o.partial.tga"), Some("s.partial.png")])[1..],
            [
                "then: rt -merge o.partial.tga o.rest.tga -output o.tga -region 10 20 30 40",
                "then: rt -merge s.partial.png s.rest.png -output s.png -region 30 60 90 120",
            ]
        );
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
