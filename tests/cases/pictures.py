"""Image files for the cases, written so that no compression library's version shows in the bytes."""

import struct
import zlib

RED, GREEN, BLUE, WHITE = (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255)


def stored(data):
    """A zlib stream of stored blocks."""
    blocks = [data[at : at + 65535] for at in range(0, len(data), 65535)] or [b""]
    out = b"\x78\x01"
    for number, block in enumerate(blocks):
        last = number == len(blocks) - 1
        out += struct.pack("<BHH", last, len(block), len(block) ^ 0xFFFF) + block
    return out + struct.pack(">I", zlib.adler32(data))


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(width, height, color, kind=2, bits=8, palette=None):
    """`color(x, y)` gives the codes of one texel; `kind` is PNG's color type."""
    rows = b""
    for y in range(height):
        codes = [code for x in range(width) for code in color(x, y)]
        rows += b"\0" + (struct.pack(f">{len(codes)}H", *codes) if bits == 16 else bytes(codes))
    file = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, kind, 0, 0, 0))
    if palette:
        file += chunk(b"PLTE", bytes(code for entry in palette for code in entry))
    return file + chunk(b"IDAT", stored(rows)) + chunk(b"IEND", b"")


def bomb(side):
    """A picture that says it is huge and holds nothing."""
    head = chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + chunk(b"IDAT", stored(b"")) + chunk(b"IEND", b"")


def quadrants(top_left=RED, top_right=GREEN, bottom_left=BLUE, bottom_right=WHITE, side=16, **more):
    """Four squares of one color each."""
    squares = ((top_left, top_right), (bottom_left, bottom_right))
    return png(side, side, lambda x, y: squares[2 * y // side][2 * x // side], **more)


def function(at, side=32, **more):
    """`at(u, v)` gives codes at texel centers."""
    whole = lambda codes: tuple(int(round(min(max(code, 0), 255))) for code in codes)
    return png(side, side, lambda x, y: whole(at((x + 0.5) / side, (y + 0.5) / side)), **more)


def ramp(side=32):
    """A different color everywhere."""
    return function(lambda u, v: (30 + 200 * u, 30 + 200 * v, 200 - 80 * u - 80 * v), side)


def jpeg(levels):
    """A gray baseline JPEG of 16 by 16 texels: four blocks, each of one code."""
    bits = ""
    before = 128
    for level in levels:
        step, before = level - before, level
        size = abs(step).bit_length()
        bits += f"{size:04b}"
        bits += f"{step if step > 0 else step + (1 << size) - 1:0{size}b}" if size else ""
        bits += "0"
    bits += "1" * (-len(bits) % 8)
    scan = bytes(int(bits[at : at + 8], 2) for at in range(0, len(bits), 8)).replace(b"\xff", b"\xff\0")

    def segment(mark, data):
        return b"\xff" + bytes([mark]) + struct.pack(">H", len(data) + 2) + data

    direct = bytes([0, 0, 0, 0, 9] + [0] * 12 + list(range(9)))
    alternating = bytes([0x10, 1] + [0] * 15 + [0])
    return (
        b"\xff\xd8"
        + segment(0xDB, b"\0" + b"\x08" * 64)
        + segment(0xC0, struct.pack(">BHHB", 8, 16, 16, 1) + b"\x01\x11\0")
        + segment(0xC4, direct)
        + segment(0xC4, alternating)
        + segment(0xDA, b"\x01\x01\0\0\x3f\0")
        + scan
        + b"\xff\xd9"
    )
