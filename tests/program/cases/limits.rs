//! Little memory, small stacks, closed and full descriptors, and the environment.

use super::Case;

pub const CASES: &[Case] = &[
    ("r -input s.txt -size 65535 65535 -cost_map rays o.tga", 1, "error: not enough memory"),
    (
        "(ulimit -v 4000000; r -input s.txt -size 65535 65535 -cost_map rays o.tga)",
        1,
        "error: not enough memory",
    ),
    (
        "(ulimit -v 400000; r -input s.txt -size 65535 65535 -compare b.tga)",
        1,
        "error: cannot compare `b.tga` with the rendered picture: the pictures differ in size: 4 x 4 pixels against 65535 x 65535\n  hint: -size 4 4 renders that size",
    ),
    (
        "(ulimit -v 400000; r -input s.txt -size 65535 65535 -output o.tga -compare o.tga)",
        1,
        "error: cannot read `o.tga`: No such file or directory",
    ),
    (
        "(ulimit -v 400000; r -input s.txt -grid 1000 1000 1000 -output o.tga)",
        1,
        "error: the grid does not fit into memory",
    ),
    (
        "(ulimit -v 400000; r -input s.txt -grid 1290 1290 1290 -output o.tga)",
        1,
        "error: the grid does not fit into memory",
    ),
    (
        "(ulimit -v 400000; r -input s.txt -grid 1000 1000 1000 -visualize_grid -output o.tga)",
        1,
        "error: the grid does not fit into memory",
    ),
    (
        "(ulimit -v 400000; r -input s.txt -size 1 5000 -threads 4096 -output o.tga)",
        1,
        "error: `-threads`: the system does not start the threads: ",
    ),
    ("(ulimit -v 400000; r -threads 4096 -grade class -commands c.txt)", 0, ""),
    (
        "(ulimit -v 400000; r -input s.txt -size 65535 65535 -gaussian_filter 1000 -jittered_samples 2 -threads 2 -output o.tga)",
        1,
        "error: not enough memory",
    ),
    ("(ulimit -v 400000; r -input deep.txt -size 3 3 -output o.tga)", 0, ""),
    ("(ulimit -s 256; r -input deep.txt -size 3 3 -output o.tga)", 0, ""),
    (
        "(ulimit -s 256; r -input deep-open.txt -size 3 3 -output o.tga)",
        1,
        "deep-open.txt:6:2: error: expected `}` at the end of `Transform`, found the end of the file",
    ),
    ("(ulimit -n 7; r -input s.txt -size 3 3 -output o.tga)", 0, ""),
    ("r -input s.txt -size 3 3 -output o.tga <&-", 0, ""),
    ("r -input s.txt -size 3 3 -output o.tga >&-", 0, ""),
    ("r -input s.txt -size 3 3 -output o.tga 2>&-", 0, ""),
    ("r -input s.txt -size 3 3 -output o.tga <&- >&- 2>&-", 0, ""),
    ("r -input gone.txt 2>&-", 1, ""),
    ("r -nonsense 2>&-", 2, ""),
    ("r -input gone.txt <&- >&-", 1, "gone.txt: error: cannot read the scene: No such file or directory"),
    ("r -version 2>&-", 0, ""),
    ("r -input s.txt -size 3 3 -output o.tga 2>/dev/full", 0, ""),
    ("r -input gone.txt 2>/dev/full", 1, ""),
    ("r -input s.txt -stats | true", 0, ""),
    ("r -help | head -c 1 >/dev/null", 0, ""),
    ("TMPDIR=/gone r -input s.txt -size 3 3 -output o.tga", 0, ""),
    ("env -i \"$PROGRAM\" -input s.txt -size 3 3 -output o.tga", 0, ""),
    ("RAYON_NUM_THREADS=99999 r -input s.txt -size 3 3 -output o.tga", 0, ""),
    ("RAYON_NUM_THREADS=none r -input s.txt -size 3 3 -output o.tga", 0, ""),
    ("RUST_MIN_STACK=1 r -input s.txt -size 3 3 -threads 3 -output o.tga", 0, ""),
];
