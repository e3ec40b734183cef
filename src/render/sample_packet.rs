//! Samples of neighbouring pixels that pass through the stages together: first their rays, then the hits, and
//! then the surfaces there. The stages of one sample depend on each other, while those of different samples
//! overlap, which hides the latency of divisions and of memory.

use crate::camera::Camera;
use crate::grid::Caster;
use crate::grid::packet::{PACKET_SIZE, PacketRay};
use crate::math::ray::{Ray, Visible};
use crate::mode::Mode;
use crate::raster::{Seen, VisibilityBuffer};
use crate::stats::Probe;
use crate::world::{SurfacePoint, World};
use glam::DVec2;
use std::ops::Range;

/// A sample in a row of pixels, and its hit.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    pub column: usize,
    /// The offset from the pixel's centre, in pixels.
    pub offset: DVec2,
    /// Whether it is the last sample of its pixel.
    pub is_last: bool,
    pub ray: Ray,
    /// The primitive that the ray hits first, once the ray has been cast.
    pub visible: Option<Visible>,
    /// The surface there, once it has been computed.
    pub surface: Option<SurfacePoint>,
}

impl PacketRay for Sample {
    #[inline(always)]
    fn ray(&self) -> &Ray {
        &self.ray
    }

    #[inline(always)]
    fn set_visible(&mut self, visible: Option<Visible>) {
        self.visible = visible;
    }
}

/// Up to [`SIZE`](Self::SIZE) samples of a row.
#[derive(Debug, Default)]
pub struct SamplePacket {
    samples: Vec<Sample>,
}

impl SamplePacket {
    /// The maximum number of samples, which is the number of rays that are cast together.
    pub const SIZE: usize = PACKET_SIZE;

    pub fn samples(&self) -> &[Sample] {
        &self.samples
    }

    pub fn clear(&mut self) {
        self.samples.clear();
    }

    /// Adds the centres of the pixels in these columns of row `j`.
    #[inline(always)]
    pub fn push_centers(&mut self, camera: &Camera, columns: Range<usize>, j: usize) {
        for column in columns {
            self.push(camera, [column, j], DVec2::ZERO, true);
        }
    }

    /// Adds a sample of a pixel in row `j`.
    #[inline(always)]
    pub fn push(&mut self, camera: &Camera, [column, j]: [usize; 2], offset: DVec2, is_last: bool) {
        let ray = camera.ray(DVec2::new(column as f64, j as f64), offset);
        self.samples.push(Sample { column, offset, is_last, ray, visible: None, surface: None });
    }

    /// Finds the first hit of each ray. `visibility` has those of rays through row `j`, as far as they are known.
    #[inline(always)]
    pub fn cast<M: Mode, P: Probe>(
        &mut self,
        caster: &Caster<M>,
        visibility: Option<&VisibilityBuffer>,
        j: usize,
        probe: &mut P,
    ) {
        let Some(visibility) = visibility else {
            return caster.nearest_of_packet(&mut self.samples, probe);
        };
        let mut unsure = vec![];
        for sample in &mut self.samples {
            match visibility.seen(caster.world, &sample.ray, sample.column, j) {
                Seen::Nothing => sample.visible = None,
                Seen::Primitive(visible) => sample.visible = Some(visible),
                Seen::Unsure => unsure.push(sample),
            }
        }
        caster.nearest_of_packet(&mut unsure, probe);
    }

    /// Computes the surface that each ray hits first.
    #[inline(always)]
    pub fn find_surfaces(&mut self, world: &World) {
        if !world.triangles.is_empty() {
            let visible = self.samples.iter().filter_map(|sample| sample.visible);
            visible.for_each(|visible| world.prefetch(visible.primitive));
        }
        for Sample { ray, visible, surface, .. } in &mut self.samples {
            if let Some(visible) = visible {
                *surface = Some(world.visible_surface(ray, *visible));
            }
        }
    }
}
