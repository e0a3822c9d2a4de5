#!/usr/bin/env python3
"""Converts four models and writes the tables of docs/storage.md between their marks (Python's standard library alone).

  docs/storage.py MESHCOLOR ASSETS [LAYOUT_TIME PYTHON]

MESHCOLOR is the program, ASSETS the folder of the models. With LAYOUT_TIME, the built example of meshcolor-core of
that name, and a PYTHON that has xatlas and numpy, the time of a layout is taken too. docs/storage.sh does it all.
"""

import json
import pathlib
import re
import struct
import subprocess
import sys
import tempfile

from figures import share, table

PAGE = pathlib.Path(__file__).parent / "storage.md"
MODELS = {
    "DamagedHelmet": "DamagedHelmet.glb",
    "Fox": "Fox.glb",
    "spot": "spot/spot_control_mesh.obj",
    "spot, finer": "spot/spot_fine.obj",
}
HELMET_RUNS = [
    ["--coordinates", "4d-rows"],
    ["--coordinates", "4d"],
    [],
    ["--texels", "3200000", "--sampling", "fitted"],
    ["--texels", "1600000", "--sampling", "fitted"],
]
SMALL_RUNS = [[], ["--texels", "300000", "--sampling", "fitted"], ["--max-error", "2"]]
KINDS = [("4D", ["--coordinates", "4d"]), ("indexed", ["--coordinates", "indexed"])]
FIXED = ["3", "4"]
MIB = 1 << 20


class Run:
    """One conversion: its report, and the bytes of the images in its file."""

    def __init__(self, program, model, options):
        with tempfile.TemporaryDirectory() as scratch:
            out = pathlib.Path(scratch) / "out"
            command = [program, "convert", model, "--no-preview", "--quiet", *options, "-o", out]
            subprocess.run(list(map(str, command)), check=True)
            self.report = json.loads((out / "report.json").read_text())
            self.png_bytes = image_bytes((out / "asset.glb").read_bytes())

    def levels(self):
        return [level for layout in self.report["layouts"] for level in layout["levels"]]

    def texels(self):
        """Of level 0 and of all levels, one map."""
        levels = self.levels()
        own = [level["allocated_texels"] for level in levels]
        return sum(n for n, level in zip(own, levels) if level["level"] == 0), sum(own)

    def share(self, name, first_only):
        """A share of the allocated texels (`waste`, `efficiency`), at level 0 or over all levels."""
        levels = [level for level in self.levels() if level["level"] == 0 or not first_only]
        texels = sum(level["allocated_texels"] for level in levels)
        return sum(level[name] * level["allocated_texels"] for level in levels) / texels

    def raw_bytes(self):
        """Of all levels of all maps as they are stored."""
        total = 0
        for channel in self.report["channels"]:
            for level in channel["levels"]:
                bits = 16 if level.get("range") else channel["bits"]
                total += level["size"][0] * level["size"][1] * channel["components"] * bits // 8
        return total

    def source_texels(self):
        """Level 0, all maps, and the bytes of these."""
        maps = [(channel, channel["levels"][0]["source"]["size"]) for channel in self.report["channels"]]
        texels = [size[0] * size[1] for _, size in maps]
        return sum(texels), sum(n * channel["components"] for n, (channel, _) in zip(texels, maps))

    def psnr(self, slot):
        channel = next(channel for channel in self.report["channels"] if slot in channel["slots"])
        own = channel["fidelity"]
        return f"{own['psnr_db']:.1f} ({own['yardstick_psnr_db']:.1f})"


def image_bytes(glb):
    """Of all images inside a GLB."""
    length, = struct.unpack_from("<I", glb, 12)
    document = json.loads(glb[20:20 + length])
    views = document.get("bufferViews", [])
    return sum(views[image["bufferView"]]["byteLength"] for image in document.get("images", []))


def source_bytes(path):
    """Of the source's image files."""
    if path.suffix == ".glb":
        return image_bytes(path.read_bytes())
    materials = [path.parent / name for name in re.findall(r"^mtllib (.+)$", path.read_text(), re.M)]
    names = {name for mtl in materials for name in re.findall(r"^\s*map_Kd (\S+)", mtl.read_text(), re.M)}
    return sum((path.parent / name).stat().st_size for name in names)


def short(texels):
    return f"{texels / 1e6:.2f} M" if texels >= 1e6 else f"{texels / 1e3:.0f} k"


def mib(size):
    return f"{size / MIB:.2f}"


def named(options):
    return f"`{' '.join(options)}`" if options else "none"


def helmet(convert):
    slots = ["baseColor", "metallicRoughness", "normal", "occlusion", "emissive"]
    rows = []
    for options in HELMET_RUNS:
        run = convert("DamagedHelmet", options)
        rows.append([named(options), *map(short, run.texels()), *[run.psnr(slot + "Texture") for slot in slots]])
    return table(["options", "texels, level 0", "all levels", "base color", "metallic-roughness", "normal",
                  "occlusion", "emissive"], rows)


def small(convert):
    rows = []
    for model in list(MODELS)[1:]:
        for options in SMALL_RUNS:
            run = convert(model, options)
            rows.append([f"{model}, {named(options)}", *map(short, run.texels()), run.psnr("baseColorTexture")])
    return table(["model, options", "texels, level 0", "all levels", "base color"], rows)


def levels(convert, assets):
    heading = ["model, stored as", "texels, level 0", "all levels", "times source", "raw, MiB", "files, MiB",
               "waste, level 0", "all levels", "efficiency, level 0"]
    rows = []
    for model, path in MODELS.items():
        runs = [(name, convert(model, options)) for name, options in KINDS]
        texels, raw = runs[0][1].source_texels()
        maps = len(runs[0][1].report["channels"])
        rows.append([f"{model}, source and mips", short(texels / maps), short(texels / maps * 4 / 3), "1.00",
                     mib(raw * 4 / 3), mib(source_bytes(assets / path)), "", "", ""])
        for name, run in runs:
            own, own_all = run.texels()
            rows.append([f"{model}, {name}", short(own), short(own_all), f"{own_all * maps / (texels * 4 / 3):.2f}",
                         mib(run.raw_bytes()), mib(run.png_bytes), share(run.share("waste", True)),
                         share(run.share("waste", False)), share(run.share("efficiency", True))])
    return table(heading, rows)


def fixed(convert):
    heading = ["model, coordinates"]
    for exponent in FIXED:
        heading += [f"exponent {exponent}: texels", "waste", "all levels", "efficiency", "all levels"]
    rows = []
    for model in MODELS:
        for name, options in KINDS:
            row = [f"{model}, {name}"]
            for exponent in FIXED:
                run = convert(model, [*options, "--resolution", f"fixed:{exponent}"])
                row.append(short(run.texels()[0]))
                row += [share(run.share(figure, first)) for figure in ("waste", "efficiency") for first in (True, False)]
            rows.append(row)
    return table(heading, rows)


def layout(example, python):
    script = pathlib.Path(__file__).parent / "layout_time.py"
    return subprocess.run([python, script, example], check=True, capture_output=True, text=True).stdout


def write(mark, text):
    page = PAGE.read_text()
    start, end = f"<!-- {mark} -->\n", f"<!-- end {mark} -->"
    head, rest = page.split(start)
    PAGE.write_text(f"{head}{start}\n{text.strip()}\n\n{end}{rest.split(end)[1]}")
    print(text)


def main(arguments):
    if len(arguments) not in (2, 4):
        sys.exit(__doc__)
    program, assets = arguments[0], pathlib.Path(arguments[1])
    runs = {}

    def convert(model, options):
        key = (model, *options)
        if key not in runs:
            runs[key] = Run(program, assets / MODELS[model], options)
        return runs[key]

    write("helmet", helmet(convert))
    write("small", small(convert))
    write("levels", levels(convert, assets))
    write("fixed", fixed(convert))
    if len(arguments) == 4:
        write("layout", layout(*arguments[2:]))


if __name__ == "__main__":
    main(sys.argv[1:])
