#!/usr/bin/python3
"""nlg-view --watch: what is saved is baked again and served, on this machine's own address alone, and whatever ends leaves nothing half written.

    watch_test.py BUILD_FOLDER served
    watch_test.py BUILD_FOLDER SCREENSHOT_FOLDER page    in a real browser; exit code 77, a skipped test, where there is none
"""
import http.client
import json
import os
import re
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.append(str(Path(__file__).resolve().parents[1]))
from browser import BROWSERS, SKIPPED, Browser, find_browser
from tools import SECONDS

BUILD, KIND = Path(sys.argv[1]).resolve(), sys.argv[-1]
# both halves of one room have a lamp of their own, and the wall between them shines
LAMPS = {"warm": [-1.5, 1.5, 0], "cold, blue": [1.5, 1.5, 0]}
COLOURS = {"warm": [1, .8, .6], "cold, blue": [.3, .5, 1]}
SETTINGS = ["--spacing-m", ".95", "--light-groups", "name", "--light-samples", "8", "--light-rays", "32"]
SIZE = (320, 180)


def boxes(wall_x):
    """A room of 6 x 3 x 4 m that faces in, and a wall across it: positions and triangles."""
    positions, triangles = [], []
    for low, high, turn in (((-3, 0, -2), (3, 3, 2), 1), ((wall_x - .1, 0, -2), (wall_x + .1, 2, .5), -1)):
        first = len(positions)
        positions += [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
        for a, b, c, d in ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)):
            for corner in ((a, b, c), (a, c, d)):
                triangles.append([first + i for i in corner[::-turn]])
    return positions, triangles


class Level:
    """level.gltf with level.bin beside it."""

    def __init__(self, folder):
        self.path, self.bin = folder / "level.gltf", folder / "level.bin"
        self.candela = dict.fromkeys(LAMPS, 10.0)
        self.save_walls(0)
        self.save()

    def save_walls(self, wall_x):
        positions, triangles = boxes(wall_x)
        self.positions, self.triangles = positions, triangles
        replace(self.bin, struct.pack(f"<{3 * len(positions)}f", *sum(positions, ())) + struct.pack(f"<{3 * len(triangles)}I", *sum(triangles, [])))

    def text(self):
        count, corners, walls = len(self.positions), 3 * len(self.triangles), 36
        return json.dumps({
            "asset": {"version": "2.0"}, "scene": 0, "extensionsUsed": ["KHR_lights_punctual"],
            "scenes": [{"nodes": list(range(1 + len(LAMPS)))}],
            "nodes": [{"mesh": 0}] + [{"name": name, "translation": place, "extensions": {"KHR_lights_punctual": {"light": i}}} for i, (name, place) in enumerate(LAMPS.items())],
            "extensions": {"KHR_lights_punctual": {"lights": [{"name": name, "type": "point", "color": COLOURS[name], "intensity": self.candela[name]} for name in LAMPS]}},
            "materials": [{"name": "plaster"}, {"name": "screen", "emissiveFactor": [0, .1, 0]}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1 + i, "material": i} for i in range(2)]}],
            "buffers": [{"uri": "level.bin", "byteLength": 12 * count + 4 * corners}],
            "bufferViews": [{"buffer": 0, "byteLength": 12 * count}, {"buffer": 0, "byteOffset": 12 * count, "byteLength": 4 * corners}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3", "min": [-3, 0, -2], "max": [3, 3, 2]},
                          *({"bufferView": 1, "componentType": 5125, "byteOffset": 4 * first, "count": corner_count, "type": "SCALAR"}
                            for first, corner_count in ((0, walls), (walls, corners - walls)))]})

    def save(self):
        replace(self.path, self.text().encode())


def replace(path, content):
    """As programs save that lose nothing: the new file takes the place of the old one."""
    other = path.with_name(path.name + "~")
    other.write_bytes(content)
    other.rename(path)


def is_running(process):
    """Whether it is there, and no zombie that nobody has asked after."""
    try:
        return Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


class Watch:
    def __init__(self, folder, settings):
        self.folder = folder
        with open(folder / "log", "w", encoding="utf-8") as log:
            self.process = subprocess.Popen([BUILD / "bin/nlg-view", "level.gltf", "--watch", "--port", "0", *settings], cwd=folder, stderr=log, stdout=subprocess.DEVNULL)
        self.port = int(self.waited(lambda: re.search(r"open http://127\.0\.0\.1:(\d+)/\n", self.said()), "its address")[1])

    def said(self):
        return (self.folder / "log").read_text(encoding="utf-8")

    def waited(self, of, what):
        end = time.monotonic() + 4 * SECONDS
        while time.monotonic() < end:
            if found := of():
                return found
            if self.process.poll() is not None:
                raise AssertionError(f"ended with {self.process.returncode} before {what}: {self.said()}")
            time.sleep(.02)
        raise AssertionError(f"no {what} in {4 * SECONDS} s: {self.said()}")

    def get(self, path, host=None):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=SECONDS)
        connection.request("GET", path, headers={"Host": host} if host else {})
        answer = connection.getresponse()
        content = answer.read()
        connection.close()
        return answer, content

    def state(self):
        return json.loads(self.get("/state")[1])

    def final_after(self, shown):
        """The state with a final grid that is none of those up to `shown`."""
        return self.waited(lambda: (state := self.state())["shown"] > shown and state["text"].startswith("final") and state, "final grid")

    def end(self, by=signal.SIGINT):
        self.process.send_signal(by)
        code = self.process.wait(SECONDS)
        return code


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.level = Level(self.folder)
        self.grid = self.folder / "level/grid.safetensors"

    def watch(self, settings=SETTINGS):
        watch = Watch(self.folder, settings)
        self.addCleanup(lambda: watch.process and watch.process.poll() is None and watch.end(signal.SIGKILL))
        return watch

    def assert_as_baked_by_hand(self):
        done = subprocess.run([BUILD / "bin/nlg-bake", "level.gltf", *SETTINGS, "--out", "by_hand.safetensors"], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.grid.read_bytes(), (self.folder / "by_hand.safetensors").read_bytes(), "the grid is not what nlg-bake makes of the scene")

    def assert_nothing_half_written(self):
        self.assertEqual([path.name for path in self.folder.rglob("*.tmp.*")], [])
        for grid in self.folder.rglob("*.safetensors"):
            self.assertEqual(subprocess.run([BUILD / "bin/nlg-bake", "info", grid], capture_output=True).returncode, 0, grid)


class Served(Case):
    def test_bakes_what_is_saved_and_serves_it(self):
        watch = self.watch()
        first = watch.final_after(0)
        self.assert_as_baked_by_hand()
        script, scene = (watch.get(f"/{name}.js?{first['shown']}")[1] for name in ("method-grid", "scene"))
        self.assertTrue(script.startswith(b'nlgReceive("method-grid", {'), script[:40])
        # a lamp: functions stay
        self.level.candela["warm"] = 100.0
        self.level.save()
        lit = watch.final_after(first["shown"])
        self.assertIn("functions as in level/watch/preview.safetensors", watch.said())
        self.assertNotEqual(watch.get(f"/method-grid.js?{lit['shown']}")[1], script)
        self.assertEqual(watch.get(f"/method-grid.js?{first['shown']}")[0].status, 404, "numbers of before are gone")
        self.assert_as_baked_by_hand()
        # a file that the scene's file names
        self.level.save_walls(1)
        moved = watch.final_after(lit["shown"])
        self.assertNotEqual(watch.get(f"/scene.js?{moved['shown']}")[1], scene)
        self.assert_as_baked_by_hand()
        # what is no scene, and one whose buffer is gone; each is said, and what was shown stays
        for break_it in (lambda: replace(self.level.path, b"{"), self.level.bin.unlink):
            break_it()
            failed = watch.waited(lambda: (state := watch.state())["failed"] and state["text"].endswith("next save") and state, "error")
            self.assertRegex(failed["text"], "^nlg-bake: error: level.gltf: ")
            self.assertEqual(failed["shown"], moved["shown"])
            self.assertEqual(watch.get(f"/scene.js?{moved['shown']}")[0].status, 200)
            self.level.save_walls(1)
            self.level.save()
            moved = watch.final_after(moved["shown"])
            self.assertFalse(moved["failed"])
        self.assert_as_baked_by_hand()
        self.assertEqual(watch.end(), 0)
        self.assert_nothing_half_written()
        self.assertTrue((self.folder / "level/index.html").is_file())

    def test_answers_to_this_machine_alone(self):
        watch = self.watch()
        page, text = watch.get("/")
        self.assertIn(b"<html data-served", text)
        self.assertEqual(page.getheader("Cross-Origin-Resource-Policy"), "same-origin")
        self.assertEqual(page.getheader("Content-Security-Policy"), "frame-ancestors 'none'")
        self.assertEqual(watch.get("/state", f"localhost:{watch.port}")[0].status, 200)
        for host in (f"elsewhere.example:{watch.port}", "127.0.0.1", f"127.0.0.1.elsewhere.example:{watch.port}", ""):
            for path in ("/", "/state", "/viewer.js", "/no"):
                answer, content = watch.get(path, host or " ")
                self.assertEqual((answer.status, b"nlg" in content), (403, False), (host, path))
        for path in ("/level.gltf", "/../level.gltf", "/%2e%2e/level.gltf", "/grid.safetensors", "/scene.js"):
            self.assertEqual(watch.get(path)[0].status, 404, path)
        # whole of 127/8 is this machine; an address of the network's would be refused as this one is
        with self.assertRaises(ConnectionRefusedError):
            socket.create_connection(("127.0.0.2", watch.port), SECONDS)

    def test_no_client_holds_the_page_or_its_end(self):
        watch = self.watch()
        watch.final_after(0)
        # clients that say nothing, or a byte now and then
        clients = [socket.create_connection(("127.0.0.1", watch.port), SECONDS) for _ in range(30)]
        for client in clients[:15]:
            client.sendall(b"GET / HT")
        self.assertEqual(watch.get("/state")[0].status, 200)
        clients += [socket.create_connection(("127.0.0.1", watch.port), SECONDS) for _ in range(16)]
        self.assertEqual(watch.end(), 0)
        for client in clients:
            client.close()

    def test_what_it_started_ends_with_it(self):
        watch = self.watch(["--light-rays", "1048576", "--light-samples", "4096"])
        watch.waited(lambda: "baking: final" in watch.state()["text"], "preview")
        bake = self.child_of(watch)
        watch.end(signal.SIGKILL)
        watch.process = None
        end = time.monotonic() + SECONDS
        while is_running(bake) and time.monotonic() < end:
            time.sleep(.02)
        self.assertFalse(is_running(bake), "a bake outlives its watch")

    def test_begins_anew_when_it_is_saved_meanwhile_and_ends_at_any_moment(self):
        # a bake that would take hours
        watch = self.watch(["--light-rays", "1048576", "--light-samples", "4096"])
        waiting = "baking: final"
        watch.waited(lambda: waiting in watch.state()["text"], "preview")
        bake = self.child_of(watch)
        shown = watch.state()["shown"]
        self.level.candela["warm"] = 100.0
        self.level.save()
        watch.waited(lambda: (state := watch.state())["shown"] > shown and waiting in state["text"], "preview of what was saved")
        self.assertFalse(os.path.exists(f"/proc/{bake}"), "the bake of before goes on")
        bake = self.child_of(watch)
        self.assertEqual(watch.end(signal.SIGTERM), 0)
        self.assertFalse(os.path.exists(f"/proc/{bake}"), "a bake outlives its watch")
        self.assertFalse(self.grid.exists())
        self.assert_nothing_half_written()

    def child_of(self, watch):
        return int(watch.waited(Path(f"/proc/{watch.process.pid}/task/{watch.process.pid}/children").read_text, "child").split()[0])


class Page(Case):
    def test_shows_what_is_saved_without_being_opened_again(self):
        out = Path(sys.argv[2])
        out.mkdir(parents=True, exist_ok=True)
        watch = self.watch()
        url = f"http://127.0.0.1:{watch.port}/"
        browser = Browser(find_browser(), str(self.folder / "profile"), ["--enable-unsafe-swiftshader"])
        self.addCleanup(browser.close)
        browser.call("Emulation.setDeviceMetricsOverride", width=SIZE[0], height=SIZE[1], deviceScaleFactor=1, mobile=False)
        # before there is any grid; a name with a comma. A slow page asks for scripts when others have taken their place: it waits for those
        browser.call("Network.setBlockedURLs", urls=["*method-grid.js*"])
        browser.open(url + "?light=cold,%20blue:0.5&divider=1")
        value = browser.value
        watch.waited(lambda: value("document.getElementById('message').textContent").startswith("method-grid.js is not beside"), "scripts that are gone")
        browser.call("Network.setBlockedURLs", urls=[])
        shown = watch.final_after(0)["shown"]
        self.level.save()
        state = lambda: value("document.getElementById('status').textContent")
        shows = lambda shown: watch.waited(lambda: value("document.documentElement.dataset.shown") == str(shown) and state().startswith("final"), f"page of {shown}; it says {state()}")
        shown = watch.final_after(shown)["shown"]
        shows(shown)
        browser.events.clear()

        def picture(name):
            value("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
            browser.picture(str(out / f"watch_{name}.png"), *SIZE)
            return value(MEAN_OF_CANVAS)

        sliders = "JSON.stringify([...document.querySelectorAll('#groups label')].map(row => [row.textContent.trim(), ...[...row.querySelectorAll('input')].map(input => input.value)]))"
        # sliders dim and colour what they name
        slide = lambda name, kind, to: value(f"""(() => {{ const row = [...document.querySelectorAll('#groups label')].find(row => row.textContent.trim() === '{name}');
          const input = row.querySelector('[type={kind}]'); input.value = '{to}'; input.dispatchEvent(new Event('input')); }})()""")
        both = picture("both")
        slide("warm", "range", 0)
        slide("screen", "range", 0)
        cold = picture("cold")
        slide("cold, blue", "color", "#ff0000")
        red = picture("red")
        slide("cold, blue", "range", 0)
        dark = picture("dark")
        self.assertEqual(dark, [0, 0, 0])
        self.assertTrue(all(b > c for b, c in zip(both, cold)), (both, cold))
        self.assertGreater(cold[2], cold[0])
        self.assertEqual(red[1:], [0, 0])
        self.assertGreater(red[0], 0)
        slide("screen", "range", 1)
        slide("cold, blue", "range", 0.5)
        slide("warm", "range", 1)
        # a ball is carried; it stays, and so do sliders
        value("document.getElementById('ball').click()")
        value("window.marked = true")
        before, chosen = picture("before"), value(sliders)
        self.level.candela["warm"] = 100.0
        self.level.save()
        shows(watch.final_after(shown)["shown"])
        self.assertEqual(value("window.marked"), True, "the page was loaded anew")
        self.assertEqual(value(sliders), chosen)
        self.assertTrue(value("document.getElementById('ball').checked"))
        after = picture("after")
        self.assertGreater(after[0], 1.2 * before[0])

# of its pixels, by channel
MEAN_OF_CANVAS = """(() => { const canvas = document.getElementById('canvas'), copy = document.createElement('canvas'); copy.width = canvas.width; copy.height = canvas.height;
  const paint = copy.getContext('2d'); document.getElementById('exposure').dispatchEvent(new Event('input'));
  return new Promise(done => requestAnimationFrame(() => { paint.drawImage(canvas, 0, 0); const data = paint.getImageData(0, 0, copy.width, copy.height).data, sum = [0, 0, 0];
    for (let i = 0; i < data.length; ++i) if (i % 4 < 3) sum[i % 4] += data[i]; done(sum.map(one => 4 * one / data.length)); })); })()"""

if __name__ == "__main__":
    if KIND == "page" and not find_browser():
        print(f"skipped: none of {', '.join(BROWSERS)} is installed")
        sys.exit(SKIPPED)
    unittest.main(argv=sys.argv[:1], defaultTest=KIND.capitalize())
