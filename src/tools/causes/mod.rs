//! Finds why a picture differs from this program's, by trying common mistakes in ray tracers one after the other.
//!
//! Each [`Mistake`] produces a wrong picture: by changing the finished picture, the request or the scene, or by a
//! student's tracer with a switch for each mistake. A search judges which of these pictures is the examined one.

mod changes;
mod finding;
mod mistakes;
mod object_space;
pub(crate) mod paint;
mod search;
mod speckles;
pub(crate) mod student;
#[cfg(test)]
mod tests;
mod transforms;
mod window;

pub(crate) use changes::has_secondary_rays;
pub use finding::Finding;
pub use mistakes::{Mistake, OppositeFaces};
pub use student::SelfHitting;

use crate::caster::choose::Rays;
use crate::picture::{Color, FloatPicture, Picture, Window};
use crate::render::renderer::{Prepared, Renderer};
use crate::render::{Layer, Progress, Request, Tracing, Watch};
use crate::scene::model::Shows;
use crate::tools::compare::colors;
use mistakes::Make;
use object_space::ObjectSpaces;
use search::{Made, Search, try_all};
use speckles::speckles;
use std::borrow::Cow;
use std::ops::ControlFlow;
use std::rc::Rc;
use student::{MAX_BOUNCES, Student};
use window::{flipped, part_of_colors, telling_windows};

/// About how many camera rays the windows of successive searches have.
const RAYS_OF_WINDOWS: [usize; 2] = [1 << 9, 1 << 12];

/// The shortest side of a window, in pixels. Fewer pixels show too little.
const MIN_SIDE: usize = 8;

/// The largest number of mistakes of which each is tried together with all others.
const MAX_GROUNDS: usize = 3;

/// This program's picture, with its renderer and request.
pub struct Original<'a> {
    prepared: Prepared<'a>,
    watch: Watch<'a>,
    /// The request. Its window is the part of the picture used to judge causes.
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
        let layer = request.layers.first().copied().unwrap_or(Layer::Color);
        let request =
            Request { layers: vec![layer], tracing: Tracing::Fast, window: None, ..request.clone() };
        if !can_try(renderer, &request) {
            return None;
        }
        // The tracer casts all rays, even those that the renderer can skip.
        let prepared = renderer.prepare_for(&request, Rays::cast(request.camera_rays())).ok()?;
        let colors = rendered(&prepared, &request, watch)?;
        Some(Self { prepared, watch, request, colors })
    }

    /// Returns true if the watch has cancelled the search.
    fn is_cancelled(&self) -> bool {
        (self.watch)(Progress { done: 0, rows: 0, rays: 0 }).is_break()
    }

    /// Returns the picture with the mistake. `None` if it cannot be made.
    pub fn picture(&self, mistake: Mistake) -> Option<Picture> {
        Some(self.made(&[mistake], None)?.to_picture())
    }

    /// Returns the colours of a window with all of these mistakes. `None` if they cannot be made together.
    fn made(&self, mistakes: &[Mistake], window: Option<Window>) -> Option<FloatPicture> {
        if self.is_cancelled() {
            return None;
        }
        // A flip moves pixels into the window from another one.
        let window = window.map(|window| flipped(window, self.request.size, flips(mistakes)));
        let request = Request { window, ..self.request.clone() };
        let changed = Changed::new(self.renderer(), &request, mistakes)?;
        let mut colors = match (changed.is_unchanged(&request), window) {
            (true, None) => self.colors.clone(),
            (true, Some(window)) => part_of_colors(&self.colors, window),
            (false, _) => changed.render(self)?,
        };
        finish(mistakes, &mut colors);
        Some(colors)
    }

    /// Finds why each wrong picture differs from the reference `b`. All have the original's size. The mistakes in
    /// `first` are tried first, and together with all others.
    ///
    /// Tries mistakes in the finished picture first. Then searches in a window of about five hundred camera rays where
    /// many pixels differ, and checks the likely findings on the whole picture. Pictures that remain unexplained are
    /// searched for two mistakes, and in a larger window.
    fn explain_all_with(&self, wrong: &[Picture], b: &Picture, first: &[Mistake]) -> Vec<Finding> {
        let reference = if self.colors.to_picture() == *b { &self.colors } else { &of_bytes(b) };
        let made = Rc::new(Made::new(reference));
        let search = |wrong| Search::new(Cow::Borrowed(wrong), made.clone());
        let mut searches: Vec<Search> = wrong.iter().map(search).collect();
        let first = &first[..first.len().min(MAX_GROUNDS)];
        let alone = |mistake| vec![mistake];
        let (of_pixels, others): (Vec<Mistake>, Vec<Mistake>) =
            Mistake::all().partition(|mistake| mistake.is_of_pixels());
        let others: Vec<Vec<Mistake>> = others.into_iter().map(alone).collect();
        let learned: Vec<Vec<Mistake>> = first.iter().copied().map(alone).collect();
        self.try_all(None, of_pixels.chunks(1), &mut searches.iter_mut().collect::<Vec<_>>());
        let mut sides = RAYS_OF_WINDOWS.map(|rays| self.side_of_windows(rays)).to_vec();
        sides.dedup();
        self.search(&learned, sides[0], &mut searches);
        for side in sides {
            self.search(&others, side, &mut searches);
            let pairs = pairs(&searches, first);
            self.search(&pairs, side, &mut searches);
        }
        let finding = |(search, wrong): (&Search, _)| match search.finding() {
            Finding::Unknown { tried } => speckles(self, wrong, b).unwrap_or(Finding::Unknown { tried }),
            found => found,
        };
        searches.iter().zip(wrong).map(finding).collect()
    }

    /// Returns the side of windows with about this many camera rays, in pixels. `None` if the whole picture is small, or
    /// if it is reduced and so needs the pixels around the window.
    fn side_of_windows(&self, rays: usize) -> Option<usize> {
        let is_whole = self.request.camera_rays() <= rays || self.request.is_reduced;
        let side = (rays / self.request.sampler.count() as usize).isqrt().max(MIN_SIDE);
        (!is_whole).then_some(side)
    }

    /// Tries mistakes in windows with this side, and the likely ones on the whole picture. Without a side, tries them all
    /// on the whole picture.
    fn search(&self, all: &[Vec<Mistake>], side: Option<usize>, searches: &mut [Search]) {
        let all = || all.iter().map(Vec::as_slice);
        let mut open: Vec<&mut Search> = searches.iter_mut().filter(|search| !search.is_settled()).collect();
        let Some(side) = side else { return self.try_all(None, all(), &mut open) };
        let left: Vec<Vec<u8>> = open.iter().map(|search| search.left()).collect();
        for (window, pictures) in telling_windows(&left, self.request.size, side) {
            let reference = Rc::new(open[0].reference().in_window(window));
            let in_window = |&at: &usize| open[at].in_window(window, reference.clone());
            let mut parts: Vec<Search> = pictures.iter().map(in_window).collect();
            self.try_all(Some(window), all(), &mut parts.iter_mut().collect::<Vec<_>>());
            for (&at, part) in pictures.iter().zip(&parts) {
                self.try_all(None, part.likely(), &mut [&mut *open[at]]);
                open[at].add_shown(part.shown());
            }
        }
    }

    fn try_all<'m>(
        &self,
        window: Option<Window>,
        all: impl IntoIterator<Item = &'m [Mistake]>,
        searches: &mut [&mut Search],
    ) {
        try_all(all, |mistakes| self.made(mistakes, window), searches);
    }

    fn layer(&self) -> Layer {
        self.request.layers.first().copied().unwrap_or(Layer::Color)
    }

    fn renderer(&self) -> &Renderer {
        self.prepared.renderer()
    }
}

/// Returns true if the request's first layer shows the scene, and not something that is drawn in its place, and if a
/// mistake leaves the samples as they are. Adaptive samples depend on the colours, so a wrong picture has other samples
/// too.
pub(crate) fn can_try(renderer: &Renderer, request: &Request) -> bool {
    let layer = request.layers.first().copied().unwrap_or(Layer::Color);
    let shows_scene = renderer.scene.shows == Shows::Scene && !request.draws_cells && layer.is_of_scene();
    shows_scene && (layer != Layer::Color || request.adaptive.is_none())
}

/// Returns pairs of mistakes to try: the best ones of unexplained pictures and the `first` ones, each with all others
/// that show.
fn pairs(searches: &[Search], first: &[Mistake]) -> Vec<Vec<Mistake>> {
    let open = || searches.iter().filter(|search| !search.is_settled());
    let mut grounds = distinct(open().filter_map(Search::best).chain(first.iter().copied()));
    grounds.truncate(MAX_GROUNDS);
    let shows = |mistake: &Mistake| open().any(|search| search.shown().contains(mistake));
    let others: Vec<Mistake> = Mistake::all().skip(1).filter(shows).collect();
    let with_others = |&ground: &Mistake| {
        let others = others.iter().filter(move |other| !ground.is_akin(**other));
        others.map(move |&other| vec![ground, other])
    };
    grounds.iter().flat_map(with_others).collect()
}

/// Returns these mistakes in their order, each once.
pub(crate) fn distinct(mistakes: impl IntoIterator<Item = Mistake>) -> Vec<Mistake> {
    let mut distinct = vec![];
    for mistake in mistakes {
        if !distinct.contains(&mistake) {
            distinct.push(mistake);
        }
    }
    distinct
}

/// The changes that mistakes make before a picture is rendered.
struct Changed {
    /// The renderer of another scene.
    renderer: Option<Renderer>,
    request: Request,
    /// The mistake of a student's tracer.
    switch: Option<Mistake>,
}

impl Changed {
    /// Makes these mistakes. `None` if one tracer cannot make them.
    fn new(original: &Renderer, request: &Request, mistakes: &[Mistake]) -> Option<Self> {
        let (mut scene, mut changed, mut switch) = (original.scene.clone(), request.clone(), None);
        for &mistake in mistakes {
            match mistake.make() {
                Make::Colors(_) | Make::Flip(_) => {}
                Make::Request(change) => change(&mut changed, &scene),
                Make::Scene(change) => change(&mut scene),
                Make::Text(change) => change(&mut scene, &original.source.text),
                Make::Student if switch.is_some() => return None,
                Make::Student => switch = Some(mistake),
            }
        }
        // The scene's own camera is none of the request's.
        if changed.camera == Some(original.scene.camera) {
            changed.camera = request.camera;
        }
        if switch.is_some() && request.effects.bounces > MAX_BOUNCES && has_secondary_rays(&scene) {
            return None;
        }
        let is_changed = scene != original.scene;
        let renderer = is_changed.then(|| original.with_scene(scene)).transpose().ok()?;
        Some(Self { renderer, request: changed, switch })
    }

    fn is_unchanged(&self, request: &Request) -> bool {
        self.renderer.is_none() && self.switch.is_none() && self.request == *request
    }

    /// Renders the picture. `None` if it is cancelled, or memory is too small.
    fn render(&self, original: &Original) -> Option<FloatPicture> {
        let prepared = match &self.renderer {
            Some(renderer) => &renderer.prepare(&self.request).ok()?,
            None => &original.prepared,
        };
        if self.switch.is_none() {
            return rendered(prepared, &self.request, original.watch);
        }
        let (renderer, hits) = (prepared.renderer(), prepared.caster());
        let spaces = &ObjectSpaces::new(&renderer.scene, original.renderer().meshes(), hits.world);
        let student = Student::new(renderer, hits, self.request.effects);
        let student = Student { mistake: self.switch, spaces: Some(spaces), ..student };
        paint::colors(&student, &self.request, &|| original.is_cancelled()).ok()
    }
}

/// Returns true if these mistakes flip the picture left to right, and if they flip it upside down.
fn flips(mistakes: &[Mistake]) -> [bool; 2] {
    mistakes.iter().fold([false; 2], |all, mistake| match mistake.make() {
        Make::Flip(flips) => [all[0] ^ flips[0], all[1] ^ flips[1]],
        _ => all,
    })
}

/// Makes the mistakes of these that change finished pictures.
fn finish(mistakes: &[Mistake], picture: &mut FloatPicture) {
    let [across, down] = flips(mistakes);
    if across {
        picture.colors.chunks_exact_mut(picture.size[0]).for_each(<[Color]>::reverse);
    }
    if down {
        let rows = picture.colors.chunks_exact(picture.size[0]).rev();
        picture.colors = rows.flatten().copied().collect();
    }
    for mistake in mistakes {
        if let Make::Colors(change) = mistake.make() {
            picture.colors.iter_mut().for_each(|color| *color = change(*color));
        }
    }
}

/// Returns colours that are cut to these bytes. Halfway between two bytes, no rounding changes them.
fn of_bytes(picture: &Picture) -> FloatPicture {
    let size = [picture.width() as usize, picture.height() as usize];
    let color = |pixel: &[u8; 3]| Color::from_array(pixel.map(|byte| (f64::from(byte) + 0.5) / 255.0));
    FloatPicture { size, colors: colors(picture).iter().map(color).collect() }
}

/// Finds why pictures differ from a finished one, whose scene is not known. `colors` are its colours, or `None` if only
/// its bytes are known. Mistakes in converting colours to bytes are then not tried. All pictures have the same size.
pub fn explain_finished(
    reference: &Picture,
    rendered: Option<&FloatPicture>,
    wrong: &[Picture],
) -> Vec<Finding> {
    let colors = rendered.map_or_else(|| Cow::Owned(of_bytes(reference)), Cow::Borrowed);
    let made = Rc::new(Made::new(&colors));
    let mut searches: Vec<Search> =
        wrong.iter().map(|wrong| Search::new(Cow::Borrowed(wrong), made.clone())).collect();
    let all: Vec<Mistake> = Mistake::of_pixels(rendered.is_some()).collect();
    let make = |mistakes: &[Mistake]| {
        let mut colors = colors.clone().into_owned();
        finish(mistakes, &mut colors);
        Some(colors)
    };
    try_all(all.chunks(1), make, &mut searches.iter_mut().collect::<Vec<_>>());
    searches.iter().map(Search::finding).collect()
}

/// Renders the request's only layer. `None` if memory is too small or the watch cancels.
fn rendered(prepared: &Prepared, request: &Request, watch: Watch) -> Option<FloatPicture> {
    prepared.render_layer(request, watch).ok().map(|(picture, _)| picture)
}

// STUB, to be replaced at the merge: the interface that `command/compare`, `tools/grade` and `live` use.
impl Original<'_> {
    /// Returns this program's picture.
    pub fn colors(&self) -> &FloatPicture {
        &self.colors
    }

    /// Finds why a picture of the original's size differs from it.
    pub fn explain(&self, picture: &Picture) -> Finding {
        if *picture == self.colors.to_picture() {
            // A picture that equals this program's, but not the reference of a file.
            let (cause, also, same) = (Mistake::Unchanged, vec![], vec![]);
            return Finding::Equal { cause, also, same, pixels: 0, by_more_than_one_level: 0, at_edges: 0 };
        }
        self.explain_all(std::slice::from_ref(picture)).pop().unwrap_or(Finding::Unknown { tried: 0 })
    }

    /// Finds why each of these pictures of the original's size differs from it.
    pub fn explain_all(&self, pictures: &[Picture]) -> Vec<Finding> {
        self.explain_all_with(pictures, &self.colors.to_picture(), &[])
    }

    /// Returns the number of pixels whose difference rounding of single precision does not explain.
    pub fn unexplained(&self, picture: &Picture) -> u64 {
        let own = self.colors.to_picture();
        let pairs = colors(picture).iter().zip(colors(&own));
        let beyond = |(a, b): &(&_, &_)| crate::tools::compare::largest_channel_difference(**a, **b) > 1;
        pairs.filter(beyond).count() as u64
    }
}
