//! Why two pictures cannot be compared.

use crate::picture::BadSize;
use std::fmt;

/// Two pictures that cannot be compared. Displays as one line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CompareError {
    /// The pictures differ in width or height.
    Sizes {
        /// Width and height of A.
        a: [u32; 2],
        /// Width and height of B.
        b: [u32; 2],
    },
    /// There is no memory for the picture that shows the difference.
    Memory(BadSize),
}

impl fmt::Display for CompareError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sizes { a: [aw, ah], b: [bw, bh] } => {
                write!(f, "the pictures differ in size: {aw} x {ah} pixels against {bw} x {bh}")
            }
            Self::Memory(size) => size.fmt(f),
        }
    }
}

impl std::error::Error for CompareError {}
