//! Finds why a picture differs from this program's, by trying common mistakes in ray tracers one after the other.
//!
//! Each [`Mistake`] produces a wrong picture: by changing the finished picture, the request or the scene, or by a
//! student's tracer with a switch for each mistake. A search judges which of these pictures is the examined one.

mod changes;
mod finding;
mod mistakes;
mod object_space;
mod paint;
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

use crate::caster::choose::{Rays, Structure};
use crate::picture::{Color, FloatPicture, Picture, Window};
use crate::render::renderer::{Prepared, Renderer};
use crate::render::{Layer, Progress, Request, Tracing, Watch};
use crate::tools::compare::colors;
use mistakes::{Make, Setting};
use object_space::ObjectSpaces;
use search::{Made, Search, try_all};
use speckles::{Speckles, can_show, speckles};
use std::borrow::Cow;
use std::ops::ControlFlow;
use std::rc::Rc;
use student::{MAX_BOUNCES, Student};
use window::{part, part_of_colors, telling_windows};

/// Upper bounds on the camera rays in the windows of successive searches.
const RAYS_OF_WINDOWS: [usize; 2] = [1 << 11, 1 << 15];

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
    /// Renders the request's first layer, or its colours if there is none, with this structure. `None` if memory is too
    /// small. The renderer must have kept the meshes.
    pub fn new(renderer: &'a Renderer, structure: Structure, request: &Request) -> Option<Self> {
        Self::watched(renderer, structure, request, &|_| ControlFlow::Continue(()))
    }

    /// Renders like [`new`](Self::new), and lets `watch` cancel. After that the search ends soon, with an unspecified
    /// result. `None` also if it is cancelled during this call.
    pub fn watched(
        renderer: &'a Renderer,
        structure: Structure,
        request: &Request,
        watch: Watch<'a>,
    ) -> Option<Self> {
        let layer = request.layers.first().copied().unwrap_or(Layer::Color);
        let (layers, tracing, draws_cells) = (vec![layer], Tracing::Fast, false);
        let request = Request { layers, tracing, draws_cells, structure, window: None, ..request.clone() };
        // The tracer casts all rays, even those that the renderer can skip.
        let prepared = renderer.prepare_for(&request, Rays::cast(request.camera_rays())).ok()?;
        let colors = rendered(&prepared, &request, watch)?;
        Some(Self { prepared, watch, request, colors })
    }

    /// Returns true if the watch has cancelled the search.
    fn is_cancelled(&self) -> bool {
        (self.watch)(Progress { done: 0, rows: 0, rays: 0 }).is_break()
    }

    /// Returns the picture with the mistake. `None` if this scene or request cannot show the mistake.
    pub fn picture(&self, mistake: Mistake) -> Option<Picture> {
        Some(self.made(&[mistake], None)?.to_picture())
    }

    /// Returns the colours of a window with all of these mistakes. `None` if this scene or request cannot show one.
    fn made(&self, mistakes: &[Mistake], window: Option<Window>) -> Option<FloatPicture> {
        if self.is_cancelled() || !mistakes.iter().all(|mistake| mistake.shows_in(self.layer())) {
            return None;
        }
        let part = |colors| {
            window.map_or(Cow::Borrowed(colors), |window| Cow::Owned(part_of_colors(colors, window)))
        };
        let moves = mistakes.iter().any(|mistake| matches!(mistake.make(), Some(Make::Pixels(_))));
        if mistakes.iter().all(|mistake| mistake.is_of_pixels()) {
            return Some(match moves {
                true => part(&finished(mistakes, self.colors.clone())).into_owned(),
                false => finished(mistakes, part(&self.colors).into_owned()),
            });
        }
        // Pixels may move into the window.
        let request = Request { window: window.filter(|_| !moves), ..self.request.clone() };
        let changed = Changed::new(self.renderer(), &request, mistakes)?;
        let prepared = match &changed.renderer {
            Some(renderer) => &renderer.prepare(&changed.request).ok()?,
            None => &self.prepared,
        };
        let colors = match changed.switch {
            Some(mistake) => {
                let hits = prepared.caster();
                let spaces =
                    &ObjectSpaces::new(&prepared.renderer().scene, self.renderer().meshes(), hits.world);
                let student = Student {
                    mistake: Some(mistake),
                    ..Student::new(prepared.renderer(), hits, changed.request.effects, spaces)
                };
                paint::colors(&student, prepared.renderer(), &changed.request, &|| self.is_cancelled())
                    .ok()?
            }
            None => rendered(prepared, &changed.request, self.watch)?,
        };
        let colors = finished(mistakes, colors);
        Some(if moves { part(&colors).into_owned() } else { colors })
    }

    /// Finds why the picture `a` differs from the reference `b`. Both have the original's size.
    pub fn explain(&self, a: &Picture, b: &Picture) -> Finding {
        self.explain_all(std::slice::from_ref(a), b, &[]).pop().unwrap_or(Finding::Unknown { tried: 0 })
    }

    /// Finds why each wrong picture differs from the reference `b`. All have the original's size. The mistakes in `first`
    /// are tried first, and together with all others.
    ///
    /// Searches first in a window of about two thousand camera rays where many pixels differ, and checks each finding
    /// on the whole picture. Pictures that remain unexplained are searched for two mistakes, and in a larger window.
    pub fn explain_all(&self, wrong: &[Picture], b: &Picture, first: &[Mistake]) -> Vec<Finding> {
        let reference = if self.colors.to_picture() == *b { &self.colors } else { &of_bytes(b) };
        let made = Rc::new(Made::new(reference));
        let search = |wrong| Search::new(Cow::Borrowed(wrong), made.clone());
        let mut searches: Vec<Search> = wrong.iter().map(search).collect();
        let first = &first[..first.len().min(MAX_GROUNDS)];
        let all: Vec<Mistake> = Mistake::all().collect();
        self.try_all(None, first.chunks(1), searches.iter_mut());
        for rays in RAYS_OF_WINDOWS {
            self.search(reference, &all.chunks(1).collect::<Vec<_>>(), rays, &mut searches);
            let open = searches.iter().filter(|search| !search.is_settled());
            let mut grounds: Vec<Mistake> =
                open.filter_map(Search::best).chain(first.iter().copied()).collect();
            grounds.dedup();
            grounds.truncate(MAX_GROUNDS);
            let pairs = grounds.iter().flat_map(|&ground| all[1..].iter().map(move |&other| [ground, other]));
            let pairs: Vec<[Mistake; 2]> = pairs.filter(|[one, other]| !one.is_akin(*other)).collect();
            self.search(
                reference,
                &pairs.iter().map(<[_; 2]>::as_slice).collect::<Vec<_>>(),
                rays,
                &mut searches,
            );
            if self.request.camera_rays() <= rays {
                break;
            }
        }
        searches
            .iter()
            .zip(wrong)
            .map(|(search, wrong)| self.or_speckles(search.finding(), wrong, b))
            .collect()
    }

    /// Tries mistakes in windows of at most `rays` camera rays, and the likely ones on the whole picture.
    fn search(&self, reference: &FloatPicture, all: &[&[Mistake]], rays: usize, searches: &mut [Search]) {
        let mut open: Vec<&mut Search> = searches.iter_mut().filter(|search| !search.is_settled()).collect();
        // A reduced picture needs the pixels around the window.
        if self.request.camera_rays() <= rays || self.request.is_reduced {
            return self.try_all(None, all.iter().copied(), open.into_iter());
        }
        let pixels = rays / self.request.sampler.count() as usize;
        for (window, pictures) in telling_windows(&open, self.request.size, pixels) {
            let made = Rc::new(Made::new(&part_of_colors(reference, window)));
            let in_window =
                |&at: &usize| Search::new(Cow::Owned(part(open[at].wrong(), window)), made.clone());
            let mut parts: Vec<Search> = pictures.iter().map(in_window).collect();
            self.try_all(Some(window), all.iter().copied(), parts.iter_mut());
            for (&at, part) in pictures.iter().zip(&parts) {
                self.try_all(None, part.likely(), std::iter::once(&mut *open[at]));
                open[at].count_tried(part);
            }
        }
    }

    fn try_all<'m, 's, 'p: 's>(
        &self,
        window: Option<Window>,
        all: impl IntoIterator<Item = &'m [Mistake]>,
        searches: impl Iterator<Item = &'s mut Search<'p>>,
    ) {
        try_all(all, |mistakes| self.made(mistakes, window), &mut searches.collect::<Vec<_>>());
    }

    /// Returns the finding, or speckles if nothing was found. The pictures are whole.
    fn or_speckles(&self, found: Finding, a: &Picture, b: &Picture) -> Finding {
        let Finding::Unknown { tried } = found else { return found };
        let tried = tried + usize::from(can_show(self));
        let found = speckles(self, a, b);
        found.map_or(Finding::Unknown { tried }, |Speckles { pixels, rays }| Finding::Speckles {
            pixels,
            rays,
        })
    }

    fn layer(&self) -> Layer {
        self.request.layers.first().copied().unwrap_or(Layer::Color)
    }

    fn renderer(&self) -> &Renderer {
        self.prepared.renderer()
    }
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
    /// Makes these mistakes. `None` if the scene or the request cannot show one of them.
    fn new(original: &Renderer, request: &Request, mistakes: &[Mistake]) -> Option<Self> {
        let (mut scene, mut request, mut switch) = (Cow::Borrowed(&original.scene), request.clone(), None);
        for &mistake in mistakes {
            match mistake.make()? {
                Make::Levels(_) | Make::Pixels(_) => {}
                Make::Camera(change) => {
                    let camera = request.camera.unwrap_or(scene.camera);
                    request.camera = Some(change(camera, scene.screen, request.size)?);
                }
                Make::Effects(change) => {
                    let before = request.effects;
                    change(&mut request.effects, &scene);
                    (request.effects != before).then_some(())?;
                }
                Make::Scene(change) => change(scene.to_mut()).then_some(())?,
                Make::Text(change) => scene = Cow::Owned(change(&scene, &original.source.text)?),
                Make::Student(shows) => {
                    let setting = Setting { scene: &scene, request: &request };
                    (setting.bounces() <= MAX_BOUNCES && shows(&setting)).then_some(())?;
                    switch.replace(mistake).is_none().then_some(())?;
                }
            }
        }
        let renderer = match scene {
            Cow::Owned(scene) => Some(original.with_scene(scene).ok()?),
            Cow::Borrowed(_) => None,
        };
        Some(Self { renderer, request, switch })
    }
}

/// Makes the mistakes of these that change finished pictures.
fn finished(mistakes: &[Mistake], mut picture: FloatPicture) -> FloatPicture {
    for mistake in mistakes {
        match mistake.make() {
            Some(Make::Levels(change)) => {
                let changed = |color: &mut Color| *color = (255.0 * *color).map(change) / 255.0;
                picture.colors.iter_mut().for_each(changed);
            }
            Some(Make::Pixels(change)) => change(&mut picture.colors, picture.size[0]),
            _ => {}
        }
    }
    picture
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
    let make = |mistakes: &[Mistake]| Some(finished(mistakes, colors.clone().into_owned()));
    try_all(all.chunks(1), make, &mut searches.iter_mut().collect::<Vec<_>>());
    searches.iter().map(Search::finding).collect()
}

/// Renders the request's only layer. `None` if memory is too small or the watch cancels.
fn rendered(prepared: &Prepared, request: &Request, watch: Watch) -> Option<FloatPicture> {
    let mut picture = FloatPicture::with_room(request.layer_size(request.layers.first()?)).ok()?;
    let mut take_row = |_: usize, row: &[Color]| {
        picture.colors.extend_from_slice(row);
        ControlFlow::Continue(())
    };
    prepared.render_rows(request, watch, &mut take_row).ok()?;
    Some(picture)
}
