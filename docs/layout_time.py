#!/usr/bin/env python3
"""Takes the time of a layout beside xatlas' on the same mesh, in CPU seconds, and prints it as a table.

  docs/layout_time.py LAYOUT_TIME [FACES]

LAYOUT_TIME is the built example of meshcolor-core (cargo build --release -p meshcolor-core --example layout_time). This
Python needs the packages xatlas and numpy (pip install xatlas==0.0.11 numpy); xatlas runs with its own settings.
"""

import json
import pathlib
import resource
import subprocess
import sys
import tempfile

import numpy
import xatlas

from figures import count, table


def cpu_seconds():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def mesh(path):
    """Positions and triangles of an OBJ."""
    lines = [line.split() for line in path.read_text().splitlines()]
    positions = [list(map(float, words[1:4])) for words in lines if words[0] == "v"]
    faces = [[int(corner.split("/")[0]) - 1 for corner in words[1:]] for words in lines if words[0] == "f"]
    return numpy.array(positions, dtype=numpy.float32), numpy.array(faces, dtype=numpy.uint32)


def main(arguments):
    if not arguments:
        sys.exit(__doc__)
    faces = arguments[1] if len(arguments) > 1 else "100000"
    with tempfile.TemporaryDirectory() as scratch:
        path = pathlib.Path(scratch) / "mesh.obj"
        command = [arguments[0], faces, path]
        ours = json.loads(subprocess.run(list(map(str, command)), check=True, capture_output=True, text=True).stdout)
        positions, triangles = mesh(path)
    atlas = xatlas.Atlas()
    atlas.add_mesh(positions, triangles)
    before = cpu_seconds()
    atlas.generate()
    theirs = cpu_seconds() - before
    before_layout = ours["weld_seconds"] + ours["pair_seconds"] + ours["merge_seconds"]
    steps = [
        ("xatlas 0.0.11: charts and packing", theirs),
        ("layout, indexed", ours["indexed_seconds"]),
        ("layout, 4D", ours["scaled_seconds"]),
        ("pairs: the matching alone", ours["pair_seconds"]),
        ("welding, pairs, quads and layout, indexed", before_layout + ours["indexed_seconds"]),
        ("the same, 4D", before_layout + ours["scaled_seconds"]),
    ]
    told = f"{count(ours['faces'])} triangles, {count(ours['pairs'])} pairs; xatlas: {count(atlas.chart_count)} charts.\n\n"
    rows = [[name, f"{seconds:.4f}" if seconds < 1 else f"{seconds:.1f}", f"{theirs / seconds:,.0f}".replace(",", " ")]
            for name, seconds in steps]
    print(told + table(["step", "CPU seconds", "xatlas over it"], rows), end="")


if __name__ == "__main__":
    main(sys.argv[1:])
