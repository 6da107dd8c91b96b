"""Modelling in Blender 3.4 from a script: boxes, sheets, images, materials. Read by scenes.py, inside Blender.

A material is made twice from one Look: of Principled nodes, as an artist has them and the exporter reads them, and of diffuse, transparent and
emission nodes, for Cycles. Blender's Principled BSDF is not Lambert's, whatever its settings, and Cycles refracts where glTF's thin
transmission goes straight through.
"""
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np


@dataclass
class Look:
    colour: tuple = (0.8, 0.8, 0.8)  # linear; an image takes its place
    image: object = None             # of bpy.data.images
    alpha: float = 1.0               # an image's alpha takes its place when is_cut
    is_cut: bool = False             # alphaMode MASK by the image's alpha
    transmission: float = 0.0
    emission: tuple = (0.0, 0.0, 0.0)
    emission_image: object = None
    strength: float = 1.0
    mapping: tuple = None            # scale, turn (radians) and shift of a Mapping node before the image

    @property
    def blend_method(self):
        return "CLIP" if self.is_cut else "BLEND" if self.alpha < 1.0 else "OPAQUE"


def picture(name, pixels, folder, form="PNG"):
    """An image of a file that is written here. pixels: rows from the top, sRGB in [0, 1], three channels or four."""
    height, width, channels = pixels.shape
    image = bpy.data.images.new(name, width, height, alpha=channels == 4)
    whole = np.ones((height, width, 4), np.float32)
    whole[..., :channels] = pixels[::-1]
    image.pixels.foreach_set(whole.ravel())
    path = Path(folder) / f"{name}.{'png' if form == 'PNG' else 'jpg'}"
    image.file_format = form
    image.filepath_raw = str(path)
    image.save()
    bpy.data.images.remove(image)
    return bpy.data.images.load(str(path))


def image_node(material, image, look):
    nodes, links = material.node_tree.nodes, material.node_tree.links
    node = nodes.new("ShaderNodeTexImage")
    node.image = image
    if look.mapping is not None:
        scale, turn, shift = look.mapping
        mapping, place = nodes.new("ShaderNodeMapping"), nodes.new("ShaderNodeTexCoord")
        mapping.inputs["Scale"].default_value = (scale, scale, 1)
        mapping.inputs["Rotation"].default_value = (0, 0, turn)
        mapping.inputs["Location"].default_value = (*shift, 0)
        links.new(place.outputs["UV"], mapping.inputs["Vector"])
        links.new(mapping.outputs["Vector"], node.inputs["Vector"])
    return node


def principled(material, look):
    """As an artist sets it up, and as the exporter reads it."""
    material.use_nodes = True
    links = material.node_tree.links
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Specular"].default_value = 0.0
    shader.inputs["Roughness"].default_value = 1.0
    shader.inputs["Base Color"].default_value = (*look.colour, 1)
    shader.inputs["Alpha"].default_value = look.alpha
    shader.inputs["Transmission"].default_value = look.transmission
    shader.inputs["Emission"].default_value = (*look.emission, 1)
    shader.inputs["Emission Strength"].default_value = look.strength
    material.blend_method = look.blend_method
    if look.image is not None:
        node = image_node(material, look.image, look)
        links.new(node.outputs["Color"], shader.inputs["Base Color"])
        if look.is_cut:
            links.new(node.outputs["Alpha"], shader.inputs["Alpha"])
    if look.emission_image is not None:
        links.new(image_node(material, look.emission_image, look).outputs["Color"], shader.inputs["Emission"])


def lambert(material, look):
    """The same for Cycles: a diffuse surface of which alpha and transmission let light pass straight on."""
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    base = image_node(material, look.image, look) if look.image is not None else None

    def coloured(kind):
        shader = nodes.new(kind)
        shader.inputs["Color"].default_value = (*look.colour, 1)
        if base is not None:
            links.new(base.outputs["Color"], shader.inputs["Color"])
        return shader.outputs[0]

    def mixed(share, below, above):
        """share: a number, or a node's output."""
        mix = nodes.new("ShaderNodeMixShader")
        links.new(below, mix.inputs[1])
        links.new(above, mix.inputs[2])
        if isinstance(share, float):
            mix.inputs[0].default_value = share
        else:
            links.new(share, mix.inputs[0])
        return mix.outputs[0]

    surface = coloured("ShaderNodeBsdfDiffuse")
    if look.transmission > 0.0:
        surface = mixed(look.transmission, surface, coloured("ShaderNodeBsdfTransparent"))
    if look.blend_method != "OPAQUE":
        surface = mixed(base.outputs["Alpha"] if look.is_cut else look.alpha, nodes.new("ShaderNodeBsdfTransparent").outputs[0], surface)
    if look.emission_image is not None or any(look.emission):
        emission, both = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeAddShader")
        emission.inputs["Color"].default_value = (*look.emission, 1)
        emission.inputs["Strength"].default_value = look.strength
        if look.emission_image is not None:
            links.new(image_node(material, look.emission_image, look).outputs["Color"], emission.inputs["Color"])
        links.new(surface, both.inputs[0])
        links.new(emission.outputs[0], both.inputs[1])
        surface = both.outputs[0]
    links.new(surface, nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])


class Model:
    """Objects and their materials, in an empty Blender scene. Metres, z up."""

    def __init__(self):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.looks = {}  # material → Look

    def material(self, name, look):
        material = bpy.data.materials.new(name)
        principled(material, look)
        self.looks[material] = look
        return material

    def mesh(self, name, corners, faces, places, material):
        """faces: indices of corners; places: of every corner of every face, on the image."""
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata(corners, [], faces)
        layer = mesh.uv_layers.new()
        layer.data.foreach_set("uv", np.asarray(places, np.float32).ravel())
        mesh.materials.append(material)
        mesh.update()
        thing = bpy.data.objects.new(name, mesh)
        bpy.context.collection.objects.link(thing)
        return thing

    def box(self, name, low, high, material, metres=1.0):
        """A closed box; an image covers so many metres of it."""
        low, high = np.asarray(low, float), np.asarray(high, float)
        corners = [[(low, high)[c >> axis & 1][axis] for axis in range(3)] for c in range(8)]
        faces, places = [], []
        for axis in range(3):
            u, v = ((1, 2), (0, 2), (0, 1))[axis]
            for side in (0, 1):
                ring = [sum(bit << a for bit, a in ((side, axis), (du, u), (dv, v))) for du, dv in ((0, 0), (1, 0), (1, 1), (0, 1))]
                # the cross product of u and v is -y in the middle case
                if (side == 1) == (axis == 1):
                    ring.reverse()
                faces.append(ring)
                places += [(corners[c][u] / metres, corners[c][v] / metres) for c in ring]
        return self.mesh(name, corners, faces, places, material)

    def sheet(self, name, corner, right, up, material, repeats=(1.0, 1.0)):
        """A parallelogram; its front is where right goes to the right and up goes up."""
        corner, right, up = (np.asarray(v, float) for v in (corner, right, up))
        corners = [corner, corner + right, corner + right + up, corner + up]
        u, v = repeats
        return self.mesh(name, corners, [[0, 1, 2, 3]], [(0, 0), (u, 0), (u, v), (0, v)], material)

    def for_cycles(self):
        """From here on materials are Cycles'. What is exported is exported before."""
        for material, look in self.looks.items():
            lambert(material, look)
            # 3.4 draws points on shining images wrong: means are off by 1 %, single places by several
            material.cycles.sample_as_light = False
