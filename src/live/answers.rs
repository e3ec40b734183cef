//! Answers the questions of the page.

use super::camera_block::camera_block;
use super::http::{Answer, Refusal};
use super::limits::{BYTES_PER_PIXEL, MAX_PICTURE_FILE, MAX_QUESTION, MAX_SIDE};
use super::objects::ObjectMap;
use super::painter::{Painted, Painter, Subject, Unpainted};
use super::questions::{Edited, PageView, TracedPixel, Wanted};
use super::rays::Rays;
use super::reference::{cause, compare, decode};
use super::saving::save;
use super::server::Setup;
use super::settings::{Most, command_line};
use super::stage::{OpenScene, Stage};
use crate::cli::{Options, Output};
use crate::image_io::read_picture;
use crate::memory;
use crate::picture::{CHANNELS, Picture};
use crate::render::{Layer, Tracing};
use crate::scene::Camera;
use crate::scene::parser::parse_camera;
use crate::tools::explain::{Explainer, Stop};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How long the rays behind a pixel are followed.
const LONGEST_EXPLANATION: Duration = Duration::from_secs(10);

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
    painter: Painter,
    reference: Mutex<Option<Arc<Reference>>>,
    /// One of the long tasks at a time.
    task: Mutex<()>,
}

struct Reference {
    name: String,
    picture: Picture,
}

/// The status of a request that a later one has overtaken.
const OVERTAKEN: u16 = 409;

type Found = Result<Answer, Refusal>;

impl App {
    pub fn new(setup: &Setup, stage: Stage) -> std::io::Result<Self> {
        let comparison = setup.options.comparison.as_ref();
        let file = comparison.and_then(|wanted| wanted.picture.as_ref().or(wanted.reference.as_ref()));
        // One that cannot be read has been complained about.
        let reference = file.and_then(|path| {
            let name = path.to_string_lossy().into_owned();
            read_picture(path).ok().map(|picture| Arc::new(Reference { name, picture }))
        });
        let compared = comparison.into_iter().flat_map(|wanted| [&wanted.picture, &wanted.reference]);
        Ok(Self {
            input: setup.input.to_owned(),
            words: setup.words.to_vec(),
            outputs: outputs(setup.options),
            compared: compared.flatten().cloned().collect(),
            most: Most::of(setup.options),
            stage,
            painter: Painter::start()?,
            reference: Mutex::new(reference),
            task: Mutex::default(),
        })
    }

    /// The most bytes of a question to this path.
    pub fn longest_body(&self, path: &str) -> usize {
        if path == "/reference" { MAX_PICTURE_FILE } else { MAX_QUESTION }
    }

    /// Answers a question.
    pub fn answer(&self, path: &str, query: &str, body: Vec<u8>) -> Found {
        let found = self.found(path, query, body);
        match found {
            // This is no failure, and a browser lists failures.
            Err(refusal) if refusal.status == OVERTAKEN => Ok(framed(json!({ "overtaken": true }), &[])),
            found => found,
        }
    }

    fn found(&self, path: &str, query: &str, body: Vec<u8>) -> Found {
        match path {
            "/start" => Ok(framed(self.start(), &[])),
            "/scene" => self.edit(understood(&body)?),
            "/picture" => self.picture(understood(&body)?),
            "/objects" => self.objects(understood(&body)?),
            "/trace" => self.trace(understood(&body)?),
            "/save" => self.save(understood(&body)?),
            "/reference" => self.take_reference(query, &body),
            "/compare" => self.compare(understood(&body)?),
            "/cause" => self.cause(understood(&body)?),
            _ => Err(Refusal::new(404, "there is nothing here")),
        }
    }

    fn start(&self) -> Value {
        let first = self.stage.first();
        let outputs: Vec<_> = self.outputs.iter().map(|output| output.file.to_string_lossy()).collect();
        let reference = self.reference().map(|found| summary(&found));
        json!({
            "name": self.input.to_string_lossy(),
            "words": self.words,
            "outputs": outputs,
            "text": first.renderer.source.text,
            "scene": description(first),
            "reference": reference,
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    fn edit(&self, Edited { text }: Edited) -> Found {
        Ok(match self.stage.type_in(text) {
            Ok(scene) => framed(json!({ "scene": description(&scene) }), &[]),
            Err(errors) => framed(json!({ "errors": errors }), &[]),
        })
    }

    fn picture(&self, wanted: Wanted) -> Found {
        let subject = Subject { sketch: wanted.sketch.map(clipped), ..self.subject(&wanted.view)? };
        let (shown, camera) = (subject.sketch.unwrap_or(subject.options.size), subject.camera);
        let painted = self.painter.paint(subject, wanted.page, wanted.turn)?;
        let output = self.output(wanted.view.show.cost().map_or(Layer::Color, Layer::Cost));
        let output = output.map(|output| output.file.as_path());
        let cost = wanted.view.show.cost();
        let Painted { picture, costs, nans, time } = painted;
        let meta = json!({
            "size": [picture.width(), picture.height()],
            "shows": shown,
            "milliseconds": time.as_secs_f64() * 1000.0,
            "nans": nans,
            "costs": costs.map(|report| report.to_string()),
            "command": command_line(&self.input, &wanted.view.words, cost, output),
            "camera": camera.as_ref().map(camera_block),
        });
        Ok(framed(meta, &[&rgba(&picture)]))
    }

    fn objects(&self, view: PageView) -> Found {
        let subject = self.subject(&view)?;
        let _task = self.task.lock().unwrap_or_else(PoisonError::into_inner);
        let size = clipped(subject.options.size);
        let map = ObjectMap::new(&subject.scene.renderer, subject.camera, size).map_err(impossible)?;
        Ok(framed(json!({ "size": size, "objects": map.objects }), &[&map.places]))
    }

    fn trace(&self, TracedPixel { view, pixel }: TracedPixel) -> Found {
        let subject = self.subject(&view)?;
        let _task = self.task.lock().unwrap_or_else(PoisonError::into_inner);
        let (options, renderer) = (&subject.options, &subject.scene.renderer);
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

    fn save(&self, view: PageView) -> Found {
        let subject = self.subject(&view)?;
        let _task = self.task.lock().unwrap_or_else(PoisonError::into_inner);
        let said = save(&subject, &self.outputs, &self.compared, &self.painter).map_err(impossible)?;
        Ok(framed(json!({ "said": said }), &[]))
    }

    fn take_reference(&self, query: &str, body: &[u8]) -> Found {
        let name = query.strip_prefix("name=").unwrap_or_default();
        let picture = decode(name, body).map_err(impossible)?;
        let found = Arc::new(Reference { name: name.to_owned(), picture });
        let said = summary(&found);
        *self.reference.lock().unwrap_or_else(PoisonError::into_inner) = Some(found);
        Ok(framed(said, &[]))
    }

    fn compare(&self, wanted: Wanted) -> Found {
        let (reference, own, subject) = self.pair(&wanted)?;
        let picture = &reference.picture;
        let compared = subject.scene.renderer.on_own_threads(|| compare(picture, &own));
        let (block, amplification, difference) = compared.map_err(impossible)?;
        let meta = json!({
            "size": picture_size(picture), "block": block, "amplification": amplification, "name": reference.name,
        });
        Ok(framed(meta, &[&rgba(picture), &rgba(&own), &rgba(&difference)]))
    }

    fn cause(&self, wanted: Wanted) -> Found {
        let (reference, own, subject) = self.pair(&wanted)?;
        if picture_size(&reference.picture) != picture_size(&own) {
            return Err(impossible("the pictures differ in size".into()));
        }
        let _task = self.task.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(framed(json!({ "cause": cause(&reference.picture, &own, &subject) }), &[]))
    }

    /// The picture from elsewhere, and the view's.
    fn pair(&self, wanted: &Wanted) -> Result<(Arc<Reference>, Picture, Subject), Refusal> {
        let reference =
            self.reference().ok_or_else(|| impossible("there is no picture to compare with".into()))?;
        let subject = self.subject(&wanted.view)?;
        let own = self.painter.paint(subject.clone(), wanted.page, wanted.turn)?.picture;
        Ok((reference, own, subject))
    }

    fn reference(&self) -> Option<Arc<Reference>> {
        self.reference.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn output(&self, layer: Layer) -> Option<&Output> {
        self.outputs.iter().find(|output| output.layer == layer)
    }

    fn subject(&self, view: &PageView) -> Result<Subject, Refusal> {
        let scene = self.stage.scene(view.scene).ok_or_else(|| Refusal::new(410, "the scene is closed"))?;
        let options = self.most.options(&view.words).map_err(impossible)?;
        let pixels = options.size.iter().map(|&side| side as u64).product::<u64>();
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

fn understood<Q: DeserializeOwned>(body: &[u8]) -> Result<Q, Refusal> {
    serde_json::from_slice(body).map_err(|error| Refusal::new(400, format!("not a question: {error}")))
}

fn impossible(reason: String) -> Refusal {
    Refusal::new(422, reason)
}

impl From<Unpainted> for Refusal {
    fn from(reason: Unpainted) -> Self {
        let status = match reason {
            Unpainted::Overtaken => OVERTAKEN,
            Unpainted::Busy => 503,
            Unpainted::TooSlow | Unpainted::Failed(_) => 422,
        };
        Self::new(status, reason.to_string())
    }
}

/// What the page needs to know of a scene to turn it.
fn description(scene: &OpenScene) -> Value {
    let renderer = &scene.renderer;
    let camera = match renderer.scene.camera {
        Camera::Orthographic { center, direction, up, size } => {
            json!({ "kind": "orthographic", "center": center, "direction": direction, "up": up, "size": size })
        }
        Camera::Perspective { center, direction, up, angle } => {
            json!({ "kind": "perspective", "center": center, "direction": direction, "up": up, "angle": angle })
        }
    };
    json!({
        "revision": scene.revision,
        "camera": camera,
        "bounds": renderer.bounds(),
        "is_unlit": renderer.scene.lights.is_empty(),
    })
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
fn framed(meta: Value, parts: &[&[u8]]) -> Answer {
    let meta = meta.to_string().into_bytes();
    let mut body = Vec::with_capacity(4 + meta.len() + parts.iter().map(|part| part.len()).sum::<usize>());
    body.extend((meta.len() as u32).to_le_bytes());
    body.extend(meta);
    parts.iter().for_each(|part| body.extend_from_slice(part));
    Answer::bytes(body)
}
