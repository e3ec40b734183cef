//! Finds the object of the scene's text behind each pixel.

use crate::caster::RayOrigin;
use crate::diagnostic::Diagnostic;
use crate::render::renderer::Prepared;
use crate::render::{Request, Stop};
use crate::scene::Camera;
use crate::tools::explain::{Explainer, ObjectPart};
use glam::DVec2;
use rayon::prelude::*;
use std::collections::HashMap;

/// Returns the objects behind the centres of a picture's pixels, and two bytes for each pixel, row by row from the top:
/// 1 plus the index of its object, the lower byte first, or 0 for no object. The result is incomplete if it was
/// stopped.
pub fn object_map(
    prepared: &Prepared,
    camera: Option<Camera>,
    [width, height]: [usize; 2],
    stop: &Stop,
) -> Result<(Vec<ObjectPart>, Vec<u8>), Diagnostic> {
    let known = Explainer::new(prepared)?;
    let view = prepared.camera(&Request { camera, ..Request::new([width, height]) });
    let caster = prepared.caster(stop)?;
    // All rays are cast, without rasterization.
    let seen = |pixel: usize| {
        let at = DVec2::new((pixel % width) as f64, (height - 1 - pixel / width) as f64);
        let nearest = || caster.nearest(&view.ray(at, DVec2::ZERO), RayOrigin::FREE);
        if stop.is_over() { None } else { nearest().map(|visible| visible.primitive) }
    };
    let primitives: Vec<Option<u32>> = (0..width * height).into_par_iter().map(seen).collect();
    let (mut objects, mut places) = (vec![], Vec::with_capacity(2 * primitives.len()));
    let mut found = HashMap::new();
    for primitive in primitives {
        let place = primitive.map_or(0, |primitive| {
            *found.entry(known.object_id(primitive)).or_insert_with(|| {
                objects.push(known.object(primitive));
                u16::try_from(objects.len()).unwrap_or(0)
            })
        });
        places.extend(place.to_le_bytes());
    }
    Ok((objects, places))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::caster::choose::Structure;
    use crate::render::test_renderer::renderer_of;
    use std::time::{Duration, Instant};

    #[test]
    fn each_pixel_names_the_object_that_it_shows() {
        let text = "OrthographicCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 size 4 }
            Group { numObjects 2 Material { }
            Sphere { center -1 1 0 radius .9 }
            Box { min 0 -2 -1 max 2 0 1 } }";
        let renderer = renderer_of(text);
        let prepared =
            renderer.prepare(&Request { structure: Structure::List, ..Request::new([2, 2]) }).unwrap();
        let stop = Stop::at(Instant::now() + Duration::from_secs(60));
        let (objects, places) = object_map(&prepared, None, [2, 2], &stop).unwrap();
        let named: Vec<(&str, u32)> =
            objects.iter().map(|object| (object.name.as_str(), object.at.line)).collect();
        assert_eq!(named, [("Sphere", 3), ("Box", 4)]);
        assert_eq!(places, [1, 0, 0, 0, 0, 0, 2, 0]);
    }
}
