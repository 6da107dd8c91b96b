"""docs/reference/cycles.md: our path tracer against Blender's Cycles. Written by results.py from docs/results/cycles.json."""
from results_collect import fail, read_json, rounded, take
from results_page import table
from results_quotes import number

NAME = "cycles"
SCENES = {
    "images": "walls, floor and ceiling are images (PNG, JPEG), one behind a Mapping node; sky",
    "mask": "a fence, `alphaMode` MASK, before the window; a sun, and sky",
    "blend": "a pane in the window, `alphaMode` BLEND, alpha .15; a point lamp, and sky",
    "emission": "a screen on the wall shines by an image; no window",
    "transmission": "tinted glass in the window, transmission .8; sky",
    "sum": "all of them, in two windows; sun, lamp and sky",
}
CHANNELS = ("red", "green", "blue")
LOW, HIGH = 0.98, 1.02
INTRODUCTION = """# Light against Cycles

*Written by `workflow/results.py write` from `docs/results/cycles.json`. Change nothing here by hand.*

Our path tracer against [Cycles](https://www.cycles-renderer.org/) of Blender 3.4. Blender models a room and exports it as glTF, with the exporter's defaults and Punctual Lights ticked. Cycles bakes the irradiance at sample points in the room, `nlg-render irradiance` traces it from the exported file, and the means over the points are compared.

```sh
apt-get install --no-install-recommends blender python3-numpy     # Debian's, 3.4; no package of the project
workflow/cycles/compare.py                                        # a table of ratios; some minutes
workflow/results.py collect-cycles out/cycles                     # this page
```

A room is 4 × 3 × 2.6 m, of closed boxes, with a crate in it. Two thirds of the sample points are in its air, with any normal; one third 2 cm before a surface, with its normal. Cycles bakes on squares of 2 mm that no ray meets and that are not exported.
"""
SETTINGS = """
## What makes both comparable
- **Materials** are exported as Principled BSDF. For Cycles they are replaced by diffuse, transparent and emission nodes with the same images: Principled is not Lambertian at any roughness, and Cycles refracts where glTF's transmission does not.
- **Cycles**: filter glossy, clamping, the light threshold, adaptive sampling and denoising are off; 64 bounces of every kind.
- **Emissive meshes** are met by paths alone (`sample_as_light` off): light sampling of 3.4 is biased by 1 % in the mean against a closed form.
- **Images** are large: between texels Cycles averages sRGB codes, glTF linear light.
- **White**: no surface reflects more than .9, to which nlg clamps (`light/light_transport.cpp`).
- **Lamps and suns** come with the file, 683 times as bright as its emission, the exporter's default: nlg recognises it ([units](../theory/light.md#units)). The world is not exported; `--sky` gives its sky.
- **Alpha**: `alphaMode` MASK cuts at a half, so that the fence's image has only 0 and 1.
"""


def cell(channel):
    return f"{number(channel['ratio'], 3)} ± {number(channel['error'], 3)}"


def row(name, found):
    channels = [found["channels"][name] for name in CHANNELS]
    worst = max(channels, key=lambda channel: channel["difference"])
    return [f"`{name}`: {SCENES[name]}", *map(cell, channels), f"{number(worst['difference'], 3)} ({number(worst['noise'], 3)})"]


def page(all_results):
    results = all_results[NAME]
    scenes = results["scenes"]
    ratios = [found["channels"][channel]["ratio"] for found in scenes.values() for channel in CHANNELS]
    inside = sum(LOW <= ratio <= HIGH for ratio in ratios)
    first = next(iter(scenes.values()))
    text = INTRODUCTION + f"\nOf revision `{results['revision']}` and Blender {results['blender']}: {first['places']:,} sample points; {first['runs']} bakes of {first['samples']:,} samples; {first['runs']} runs of {first['rays']:,} rays.\n"
    text += f"\n## Irradiance over Cycles'\nRatios of the means, with their standard errors. {inside} of {len(ratios)} lie from {number(LOW, 2)} to {number(HIGH, 2)}. *Points differ*: root mean square of the difference at a point over that of Cycles, in the channel where it is largest; in parentheses the share of both sides' noise in it.\n"
    return text + table(["scene", *CHANNELS, "points differ"], [row(name, scenes[name]) for name in SCENES]) + SETTINGS


def collect(folder):
    """What workflow/cycles/compare.py wrote of all scenes."""
    found = {name: read_json(folder / f"{name}.result.json") for name in SCENES}
    keys = ("revision", "blender", "places", "runs", "samples", "rays", "channels")
    scenes = {name: take(result, keys, folder / f"{name}.result.json") for name, result in found.items()}
    same = {}
    for key in ("revision", "blender"):
        values = sorted({scene.pop(key) for scene in scenes.values()})
        if len(values) != 1:
            fail(folder, f"one {key} in all results", ", ".join(values))
        same[key] = values[0]
    return rounded({"schema_version": 1, "run": NAME, **same, "scenes": scenes})
