//! Tracing that can be stopped.

use crate::caster::Caster;
use crate::math::instructions::Level;
use crate::math::ray::{Ray, Visible};
use crate::render::Progress;
use crate::scene::model::Model;
use crate::stats::Probe;
use crate::trace::Rules;
use crate::world::World;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// When to stop.
#[derive(Debug)]
pub struct Stop {
    deadline: Instant,
    is_over: AtomicBool,
}

impl Stop {
    /// At this time.
    pub fn at(deadline: Instant) -> Self {
        Self { deadline, is_over: AtomicBool::new(false) }
    }

    /// Now.
    pub fn cancel(&self) {
        self.is_over.store(true, Ordering::Relaxed);
    }

    /// Whether it is time.
    pub fn is_over(&self) -> bool {
        if !self.is_over.load(Ordering::Relaxed) && Instant::now() >= self.deadline {
            self.cancel();
        }
        self.is_over.load(Ordering::Relaxed)
    }

    /// Ends a render when it is time. This is a [`Watch`](crate::render::Watch).
    pub fn watch(&self, _: Progress) -> ControlFlow<()> {
        if self.is_over() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// The right rules until it is time to stop. Then rays hit nothing, so that none follows.
pub struct Stoppable<'a, 'w> {
    pub caster: &'a Caster<'w>,
    pub stop: &'a Stop,
}

impl Rules for Stoppable<'_, '_> {
    fn world(&self) -> &World {
        self.caster.world()
    }

    fn model(&self) -> Model {
        self.caster.world.model
    }

    fn nearest<P: Probe>(&self, ray: &Ray, leaves: Option<u32>, probe: &mut P) -> Option<Visible> {
        if self.stop.is_over() { None } else { self.caster.nearest(ray, leaves, probe) }
    }

    fn level(&self) -> Level {
        self.caster.level()
    }
}
