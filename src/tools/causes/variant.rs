//! Variants of a picture: with some mistakes, whole or at some pixels.

use super::Original;
use super::changes::{Part, has_secondary_rays, leave_out};
use super::mistakes::{Make, Mistake};
use super::paint::{Move, Painter};
use super::rules::Rule;
use super::student::{MAX_BOUNCES, Student};
use super::wrong_hits::{MAX_TESTS, WrongHits, is_exhaustive};
use crate::picture::{Color, FloatPicture};
use crate::render::renderer::{Prepared, Renderer};
use crate::render::{Layer, Request};
use crate::scene::Camera;
use crate::tools::compare::color_of;
use crate::trace::Shadows;
use crate::world::Objects;
use glam::DVec2;

/// Numbers by which a tracer in single precision may decide otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thresholds {
    /// An epsilon in place of the scene's.
    pub epsilon: Option<f64>,
    /// The factor of the smallest weight of a ray that is traced.
    pub weight: f64,
}

impl Thresholds {
    /// This program's own.
    pub const OWN: Self = Self { epsilon: None, weight: 1.0 };
}

/// A picture with some mistakes, ready to be rendered.
pub struct Variant<'o> {
    original: &'o Original<'o>,
    /// The renderer of another scene.
    renderer: Option<Renderer>,
    request: Request,
    rules: Vec<Rule>,
    moves: Vec<Move>,
    /// A part of the scene that is left out.
    without: Option<Part>,
    pixel_changes: PixelChanges,
}

impl<'o> Variant<'o> {
    /// Returns the picture with these mistakes. `None` if it cannot be made.
    pub fn new(original: &'o Original, mistakes: &[Mistake]) -> Option<Self> {
        let own = original.renderer();
        let (mut scene, mut request) = (own.scene.clone(), original.request.clone());
        let (mut rules, mut moves, mut without) = (vec![], vec![], None);
        for mistake in mistakes {
            match mistake.make {
                Make::Colors { .. } | Make::Flip(_) | Make::Unset(_) => {}
                Make::Points(shift) => moves.push(shift),
                Make::Request(change) => change(&mut request, &scene),
                Make::Scene(change) => change(&mut scene),
                Make::Without(part) => {
                    leave_out(&mut scene, part);
                    without = Some(part);
                }
                Make::Rule(rule) => rules.push(rule),
            }
        }
        // A camera equal to the scene's counts as unchanged.
        if request.camera == Some(own.scene.camera) {
            request.camera = original.request.camera;
        }
        let is_student = !rules.is_empty() || !moves.is_empty();
        let is_deep = is_student && request.effects.bounces > MAX_BOUNCES && has_secondary_rays(&scene);
        let is_large = is_exhaustive(&rules) && own.world().ids().len() * request.camera_rays() > MAX_TESTS;
        if is_deep || is_large {
            return None;
        }
        let renderer =
            (scene != own.scene).then(|| own.with_scene(scene, &original.patience)).transpose().ok()?;
        let pixel_changes = PixelChanges::new(mistakes);
        Some(Self { original, renderer, request, rules, moves, without, pixel_changes })
    }

    /// Returns true if the tracer and its scene are the original's, so that only the finished picture changes.
    pub fn is_traced_as_original(&self) -> bool {
        let is_same = self.renderer.is_none() && self.rules.is_empty() && self.moves.is_empty();
        is_same && !self.hides_triangles() && self.request == self.original.request
    }

    /// Returns true if rays leave surfaces, so that an epsilon may show.
    pub fn has_secondary_rays(&self) -> bool {
        let scene =
            self.renderer.as_ref().map_or(&self.original.renderer().scene, |renderer| &renderer.scene);
        let effects = self.request.effects;
        let has_rays = effects.shadows != Shadows::None || effects.bounces > 0 && has_secondary_rays(scene);
        self.original.layer == Layer::Color && has_rays
    }

    /// Returns true if the weights of rays decide which ones are traced.
    pub fn weighs_rays(&self) -> bool {
        self.request.effects.bounces > 0 && self.request.effects.min_weight > 0.0
    }

    /// Returns the number of camera rays on which a pixel depends.
    pub fn rays_per_pixel(&self) -> usize {
        let is_color = self.original.layer == Layer::Color;
        let Request { sampler, filter, .. } = self.request;
        let side = 2 * filter.support() + 1;
        if is_color { sampler.count() as usize * side * side } else { 1 }
    }

    /// Returns the width and height of the picture.
    pub fn size(&self) -> [usize; 2] {
        self.request.layer_size(&self.original.layer)
    }

    /// Returns the changes of the finished picture.
    pub fn pixel_changes(&self) -> &PixelChanges {
        &self.pixel_changes
    }

    /// Returns the whole picture. `None` if it is cancelled, or memory is too small.
    pub fn picture(&self) -> Option<FloatPicture> {
        let mut picture = if self.is_traced_as_original() {
            self.original.colors.clone()
        } else if self.rules.is_empty() && self.moves.is_empty() && !self.hides_triangles() {
            let rendered =
                |prepared: &Prepared| prepared.render_watched(&self.request, self.original.patience.0).ok();
            self.with_prepared(rendered)??.0.remove(0)
        } else {
            self.with_painter(Thresholds::OWN, |painter| painter.picture().ok())??
        };
        if self.original.is_cancelled() {
            return None;
        }
        self.pixel_changes.apply(&mut picture);
        Some(picture)
    }

    /// Calls `work` with the prepared scene.
    fn with_prepared<T>(&self, work: impl FnOnce(&Prepared) -> T) -> Option<T> {
        match &self.renderer {
            Some(renderer) => {
                Some(work(&renderer.prepare_within(&self.request, &self.original.patience).ok()?))
            }
            None => Some(work(&self.original.prepared)),
        }
    }

    /// Calls `work` with a student's tracer that paints the picture before it is finished. `None` if memory is too small.
    pub fn with_painter<T>(&self, thresholds: Thresholds, work: impl FnOnce(&Painter) -> T) -> Option<T> {
        let paint = |prepared: &Prepared| {
            let patience = &self.original.patience;
            let (renderer, caster) = (prepared.renderer(), &prepared.caster(patience).ok()?);
            let objects = Objects::new(&renderer.scene, self.original.renderer().meshes(), caster.world)?;
            let wrong = WrongHits::new(caster, &objects, &self.rules, self.hidden(&objects));
            let mut effects = self.request.effects;
            effects.min_weight *= thresholds.weight;
            let student = if wrong.is_needed() {
                Student::new(renderer, &wrong, effects)
            } else {
                Student::new(renderer, caster, effects)
            };
            let (objects, epsilon) = (Some(&objects), thresholds.epsilon);
            let student = Student { rules: &self.rules, objects, epsilon, patience, ..student };
            Some(work(&Painter::new(&student, &self.request, &self.moves)))
        };
        self.with_prepared(paint)?
    }

    /// Returns true if triangles are left out of the world.
    fn hides_triangles(&self) -> bool {
        matches!(self.without, Some(Part::Triangle { .. }))
    }

    /// Returns the primitives that are left out of the world, in ascending order.
    fn hidden(&self, objects: &Objects) -> Vec<u32> {
        let Some(part) = self.without else { return vec![] };
        let scene = &self.original.renderer().scene;
        let mut hidden: Vec<u32> = objects.iter().filter_map(|object| part.hidden(object, scene)).collect();
        hidden.sort_unstable();
        hidden
    }

    /// Returns the depth below a surface at which rays in single precision may start by rounding.
    pub fn depth(&self) -> f64 {
        let (world, scene) = (self.original.renderer().world(), &self.original.renderer().scene);
        let camera = self.request.camera.as_ref().unwrap_or(&scene.camera);
        let (Camera::Orthographic { center, .. } | Camera::Perspective { center, .. }) = camera;
        DEPTH * (world.max_abs_coord + center.abs().max_element())
    }
}

/// The depth below a surface at which rays in single precision may start, as a part of the largest coordinates.
const DEPTH: f64 = 1.0 / (1u64 << 19) as f64;

/// Returns the colours of a variant at some pixels, before they are finished, with all points moved.
pub fn colors_at(painter: &Painter, variant: &Variant, pixels: &[usize], moved: DVec2) -> Vec<Color> {
    let size = variant.size();
    let sources: Vec<[usize; 2]> = pixels.iter().map(|&at| variant.pixel_changes.source(at, size)).collect();
    painter.pixels(&sources, moved)
}

/// Changes of a finished picture: flips, and changes of colours in their order.
#[derive(Clone, Debug, Default)]
pub struct PixelChanges {
    /// Left to right, and upside down.
    flips: [bool; 2],
    changes: Vec<Make>,
}

impl PixelChanges {
    /// Returns the changes that these mistakes make.
    pub fn new(mistakes: &[Mistake]) -> Self {
        let mut all = Self::default();
        for mistake in mistakes {
            match mistake.make {
                Make::Flip([across, down]) => {
                    all.flips = [all.flips[0] ^ across, all.flips[1] ^ down];
                }
                make @ (Make::Colors { .. } | Make::Unset(_)) => all.changes.push(make),
                _ => {}
            }
        }
        all
    }

    /// Returns the column and row of the pixel that is moved to this index by the flips.
    pub fn source(&self, at: usize, [width, height]: [usize; 2]) -> [usize; 2] {
        let [x, y] = [at % width, at / width];
        let [across, down] = self.flips;
        [if across { width - 1 - x } else { x }, if down { height - 1 - y } else { y }]
    }

    /// Returns the finished colour of the pixel with this index in the finished picture.
    pub fn color(&self, color: Color, at: usize, size: [usize; 2]) -> Color {
        self.changes.iter().fold(color, |color, change| match change {
            Make::Colors { change, .. } => change(color),
            Make::Unset(unset) if unset.window.contains([at % size[0], at / size[0]]) => {
                color_of(unset.color)
            }
            _ => color,
        })
    }

    /// Finishes a whole picture.
    pub fn apply(&self, picture: &mut FloatPicture) {
        let size = picture.size;
        if self.flips[0] {
            picture.colors.chunks_exact_mut(size[0]).for_each(<[Color]>::reverse);
        }
        if self.flips[1] {
            let rows = picture.colors.chunks_exact(size[0]).rev();
            picture.colors = rows.flatten().copied().collect();
        }
        if !self.changes.is_empty() {
            let colors = picture.colors.iter_mut().enumerate();
            colors.for_each(|(at, color)| *color = self.color(*color, at, size));
        }
    }
}
