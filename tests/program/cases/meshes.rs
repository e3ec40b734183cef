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
        "r -input m-vertices.txt -output o.tga",
        1,
        "m-vertices.txt:5:25: error: in the mesh `vertices.obj`: the mesh has no faces",
    ),
    (
        "r -input m-word.txt -output o.tga",
        1,
        "m-word.txt:5:25: error: in the mesh `word.obj`: line 1: a vertex needs three numbers, found `zero`",
    ),
    (
        "r -input m-short.txt -output o.tga",
        1,
        "m-short.txt:5:25: error: in the mesh `short.obj`: line 1: a vertex needs three numbers",
    ),
    (
        "r -input m-two.txt -output o.tga",
        1,
        "m-two.txt:5:25: error: in the mesh `two.obj`: line 4: a face needs at least three vertices",
    ),
    (
        "r -input m-index.txt -output o.tga",
        1,
        "m-index.txt:5:25: error: in the mesh `index.obj`: line 4: a face names a vertex that does not exist; the mesh has 3",
    ),
    (
        "r -input m-zero.txt -output o.tga",
        1,
        "m-zero.txt:5:25: error: in the mesh `zero.obj`: line 4: a face names a vertex that does not exist; the mesh has 3",
    ),
    (
        "r -input m-negative.txt -output o.tga",
        1,
        "m-negative.txt:5:25: error: in the mesh `negative.obj`: line 4: a face names a vertex that does not exist; the mesh has 3",
    ),
    (
        "r -input m-letters.txt -output o.tga",
        1,
        "m-letters.txt:5:25: error: in the mesh `letters.obj`: line 4: a face needs vertex indices such as `1 2 3`, found `a`",
    ),
    (
        "r -input m-big-index.txt -output o.tga",
        1,
        "m-big-index.txt:5:25: error: in the mesh `big-index.obj`: line 4: a face names a vertex that does not exist; the mesh has 3",
    ),
    (
        "r -input m-nan.txt -output o.tga",
        1,
        "m-nan.txt:5:25: error: in the mesh `nan.obj`: line 1: a vertex has a coordinate that is not finite",
    ),
    (
        "r -input m-huge.txt -output o.tga",
        1,
        "m-huge.txt:5:25: error: in the mesh `huge.obj`: line 1: a vertex has a coordinate that is not finite",
    ),
    (
        "r -input m-beyond.txt -output o.tga",
        1,
        "m-beyond.txt:5:1: error: the object has coordinates beyond 1e100",
    ),
    (
        "r -input m-weightless.txt -output o.tga",
        1,
        "m-weightless.txt:5:25: error: in the mesh `weightless.obj`: line 1: a vertex has the weight 0",
    ),
    (
        "r -input m-latin1.txt -output o.tga",
        1,
        "m-latin1.txt:5:25: error: in the mesh `latin1.obj`: line 1: a vertex needs three numbers, found `\u{fffd}`",
    ),
    (
        "r -input m-binary.txt -output o.tga",
        1,
        "m-binary.txt:5:25: error: in the mesh `binary.obj`: the file is binary, not OBJ",
    ),
    (
        "r -input m-continued-index.txt -output o.tga",
        1,
        "m-continued-index.txt:5:25: error: in the mesh `continued-index.obj`: line 5: a face names",
    ),
    (
        "r -input m-continued-later.txt -output o.tga",
        1,
        "m-continued-later.txt:5:25: error: in the mesh `continued-later.obj`: line 6: a face needs at least three vertices",
    ),
    (
        "r -input m-continued-end.txt -output o.tga",
        1,
        "m-continued-end.txt:5:25: error: in the mesh `continued-end.obj`: line 4: a face needs at least three vertices",
    ),
    ("r -input m-continued.txt -output o.tga", 0, ""),
    ("r -input m-continued-vertex.txt -output o.tga", 0, ""),
    ("r -input m-comment.txt -output o.tga", 0, ""),
    ("r -input m-slashes.txt -output o.tga", 0, ""),
    ("r -input m-windows.txt -output o.tga", 0, ""),
    ("r -input m-marked.txt -output o.tga", 0, ""),
    ("r -input m-no-end.txt -output o.tga", 0, ""),
    ("r -input m-polygon.txt -output o.tga", 0, ""),
    ("r -input m-groups.txt -output o.tga", 0, ""),
    ("r -input m-curves.txt -output o.tga", 0, ""),
    (
        "r -input m-long-line.txt -output o.tga",
        1,
        "m-long-line.txt:5:25: error: in the mesh `long-line.obj`: line 4: a face needs vertex indices such as `1 2 3`, found `xxx",
    ),
];
