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
    ("r -input blank.txt -output o.tga", 1, "blank.txt:1:1: error: the scene has no camera"),
    ("r -input comment.txt -output o.tga", 1, "comment.txt:1:1: error: the scene has no camera"),
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
    (
        "r -input count20.txt -output o.tga",
        1,
        "count20.txt:2:41: error: `numObjects` announces 12345678901234567890, but only 0 found",
    ),
    ("r -input count21.txt -output o.tga", 1, "`numObjects` must be below 2^64, found `"),
    (
        "r -input count-vast.txt -output o.tga",
        1,
        "count-vast.txt:2:31: error: `numObjects` announces 4000000000, but only 0 found",
    ),
    (
        "r -input count-negative.txt -output o.tga",
        1,
        "count-negative.txt:2:20: error: `numObjects` must not be negative, found `-1`",
    ),
    (
        "r -input count-fraction.txt -output o.tga",
        1,
        "count-fraction.txt:2:20: error: `numObjects` must be a whole number, found `1.5`",
    ),
    (
        "r -input count-word.txt -output o.tga",
        1,
        "count-word.txt:2:20: error: expected a whole number for `numObjects`, found `many`",
    ),
    (
        "r -input index20.txt -output o.tga",
        1,
        "index20.txt:2:50: error: there is no material 12345678901234567890: none is declared",
    ),
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
        "r -input closing.txt -output o.tga",
        1,
        "closing.txt:2:24: error: expected a camera, `Background`, `Lights`, `Materials` or `Group`, found `}`",
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
        "r -input infinite.txt -output o.tga",
        1,
        "infinite.txt:2:52: error: expected a number for `center`, found `inf`",
    ),
    (
        "r -input beyond.txt -output o.tga",
        1,
        "beyond.txt:2:52: error: the number `1e101` is too large: the largest is 1e100",
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
    ("r -input no-camera.txt -output o.tga", 1, "no-camera.txt:1:23: error: the scene has no camera"),
    ("r -input no-group.txt -output o.tga", 1, "no-group.txt:1:69: error: the scene has no group"),
    ("r -input bare.txt -output o.tga", 1, "bare.txt:2:22: error: the `Sphere` has no material"),
    ("r -input light.txt -output o.tga", 1, "light.txt:2:22: error: expected a light, found `SpotLight`"),
    ("r -input dark.txt -output o.tga", 0, "WARNING:  No lights specified"),
    ("r -input deep.txt -output o.tga", 0, "warning: no ray hits anything"),
    ("r -input s.txt/s.txt -output o.tga", 1, "s.txt/s.txt: error: cannot read the scene: Not a directory"),
];
