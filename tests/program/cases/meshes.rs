//! Meshes.

use super::Case;

pub const CASES: &[Case] = &[
    ("r -input m-gone.txt -output o.tga", 1, "m-gone.txt:5:25: error:"),
    ("r -input m-folder.txt -output o.tga", 1, "m-folder.txt:5:25: error:"),
    ("r -input m-empty.txt -output o.tga", 1, "m-empty.txt:5:25: error:"),
    ("r -input m-letters.txt -output o.tga", 1, "m-letters.txt:5:25: error:"),
    ("r -input m-beyond.txt -output o.tga", 1, "m-beyond.txt:5:1: error:"),
    ("r -input m-binary.txt -output o.tga", 1, "m-binary.txt:5:25: error:"),
    ("r -input m-continued-later.txt -output o.tga", 1, "m-continued-later.txt:5:25: error:"),
    ("r -input m-polygon.txt -output o.tga", 0, ""),
    ("r -input m-long-line.txt -output o.tga", 1, "m-long-line.txt:5:25: error:"),
];
