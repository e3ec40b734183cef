//! Parses scene text to a [`Scene`]: the course's grammar of 2004, and the forms of 2003 that differ from it.

use super::error::{Problem, SceneError};
use super::parse_camera::{parse_orthographic_camera, parse_perspective_camera};
use super::parse_light::parse_lights;
use super::parse_material::parse_materials;
use super::parse_object::{self, ObjectTree};
use super::reader::{Parsed, Reader};
use super::recovery::Findings;
use super::warning::{self, Doubt, SceneWarning};
use super::{Background, Camera, Light, ObjectId, Position, Scene};

const BLOCKS: [&str; 6] =
    ["OrthographicCamera", "PerspectiveCamera", "Background", "Lights", "Materials", "Group"];
/// How the keywords of each kind of block end, and what a reader calls it.
const KINDS: [&str; 5] = ["Camera", "Background", "Lights", "Materials", "Group"];
const NOUNS: [&str; 5] = ["camera", "`Background`", "list of lights", "list of materials", "`Group`"];
const BACKGROUND_FIELDS: [&str; 2] = ["color", "ambientLight"];

/// A scene with what its text says beyond it.
#[derive(Clone, Debug)]
pub struct Reading {
    /// The scene. Its mesh files are named in it, but not opened.
    pub scene: Scene,
    /// What the text says without an error, but hardly on purpose.
    pub warnings: Vec<SceneWarning>,
    /// Where the text says it.
    pub places: Places,
}

/// The positions of keywords in the text of a scene.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Places {
    /// The camera's.
    pub camera: Position,
    /// Those of the lights, in the order of [`Scene::lights`].
    pub lights: Vec<Position>,
}

/// Parses a scene, as [`read`] does. Errors: the first violation of the grammar or of a rule for values, with
/// its position.
pub fn parse(text: &str) -> Result<Scene, SceneError> {
    match read(text) {
        Ok(reading) => Ok(reading.scene),
        Err(mut errors) => Err(errors.swap_remove(0)),
    }
}

/// Parses a scene.
///
/// Blocks may come in any order, except that `Materials` must precede the `Group`, and a later block replaces
/// an earlier one of its kind. Errors: at least one and at most ten, in the order of the text. None of them is
/// only a consequence of another.
pub fn read(text: &str) -> Result<Reading, Vec<SceneError>> {
    let mut reader = Reader::new(text);
    let mut blocks = Blocks::default();
    while !reader.peek().is_end() {
        let block = reader.peek().text;
        if let Err(error) = blocks.parse_block(&mut reader) {
            if let Problem::Memory(_) = error.problem {
                return Err(vec![error]);
            }
            reader.recover_block(error, block);
        }
    }
    let parsed = blocks.into_scene(&mut reader);
    let Findings { mut errors, warnings, .. } = reader.findings;
    match parsed {
        Some((scene, places)) if errors.is_empty() => {
            Ok(Reading { scene, warnings: warning::merged(warnings), places })
        }
        _ => {
            errors.sort_by_key(|error| (error.at.line, error.at.column));
            Err(errors)
        }
    }
}

impl Reader<'_> {
    /// Records an error of the block with this keyword, and goes on with the next block.
    fn recover_block(&mut self, error: SceneError, block: &str) {
        // After another error, a brace that closes nothing may be due to a missing one.
        if !self.is_at("}") || self.depth > 0 || self.findings.errors.is_empty() {
            self.report(error);
        }
        let is_balanced = self.is_balanced();
        let is_whole = is_balanced && self.skip_item(0);
        // What stands outside of any group after a first such object says nothing new.
        if is_whole && !parse_object::OBJECTS.contains(&block) {
            return;
        }
        // A group may hold groups, but no other block.
        let is_in_group = block == "Group" && self.depth > 0;
        let starts: Vec<&str> =
            BLOCKS.into_iter().filter(|&start| !is_in_group || start != "Group").collect();
        while !self.peek().is_end() && !(self.is_at_any(&starts) && (self.depth == 0 || !is_balanced)) {
            self.take();
        }
        self.depth = 0;
    }
}

/// Parses the block of a camera alone. Errors: anything else, or anything after it.
pub fn parse_camera(text: &str) -> Result<Camera, SceneError> {
    let mut reader = Reader::new(text);
    let camera = match reader.peek().text {
        "OrthographicCamera" => parse_orthographic_camera(&mut reader)?,
        "PerspectiveCamera" => parse_perspective_camera(&mut reader)?,
        _ => return Err(reader.unexpected("a camera", &BLOCKS[..2])),
    };
    if !reader.peek().is_end() {
        return Err(reader.unexpected("the end of the camera", &[]));
    }
    reader.findings.errors.into_iter().next().map_or(Ok(camera), Err)
}

/// The blocks read so far.
#[derive(Default)]
struct Blocks {
    camera: Option<Camera>,
    background: Background,
    lights: Vec<(Light, Position)>,
    tree: ObjectTree,
    root: Option<ObjectId>,
    /// The position of the last block of each kind, in the order of [`KINDS`].
    places: [Option<Position>; KINDS.len()],
}

impl Blocks {
    fn parse_block(&mut self, reader: &mut Reader<'_>) -> Parsed<()> {
        self.note_block(reader);
        match reader.peek().text {
            "OrthographicCamera" => self.camera = Some(parse_orthographic_camera(reader)?),
            "PerspectiveCamera" => self.camera = Some(parse_perspective_camera(reader)?),
            "Background" => self.background = parse_background(reader)?,
            "Lights" => self.lights = parse_lights(reader)?,
            "Materials" => self.parse_materials(reader)?,
            "Group" => self.root = Some(self.tree.parse_root(reader)?),
            _ => return Err(unknown_block(reader)),
        }
        Ok(())
    }

    /// Notes the position of the block at the next word, and whether it is the second of its kind.
    fn note_block(&mut self, reader: &mut Reader<'_>) {
        let at = reader.peek().at;
        let Some(kind) = KINDS.iter().position(|kind| reader.peek().text.ends_with(kind)) else { return };
        if let Some(earlier) = self.places[kind].replace(at) {
            let doubt = Doubt::Replaces { block: NOUNS[kind], earlier: earlier.line };
            reader.findings.warnings.push(SceneWarning { at, doubt });
        }
    }

    fn parse_materials(&mut self, reader: &mut Reader<'_>) -> Parsed<()> {
        if self.root.is_some() {
            reader.report(SceneError::new(reader.peek().at, Problem::MaterialsAfterGroup));
        }
        let errors = reader.findings.errors.len();
        let materials = parse_materials(reader);
        let is_short = |error: &SceneError| matches!(error.problem, Problem::TooFew { .. });
        self.tree.knows_materials =
            materials.is_ok() && !reader.findings.errors[errors..].iter().any(is_short);
        self.tree.declare(materials?)?;
        Ok(())
    }

    /// The scene. A missing block is recorded, unless an error may have hidden it.
    fn into_scene(self, reader: &mut Reader<'_>) -> Option<(Scene, Places)> {
        for (is_missing, block) in [(self.camera.is_none(), "camera"), (self.root.is_none(), "group")] {
            if is_missing && reader.findings.errors.is_empty() {
                reader.report(SceneError::new(reader.peek().at, Problem::Missing { block }));
            }
        }
        let (lights, places) = self.lights.into_iter().unzip();
        let scene = Scene {
            camera: self.camera?,
            background: self.background,
            lights,
            materials: self.tree.materials,
            material_positions: self.tree.material_positions,
            objects: self.tree.objects,
            positions: self.tree.positions,
            root: self.root?,
            meshes: self.tree.meshes,
        };
        Some((scene, Places { camera: self.places[0].unwrap_or_default(), lights: places }))
    }
}

fn unknown_block(reader: &Reader<'_>) -> SceneError {
    let error = reader.unexpected("a camera, `Background`, `Lights`, `Materials` or `Group`", &BLOCKS);
    match reader.peek().text {
        "}" => error.with_hint("this brace closes nothing"),
        "Sphere" | "Plane" | "Triangle" | "TriangleMesh" | "Box" | "Transform" | "MaterialIndex" => {
            error.with_hint("objects and their materials go inside a `Group`")
        }
        _ => error,
    }
}

/// Reads the background. Both fields are optional, and a repeated field replaces the earlier one.
fn parse_background(reader: &mut Reader<'_>) -> Parsed<Background> {
    let name = reader.open()?.text;
    let mut background = Background::default();
    loop {
        if reader.accept("color") {
            background.color = reader.shown_color("color")?;
        } else if reader.accept("ambientLight") {
            background.ambient = reader.shown_color("ambientLight")?;
        } else if reader.is_at("}") {
            reader.close(name)?;
            return Ok(background);
        } else {
            return Err(reader.unexpected("`color`, `ambientLight` or `}`", &BACKGROUND_FIELDS));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::material::{Material, Phong};
    use crate::scene::{MeshFile, Object, Position};
    use glam::{DAffine3, DVec3};

    const CAMERA: &str = "PerspectiveCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 angle 30 }";

    fn objects(group: &str) -> Scene {
        let materials = "Materials { numMaterials 2 Material { } Material { } }";
        parse(&format!("{CAMERA} {materials} {group}")).unwrap()
    }

    #[test]
    fn the_smallest_scene() {
        let scene = parse(&format!("{CAMERA} Group {{ numObjects 0 }}")).unwrap();
        assert_eq!(scene.objects, [Object::Group(vec![])]);
        assert_eq!((scene.root, scene.background), (0, Background::default()));
        assert!(scene.lights.is_empty() && scene.materials.is_empty() && scene.meshes.is_empty());
    }

    #[test]
    fn cameras_lights_and_background() {
        let text = "Group { numObjects 0 }
            Lights { numLights 2 PointLight { position 1 2 3 color 1 1 1 attenuation 0 1 2 }
                                 DirectionalLight { direction 0 -1 0 color .5 0 -1 } }
            Background { ambient_light .1 .2 .3 color 1 0 0 }
            OrthographicCamera { center 1 2 3 direction 0 0 -2 up 0 1 1 size 4 }";
        let scene = parse(text).unwrap();
        let camera = Camera::Orthographic {
            center: DVec3::new(1.0, 2.0, 3.0),
            direction: DVec3::new(0.0, 0.0, -2.0),
            up: DVec3::new(0.0, 1.0, 1.0),
            size: 4.0,
        };
        assert_eq!(scene.camera, camera);
        assert_eq!(scene.background, Background { color: DVec3::X, ambient: DVec3::new(0.1, 0.2, 0.3) });
        let position = DVec3::new(1.0, 2.0, 3.0);
        assert_eq!(
            scene.lights[0],
            Light::Point { position, color: DVec3::ONE, attenuation: [0.0, 1.0, 2.0] }
        );
        let color = DVec3::new(0.5, 0.0, -1.0);
        assert_eq!(scene.lights[1], Light::Directional { direction: DVec3::NEG_Y, color });
    }

    #[test]
    fn every_object_has_the_position_of_its_keyword() {
        let group = "Group { numObjects 2 MaterialIndex 1 Sphere { center 0 0 0 radius 1 }
            Transform { Scale 1 1 1 Group { numObjects 1 Box { min 0 0 0 max 1 1 0 } } } }";
        // The later group replaces the earlier one.
        let scene = objects(&format!("{group}\n\n{group}"));
        let at = |line, column| Position { line, column };
        // Sphere, box, inner group, transform, outer group: each after its children.
        assert_eq!(scene.positions, [at(4, 38), at(5, 58), at(5, 37), at(5, 13), at(4, 1)]);
    }

    #[test]
    fn every_primitive() {
        let scene = objects(
            "Group { numObjects 5 MaterialIndex 1 Sphere { center 0 0 0 radius 1 } Plane { normal 0 2 0 offset -1 }
             Triangle { vertex0 1 0 0 vertex1 0 1 0 vertex2 0 0 1 } MaterialIndex 1 MaterialIndex 0
             TriangleMesh { obj_file a/b.obj } Box { min 0 0 0 max 1 1 0 } }",
        );
        let expected = [
            Object::Sphere { center: DVec3::ZERO, radius: 1.0, material: 1 },
            Object::Plane { normal: DVec3::Y * 2.0, offset: -1.0, material: 1 },
            Object::Triangle { vertices: [DVec3::X, DVec3::Y, DVec3::Z], material: 1 },
            Object::Mesh { mesh: 0, material: 0 },
            Object::Box { min: DVec3::ZERO, max: DVec3::new(1.0, 1.0, 0.0), material: 0 },
            Object::Group(vec![0, 1, 2, 3, 4]),
        ];
        assert_eq!(scene.objects, expected);
    }

    #[test]
    fn objects_come_after_their_children() {
        let sphere = "Sphere { center 0 0 0 radius 1 }";
        let scene = objects(&format!(
            "Group {{ numObjects 2 MaterialIndex 0\nGroup {{ numObjects 1 {sphere} }}\n  Transform {{ Scale 1 2 1 {sphere} }} }}"
        ));
        let matrix = DAffine3::from_scale(DVec3::new(1.0, 2.0, 1.0));
        assert_eq!(scene.objects[1], Object::Group(vec![0]));
        assert_eq!(
            scene.objects[3],
            Object::Transform { matrix, child: 2, at: Position { line: 3, column: 3 } }
        );
        assert_eq!((scene.root, &scene.objects[4]), (4, &Object::Group(vec![1, 3])));
    }

    #[test]
    fn a_material_outlasts_its_group() {
        let scene = objects(
            "Group { numObjects 2 Group { numObjects 1 MaterialIndex 1 Plane { normal 0 1 0 offset 0 } }
             Plane { normal 0 1 0 offset 0 } }",
        );
        assert_eq!(scene.objects[2], Object::Plane { normal: DVec3::Y, offset: 0.0, material: 1 });
    }

    #[test]
    fn materials_inside_groups_follow_the_declared_ones() {
        let scene = objects(
            "Group { num_objects 2 Material { diffuse_color 1 0 0 } Plane { normal 0 1 0 offset 0 }
             Material { diffuseColor 0 1 0 } Material { diffuseColor 0 0 1 } Plane { normal 0 1 0 offset 0 } }",
        );
        let material = |diffuse| Material::Phong(Phong { diffuse, ..Phong::default() });
        assert_eq!(scene.materials[2..], [material(DVec3::X), material(DVec3::Y), material(DVec3::Z)]);
        assert_eq!(scene.material_positions.len(), scene.materials.len());
        assert_eq!(scene.objects[0], Object::Plane { normal: DVec3::Y, offset: 0.0, material: 2 });
        assert_eq!(scene.objects[1], Object::Plane { normal: DVec3::Y, offset: 0.0, material: 4 });
    }

    #[test]
    fn each_mesh_is_named_once() {
        let mesh = |name: &str| format!("TriangleMesh {{ obj_file {name}.obj }}");
        let scene = objects(&format!(
            "Group {{ numObjects 3 MaterialIndex 0\n{} {} {} }}",
            mesh("a"),
            mesh("b"),
            mesh("a")
        ));
        let at = |column| Position { line: 2, column };
        let named = |name: &str, column| MeshFile { name: name.into(), at: at(column) };
        assert_eq!(scene.meshes, [named("a.obj", 25), named("b.obj", 57)]);
        assert_eq!(scene.objects[2], Object::Mesh { mesh: 0, material: 0 });
    }

    #[test]
    fn later_blocks_replace_earlier_ones() {
        let scene = parse(&format!(
            "OrthographicCamera {{ center 0 0 0 direction 0 0 1 up 0 1 0 size 1 }} {CAMERA}
             Materials {{ numMaterials 1 Material {{ }} }} Materials {{ numMaterials 0 }}
             Group {{ numObjects 1 Material {{ }} TriangleMesh {{ obj_file a.obj }} }} Group {{ numObjects 0 }}"
        ))
        .unwrap();
        assert!(matches!(scene.camera, Camera::Perspective { .. }));
        assert_eq!((scene.objects, scene.meshes), (vec![Object::Group(vec![])], vec![]));
    }
}
