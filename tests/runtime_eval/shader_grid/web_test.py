#!/usr/bin/python3
"""look_up.glsl in a browser, over a quarter of the places of the Vulkan test: as GLSL ES in WebGL 2, or as WGSL in WebGPU, with resample.comp.

    web_test.py webgl|webgpu BUILD_FOLDER SHADER_CASES

Status has to be that of lookUpIrradiance, light within 1e-3 of it (of 1, where it is below). Exit code 77, a skipped test, where there is no
browser or, for WebGPU, none of what makes WGSL.
"""
import base64
import json
import os
import shutil
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.join(HERE, "..", "..", "..")
sys.path.append(os.path.join(ROOT, "tests"))
from browser import BROWSERS, SKIPPED, Browser, find_browser

PLACES = 400 * 64
# without a graphics card by SwiftShader, which comes with Chromium
OPTIONS = ["--enable-unsafe-swiftshader", "--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader"]
RUN = {"webgl": "lookUpByWebGL()", "webgpu": "lookUpByWebGPU()"}
FILES = {"webgl": ("grid.bin", "places.bin", "lights.bin"), "webgpu": ("grid.bin", "places.bin", "lights.bin", "box.bin", "texels.bin")}


def why_not(interface, naga):
    """What is missing, or None."""
    if not find_browser():
        return f"none of {', '.join(BROWSERS)} is installed"
    if interface == "webgpu":
        if not shutil.which("glslangValidator"):
            return "glslangValidator is not installed"
        if not shutil.which("node") or not os.path.isdir(os.path.join(naga, "node_modules", "naga-wasm")):
            return f"naga is not installed; workflow/install_from_npm.sh naga {naga} says why not"
    return None


def write_page(interface, case, naga):
    texts = {}
    if interface == "webgl":
        with open(os.path.join(case, "look_up.glsl"), encoding="utf-8") as file:
            texts["look_up.glsl"] = file.read()
    else:
        for source, name in (("look_up.glsl", "look_up.wgsl"), ("resample.comp", "resample.wgsl")):
            out = os.path.join(case, name)
            subprocess.run(["node", os.path.join(ROOT, "export", "shader", "wgsl.mjs"), naga, os.path.join(case, source), out], check=True)
            with open(out, encoding="utf-8") as file:
                texts[name] = file.read()
    files = {}
    for name in FILES[interface]:
        with open(os.path.join(case, name), "rb") as file:
            files[name] = base64.b64encode(file.read()).decode()
    with open(os.path.join(HERE, "web_page.js"), encoding="utf-8") as file:
        script = file.read()
    page = os.path.join(case, "page.html")
    with open(page, "w", encoding="utf-8") as file:
        file.write(f"<!doctype html><meta charset=utf-8><script>const kTexts = {json.dumps(texts)}, kFiles = {json.dumps(files)};</script><script>{script}</script>")
    return "file://" + page


def failures_of(name, answer):
    light = answer["look_up"]
    result = [f"{name}: {light[key]} of {light['places']} places: {key}" for key in ("other_status", "above") if light[key]]
    if light["places"] != PLACES or light["lit"] < PLACES // 10:
        result.append(f"{name}: {light['places']} places, {light['lit']} of them lit; expected {PLACES}, most of them lit")
    texels = answer.get("resampled")
    if texels:
        result += [f"{name}: {texels[key]} of {texels['texels']} texels: {key}" for key in ("other_say", "above") if texels[key]]
        if texels["lit"] < 1000:
            result.append(f"{name}: {texels['lit']} of {texels['texels']} texels lit, expected more")
    return result


def main():
    interface, build, cases = sys.argv[1:]
    naga = os.path.join(os.path.dirname(os.path.abspath(build)), "naga")
    missing = why_not(interface, naga)
    failures = []
    if not missing:
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([cases, folder, str(PLACES)], check=True)
            browser = Browser(find_browser(), os.path.join(folder, "profile"), OPTIONS)
            try:
                for name in ("int8", "float16"):
                    browser.events.clear()
                    browser.open(write_page(interface, os.path.join(folder, name), naga))
                    answer = browser.value(RUN[interface])
                    missing = answer.get("missing")
                    if missing:
                        break
                    print(f"{name}: {json.dumps(answer)}")
                    failures += failures_of(name, answer)
            finally:
                browser.close()
    if missing:
        print(f"SKIPPED: {missing}")
        return SKIPPED
    for text in failures:
        print("FAILED:", text)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
