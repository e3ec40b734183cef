//! Which object of the scene's text each pixel shows.

use crate::camera::Camera;
use crate::caster::choose::{Rays, Structure};
use crate::render::{Request, Tracing};
use crate::renderer::Renderer;
use crate::scene;
use crate::stats::Quiet;
use crate::tools::explain::Objects;
use glam::DVec2;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::HashMap;

/// An object in the text.
#[derive(Debug, PartialEq, Eq, Serialize)]
pub struct NamedObject {
    pub name: String,
    pub line: u32,
    pub column: u32,
}

/// The object behind the centre of each pixel.
#[derive(Debug)]
pub struct ObjectMap {
    pub objects: Vec<NamedObject>,
    /// Row by row from the top: the index of the object and one, as two bytes with the lower one first; 0 where nothing
    /// is.
    pub places: Vec<u8>,
}

impl ObjectMap {
    /// For a picture of this size; an error is a line.
    pub fn new(renderer: &Renderer, camera: Option<scene::Camera>, size: [usize; 2]) -> Result<Self, String> {
        let request = Request { camera, ..Request::new(size) };
        let rays = request.camera_rays();
        // Every ray is cast, also where a picture would be rasterized.
        let prepared = renderer.prepare_as(Structure::Any, Rays::cast(rays), Tracing::Fast);
        let prepared = prepared.map_err(|error| error.to_string())?;
        let objects = Objects::new(renderer).map_err(|error| error.to_string())?;
        let view: Camera = prepared.camera(&request);
        let caster = prepared.caster();
        let [width, height] = size;
        let seen = |pixel: usize| {
            let at = DVec2::new((pixel % width) as f64, (height - 1 - pixel / width) as f64);
            let ray = view.ray(at, DVec2::ZERO);
            caster.nearest(&ray, None, &mut Quiet).map(|visible| visible.primitive)
        };
        let primitives: Vec<Option<u32>> =
            renderer.on_own_threads(|| (0..width * height).into_par_iter().map(seen).collect());
        let mut map = Self { objects: vec![], places: Vec::with_capacity(2 * primitives.len()) };
        let mut known = HashMap::new();
        for primitive in primitives {
            let place = primitive.map_or(0, |id| *known.entry(id).or_insert_with(|| map.place(&objects, id)));
            map.places.extend(place.to_le_bytes());
        }
        Ok(map)
    }

    /// The index of the object that a primitive belongs to, and one.
    fn place(&mut self, objects: &Objects, primitive: u32) -> u16 {
        let Some(part) = objects.of(primitive) else { return 0 };
        let object = NamedObject { name: part.name, line: part.at.line, column: part.at.column };
        let found = self.objects.iter().position(|known| *known == object);
        let place = found.unwrap_or_else(|| {
            self.objects.push(object);
            self.objects.len() - 1
        });
        u16::try_from(place + 1).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnostic::Diagnostic;
    use crate::renderer::Meshes;
    use crate::scene::MeshFile;
    use crate::scene::texels::ImageFile;
    use crate::scene_io::{Hints, Readers, Source, load_text};

    #[test]
    fn each_pixel_names_the_object_that_it_shows() {
        let text = "OrthographicCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 size 4 }
            Group { numObjects 2 Material { }
            Sphere { center -1 1 0 radius .9 }
            Box { min 0 -2 -1 max 2 0 1 } }";
        let source = Source { path: "s.txt".into(), text: text.into() };
        let no_mesh = |_: &MeshFile, _, _| Err(Diagnostic::error("no mesh"));
        let no_image = |_: &ImageFile, _| Err(Diagnostic::error("no picture"));
        let readers = Readers { mesh: &no_mesh, image: &no_image };
        let loaded = load_text(source, &Hints::default(), readers).unwrap();
        let renderer = Renderer::new(loaded, Meshes::Kept).unwrap();
        let map = ObjectMap::new(&renderer, None, [2, 2]).unwrap();
        let named: Vec<(&str, u32)> =
            map.objects.iter().map(|object| (object.name.as_str(), object.line)).collect();
        assert_eq!(named, [("Sphere", 3), ("Box", 4)]);
        assert_eq!(map.places, [1, 0, 0, 0, 0, 0, 2, 0]);
    }
}
