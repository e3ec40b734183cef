//! Answers the questions of pages.

use super::camera::{camera_block, camera_values};
use super::http::Answer;
use super::limits::*;
use super::objects::ObjectMap;
use super::painter::{Painted, Painter, Subject};
use super::queue::Queue;
use super::rays::Rays;
use super::saving::save;
use super::scenes::{OpenScene, Scenes};
use super::settings::{Most, command_line};
use crate::base::memory;
use crate::cli::{Options, Output};
use crate::diagnostic::Diagnostic;
use crate::image_io::{read_picture, read_picture_from};
use crate::picture::{CHANNELS, Picture};
use crate::render::{Cost, Layer, Progress, grid_view};
use crate::scene::edition::Edition;
use crate::scene::parser::parse_camera;
use crate::tools::causes::Original;
use crate::tools::compare::{Comparison, DifferencePicture};
use crate::tools::explain::{Explainer, Stop};
use serde::Deserialize;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Instant;

/// What the pages of a command line share.
pub struct Session {
    input: PathBuf,
    /// The flags that the page starts with.
    words: Vec<String>,
    /// The pictures that a page can write.
    outputs: Vec<Output>,
    /// The pictures that the command line compares.
    compared: Vec<PathBuf>,
    most: Most,
    scenes: Scenes,
    painter: Painter,
    /// The picture from elsewhere that views are compared with.
    reference: Mutex<Option<Arc<Reference>>>,
    queue: Arc<Queue>,
}

struct Reference {
    name: String,
    picture: Picture,
}

/// What a page asks. Each question has some of these.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Question {
    /// A random number of the page, and one that grows with each picture.
    page: Option<u64>,
    turn: Option<u64>,
    view: Option<View>,
    /// Width and height in pixels of a sketch with one ray through each centre, in place of the whole picture.
    sketch: Option<[usize; 2]>,
    /// The pixel whose rays are traced, by column and row from the top left.
    pixel: Option<[usize; 2]>,
    /// A scene's text, in place of the one on the page, and the flags, which may name its edition.
    text: Option<String>,
    words: Vec<String>,
}

/// A view of a scene, as the controls and the hand have set it.
#[derive(Deserialize)]
struct View {
    /// The scene's revision.
    scene: u64,
    /// Flags with their values.
    words: Vec<String>,
    /// The camera's block of scene text; none for the scene's own.
    camera: Option<String>,
    show: Show,
}

/// What a picture shows: colours, or what each pixel costs.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Show {
    Color,
    Rays,
    Tests,
    Cells,
}

impl Question {
    fn read(path: &str, body: &[u8]) -> Result<Self, Answer> {
        let refused = |error: serde_json::Error| Answer::text(400, &format!("not a question: {error}"));
        let mut question: Self = serde_json::from_slice(body).map_err(refused)?;
        // These are views themselves.
        if matches!(path, "/objects" | "/save") {
            question.view = Some(serde_json::from_slice(body).map_err(refused)?);
        }
        Ok(question)
    }
}

type Found = Result<Answer, Answer>;
type Work = Box<dyn Fn(&Session, &Stop) -> Found + Send + Sync>;

impl Session {
    /// Opens the scene of a command line, which has a page that starts with these words.
    pub fn open(options: &Options, input: &Path, words: &[String]) -> Result<Self, Diagnostic> {
        let cores = || thread::available_parallelism().map_or(1, usize::from);
        let queue = Queue::new(options.threads.unwrap_or_else(cores));
        let (path, hints, endless) = (input.to_owned(), options.hints(), Instant::now() + FOREVER);
        let open = move |_: &Stop| Scenes::open(&path, hints.clone());
        let scenes = queue.run(0, endless, &mut || None, open);
        let scenes = scenes.map_err(|answer| Diagnostic::error(String::from_utf8_lossy(&answer.body)))??;
        let comparison = options.comparison.as_ref();
        let file = comparison.and_then(|wanted| wanted.picture.as_ref().or(wanted.reference.as_ref()));
        // One that cannot be read has been complained about.
        let picture = file.and_then(|path| Some((path, read_picture(path).ok()?)));
        let reference = picture.map(|(path, picture)| {
            Arc::new(Reference { name: path.to_string_lossy().into_owned(), picture })
        });
        let compared = comparison.into_iter().flat_map(|wanted| [&wanted.picture, &wanted.reference]);
        // A page renders no part of a picture, and standard output has another reader.
        let may_write = |output: &&Output| !output.is_standard_output() && options.region.is_none();
        let size = reference.as_ref().map_or([0; 2], |reference| picture_size(&reference.picture));
        Ok(Self {
            input: input.to_owned(),
            words: words.to_vec(),
            outputs: options.outputs.iter().filter(may_write).cloned().collect(),
            compared: compared.flatten().cloned().collect(),
            most: Most::of(options, size),
            scenes,
            painter: Painter::new(options.structure),
            reference: Mutex::new(reference),
            queue,
        })
    }

    /// Answers a question. `has_left` is asked often whether the other side no longer waits.
    pub fn answer(
        self: &Arc<Self>,
        path: &str,
        query: &str,
        body: Vec<u8>,
        has_left: &mut dyn FnMut() -> bool,
    ) -> Found {
        let deadline = Instant::now() + answer_time(path);
        // Of some kinds only the newest question of a page counts.
        let kind = match path {
            "/picture" | "/compare" | "/cause" => Some("picture"),
            "/scene" => Some("scene"),
            "/objects" => Some("objects"),
            "/trace" => Some("trace"),
            "/start" | "/save" | "/reference" => None,
            _ => return Err(Answer::text(404, "there is nothing here")),
        };
        let question = if path == "/reference" { Question::default() } else { Question::read(path, &body)? };
        let turn = kind.zip(question.page).map(|(kind, page)| self.queue.turn(page, kind, question.turn));
        let mut gives_up = || match () {
            // This is no failure, and a browser lists failures.
            () if turn.is_some_and(|turn| self.queue.is_overtaken(turn)) => {
                Some(Answer::described(&json!({ "overtaken": true }), &[]))
            }
            () if Instant::now() > deadline => {
                let reason = "this takes longer than a page may: choose a smaller picture, or fewer samples";
                Some(Answer::impossible(reason))
            }
            () => has_left().then(|| Answer::text(408, "nobody waits for this answer")),
        };
        let (work, bytes) = match path {
            "/reference" => {
                let name = query.strip_prefix("name=").unwrap_or_default().to_owned();
                let work: Work = Box::new(move |session, _| session.take_reference(&name, &body));
                (work, BYTES_OF_READING)
            }
            _ => self.work(path, question)?,
        };
        let session = self.clone();
        self.queue.run(bytes, deadline, &mut gives_up, move |stop| work(&session, stop))?
    }

    /// Returns what is to be done for a question, and the memory in bytes that it takes.
    fn work(&self, path: &str, question: Question) -> Result<(Work, u64), Answer> {
        let incomplete = || Answer::text(400, "not a question: it is incomplete");
        if path == "/start" {
            return Ok((Box::new(|session, _| session.start()), 0));
        }
        if path == "/scene" {
            let text = question.text.ok_or_else(incomplete)?;
            let named = self.most.options(&question.words)?.edition;
            return Ok((Box::new(move |session, stop| session.type_in(&text, named, stop)), 0));
        }
        let view = question.view.ok_or_else(incomplete)?;
        let mut subject = self.subject(&view)?;
        if path == "/picture" {
            subject.sketch = question.sketch.map(clipped);
        }
        let bytes = match path {
            "/picture" | "/save" => subject.bytes(1, 0),
            "/compare" => subject.bytes(2, 0),
            "/cause" => subject.bytes(2, 2),
            "/objects" => subject.bytes(1, 1),
            _ => subject.bytes(0, 1),
        };
        let work: Work = match path {
            "/picture" => Box::new(move |session, stop| session.picture(&subject, &view.words, stop)),
            "/save" => Box::new(move |session, stop| session.save(&subject, stop)),
            "/compare" => Box::new(move |session, stop| session.compare(&subject, stop)),
            "/cause" => Box::new(move |session, stop| session.cause(&subject, stop)),
            "/objects" => Box::new(move |session, stop| session.objects(&subject, stop)),
            _ => {
                let pixel = question.pixel.ok_or_else(incomplete)?;
                Box::new(move |session, stop| session.trace(&subject, pixel, stop))
            }
        };
        Ok((work, bytes))
    }

    fn start(&self) -> Found {
        let first = self.scenes.first();
        let outputs: Vec<_> = self.outputs.iter().map(|output| output.file.to_string_lossy()).collect();
        let meta = json!({
            "name": self.input.to_string_lossy(),
            "words": self.words(),
            "outputs": outputs,
            "text": first.renderer.source.text,
            "scene": self.description(first),
            "reference": self.reference().as_deref().map(summary),
            "most": self.most.to_json(),
            "cell_colors": grid_view::SCALE.map(|color| color.map(|channel| (255.0 * channel) as u8)),
            "version": env!("CARGO_PKG_VERSION"),
        });
        Ok(Answer::described(&meta, &[]))
    }

    /// The flags that the page starts with. Their picture has the size of the one to compare with.
    fn words(&self) -> Vec<String> {
        let mut words = self.words.clone();
        let Some(wanted) = self.reference().map(|reference| picture_size(&reference.picture)) else {
            return words;
        };
        let Ok(mut options) = self.most.options(&words) else { return words };
        if options.picture_size() == wanted {
            return words;
        }
        // The samples may enlarge or reduce the picture.
        let sizes = [wanted, wanted.map(|side| side / 3), wanted.map(|side| 3 * side)];
        let makes = |size: &[usize; 2]| {
            options.size = *size;
            options.picture_size() == wanted
        };
        let [width, height] = sizes.into_iter().find(makes).unwrap_or(wanted);
        if let Some(start) = words.iter().position(|word| word == "-size") {
            let values = words[start + 1..].iter().take_while(|word| !word.starts_with('-')).count();
            words.drain(start..=start + values);
        }
        words.extend(["-size".to_owned(), width.to_string(), height.to_string()]);
        words
    }

    fn type_in(&self, text: &str, named: Option<Edition>, stop: &Stop) -> Found {
        let meta = match self.scenes.type_in(text.to_owned(), named, stop) {
            Ok(scene) => json!({ "scene": self.description(&scene) }),
            Err(error) => json!({ "errors": [error] }),
        };
        self.painter.forget(|revision| self.scenes.is_open(revision));
        Ok(Answer::described(&meta, &[]))
    }

    fn picture(&self, subject: &Subject, words: &[String], stop: &Stop) -> Found {
        let Painted { picture, costs, nans, time } = self.painter.paint(subject, stop)?;
        let layer = subject.cost.map_or(Layer::Color, Layer::Cost);
        let output = self.outputs.iter().find(|output| output.layer == layer);
        let saturated = |&count: &u64| u32::try_from(count).unwrap_or(u32::MAX).to_le_bytes();
        let counts = costs.iter().flat_map(|report| report.map.counts.iter().flat_map(saturated));
        let counts: Vec<u8> = counts.collect();
        // Which edition the words of the scene tell depends on the pictures that are written, too.
        let mut words = words.to_vec();
        let choice = &subject.scene.choice;
        if choice.because.is_some() {
            words.extend(["-edition".to_owned(), choice.edition.to_string()]);
        }
        let output = output.map(|output| output.file.as_path());
        let meta = json!({
            "size": picture_size(&picture),
            "shows": subject.sketch.unwrap_or_else(|| subject.options.picture_size()),
            "milliseconds": time.as_secs_f64() * 1000.0,
            "nans": nans,
            "costs": costs.map(|report| report.to_string()),
            "command": command_line(&self.input, &words, subject.cost, output),
            "camera": subject.camera.as_ref().map(camera_block),
        });
        Ok(Answer::described(&meta, &[&rgba(&picture), &counts]))
    }

    fn save(&self, subject: &Subject, stop: &Stop) -> Found {
        let said = save(subject, &self.outputs, &self.compared, &self.painter, stop)?;
        Ok(Answer::described(&json!({ "said": said }), &[]))
    }

    fn objects(&self, subject: &Subject, stop: &Stop) -> Found {
        let size = clipped(subject.options.picture_size());
        let ready = self.painter.ready(subject, false, false)?;
        let map = ObjectMap::new(ready.borrow_dependent(), subject.camera, size, stop);
        let map = map?;
        Ok(Answer::described(&json!({ "size": size, "objects": map.objects }), &[&map.places]))
    }

    fn trace(&self, subject: &Subject, pixel: [usize; 2], stop: &Stop) -> Found {
        if subject.options.reduced {
            return Err(Answer::impossible("the pixels of a picture that is reduced are not traced"));
        }
        let ready = self.painter.ready(subject, true, false)?;
        let prepared = ready.borrow_dependent();
        let explainer = Explainer::new(prepared)?;
        let tree = explainer.pixel(&subject.request(Layer::Color), pixel, stop)?;
        let rays = Rays::of(&tree, subject.scene.renderer.bounds(), prepared.cells());
        Ok(Answer::described(&json!({ "pixel": pixel, "rays": rays }), &[]))
    }

    /// Takes a picture from elsewhere, in the bytes of a file with this name.
    fn take_reference(&self, name: &str, file: &[u8]) -> Found {
        let picture = read_picture_from(Path::new(name), file)?;
        let ([width, height], most) = (picture_size(&picture), self.most.side());
        if width.max(height) > most {
            let reason =
                format!("a page shows pictures of at most {most} pixels a side, not {width} x {height}");
            return Err(Answer::impossible(reason));
        }
        let reference = Arc::new(Reference { name: name.to_owned(), picture });
        let said = Answer::described(&summary(&reference), &[]);
        *self.reference.lock().unwrap_or_else(PoisonError::into_inner) = Some(reference);
        Ok(said)
    }

    fn compare(&self, subject: &Subject, stop: &Stop) -> Found {
        let (reference, own) = self.pair(subject, stop)?;
        let picture = &reference.picture;
        let compared = Comparison::new_unless(picture, &own, &|| stop.is_over())?;
        let shown = DifferencePicture::new(picture, &own)?;
        let meta = json!({
            "size": picture_size(picture), "block": compared.to_string(), "amplification": shown.amplification,
            "name": reference.name,
        });
        let difference = rgba(&shown.picture);
        // The last of the panels that stand side by side.
        let [all, panel] = [shown.picture.width(), picture.width()].map(|width| 4 * width as usize);
        let difference: Vec<&[u8]> = difference.chunks_exact(all).map(|row| &row[all - panel..]).collect();
        Ok(Answer::described(&meta, &[&rgba(picture), &rgba(&own), &difference.concat()]))
    }

    /// Finds what makes the difference, in the words of the command line; none where nothing can be tried.
    fn cause(&self, subject: &Subject, stop: &Stop) -> Found {
        let (reference, own) = self.pair(subject, stop)?;
        let picture = &reference.picture;
        if picture_size(picture) != picture_size(&own) {
            return Err(Answer::impossible("the pictures differ in size"));
        }
        let request = subject.request(Layer::Color);
        let can_try = !subject.options.visualize_grid
            && subject.options.adaptive.is_none()
            && request.camera_rays() <= MAX_CAUSE_RAYS
            && picture.pixels() != own.pixels();
        let watch = |progress: Progress| stop.watch(progress);
        let renderer = &subject.scene.renderer;
        let original = || Original::watched(renderer, subject.options.structure, &request, &watch);
        let original = if can_try { original() } else { None };
        let cause = original.map(|original| original.explain(picture, &own).to_string());
        Ok(Answer::described(&json!({ "cause": cause }), &[]))
    }

    /// Returns the picture from elsewhere, and the view's.
    fn pair(&self, subject: &Subject, stop: &Stop) -> Result<(Arc<Reference>, Picture), Answer> {
        let reference = self.reference();
        let reference = reference.ok_or_else(|| Answer::impossible("there is no picture to compare with"))?;
        // Costs are no colours, and their map has a scale beside it.
        let own = self.painter.paint(&Subject { cost: None, ..subject.clone() }, stop)?;
        Ok((reference, own.picture))
    }

    fn reference(&self) -> Option<Arc<Reference>> {
        self.reference.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Returns what the page needs to know of a scene to turn it, and of the edition that it was read in.
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
            "note": choice.remark().map(|found| match found.hint {
                Some(hint) => format!("{}; {hint}", found.message),
                None => found.message,
            }),
            "defaults": { "bounces": defaults.bounces, "weight": defaults.min_weight },
        })
    }

    fn subject(&self, view: &View) -> Result<Subject, Answer> {
        let scene = self.scenes.scene(view.scene).ok_or_else(|| Answer::text(410, "the scene is closed"))?;
        let options = self.most.options(&view.words)?;
        if options.edition != scene.named {
            return Err(Answer::text(410, "the scene is open in another edition"));
        }
        let options = options.in_edition(scene.choice.edition);
        let camera = view.camera.as_deref().map(parse_camera).transpose();
        let camera = camera.map_err(|error| Answer::impossible(format!("the camera: {}", error.message)))?;
        let cost = match view.show {
            Show::Color => None,
            Show::Rays => Some(Cost::Rays),
            Show::Tests => Some(Cost::Tests),
            Show::Cells => Some(Cost::Cells),
        };
        let subject = Subject { scene, options, camera, cost, sketch: None };
        memory::ask(subject.bytes(2, 0))?;
        Ok(subject)
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
