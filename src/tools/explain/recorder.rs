//! Records the rays behind one sample while the tracer follows them, with all that the tracer itself does not need.

use super::close_call::is_about_zero;
use super::explainer::Explainer;
use super::stop::Stop;
use super::tree::{CloseCall, CloseCallKind, Crossing, LeftOut, Lighting, NotFollowed, RayNode, Shadow};
use crate::math::ray::{Hit, Ray};
use crate::picture::Color;
use crate::stats::{Counts, Probe};
use crate::trace::{Event, Observer, is_critical};

/// Records the descendants of one camera ray while the tracer follows them, as long as there is room.
pub struct Recorder<'e, 'p, 'r> {
    explainer: &'e Explainer<'p, 'r>,
    stop: &'e Stop,
    rays: Vec<RayNode>,
    /// The largest number of rays kept.
    room: usize,
    /// The rays that are not kept.
    left_out: LeftOut,
    /// The tracer's pending rays: the index of each, or `None` if it is not kept, and the primitive at its origin.
    waiting: Vec<(Option<usize>, Option<u32>)>,
    current: Option<usize>,
    /// The primitive at the current ray's origin.
    leaves: Option<u32>,
    /// The current ray's nearest hit.
    hit: Option<Hit>,
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
            filter: Color::ONE,
            weight: 1.0,
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
        let mut recorder = Self {
            explainer,
            stop,
            rays: vec![],
            room,
            left_out: LeftOut::default(),
            waiting: vec![],
            current: None,
            leaves: None,
            hit: None,
            counts: Counts::default(),
            shadow: None,
        };
        recorder.push(RayNode::new(ray));
        recorder.pop();
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

    /// Adds a ray, unless there is no room or its parent was not kept.
    fn push(&mut self, ray: RayNode) {
        let place = self.rays.len();
        let is_kept = place < self.room && (ray.kind.is_none() || self.current.is_some());
        if is_kept {
            if let Some(parent) = self.current {
                self.rays[parent].children.push(place);
            }
            self.rays.push(ray);
        } else {
            self.left_out.rays += 1;
        }
        self.waiting.push((is_kept.then_some(place), self.hit.map(|hit| hit.primitive)));
    }

    /// Turns to the ray that was pushed last.
    fn pop(&mut self) {
        (self.current, self.leaves) = self.waiting.pop().unwrap_or_default();
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
        let event = event();
        match event {
            Event::Popped => {
                self.leave_out();
                self.pop();
                return;
            }
            Event::Pushed { kind, ray, filter, weight, .. } => {
                let bounces = 1 + self.current.map_or(0, |parent| self.rays[parent].bounces);
                self.push(RayNode { kind: Some(kind), bounces, filter, weight, ..RayNode::new(ray) });
                return;
            }
            _ => {}
        }
        // The other events concern the current ray.
        let Self { explainer, stop, leaves, .. } = *self;
        let Some(node) = self.current.map(|place| &mut self.rays[place]) else { return };
        match event {
            Event::Met(hit) => {
                (self.hit, node.counts) = (hit, std::mem::take(&mut self.counts));
                if !stop.is_over() {
                    node.close_calls = explainer.close_calls(&node.ray, leaves, hit);
                }
            }
            Event::Surface { point, material } => {
                let Some(hit) = self.hit else { return };
                let surface = explainer.surface(point, material, hit);
                if is_about_zero(surface.point.normal.dot(node.ray.direction)) {
                    node.close_calls.push(CloseCall::of(CloseCallKind::Cosine));
                }
                if explainer.is_in_boundary(&surface) {
                    node.close_calls.push(CloseCall::of(CloseCallKind::Boundary));
                }
                node.surface = Some(surface);
            }
            Event::NotFollowed { kind, end } => node.ends.push(NotFollowed { kind, end }),
            Event::Refracting { direction, normal, indices } => {
                if is_critical(direction, normal, indices) {
                    node.close_calls.insert(0, CloseCall::of(CloseCallKind::Critical));
                }
            }
            Event::Ambient(color) => node.surface.iter_mut().for_each(|it| it.ambient = Some(color)),
            Event::ShadowRay(ray) => {
                let (counts, crossed, close_calls) = Default::default();
                self.shadow = Some(Shadow { ray, crossed, blocker: None, counts, close_calls });
            }
            Event::Crossed { hit, tint, leaves } => {
                if let Some(shadow) = &mut self.shadow {
                    shadow.crossed.push(Crossing {
                        object: explainer.object(hit.primitive),
                        hit,
                        tint,
                        leaves,
                    });
                }
            }
            Event::Light { incident, cosine, passed, parts } => {
                let (Some(surface), Some(hit)) = (&mut node.surface, self.hit) else { return };
                let (counts, mut shadow) = (std::mem::take(&mut self.counts), self.shadow.take());
                if let Some(shadow) = shadow.as_mut().filter(|_| !stop.is_over()) {
                    shadow.counts = counts;
                    explainer.finish_shadow(shadow, surface.lights.len(), hit.primitive);
                    if is_about_zero(cosine) {
                        shadow.close_calls.push(CloseCall::of(CloseCallKind::Cosine));
                    }
                }
                surface.lights.push(Lighting { incident, cosine, passed, parts, shadow });
            }
            Event::Shaded(color) => node.color = color,
            Event::Popped | Event::Pushed { .. } => {}
        }
    }
}
