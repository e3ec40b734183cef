//! Scenes.

use super::Case;

pub const CASES: &[Case] = &[
    ("r -input gone.txt -output o.tga", 1, "gone.txt: error:"),
    ("r -input folder.txt -output o.tga", 1, "folder.txt: error:"),
    ("r -input empty.txt -output o.tga", 1, "empty.txt:1:1: error:"),
    ("r -input binary.txt -output o.tga", 1, "binary.txt:1:9: error:"),
    ("r -input utf16.txt -output o.tga", 1, "utf16.txt:1:1: error:"),
    ("r -input latin1.txt -output o.tga", 1, "latin1.txt:2:4: error:"),
    ("r -input nul.txt -output o.tga", 1, "nul.txt:2:22: error:"),
    ("r -input cut.txt -output o.tga", 1, "cut.txt:3:1: error:"),
    ("r -input count21.txt -output o.tga", 1, "`numObjects` must be below 2^64, found `"),
    ("r -input long-word.txt -output o.tga", 1, "long-word.txt:2:22: error:"),
    ("r -input long-line.txt -output o.tga", 1, "long-line.txt:2:100023: error:"),
    ("r -input long-name.txt -output o.tga", 1, "long-name.txt:5:25: error:"),
    ("r -input long-number.txt -output o.tga", 1, "`numObjects` must be below 2^64, found `"),
    ("r -input braces.txt -output o.tga", 1, "braces.txt:1:1: error:"),
    ("r -input deep-open.txt -output o.tga", 1, "deep-open.txt:6:2: error:"),
    ("r -input escape.txt -output o.tga", 1, "escape.txt:2:22: error: ... \\u{1b}[31mred\\u{1b}[0m"),
    ("r -input bell.txt -output o.tga", 1, "bell.txt:5:25: error: ... \\u{7}\\u{1b}]0;title\\u{7}.obj"),
    ("r -input flat.txt -output o.tga", 1, "flat.txt:2:36: error:"),
    ("r -input grown.txt -output o.tga", 1, "grown.txt:2:93: error:"),
    ("r -input tiny.txt -output o.tga", 1, "tiny.txt:2:36: error:"),
    ("r -input dark.txt -output o.tga", 0, "WARNING:  No lights specified"),
    ("r -input deep.txt -output o.tga", 0, "warning: no ray hits anything"),
    ("r -input s.txt/s.txt -output o.tga", 1, "s.txt/s.txt: error:"),
];
