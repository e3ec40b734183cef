//! Parses scene text into a [`Scene`]: the course's grammar of 2004, with the variants of 2003.

use super::edition::Edition;
use super::filled_cells::FilledCells;
use super::mesh::NamedFile;
use super::model::Shows;
use super::parse_material::parse_materials;
use super::parse_objects::ObjectTree;
use super::parse_view::{self, parse_lights};
use super::reader::{Parsed, Reader};
use super::texels::{CubeFaces, FACES, ImageFile};
use super::{Background, Camera, Light, MeshFile, Object, ObjectId, Position, Positions, Scene};
use crate::base::patience::{Endless, Patience};
use crate::diagnostic::Diagnostic;
use std::sync::Arc;

const BLOCKS: [&str; 6] =
    ["OrthographicCamera", "PerspectiveCamera", "Background", "Lights", "Materials", "Group"];
/// The suffixes that identify the kinds of blocks, and the nouns used in messages.
const KINDS: [&str; 5] = ["Camera", "Background", "Lights", "Materials", "Group"];
const NOUNS: [&str; 5] = ["camera", "`Background`", "list of lights", "list of materials", "`Group`"];

/// A scene, and the warnings about its text.
#[derive(Clone, Debug)]
pub struct Reading {
    /// The scene. The files that it names are not opened.
    pub scene: Scene,
    /// The files that the scene names and that have no effect.
    pub unread: Vec<NamedFile>,
    /// Warnings about the text, with their positions in it.
    pub warnings: Vec<Diagnostic>,
}

/// Parses a scene of the 2004 edition. See [`read_in`].
pub fn parse(text: &str) -> Result<Scene, Diagnostic> {
    Ok(read_in(Edition::Y2004, text)?.scene)
}

/// Parses a scene in the language of an edition.
///
/// Blocks may come in any order, except that `Materials` must precede the `Group`. A later block replaces an earlier
/// one of its kind. Fails at the first violation of the grammar or of a rule for values, and reports its position.
pub fn read_in(edition: Edition, text: &str) -> Result<Reading, Diagnostic> {
    read_words(edition, text, &Endless)?.finish(&Endless)
}

/// Reads the words of a scene like [`read_in`], but does not make the surfaces of its grids.
pub(super) fn read_words(
    edition: Edition,
    text: &str,
    patience: &dyn Patience,
) -> Result<Unfinished, Diagnostic> {
    let mut reader = Reader::new(edition, text, patience);
    let mut blocks = Blocks::default();
    while !reader.peek().is_end() {
        blocks.parse_block(&mut reader)?;
    }
    let grids = std::mem::take(&mut blocks.tree.grids);
    let scene = blocks.into_scene(&mut reader)?;
    let unread = std::mem::take(&mut reader.unread);
    Ok(Unfinished { reading: Reading { scene, unread, warnings: reader.into_warnings() }, grids })
}

/// A scene whose words have been read, and the cells of its grids.
#[derive(Debug)]
pub(super) struct Unfinished {
    pub reading: Reading,
    grids: Vec<(ObjectId, FilledCells)>,
}

impl Unfinished {
    /// Makes the surfaces of the grids.
    pub fn finish(mut self, patience: &dyn Patience) -> Result<Reading, Diagnostic> {
        for (id, cells) in self.grids {
            if let Some(Object::Grid { surface, .. }) = self.reading.scene.objects.get_mut(id) {
                *surface = Arc::new(cells.surface(patience)?);
            }
        }
        Ok(self.reading)
    }
}

/// Parses a text that consists of one camera block. Fails for any other text.
pub fn parse_camera(text: &str) -> Result<Camera, Diagnostic> {
    let mut reader = Reader::new(Edition::Y2004, text, &Endless);
    if !reader.is_at_any(&BLOCKS[..2]) {
        return Err(reader.unexpected("a camera", &BLOCKS[..2]));
    }
    let camera = parse_view::parse_camera(&mut reader)?;
    if !reader.peek().is_end() {
        return Err(reader.unexpected("the end of the camera", &[]));
    }
    Ok(camera)
}

/// The blocks read so far.
#[derive(Default)]
struct Blocks {
    camera: Option<Camera>,
    background: Background,
    cube_map: Option<CubeFaces>,
    lights: Vec<(Light, Position)>,
    tree: ObjectTree,
    root: Option<ObjectId>,
    /// The position of the last block of each kind, in the order of [`KINDS`].
    positions: [Option<Position>; KINDS.len()],
}

impl Blocks {
    fn parse_block(&mut self, reader: &mut Reader<'_>) -> Parsed<()> {
        self.note_block(reader);
        match reader.peek().text {
            word if reader.is_of_other_edition(word) => return Err(unknown_block(reader)),
            "OrthographicCamera" | "PerspectiveCamera" => {
                self.camera = Some(parse_view::parse_camera(reader)?);
            }
            "Background" => (self.background, self.cube_map) = parse_background(reader)?,
            "Lights" => self.lights = parse_lights(reader)?,
            "Materials" => self.parse_materials(reader)?,
            "Group" => self.root = Some(self.tree.parse_root(reader)?),
            _ => return Err(unknown_block(reader)),
        }
        Ok(())
    }

    /// Records the position of the block at the next word, and warns if it is the second of its kind.
    fn note_block(&mut self, reader: &mut Reader<'_>) {
        let at = reader.peek().at;
        let Some(kind) = KINDS.iter().position(|kind| reader.peek().text.ends_with(kind)) else { return };
        if let Some(earlier) = self.positions[kind].replace(at) {
            let message = format!("a second {}: it replaces the one in line {}", NOUNS[kind], earlier.line);
            reader.replaced.push(Diagnostic::warning(message).at(at));
        }
    }

    fn parse_materials(&mut self, reader: &mut Reader<'_>) -> Parsed<()> {
        if self.root.is_some() {
            let error = Diagnostic::error("`Materials` must come before the `Group`");
            return Err(error.at(reader.peek().at));
        }
        self.tree.declare(parse_materials(reader)?);
        Ok(())
    }

    /// Returns the scene. Fails if a block is missing.
    fn into_scene(mut self, reader: &mut Reader<'_>) -> Parsed<Scene> {
        let end = reader.peek().at;
        let missing = |block| Diagnostic::error(format!("the scene has no {block}")).at(end);
        let camera = self.camera.ok_or_else(|| missing("camera"))?;
        // Aalto's scenes may have no objects. Its program then shows pixel coordinates.
        let shows = if self.root.is_some() { Shows::Scene } else { Shows::Places };
        let root = match self.root {
            Some(root) => root,
            None if reader.edition == Edition::Aalto => self.tree.add(Object::Group(vec![]), end),
            None => return Err(missing("group")),
        };
        let (lights, light_positions) = self.lights.into_iter().unzip();
        let meshes = self.tree.meshes.list.into_iter();
        let images = std::mem::take(&mut reader.images).list.into_iter();
        Ok(Scene {
            camera,
            background: self.background,
            lights,
            materials: self.tree.materials,
            objects: self.tree.objects,
            root,
            meshes: meshes.map(|(name, at)| MeshFile { name, at, ..MeshFile::default() }).collect(),
            images: images.map(|(name, at)| ImageFile { name, at, ..ImageFile::default() }).collect(),
            cube_map: self.cube_map,
            screen: reader.edition.screen(),
            lighting: reader.edition.lighting(),
            mesh_normals: reader.edition.mesh_normals(),
            measure_colors: reader.edition.measure_colors(),
            shows,
            positions: Positions {
                camera: self.positions[0].unwrap_or_default(),
                lights: light_positions,
                materials: self.tree.material_positions,
                objects: self.tree.positions,
            },
        })
    }
}

fn unknown_block(reader: &Reader<'_>) -> Diagnostic {
    let error = reader.unexpected("a camera, `Background`, `Lights`, `Materials` or `Group`", &BLOCKS);
    match reader.peek().text {
        "}" => error.with_hint("this brace closes nothing"),
        "Sphere" | "Plane" | "Triangle" | "TriangleMesh" | "Box" | "Transform" | "MaterialIndex" => {
            error.with_hint("objects and their materials go inside a `Group`")
        }
        _ => error,
    }
}

/// Reads the background. All fields are optional.
fn parse_background(reader: &mut Reader<'_>) -> Parsed<(Background, Option<CubeFaces>)> {
    let mut background = Background::default();
    let mut cube_map = None;
    let fields = ["color", "ambientLight", "cubeMap"];
    reader.block(|reader, _| {
        reader.fields("`color`, `ambientLight` or `}`", &fields, |reader, field| {
            match field {
                "color" => background.color = reader.shown_color()?,
                "ambientLight" => background.ambient = reader.shown_color()?,
                _ => {
                    let (folder, ending) = (reader.file_name()?, reader.edition.ending_of_faces());
                    let name = |face| format!("{}/{face}.{ending}", folder.text);
                    cube_map = Some(FACES.map(|face| reader.images.index(name(face), folder.at)));
                }
            }
            Ok(())
        })
    })?;
    Ok((background, cube_map))
}

#[cfg(test)]
mod tests;
