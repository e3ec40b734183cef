//! Answers the questions of pages.

use super::flags::{Amounts, options};
use super::http::Response;
use super::limits::*;
use super::lock;
use super::objects::object_map;
use super::painting::{Painted, complete, paint};
use super::prepared::PreparedScenes;
use super::rays::Rays;
use super::scenes::{OpenScene, Scenes};
use super::view::View;
use super::workers::Workers;
use crate::base::escape::quoted;
use crate::base::memory;
use crate::base::shell::Shell;
use crate::cli::{Options, Output};
use crate::diagnostic::Diagnostic;
use crate::image_io::{check_distinct, put_in_place, read_picture, read_picture_from};
use crate::picture::{CHANNELS, Picture};
use crate::render::{Cost, Layer, Progress, Stop, Tracing, grid_view};
use crate::scene::parser::parse_camera;
use crate::tools::causes::Original;
use crate::tools::compare::{Comparison, DifferencePicture};
use crate::tools::explain::Explainer;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

/// The state that the pages of a command line share.
pub struct Session {
    input: PathBuf,
    line: Options,
    /// The pictures that a page can write.
    outputs: Vec<Output>,
    most: Amounts,
    scenes: Scenes,
    prepared: PreparedScenes,
    /// The picture from elsewhere that views are compared with.
    reference: Mutex<Option<Arc<Reference>>>,
    workers: Workers,
}

struct Reference {
    name: String,
    picture: Picture,
}

/// A question about a view.
#[derive(Deserialize)]
struct Question {
    view: Shown,
    /// Width and height in pixels of a sketch with one ray through each centre, in place of the whole picture.
    sketch: Option<[usize; 2]>,
    /// The pixel whose rays are traced, by column and row from the top left.
    pixel: Option<[usize; 2]>,
}

/// A scene that is typed in.
#[derive(Deserialize)]
struct Typed {
    text: String,
    /// The flags, which may name its edition.
    #[serde(default)]
    words: Vec<String>,
}

/// A view, as the page describes it.
#[derive(Deserialize)]
struct Shown {
    /// The scene's revision.
    scene: u64,
    /// Flags with their values.
    words: Vec<String>,
    /// The camera's block of scene text; none for the scene's own.
    camera: Option<String>,
    /// The cost that is shown in place of colours.
    #[serde(flatten)]
    cost: Option<Cost>,
}

type Found = Result<Response, Response>;

impl Session {
    /// Opens the scene of a command line.
    pub fn open(line: &Options, input: &Path) -> Result<Self, Diagnostic> {
        memory::use_few_heaps();
        memory::keep_reserve()?;
        let compared =
            line.comparison.iter().find_map(|wanted| wanted.picture.as_ref().or(wanted.reference.as_ref()));
        // The comparison of the command line has told about a picture that cannot be read.
        let picture = compared.and_then(|path| Some((path, read_picture(path).ok()?)));
        let reference = picture.map(|(path, picture)| {
            Arc::new(Reference { name: path.to_string_lossy().into_owned(), picture })
        });
        // A page renders no part of a picture, standard output has another reader, and a pipe would wait for one.
        let may_write =
            |output: &&Output| !output.is_standard_output() && output.file.is_file() && line.region.is_none();
        let size = reference.as_ref().map_or([0; 2], |reference| reference.picture.size());
        let cores = || thread::available_parallelism().map_or(1, usize::from);
        Ok(Self {
            input: input.to_owned(),
            line: line.clone(),
            outputs: line.outputs.iter().filter(may_write).cloned().collect(),
            most: Amounts::most(line, size),
            scenes: Scenes::open(line, input)?,
            prepared: PreparedScenes::new(line.structure),
            reference: Mutex::new(reference),
            workers: Workers::new(line.threads.unwrap_or_else(cores)),
        })
    }

    /// Answers a question. `has_left` is called often, and returns true if the client no longer waits.
    pub fn answer(&self, path: &str, query: &str, body: &[u8], has_left: &mut dyn FnMut() -> bool) -> Found {
        let mut within = |seconds, bytes, work: &(dyn Fn(&Stop) -> Found + Sync)| {
            self.workers.run(Duration::from_secs(seconds), bytes, has_left, work)
        };
        if path == "/start" {
            return Ok(self.start());
        }
        if path == "/reference" {
            return within(20, FILE_BYTES, &|_| self.take_reference(query, body));
        }
        if path == "/scene" {
            let typed: Typed = question(body)?;
            let of_meshes = if typed.text.contains("TriangleMesh") { FILE_BYTES } else { 0 };
            let bytes = of_meshes + typed.text.len() as u64 * PARSER_BYTES_PER_BYTE;
            return within(20, bytes, &|stop| self.type_in(&typed, stop));
        }
        let Question { view, sketch, pixel } = question(body)?;
        let view = self.view(view, sketch.filter(|_| path == "/picture"))?;
        match path {
            "/picture" => within(60, view.bytes(), &|stop| self.picture(&view, stop)),
            "/compare" => within(60, view.bytes(), &|stop| self.compare(&view, stop)),
            "/cause" => within(60, view.bytes() + 2 * view.scene.bytes(), &|stop| self.cause(&view, stop)),
            "/objects" => within(20, view.bytes(), &|stop| self.objects(&view, stop)),
            "/trace" => {
                let pixel = pixel.ok_or_else(|| Response::text(400, "not a question: it names no pixel"))?;
                within(20, 0, &|stop| self.trace(&view, pixel, stop))
            }
            // The command line may name pictures that no page would show.
            "/save" => within(600, view.bytes(), &|stop| self.save(&view, stop)),
            _ => Err(Response::text(404, "there is nothing here")),
        }
    }

    fn view(
        &self,
        Shown { scene, words, camera, cost }: Shown,
        sketch: Option<[usize; 2]>,
    ) -> Result<View, Response> {
        let closed = |reason| Response::text(410, reason);
        let scene = self.scenes.scene(scene).ok_or_else(|| closed("the scene is closed"))?;
        let options = options(&words, self.most)?;
        if options.edition != scene.named {
            return Err(closed("the scene is open in another edition"));
        }
        let options = options.in_edition(scene.choice.edition);
        let in_block =
            |error: Diagnostic| Response::text(422, &error.in_file(Path::new("camera")).headline());
        let camera = camera.map(|block| parse_camera(&block).map_err(in_block)).transpose()?;
        let view = View { scene, words, options, camera, cost, sketch: sketch.map(clipped) };
        memory::ask(view.bytes())?;
        Ok(view)
    }

    fn start(&self) -> Response {
        let (first, reference) = (&self.scenes.first, self.reference());
        let outputs: Vec<_> = self.outputs.iter().map(|output| output.file.to_string_lossy()).collect();
        let meta = json!({
            "name": self.input.to_string_lossy(),
            "words": self.line.page.as_ref().map(|page| &page.words),
            "outputs": outputs,
            "text": first.renderer.source.text,
            "scene": description(first),
            "reference": reference.as_deref().map(summary),
            "most": self.most,
            "cell_colors": grid_view::SCALE.map(|color| color.map(|channel| (255.0 * channel) as u8)),
        });
        Response::described(&meta, &[])
    }

    fn type_in(&self, Typed { text, words }: &Typed, stop: &Stop) -> Found {
        let named = options(words, self.most)?.edition;
        let meta = match self.scenes.type_in(text.clone(), named, stop) {
            Ok(scene) => json!({ "scene": description(&scene) }),
            Err(error) => {
                let at = error.position().map(|at| [at.line, at.column]);
                json!({ "error": { "at": at, "problem": error.message, "hint": error.hint } })
            }
        };
        Ok(Response::described(&meta, &[]))
    }

    fn picture(&self, view: &View, stop: &Stop) -> Found {
        let start = Instant::now();
        let Painted { picture, costs, nans } = paint(&self.prepared, view, stop)?;
        let saturated = |&count: &u64| u32::try_from(count).unwrap_or(u32::MAX).to_le_bytes();
        let counts = costs.iter().flat_map(|map| map.counts.iter().flat_map(saturated));
        let counts: Vec<u8> = counts.collect();
        let meta = json!({
            "size": picture.size(),
            "shows": view.sketch.unwrap_or_else(|| view.options.picture_size()),
            "milliseconds": start.elapsed().as_secs_f64() * 1000.0,
            "nans": nans,
            "costs": costs.map(|map| map.to_string()),
            "command": self.command_line(view),
        });
        Ok(Response::described(&meta, &[&rgba(&picture), &counts]))
    }

    /// Returns the command line that writes the picture of a view.
    fn command_line(&self, view: &View) -> String {
        let text = |path: &Path| path.to_string_lossy().into_owned();
        let layer = view.cost.map_or(Layer::Color, Layer::Cost);
        let output = self.outputs.iter().find(|output| output.layer == layer);
        let mut line = vec!["raytracer".into(), "-input".into(), text(&self.input)];
        line.extend_from_slice(&view.words);
        // Names an edition that the scene's words have told, so that the command line prints no note about it.
        let choice = &view.scene.choice;
        if choice.because.is_some() {
            line.extend(["-edition".into(), choice.edition.to_string()]);
        }
        match view.cost {
            None => line.push("-output".into()),
            Some(cost) => line.extend(["-cost_map".into(), cost.name().into()]),
        }
        line.push(output.map_or("picture.png".into(), |output| text(&output.file)));
        line.iter().map(|word| Shell::OF_SYSTEM.word(word)).collect::<Vec<_>>().join(" ")
    }

    /// Writes the pictures that the command line names of a view, all or none.
    fn save(&self, view: &View, stop: &Stop) -> Found {
        if self.outputs.is_empty() {
            let reason = "the command line names no picture to write; copy the one below";
            return Err(Response::text(422, reason));
        }
        let written = self.outputs.iter().map(|output| output.file.clone());
        check_distinct(written, self.line.files().chain(view.scene.files.clone()))?;
        let files = self.outputs.iter().map(|output| complete(&self.prepared, view, output, stop));
        put_in_place(files.collect::<Result<_, _>>()?)?;
        let names: Vec<String> = self.outputs.iter().map(|output| quoted(&output.file)).collect();
        Ok(Response::described(&json!({ "said": format!("saved {}", names.join(", ")) }), &[]))
    }

    fn objects(&self, view: &View, stop: &Stop) -> Found {
        let size = clipped(view.options.picture_size());
        let ready = self.prepared.get(view, Tracing::Fast, false, stop)?;
        let (objects, places) = object_map(ready.borrow_dependent(), view.camera, size, stop)?;
        Ok(Response::described(&json!({ "size": size, "objects": objects }), &[&places]))
    }

    fn trace(&self, view: &View, pixel: [usize; 2], stop: &Stop) -> Found {
        if view.options.reduced {
            return Err(Response::text(422, "the pixels of a picture that is reduced are not traced"));
        }
        let ready = self.prepared.get(view, Tracing::Counted, false, stop)?;
        let prepared = ready.borrow_dependent();
        let tree = Explainer::new(prepared)?.pixel(&view.request(Layer::Color), pixel, stop)?;
        let rays = Rays::of(&tree, view.scene.renderer.bounds(), prepared.cells());
        Ok(Response::described(&json!({ "pixel": pixel, "rays": rays }), &[]))
    }

    /// Takes a picture from elsewhere, in the bytes of a file whose name the query has.
    fn take_reference(&self, query: &str, file: &[u8]) -> Found {
        let name = query.strip_prefix("name=").unwrap_or_default().to_owned();
        let most = self.most.side;
        // Up to four channels of two bytes.
        let picture = read_picture_from(Path::new(&name), file, 8 * (most as u64).pow(2))?;
        let [width, height] = picture.size();
        if width.max(height) > most {
            let reason =
                format!("a page shows pictures of at most {most} pixels a side, not {width} x {height}");
            return Err(Response::text(422, &reason));
        }
        let reference = Arc::new(Reference { name, picture });
        let said = Response::described(&summary(&reference), &[]);
        *lock(&self.reference) = Some(reference);
        Ok(said)
    }

    fn compare(&self, view: &View, stop: &Stop) -> Found {
        let (reference, own) = self.pair(view, stop)?;
        let picture = &reference.picture;
        let compared = Comparison::within(picture, &own.picture, stop)?;
        let (shown, amplification) = DifferencePicture::of_bytes(picture, &own.picture)?;
        let meta = json!({
            "size": picture.size(), "block": compared.to_string(), "largest": compared.largest,
            "amplification": amplification,
        });
        let difference = rgba(&shown);
        // The last of the panels that stand side by side.
        let [all, panel] = [shown.width(), picture.width()].map(|width| 4 * width as usize);
        let difference: Vec<&[u8]> = difference.chunks_exact(all).map(|row| &row[all - panel..]).collect();
        Ok(Response::described(&meta, &[&rgba(picture), &rgba(&own.picture), &difference.concat()]))
    }

    /// Finds the cause of the difference, in the words of the command line; null if no cause can be tried.
    fn cause(&self, view: &View, stop: &Stop) -> Found {
        let request = view.request(Layer::Color);
        let (reference, own) = self.pair(view, stop)?;
        let (picture, own) = (&reference.picture, &own.picture);
        let differs = picture.size() == own.size() && picture.pixels() != own.pixels();
        let can_try = differs && request.camera_rays() <= MAX_CAUSE_RAYS;
        let watch = |progress: Progress| stop.watch(progress);
        let original = || Original::watched(&view.scene.renderer, &request, &watch);
        let original = can_try.then(original).flatten();
        let cause = original.map(|original| original.explain(picture).to_string());
        Ok(Response::described(&json!({ "cause": cause }), &[]))
    }

    /// Returns the picture from elsewhere, and the view's.
    fn pair(&self, view: &View, stop: &Stop) -> Result<(Arc<Reference>, Painted), Response> {
        let reference = self.reference();
        let reference =
            reference.ok_or_else(|| Response::text(422, "there is no picture to compare with"))?;
        // Costs are no colours, and their map has a scale beside it.
        Ok((reference, paint(&self.prepared, &View { cost: None, ..view.clone() }, stop)?))
    }

    fn reference(&self) -> Option<Arc<Reference>> {
        lock(&self.reference).clone()
    }
}

/// Returns what the page needs to know of a scene to turn it, and of the edition that it was read in.
fn description(OpenScene { revision, choice, renderer, .. }: &OpenScene) -> Value {
    let (scene, edition) = (&renderer.scene, choice.edition);
    json!({
        "revision": revision,
        "camera": scene.camera,
        "screen": scene.screen,
        "bounds": renderer.bounds(),
        "is_unlit": scene.lights.is_empty(),
        "edition": edition,
        "note": choice.remark().map(|found| found.in_one_line()),
        "defaults": { "bounces": edition.default_bounces(), "weight": edition.default_weight() },
    })
}

fn summary(reference: &Reference) -> Value {
    json!({ "name": reference.name, "size": reference.picture.size() })
}

fn question<Q: DeserializeOwned>(body: &[u8]) -> Result<Q, Response> {
    serde_json::from_slice(body).map_err(|error| Response::text(400, &format!("not a question: {error}")))
}

fn clipped(size: [usize; 2]) -> [usize; 2] {
    size.map(|side| side.clamp(1, MAX_SIDE_PIXELS))
}

/// Red, green, blue and an opaque alpha, as a canvas takes them.
fn rgba(picture: &Picture) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(picture.pixels().len() / CHANNELS * 4);
    for &[red, green, blue] in picture.pixels().as_chunks().0 {
        bytes.extend_from_slice(&[red, green, blue, u8::MAX]);
    }
    bytes
}
