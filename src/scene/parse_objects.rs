//! Reads groups and their objects without recursion, so any depth of nesting works.

use super::edition::Edition;
use super::filled_cells::{FilledCells, MOST, MOST_OF_SCENE};
use super::limits::SMALLEST_RADIUS;
use super::material::Material;
use super::parse_material::{PHONG_KINDS, parse_phong};
use super::reader::{Announced, NamedFiles, Parsed, Reader};
use super::transform::{TRANSFORMATIONS, Transformations, is_at_transformation, parse_transformations};
use super::{MaterialId, Object, ObjectId, Position};
use crate::diagnostic::Diagnostic;
use glam::DVec3;
use std::sync::Arc;

/// The keywords that start an object.
const OBJECTS: [&str; 8] =
    ["Group", "Transform", "Sphere", "Plane", "Triangle", "TriangleMesh", "Box", "Grid"];

/// The fields of a triangle's vertices, each preceded by the field of its texture coordinates.
const TRIANGLE_FIELDS: [[&str; 2]; 3] =
    [["textCoord0", "vertex0"], ["textCoord1", "vertex1"], ["textCoord2", "vertex2"]];

/// Quotes that a name may have by mistake.
const QUOTES: [char; 7] = ['"', '\'', '`', '\u{201c}', '\u{201d}', '\u{2018}', '\u{2019}'];

/// The objects read so far, with their meshes and materials.
#[derive(Default)]
pub struct ObjectTree {
    /// The arena. Every object comes after its children.
    pub objects: Vec<Object>,
    /// The position of each object's keyword.
    pub positions: Vec<Position>,
    pub meshes: NamedFiles,
    /// The cells of the objects that are grids, whose surfaces are not made yet.
    pub grids: Vec<(ObjectId, FilledCells)>,
    /// The number of these cells.
    cells: u64,
    /// The declared materials, followed by those written inside groups.
    pub materials: Vec<Material>,
    /// The position of each material's keyword.
    pub material_positions: Vec<Position>,
    /// The number of declared materials. Only these can be chosen by their index.
    declared: usize,
    /// The material of the following objects. As in the course's program, it stays in effect after the end of the group
    /// that chose it.
    current_material: Option<MaterialId>,
}

/// A group or transform whose closing brace has not been read yet.
enum Open {
    Group { announced: Announced, children: Vec<ObjectId>, at: Position },
    Transform { list: Transformations, has_child: bool, at: Position },
}

impl ObjectTree {
    /// Replaces the declared materials.
    pub fn declare(&mut self, materials: Vec<(Material, Position)>) {
        self.declared = materials.len();
        (self.materials, self.material_positions) = materials.into_iter().unzip();
    }

    /// Adds an object and returns its id.
    pub fn add(&mut self, object: Object, at: Position) -> ObjectId {
        self.objects.push(object);
        self.positions.push(at);
        self.objects.len() - 1
    }

    /// Reads a `Group` and its contents, and returns its id. Replaces the objects read before. Takes time linear in the
    /// length of the text, and constant stack space.
    pub fn parse_root(&mut self, reader: &mut Reader<'_>) -> Parsed<ObjectId> {
        let replaced = std::mem::take(&mut self.meshes).list.into_iter();
        reader.unread.extend(replaced.map(|(name, _)| ("mesh", name)));
        (self.objects, self.positions) = Default::default();
        (self.grids, self.cells) = Default::default();
        let mut innermost = Open::group(reader)?;
        let mut ancestors = vec![];
        loop {
            let is_at_object = self.find_object(reader, &mut innermost)?;
            let (word, at) = (reader.peek().text, reader.peek().at);
            if is_at_object && (word == "Group" || word == "Transform") {
                let inner = if word == "Group" { Open::group(reader)? } else { Open::transform(reader)? };
                ancestors.push(std::mem::replace(&mut innermost, inner));
                continue;
            }
            let child = if is_at_object {
                let object = self.parse_primitive(reader)?;
                self.add(object, at)
            } else {
                let id = self.close(reader, innermost)?;
                let Some(parent) = ancestors.pop() else { return Ok(id) };
                innermost = parent;
                id
            };
            match &mut innermost {
                Open::Group { children, .. } => children.push(child),
                Open::Transform { has_child, .. } => *has_child = true,
            }
        }
    }

    /// Reads the choices of material before the next object in `innermost`. Returns false if there is no further
    /// object.
    fn find_object(&mut self, reader: &mut Reader<'_>, innermost: &mut Open) -> Parsed<bool> {
        let announced = match innermost {
            Open::Group { announced, .. } => announced,
            Open::Transform { has_child: true, .. } => return Ok(false),
            Open::Transform { .. } if reader.is_at_any(&OBJECTS) => return Ok(true),
            Open::Transform { .. } => return Err(missing_object(reader)),
        };
        let before = reader.peek();
        self.parse_material_choices(reader)?;
        if reader.is_at_any(&OBJECTS) {
            announced.next_item(reader);
            return Ok(true);
        }
        if !announced.is_reached() && !reader.is_at("}") {
            return Err(reader.unexpected("an object", &OBJECTS));
        }
        if announced.is_reached() && before != reader.peek() {
            let problem = "must come before an object, but the group has no more";
            return Err(Diagnostic::error(format!("{} {problem}", before.quoted())).at(before.at));
        }
        Ok(false)
    }

    /// Reads the closing brace of a group or transform, and adds the object.
    fn close(&mut self, reader: &mut Reader<'_>, innermost: Open) -> Parsed<ObjectId> {
        match innermost {
            Open::Group { announced, children, at } => {
                announced.close(reader, "Group")?;
                Ok(self.add(Object::Group(children), at))
            }
            Open::Transform { list: Transformations { matrix, factors }, at, .. } => {
                reader.close("Transform").map_err(|error| {
                    if reader.is_at_any(&OBJECTS) {
                        return error.with_hint("a `Transform` holds one object; put several into a `Group`");
                    }
                    if is_at_transformation(reader) {
                        return error.with_hint("transformations come before the object that they move");
                    }
                    error
                })?;
                // The last object added is the child.
                let child = self.objects.len() - 1;
                Ok(self.add(Object::Transform { matrix, factors, child, at }, at))
            }
        }
    }

    /// Reads any number of choices of material: `MaterialIndex`, or a whole material as in the 2003 edition.
    fn parse_material_choices(&mut self, reader: &mut Reader<'_>) -> Parsed<()> {
        loop {
            let at = reader.peek().at;
            self.current_material = Some(if reader.is_at("MaterialIndex") {
                self.parse_material_index(reader)?
            } else if reader.is_at_any(&PHONG_KINDS) {
                self.materials.push(parse_phong(reader)?);
                self.material_positions.push(at);
                self.materials.len() - 1
            } else {
                return Ok(());
            });
        }
    }

    fn parse_material_index(&self, reader: &mut Reader<'_>) -> Parsed<MaterialId> {
        let at = reader.keyword("MaterialIndex")?.peek().at;
        let (index, declared) = (reader.whole()?, self.declared);
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

    fn parse_primitive(&mut self, reader: &mut Reader<'_>) -> Parsed<Object> {
        let word = reader.peek();
        let material = self.current_material.ok_or_else(|| {
            let error = Diagnostic::error(format!("the {} has no material", word.quoted()));
            error.at(word.at).with_hint("put a `MaterialIndex` before it")
        })?;
        reader.block(|reader, name| {
            Ok(match name {
                "Sphere" => {
                    let (center, radius) = parse_center_and_radius(reader)?;
                    Object::Sphere { center, radius, material }
                }
                "Plane" => {
                    let normal = reader.keyword("normal")?.direction()?;
                    Object::Plane { normal, offset: reader.keyword("offset")?.number()?, material }
                }
                "Triangle" => Object::Triangle { vertices: parse_vertices(reader)?, material },
                "TriangleMesh" => Object::Mesh { mesh: self.parse_mesh_name(reader)?, material },
                "Box" => {
                    let [min, max] = parse_corners(reader, "must not be below `min`", f64::ge)?;
                    Object::Box { min, max, material }
                }
                _ => {
                    self.add_cells(parse_cells(reader)?, word.at)?;
                    Object::Grid { surface: Arc::default(), material }
                }
            })
        })
    }

    /// Adds the cells of the next object, which is a grid.
    fn add_cells(&mut self, cells: FilledCells, at: Position) -> Parsed<()> {
        self.cells = self.cells.saturating_add(cells.count());
        if self.cells > MOST_OF_SCENE {
            let message = format!("up to here, the grids of the scene have {} cells", self.cells);
            let hint =
                format!("together they may have {MOST_OF_SCENE}, as many as one grid of 256 x 256 x 256");
            return Err(Diagnostic::error(message).at(at).with_hint(hint));
        }
        self.grids.push((self.objects.len(), cells));
        Ok(())
    }

    /// Reads `obj_file` and the file name. Returns the mesh's index.
    fn parse_mesh_name(&mut self, reader: &mut Reader<'_>) -> Parsed<usize> {
        let word = reader.keyword("obj_file")?.peek();
        if word.text.starts_with(QUOTES) {
            let problem = reader.bad_value(word, "must be a name without quotes");
            return Err(problem.with_hint("a name has neither quotes nor blanks"));
        }
        if !word.is_end()
            && !matches!(word.text, "{" | "}")
            && !word.text.to_ascii_lowercase().ends_with(".obj")
        {
            return Err(reader.bad_value(word, "must end in `.obj`"));
        }
        reader.file_name()?;
        Ok(self.meshes.index(word.text.to_owned(), word.at))
    }
}

impl Open {
    fn group(reader: &mut Reader<'_>) -> Parsed<Self> {
        let at = reader.open()?.at;
        Ok(Self::Group { announced: Announced::parse(reader, "numObjects")?, children: vec![], at })
    }

    fn transform(reader: &mut Reader<'_>) -> Parsed<Self> {
        let at = reader.open()?.at;
        Ok(Self::Transform { list: parse_transformations(reader)?, has_child: false, at })
    }
}

/// Returns the error that no object follows the transformations of a `Transform`.
fn missing_object(reader: &Reader<'_>) -> Diagnostic {
    let expected = "a transformation or an object";
    if reader.is_at("MaterialIndex") || reader.is_at_any(&PHONG_KINDS) {
        return reader.unexpected(expected, &[]).with_hint("choose the material before the `Transform`");
    }
    reader.unexpected(expected, &[&TRANSFORMATIONS[..], &OBJECTS].concat())
}

fn parse_center_and_radius(reader: &mut Reader<'_>) -> Parsed<(DVec3, f64)> {
    let center = reader.keyword("center")?.vector()?;
    let rule = "must be positive, and at least 1e-100";
    Ok((center, reader.keyword("radius")?.number_that(rule, |radius| radius >= SMALLEST_RADIUS)?))
}

fn parse_vertices(reader: &mut Reader<'_>) -> Parsed<[DVec3; 3]> {
    let mut vertices = [DVec3::ZERO; 3];
    for (vertex, [coordinates, name]) in vertices.iter_mut().zip(TRIANGLE_FIELDS) {
        // Aalto's program reads texture coordinates but does not store them in triangles.
        if reader.edition == Edition::Aalto && reader.accept(coordinates) {
            reader.number()?;
            reader.number()?;
        }
        *vertex = reader.keyword(name)?.vector()?;
    }
    Ok(vertices)
}

/// Reads `min` and `max`. `holds` compares each number of `max` with its counterpart in `min`.
fn parse_corners(reader: &mut Reader<'_>, rule: &str, holds: fn(&f64, &f64) -> bool) -> Parsed<[DVec3; 2]> {
    let min = reader.keyword("min")?.vector()?;
    reader.keyword("max")?;
    let mut number = |min: f64| reader.number_that(rule, |max| holds(&max, &min));
    Ok([min, DVec3::new(number(min.x)?, number(min.y)?, number(min.z)?)])
}

fn parse_cells(reader: &mut Reader<'_>) -> Parsed<FilledCells> {
    let [min, max] = parse_corners(reader, "must be above `min`", f64::gt)?;
    reader.keyword("numCells")?;
    let mut counts = [1; 3];
    for count in &mut counts {
        let word = reader.peek();
        *count = match reader.whole()? {
            number @ 1..=MOST => number as usize,
            _ => return Err(reader.bad_value(word, "must be from 1 to 256")),
        };
    }
    if !reader.is_at("rasterizeSphere") {
        return Err(reader.unexpected("`rasterizeSphere`", &["rasterizeSphere"]));
    }
    let (center, radius) = reader.block(|reader, _| parse_center_and_radius(reader))?;
    Ok(FilledCells { min, max, counts, center, radius })
}
