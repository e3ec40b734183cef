//! What is wrong in a mesh file, or doubtful.

use super::Position;
use super::foreign_format::ForeignFormat;
use crate::escape::quoted;
use std::fmt;

/// An error in a mesh file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshError {
    /// The position of the error; none for an error of the whole file.
    pub at: Option<Position>,
    /// What is wrong.
    pub fault: MeshFault,
}

/// What is wrong in a mesh file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MeshFault {
    /// A file without faces.
    NoFaces(Instead),
    /// A file of another format.
    Foreign(ForeignFormat),
    /// A vertex with a word that is not a number, or with fewer than three.
    BadVertex {
        /// The word; none if the statement ends there.
        word: Option<String>,
    },
    /// A vertex with five numbers, or with more than seven.
    SurplusNumbers {
        /// How many there are.
        count: usize,
    },
    /// A vertex with a coordinate that is not a finite number.
    NotFinite,
    /// A vertex whose weight is zero.
    ZeroWeight,
    /// A face with a word that is not a vertex index.
    BadFace {
        /// The word.
        word: String,
    },
    /// A face of one or two vertices.
    FewCorners,
    /// A face that names a vertex which the file does not have.
    NoSuchVertex {
        /// The index.
        index: i64,
        /// The number of vertices in the file.
        vertices: usize,
    },
    /// A vertex or face that is not UTF-8 text.
    NotText,
}

/// What a file without faces has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Instead {
    /// Nothing at all.
    Nothing,
    /// Vertices, comments or other statements without an area.
    NoArea,
    /// Points, lines or curves.
    Lines,
    /// Curved surfaces.
    Surfaces,
    /// A word that is no keyword.
    Word(String),
}

/// Something in a mesh file that is no error, but hardly meant.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshDoubt {
    /// The first of its kind.
    pub at: Position,
    /// The kind.
    pub kind: DoubtKind,
    /// How many more of the kind there are.
    pub others: usize,
}

/// What is doubtful in a mesh file.
#[derive(Clone, Debug, PartialEq)]
pub enum DoubtKind {
    /// A polygon whose outline crosses itself.
    Crossing,
    /// A statement that is left out, since its first word is no keyword.
    UnknownWord {
        /// The word.
        word: String,
        /// A keyword that may be meant.
        near: Option<&'static str>,
    },
    /// A curved surface, which is left out.
    Surface,
}

impl std::error::Error for MeshError {}

impl fmt::Display for MeshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.at {
            Some(at) => write!(f, "line {}: {}", at.line, self.fault),
            None => self.fault.fmt(f),
        }
    }
}

impl fmt::Display for MeshFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoFaces(Instead::Nothing) => write!(f, "the mesh has no faces: the file is empty"),
            Self::NoFaces(Instead::NoArea) => write!(f, "the mesh has no faces"),
            Self::NoFaces(Instead::Lines) => write!(f, "the mesh has no faces, only points, lines or curves"),
            Self::NoFaces(Instead::Surfaces) => {
                write!(f, "the mesh has no faces, only curved surfaces, which are not read")
            }
            Self::NoFaces(Instead::Word(word)) => {
                write!(f, "the mesh has no faces, and {} is no keyword of OBJ", quoted(word))
            }
            Self::Foreign(format) => write!(f, "the file is {format}, not OBJ"),
            Self::BadVertex { word: Some(word) } => {
                write!(f, "a vertex needs three numbers, and {} is none", quoted(word))
            }
            Self::BadVertex { word: None } => write!(f, "a vertex needs three numbers"),
            Self::SurplusNumbers { count } => write!(
                f,
                "a vertex has {count} numbers: it needs three, and may have a weight or a colour of three or four"
            ),
            Self::NotFinite => write!(f, "a vertex has a coordinate that is not finite"),
            Self::ZeroWeight => write!(f, "a vertex has the weight 0, which puts it infinitely far away"),
            Self::BadFace { word } => {
                write!(f, "a face needs vertex indices such as `1 2 3`, and {} is none", quoted(word))
            }
            Self::FewCorners => write!(f, "a face needs at least three vertices"),
            Self::NoSuchVertex { vertices, .. } => {
                write!(f, "a face names a vertex that does not exist; the mesh has {vertices}")
            }
            Self::NotText => write!(f, "not UTF-8 text"),
        }
    }
}

impl MeshFault {
    /// Advice in one line, if there is any.
    pub fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::Foreign(format) => format.hint(),
            Self::NoFaces(Instead::Surfaces) => "convert them to polygons when the mesh is exported",
            Self::BadVertex { word: Some(word) } => number_hint(word)?,
            Self::ZeroWeight => "leave out the fourth number, or make it 1",
            Self::BadFace { word } => corner_hint(word)?,
            Self::FewCorners => "a line between two vertices is written `l 1 2`",
            Self::NoSuchVertex { index: 0, .. } => "indices start with 1",
            Self::NoSuchVertex { index: ..0, .. } => {
                "a negative index counts back from the face: -1 is the vertex before it"
            }
            _ => return None,
        };
        Some(hint.to_owned())
    }
}

const BACKSLASH: &str = "a backslash continues a statement only at the end of a line";
const ZERO_BYTE: &str = "the word has a zero byte: the file may be damaged";

fn number_hint(word: &str) -> Option<&'static str> {
    let is_number = |word: &str| word.parse::<f64>().is_ok();
    match word {
        "\\" => Some(BACKSLASH),
        _ if word.contains('\0') => Some(ZERO_BYTE),
        _ if word.matches(',').count() == 1 && !word.ends_with(',') && is_number(&word.replace(',', ".")) => {
            Some("a decimal point is needed, not a comma")
        }
        _ if word.split([',', ';']).all(|part| part.is_empty() || is_number(part)) => {
            Some("numbers are separated by blanks")
        }
        _ if is_number(&word.replace(['d', 'D'], "e")) => Some("an exponent is written with `e`, as in 1e-5"),
        _ => None,
    }
}

fn corner_hint(word: &str) -> Option<&'static str> {
    match word {
        "\\" => Some(BACKSLASH),
        _ if word.contains('\0') => Some(ZERO_BYTE),
        _ if word.contains([',', ';']) => Some("indices are separated by blanks"),
        _ if word.matches('/').count() > 2 => {
            Some("a corner has at most three indices: of its position, texture coordinate and normal")
        }
        _ if word.starts_with('/') => Some("the index of the position comes first"),
        _ if word.parse::<f64>().is_ok() => Some("indices are whole numbers"),
        _ => None,
    }
}

impl MeshDoubt {
    /// Advice in one line, if there is any.
    pub fn hint(&self) -> Option<String> {
        match &self.kind {
            DoubtKind::Crossing => Some("it covers what its outline goes around, however often".into()),
            DoubtKind::UnknownWord { near, .. } => near.map(|near| format!("did you mean `{near}`?")),
            DoubtKind::Surface => Some("convert it to polygons when the mesh is exported".into()),
        }
    }
}

impl fmt::Display for MeshDoubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: ", self.at.line)?;
        match &self.kind {
            DoubtKind::Crossing => write!(f, "the outline of the polygon crosses itself")?,
            DoubtKind::UnknownWord { word, .. } => {
                write!(f, "{} is no keyword of OBJ, and its line is left out", quoted(word))?;
            }
            DoubtKind::Surface => write!(f, "a curved surface is left out")?,
        }
        match (self.others, &self.kind) {
            (0, _) => Ok(()),
            (1, DoubtKind::Crossing) => write!(f, "; so does that of another"),
            (others, DoubtKind::Crossing) => write!(f, "; so do those of {others} more"),
            (1, _) => write!(f, "; so is another"),
            (others, _) => write!(f, "; so are {others} more"),
        }
    }
}
