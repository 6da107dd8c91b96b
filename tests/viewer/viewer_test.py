#!/usr/bin/python3
"""nlg-view's page in a real browser: it opens at desktop and phone width without a complaint, and its pixels are those of nlg-render.

    viewer_test.py BUILD_FOLDER SCREENSHOT_FOLDER cornell|level

`level` is kaos2 of OpenArena, where Debian's package of it is installed. Exit code 77, a skipped test, where there is no browser or no
level.
"""
import json
import os
import signal
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from browser import BROWSERS, SKIPPED, Browser, complaints, find_browser
from PIL import Image, ImageChops

LEVELS = "/usr/share/games/openarena/baseoa"
SIZES = {"desktop": (1280, 800), "phone": (390, 844)}
WIDTH, HEIGHT = 320, 180  # of pictures that are compared
SETTINGS = {"cornell": ["--spacing-m", "0.5"], "level": []}
VIEWS = {"cornell": 2, "level": 5}
BASELINES = {"cornell": ["valid-trilinear", "ddgi"], "level": ["valid-trilinear"]}
# Edges are drawn by four samples here and there, at other places; a surface stands at the same offset before what is near. What lies
# between is the same light to a step of 255.
# pixels a side: the page filters the images of a level, which nlg-render does not; blocks of these keep light apart from the noise of images
BLOCK, MOST_MEDIAN = {"cornell": 1, "level": 10}, {"cornell": 1.0, "level": 2.0}
MOST_MEAN, MOST_BEYOND_EDGES = 2.5, 0.04  # steps of 255; the last: share of pixels off by more than 16
LONGEST_WAIT_S = 240
# boxes that stick out of the window
STICKING_OUT = """[...document.querySelectorAll('#panel *')].filter(e => e.getBoundingClientRect().width > 0 && e.getBoundingClientRect().right > innerWidth + 0.5)
  .map(e => e.id || e.tagName)"""


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}: {done.stderr}")
    return done.stdout


def facts_of(folder):
    with open(os.path.join(folder, "scene.js"), encoding="ascii") as file:
        text = file.read()
    return json.loads(text[text.index("{"):text.rindex(', "')])


class Page:
    def __init__(self, browser, url):
        self.browser, self.url = browser, url

    def open(self, width, height, **query):
        self.browser.events.clear()
        self.browser.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 600)
        self.browser.open(self.url + "?" + "&".join(f"{key}={value}" for key, value in query.items()))
        end = time.monotonic() + LONGEST_WAIT_S
        while True:
            state = json.loads(self.browser.value("JSON.stringify(document.documentElement.dataset)"))
            if "error" in state:
                sys.exit(f"{query}: the page says {state['error']}")
            if "ready" in state:
                break
            if time.monotonic() > end:
                sys.exit(f"{query}: no picture within {LONGEST_WAIT_S} s")
            time.sleep(0.1)
        # the frame that is shown by now is the one that was drawn
        self.browser.value("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
        if found := complaints(self.browser.events, lambda url: url.startswith("file:")):
            sys.exit(f"{query}: {json.dumps(found)[:2000]}")
        return state


def waited(browser, expression):
    """Whether it comes true."""
    end = time.monotonic() + LONGEST_WAIT_S / 4
    while time.monotonic() < end:
        if browser.value(expression):
            return True
        time.sleep(0.05)
    return False


def made_with_first_page(command, page):
    """The page is there before what the grid is compared with, and says that this follows."""
    with subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True) as making:
        lines = iter(making.stderr.readline, "")
        if not any(line.endswith("errors follow\n") for line in lines):
            sys.exit(f"{command}: no line says that there is a page")
        making.send_signal(signal.SIGSTOP)
        try:
            page.open(WIDTH, HEIGHT)
            shown = json.loads(page.browser.value("JSON.stringify([document.getElementById('warnings').textContent, document.getElementById('left').options.length])"))
        finally:  # a stopped one would be waited for
            making.send_signal(signal.SIGCONT)
        rest = making.stderr.read()
        if making.wait() != 0:
            sys.exit(f"{command}: {rest}")
    return [] if "Not here yet" in shown[0] and shown[1] == 1 else [f"the first page shows {shown}"]


def check_states(browser, tool, folder, out):
    """A grid of two states of light is shown by its first; the other one is a slider away."""
    view, day, both = (os.path.join(folder, name) for name in ("states", "day.safetensors", "both.safetensors"))
    run(tool("nlg-bake"), "cornell:0", "--spacing-m", "0.5", "--light-state", "day", "--out", day)
    run(tool("nlg-bake"), "cornell:0", "--spacing-m", "0.5", "--light-state", "night", "--light-groups", "kind", "--intensity", ".05", "--relight", day, "--out", both)
    run(tool("nlg-view"), "cornell:0", "--grid", both, "--light-state", "day", "--out", view, "--baselines", "none", "--truth-views", "0", "--truth-samples", "0")
    page, failures = Page(browser, "file://" + os.path.join(view, "index.html")), []
    rows = """JSON.stringify([...document.querySelectorAll('#groups label')].map(row => [row.textContent.trim(), row.querySelector('input').value]))"""
    brightest = {}
    for name, query in {"day": {}, "night": {"light": "day:0&light=night:1"}, "mixed": {"light": "day:0.5&light=night:1&light=night/emission:0"}}.items():
        # what is hidden stands in the page
        page.open(WIDTH, HEIGHT, ui=0, divider=1, **query)
        shown = json.loads(browser.value(rows))
        day, night, emission = {"day": ("1", "0", "1"), "night": ("0", "1", "1"), "mixed": ("0.5", "1", "0")}[name]
        if shown != [["day", day], ["night", night], ["emission", emission]]:
            failures.append(f"states, {name}: the sliders are {shown}")
        picture = os.path.join(out, f"states_{name}.png")
        browser.picture(picture, WIDTH, HEIGHT)
        pixels = Image.open(picture).convert("L").tobytes()
        brightest[name] = sum(pixels) / len(pixels)
    print(f"states, mean of 255: {brightest}")
    # a twentieth of the light is a quarter of sRGB's steps
    if not brightest["night"] < 0.4 * brightest["day"] or not brightest["night"] < brightest["mixed"] < brightest["day"]:
        failures.append(f"states: means of pictures are {brightest}")
    return failures


def difference(a, b, block):
    """Per block of pixels the largest over the channels, as a rising list."""
    channels = ImageChops.difference(*(Image.open(path).convert("RGB").reduce(block) for path in (a, b))).split()
    return sorted(ImageChops.lighter(ImageChops.lighter(channels[0], channels[1]), channels[2]).tobytes())


def main():
    build, out, which = sys.argv[1:]
    scene = "cornell" if which == "cornell" else f"{LEVELS}:kaos2"
    if not find_browser():
        print(f"skipped: none of {', '.join(BROWSERS)} is installed")
        return SKIPPED
    if which == "level" and not os.path.isdir(LEVELS):
        print("skipped: no levels; Debian: openarena-081-maps")
        return SKIPPED
    os.makedirs(out, exist_ok=True)
    tool = lambda name: os.path.join(build, "bin", name)
    failures = []
    with tempfile.TemporaryDirectory() as folder:
        grid, view = os.path.join(folder, "grid.safetensors"), os.path.join(folder, "view")
        run(tool("nlg-bake"), scene, *SETTINGS[which], "--out", grid)
        browser = Browser(find_browser(), os.path.join(folder, "profile"), ["--enable-unsafe-swiftshader"])
        page = Page(browser, "file://" + os.path.join(view, "index.html"))
        command = [tool("nlg-view"), scene, "--grid", grid, "--out", view, "--baselines", ",".join(BASELINES[which]), "--truth-views", str(VIEWS[which]), "--truth-width", "64",
                   "--truth-rays", "8", "--truth-samples", "100"]
        failures += made_with_first_page(command, page)
        page_bytes = sum(os.path.getsize(os.path.join(view, name)) for name in ("index.html", "viewer.js"))
        if page_bytes > 2e6:
            failures.append(f"the page has {page_bytes} bytes; 2 MB are what it may have")
        facts = facts_of(view)
        for name, (width, height) in SIZES.items():
            state = page.open(width, height)
            print(f"{which}, {name}: first frame, a quarter as sharp, after {state['firstFrameMs']} ms; the whole one after {state['fullFrameMs']} ms")
            sticking = browser.value(STICKING_OUT)
            if sticking or browser.value("document.documentElement.scrollWidth") > width:
                failures.append(f"{name}: wider than the window: {sticking}")
            browser.picture(os.path.join(out, f"{which}_{name}.png"), width, height)
        # whatever can be shown is drawn without a complaint
        for show, query in {"leaks": {}, "share": {}, "difference": {}, "marks": {"probes": 1, "cells": 1, "ball": 1, "figure": 1}, "worst": {}}.items():
            place = len(facts["views"]) + len(facts["starts"]) if show == "worst" else 0
            page.open(640, 360, ui=0, place=place, **({"show": show} if show in ("leaks", "share", "difference") else {}), **query)
            browser.picture(os.path.join(out, f"{which}_{show}.png"), 640, 360)
        pairs = [(view_idx, "grid") for view_idx in range(len(facts["views"]))] + [(0, baseline) for baseline in BASELINES[which]]
        for view_idx, method in pairs:
            camera = facts["views"][view_idx]
            eye = [a + b for a, b in zip(camera["eye"], facts["origin_m"])]
            look = [a + b for a, b in zip(eye, camera["forward"])]
            text = lambda three: ",".join(repr(number) for number in three)
            drawn, shown = os.path.join(out, f"{which}_{view_idx}_{method}_render.png"), os.path.join(out, f"{which}_{view_idx}_{method}.png")
            run(tool("nlg-render"), scene, "--grid", grid, *SETTINGS[which], "--method", method, f"--eye={text(eye)}", f"--look={text(look)}", "--fov",
                repr(camera["fov_y"] * 57.29577951308232), "--exposure", repr(camera["exposure"]), "--width", str(WIDTH), "--height", str(HEIGHT), "--out", drawn)
            page.open(WIDTH, HEIGHT, ui=0, place=view_idx, left=method, right=method, divider=1)
            browser.picture(shown, WIDTH, HEIGHT)
            off = difference(drawn, shown, BLOCK[which])
            median, mean, beyond = off[len(off) // 2], sum(off) / len(off), sum(value > 16 for value in off) / len(off)
            print(f"{which}, view {view_idx}, {method}: off by {median} (median), {mean:.2f} (mean) of 255; by more than 16: {100 * beyond:.2f} % of the pixels")
            if median > MOST_MEDIAN[which] or mean > MOST_MEAN or beyond > MOST_BEYOND_EDGES:
                failures.append(f"view {view_idx} by {method} is not what nlg-render draws: {shown}, {drawn}")
        if which == "cornell":
            failures += check_states(browser, tool, folder, out)
        # what is wrong is said on the page
        browser.events.clear()  # among them that the page before was loaded
        browser.open(page.url + "?left=nothing")
        if not waited(browser, "document.getElementById('message')?.hidden === false && document.getElementById('message').textContent.includes('no method nothing')"):
            failures.append("an unknown method: the page says nothing of it")
        browser.close()
    print("\n".join(failures))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
