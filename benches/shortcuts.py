#!/usr/bin/env python3
"""What each shortcut saves: the commands of `commands.py` with all shortcuts and without each of them.

Usage: benches/shortcuts.py [--markdown] [--runs N] [--size N] [PROGRAM]

PROGRAM is target/ablation/release/raytracer unless told, which
`cargo build --release --features ablation --target-dir target/ablation` builds. Each command is run N times (5) on one
thread, with and without the shortcut in turns, and the least CPU times are compared. Standard library only.
"""

import argparse
import math
import os
import re
from pathlib import Path

from commands import ROOT, commands, run

# The files of each shortcut, whose lines without tests are counted.
FILES = {
    "first_hits": ["src/fast/raster/mod.rs", "src/fast/raster/bins.rs", "src/fast/raster/tile.rs", "src/fast/raster/triangle_bounds.rs",
                   "src/fast/raster/edge_functions.rs", "src/fast/raster/flat_triangle.rs", "src/fast/raster/viewport.rs", "src/fast/raster/parallel_view.rs"],
    "shadow_maps": ["src/fast/raster/shadow_map.rs", "src/fast/raster/light_view.rs"],
    "avx2": ["src/math/instructions.rs"],
    "plain_meshes": ["src/scene/plain_obj.rs"],
}


def lines(name):
    """The lines of a shortcut's files before their tests."""
    texts = [(ROOT / file).read_text() for file in FILES[name]]
    return sum(re.split(r"#\[cfg\(test\)\]\nmod ", text)[0].count("\n") for text in texts)


def least(command, without, runs):
    """The least CPU times of a command with all shortcuts and without one, in turns."""
    times = [math.inf, math.inf]
    for _ in range(runs):
        for k, names in enumerate(("", without)):
            os.environ["WITHOUT"] = names
            times[k] = min(times[k], run(command)[1])
    return times


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("--markdown", action="store_true")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--size", type=int, default=400)
    parser.add_argument("program", nargs="?", type=Path, default=ROOT / "target/ablation/release/raytracer")
    options = parser.parse_args()
    size = str(options.size)
    all_commands = [
        (scene.stem, [options.program, "-input", scene, "-output", ROOT / "target/shortcuts.tga", "-size", size, size, "-threads", "1", *flags])
        for scene, flags in commands()
    ]
    row = "| `{}` | {} | {:.3f} | {:.2f} | `{}` |" if options.markdown else "{:14} {:5} {:6.3f} {:6.2f} {}"
    if options.markdown:
        print("| shortcut | lines | times as slow without it | at most | in |\n|---|---:|---:|---:|---|")
    for name in FILES:
        ratios = []
        for scene, command in all_commands:
            with_all, without = least(command, name, options.runs)
            ratios.append((without / with_all, scene))
        mean = math.exp(sum(math.log(ratio) for ratio, _ in ratios) / len(ratios))
        print(row.format(name, lines(name), mean, *max(ratios)), flush=True)


if __name__ == "__main__":
    main()
