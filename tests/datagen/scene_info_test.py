#!/usr/bin/env python3
"""nlg-datagen info SCENE. scene_info_test.py FOLDER_OF_TOOLS"""
import base64
import json
import os
import struct
import subprocess
import sys
import tempfile
import unittest

TOOL = os.path.join(os.path.abspath(sys.argv.pop(1)), "nlg-datagen")
# a square of 4 m² that lets half of the light through, one of 1 m² beside it, a lamp, and an animation
CORNERS = struct.pack("<12f", 0, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0)
FILE = {
    "asset": {"version": "2.0"}, "scenes": [{"nodes": [0, 1, 2]}],
    "nodes": [{"mesh": 0}, {"mesh": 1, "translation": [3, 0, 0], "scale": [.5, .5, 1]}, {"extensions": {"KHR_lights_punctual": {"light": 0}}}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 6, "material": material}]} for material in (0, 1)],
    "materials": [{"name": "pane", "alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, .25]}},
                  {"emissiveFactor": [1, 0, 0], "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
    "textures": [{"source": 0}], "images": [{"uri": "missing.png"}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}], "bufferViews": [{"buffer": 0, "byteLength": 48}],
    "buffers": [{"byteLength": 48, "uri": "data:application/octet-stream;base64," + base64.b64encode(CORNERS).decode()}],
    "extensionsUsed": ["KHR_lights_punctual"], "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 100}]}},
    "animations": [{"channels": [], "samplers": []}]}


class SceneInfo(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        with open(os.path.join(self.folder.name, "room.gltf"), "w") as file:
            json.dump(FILE, file)

    def tearDown(self):
        self.folder.cleanup()

    def info(self, *arguments):
        result = subprocess.run([TOOL, "info", *arguments], cwd=self.folder.name, capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout

    def test_json_has_what_the_file_holds(self):
        scene = json.loads(self.info("--json", "room.gltf"))
        expected = {"scene": "room.gltf", "triangles": 4, "objects": 2, "size_m": [4, 2, 0], "materials": 2, "materials_with_image": 0, "images": 0, "lamps": 1,
                    "lamps_cd": [100, 100], "suns_lux": [], "materials_that_shine": 1, "shine_cd_per_m2": [1, 1], "sky": False}
        self.assertEqual({key: scene[key] for key in expected}, expected)
        self.assertEqual(scene["surfaces"], {"solid": .2, "sheets": 0, "dense_transmissive": 0, "thin_transmissive": .8})
        self.assertEqual(sum("missing.png" in note for note in scene["notes"]), 1)
        self.assertEqual(sum("pane (thin, stops 25 %)" in note for note in scene["notes"]), 1)
        self.assertEqual(sum("1 animation" in note for note in scene["notes"]), 1)

    def test_lamps_of_an_exporter_that_nobody_knows_are_named(self):
        for generator in ("Maya 2024", "Unity glTFast 6", "THREE.GLTFExporter r140"):
            with open(os.path.join(self.folder.name, "stranger.gltf"), "w") as file:
                json.dump({**FILE, "asset": {"version": "2.0", "generator": generator}}, file)
            notes = json.loads(self.info("--json", "stranger.gltf"))["notes"]
            self.assertEqual(sum("as glTF's cd and lux" in note and "--light-unit" in note for note in notes), 1, notes)

    def test_options_are_those_of_reading(self):
        scene = json.loads(self.info("--json", "--unit", "0.5", "--transmissive-cover", "0.2", "room.gltf"))
        self.assertEqual(scene["size_m"], [2, 1, 0])
        self.assertEqual(scene["surfaces"]["dense_transmissive"], .8)

    def test_scenes_without_a_file(self):
        self.assertEqual(json.loads(self.info("--json", "cornell"))["triangles"], 128)


if __name__ == "__main__":
    unittest.main()
