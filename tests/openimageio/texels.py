"""Prints as JSON what OpenImageIO reads in the files that the command line names: for each a list of its parts
(faces of a Ptex file), each with the texels of its finest level, rows as the file has them. Codes are shares of 1."""

import itertools
import json
import math
import sys

import OpenImageIO as oiio


def part(path, number):
    image = oiio.ImageBuf(path, number, 0)
    if not image.read(number, 0, True, oiio.FLOAT):
        sys.exit(f"{path}: {image.geterror()}")
    spec = image.spec()
    at = [(x, y) for y in range(spec.height) for x in range(spec.width)]
    return {
        "size": [spec.width, spec.height],
        "channels": spec.nchannels,
        # JSON has no word for others.
        "values": [value if math.isfinite(value) else None for x, y in at for value in image.getpixel(x, y)],
    }


def part_count(path):
    """Some formats do not tell it in front."""
    file = oiio.ImageInput.open(path)
    if file is None:
        sys.exit(f"{path}: {oiio.geterror()}")
    return next(number for number in itertools.count() if not file.seek_subimage(number, 0))


print(json.dumps([[part(path, number) for number in range(part_count(path))] for path in sys.argv[1:]]))
