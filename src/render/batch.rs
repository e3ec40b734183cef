//! The centres of neighbouring pixels, brought from stage to stage together: rays, then what they hit, then
//! the surfaces there. One centre's stages wait for each other's divisions and for memory, while
//! neighbours' need not.

use crate::camera::Camera;
use crate::caster::Caster;
use crate::math::ray::{Hit, Ray};
use crate::projection::Projection;
use crate::stats::Probe;
use crate::world::SurfacePoint;
use glam::DVec2;
use std::ops::Range;

/// What is seen through the centre of a pixel.
#[derive(Clone, Copy, Debug)]
pub struct Center {
    pub column: usize,
    pub ray: Ray,
    /// What the ray hits, once it has been found.
    pub hit: Option<Hit>,
    pub surface: Option<SurfacePoint>,
}

/// Some neighbours of a row.
#[derive(Debug, Default)]
pub struct Batch {
    centers: Vec<Center>,
}

impl Batch {
    /// Enough that waits overlap, few enough to stay near.
    pub const PIXELS: usize = 16;

    pub fn centers(&self) -> &[Center] {
        &self.centers
    }

    /// Takes the pixels in these columns of row `j`.
    pub fn take(&mut self, camera: &Camera, columns: Range<usize>, j: usize) {
        self.centers.clear();
        for column in columns {
            let ray = camera.ray(DVec2::new(column as f64, j as f64), DVec2::ZERO);
            self.centers.push(Center { column, ray, hit: None, surface: None });
        }
    }

    /// Finds what each ray hits; `projection` says what is seen in row `j`, as far as it is known.
    pub fn find_hits<P: Probe>(
        &mut self,
        caster: &Caster,
        projection: Option<&Projection>,
        j: usize,
        probe: &mut P,
    ) {
        for Center { column, ray, hit, .. } in &mut self.centers {
            let known = projection.and_then(|projection| projection.hit(caster.world, ray, *column, j));
            *hit = known.unwrap_or_else(|| caster.nearest(ray, None, probe));
        }
    }

    /// Finds the surface at each hit.
    pub fn find_surfaces(&mut self, caster: &Caster) {
        for Center { ray, hit, surface, .. } in &mut self.centers {
            *surface = hit.map(|hit| caster.world.surface(ray, hit));
        }
    }
}
