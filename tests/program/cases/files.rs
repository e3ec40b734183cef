//! Files that are read and written.

use super::Case;

pub const CASES: &[Case] = &[
    ("r -input s.txt -output gone/o.tga", 1, "error: cannot write `gone/o.tga`: there is no folder `gone`"),
    ("r -input s.txt -output folder.tga", 1, "error: cannot write `folder.tga`: it is a folder"),
    ("r -input s.txt -output s.txt/o.tga", 1, "error: cannot write `s.txt/o.tga`: Not a directory"),
    (
        "r -input s.txt -output loop.tga",
        1,
        "error: cannot write `loop.tga`: Too many levels of symbolic links",
    ),
    ("r -input s.txt -normals gone/o.tga", 1, "error: cannot write `gone/o.tga`: there is no folder `gone`"),
    ("r -input s.txt -json gone/o.json", 1, "error: cannot write `gone/o.json`: there is no folder `gone`"),
    ("r -input s.txt -json folder.json", 1, "error: cannot write `folder.json`: it is a folder"),
    (
        "r -input s.txt -output \"$(head -c 300 /dev/zero | tr '\\0' x).tga\"",
        1,
        "error: cannot write `xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx",
    ),
    ("r -compare gone.tga -reference b.tga", 1, "error: cannot read `gone.tga`: No such file or directory"),
    (
        "r -compare header.tga -reference b.tga",
        1,
        "error: cannot read `header.tga`: it ends within its header",
    ),
    (
        "r -compare swapped.png -reference b.tga",
        1,
        "error: cannot read `swapped.png`: it is a TGA file\n  hint: name it `swapped.tga`",
    ),
    (
        "r -compare wide.tga -reference b.tga",
        1,
        "error: cannot compare `wide.tga` with `b.tga`: the pictures differ in size: 5 x 4 pixels against 4 x 4",
    ),
    (
        "r -compare b.tga -reference b.tga -difference gone/d.png",
        1,
        "error: cannot write `gone/d.png`: there is no folder `gone`",
    ),
    ("r -compare b.tga -reference b.png >/dev/null", 0, ""),
    ("r -compare b.tga -reference b.png -tolerance 0 0 >/dev/null", 0, ""),
    (
        "r -input s.txt -size 4 4 -shade_back -compare wide.tga",
        1,
        "error: cannot compare `wide.tga` with the rendered picture: the pictures differ in size: 5 x 4 pixels against 4 x 4\n  hint: -size 5 4 renders that size",
    ),
    ("r -grade gone -reference class", 1, "error: cannot read the folder `gone`: No such file or directory"),
    ("r -grade s.txt -reference class", 1, "error: cannot read the folder `s.txt`: Not a directory"),
    ("r -grade class -reference gone", 1, "error: cannot read the folder `gone`: No such file or directory"),
    (
        "r -grade class -commands gone.txt",
        1,
        "error: cannot read the commands `gone.txt`: No such file or directory",
    ),
    (
        "r -grade class -commands c-bad.txt",
        1,
        "error: `c-bad.txt`, line 1: unexpected argument '-shadow' found\n  hint: did you mean '-shadows'?",
    ),
    (
        "r -grade class -commands c.txt -report gone/p.html",
        1,
        "error: cannot write `gone/p.html`: there is no folder `gone`",
    ),
    ("r -grade class -commands c.txt -tolerance 0 0 >/dev/null", 0, ""),
    ("r -grade class -reference class/anna -tolerance 0 0 >/dev/null", 0, ""),
    ("r -input s.txt -error_report s.txt", 1, "error: cannot make the folder `s.txt`: File exists"),
    (
        "r -input gone.txt -output o.tga; echo kept > o.tga; r -input empty.txt -output o.tga; grep -q kept o.tga",
        0,
        "gone.txt: error: cannot read the scene: No such file or directory",
    ),
];
