//! Reads groups and the objects in them, without recursion, so that any depth of nesting works.

use super::list::Announced;
use super::material::Material;
use super::open_object::{Open, close_transform, open_group, open_transform};
use super::parse_material::{PHONG_KINDS, parse_phong};
use super::parse_primitive::{OBJECTS, PRIMITIVES, parse_primitive};
use super::reader::{Parsed, Reader, bad_value};
use super::transform::transformations;
use super::{MaterialId, MeshFile, Object, ObjectId, Position};
use crate::diagnostic::Diagnostic;
use std::collections::HashMap;

/// The objects of a scene that have been read so far, with the meshes and materials that they use.
#[derive(Default)]
pub struct ObjectTree {
    /// The arena, in which every object comes after its children.
    pub objects: Vec<Object>,
    /// Where each of them stands.
    pub positions: Vec<Position>,
    pub meshes: Vec<MeshFile>,
    mesh_indices: HashMap<String, usize>,
    /// The declared materials, followed by those written inside groups.
    pub materials: Vec<Material>,
    /// The position of each material's keyword.
    pub material_positions: Vec<Position>,
    /// The number of declared materials. Only these can be chosen by their index.
    declared: usize,
    /// The material of the following objects. As in the course's program, it stays in effect after the group
    /// in which it was chosen.
    current_material: Option<MaterialId>,
}

/// What a name may stand between, by mistake.
const QUOTES: [char; 7] = ['"', '\'', '`', '\u{201c}', '\u{201d}', '\u{2018}', '\u{2019}'];

/// The result of one step of reading.
enum Step {
    /// The start of a group or transform.
    Opened(Open),
    /// A whole primitive.
    Finished(Object, Position),
    /// The end of the innermost open object.
    Closed(Object, Position),
}

impl ObjectTree {
    /// Replaces the declared materials.
    pub fn declare(&mut self, materials: Vec<(Material, Position)>) {
        self.declared = materials.len();
        (self.materials, self.material_positions) = materials.into_iter().unzip();
    }

    /// Reads a `Group` and everything in it, which replaces the objects read before, and returns its id. The time is
    /// linear in the length of the text, and the stack has constant size.
    pub fn parse_root(&mut self, reader: &mut Reader<'_>) -> Parsed<ObjectId> {
        self.objects.clear();
        self.positions.clear();
        self.meshes.clear();
        self.mesh_indices.clear();
        let mut innermost = open_group(reader)?;
        let mut ancestors = Vec::new();
        loop {
            match self.step(reader, &mut innermost)? {
                Step::Opened(inner) => {
                    ancestors.push(std::mem::replace(&mut innermost, inner));
                }
                Step::Finished(object, at) => {
                    let id = self.add(object, at);
                    innermost.add_child(id);
                }
                Step::Closed(object, at) => {
                    let id = self.add(object, at);
                    let Some(parent) = ancestors.pop() else { return Ok(id) };
                    innermost = parent;
                    innermost.add_child(id);
                }
            }
        }
    }

    fn add(&mut self, object: Object, at: Position) -> ObjectId {
        self.objects.push(object);
        self.positions.push(at);
        self.objects.len() - 1
    }

    fn step(&mut self, reader: &mut Reader<'_>, innermost: &mut Open) -> Parsed<Step> {
        match innermost {
            Open::Group { announced, children, at } => self.step_in_group(reader, announced, children, *at),
            Open::Transform { matrix, at, child: Some(child) } => {
                close_transform(reader)?;
                Ok(Step::Closed(Object::Transform { matrix: *matrix, child: *child, at: *at }, *at))
            }
            Open::Transform { child: None, .. } => self.parse_transformed_object(reader),
        }
    }

    /// Reads the next object of a group and the choices of material before it, or the end of the group.
    fn step_in_group(
        &mut self,
        reader: &mut Reader<'_>,
        announced: &mut Announced,
        children: &mut Vec<ObjectId>,
        at: Position,
    ) -> Parsed<Step> {
        let is_full = announced.is_reached(children.len());
        let before = reader.peek();
        self.parse_material_choices(reader)?;
        if !reader.is_at("}") && (reader.is_at_any(&OBJECTS) || !is_full) {
            announced.next_item(reader, children.len());
            return self.parse_object(reader, "an object", &OBJECTS);
        }
        if is_full && before != reader.peek() {
            let message = format!(
                "{} must stand before an object, but the group's last object is past",
                before.quoted()
            );
            return Err(Diagnostic::error(message).at(before.at));
        }
        announced.close(reader, "Group", children.len())?;
        Ok(Step::Closed(Object::Group(std::mem::take(children)), at))
    }

    /// Reads any number of choices of material: `MaterialIndex`, or a whole material as in the 2003 edition.
    fn parse_material_choices(&mut self, reader: &mut Reader<'_>) -> Parsed<()> {
        loop {
            if reader.is_at("MaterialIndex") {
                self.current_material = Some(self.parse_material_index(reader)?);
            } else if reader.is_at_any(&PHONG_KINDS) {
                self.parse_own_material(reader)?;
            } else {
                return Ok(());
            }
        }
    }

    fn parse_own_material(&mut self, reader: &mut Reader<'_>) -> Parsed<()> {
        self.material_positions.push(reader.peek().at);
        self.materials.push(parse_phong(reader)?);
        self.current_material = Some(self.materials.len() - 1);
        Ok(())
    }

    /// Reads `MaterialIndex` and the index.
    fn parse_material_index(&self, reader: &mut Reader<'_>) -> Parsed<MaterialId> {
        reader.keyword("MaterialIndex")?;
        let at = reader.peek().at;
        let (index, declared) = (reader.whole("MaterialIndex")?, self.declared);
        let known = usize::try_from(index).ok().filter(|&index| index < declared);
        known.ok_or_else(|| {
            let all = match declared {
                0 => "none is declared".to_owned(),
                1 => "only material 0 is declared".to_owned(),
                _ => format!("materials 0 to {} are declared", declared - 1),
            };
            Diagnostic::error(format!("there is no material {index}: {all}")).at(at)
        })
    }

    fn parse_transformed_object(&mut self, reader: &mut Reader<'_>) -> Parsed<Step> {
        let keywords = [transformations(reader.edition), OBJECTS.as_slice()].concat();
        let what = "a transformation or an object";
        if reader.is_at("MaterialIndex") || reader.is_at_any(&PHONG_KINDS) {
            return Err(reader.unexpected(what, &[]).with_hint("choose the material before the `Transform`"));
        }
        self.parse_object(reader, what, &keywords)
    }

    /// Reads a whole primitive, or the start of a group or transform. `what` and `keywords` describe the
    /// words that are allowed here, for the error message.
    fn parse_object(&mut self, reader: &mut Reader<'_>, what: &str, keywords: &[&str]) -> Parsed<Step> {
        match reader.peek().text {
            "Group" => open_group(reader).map(Step::Opened),
            "Transform" => open_transform(reader).map(Step::Opened),
            word if PRIMITIVES.contains(&word) => {
                let at = reader.peek().at;
                self.parse_primitive(reader).map(|object| Step::Finished(object, at))
            }
            _ => Err(reader.unexpected(what, keywords)),
        }
    }

    fn parse_primitive(&mut self, reader: &mut Reader<'_>) -> Parsed<Object> {
        let word = reader.peek();
        let material = self.current_material.ok_or_else(|| {
            let error = Diagnostic::error(format!("the {} has no material", word.quoted()));
            error.at(word.at).with_hint("put a `MaterialIndex` before it")
        })?;
        let name = reader.open()?.text;
        let object = match name {
            "TriangleMesh" => Object::Mesh { mesh: self.parse_mesh_name(reader)?, material },
            _ => match parse_primitive(name, reader, material) {
                Some(object) => object?,
                None => return Err(reader.unexpected("the values of another object", &OBJECTS)),
            },
        };
        reader.close(name)?;
        Ok(object)
    }

    /// Reads `obj_file` and the file name, and returns the mesh's index.
    fn parse_mesh_name(&mut self, reader: &mut Reader<'_>) -> Parsed<usize> {
        reader.keyword("obj_file")?;
        let word = reader.peek();
        if word.is_end() || matches!(word.text, "{" | "}") {
            return Err(reader.unexpected("a file name for `obj_file`", &[]));
        }
        if word.text.starts_with(QUOTES) {
            let problem = bad_value(word, "obj_file", "must be a name without quotes");
            return Err(problem.with_hint("a name has neither quotes nor blanks"));
        }
        if !word.text.to_ascii_lowercase().ends_with(".obj") {
            return Err(bad_value(word, "obj_file", "must end in `.obj`"));
        }
        reader.take();
        Ok(self.mesh_index(word.text, word.at))
    }

    fn mesh_index(&mut self, name: &str, at: Position) -> usize {
        if let Some(&index) = self.mesh_indices.get(name) {
            return index;
        }
        let index = self.meshes.len();
        self.meshes.push(MeshFile { name: name.to_owned(), at, ..MeshFile::default() });
        self.mesh_indices.insert(name.to_owned(), index);
        index
    }
}
