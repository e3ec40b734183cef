//! The rays behind a pixel as lines in space, each tied to its lines in the text of `-pixel`.

use crate::caster::dda::Dda;
use crate::caster::lattice::Lattice;
use crate::math::aabb::Aabb;
use crate::math::ray::Ray;
use crate::tools::explain::{PixelTree, RayNode};
use crate::trace::Secondary;
use glam::DVec3;
use serde::Serialize;
use std::collections::HashMap;

/// Lines and cells beyond this number are not drawn.
const MAX_DRAWN: usize = 4000;
/// The text is cut after this number of lines.
const MAX_TEXT: usize = 5000;

/// A line in space.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Segment {
    /// A ray from the `camera`, a `reflected` or `refracted` one, one that reaches a `light`, one whose light something
    /// blocks (`shadow`), or a `normal`.
    pub kind: &'static str,
    pub from: DVec3,
    pub to: DVec3,
}

/// The rays behind a pixel.
#[derive(Debug, Serialize)]
pub struct Rays {
    /// The text of `-pixel`, line by line.
    pub text: Vec<String>,
    /// For each line of the text, the index of its line in space.
    pub segments_of_lines: Vec<Option<usize>>,
    pub segments: Vec<Segment>,
    /// The cells that the rays pass through, each by its lower corner.
    pub cells: Vec<DVec3>,
    /// The size of a cell.
    pub cell_size: DVec3,
}

impl Rays {
    /// The rays of a pixel in a scene with these bounds, and the cells that they pass if there is a grid.
    pub fn of(tree: &PixelTree, bounds: Option<Aabb>, cells: Option<[usize; 3]>) -> Self {
        let far = bounds.map_or(10.0, |bounds| bounds.extent().length().max(f64::MIN_POSITIVE));
        let mut segments = vec![];
        // For the rays of the first sample and their lights, the indices of their lines in space.
        let mut drawn = HashMap::new();
        for (number, sample) in tree.samples.iter().enumerate() {
            for (place, node) in sample.rays.iter().enumerate() {
                for (light, segment) in lines_of(node, far) {
                    if number == 0 && segment.kind != "normal" {
                        drawn.insert((place, light), segments.len());
                    }
                    segments.push(segment);
                }
            }
        }
        let lines = tree.lines().into_iter().take(MAX_TEXT);
        let (text, segments_of_lines) = lines
            .map(|line| {
                let drawn = |(ray, light)| drawn.get(&(ray, light)).or_else(|| drawn.get(&(ray, None)));
                (line.text, line.about.and_then(drawn).copied())
            })
            .unzip();
        let lattice = bounds.zip(cells).map(|(bounds, cells)| Lattice::new(bounds, cells));
        let cells = lattice.as_ref().map(|lattice| cells_passed(lattice, tree)).unwrap_or_default();
        let cell_size = lattice.map_or(DVec3::ZERO, |lattice| lattice.cell_size);
        segments.truncate(MAX_DRAWN);
        Self { text, segments_of_lines, segments, cells, cell_size }
    }
}

/// Returns the line of a ray, a line towards each light to which a ray is cast from its end, with the light's index,
/// and the normal there. A ray that hits nothing has the length `far`.
fn lines_of(node: &RayNode, far: f64) -> Vec<(Option<usize>, Segment)> {
    // An orthographic camera's ray may start behind its plane.
    let line = |kind: &'static str, ray: &Ray, t: Option<f64>| {
        let far = far / ray.direction.length().max(f64::MIN_POSITIVE);
        let t = t.unwrap_or(far);
        let start = if t < 0.0 { t - far } else { 0.0 };
        Segment { kind, from: ray.at(start), to: ray.at(t) }
    };
    let kind = node.kind.map_or("camera", Secondary::name);
    let mut lines = vec![(None, line(kind, &node.ray, node.surface.as_ref().map(|surface| surface.t)))];
    let Some(surface) = &node.surface else { return lines };
    let from = surface.point.position;
    for (index, light) in surface.lights.iter().enumerate() {
        let distance = Some(light.incident.distance).filter(|distance| distance.is_finite());
        let to_light = light.shadow.as_ref().map(|shadow| match &shadow.blocker {
            Some(blocker) => line("shadow", &shadow.ray, Some(blocker.t)),
            None => line("light", &Ray::new(from, light.incident.direction), distance),
        });
        lines.extend(to_light.map(|segment| (Some(index), segment)));
    }
    let to = from + 0.06 * far * surface.point.normal;
    lines.push((None, Segment { kind: "normal", from, to }));
    lines
}

/// The cells of a grid that the rays of a pixel pass, without those to the lights.
fn cells_passed(lattice: &Lattice, tree: &PixelTree) -> Vec<DVec3> {
    let most = lattice.cells().map(|count| count as f64);
    let mut indices = vec![];
    for node in tree.samples.iter().flat_map(|sample| &sample.rays) {
        let Some((mut dda, _)) = Dda::of_ray(lattice, &node.ray) else { continue };
        let end = node.surface.as_ref().map_or(i32::MAX, |surface| dda.fixed_t(surface.t));
        while indices.len() < MAX_DRAWN {
            let cell = lattice.cell_of(dda.index());
            if cell.min_element() < 0.0 || cell.cmpge(DVec3::from_array(most)).any() {
                break;
            }
            indices.push(dda.index());
            if dda.exit() > end {
                break;
            }
            dda.step();
        }
    }
    indices.sort_unstable();
    indices.dedup();
    let corner = |index| lattice.bounds.min + lattice.cell_of(index) * lattice.cell_size;
    indices.into_iter().map(corner).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::caster::choose::{Resolution, Structure};
    use crate::render::test_renderer::renderer_of;
    use crate::render::{Request, Stop, Tracing};
    use crate::tools::explain::Explainer;
    use crate::trace::{Effects, Shadows};
    use std::time::{Duration, Instant};

    const GLASS: &str = "PerspectiveCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 angle 30 }
        Lights { numLights 2 PointLight { position 0 3 3 color 1 1 1 } DirectionalLight { direction 0 0 1 color 1 1 1 } }
        Group { numObjects 2 Material { diffuseColor 1 1 1 reflectiveColor .3 .3 .3 transparentColor .7 .7 .7
        indexOfRefraction 1.5 } Sphere { center 0 0 0 radius 1 } Triangle { vertex0 -3 -1 -3 vertex1 3 -1 -3
        vertex2 0 -1 3 } }";

    fn rays(structure: Structure) -> (PixelTree, Rays) {
        let renderer = renderer_of(GLASS);
        let effects = Effects { shadows: Shadows::Opaque, bounces: 3, shade_back: true, min_weight: 0.0 };
        let request = Request { effects, structure, tracing: Tracing::Counted, ..Request::new([9, 9]) };
        let prepared = renderer.prepare(&request).unwrap();
        let stop = Stop::at(Instant::now() + Duration::from_secs(60));
        let tree = Explainer::new(&prepared).unwrap().pixel(&request, [5, 4], &stop).unwrap();
        let rays = Rays::of(&tree, renderer.bounds(), prepared.cells());
        (tree, rays)
    }

    #[test]
    fn every_ray_of_the_tree_is_drawn_and_told_of() {
        let (tree, rays) = rays(Structure::List);
        let nodes = || tree.samples.iter().flat_map(|sample| &sample.rays);
        let lights = nodes().flat_map(|node| &node.surface).flat_map(|surface| &surface.lights);
        let drawn = |kinds: &[&str]| rays.segments.iter().filter(|line| kinds.contains(&line.kind)).count();
        assert!(nodes().count() > 4);
        assert_eq!(drawn(&["camera", "reflected", "refracted"]), nodes().count());
        assert_eq!(drawn(&["light", "shadow"]), lights.filter(|light| light.shadow.is_some()).count());
        for (index, line) in rays.segments.iter().enumerate().filter(|(_, line)| line.kind != "normal") {
            let first = rays
                .segments_of_lines
                .iter()
                .position(|&told| told == Some(index))
                .expect("a line of the text");
            let word = if line.kind == "shadow" { "light" } else { line.kind };
            assert!(rays.text[first].trim_start().starts_with(word), "{}", rays.text[first]);
            if line.kind == "shadow" {
                // The line between has the direction to the light.
                assert!(rays.text[first + 2].contains("shadow ray blocked"), "{}", rays.text[first + 2]);
            }
        }
    }

    #[test]
    fn a_ray_ends_where_the_next_one_starts() {
        let (_, rays) = rays(Structure::List);
        let (camera, second) =
            (&rays.segments[0], rays.segments.iter().find(|line| line.kind == "refracted"));
        assert_eq!(camera.from, DVec3::new(0.0, 0.0, 5.0));
        assert!((second.unwrap().from - camera.to).length() < 1e-12);
    }

    #[test]
    fn the_cells_passed_contain_the_rays() {
        let (tree, rays) = rays(Structure::Grid(Resolution::Cells([6, 4, 5])));
        assert!(rays.cells.len() > 6 && rays.cells.len() < 6 * 4 * 5);
        for node in tree.samples.iter().flat_map(|sample| &sample.rays) {
            let Some(surface) = &node.surface else { continue };
            let is_in = |&low: &DVec3| {
                let slack = DVec3::splat(1e-9);
                let (point, high) = (surface.point.position, low + rays.cell_size);
                point.cmpge(low - slack).all() && point.cmple(high + slack).all()
            };
            assert!(rays.cells.iter().any(is_in), "{}", surface.point.position);
        }
        assert!(Rays::of(&tree, None, None).cells.is_empty());
    }
}
