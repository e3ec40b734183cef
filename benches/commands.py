#!/usr/bin/env python3
"""Times whole commands: the scenes of assignments 6 and 7 at 200x200 and 1000x1000, and one thread against two.

Usage: benches/commands.py [--markdown] [--runs N] [PROGRAM]

PROGRAM is target/release/raytracer unless told. Each command is run N times (5), all commands in
turn, and the medians of wall and CPU time are printed, in milliseconds. Standard library only.
"""

import argparse
import os
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SIZES = (200, 1000)
GRIDS = {
    "scene6_04": (None, "10 10 7"),
    "scene6_05": ("15 15 12",),
    "scene6_06": ("20 20 15",),
    "scene6_07": ("40 40 33",),
}
# Mirrors and glass show only where rays are followed.
BOUNCES = {f"scene{name}": 4 for name in ("6_11", "6_12", "6_14", "6_18", "7_04", "7_05", "7_06")}


def commands():
    """The scene and flags of every command but for its size, in the order of the scenes' names."""
    for scene in sorted((ROOT / "scenes").glob("scene[67]_*.txt")):
        name = scene.name[:9]
        for grid in GRIDS.get(name, (None,)):
            flags = ["-shadows"]
            flags += ["-grid", *grid.split()] if grid else []
            flags += ["-bounces", str(BOUNCES[name])] if name in BOUNCES else []
            yield scene, flags


def run(command):
    """Milliseconds of wall and of CPU time of one run."""
    start = time.perf_counter()
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=ROOT)
    _, status, usage = os.wait4(child.pid, 0)
    wall = time.perf_counter() - start
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        raise SystemExit(f"failed: {' '.join(map(str, command))}")
    return 1e3 * wall, 1e3 * (usage.ru_utime + usage.ru_stime)


def medians(commands, runs):
    """Runs all commands in turn, `runs` times; the median wall and CPU time of each."""
    times = [[] for _ in commands]
    for _ in range(runs):
        for command, results in zip(commands, times):
            results.append(run(command))
    return [tuple(statistics.median(column) for column in zip(*results)) for results in times]


def table(markdown, head, rows):
    """Prints columns, aligned or as Markdown; the first two are text."""
    if markdown:
        print("| " + " | ".join(head) + " |")
        print("|---|---|" + "---:|" * (len(head) - 2))
        for row in rows:
            print("| " + " | ".join(row) + " |")
        return
    rows = [head, *rows]
    widths = [max(map(len, column)) for column in zip(*rows)]
    for row in rows:
        cells = [c.ljust(w) if i < 2 else c.rjust(w) for i, (c, w) in enumerate(zip(row, widths))]
        print("  ".join(cells).rstrip())


def code(text, markdown):
    """The text, set as code in Markdown."""
    return f"`{text}`" if markdown and text else text


def scenes_table(program, picture, runs, markdown):
    """Every scene at every size."""
    cases = list(commands())
    base = [[program, "-input", scene, "-output", picture, *flags] for scene, flags in cases]
    sized = [b + ["-size", str(n), str(n)] for b in base for n in SIZES]
    results = medians(sized, runs)
    rows = []
    for i, (scene, flags) in enumerate(cases):
        columns = results[i * len(SIZES) : (i + 1) * len(SIZES)]
        times = [f"{ms:.1f}" for pair in columns for ms in pair]
        rows.append([code(scene.stem, markdown), code(" ".join(flags), markdown), *times])
    head = ["Scene", "Flags"] + [f"{n}x{n} {what}" for n in SIZES for what in ("wall", "CPU")]
    table(markdown, head, rows)


def threads_table(program, picture, runs, markdown):
    """The largest picture of the largest mesh with one thread and with two."""
    scene = ROOT / "scenes" / "scene6_07_bunny_mesh_40k.txt"
    size = str(max(SIZES))
    base = [program, "-input", scene, "-output", picture, "-size", size, size]
    base += ["-shadows", "-grid", *GRIDS["scene6_07"][0].split(), "-threads"]
    one, two = medians([base + ["1"], base + ["2"]], runs)
    rows = [
        [code(scene.stem, markdown), f"{n} thread{'s' * (n > 1)}", f"{wall:.1f}", f"{cpu:.1f}", f"{one[0] / wall:.2f}"]
        for n, (wall, cpu) in ((1, one), (2, two))
    ]
    table(markdown, ["Scene", "Threads", f"{size}x{size} wall", "CPU", "Times as fast"], rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program", nargs="?", default=ROOT / "target/release/raytracer", type=Path)
    parser.add_argument("--markdown", action="store_true")
    parser.add_argument("--runs", type=int, default=5)
    options = parser.parse_args()
    program = options.program.resolve()
    with tempfile.TemporaryDirectory() as folder:
        picture = Path(folder) / "picture.tga"
        scenes_table(program, picture, options.runs, options.markdown)
        print()
        threads_table(program, picture, options.runs + 4, options.markdown)


if __name__ == "__main__":
    main()
