//! The rays behind a pixel as lines in space, each tied to its lines in the text of `-pixel`.

use crate::caster::dda::Dda;
use crate::caster::lattice::Lattice;
use crate::math::aabb::Aabb;
use crate::math::ray::Ray;
use crate::tools::explain::{PixelTree, RayNode};
use crate::trace::Secondary;
use glam::DVec3;
use serde::Serialize;

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
    pub tells: Vec<Option<usize>>,
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
        let mut drawing = Drawing { far, segments: vec![], owners: vec![] };
        for sample in &tree.samples {
            let mut waiting: Vec<usize> = (0..sample.rays.len().min(1)).collect();
            while let Some(node) = waiting.pop().map(|place| &sample.rays[place]) {
                drawing.add(node);
                waiting.extend(node.children.iter().rev());
            }
        }
        let text: Vec<String> = tree.to_string().lines().take(MAX_TEXT).map(str::to_owned).collect();
        let tells = tells(&text, &drawing.owners);
        let lattice = bounds.zip(cells).map(|(bounds, cells)| Lattice::new(bounds, cells));
        let passed = lattice.as_ref().map(|lattice| cells_passed(lattice, tree)).unwrap_or_default();
        let cell_size = lattice.map_or(DVec3::ZERO, |lattice| lattice.cell_size);
        drawing.segments.truncate(MAX_DRAWN);
        Self { text, tells, segments: drawing.segments, cells: passed, cell_size }
    }
}

/// Lines in space under construction, in the order of the text.
struct Drawing {
    /// The length of a ray that hits nothing.
    far: f64,
    segments: Vec<Segment>,
    /// For each ray of the text, the index of its line, and the indices of its lights' lines.
    owners: Vec<(usize, Vec<Option<usize>>)>,
}

impl Drawing {
    /// Draws a ray, the normal where it ends, and a line towards each light to which a ray is cast from there.
    fn add(&mut self, node: &RayNode) {
        let kind = match node.kind {
            None => "camera",
            Some(Secondary::Reflected) => "reflected",
            Some(Secondary::Refracted) => "refracted",
        };
        let own = self.ray(kind, &node.ray, node.surface.as_ref().map(|surface| surface.t));
        let mut lights = vec![];
        if let Some(surface) = &node.surface {
            let from = surface.point.position;
            for light in &surface.lights {
                let distance = light.incident.distance;
                lights.push(light.shadow.as_ref().map(|shadow| match &shadow.blocker {
                    Some(blocker) => self.ray("shadow", &shadow.ray, Some(blocker.t)),
                    None => {
                        let ray = Ray::new(from, light.incident.direction);
                        self.ray("light", &ray, distance.is_finite().then_some(distance))
                    }
                }));
            }
            let to = from + 0.06 * self.far * surface.point.normal;
            self.segments.push(Segment { kind: "normal", from, to });
        }
        self.owners.push((own, lights));
    }

    /// Draws a ray up to `t`, and returns its index. An orthographic camera's may start behind its plane.
    fn ray(&mut self, kind: &'static str, ray: &Ray, t: Option<f64>) -> usize {
        let far = self.far / ray.direction.length().max(f64::MIN_POSITIVE);
        let t = t.unwrap_or(far);
        let start = if t < 0.0 { t - far } else { 0.0 };
        self.segments.push(Segment { kind, from: ray.at(start), to: ray.at(t) });
        self.segments.len() - 1
    }
}

/// Returns for each line of the text the index of its line in space. The text has the rays and lights in the order in
/// which they were drawn.
fn tells(text: &[String], owners: &[(usize, Vec<Option<usize>>)]) -> Vec<Option<usize>> {
    let (mut rays, mut lights) = (owners.iter(), [].iter());
    let (mut ray, mut current) = (None, None);
    let mut tell = |line: &String| {
        let words = line.trim_start();
        let starts_with = |starts: &[&str]| starts.iter().any(|start| words.starts_with(start));
        if starts_with(&["camera ray", "reflected ray,", "refracted ray,"])
            && let Some((own, its_lights)) = rays.next()
        {
            (ray, current, lights) = (Some(*own), Some(*own), its_lights.iter());
        } else if starts_with(&["light "]) {
            current = lights.next().copied().flatten().or(ray);
        } else if starts_with(&["own colour"]) {
            current = ray;
        } else if starts_with(&["the sample's colour", "sample "]) {
            (ray, current) = (None, None);
        }
        current
    };
    text.iter().map(&mut tell).collect()
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
    use crate::diagnostic::Diagnostic;
    use crate::render::Request;
    use crate::render::Tracing;
    use crate::render::renderer::{Meshes, Renderer};
    use crate::scene::MeshFile;
    use crate::scene::load::{Hints, Readers, Source, load_text};
    use crate::scene::texels::ImageFile;
    use crate::tools::explain::{Explainer, Stop};
    use crate::trace::{Effects, Shadows};
    use std::time::{Duration, Instant};

    const GLASS: &str = "PerspectiveCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 angle 30 }
        Lights { numLights 2 PointLight { position 0 3 3 color 1 1 1 } DirectionalLight { direction 0 0 1 color 1 1 1 } }
        Group { numObjects 2 Material { diffuseColor 1 1 1 reflectiveColor .3 .3 .3 transparentColor .7 .7 .7
        indexOfRefraction 1.5 } Sphere { center 0 0 0 radius 1 } Triangle { vertex0 -3 -1 -3 vertex1 3 -1 -3
        vertex2 0 -1 3 } }";

    fn rays(structure: Structure) -> (PixelTree, Rays) {
        let source = Source { path: "s.txt".into(), text: GLASS.into() };
        let no_mesh = |_: &MeshFile, _, _| Err(Diagnostic::error("no mesh"));
        let no_image = |_: &ImageFile, _| Err(Diagnostic::error("no picture"));
        let readers = Readers { mesh: &no_mesh, image: &no_image };
        let loaded = load_text(source, &Hints::default(), readers).unwrap();
        let renderer = Renderer::new(loaded, Meshes::Kept).unwrap();
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
            let first = rays.tells.iter().position(|&told| told == Some(index)).expect("a line of the text");
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
