#!/usr/bin/env python3
"""Opens the page of a graded folder in a real browser, clicks a picture, and looks at what appears.

usage: tests/browser/grade.py [PROGRAM] [--screenshots FOLDER]

PROGRAM is target/release/raytracer unless it is named. Needs Chromium and its driver (Debian: chromium,
chromium-driver); without them it says so and ends with status 0. Standard library only.
"""
import argparse
import base64
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[2]
COMMANDS = """\
raytracer -input scene6_02_sphere_triangles.txt -size 120 120 -output shadows.tga -shadows
raytracer -input scene6_01_sphere.txt -size 90 120 -output sphere.tga
raytracer -input scene6_13_checkerboard.txt -size 120 96 -output board.tga -shadows
"""
ARGUMENTS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--window-size=1280,900",
]
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
    return subprocess.run(
        [program, "-grade", folder / "class", "-commands", folder / "commands.txt", "-report", folder / "page.html"],
        cwd=ROOT / "scenes", check=True, capture_output=True, text=True).stdout


class Browser:
    """A headless browser, steered by the WebDriver protocol."""

    def __init__(self, driver, chromium, profile):
        self.process = subprocess.Popen([driver, "--port=0"], stdout=subprocess.PIPE, text=True)
        for line in self.process.stdout:
            found = re.search(r"started successfully on port (\d+)", line)
            if found:
                break
        else:
            raise RuntimeError("the driver did not start")
        self.session = f"http://127.0.0.1:{found.group(1)}/session"
        options = {"binary": chromium, "args": [*ARGUMENTS, f"--user-data-dir={profile}"]}
        wanted = {"goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}
        self.session += "/" + self.ask("POST", "", {"capabilities": {"alwaysMatch": wanted}})["sessionId"]

    def ask(self, method, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.session + path, data, {"Content-Type": "application/json"}, method=method)
        with urllib.request.urlopen(request, timeout=60) as answer:
            return json.load(answer)["value"]

    def run(self, script):
        return self.ask("POST", "/execute/sync", {"script": script, "args": []})

    def click(self, selector):
        element = self.ask("POST", "/element", {"using": "css selector", "value": selector})
        self.ask("POST", f"/element/{next(iter(element.values()))}/click", {})

    def wait(self, script, what):
        for _ in range(100):
            if self.run(script):
                return
            time.sleep(0.1)
        raise AssertionError(what)

    def screenshot(self, folder, name):
        if folder:
            folder.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(base64.b64decode(self.ask("GET", "/screenshot")))

    def close(self):
        try:
            self.ask("DELETE", "")
        finally:
            self.process.terminate()
            self.process.wait()


def check(browser, page, screenshots):
    browser.ask("POST", "/url", {"url": page.as_uri()})
    cells = browser.run("return [...document.querySelectorAll('tbody tr')].map(row => [...row.cells].map(cell => "
                        "cell.className))")
    assert cells == [
        ["", "unusable", "missing", "missing"],
        ["", "passed", "passed", "passed"],
        ["", "failed", "failed", "missing"],
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
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    driver = shutil.which("chromedriver")
    if not (chromium and driver):
        print("skipped: there is no Chromium with its driver")
        return
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        make_folder(options.program.resolve(), folder)
        browser = Browser(driver, chromium, folder / "profile")
        try:
            check(browser, folder / "page.html", options.screenshots)
        finally:
            browser.close()
    print("the page shows the table, and a click shows A, B, the difference, and blinks")


if __name__ == "__main__":
    sys.exit(main())
