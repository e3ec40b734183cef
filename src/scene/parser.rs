//! Parses scene text to a [`Scene`]: the course's grammar of 2004, and the forms of 2003 that differ from it.

use super::error::{Problem, SceneError};
use super::list::counted_list;
use super::parse_material::parse_materials;
use super::parse_object::ObjectTree;
use super::reader::{Parsed, Reader};
use super::{Background, Camera, Light, ObjectId, Scene};
use crate::math::robust::unit;
use glam::DVec3;

const BLOCKS: [&str; 6] =
    ["OrthographicCamera", "PerspectiveCamera", "Background", "Lights", "Materials", "Group"];
const LIGHTS: [&str; 2] = ["DirectionalLight", "PointLight"];
const BACKGROUND_FIELDS: [&str; 2] = ["color", "ambientLight"];

/// Parses a scene. Its mesh files are named in the result, but not opened.
///
/// Blocks may come in any order, except that `Materials` must precede the `Group`, and a later block replaces
/// an earlier one of its kind. Errors: the first violation of the grammar or of a rule for values, with its
/// position.
pub fn parse(text: &str) -> Result<Scene, SceneError> {
    let mut reader = Reader::new(text);
    let mut blocks = Blocks::default();
    while !reader.peek().is_end() {
        blocks.parse_block(&mut reader)?;
    }
    blocks.into_scene(&reader)
}

/// The blocks read so far.
#[derive(Default)]
struct Blocks {
    camera: Option<Camera>,
    background: Background,
    lights: Vec<Light>,
    tree: ObjectTree,
    root: Option<ObjectId>,
}

impl Blocks {
    fn parse_block(&mut self, reader: &mut Reader<'_>) -> Parsed<()> {
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

    fn parse_materials(&mut self, reader: &mut Reader<'_>) -> Parsed<()> {
        if self.root.is_some() {
            return Err(SceneError::new(reader.peek().at, Problem::MaterialsAfterGroup));
        }
        Ok(self.tree.declare(parse_materials(reader)?)?)
    }

    fn into_scene(self, reader: &Reader<'_>) -> Parsed<Scene> {
        let missing = |block| SceneError::new(reader.peek().at, Problem::Missing { block });
        let camera = self.camera.ok_or_else(|| missing("camera"))?;
        let root = self.root.ok_or_else(|| missing("group"))?;
        Ok(Scene {
            camera,
            background: self.background,
            lights: self.lights,
            materials: self.tree.materials,
            material_positions: self.tree.material_positions,
            objects: self.tree.objects,
            positions: self.tree.positions,
            root,
            meshes: self.tree.meshes,
        })
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

fn parse_orthographic_camera(reader: &mut Reader<'_>) -> Parsed<Camera> {
    let name = reader.open()?.text;
    let (center, direction, up) = parse_view(reader)?;
    let size = reader.positive_field("size")?;
    reader.close(name)?;
    Ok(Camera::Orthographic { center, direction, up, size })
}

fn parse_perspective_camera(reader: &mut Reader<'_>) -> Parsed<Camera> {
    let name = reader.open()?.text;
    let (center, direction, up) = parse_view(reader)?;
    reader.keyword("angle")?;
    let rule = "must be above 0 and below 180 degrees";
    let angle = reader.number_that("angle", rule, |angle| angle > 0.0 && angle < 180.0)?;
    reader.close(name)?;
    Ok(Camera::Perspective { center, direction, up, angle })
}

/// Reads the fields that both cameras share: center, direction and up.
fn parse_view(reader: &mut Reader<'_>) -> Parsed<(DVec3, DVec3, DVec3)> {
    let center = reader.vector_field("center")?;
    let direction = reader.direction_field("direction")?;
    reader.keyword("up")?;
    let at = reader.peek().at;
    let up = reader.nonzero_vector("up")?;
    if are_parallel(direction, up) {
        return Err(SceneError::new(at, Problem::UpAlongDirection));
    }
    Ok((center, direction, up))
}

/// Whether two nonzero vectors are parallel, up to rounding.
fn are_parallel(a: DVec3, b: DVec3) -> bool {
    const MAX_SINE: f64 = 1e-12;
    unit(a).cross(unit(b)).length() < MAX_SINE
}

/// Reads the background. Both fields are optional, and a repeated field replaces the earlier one.
fn parse_background(reader: &mut Reader<'_>) -> Parsed<Background> {
    let name = reader.open()?.text;
    let mut background = Background::default();
    loop {
        if reader.accept("color") {
            background.color = reader.color("color")?;
        } else if reader.accept("ambientLight") {
            background.ambient = reader.color("ambientLight")?;
        } else if reader.is_at("}") {
            reader.close(name)?;
            return Ok(background);
        } else {
            return Err(reader.unexpected("`color`, `ambientLight` or `}`", &BACKGROUND_FIELDS));
        }
    }
}

fn parse_lights(reader: &mut Reader<'_>) -> Parsed<Vec<Light>> {
    let name = reader.open()?.text;
    counted_list(reader, name, "numLights", &LIGHTS, |reader, _| parse_light(reader))
}

fn parse_light(reader: &mut Reader<'_>) -> Parsed<Light> {
    match reader.peek().text {
        "DirectionalLight" => parse_directional_light(reader),
        "PointLight" => parse_point_light(reader),
        _ => Err(reader.unexpected("a light", &LIGHTS)),
    }
}

fn parse_directional_light(reader: &mut Reader<'_>) -> Parsed<Light> {
    let name = reader.open()?.text;
    let direction = reader.direction_field("direction")?;
    let color = reader.color_field("color")?;
    reader.close(name)?;
    Ok(Light::Directional { direction, color })
}

fn parse_point_light(reader: &mut Reader<'_>) -> Parsed<Light> {
    let name = reader.open()?.text;
    let position = reader.vector_field("position")?;
    let color = reader.color_field("color")?;
    let constant = DVec3::X;
    let has_attenuation = reader.accept("attenuation");
    let attenuation = if has_attenuation { reader.vector("attenuation")? } else { constant };
    if !has_attenuation && !reader.is_at("}") {
        return Err(
            reader.unexpected(&format!("`attenuation` or `}}` at the end of `{name}`"), &["attenuation"])
        );
    }
    reader.close(name)?;
    Ok(Light::Point { position, color, attenuation: attenuation.to_array() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::material::{Material, Phong};
    use crate::scene::{MeshFile, Object, Position};
    use glam::DAffine3;

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

    #[test]
    fn nearly_parallel_is_not_parallel() {
        assert!(are_parallel(DVec3::ONE, DVec3::ONE * -3.0));
        assert!(are_parallel(DVec3::ONE * 1e-300, DVec3::ONE * 1e300));
        assert!(!are_parallel(DVec3::Y, DVec3::new(1e-6, 1.0, 0.0)));
    }

    #[test]
    fn vectors_are_parallel_within_less_than_1e_12() {
        let parallel = |angle: f64| are_parallel(DVec3::X * 3.0, DVec3::new(-1.0, angle, 0.0));
        assert_eq!([0.0, 0.99e-12, 1e-12, 1e-9].map(parallel), [true, true, false, false]);
    }
}
