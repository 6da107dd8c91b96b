#!/usr/bin/python3
"""Exported light in three.js, in a browser: the guide's own lines draw patches at many places, and their light is compared.

    three_test.py BUILD_FOLDER THREE_CASES

LightProbeGrid (WebGPU) and LightProbeGridWebGL have to show what our model of them says of the same files, but for the bits of a linear
filter's weights; ours, looked up per pixel, is to be within 1e-3 of lookUpIrradiance, or of the mean irradiance where that is larger. Exit code 77, a
skipped test, where there is no browser, no three.js, or none of what makes WGSL.
"""
import functools
import http.server
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.join(HERE, "..", "..", "..")
sys.path.append(os.path.join(ROOT, "tests"))
from browser import BROWSERS, SKIPPED, Browser, complaints, find_browser

PLACES = 512
OFFSET_M = 0.02  # of both modules
PER_PIXEL_BOUND = 1e-3
ORIGIN = [2, -1, 4]  # of the level, in the pages that move it
# without a graphics card by SwiftShader, which comes with Chromium
OPTIONS = ["--enable-unsafe-swiftshader", "--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader"]
IMPORTS = {"three": "/three/build/three.module.js", "three/webgpu": "/three/build/three.webgpu.js", "three/tsl": "/three/build/three.tsl.js",
           "three/addons/": "/three/examples/jsm/"}
RENDERERS = {"webgl": "const renderer = new THREE.WebGLRenderer();", "webgpu": "const renderer = new THREE.WebGPURenderer();\nawait renderer.init();"}
# what else is tried where a hook was put into materials
HOOKS = """
const refused = [];
const attempt = (what) => { try { what(); } catch (error) { refused.push(error.message); } };
const other = new NeuralLightGrid(kWords, kLookUp);
attempt(() => other.applyTo(patches.objects[1].material));
attempt(() => new NeuralLightGrid(kWords, kLookUp.replace('NLG_CLASS_COUNT', 'NLG_OTHER')));
attempt(() => new NeuralLightGrid(kWords, kLookUp.replace(/(NLG_LIGHT_FIELDS uint\[\]\()\d+/, '$10')));
const basic = new THREE.Mesh(new THREE.PlaneGeometry(), new THREE.MeshBasicMaterial({name: 'plain'}));
basic.frustumCulled = false;
grid.applyTo([basic.material]);
attempt(() => renderer.render(new THREE.Scene().add(basic), new THREE.PerspectiveCamera()));
grid.removeFrom(basic.material);
renderer.render(new THREE.Scene().add(basic), new THREE.PerspectiveCamera());

// another grid's text is another program
const materials = [];
for (const root of patches.objects) root.traverse((object) => object.isMesh && materials.push(object.material));
const twice = new NeuralLightGrid(kWords, kLookUp.replace('max(irradiance *', 'max(2.0 * irradiance *'));
twice.position.copy(grid.position);
for (const material of materials) grid.removeFrom(material);
twice.applyTo(materials);
const doubled = await patches.draw(renderer, scene);
twice.dispose();
grid.applyTo(materials);

grid.dispose();
const disposed = await patches.draw(renderer, scene);
Object.assign(answer, {refused, doubled, disposed});
"""
# what else is tried where the grid is a light of the scene
LIGHTS = """
const other = await NeuralLightGrid.load('./level_per_pixel');
other.position.copy(grid.position);
other.intensity = 0.5;
scene.add(other);
const both = await patches.draw(renderer, scene);
scene.remove(grid, other);
grid.dispose();
other.dispose();
const disposed = await patches.draw(renderer, scene);
const webgl = new THREE.WebGPURenderer({forceWebGL: true});
await webgl.init();
const refused = [], say = console.error;
console.error = (text) => refused.push(text.split(' "')[0]);
webgl.render(new THREE.Scene().add(grid, new THREE.Mesh(new THREE.PlaneGeometry(), new THREE.MeshLambertMaterial())), new THREE.OrthographicCamera());
console.error = say;
Object.assign(answer, {refused, both, disposed});
"""


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}: {done.stderr}")
    return done.stdout


def guide_lines():
    """The JavaScript of the guide, by the module that it imports."""
    with open(os.path.join(ROOT, "docs", "guide", "engines.md"), encoding="utf-8") as file:
        blocks = re.findall(r"```js\n(.*?)```", file.read(), flags=re.DOTALL)
    found = {module: [block for block in blocks if f"/{module}'" in block] for module in ("LightProbeGrid.js", "three_light_grid.js", "three_light_grid_webgpu.js")}
    for module, of_module in found.items():
        if len(of_module) != 1:
            sys.exit(f"the guide has {len(of_module)} blocks of lines that import {module}")
    return {module: of_module[0] for module, of_module in found.items()}


def pages():
    """What is drawn: renderer, lines of the guide, key of what is expected, what else is tried, and what judges that."""
    lines = guide_lines()
    texture = lines["LightProbeGrid.js"]
    of_webgl = texture.replace("three/webgpu", "three").replace("LightProbeGrid", "LightProbeGridWebGL")
    return {
        "LightProbeGridWebGL": ("webgl", of_webgl, "texture", "", None),
        "LightProbeGrid": ("webgpu", texture, "texture", "", None),
        "per_pixel_webgl": ("webgl", lines["three_light_grid.js"], "per_pixel", HOOKS, failures_of_hooks),
        "per_pixel_webgpu": ("webgpu", lines["three_light_grid_webgpu.js"], "per_pixel", LIGHTS, failures_of_lights),
    }


def script(renderer, lines, expected, more):
    origin = ORIGIN if expected == "per_pixel" else [0, 0, 0]
    moved = f"grid.position.set({origin[0]}, {origin[1]}, {origin[2]});" if expected == "per_pixel" else ""
    return f"""import {{ Patches }} from '/three_patches.js';
const patches = new Patches(THREE, {{origin: {origin}}});
const scene = new THREE.Scene();
scene.add(...patches.objects);
{lines}
{moved}
{RENDERERS[renderer]}
export const answer = {{light: await patches.draw(renderer, scene)}};
{more}
"""


def write_case(folder, grid, tool, cases, naga, scene):
    """A grid for three.js, texels of its scene if there is one, the places, and the pages; returns the places."""
    per_pixel = os.path.join(folder, "level_per_pixel")
    if scene:
        run(tool("nlg-export"), "engine", scene, "--format", "three", "--out", folder, "--places", "100", "--truth-rays", "8", "--spacing-m", "0.5")
    run(tool("nlg-export"), "shader", "--grid", grid, "--format", "three-per-pixel", "--out", per_pixel)
    run("node", os.path.join(ROOT, "export", "shader", "wgsl.mjs"), naga, os.path.join(per_pixel, "look_up.glsl"), os.path.join(per_pixel, "look_up.wgsl"))
    places = json.loads(run(cases, "places", grid, folder, repr(OFFSET_M), str(PLACES)))
    with open(os.path.join(per_pixel, "look_up.glsl"), encoding="utf-8") as file:
        look_up = file.read()
    with open(os.path.join(per_pixel, "grid.bin"), "rb") as file:
        words = file.read()
    numbers = [int.from_bytes(words[i:i + 4], "little") for i in range(0, len(words), 4)]
    with open(os.path.join(folder, "page.html"), "w", encoding="utf-8") as file:
        file.write(f"<!doctype html><meta charset=utf-8><link rel=icon href=data:,><script type=importmap>{json.dumps({'imports': IMPORTS})}</script>"
                   f"<script>const kPlaces = {json.dumps(places)}, kLookUp = {json.dumps(look_up)}, kWords = new Uint32Array({numbers});</script>")
    for name, page in pages().items():
        with open(os.path.join(folder, name + ".js"), "w", encoding="utf-8") as file:
            file.write(script(*page[:4]))
    return places


class QuietHandler(http.server.SimpleHTTPRequestHandler):
    extensions_map = {**http.server.SimpleHTTPRequestHandler.extensions_map, ".js": "text/javascript"}

    def log_message(self, *_):
        pass


def channels(light):
    return [light[4 * i:4 * i + 3] for i in range(PLACES)]


def failures_of(name, answer, places, expected):
    light = answer["light"]
    missing = sum(light[4 * i + 3] != 1 for i in range(PLACES))
    mean = sum(sum(place[expected]) for place in places) / (3 * PLACES)
    shares = []  # of what is allowed
    largest = 0.0
    for place, rgb in zip(places, channels(light)):
        for got, right in zip(rgb, place[expected]):
            bound = place["bound"] if expected == "texture" else PER_PIXEL_BOUND * max(right, mean)
            # NaN is no agreement
            shares.append(abs(got - right) / bound if got == got else float("inf"))
            largest = max(largest, abs(got - right))
    lit = sum(max(place[expected]) > 0 for place in places)
    print(f"{name}: {PLACES} places, {lit} of them lit, mean irradiance {mean:.3g}; off by {largest:.2g} at most, which is {max(shares):.2g} of what is allowed at worst")
    failures = []
    if missing:
        failures.append(f"{name}: {missing} patches were not drawn")
    if max(shares) > 1:
        failures.append(f"{name}: {sum(share > 1 for share in shares)} of {len(shares)} numbers are off")
    if lit < PLACES // 2:
        failures.append(f"{name}: {lit} places are lit; expected most of them")
    return failures


def failures_of_hooks(name, answer, _):
    light, doubled = channels(answer["light"]), channels(answer["doubled"])
    failures = []
    if any(abs(b[c] - 2 * l[c]) > 1e-5 * max(1, b[c]) for l, b in zip(light, doubled) for c in range(3)):
        failures.append(f"{name}: a second grid is looked up by the first one's text")
    return failures + failures_of_end(name, answer, ["MeshPhongMaterial '' has the light of another grid", *2 * ["grid.bin and look_up.glsl are not of one grid"],
                "MeshBasicMaterial 'plain' is not lit by three.js: no #include <lights_fragment_begin>"])


def failures_of_lights(name, answer, _):
    off = sum(abs(b[c] - 1.5 * l[c]) > 1e-5 * max(1, b[c]) for l, b in zip(channels(answer["light"]), channels(answer["both"])) for c in range(3))
    failures = [f"{name}: two grids do not add up at {off} of the numbers"] if off else []
    return failures + failures_of_end(name, answer, ["THREE.TSL: Error: three_light_grid_webgpu.js: no WebGPU; use WebGLRenderer and three_light_grid.js"])


def failures_of_end(name, answer, expected):
    failures = []
    if any(max(rgb) > 0 for rgb in channels(answer["disposed"])):
        failures.append(f"{name}: a grid that was disposed of gives light")
    if answer["refused"] != expected:
        failures.append(f"{name}: refused {answer['refused']}, not {expected}")
    return failures


def why_not(three, naga):
    """What is missing, or None."""
    if not find_browser():
        return f"none of {', '.join(BROWSERS)} is installed"
    if not shutil.which("node") or not shutil.which("glslangValidator"):
        return "node or glslangValidator is not installed"
    for what, folder, package in (("three", three, "three"), ("naga", naga, "naga-wasm")):
        if not os.path.isdir(os.path.join(folder, "node_modules", package)):
            return f"{what} is not installed; workflow/install_from_npm.sh {what} {folder} says why not"
    return None


def main():
    build, cases = (os.path.abspath(path) for path in sys.argv[1:])
    three, naga = (os.path.join(os.path.dirname(build), what) for what in ("three", "naga"))
    missing = why_not(three, naga)
    if missing:
        print(f"SKIPPED: {missing}")
        return SKIPPED
    tool = lambda name: os.path.join(build, "bin", name)
    failures = []
    with tempfile.TemporaryDirectory() as folder:
        os.symlink(os.path.join(three, "node_modules", "three"), os.path.join(folder, "three"))
        shutil.copy(os.path.join(HERE, "three_patches.js"), folder)
        cornell, every = (os.path.join(folder, name + ".safetensors") for name in ("cornell", "every_representation"))
        run(tool("nlg-bake"), "cornell", "--spacing-m", "0.5", "--out", cornell)
        run(cases, "grid", every)
        places = {"cornell": write_case(os.path.join(folder, "cornell"), cornell, tool, cases, naga, "cornell"),
                  "every_representation": write_case(os.path.join(folder, "every_representation"), every, tool, cases, naga, None)}
        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(QuietHandler, directory=folder))
        threading.Thread(target=server.serve_forever, daemon=True).start()
        browser = Browser(find_browser(), os.path.join(folder, "profile"), OPTIONS)
        try:
            for case, of_case in places.items():
                for name, (_, _, expected, _, judge) in pages().items():
                    if expected == "texture" and case != "cornell":
                        continue  # a grid of no scene has no texels
                    what = f"{case}, {name}"
                    browser.events.clear()
                    browser.open(f"http://127.0.0.1:{server.server_address[1]}/{case}/page.html")
                    answer = browser.value(f"import('./{name}.js').then((module) => module.answer)")
                    failures += [f"{what}: {complaint[:2000]}" for complaint in complaints(browser.events)]
                    failures += failures_of(what, answer, of_case, expected)
                    if judge:
                        failures += judge(what, answer, of_case)
        finally:
            browser.close()
            server.shutdown()
    for text in failures:
        print("FAILED:", text)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
