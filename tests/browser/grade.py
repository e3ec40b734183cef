#!/usr/bin/env python3
"""Opens the page of a graded folder in a real browser, clicks a picture, and looks at what appears.

usage: tests/browser/grade.py [PROGRAM] [--screenshots FOLDER]

PROGRAM is target/release/raytracer unless it is named. Needs Chromium and its driver (Debian: chromium,
chromium-driver); without them it says so and ends with status 0. Standard library only.
"""
import argparse
import pathlib
import subprocess
import sys
import tempfile
import time

from browser import Browser, find_browser

ROOT = pathlib.Path(__file__).resolve().parents[2]
COMMANDS = """\
raytracer -input scene6_02_sphere_triangles.txt -size 120 120 -output shadows.tga -shadows
raytracer -input scene6_01_sphere.txt -size 90 120 -output sphere.tga
raytracer -input scene6_13_checkerboard.txt -size 120 96 -output board.tga -shadows
"""
HOSTILE = "<img src=x onerror=alert(1)>&'\""


def make_folder(program, folder):
    """Three names, one of which would be markup: all right; wrong; broken."""
    (folder / "commands.txt").write_text(COMMANDS)
    for name in ["anna", "bela", HOSTILE]:
        (folder / "class" / name).mkdir(parents=True)
    for line in COMMANDS.splitlines():
        words = line.split()[1:]
        at = words.index("-output") + 1
        picture = words[at]
        words[at] = str(folder / "class" / "anna" / picture)
        subprocess.run([program, *words], cwd=ROOT / "scenes", check=True)
    right = folder / "class" / "anna"
    wrong = folder / "class" / "bela"
    words = COMMANDS.splitlines()[0].replace("-shadows", "").split()[1:]
    words[words.index("-output") + 1] = str(wrong / "shadows.tga")
    subprocess.run([program, *words], cwd=ROOT / "scenes", check=True)
    data = (right / "sphere.tga").read_bytes()
    rows = [data[at:at + 270] for at in range(18, len(data), 270)]
    # A row further down.
    rows = [rows[-1]] + rows[:-1]
    (wrong / "sphere.tga").write_bytes(data[:18] + b"".join(rows))
    (folder / "class" / HOSTILE / "shadows.tga").write_bytes(bytes([0, 0, 2] + [0] * 9 + [255] * 4 + [24, 32]))
    (folder / "class" / HOSTILE / "<b>extra.tga").write_bytes(b"")
    subprocess.run(
        [program, "-grade", folder / "class", "-commands", folder / "commands.txt", "-report", folder / "page.html"],
        cwd=ROOT / "scenes", check=True, capture_output=True)


def check(browser, page, screenshots):
    browser.ask("POST", "/url", {"url": page.as_uri()})
    cells = browser.run("return [...document.querySelectorAll('tbody tr')].map(row => [...row.cells].map(cell => "
                        "cell.className))")
    assert cells == [
        ["", "points", "unusable", "missing", "missing"],
        ["", "points", "passed", "passed", "passed"],
        ["", "points", "failed", "failed", "missing"],
    ], cells
    text = browser.run("return document.body.innerText")
    assert HOSTILE in text and "<b>extra.tga" in browser.run("return document.body.textContent"), text
    assert browser.run("return document.querySelectorAll('img, li b').length") == 0, "a name became markup"
    assert browser.run("const b = document.querySelector('thead th i').getBoundingClientRect();"
                       "return Math.max(b.width, b.height)") <= 64
    browser.screenshot(screenshots, "table.png")

    browser.click("td[data-a] button")
    browser.wait("return document.querySelector('dialog').open", "a click opens nothing")
    data = "[...document.querySelectorAll('dialog canvas')].map(canvas => canvas.toDataURL())"
    a, b, difference, _ = browser.run("return " + data)
    assert len({a, b, difference}) == 3, "A, B and their difference are not three pictures"
    assert "without -shadows" in browser.run("return document.querySelector('dialog p').textContent")
    seen = set()
    for _ in range(40):
        seen.add(browser.run("return " + data)[3])
        time.sleep(0.05)
    assert seen == {a, b}, f"the fourth picture shows {len(seen)} pictures, not A and B in turn"
    browser.screenshot(screenshots, "dialog.png")
    browser.click("dialog form button")
    browser.wait("return !document.querySelector('dialog').open", "the dialog stays open")

    complaints = [entry["message"] for entry in browser.ask("POST", "/se/log", {"type": "browser"})]
    assert not complaints, complaints


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program", nargs="?", default=ROOT / "target/release/raytracer", type=pathlib.Path)
    parser.add_argument("--screenshots", type=pathlib.Path)
    options = parser.parse_args()
    found = find_browser()
    if not found:
        print("skipped: there is no Chromium with its driver")
        return
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        make_folder(options.program.resolve(), folder)
        browser = Browser(*found, folder / "profile")
        try:
            check(browser, folder / "page.html", options.screenshots)
        finally:
            browser.close()
    print("the page shows the table, and a click shows A, B, the difference, and blinks")


if __name__ == "__main__":
    sys.exit(main())
