//! The rays behind a pixel as lines in space, each tied to its lines in the text of `-pixel`.

use crate::caster::dda::Dda;
use crate::caster::lattice::Lattice;
use crate::math::aabb::Aabb;
use crate::math::ray::Ray;
use crate::tools::explain::{Lighting, PixelTree, RayNode, SampleTree};
use crate::trace::Secondary;
use glam::DVec3;
use serde::Serialize;

/// Lines beyond this number are not drawn.
const MAX_LINES: usize = 4000;
/// Nor are more cells.
const MAX_CELLS: usize = 4000;
/// The text is cut after so many lines.
const MAX_TEXT: usize = 5000;

/// What a line in space shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LineKind {
    Camera,
    Reflected,
    Refracted,
    /// A ray that reaches a light.
    Light,
    /// A ray to a light that something blocks.
    Shadow,
    Normal,
}

/// A line in space.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Segment {
    pub kind: LineKind,
    pub from: DVec3,
    pub to: DVec3,
}

/// The rays behind a pixel.
#[derive(Debug, Serialize)]
pub struct Rays {
    /// The text of `-pixel`, line by line.
    pub text: Vec<String>,
    /// The line in space that each line of the text tells of, by its index.
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
        tree.samples.iter().for_each(|sample| drawing.add_sample(sample));
        let text: Vec<String> = tree.to_string().lines().take(MAX_TEXT).map(str::to_owned).collect();
        let tells = tells(&text, &drawing.owners);
        let lattice = bounds.zip(cells).map(|(bounds, cells)| Lattice::new(bounds, cells));
        let passed = lattice.as_ref().map(|lattice| cells_passed(lattice, tree)).unwrap_or_default();
        let cell_size = lattice.map_or(DVec3::ZERO, |lattice| lattice.cell_size);
        drawing.segments.truncate(MAX_LINES);
        Self { text, tells, segments: drawing.segments, cells: passed, cell_size }
    }
}

/// Lines in space under construction, in the order of the text.
struct Drawing {
    /// How far a ray is drawn that meets nothing.
    far: f64,
    segments: Vec<Segment>,
    /// For each ray of the text, the index of its line, and those of its lights.
    owners: Vec<(usize, Vec<Option<usize>>)>,
}

impl Drawing {
    fn add_sample(&mut self, sample: &SampleTree) {
        let mut waiting = if sample.rays.is_empty() { vec![] } else { vec![0] };
        while let Some(node) = waiting.pop().and_then(|place: usize| sample.rays.get(place)) {
            self.add_ray(node);
            waiting.extend(node.children.iter().rev());
        }
    }

    fn add_ray(&mut self, node: &RayNode) {
        let kind = match node.kind {
            None => LineKind::Camera,
            Some(Secondary::Reflected) => LineKind::Reflected,
            Some(Secondary::Refracted) => LineKind::Refracted,
        };
        let own = self.segments.len();
        let t = node.surface.as_ref().map(|surface| surface.t);
        self.add(kind, &node.ray, t);
        let Some(surface) = &node.surface else { return self.owners.push((own, vec![])) };
        let (point, normal) = (surface.point.position, surface.point.normal);
        let lights = surface.lights.iter().map(|light| self.add_light(point, light)).collect();
        self.segments.push(Segment {
            kind: LineKind::Normal,
            from: point,
            to: point + 0.06 * self.far * normal,
        });
        self.owners.push((own, lights));
    }

    /// The line towards a light, if a ray is cast there.
    fn add_light(&mut self, point: DVec3, light: &Lighting) -> Option<usize> {
        let shadow = light.shadow.as_ref()?;
        let blocked = shadow.blocker.as_ref().map(|blocker| blocker.t);
        let distance = light.incident.distance;
        let ray = Ray::new(point, light.incident.direction);
        let (kind, t) = match blocked {
            Some(t) => (LineKind::Shadow, Some(t)),
            None => (LineKind::Light, distance.is_finite().then_some(distance)),
        };
        self.add(kind, if blocked.is_some() { &shadow.ray } else { &ray }, t);
        Some(self.segments.len() - 1)
    }

    /// A ray up to `t`. An orthographic camera's may start behind its plane.
    fn add(&mut self, kind: LineKind, ray: &Ray, t: Option<f64>) {
        let length = ray.direction.length().max(f64::MIN_POSITIVE);
        let t = t.unwrap_or(self.far / length);
        let start = if t < 0.0 { t - self.far / length } else { 0.0 };
        self.segments.push(Segment { kind, from: ray.at(start), to: ray.at(t) });
    }
}

/// The line in space that each line of the text tells of. Rays and lights stand in the text in the order in which they
/// were drawn.
fn tells(text: &[String], owners: &[(usize, Vec<Option<usize>>)]) -> Vec<Option<usize>> {
    let (mut rays, mut lights) = (owners.iter(), [].iter());
    let (mut ray, mut current) = (None, None);
    let mut told = vec![];
    for line in text {
        let words = line.trim_start();
        let starts_with = |starts: &[&str]| starts.iter().any(|start| words.starts_with(start));
        if starts_with(&["camera ray", "reflected ray,", "refracted ray,"]) {
            if let Some((own, its_lights)) = rays.next() {
                (ray, lights) = (Some(*own), its_lights.iter());
                current = ray;
            }
        } else if starts_with(&["light "]) {
            current = lights.next().copied().flatten().or(ray);
        } else if starts_with(&["own colour"]) {
            current = ray;
        } else if starts_with(&["the sample's colour", "sample "]) {
            (ray, current) = (None, None);
        }
        told.push(current);
    }
    told
}

/// The cells of a grid that the rays of a pixel pass, without those to the lights.
fn cells_passed(lattice: &Lattice, tree: &PixelTree) -> Vec<DVec3> {
    let most = lattice.cells().map(|count| count as f64);
    let mut indices = vec![];
    for node in tree.samples.iter().flat_map(|sample| &sample.rays) {
        let Some((mut dda, _)) = Dda::of_ray(lattice, &node.ray) else { continue };
        let end = node.surface.as_ref().map_or(i32::MAX, |surface| dda.fixed_t(surface.t));
        while indices.len() < MAX_CELLS {
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
        let request = Request { effects, ..Request::new([9, 9]) };
        let prepared = renderer.prepare_for(structure, &request, Tracing::Counted).unwrap();
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
        let drawn =
            |kinds: &[LineKind]| rays.segments.iter().filter(|line| kinds.contains(&line.kind)).count();
        assert!(nodes().count() > 4);
        assert_eq!(drawn(&[LineKind::Camera, LineKind::Reflected, LineKind::Refracted]), nodes().count());
        assert_eq!(
            drawn(&[LineKind::Light, LineKind::Shadow]),
            lights.filter(|light| light.shadow.is_some()).count()
        );
        for (index, line) in
            rays.segments.iter().enumerate().filter(|(_, line)| line.kind != LineKind::Normal)
        {
            let first = rays.tells.iter().position(|&told| told == Some(index)).expect("a line of the text");
            let word = match line.kind {
                LineKind::Camera => "camera ray",
                LineKind::Reflected => "reflected ray",
                LineKind::Refracted => "refracted ray",
                _ => "light ",
            };
            assert!(rays.text[first].trim_start().starts_with(word), "{}", rays.text[first]);
            if line.kind == LineKind::Shadow {
                // The line between has the direction to the light.
                assert!(rays.text[first + 2].contains("shadow ray blocked"), "{}", rays.text[first + 2]);
            }
        }
    }

    #[test]
    fn a_ray_ends_where_the_next_one_starts() {
        let (_, rays) = rays(Structure::List);
        let (camera, second) =
            (&rays.segments[0], rays.segments.iter().find(|line| line.kind == LineKind::Refracted));
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
