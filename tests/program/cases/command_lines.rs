//! Command lines.

use super::Case;

pub const CASES: &[Case] = &[
    ("r -input s.txt -output o.jpeg", 2, "-output ... o.jpeg"),
    ("r -input s.txt -seed 1 -seed 2", 2, "-seed ... multiple times"),
    ("r -input s.txt -cost_map rays", 2, "-cost_map"),
    ("r -input s.txt -cost_map heat o.tga", 2, "-cost_map ... heat"),
    ("r -input s.txt -render_filter o.tga 70000", 2, "-render_filter ... 70000"),
    ("r -input s.txt -json o.xml", 2, "-json ... o.xml"),
    ("r -input s.txt '-stats\n'", 2, "-stats"),
    (
        "r \"-$(head -c 100000 /dev/zero | tr '\\0' x)\"",
        2,
        "-xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx",
    ),
    (
        "r \"$(head -c 100000 /dev/zero | tr '\\0' x)\"",
        2,
        "xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx",
    ),
    ("r -version", 0, ""),
    ("r -help >/dev/null", 0, ""),
    ("r -input s.txt -output ./o.tga -size 9 9", 0, ""),
    (
        "r -input \"$(head -c 100000 /dev/zero | tr '\\0' x).txt\"",
        1,
        "error: cannot read the scene: File name too long",
    ),
];
