//! Reads the fields of primitives.

use super::limits::SMALLEST_RADIUS;
use super::reader::{Parsed, Reader};
use super::{MaterialId, Object};
use glam::DVec3;

/// The words with which an object begins: those of groups and transforms, and of primitives.
pub const OBJECTS: [&str; 7] = ["Group", "Transform", "Sphere", "Plane", "Triangle", "TriangleMesh", "Box"];

/// Those of primitives.
pub const PRIMITIVES: &[&str] = OBJECTS.split_at(2).1;

/// Reads the fields of the primitive with this name; none for a mesh, and for words that are no primitive's.
pub fn parse_primitive(name: &str, reader: &mut Reader<'_>, material: MaterialId) -> Option<Parsed<Object>> {
    Some(match name {
        "Sphere" => parse_sphere(reader, material),
        "Plane" => parse_plane(reader, material),
        "Triangle" => parse_triangle(reader, material),
        "Box" => parse_box(reader, material),
        _ => return None,
    })
}

fn parse_sphere(reader: &mut Reader<'_>, material: MaterialId) -> Parsed<Object> {
    let center = reader.vector_field("center")?;
    reader.keyword("radius")?;
    let rule = "must be positive, and at least 1e-100";
    let radius = reader.number_that("radius", rule, |radius| radius >= SMALLEST_RADIUS)?;
    Ok(Object::Sphere { center, radius, material })
}

fn parse_plane(reader: &mut Reader<'_>, material: MaterialId) -> Parsed<Object> {
    let normal = reader.direction_field("normal")?;
    let offset = reader.number_field("offset")?;
    Ok(Object::Plane { normal, offset, material })
}

fn parse_triangle(reader: &mut Reader<'_>, material: MaterialId) -> Parsed<Object> {
    let vertices =
        [reader.vector_field("vertex0")?, reader.vector_field("vertex1")?, reader.vector_field("vertex2")?];
    Ok(Object::Triangle { vertices, material })
}

fn parse_box(reader: &mut Reader<'_>, material: MaterialId) -> Parsed<Object> {
    let min = reader.vector_field("min")?;
    reader.keyword("max")?;
    let mut number_from = |min| reader.number_that("max", "must not be below `min`", |number| number >= min);
    let max = DVec3::new(number_from(min.x)?, number_from(min.y)?, number_from(min.z)?);
    Ok(Object::Box { min, max, material })
}
