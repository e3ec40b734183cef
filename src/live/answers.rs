//! Answers the questions of the page.

use super::camera_block::camera_block;
use super::cancel::Cancel;
use super::http::Refusal;
use super::limits::{BYTES_PER_PIXEL, MAX_SIDE};
use super::objects::ObjectMap;
use super::painter::{Easel, Painted, Subject, Unpainted};
use super::questions::{Asked, Edited, PageView, TracedPixel, Wanted, understood};
use super::rays::Rays;
use super::reference::{cause, compare, decode};
use super::saving::save;
use super::settings::{Most, command_line};
use super::stage::{OpenScene, SceneMessage, Stage};
use super::wire::Question;
use crate::cli::{Options, Output};
use crate::image_io::read_picture;
use crate::memory;
use crate::picture::{CHANNELS, Picture};
use crate::render::{Layer, Tracing, grid_view};
use crate::scene::Camera;
use crate::scene::model::Screen;
use crate::scene::parser::parse_camera;
use crate::tools::explain::{Explainer, Stop};
use crate::undisturbed::without_signals;
use rayon::ThreadPoolBuilder;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

/// How long the rays behind a pixel are followed, if the desk does not end it before.
const LONGEST_EXPLANATION: Duration = Duration::from_secs(60);

/// What a page is made of.
pub struct Setup<'o> {
    /// The command line. It has a page.
    pub options: &'o Options,
    /// Its scene.
    pub input: &'o Path,
    /// The flags that the page starts with.
    pub words: &'o [String],
}

/// Everything that the page can ask for.
pub struct App {
    input: PathBuf,
    /// The flags that the page starts with.
    words: Vec<String>,
    outputs: Vec<Output>,
    /// The pictures that the command line compares.
    compared: Vec<PathBuf>,
    most: Most,
    stage: Stage,
    reference: Option<Reference>,
}

struct Reference {
    name: String,
    picture: Picture,
}

/// A question with what it has brought along taken in.
pub struct Task {
    pub question: Question,
    /// The scene that it is about.
    pub scene: Arc<OpenScene>,
    /// Whether the scene that it has brought along is open.
    pub has_opened: bool,
    body: Vec<u8>,
    /// Why what it has brought along is useless.
    refused: Option<Found>,
}

/// A description in JSON and bytes, as in [`framed`].
type Found = Result<Vec<u8>, Refusal>;

/// A text that was opened, or the error in it.
type Typed = Result<Arc<OpenScene>, SceneMessage>;

impl App {
    /// Opens the command line's scene, from this text where it is known already; an error is a message.
    pub fn open(setup: &Setup, text: Option<String>) -> Result<Self, String> {
        let cores = || thread::available_parallelism().map_or(1, usize::from);
        let count = setup.options.threads.unwrap_or_else(cores);
        let threads = without_signals(|| ThreadPoolBuilder::new().num_threads(count).build());
        let threads = threads.map_err(|error| format!("error: cannot serve the page: {error}"))?;
        let stage = Stage::open(setup.input, text, &setup.options.hints(), Arc::new(threads))
            .map_err(|error| error.to_string())?;
        let comparison = setup.options.comparison.as_ref();
        let file = comparison.and_then(|wanted| wanted.picture.as_ref().or(wanted.reference.as_ref()));
        // One that cannot be read has been complained about.
        let reference = file.and_then(|path| {
            let name = path.to_string_lossy().into_owned();
            read_picture(path).ok().map(|picture| Reference { name, picture })
        });
        let largest = reference.iter().fold(setup.options.size, |size, reference| {
            let other = picture_size(&reference.picture);
            [size[0].max(other[0]), size[1].max(other[1])]
        });
        let compared = comparison.into_iter().flat_map(|wanted| [&wanted.picture, &wanted.reference]);
        Ok(Self {
            input: setup.input.to_owned(),
            words: setup.words.to_vec(),
            outputs: outputs(setup.options),
            compared: compared.flatten().cloned().collect(),
            most: Most::of(&Options { size: largest, ..setup.options.clone() }),
            stage,
            reference,
        })
    }

    /// The text of the command line's scene.
    pub fn text(&self) -> &str {
        &self.stage.first().renderer.source.text
    }

    /// Takes in what a question brings along.
    pub fn unpack(&mut self, (question, parts): (Question, Vec<Vec<u8>>)) -> Task {
        let mut parts = parts.into_iter();
        let body = parts.next().unwrap_or_default();
        let mut refused = None;
        let mut scene = self.stage.first().clone();
        if let Some(revision) = question.opens {
            match self.type_in(revision, &parts.next().unwrap_or_default()) {
                Ok(Ok(opened)) => scene = opened,
                Ok(Err(error)) if question.path == "/scene" => {
                    refused = Some(Ok(framed(json!({ "errors": [error] }), &[])));
                }
                // It was a scene before: a mesh is gone, or there is too little memory.
                Ok(Err(error)) => refused = Some(Err(impossible(error.problem))),
                Err(reason) => refused = Some(Err(reason)),
            }
        } else if let Some(open) =
            understood(&body).ok().and_then(|asked: Asked| self.stage.scene(asked.scene()))
        {
            scene = open;
        }
        let has_opened = question.opens.is_some() && refused.is_none();
        if let Some(name) = &question.reference {
            match decode(name, &parts.next().unwrap_or_default()) {
                Ok(picture) => self.reference = Some(Reference { name: name.clone(), picture }),
                Err(reason) => refused = Some(Err(impossible(reason))),
            }
        }
        Task { question, scene, has_opened, body, refused }
    }

    /// Opens the scene in a question of the page, in the edition that its flags name.
    fn type_in(&mut self, revision: u64, question: &[u8]) -> Result<Typed, Refusal> {
        let Edited { text, words } = understood(question)?;
        let options = self.most.options(&words).map_err(impossible)?;
        Ok(self.stage.type_in(revision, text, options.edition))
    }

    /// Answers a question about the scene that is on the easel.
    pub fn answer(&mut self, task: &mut Task, easel: &mut Easel, stop: &Cancel) -> Found {
        if let Some(refused) = task.refused.take() {
            return refused;
        }
        let body = &task.body;
        match task.question.path.as_str() {
            "/start" => Ok(framed(self.start(), &[])),
            "/scene" => Ok(framed(json!({ "scene": self.description(&task.scene) }), &[])),
            "/picture" => self.picture(understood(body)?, easel, stop),
            "/objects" => self.objects(understood(body)?),
            "/trace" => self.trace(understood(body)?),
            "/save" => self.save(understood(body)?, easel, stop),
            "/reference" => Ok(framed(self.reference.as_ref().map(summary).into(), &[])),
            "/compare" => self.compare(understood(body)?, easel, stop),
            "/cause" => self.cause(understood(body)?, easel, stop),
            _ => Err(Refusal::new(404, "there is nothing here")),
        }
    }

    fn start(&self) -> Value {
        let first = self.stage.first();
        let outputs: Vec<_> = self.outputs.iter().map(|output| output.file.to_string_lossy()).collect();
        let reference = self.reference.as_ref().map(summary);
        json!({
            "name": self.input.to_string_lossy(),
            "words": self.words(),
            "outputs": outputs,
            "text": first.renderer.source.text,
            "scene": self.description(first),
            "reference": reference,
            "most": self.most,
            "cell_colors": grid_view::SCALE.map(|color| color.map(|channel| (255.0 * channel) as u8)),
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    /// The flags that the page starts with. Their picture has the size of the one to compare with.
    fn words(&self) -> Vec<String> {
        let mut words = self.words.clone();
        let Some(wanted) = self.reference.as_ref().map(|reference| picture_size(&reference.picture)) else {
            return words;
        };
        let Ok(mut options) = self.most.options(&words) else { return words };
        if options.picture_size() == wanted {
            return words;
        }
        // The samples may enlarge or reduce the picture.
        let sizes = [wanted, wanted.map(|side| side / 3), wanted.map(|side| 3 * side)];
        let mut makes = |size| {
            options.size = size;
            options.picture_size() == wanted
        };
        let [width, height] = sizes.into_iter().find(|&size| makes(size)).unwrap_or(wanted);
        if let Some(start) = words.iter().position(|word| word == "-size") {
            let values = words[start + 1..].iter().take_while(|word| !word.starts_with('-')).count();
            words.drain(start..=start + values);
        }
        words.extend(["-size".to_owned(), width.to_string(), height.to_string()]);
        words
    }

    fn picture(&self, wanted: Wanted, easel: &mut Easel, stop: &Cancel) -> Found {
        let subject = Subject { sketch: wanted.sketch.map(clipped), ..self.subject(&wanted.view)? };
        let shown = subject.sketch.unwrap_or_else(|| subject.options.picture_size());
        let (camera, scene) = (subject.camera, subject.scene.clone());
        let painted = easel.paint(&subject, stop)?;
        let output = self.output(wanted.view.show.cost().map_or(Layer::Color, Layer::Cost));
        let output = output.map(|output| output.file.as_path());
        let cost = wanted.view.show.cost();
        let Painted { picture, costs, nans, time } = painted;
        let saturated = |&count: &u64| u32::try_from(count).unwrap_or(u32::MAX).to_le_bytes();
        let counts = costs.iter().flat_map(|report| report.map.counts.iter().flat_map(saturated));
        let counts: Vec<u8> = counts.collect();
        // A command that names the edition has nothing to say of it.
        let mut words = wanted.view.words;
        if scene.choice.because.is_some() {
            words.extend(["-edition".to_owned(), scene.choice.edition.to_string()]);
        }
        let meta = json!({
            "size": [picture.width(), picture.height()],
            "shows": shown,
            "milliseconds": time.as_secs_f64() * 1000.0,
            "nans": nans,
            "costs": costs.map(|report| report.to_string()),
            "command": command_line(&self.input, &words, cost, output),
            "camera": camera.as_ref().map(camera_block),
        });
        Ok(framed(meta, &[&rgba(&picture), &counts]))
    }

    fn objects(&self, view: PageView) -> Found {
        let subject = self.subject(&view)?;
        let size = clipped(subject.options.picture_size());
        let map = ObjectMap::new(&subject.scene.renderer, subject.camera, size).map_err(impossible)?;
        Ok(framed(json!({ "size": size, "objects": map.objects }), &[&map.places]))
    }

    fn trace(&self, TracedPixel { view, pixel }: TracedPixel) -> Found {
        let subject = self.subject(&view)?;
        let (options, renderer) = (&subject.options, &subject.scene.renderer);
        if options.reduced {
            return Err(impossible("the pixels of a picture that is reduced are not traced".into()));
        }
        let request = crate::render::Request {
            camera: subject.camera,
            layers: vec![Layer::Color],
            ..options.request()
        };
        let prepared = renderer.prepare_for(options.structure, &request, Tracing::Counted);
        let prepared = prepared.map_err(|error| impossible(error.to_string()))?;
        let explainer = Explainer::new(&prepared).map_err(|error| impossible(error.to_string()))?;
        let stop = Stop::at(Instant::now() + LONGEST_EXPLANATION);
        let tree = explainer.pixel(&request, pixel, &stop).map_err(|error| impossible(error.to_string()))?;
        let rays = Rays::of(&tree, renderer.bounds(), prepared.cells());
        Ok(framed(json!({ "pixel": pixel, "rays": rays }), &[]))
    }

    fn save(&self, view: PageView, easel: &mut Easel, stop: &Cancel) -> Found {
        let subject = self.subject(&view)?;
        let said = save(&subject, &self.outputs, &self.compared, &mut |subject| easel.paint(subject, stop))
            .map_err(impossible)?;
        Ok(framed(json!({ "said": said }), &[]))
    }

    fn compare(&self, wanted: Wanted, easel: &mut Easel, stop: &Cancel) -> Found {
        let (reference, own, subject) = self.pair(&wanted, easel, stop)?;
        let picture = &reference.picture;
        let compared = subject.scene.renderer.on_own_threads(|| compare(picture, &own));
        let (block, amplification, difference) = compared.map_err(impossible)?;
        let meta = json!({
            "size": picture_size(picture), "block": block, "amplification": amplification, "name": reference.name,
        });
        Ok(framed(meta, &[&rgba(picture), &rgba(&own), &rgba(&difference)]))
    }

    fn cause(&self, wanted: Wanted, easel: &mut Easel, stop: &Cancel) -> Found {
        let (reference, own, subject) = self.pair(&wanted, easel, stop)?;
        if picture_size(&reference.picture) != picture_size(&own) {
            return Err(impossible("the pictures differ in size".into()));
        }
        Ok(framed(json!({ "cause": cause(&reference.picture, &own, &subject) }), &[]))
    }

    /// The picture from elsewhere, and the view's.
    fn pair(
        &self,
        wanted: &Wanted,
        easel: &mut Easel,
        stop: &Cancel,
    ) -> Result<(&Reference, Picture, Subject), Refusal> {
        let reference = self.reference.as_ref();
        let reference = reference.ok_or_else(|| impossible("there is no picture to compare with".into()))?;
        // Costs are no colours, and their map has a scale beside it.
        let subject = Subject { cost: None, ..self.subject(&wanted.view)? };
        let own = easel.paint(&subject, stop)?.picture;
        Ok((reference, own, subject))
    }

    /// What the page needs to know of a scene to turn it, and of the edition that it was read in.
    fn description(&self, scene: &OpenScene) -> Value {
        let (renderer, choice) = (&scene.renderer, &scene.choice);
        let defaults = self.most.options(&[]).map(|options| options.in_edition(choice.edition).effects);
        let defaults = defaults.unwrap_or_default();
        json!({
            "revision": scene.revision,
            "camera": camera_values(&renderer.scene.camera, renderer.scene.model.screen),
            "bounds": renderer.bounds(),
            "is_unlit": renderer.scene.lights.is_empty(),
            "edition": choice.edition,
            "note": choice.note().or_else(|| choice.doubt().map(|doubt| doubt.join("; "))),
            "defaults": { "bounces": defaults.bounces, "weight": defaults.min_weight },
        })
    }

    fn output(&self, layer: Layer) -> Option<&Output> {
        self.outputs.iter().find(|output| output.layer == layer)
    }

    fn subject(&self, view: &PageView) -> Result<Subject, Refusal> {
        let scene = self.stage.scene(view.scene).ok_or_else(|| Refusal::new(410, "the scene is closed"))?;
        let options = self.most.options(&view.words).map_err(impossible)?;
        if options.edition != scene.named {
            return Err(Refusal::new(410, "the scene is open in another edition"));
        }
        let options = options.in_edition(scene.choice.edition);
        let pixels = options.request().size.iter().map(|&side| side as u64).product::<u64>();
        memory::ask(pixels * BYTES_PER_PIXEL).map_err(|error| impossible(error.to_string()))?;
        let camera = view.camera.as_deref().map(read_camera).transpose()?;
        Ok(Subject { scene, options, camera, cost: view.show.cost(), sketch: None })
    }
}

/// The pictures that a page can write. It renders no part of a picture, and standard output is another reader's.
fn outputs(line: &Options) -> Vec<Output> {
    let named = line.outputs.iter().filter(|output| !output.is_standard_output() && line.region.is_none());
    named.cloned().collect()
}

fn read_camera(block: &str) -> Result<Camera, Refusal> {
    parse_camera(block).map_err(|error| impossible(format!("the camera: {error}")))
}

fn impossible(reason: String) -> Refusal {
    Refusal::new(422, reason)
}

impl From<Unpainted> for Refusal {
    fn from(reason: Unpainted) -> Self {
        impossible(reason.to_string())
    }
}

/// How the page shows a scene's camera, whose view is spread over the pixels in this way.
fn camera_values(camera: &Camera, screen: Screen) -> Value {
    let (is_stretched, up_as_written) = match screen {
        Screen::LongerSide => (false, false),
        Screen::BothSides { up_as_written } => (true, up_as_written),
    };
    match *camera {
        Camera::Orthographic { center, direction, up, size } => {
            json!({ "kind": "orthographic", "center": center, "direction": direction, "up": up, "size": size })
        }
        Camera::Perspective { center, direction, up, angle } => json!({
            "kind": "perspective", "center": center, "direction": direction, "up": up, "angle": angle,
            "is_stretched": is_stretched, "up_as_written": up_as_written,
        }),
    }
}

fn summary(reference: &Reference) -> Value {
    json!({ "name": reference.name, "size": picture_size(&reference.picture) })
}

fn picture_size(picture: &Picture) -> [usize; 2] {
    [picture.width() as usize, picture.height() as usize]
}

fn clipped(size: [usize; 2]) -> [usize; 2] {
    size.map(|side| side.clamp(1, MAX_SIDE))
}

/// Red, green, blue and an opaque alpha, as a canvas takes them.
fn rgba(picture: &Picture) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(picture.pixels().len() / CHANNELS * 4);
    for &[red, green, blue] in picture.pixels().as_chunks().0 {
        bytes.extend_from_slice(&[red, green, blue, u8::MAX]);
    }
    bytes
}

/// A description in JSON and the bytes that it describes: the length of the first as four bytes, the lowest one first,
/// and then both.
pub fn framed(meta: Value, parts: &[&[u8]]) -> Vec<u8> {
    let meta = meta.to_string().into_bytes();
    let mut body = Vec::with_capacity(4 + meta.len() + parts.iter().map(|part| part.len()).sum::<usize>());
    body.extend((meta.len() as u32).to_le_bytes());
    body.extend(meta);
    parts.iter().for_each(|part| body.extend_from_slice(part));
    body
}
