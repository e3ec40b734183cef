//! Reads the fields of primitives.

use super::edition::Edition;
use super::filled_cells::{FilledCells, MOST};
use super::limits::SMALLEST_RADIUS;
use super::reader::{Parsed, Reader, bad_value};
use super::{MaterialId, Object};
use glam::DVec3;
use std::sync::Arc;

/// The words with which an object begins: those of groups and transforms, and of primitives.
pub const OBJECTS: [&str; 8] =
    ["Group", "Transform", "Sphere", "Plane", "Triangle", "TriangleMesh", "Box", "Grid"];

/// Those of primitives.
pub const PRIMITIVES: &[&str] = OBJECTS.split_at(2).1;

/// The fields of a triangle's vertices, each after that of its texture coordinates.
const TRIANGLE_FIELDS: [[&str; 2]; 3] =
    [["textCoord0", "vertex0"], ["textCoord1", "vertex1"], ["textCoord2", "vertex2"]];

/// Reads the fields of the primitive with this name; none for a mesh, and for words that are no primitive's.
pub fn parse_primitive(name: &str, reader: &mut Reader<'_>, material: MaterialId) -> Option<Parsed<Object>> {
    Some(match name {
        "Sphere" => parse_sphere(reader, material),
        "Plane" => parse_plane(reader, material),
        "Triangle" => parse_triangle(reader, material),
        "Box" => parse_box(reader, material),
        "Grid" => parse_grid(reader, material),
        _ => return None,
    })
}

fn parse_sphere(reader: &mut Reader<'_>, material: MaterialId) -> Parsed<Object> {
    let (center, radius) = parse_center_and_radius(reader)?;
    Ok(Object::Sphere { center, radius, material })
}

fn parse_center_and_radius(reader: &mut Reader<'_>) -> Parsed<(DVec3, f64)> {
    let center = reader.vector_field("center")?;
    reader.keyword("radius")?;
    let rule = "must be positive, and at least 1e-100";
    Ok((center, reader.number_that("radius", rule, |radius| radius >= SMALLEST_RADIUS)?))
}

fn parse_plane(reader: &mut Reader<'_>, material: MaterialId) -> Parsed<Object> {
    let normal = reader.direction_field("normal")?;
    let offset = reader.number_field("offset")?;
    Ok(Object::Plane { normal, offset, material })
}

fn parse_triangle(reader: &mut Reader<'_>, material: MaterialId) -> Parsed<Object> {
    let mut vertices = [DVec3::ZERO; 3];
    for (vertex, [coordinates, name]) in vertices.iter_mut().zip(TRIANGLE_FIELDS) {
        // Aalto's program reads texture coordinates, and its triangles have none.
        if reader.edition == Edition::Aalto && reader.accept(coordinates) {
            reader.number(coordinates)?;
            reader.number(coordinates)?;
        }
        *vertex = reader.vector_field(name)?;
    }
    Ok(Object::Triangle { vertices, material })
}

fn parse_box(reader: &mut Reader<'_>, material: MaterialId) -> Parsed<Object> {
    let min = reader.vector_field("min")?;
    reader.keyword("max")?;
    let mut number_from = |min| reader.number_that("max", "must not be below `min`", |number| number >= min);
    let max = DVec3::new(number_from(min.x)?, number_from(min.y)?, number_from(min.z)?);
    Ok(Object::Box { min, max, material })
}

fn parse_grid(reader: &mut Reader<'_>, material: MaterialId) -> Parsed<Object> {
    let min = reader.vector_field("min")?;
    reader.keyword("max")?;
    let mut number_above = |min| reader.number_that("max", "must be above `min`", |number| number > min);
    let max = DVec3::new(number_above(min.x)?, number_above(min.y)?, number_above(min.z)?);
    reader.keyword("numCells")?;
    let mut counts = [1; 3];
    for count in &mut counts {
        let word = reader.peek();
        *count = match reader.whole("numCells")? {
            number @ 1..=MOST => number as usize,
            _ => return Err(bad_value(word, "numCells", "must be from 1 to 256")),
        };
    }
    if !reader.is_at("rasterizeSphere") {
        return Err(reader.unexpected("`rasterizeSphere`", &["rasterizeSphere"]));
    }
    let word = reader.open()?;
    let (center, radius) = parse_center_and_radius(reader)?;
    reader.close(word.text)?;
    let surface = FilledCells { min, max, counts, center, radius }.surface();
    Ok(Object::Grid { surface: Arc::new(surface?), material })
}
