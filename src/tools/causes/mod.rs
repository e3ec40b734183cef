//! Finds why a picture differs from this program's, by trying common mistakes in ray tracers one after the other.
//!
//! Each [`Mistake`] produces a wrong picture: by changing the finished picture, the request or the scene, or by a
//! student's tracer that breaks a rule. Each examined picture is judged alone, in this order:
//!
//! 1. `rounding::residual` finds the pixels that rounding does not explain. If there are none, the search ends.
//! 2. `Variant::new` makes a mistake, unless it does not apply or changes nothing.
//! 3. `Search::suspects` keeps the mistakes that make some of a few wrong pixels right, and then of a larger sample.
//! 4. `Search::shortlist` keeps the best of these.
//! 5. `Search::judge_whole` keeps the candidates: those that explain most of the whole picture.
//! 6. `Candidate::explains_all` decides whether the best one is the cause. If so, the search ends.
//! 7. Steps 2 to 6 are repeated with each mistake added to each of the best candidates.
//! 8. A candidate that explains nearly all is the cause.
//! 9. `speckles` looks for rays that hit their own surface, and `partial_cause` for a candidate that is part of the
//!    cause. Otherwise `difference_kind` describes the difference.

mod changes;
mod difference_kind;
mod finding;
pub(crate) mod hits;
mod mistakes;
pub(crate) mod paint;
mod regions;
mod rendering;
mod rounding;
mod rules;
mod search;
mod self_hits;
mod speckles;
pub(crate) mod student;
mod transforms;
mod variant;
mod wrong_hits;
mod wrong_textures;

pub(crate) use changes::has_secondary_rays;
pub use difference_kind::{DifferenceKind, NamedObject, Subject};
pub use finding::{Finding, Rounded};
pub use mistakes::Mistake;
pub use rules::SelfHitting;
pub use search::MAX_UNEXPLAINED;

use crate::base::patience::Patience;
use crate::caster::RayOrigin;
use crate::picture::{FloatPicture, Picture, Pixels};
use crate::render::renderer::{Prepared, Renderer};
use crate::render::{Layer, Progress, Request, Tracing, Watch};
use crate::scene::Object;
use crate::scene::model::Shows;
use crate::tools::compare::{color_of, colors};
use crate::world::Objects;
use changes::{Part, Unset};
use difference_kind::difference_kind;
use glam::DVec2;
use mistakes::Make;
use rendering::Rendering;
use search::{Candidate, MIN_VISIBLE, Search, Suspect, partial_cause};
use speckles::speckles;
use std::ops::ControlFlow;
use std::rc::Rc;
use variant::{PixelChanges, Variant};

/// The largest number of mistakes of which each is tried together with all others.
const MAX_GROUNDS: usize = 3;
/// The largest number of objects and of lights that are left out, one after the other.
const MAX_PARTS: usize = 24;
/// The largest share of the unexplained pixels that may be left if a mistake is named as a cause, not as a part.
const MAX_LEFT: f64 = 0.02;

/// The patience of a watch.
#[derive(Clone, Copy)]
struct Watched<'a>(Watch<'a>);

impl Patience for Watched<'_> {
    fn is_over(&self) -> bool {
        (self.0)(Progress { done: 0, rows: 0, rays: 0 }).is_break()
    }
}

/// This program's picture, with its renderer and request.
pub struct Original<'a> {
    prepared: Prepared<'a>,
    objects: Objects,
    patience: Watched<'a>,
    layer: Layer,
    /// The request for this layer alone.
    request: Request,
    colors: FloatPicture,
}

impl<'a> Original<'a> {
    /// Renders the request's first layer, or its colours if there is none. `None` if no mistake can be tried, or if
    /// memory is too small. The renderer must have kept the meshes.
    pub fn new(renderer: &'a Renderer, request: &Request) -> Option<Self> {
        Self::watched(renderer, request, &|_| ControlFlow::Continue(()))
    }

    /// Renders like [`new`](Self::new), and lets `watch` cancel. After that the search ends soon, with an unspecified
    /// result. `None` also if it is cancelled during this call.
    pub fn watched(renderer: &'a Renderer, request: &Request, watch: Watch<'a>) -> Option<Self> {
        let layer = first_layer(request);
        let request =
            Request { layers: vec![layer], tracing: Tracing::Fast, window: None, ..request.clone() };
        if !can_try(renderer, &request) {
            return None;
        }
        let objects = Objects::new(&renderer.scene, renderer.meshes(), renderer.world())?;
        let prepared = renderer.prepare_within(&request, &Watched(watch)).ok()?;
        let colors = prepared.render_watched(&request, watch).ok()?.0.remove(0);
        Some(Self { prepared, objects, patience: Watched(watch), layer, request, colors })
    }

    /// Returns true if the watch has cancelled the search.
    fn is_cancelled(&self) -> bool {
        self.patience.is_over()
    }

    /// Returns this program's own picture.
    pub fn own(&self) -> Picture {
        self.colors.to_picture()
    }

    /// Returns the colours of this program's own picture.
    pub fn colors(&self) -> &FloatPicture {
        &self.colors
    }

    /// Returns the picture with these mistakes. `None` if it cannot be made.
    pub fn picture(&self, mistakes: &[Mistake]) -> Option<Picture> {
        Some(Variant::new(self, mistakes)?.picture()?.to_picture())
    }

    /// Returns the number of pixels whose difference from this program's picture rounding does not explain. The picture
    /// must have the original's size.
    pub fn unexplained(&self, picture: &Picture) -> u64 {
        let rendering = Rendering::new(self.colors.clone());
        let variant = Variant::new(self, &[]);
        rounding::residual(colors(picture), &rendering, variant.as_ref()).unexplained.len() as u64
    }

    /// Finds why a picture differs from this program's. It must have the original's size.
    pub fn explain(&self, picture: &Picture) -> Finding {
        let (picture, size) = (colors(picture), self.colors.size);
        let own = Rc::new(Rendering::new(self.colors.clone()));
        let variant = Variant::new(self, &[]);
        let before = rounding::residual(picture, &own, variant.as_ref());
        if before.differing == 0 {
            return equal(&Candidate::unchanged(own, before), &[], size);
        }
        let rounding = || Finding::Rounding { rest: Rounded::new(&before, size[0]) };
        let is_visible = before.unexplained.len() >= MIN_VISIBLE;
        if before.unexplained.is_empty() && before.visible.len() < MIN_VISIBLE {
            return rounding();
        }

        // Try each mistake.
        let rays_per_pixel = variant.map_or(1, |variant| variant.rays_per_pixel());
        let search = Search::new(picture, own, size, &before, rays_per_pixel);
        let unset = Unset::find(picture, size, &before.unexplained);
        let unset = unset.map(|unset| Mistake::unset(unset, size));
        let parts = self.parts(search.wrong_sample());
        // A camera of the other handedness turns the picture, too.
        let table = Mistake::all().filter(|mistake| !matches!(mistake.make, Make::Flip([true, true])));
        let all: Vec<Mistake> = unset.into_iter().chain(parts).chain(table).collect();
        let (candidates, tried) = self.candidates(&search, &[], &all);
        if let Some(best) = best_of(&candidates, |candidate| candidate.explains_all(&before)) {
            return equal(best, &candidates, size);
        }
        if !is_visible {
            return rounding();
        }

        // Try each mistake together with those that explain the most.
        let mut pairs = vec![];
        for ground in grounds(&candidates) {
            let search =
                Search::new(picture, ground.rendering.clone(), size, &ground.residual, rays_per_pixel);
            let (found, _) = self.candidates(&search, &ground.mistakes, &all);
            let least = ground.residual.unexplained.len() / 2;
            pairs.extend(found.into_iter().filter(|pair| pair.residual.unexplained.len() < least));
        }
        if let Some(best) = best_of(&pairs, |pair| pair.explains_all(&before)) {
            return equal(best, &[], size);
        }
        let most_left = MAX_LEFT * before.unexplained.len() as f64;
        let is_nearly_all = |candidate: &Candidate| candidate.residual.unexplained.len() as f64 <= most_left;
        let [single, pair] = [&candidates, &pairs].map(|all| best_of(all, is_nearly_all));
        if let Some(best) = pair.or(single) {
            return equal(best, &candidates, size);
        }
        let speckles = speckles(self, picture, &before.unexplained);
        if let Some(found) = speckles.or_else(|| partial_cause(&search, &candidates)) {
            return found;
        }
        if 2 * before.unexplained.len() <= before.visible.len() {
            return rounding();
        }
        let difference = difference_kind(self, picture, &before.unexplained).map(Box::new);
        Finding::Unknown { tried, difference }
    }

    /// Judges each of these mistakes together with `ground`. Returns the candidates, and how many could be made.
    fn candidates(&self, search: &Search, ground: &[Mistake], all: &[Mistake]) -> (Vec<Candidate>, usize) {
        let changes: Vec<Mistake> = match ground.is_empty() {
            true => Mistake::all().filter(|mistake| matches!(mistake.make, Make::Colors { .. })).collect(),
            false => vec![],
        };
        let (mut suspects, mut tried) = (vec![], 0);
        for mistake in all.iter().filter(|mistake| !ground.iter().any(|other| other.is_akin(mistake))) {
            if self.is_cancelled() {
                break;
            }
            let mistakes = [ground, std::slice::from_ref(mistake)].concat();
            let Some(variant) = Variant::new(self, &mistakes) else { continue };
            let changes_pixels = mistake.is_of_pixels() || !ground.is_empty();
            if !changes_pixels && variant.is_traced_as_original() {
                continue;
            }
            tried += 1;
            suspects.extend(search.suspects(&variant, &mistakes, &changes));
        }
        let judge = |Suspect { mistakes, .. }| {
            let variant = Variant::new(self, &mistakes)?;
            let rendering = Rendering::new(variant.picture()?);
            search.judge_whole(mistakes, rendering, Some(&variant))
        };
        (search.shortlist(suspects).into_iter().filter_map(judge).collect(), tried)
    }

    /// Returns the parts of the scene that may be missing where these pixels differ: objects, the first and the last
    /// triangles of objects, and lights.
    fn parts(&self, pixels: &[usize]) -> Vec<Mistake> {
        let scene = &self.renderer().scene;
        // A reduced picture has other pixels.
        let pixels = if self.request.is_reduced { &[] } else { pixels };
        let mut primitives: Vec<u32> = pixels.iter().filter_map(|&at| Some(self.seen_at(at)?.0)).collect();
        primitives.sort_unstable();
        primitives.dedup();
        let is_seen = |range: std::ops::Range<u32>| {
            primitives
                .get(primitives.partition_point(|&id| id < range.start))
                .is_some_and(|id| range.contains(id))
        };
        let mut placed: Vec<_> = self.objects.iter().collect();
        // Objects that are not seen may be missing in mirrors and among shadows.
        placed.sort_by_key(|object| (!is_seen(object.primitives.clone()), object.id));
        let mut parts = vec![];
        for object in placed.into_iter().filter(|object| !object.primitives.is_empty()).take(MAX_PARTS) {
            let (id, range, kind) = (object.id, object.primitives.clone(), scene.objects[object.id].name());
            let line = scene.positions.object(id).line;
            let without =
                |name, what: &str, part| Mistake::without(name, &format!("{what}the {kind}"), line, part);
            let triangle = |is_last| Part::Triangle { of: Some(id), is_last };
            parts.push(without("object_missing", "", Part::Object(id)));
            let has_several = range.len() > 1 && !matches!(scene.objects[id], Object::Box { .. });
            if has_several && is_seen(range.end - 1..range.end) {
                parts.push(without("last_triangle_missing", "the last triangle of ", triangle(true)));
            }
            if has_several && is_seen(range.start..range.start + 1) {
                parts.push(without("first_triangle_missing", "the first triangle of ", triangle(false)));
            }
        }
        for light in 0..scene.lights.len().min(MAX_PARTS) {
            let line = scene.positions.light(light).line;
            parts.push(Mistake::without("light_missing", "the light", line, Part::Light(light)));
        }
        parts
    }

    /// Returns the primitive that is seen through the centre of the pixel with this index, and its distance.
    fn seen_at(&self, at: usize) -> Option<(u32, f64)> {
        let [width, height] = self.request.size;
        let pixel = DVec2::new((at % width) as f64, (height - 1 - at / width) as f64);
        let ray = self.renderer().camera(&self.request).ray(pixel, DVec2::ZERO);
        let caster = self.prepared.caster(&self.patience).ok()?;
        let visible = caster.nearest(&ray, RayOrigin::FREE)?;
        Some((visible.primitive, caster.world.hit(&ray, visible).t))
    }

    fn renderer(&self) -> &Renderer {
        self.prepared.renderer()
    }
}

/// Returns the layer that is examined.
fn first_layer(request: &Request) -> Layer {
    request.layers.first().copied().unwrap_or(Layer::Color)
}

/// Returns true if the request's first layer shows the scene, and not something that is drawn in its place, and if a
/// mistake leaves the samples as they are. Adaptive samples depend on the colours, so a wrong picture has other samples
/// too.
pub(crate) fn can_try(renderer: &Renderer, request: &Request) -> bool {
    let layer = first_layer(request);
    let shows_scene = renderer.scene.shows == Shows::Scene && !request.draws_cells && layer.is_of_scene();
    shows_scene && (layer != Layer::Color || request.adaptive.is_none())
}

/// Returns the candidate that leaves the fewest pixels among those that are accepted.
fn best_of(candidates: &[Candidate], is_accepted: impl Fn(&Candidate) -> bool) -> Option<&Candidate> {
    let accepted = candidates.iter().filter(|candidate| is_accepted(candidate));
    accepted.min_by_key(|candidate| (candidate.left(), candidate.mistakes.len()))
}

/// Returns the finding that a candidate is all that is wrong, with the others that give the same picture.
fn equal(best: &Candidate, candidates: &[Candidate], size: [usize; 2]) -> Finding {
    let rest = Rounded::new(&best.residual, size[0]);
    let is_same = |other: &&Candidate| {
        let is_new = !other.mistakes[0].is_akin(&best.mistakes[0]);
        is_new && other.mistakes.len() == 1 && other.rendering.is_like(&best.rendering)
    };
    let mut same: Vec<Mistake> = vec![];
    for other in candidates.iter().filter(is_same).map(|other| &other.mistakes[0]) {
        if best.mistakes.len() == 1 && !same.iter().any(|named| named.is_akin(other)) {
            same.push(other.clone());
        }
    }
    let [cause, also @ ..] = best.mistakes.as_slice() else {
        return Finding::Equal { cause: Mistake::unchanged(), also: vec![], same, rest };
    };
    Finding::Equal { cause: cause.clone(), also: also.to_vec(), same, rest }
}

/// Returns the candidates to which others may be added.
fn grounds(candidates: &[Candidate]) -> Vec<&Candidate> {
    let mut grounds: Vec<&Candidate> =
        candidates.iter().filter(|candidate| candidate.mistakes.len() == 1).collect();
    grounds.sort_by_key(|candidate| candidate.left());
    grounds.truncate(MAX_GROUNDS);
    grounds
}

/// Finds why a picture differs from a reference: by other renderings of the scene, or by changes to the finished picture
/// if there is no original. `rendered` are the colours of the reference, if they are known. Pictures are judged by their
/// bytes, so a picture of numbers is never said to differ from another by rounding alone.
pub fn explain(
    original: Option<&Original>,
    reference: &Pixels,
    rendered: Option<&FloatPicture>,
    picture: &Pixels,
) -> Option<Finding> {
    let found = match original {
        Some(original) => original.explain(&picture.bytes()),
        None => explain_finished(&reference.bytes(), rendered, &picture.bytes()),
    };
    let are_numbers = matches!((reference, picture), (Pixels::Numbers(_), Pixels::Numbers(_)));
    (!are_numbers || !matches!(found, Finding::Rounding { .. })).then_some(found)
}

/// Finds why a picture differs from a finished one, whose scene is not known. `rendered` are its colours, or `None` if
/// only its bytes are known. Mistakes in converting colours to bytes are then not tried. Both have the same size.
fn explain_finished(reference: &Picture, rendered: Option<&FloatPicture>, picture: &Picture) -> Finding {
    let (size, picture) = (reference.size(), colors(picture));
    let own = rendered.cloned().unwrap_or_else(|| FloatPicture {
        size,
        colors: colors(reference).iter().copied().map(color_of).collect(),
    });
    let base = Rc::new(Rendering::new(own.clone()));
    let is_known =
        |mistake: &Mistake| mistake.is_of_pixels() && (rendered.is_some() || !mistake.needs_floats());
    let all: Vec<Mistake> = Mistake::all().filter(is_known).collect();
    let pairs = all.iter().flat_map(|one| all.iter().map(move |other| vec![one.clone(), other.clone()]));
    let pairs = pairs.filter(|pair| !pair[0].is_akin(&pair[1]));
    let every = all.iter().map(|one| vec![one.clone()]).chain(pairs);
    let before = rounding::residual(picture, &base, None);
    let search = Search::new(picture, base, size, &before, 1);
    let suspects = every.filter_map(|mistakes| search.suspect_by_pixel_changes(mistakes, &own));
    let judge = |Suspect { mistakes, .. }| {
        let mut changed = own.clone();
        PixelChanges::new(&mistakes).apply(&mut changed);
        search.judge_whole(mistakes, Rendering::new(changed), None)
    };
    let candidates: Vec<Candidate> =
        search.shortlist(suspects.collect()).into_iter().filter_map(judge).collect();
    let most_left = MAX_LEFT * before.unexplained.len() as f64;
    let explains_nearly_all = |candidate: &Candidate| {
        candidate.explains_all(&before) || candidate.residual.unexplained.len() as f64 <= most_left
    };
    let best = best_of(&candidates, explains_nearly_all).map(|best| equal(best, &[], size));
    let found = best.or_else(|| partial_cause(&search, &candidates));
    found.unwrap_or(Finding::Unknown { tried: all.len(), difference: None })
}
