//! Brute force: every ray is tested against every primitive, in double precision, with exact decisions.

use crate::base::patience::{Endless, Steps};
use crate::math::ray::{Ray, Visible};
use crate::tools::causes::hits::Hits;
use crate::world::World;

/// Tests every primitive, one by one.
pub struct BruteForce<'a> {
    pub world: &'a World,
}

impl BruteForce<'_> {
    /// Returns all hits along a ray, each with its primitive.
    fn hits<'r>(&'r self, ray: &'r Ray, exclude: Option<u32>) -> impl Iterator<Item = (f64, u32)> + 'r {
        let ids = self.world.ids().filter(move |&id| Some(id) != exclude);
        ids.filter_map(move |id| Some((self.world.crossing(ray, id)?, id)))
    }
}

impl Hits for BruteForce<'_> {
    fn world(&self) -> &World {
        self.world
    }

    fn nearest(&self, ray: &Ray, origin_primitive: Option<u32>) -> Option<Visible> {
        let exclude = origin_primitive.filter(|&id| self.world.is_triangle(id));
        let nearest = self.hits(ray, exclude).map(|(t, _)| t).reduce(f64::min)?;
        let end = nearest + self.world.coincidence_reach(nearest);
        let close = self.hits(ray, exclude).filter(|&(t, _)| t <= end).collect();
        let (t, primitive) = self.world.foremost(ray, close, &mut Steps::new(&Endless))?;
        Some(Visible { primitive, t_bound: t })
    }
}
