//! Scenes.

use super::Case;

pub const CASES: &[Case] = &[
    (
        "r -input gone.txt -output o.tga",
        1,
        "gone.txt: error: cannot read the scene: No such file or directory",
    ),
    ("r -input folder.txt -output o.tga", 1, "folder.txt: error: cannot read the scene: Is a directory"),
    ("r -input empty.txt -output o.tga", 1, "empty.txt:1:1: error: the scene has no camera"),
    ("r -input binary.txt -output o.tga", 1, "binary.txt:1:9: error: the scene is not UTF-8 text"),
    ("r -input utf16.txt -output o.tga", 1, "utf16.txt:1:1: error: the scene is not UTF-8 text"),
    ("r -input latin1.txt -output o.tga", 1, "latin1.txt:2:4: error: the scene is not UTF-8 text"),
    (
        "r -input nul.txt -output o.tga",
        1,
        "nul.txt:2:22: error: expected `}` at the end of `Group`, found `\\0`",
    ),
    (
        "r -input cut.txt -output o.tga",
        1,
        "cut.txt:3:1: error: expected a camera, `Background`, `Lights`, `Materials` or `Group`, found `Material`",
    ),
    ("r -input count21.txt -output o.tga", 1, "`numObjects` must be below 2^64, found `"),
    (
        "r -input long-word.txt -output o.tga",
        1,
        "long-word.txt:2:22: error: expected an object, found `xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx",
    ),
    (
        "r -input long-line.txt -output o.tga",
        1,
        "long-line.txt:2:100023: error: expected an object, found `Ball`",
    ),
    (
        "r -input long-name.txt -output o.tga",
        1,
        "long-name.txt:5:25: error: cannot read the mesh `nnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnn",
    ),
    ("r -input long-number.txt -output o.tga", 1, "`numObjects` must be below 2^64, found `"),
    (
        "r -input braces.txt -output o.tga",
        1,
        "braces.txt:1:1: error: expected a camera, `Background`, `Lights`, `Materials` or `Group`, found `{`",
    ),
    (
        "r -input deep-open.txt -output o.tga",
        1,
        "deep-open.txt:6:2: error: expected `}` at the end of `Transform`, found the end of the file",
    ),
    (
        "r -input escape.txt -output o.tga",
        1,
        "escape.txt:2:22: error: expected an object, found `\\u{1b}[31mred\\u{1b}[0m`",
    ),
    (
        "r -input bell.txt -output o.tga",
        1,
        "bell.txt:5:25: error: cannot read the mesh `\\u{7}\\u{1b}]0;title\\u{7}.obj`: tried `\\u{7}\\u{",
    ),
    (
        "r -input flat.txt -output o.tga",
        1,
        "flat.txt:2:36: error: the transformation is singular: it flattens the object",
    ),
    (
        "r -input grown.txt -output o.tga",
        1,
        "grown.txt:2:93: error: the transformation's numbers grow too large",
    ),
    ("r -input tiny.txt -output o.tga", 1, "tiny.txt:2:36: error: the object has a radius below 1e-100"),
    ("r -input dark.txt -output o.tga", 0, "WARNING:  No lights specified"),
    ("r -input deep.txt -output o.tga", 0, "warning: no ray hits anything"),
    ("r -input s.txt/s.txt -output o.tga", 1, "s.txt/s.txt: error: cannot read the scene: Not a directory"),
];
