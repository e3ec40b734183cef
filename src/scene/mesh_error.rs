//! What is wrong in a mesh file.

use crate::memory::NoMemory;
use std::fmt;

/// An error in a mesh file. Lines are counted from 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MeshError {
    /// A file without faces.
    NoFaces,
    /// A vertex that does not consist of three numbers and optionally a weight or a colour.
    BadVertex {
        /// The line.
        line: usize,
    },
    /// A vertex with a coordinate that is not a finite number.
    NotFinite {
        /// The line.
        line: usize,
    },
    /// A face that is not a list of vertex indices.
    BadFace {
        /// The line.
        line: usize,
    },
    /// A face of one or two vertices.
    FewCorners {
        /// The line.
        line: usize,
    },
    /// A face that names a vertex which the file does not have.
    NoSuchVertex {
        /// The line.
        line: usize,
        /// The number of vertices in the file.
        vertices: usize,
    },
    /// A vertex or face that is not UTF-8 text.
    NotText {
        /// The line.
        line: usize,
    },
    /// The system has too little memory for the mesh.
    Memory(NoMemory),
    /// Any other error of the OBJ parser.
    Other {
        /// The line.
        line: usize,
        /// The parser's message.
        message: String,
    },
}

impl std::error::Error for MeshError {}

impl From<NoMemory> for MeshError {
    fn from(refused: NoMemory) -> Self {
        Self::Memory(refused)
    }
}

impl fmt::Display for MeshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoFaces => write!(f, "the mesh has no faces"),
            Self::BadVertex { line } => write!(f, "line {line}: a vertex needs three numbers"),
            Self::NotFinite { line } => {
                write!(f, "line {line}: a vertex has a coordinate that is not finite")
            }
            Self::BadFace { line } => write!(f, "line {line}: a face needs vertex indices such as `1 2 3`"),
            Self::FewCorners { line } => write!(f, "line {line}: a face needs at least three vertices"),
            Self::NoSuchVertex { line, vertices } => {
                write!(f, "line {line}: a face names a vertex that does not exist; the mesh has {vertices}")
            }
            Self::NotText { line } => write!(f, "line {line}: not UTF-8 text"),
            Self::Memory(refused) => refused.fmt(f),
            Self::Other { line, message } => write!(f, "line {line}: {message}"),
        }
    }
}
