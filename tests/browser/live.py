#!/usr/bin/env python3
"""Uses the live page of -gui in a real browser: drags, traces, edits, enlarges, compares, and checks the painted pixels.

usage: tests/browser/live.py [PROGRAM] [--screenshots FOLDER]

PROGRAM is target/release/raytracer unless it is named. Needs Chromium and its driver (Debian: chromium,
chromium-driver); without them it says so and ends with status 0. Standard library only.
"""
import argparse
import base64
import json
import math
import pathlib
import re
import shlex
import signal
import subprocess
import sys
import tempfile
import time

from browser import Browser, find_browser
from page_rules import RULES

ROOT = pathlib.Path(__file__).resolve().parents[2]
GLASS = "-size 320 240 -shadows -bounces 5 -weight 0.01 -shade_back"
ARROW_RIGHT, TAB, ENTER, ESCAPE = "\ue014", "\ue004", "\ue007", "\ue00c"


class Page:
    """A program that serves a page, and the browser that shows it."""

    def __init__(self, program, browser, scene, flags, folder, outputs=("-output", "o.png")):
        self.browser, self.folder, self.program = browser, folder, program
        # The meshes that scenes of editions name lie in the folder above.
        (folder / "s.txt").write_text((ROOT / "scenes" / scene).read_text().replace("../", ""))
        for file in [*(ROOT / "scenes").glob("*.obj"), *(ROOT / "scenes/editions").iterdir()]:
            if not (folder / file.name).exists():
                (folder / file.name).symlink_to(file)
        words = [program, "-input", "s.txt", *flags.split(), *outputs, "-gui", "-port", "0", "-no_browser"]
        self.process = subprocess.Popen(words, cwd=folder, stderr=subprocess.PIPE, text=True)
        found = None
        while not found:
            line = self.process.stderr.readline()
            if not line:
                raise RuntimeError("the program serves no page")
            found = re.match(r"open (\S+)", line)
        browser.ask("POST", "/url", {"url": found.group(1)})

    def run(self, script):
        return self.browser.run(script)

    def status(self):
        return self.run("return document.getElementById('status').textContent")

    def wait(self, script, what, seconds=240):
        end = time.time() + seconds
        while not self.run(script):
            if time.time() > end:
                raise AssertionError(f"{what} ({self.status()})")
            time.sleep(0.1)

    def settle(self):
        """Waits until nothing better is on its way."""
        self.wait("return view.finished && !view.sketching", "the picture is not finished")

    def pixels(self):
        """Width, height and the painted red, green and blue."""
        width, height, data = self.run(
            "const c = view.canvas; const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;"
            "let text = ''; for (let i = 0; i < d.length; i += 4) text += String.fromCharCode(d[i], d[i + 1], d[i + 2]);"
            "return [c.width, c.height, btoa(text)]")
        return width, height, base64.b64decode(data)

    def write_scene(self):
        """Writes the text with the camera that is shown."""
        text = self.run("return document.getElementById('text').value")
        block = self.run("return document.getElementById('block').value")
        (self.folder / "s.txt").write_text(re.sub(r"\b(Ortho|Persp)\w*Camera\s*\{[^}]*\}", lambda _: block.rstrip(), text))

    def check_pixels(self, what):
        """The painted pixels are those of the file that the shown command line writes, with the shown camera."""
        self.settle()
        self.write_scene()
        words = shlex.split(self.run("return document.getElementById('command').value"))
        words[words.index("-output") + 1] = "check.tga"
        subprocess.run([self.program, *words[1:]], cwd=self.folder, check=True)
        written = read_tga(self.folder / "check.tga")
        assert self.pixels() == written, f"{what}: the painted pixels are not those of the file"

    def drag(self, moves, button=0):
        self.browser.move("#picture", moves, button, 16)

    def close(self):
        # A page that is open looks for its program, which the browser would list.
        self.browser.ask("POST", "/url", {"url": "about:blank"})
        self.process.terminate()
        self.process.wait()


def read_tga(path):
    data = path.read_bytes()
    width, height = [int.from_bytes(data[at:at + 2], "little") for at in (12, 14)]
    return width, height, b"".join(data[at:at + 3][::-1] for at in range(18, len(data), 3))


def read_picture(page, name):
    """Width and height, and the red, green and blue, by way of a file that needs no library."""
    subprocess.run([page.program, "-convert", name, "-output", "converted.tga"], cwd=page.folder, check=True)
    width, height, data = read_tga(page.folder / "converted.tga")
    return (width, height), data


def check_hand(page):
    """The picture follows the mouse, and each picture at rest is the one of its command line."""
    page.check_pixels("at the start")
    own = page.run("return document.getElementById('block').value")
    for button, name in [(0, "turned"), (1, "moved"), (2, "nearer")]:
        before = page.run("return document.getElementById('block').value")
        page.drag([(0, 0), (20, 12), (40, 24)], button)
        page.wait("return view.sketches.length > 0", "no sketch was painted")
        page.check_pixels(name)
        after = page.run("return document.getElementById('block').value")
        assert after != before, f"{name}: the camera stays"
        digits = max(len(number) for number in re.findall(r"[\d.]+", after))
        assert digits <= 8, f"{name}: a number of the camera has {digits} characters: {after}"
    page.run("view.canvas.dispatchEvent(new WheelEvent('wheel', {deltaY: -200, cancelable: true}))")
    page.check_pixels("the wheel")
    page.browser.click("#home")
    page.settle()
    assert page.run("return document.getElementById('block').value") == own
    page.drag([(0, 0), (30, 10)])
    page.settle()
    page.browser.click("#keep")
    page.wait("return view.camera === null && view.scene.revision > 0", "the camera is not put into the text")
    page.check_pixels("the camera in the text")


def check_touch(page):
    """Two fingers that part come nearer."""
    before = page.run("return view.seenWith().center")
    page.run("view.canvas.setPointerCapture = () => {}; const box = view.canvas.getBoundingClientRect();"
             "const send = (kind, id, x) => view.canvas.dispatchEvent(new PointerEvent(kind, { pointerId: id,"
             " pointerType: 'touch', clientX: box.left + x, clientY: box.top + 50 }));"
             "send('pointerdown', 11, 100); send('pointerdown', 12, 140); send('pointermove', 12, 220);"
             "send('pointerup', 11, 0); send('pointerup', 12, 0)")
    page.settle()
    after = page.run("return view.seenWith().center")
    pivot = page.run("return view.seenWith().pivot")
    assert math.dist(after, pivot) < 0.5 * math.dist(before, pivot), "the fingers do not come nearer"
    page.run("delete view.canvas.setPointerCapture; find('home').click(); return 0")
    page.settle()


def check_keys(page):
    """The keyboard alone suffices: focus goes everywhere, arrows turn, letters act."""
    page.browser.click("#tab-controls")
    page.run("document.activeElement.blur(); return 0")
    reached = []
    for _ in range(60):
        page.browser.press(TAB)
        reached.append(page.run("return document.activeElement.id"))
        if reached.count("save") > 1:
            break
    for name in ["save", "help-button", "quit", "picture", "command", "block", "tab-controls", "show", "width", "shadows",
                 "samples", "grid"]:
        assert name in reached, f"{name} cannot be reached by the Tab key: {reached}"
    page.run("view.canvas.focus()")
    before = page.run("return JSON.stringify(view.seenWith().center)")
    page.browser.press(ARROW_RIGHT, ARROW_RIGHT)
    page.settle()
    assert page.run("return JSON.stringify(view.seenWith().center)") != before, "the arrow keys do not turn"
    page.check_pixels("the arrow keys")
    page.browser.press("g")
    page.wait("return /visualize_grid/.test(document.getElementById('command').value)", "g shows no grid")
    page.check_pixels("the grid")
    assert page.run("return find('cells').hidden ? 0 : find('cells').children.length") == 18, "the cells have no legend"
    page.browser.press("g")
    page.browser.press("c")
    page.wait("return /-cost_map rays/.test(document.getElementById('command').value)", "c shows no rays without a grid")
    assert "COST MAP" in page.run("return document.getElementById('costs').textContent")
    page.browser.move("#picture", [(3, 3), (4, 4)])
    page.wait("return /^pixel \\d+ \\d+\\d+ rays/.test(find('pointed').textContent)", "the cost of a pixel is not told")
    page.browser.press("c")
    page.wait("return !/-cost_map/.test(document.getElementById('command').value)", "c does not end the cost map")
    page.run("find('grid').value = 'auto'; controlsChanged()")
    page.browser.press("c")
    page.wait("return /-cost_map tests/.test(document.getElementById('command').value)", "c shows no tests in a grid")
    page.browser.press("c")
    page.run("find('grid').value = ''; controlsChanged()")
    page.settle()
    page.browser.press("r")
    page.wait("return view.stage === 'whole' && !/adaptive/.test(document.getElementById('command').value)", "r renders not")
    page.browser.press("?")
    page.wait("return document.getElementById('help').open", "? shows no help")
    page.browser.press(ENTER)
    page.wait("return !document.getElementById('help').open", "the help stays")


def check_overtaking(page):
    """A later picture ends the work for an earlier one."""
    page.settle()
    page.run("window.ended = 0; const view_ = view.question([...wordsOf(), '-random_samples', '1024', '-seed', '1']);"
             "view_.words[1] = view_.words[2] = '2000'; ask('/picture', { view: view_ }).catch((error) => { window.ended = error.status; });")
    work = lambda: sum(map(int, pathlib.Path(f"/proc/{page.process.pid}/stat").read_text().rsplit(")", 1)[1].split()[11:13]))
    time.sleep(0.5)
    before = work()
    time.sleep(0.5)
    assert work() > before + 10, "there is nothing to overtake"
    page.run("ask('/picture', { view: view.question() })")
    page.wait("return window.ended === OVERTAKEN", "the earlier picture is still asked for")
    time.sleep(1)
    before = work()
    time.sleep(0.5)
    assert work() < before + 10, "work goes on for a picture that is overtaken"


def check_letters(page):
    """Letters act where a list or a number has the focus, and change neither."""
    page.browser.click("#tab-controls")
    page.browser.move("#picture", [(3, 3), (4, 4)])
    for name in ["shadows", "bounces"]:
        before = page.run(f"clearRays(); selectTab('controls'); find('{name}').focus(); return find('{name}').value")
        page.browser.press("t")
        page.wait("return traced.rays !== null", f"t does nothing while {name} has the focus")
        assert page.run(f"return find('{name}').value") == before, f"t changes {name}"
    page.run("clearRays(); selectTab('controls'); return 0")


def check_numbers(page):
    """A number outside its limits is told of, and the picture stays."""
    command = "return find('command').value"
    before = page.run(command)
    enter = "find('bounces').value = '%s'; find('bounces').dispatchEvent(new Event('input', {bubbles: true})); return 0"
    page.run(enter % 99)
    said = page.run("return find('wrong').hidden ? '' : find('wrong').textContent")
    assert said == "Bounces: a whole number between 0 and 16 is needed.", said
    time.sleep(0.3)
    assert page.run(command) == before
    page.run(enter % 5)
    assert page.run("return find('wrong').hidden")
    page.settle()


def check_zoom(page, shot):
    """The colours of pixels, and enlarged pixels: they stay under the pointer, and have lines between them from 8 times on."""
    page.settle()
    page.browser.move("#picture", [(10, 20), (11, 20)])
    pixel = page.run("return pointed")
    width, _, data = page.pixels()
    start = 3 * (pixel[1] * width + pixel[0])
    color = " ".join(str(level) for level in data[start:start + 3])
    told = page.run("return find('pointed').textContent")
    assert told.startswith(f"pixel {pixel[0]} {pixel[1]}colour {color}"), (told, color)
    center = "return JSON.stringify(view.seenWith().center)"
    camera = page.run(center)
    page.run("document.activeElement.blur(); return 0")
    ink = "return find('overlay').toDataURL()"
    page.run("markObject(null); return 0")
    fits = page.run("return view.size[0] / size()[0]")
    for times in [times for times in [1, 2, 4, 8, 16] if times > fits]:
        without = page.run(ink)
        page.browser.press("z")
        assert page.run("return [view.magnified, find('zoomed').textContent]") == [times, f"{times}×"]
        assert page.run("return view.pixelAt(...hovered)") == pixel, f"{times} times: another pixel is under the pointer"
        page.run("markObject(null); return 0")
        assert (page.run(ink) != without) == (times >= 8), f"{times} times: the lines between pixels"
    shot("pixels.png")
    page.drag([(0, 0), (32, -16)])
    assert page.run(center) == camera, "the camera moves"
    moved = page.run("return view.pixelAt(...hovered)")
    page.browser.press("Z")
    assert page.run("return [view.magnified, view.pixelAt(...hovered)]") == [8, moved]
    page.browser.click("#zoom-in")
    page.browser.press(ESCAPE)
    assert page.run("return [view.magnified, find('zoomed').textContent]") == [0, "fits"]
    page.check_pixels("enlarged")


def check_rays(page, shot):
    page.browser.click("#tab-controls")
    page.browser.click("#home")
    page.settle()
    page.browser.move("#picture", [(20, 20), (21, 20)])
    page.browser.press("t")
    page.wait("return document.querySelectorAll('#tree li').length > 10", "t traces nothing")
    page.write_scene()
    words = shlex.split(page.run("return document.getElementById('command').value"))
    words = words[:words.index("-output")]
    if "-adaptive_samples" in words:
        at = words.index("-adaptive_samples")
        del words[at:at + 3]
    pixel = page.run("return traced.pixel.map(String)")
    said = subprocess.run([page.program, *words[1:], "-pixel", *pixel], cwd=page.folder, capture_output=True, text=True)
    shown = page.run("return [...document.querySelectorAll('#tree li')].map(line => line.textContent)")
    assert said.stdout.splitlines() == shown, "the tree is not the text of -pixel"
    kinds = page.run("return [...new Set(traced.rays.segments.map(segment => segment.kind))]")
    assert {"camera", "reflected", "refracted", "normal"} <= set(kinds), kinds
    page.run("find('refine').click(); return 0")
    page.drag([(0, 0), (60, -20), (110, -40)])
    page.check_pixels("converged beneath the rays")
    ink = "return find('overlay').toDataURL()"
    drawn = page.run(ink)
    line = page.run("return 1 + [...find('tree').children].findIndex(line => /^ *refracted ray/.test(line.textContent))")
    page.browser.move(f"#tree li:nth-child({line})", [(0, 0)])
    page.wait("return traced.lit !== null && document.querySelectorAll('#tree li.lit').length > 0", "no ray lights up")
    shot("rays.png")
    page.run("find('refine').click(); return 0")
    page.run("find('grid').value = 'auto'; controlsChanged()")
    page.settle()
    page.browser.click("#tracing button")
    page.wait("return traced.rays.cells.length > 3", "no cells are passed")
    before = page.run(ink)
    page.browser.click("#show-cells")
    assert page.run(ink) != before, "the cells are not drawn"
    page.browser.click("#show-cells")
    page.run("find('grid').value = ''; controlsChanged()")
    page.settle()
    page.browser.click("#untrace")
    assert len(page.run(ink)) < len(drawn) / 2, "the rays are not drawn, or stay"


def check_editor(page, shot):
    page.browser.click("#home")
    page.browser.click("#tab-editor")
    page.settle()
    right = page.pixels()
    edit = ("const a = find('text'); a.value = a.value.replace('%s', '%s'); a.dispatchEvent(new Event('input'));")
    page.run(edit % ("angle", "angel"))
    page.wait("return !find('complaint').hidden", "no error is shown")
    complaint = page.run("return find('complaint').textContent")
    assert page.run("return document.querySelector('#marks .error').textContent") == "angel"
    line = page.run("const a = find('text'); return a.value.slice(0, a.value.indexOf('angel')).split('\\n').length")
    assert complaint.startswith(f"line {line}: "), complaint
    assert page.pixels() == right, "the last good picture does not stay"
    shot("error.png")
    page.run(edit % ("angel", "angle"))
    page.wait("return find('complaint').hidden", "the error stays")
    page.check_pixels("the mended text")
    page.run("const a = find('text'); a.value = a.value.replace(/angle [0-9.]+/, 'angle 20'); "
             "a.dispatchEvent(new Event('input'));")
    page.wait("return view.scene.camera.angle === 20", "the edit is not rendered")
    page.check_pixels("an edit")
    page.browser.move("#picture", [(0, 0), (1, 1)])
    page.wait("return editor.object !== null && document.querySelector('#marks .object')", "no object is marked")


def check_comparison(page, shot):
    width, height, _ = page.pixels()
    flags = GLASS.replace("-shadows ", "")
    subprocess.run([page.program, "-input", "s.txt", *flags.split(), "-output", "mine.png"], cwd=page.folder, check=True)
    data = base64.b64encode((page.folder / "mine.png").read_bytes()).decode()
    page.run(f"const bytes = Uint8Array.from(atob('{data}'), c => c.charCodeAt(0)); const t = new DataTransfer();"
             "t.items.add(new File([bytes], 'mine <b>.png'));"
             "document.dispatchEvent(new DragEvent('drop', {dataTransfer: t, cancelable: true}))")
    page.wait("return /^cause/.test(find('cause').textContent)", "no cause is told")
    assert "without -shadows (0 pixels differ)" in page.run("return find('cause').textContent")
    size, mine = read_picture(page, "mine.png")
    own = page.pixels()
    apart = [max(abs(a - b) for a, b in zip(own[2][at:at + 3], mine[at:at + 3])) for at in range(0, len(mine), 3)]
    at = apart.index(max(apart))
    assert size == own[:2]
    page.browser.click("#largest")
    page.wait("return traced.pixel !== null && !find('rays').hidden", "the largest difference is not traced")
    assert page.run("return traced.pixel") == [at % width, at // width]
    page.run("clearRays(); selectTab('compare'); return 0")
    page.browser.click("input[value=reference]")
    assert page.pixels()[2] != own[2], "the file is not shown"
    page.browser.click("input[value=slider]")
    page.browser.move("#picture", [(40, 70), (41, 70)])
    told = page.run("return find('pointed').textContent")
    assert re.match(r"pixel \d+ \d+file \d+ \d+ \d+here \d+ \d+ \d+(equal|apart \d+ \d+ \d+)", told), told
    shot("comparison.png")
    page.browser.click("input[value=own]")
    page.check_pixels("compared")
    page.run("document.activeElement.blur(); return 0")
    page.browser.press("g")
    page.wait("return /visualize_grid/.test(find('command').value)", "g shows no grid in a comparison")
    page.settle()
    assert page.run("return toldImages().length") == 1, "the grid's cells are compared"
    page.browser.press("g")
    page.settle()
    page.browser.press("c")
    page.wait("return /-cost_map/.test(find('command').value) && view.counts !== null", "c shows no cost in a comparison")
    page.settle()
    assert page.run("return find('message').hidden || find('message').textContent") in (True, "Copied."), "c is refused"
    page.browser.press("c")
    page.wait("return view.counts === null && compared.images !== null && view.finished", "it is not compared again")
    page.run("document.activeElement.blur(); return 0")
    page.browser.press("b")
    seen = set()
    for _ in range(40):
        seen.add(page.pixels()[2])
        time.sleep(0.05)
    assert len(seen) == 2, f"blinking shows {len(seen)} pictures"
    page.browser.press("b")
    page.browser.click("#forget")
    page.settle()


def check_windows(page):
    """Windows of every width, light and dark: labels, names and contrast, nothing is cut off, and fingers have targets."""
    send = lambda command, **values: page.browser.ask("POST", "/goog/cdp/execute", {"cmd": command, "params": values})
    small = ("return [...document.querySelectorAll('button, select, input:not([type=checkbox], [type=radio]), label')]"
             ".filter((each) => each.getClientRects().length > 0 && each.getBoundingClientRect().height < 40)"
             ".map((each) => each.outerHTML.slice(0, 80))")
    papers = set()
    for width, height in [(360, 740), (390, 844), (800, 600), (1280, 900), (1920, 1080), (2560, 1440)]:
        send("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        for scheme in ["light", "dark"]:
            send("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
            papers.add(page.run("return getComputedStyle(document.body).backgroundColor"))
            for panel in ["controls", "editor", "rays", "compare"]:
                page.run(f"selectTab('{panel}'); return 0")
                where = f"{width} pixels, {scheme}, {panel}"
                wide = page.run("const { scrollWidth, clientWidth } = document.documentElement; return [scrollWidth, clientWidth]")
                assert wide[0] == wide[1], f"{where}: {wide[0]} pixels in {wide[1]}"
                broken = page.run(RULES)
                assert broken == [], f"{where}: {broken}"
                found = page.run(small) if width < 500 else []
                assert found == [], f"{where}: too small for a finger: {found}"
        top = page.run("scrollTo(0, 0); return find('tab-controls').getBoundingClientRect().top")
        assert top < height, f"{width} pixels: the panels are {top} pixels down"
        if width >= 1280:
            room, shown = page.run("return [view.room, view.size]")
            fills = max(shown[0] / room[0], shown[1] / room[1])
            assert 0.8 <= fills <= 1.001, f"{width} pixels: the picture fills {fills} of its room"
    assert len(papers) == 2, "there is no dark scheme"
    for command in ["Emulation.clearDeviceMetricsOverride", "Emulation.setEmulatedMedia"]:
        send(command)


def check_end(page):
    page.run("document.activeElement.blur(); return 0")
    page.browser.press("q")
    assert page.process.wait(20) == 0
    page.wait("return document.body.classList.contains('ended')", "the page does not say that it has ended")
    alive = page.run("return ['save', 'quit', 'controls', 'home', 'tracing'].filter((id) => !find(id).inert)")
    assert alive == [], f"these look alive: {alive}"


def check_download(program, browser, folder):
    """Save without a picture in the command line, and the end of a program that says nothing."""
    page = Page(program, browser, "scene6_14_glass_sphere.txt", GLASS, folder, outputs=())
    try:
        page.settle()
        browser.ask("POST", "/goog/cdp/execute", {
            "cmd": "Browser.setDownloadBehavior", "params": {"behavior": "allow", "downloadPath": str(folder)}})
        browser.click("#save")
        for _ in range(100):
            if (folder / "s.png").exists():
                break
            time.sleep(0.1)
        words = shlex.split(page.run("return find('command').value"))
        subprocess.run([program, *words[1:]], cwd=folder, check=True)
        said = subprocess.run([program, "-compare", "s.png", "-reference", "picture.png"], cwd=folder,
                              capture_output=True, text=True, check=True).stdout
        assert re.search(r"pixels that differ +0 ", said), said
        page.process.send_signal(signal.SIGINT)
        page.process.wait(20)
        page.wait("return !find('over').hidden", "the page looks alive", 3)
    finally:
        page.close()
    # Here it has looked for its program.
    entries = browser.ask("POST", "/se/log", {"type": "browser"})
    assert all("/alive" in entry["message"] for entry in entries), entries


def check_opened_comparison(program, browser, folder):
    """A page that is opened with -compare shows the cause of the difference."""
    page = Page(program, browser, "scene6_14_glass_sphere.txt", f"{GLASS} -compare mine.png", folder)
    try:
        page.wait("return /^cause/.test(find('cause').textContent)", "no cause is told")
        assert page.run("return !find('compare').hidden && find('cause').checkVisibility()"), "the cause is not in sight"
    finally:
        page.close()


def check_glass(program, browser, folder, shot):
    page = Page(program, browser, "scene6_14_glass_sphere.txt", GLASS, folder)
    try:
        page.settle()
        page.check_pixels("converged")
        page.run("find('refine').click(); return 0")
        check_hand(page)
        check_touch(page)
        check_keys(page)
        check_overtaking(page)
        check_letters(page)
        check_numbers(page)
        check_zoom(page, shot)
        check_rays(page, shot)
        check_editor(page, shot)
        check_comparison(page, shot)
        check_windows(page)
        check_end(page)
    finally:
        page.close()


def check_mark(page, pixel):
    """The mark of a ray that ends where it is seen lies on its pixel, also where the view is stretched."""
    page.run(f"trace({pixel}); return 0")
    page.wait("return traced.rays !== null", "no ray is traced")
    at = page.run("const to = traced.rays.segments.find((line) => line.kind === 'camera').to;"
                  "const { x, y } = view.seenWith().project(to, size()); return [x, y]")
    assert math.dist(at, [pixel[0] + 0.5, pixel[1] + 0.5]) < 0.01, at


def check_editions(program, browser, folder, shot):
    """The choice of edition: what it takes, what goes without a flag, and where the overlay shows a ray."""
    page = Page(program, browser, "editions/glass_2012a5.txt", "-size 72 48 -shadows", folder)
    choose = ("const e = find('%s'); e.value = '%s'; e.dispatchEvent(new Event('input', {bubbles: true})); return 0")
    command = "return find('command').value"
    try:
        page.run("find('refine').click(); return 0")
        page.settle()
        assert "2012a5" in page.run("return find('taken').textContent")
        assert page.run("return find('bounces').placeholder") == "4"
        page.check_pixels("by the scene")
        assert "-edition 2012a5" in page.run(command), page.run(command)
        page.browser.ask("POST", "/goog/cdp/execute", {"cmd": "Emulation.setDeviceMetricsOverride", "params": {
            "width": 360, "height": 1500, "deviceScaleFactor": 1, "mobile": False}})
        shot("edition_360.png")
        page.browser.ask("POST", "/goog/cdp/execute", {"cmd": "Emulation.clearDeviceMetricsOverride", "params": {}})
        shot("edition.png")
        page.run(choose % ("samples", "-jitter"))
        page.wait("return view.image.width === 216", "the samples do not enlarge the picture")
        page.check_pixels("displaced samples")
        page.run(choose % ("samples", ""))
        page.run(choose % ("edition", "2019"))
        page.wait("return /Scene/.test(find('taken').textContent)", "no error is told of")
        page.run(choose % ("edition", "2012a5"))
        page.wait("return find('taken').textContent === '' && /-edition 2012a5/.test(find('command').value)", "it is not taken")
        page.settle()
        check_mark(page, [6, 40])
        page.drag([(0, 0), (40, 12)])
        page.check_pixels("turned where the view is stretched")
    finally:
        page.close()
    page = Page(program, browser, "editions/mirrors_2019.txt", "-size 60 45 -edition 2019", folder)
    try:
        page.run("find('refine').click(); return 0")
        page.settle()
        assert page.run("return find('edition').value") == "2019" and "-edition 2019" in page.run(command)
        page.drag([(0, 0), (30, 40)])
        page.check_pixels("turned where up is as written")
        check_mark(page, [30, 32])
    finally:
        page.close()


def check_rabbit(program, browser, folder, shot):
    page = Page(program, browser, "scene6_07_bunny_mesh_40k.txt", "-size 400 400 -shadows", folder)
    try:
        page.settle()
        page.drag([(0, 0), (30, 8), (60, 16)])
        page.check_pixels("the rabbit turned")
        shot("turned.png")
    finally:
        page.close()


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program", nargs="?", default=ROOT / "target/release/raytracer", type=pathlib.Path)
    parser.add_argument("--screenshots", type=pathlib.Path)
    options = parser.parse_args()
    found = find_browser()
    if not found:
        print("skipped: there is no Chromium with its driver")
        return
    program = options.program.resolve()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        browser = Browser(*found, folder / "profile")
        shot = lambda name: browser.screenshot(options.screenshots, name)
        try:
            check_rabbit(program, browser, folder, shot)
            check_glass(program, browser, folder, shot)
            check_opened_comparison(program, browser, folder)
            check_editions(program, browser, folder, shot)
            complaints = [entry["message"] for entry in browser.ask("POST", "/se/log", {"type": "browser"})]
            assert not complaints, complaints
            check_download(program, browser, folder)
        finally:
            browser.close()
    print("the live page: pixels equal those of its command lines; hand, keys, zoom, rays, editor, comparison and windows work")


if __name__ == "__main__":
    sys.exit(main())
