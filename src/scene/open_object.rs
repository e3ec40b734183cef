//! Groups and transforms that are being read.

use super::list::Announced;
use super::parse_primitive::OBJECTS;
use super::reader::{Parsed, Reader};
use super::transform::{parse_transformations, transformations};
use super::{ObjectId, Position};
use crate::math::rounded::RoundedAffine;

/// A group or transform whose closing brace has not been read yet.
pub enum Open {
    Group { announced: Announced, children: Vec<ObjectId>, at: Position },
    Transform { matrix: RoundedAffine, at: Position, child: Option<ObjectId> },
}

impl Open {
    pub fn add_child(&mut self, id: ObjectId) {
        match self {
            Self::Group { children, .. } => children.push(id),
            Self::Transform { child, .. } => *child = Some(id),
        }
    }
}

pub fn open_group(reader: &mut Reader<'_>) -> Parsed<Open> {
    let at = reader.open()?.at;
    Ok(Open::Group { announced: Announced::parse(reader, "numObjects")?, children: Vec::new(), at })
}

pub fn open_transform(reader: &mut Reader<'_>) -> Parsed<Open> {
    let at = reader.open()?.at;
    Ok(Open::Transform { matrix: parse_transformations(reader)?, at, child: None })
}

pub fn close_transform(reader: &mut Reader<'_>) -> Parsed<()> {
    reader.close("Transform").map_err(|error| {
        if reader.is_at_any(&OBJECTS) {
            return error.with_hint("a `Transform` holds one object; put several into a `Group`");
        }
        if reader.is_at_any(transformations(reader.edition)) {
            return error.with_hint("transformations come before the object that they move");
        }
        error
    })
}
