//! Meshes.

use super::Case;

pub const CASES: &[Case] = &[
    (
        "r -input m-gone.txt -output o.tga",
        1,
        "m-gone.txt:5:25: error: cannot read the mesh `gone.obj`: tried `gone.obj` (No such file or directory",
    ),
    (
        "r -input m-folder.txt -output o.tga",
        1,
        "m-folder.txt:5:25: error: cannot read the mesh `folder.obj`: tried `folder.obj` (it is a folder)",
    ),
    (
        "r -input m-empty.txt -output o.tga",
        1,
        "m-empty.txt:5:25: error: in the mesh `empty.obj`: the mesh has no faces: the file is empty",
    ),
    (
        "r -input m-letters.txt -output o.tga",
        1,
        "m-letters.txt:5:25: error: in the mesh `letters.obj`: line 4: a face needs vertex indices such as `1 2 3`, found `a`",
    ),
    (
        "r -input m-beyond.txt -output o.tga",
        1,
        "m-beyond.txt:5:1: error: the object has coordinates beyond 1e100",
    ),
    (
        "r -input m-binary.txt -output o.tga",
        1,
        "m-binary.txt:5:25: error: in the mesh `binary.obj`: the file is binary, not OBJ",
    ),
    (
        "r -input m-continued-later.txt -output o.tga",
        1,
        "m-continued-later.txt:5:25: error: in the mesh `continued-later.obj`: line 6: a face needs at least three vertices",
    ),
    ("r -input m-polygon.txt -output o.tga", 0, ""),
    (
        "r -input m-long-line.txt -output o.tga",
        1,
        "m-long-line.txt:5:25: error: in the mesh `long-line.obj`: line 4: a face needs vertex indices such as `1 2 3`, found `xxx",
    ),
];
