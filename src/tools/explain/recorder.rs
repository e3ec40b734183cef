//! Records the rays behind one sample while the tracer follows them, with all that the tracer itself does not need.

use super::close_call::is_about_zero;
use super::explainer::Explainer;
use super::stop::Stop;
use super::tree::{CloseCall, CloseCallKind, Crossing, LeftOut, Lighting, NotFollowed, RayNode, Shadow};
use crate::math::ray::{Hit, Ray};
use crate::picture::Color;
use crate::scene::material::Phong;
use crate::stats::{Counts, Probe};
use crate::trace::{Event, Observer, is_critical};
use crate::world::SurfacePoint;

/// Records the descendants of one camera ray while the tracer follows them, as long as there is room.
pub struct Recorder<'e, 'p, 'r> {
    explainer: &'e Explainer<'p, 'r>,
    stop: &'e Stop,
    rays: Vec<RayNode>,
    /// The largest number of rays kept.
    room: usize,
    /// The rays that are not kept.
    left_out: LeftOut,
    /// The indices of pending rays, in the order of the tracer's pending rays. `None` for a ray that is not kept.
    waiting: Vec<Option<usize>>,
    current: Option<usize>,
    /// The work since the last ray was finished.
    counts: Counts,
    /// The last ray towards a light, until the light's contribution is known.
    shadow: Option<Shadow>,
}

impl RayNode {
    /// Starts the node of a camera ray.
    fn new(ray: Ray) -> Self {
        Self {
            kind: None,
            bounces: 0,
            ray,
            leaves: None,
            filter: Color::ONE,
            weight: 1.0,
            hit: None,
            counts: Counts::default(),
            surface: None,
            color: Color::ZERO,
            ends: vec![],
            children: vec![],
            close_calls: vec![],
        }
    }
}

impl<'e, 'p, 'r> Recorder<'e, 'p, 'r> {
    /// Starts with a camera ray. At most `room` rays are kept.
    pub fn new(explainer: &'e Explainer<'p, 'r>, ray: Ray, room: usize, stop: &'e Stop) -> Self {
        let (rays, left_out, waiting, counts) = Default::default();
        let mut recorder =
            Self { explainer, stop, rays, room, left_out, waiting, current: None, counts, shadow: None };
        recorder.push(RayNode::new(ray));
        recorder.current = recorder.waiting.pop().flatten();
        recorder.non_shadow_ray();
        recorder
    }

    /// Returns the rays, with the camera ray first and each ray after its parent, and the rays that are not kept.
    pub fn finish(mut self) -> (Vec<RayNode>, LeftOut) {
        self.leave_out();
        (self.rays, self.left_out)
    }

    /// Counts the work for a ray that is not kept.
    fn leave_out(&mut self) {
        if self.current.is_none() {
            self.left_out.counts = self.left_out.counts.merge(std::mem::take(&mut self.counts));
        }
    }

    fn node(&mut self) -> Option<&mut RayNode> {
        self.rays.get_mut(self.current?)
    }

    /// Adds a ray, unless there is no room or its parent was not kept.
    fn push(&mut self, ray: RayNode) {
        let place = self.rays.len();
        let is_kept = place < self.room && (ray.kind.is_none() || self.current.is_some());
        if is_kept {
            self.node().iter_mut().for_each(|parent| parent.children.push(place));
            self.rays.push(ray);
        } else {
            self.left_out.rays += 1;
        }
        self.waiting.push(is_kept.then_some(place));
    }

    /// Notes what the current ray hits.
    fn hit(&mut self, hit: Option<Hit>) {
        let Self { explainer, stop, .. } = *self;
        if self.current.is_none() {
            return;
        }
        let counts = std::mem::take(&mut self.counts);
        let Some(node) = self.node() else { return };
        (node.hit, node.counts) = (hit, counts);
        if !stop.is_over() {
            let sees = hit.map(|hit| (hit.primitive, hit.t));
            node.close_calls = explainer.close_calls(&node.ray, node.leaves, sees);
        }
    }

    fn surface(&mut self, point: &SurfacePoint, material: &Phong) {
        let explainer = self.explainer;
        let Some(node) = self.node() else { return };
        let Some(hit) = node.hit else { return };
        let surface = explainer.surface(point, material, hit);
        let is_grazing = is_about_zero(surface.point.normal.dot(node.ray.direction));
        let is_in_boundary = explainer.is_in_boundary(&surface);
        let found = [(is_grazing, CloseCallKind::Cosine), (is_in_boundary, CloseCallKind::Boundary)];
        node.close_calls.extend(found.into_iter().filter(|(is, _)| *is).map(|(_, kind)| CloseCall::of(kind)));
        node.surface = Some(surface);
    }

    fn light(&mut self, light: Lighting) {
        let Self { explainer, stop, .. } = *self;
        if self.current.is_none() {
            return;
        }
        let counts = std::mem::take(&mut self.counts);
        let mut shadow = self.shadow.take();
        let Some(RayNode { surface: Some(surface), hit: Some(hit), .. }) = self.node() else { return };
        if let Some(shadow) = shadow.as_mut().filter(|_| !stop.is_over()) {
            shadow.counts = counts;
            explainer.finish_shadow(shadow, surface.lights.len(), hit.primitive);
            if is_about_zero(light.cosine) {
                shadow.close_calls.push(CloseCall::of(CloseCallKind::Cosine));
            }
        }
        surface.lights.push(Lighting { shadow, ..light });
    }
}

impl Probe for Recorder<'_, '_, '_> {
    const COUNTS: bool = true;

    fn intersections(&mut self, count: usize) {
        self.counts.intersections(count);
    }

    fn cell(&mut self) {
        self.counts.cell();
    }
}

impl Observer for Recorder<'_, '_, '_> {
    fn non_shadow_ray(&mut self) {
        self.counts.non_shadow_ray();
    }

    fn shadow_ray(&mut self) {
        self.counts.shadow_ray();
    }

    fn observe<'e>(&mut self, event: impl FnOnce() -> Event<'e>) {
        match event() {
            Event::Popped => {
                self.leave_out();
                self.current = self.waiting.pop().flatten();
            }
            Event::Met(hit) => self.hit(hit),
            Event::Surface { point, material } => self.surface(point, material),
            Event::Pushed { kind, ray, filter, weight, .. } => {
                let parent = self.node().map(|node| (node.bounces, node.hit));
                let (bounces, hit) = parent.unwrap_or_default();
                let leaves = hit.map(|hit| hit.primitive);
                let (kind, bounces) = (Some(kind), bounces + 1);
                self.push(RayNode { kind, bounces, leaves, filter, weight, ..RayNode::new(ray) });
            }
            Event::ShadowRay(ray) => {
                let (counts, crossed, close_calls) = Default::default();
                self.shadow =
                    self.current.map(|_| Shadow { ray, crossed, blocker: None, counts, close_calls });
            }
            Event::Crossed { hit, tint, leaves } => {
                if let Some(shadow) = &mut self.shadow {
                    let object = self.explainer.object(hit.primitive);
                    shadow.crossed.push(Crossing { object, hit, tint, leaves });
                }
            }
            Event::Light { incident, cosine, passed, parts } => {
                self.light(Lighting { incident, cosine, passed, parts, shadow: None });
            }
            Event::NotFollowed { kind, end } => {
                self.node().into_iter().for_each(|node| node.ends.push(NotFollowed { kind, end }));
            }
            Event::Refracting { direction, normal, indices } if is_critical(direction, normal, indices) => {
                let call = CloseCall::of(CloseCallKind::Critical);
                self.node().into_iter().for_each(|node| node.close_calls.insert(0, call.clone()));
            }
            Event::Refracting { .. } => {}
            Event::Ambient(color) => {
                let surface = self.node().and_then(|node| node.surface.as_mut());
                surface.into_iter().for_each(|surface| surface.ambient = Some(color));
            }
            Event::Shaded(color) => self.node().into_iter().for_each(|node| node.color = color),
        }
    }
}
