//! Hits that are found in wrong ways.

use super::hits::Hits;
use super::rules::Rule;
use crate::math::ray::{Ray, Visible};
use crate::world::{Objects, PlacedObject, SurfacePoint, World};

/// Returns true if one of these rules needs a test of every primitive.
pub fn is_exhaustive(rules: &[Rule]) -> bool {
    rules
        .iter()
        .any(|rule| matches!(rule, Rule::FarHit | Rule::FirstHit | Rule::LastHit | Rule::TNotRescaled))
}

/// The largest number of tests for the camera rays of a picture, if every primitive is tested.
pub const MAX_TESTS: usize = 1 << 26;

/// Finds hits as broken rules say.
pub struct WrongHits<'a> {
    hits: &'a dyn Hits,
    rules: &'a [Rule],
    /// The objects in the order of the scene.
    objects: Vec<&'a PlacedObject>,
    /// Primitives that no ray hits, in ascending order.
    hidden: Vec<u32>,
}

impl<'a> WrongHits<'a> {
    pub fn new(hits: &'a dyn Hits, objects: &'a Objects, rules: &'a [Rule], hidden: Vec<u32>) -> Self {
        let mut objects: Vec<_> = objects.iter().collect();
        objects.sort_by_key(|object| object.id);
        Self { hits, rules, objects, hidden }
    }

    /// Returns true if hits differ from the tracer's.
    pub fn is_needed(&self) -> bool {
        let is_culled = self.breaks(Rule::BackFacesCulled) || self.breaks(Rule::FrontFacesCulled);
        is_culled || is_exhaustive(self.rules) || !self.hidden.is_empty()
    }

    fn breaks(&self, rule: Rule) -> bool {
        self.rules.contains(&rule)
    }

    fn is_hidden(&self, id: u32) -> bool {
        self.hidden.binary_search(&id).is_ok()
    }

    /// Returns true if rays pass through a primitive.
    fn is_passed(&self, ray: &Ray, visible: Visible) -> bool {
        let culled = |rule: Rule, sign: f64| {
            self.breaks(rule)
                && self.world().is_triangle(visible.primitive)
                && sign * self.hits.surface(ray, visible).normal.dot(ray.direction) > 0.0
        };
        self.is_hidden(visible.primitive)
            || culled(Rule::BackFacesCulled, 1.0)
            || culled(Rule::FrontFacesCulled, -1.0)
    }

    /// Tests all primitives, and returns the hit that the rules choose.
    fn chosen(&self, ray: &Ray, origin_primitive: Option<u32>) -> Option<Visible> {
        let exclude = origin_primitive.filter(|&id| self.world().is_triangle(id));
        let endless = Ray { t_max: f64::INFINITY, ..*ray };
        let mut chosen: Option<Visible> = None;
        for object in &self.objects {
            let scale = self.scale(ray, object);
            let is_there = |id: &u32| Some(*id) != exclude && !self.is_hidden(*id);
            for id in object.primitives.clone().filter(is_there) {
                let Some(t) = self.crossing(&endless, id).map(|t| scale * t).filter(|&t| t < ray.t_max)
                else {
                    continue;
                };
                let replaces = match chosen {
                    None => true,
                    Some(_) if self.breaks(Rule::FirstHit) => false,
                    Some(_) if self.breaks(Rule::LastHit) => true,
                    Some(best) => t < best.t_bound,
                };
                if replaces {
                    chosen = Some(Visible { primitive: id, t_bound: t });
                }
            }
        }
        chosen
    }

    /// Returns the t of a primitive: the near one, or the far one of a sphere.
    fn crossing(&self, ray: &Ray, id: u32) -> Option<f64> {
        let near = self.world().crossing(ray, id)?;
        if !self.breaks(Rule::FarHit) || !self.world().is_shape(id) {
            return Some(near);
        }
        // Past the near hit by a few roundings.
        let t_min = near + 1e-9 * (near.abs() + self.world().box_of(id).extent().max_element());
        Some(self.world().crossing(&Ray { t_min, ..*ray }, id).unwrap_or(near))
    }

    /// Returns the factor of distances along a ray in the space of an object.
    fn scale(&self, ray: &Ray, object: &PlacedObject) -> f64 {
        if !self.breaks(Rule::TNotRescaled) {
            return 1.0;
        }
        let length = (object.matrix.matrix3.inverse() * ray.direction).length();
        if length.is_finite() { length } else { 1.0 }
    }
}

impl Hits for WrongHits<'_> {
    fn world(&self) -> &World {
        self.hits.world()
    }

    fn nearest(&self, ray: &Ray, origin_primitive: Option<u32>) -> Option<Visible> {
        if is_exhaustive(self.rules) {
            return self.chosen(ray, origin_primitive);
        }
        let mut ray = *ray;
        for _ in 0..self.world().most_crossings() {
            let visible = self.hits.nearest(&ray, origin_primitive)?;
            if !self.is_passed(&ray, visible) {
                return Some(visible);
            }
            ray.t_min = self.hits.distance(&ray, visible).next_up();
        }
        None
    }

    fn distance(&self, ray: &Ray, visible: Visible) -> f64 {
        if is_exhaustive(self.rules) { visible.t_bound } else { self.hits.distance(ray, visible) }
    }

    fn surface(&self, ray: &Ray, visible: Visible) -> SurfacePoint {
        if !self.breaks(Rule::TNotRescaled) {
            return self.hits.surface(ray, visible);
        }
        let object = self.objects.iter().find(|object| object.primitives.contains(&visible.primitive));
        let t_bound = visible.t_bound / object.map_or(1.0, |object| self.scale(ray, object));
        let found = self.hits.surface(ray, Visible { t_bound, ..visible });
        SurfacePoint { position: ray.at(visible.t_bound), ..found }
    }
}
