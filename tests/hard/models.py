"""Models of the hard cases."""

from document import Gltf
from pictures import png

MTL = b"newmtl paint\nmap_Kd paint.png\n"
WELDED = {"cut": "255"}


def polygons(faces, picture):
    """Triangles and quads as OBJ, a list of (position, place) pairs each; places count v downwards."""
    lines = ["mtllib paint.mtl", "usemtl paint"]
    corners = [corner for face in faces for corner in face]
    lines += ["v " + " ".join(repr(float(value)) for value in position) for position, _ in corners]
    lines += [f"vt {float(u)!r} {1 - float(v)!r}" for _, (u, v) in corners]
    first = 1
    for face in faces:
        lines.append("f " + " ".join(f"{first + k}/{first + k}" for k in range(len(face))))
        first += len(face)
    return {"model.obj": ("\n".join(lines) + "\n").encode(), "paint.mtl": MTL, "paint.png": picture}


def occlusion(vertices, indices, picture):
    """The picture as data: codes are values."""
    gltf = Gltf()
    gltf.material()
    gltf.json["materials"][0]["occlusionTexture"] = {"index": gltf.texture(picture)}
    gltf.mesh(gltf.primitive(vertices, indices))
    return {"model.gltf": gltf.bytes()}


def checkers(width=4, height=4, low=(0, 0, 0), high=(255, 255, 255), **more):
    """A texel of one color beside a texel of the other, along both axes."""
    return png(width, height, lambda x, y: high if (x + y) % 2 else low, **more)


def halves(side):
    """Black above one diagonal and white below: a contrast that no filter averages away soon."""
    return png(side, side, lambda x, y: (255,) * 3 if x + y >= side else (0,) * 3)


def at_texel(x, y, side=4):
    """The place of a texel's center in a picture of this side."""
    return ((x + 0.5) / side, (y + 0.5) / side)


def error(code, detail, pointer=None):
    expect = {"/error/code": code, "detail_contains": detail}
    return {**expect, "/error/pointer": pointer} if pointer else expect
