"""Writes OpenEXR images into the folder that the command line names: one for each packing, type and kind of blocks,
and for each type one with levels."""

import math
import sys

import OpenImageIO as oiio

PACKINGS = ["none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa:45", "dwab:200"]
# Neither side is a multiple of a block's or a tile's.
WIDTH, HEIGHT = 45, 70


def picture(kind):
    """Waves, an edge, and a corner of one color, which B44A and DWA pack on its own."""
    image = oiio.ImageBuf(oiio.ImageSpec(WIDTH, HEIGHT, 3, kind))
    for y in range(HEIGHT):
        for x in range(WIDTH):
            wave = math.sin(x * 0.3) * math.cos(y * 0.2)
            color = (2.5 + wave, 0.01 * x - 0.3 * (y > 40), 700.0 * (x > y)) if x + y > 50 else (0.5, 0.25, 0.0)
            image.setpixel(x, y, color)
    return image


for kind in [oiio.HALF, oiio.FLOAT]:
    image = picture(kind)
    for packing in PACKINGS:
        image.specmod().attribute("compression", packing)
        for side in [0, 16]:
            image.set_write_tiles(side, side)
            path = f"{sys.argv[1]}/{kind.name}-{packing.split(':')[0]}-{side}.exr"
            if not image.write(path):
                sys.exit(f"{path}: {image.geterror()}")
    path = f"{sys.argv[1]}/{kind.name}-levels.exr"
    if not oiio.ImageBufAlgo.make_texture(oiio.MakeTxTexture, picture(kind), path):
        sys.exit(f"{path}: {oiio.geterror()}")
