"""Small glTF documents with everything in data URIs, and OBJ files."""

import base64
import json
import struct
from math import isfinite

CODES = {5120: "b", 5121: "B", 5122: "h", 5123: "H", 5125: "I", 5126: "f"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
U8, U16, U32, F32 = 5121, 5123, 5125, 5126


def data_uri(media_type, data):
    return f"data:{media_type};base64,{base64.b64encode(data).decode()}"


class Gltf:
    """A document with one buffer; `add` fills it, `bytes` ends it."""

    def __init__(self):
        self.binary = b""
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}]}

    def push(self, name, value):
        self.json.setdefault(name, []).append(value)
        return len(self.json[name]) - 1

    def view(self, data, **more):
        self.binary += b"\0" * (-len(self.binary) % 4)
        start = len(self.binary)
        self.binary += data
        return self.push("bufferViews", {"buffer": 0, "byteOffset": start, "byteLength": len(data), **more})

    def accessor(self, kind, rows, component=F32, **more):
        """`rows` are the elements, each a list of numbers. A row of texture coordinates in bytes is padded
        to four bytes, as glTF asks of vertex attributes."""
        width = WIDTHS[kind]
        element = struct.calcsize(CODES[component]) * width
        stride = element + -element % 4 if kind != "SCALAR" else element
        pack = lambda row: struct.pack(f"<{width}{CODES[component]}", *row).ljust(stride, b"\0")
        strided = {"byteStride": stride} if stride != element else {}
        view = self.view(b"".join(map(pack, rows)), **strided)
        bounds = {}
        if kind == "VEC3" and component == F32 and all(isfinite(value) for row in rows for value in row):
            single = lambda value: struct.unpack("<f", struct.pack("<f", value))[0]
            columns = [[single(value) for value in column] for column in zip(*rows)]
            bounds = {"min": [min(column) for column in columns], "max": [max(column) for column in columns]}
        head = {"bufferView": view, "componentType": component, "count": len(rows), "type": kind}
        return self.push("accessors", {**head, **bounds, **more})

    def texture(self, picture, media_type="image/png", **sampler):
        image = self.push("images", {"uri": data_uri(media_type, picture)})
        texture = {"source": image}
        if sampler:
            texture["sampler"] = self.push("samplers", sampler)
        return self.push("textures", texture)

    def material(self, picture=None, info=None, **more):
        """With `picture` as its base color."""
        material = {"pbrMetallicRoughness": {"metallicFactor": 0}, **more}
        if picture is not None:
            slot = {"index": self.texture(picture), **(info or {})}
            material["pbrMetallicRoughness"]["baseColorTexture"] = slot
        return self.push("materials", material)

    def primitive(self, vertices, indices=None, material=0, index_type=U16, mode=4, **attributes):
        """`vertices` are pairs of a position and a place in the picture; further attributes are accessors."""
        accessors = {"POSITION": self.accessor("VEC3", [vertex[0] for vertex in vertices])}
        if "TEXCOORD_0" not in attributes:
            accessors["TEXCOORD_0"] = self.accessor("VEC2", [vertex[1] for vertex in vertices])
        primitive = {"attributes": {**accessors, **attributes}, "material": material}
        if indices is not None:
            rows = [[index] for index in indices]
            primitive["indices"] = self.accessor("SCALAR", rows, index_type)
        if mode != 4:
            primitive["mode"] = mode
        return primitive

    def mesh(self, *primitives, **more):
        """A mesh with a node of its own."""
        mesh = self.push("meshes", {"primitives": list(primitives), **more})
        return self.node(mesh=mesh)

    def node(self, **node):
        node = self.push("nodes", node)
        self.json["scenes"][0]["nodes"].append(node)
        return node

    def bytes(self):
        uri = data_uri("application/octet-stream", self.binary)
        json_with_buffer = {**self.json, "buffers": [{"byteLength": len(self.binary), "uri": uri}]}
        return (json.dumps(json_with_buffer, indent=1) + "\n").encode()


def soup(faces):
    """Triangles and quads with vertices of their own; a face is a list of (position, place) pairs."""
    vertices = [corner for face in faces for corner in face]
    indices, first = [], 0
    for face in faces:
        for k in range(1, len(face) - 1):
            indices += [first, first + k, first + k + 1]
        first += len(face)
    return vertices, indices


def sheet(columns, rows, position, place):
    """A grid of squares over [0, 1]², shared vertices, each square cut into two triangles.
    Counter-clockwise where `v` points down on the surface, as in the picture."""
    at = [(x / columns, y / rows) for y in range(rows + 1) for x in range(columns + 1)]
    vertices = [(position(u, v), place(u, v)) for u, v in at]
    indices = []
    for y in range(rows):
        for x in range(columns):
            a = y * (columns + 1) + x
            b, c, d = a + 1, a + columns + 2, a + columns + 1
            indices += [a, d, c, a, c, b]
    return vertices, indices


def flat(u, v):
    return (u, 1 - v, 0)


def obj(positions, faces, places=None, head="", tail=""):
    """`faces` are lists of vertex numbers from 0; each vertex has one place (OBJ's v points up)."""
    lines = [head] if head else []
    lines += ["v " + " ".join(f"{value:g}" for value in position) for position in positions]
    lines += [f"vt {u:g} {v:g}" for u, v in places or []]
    corner = (lambda k: f"{k + 1}/{k + 1}") if places else (lambda k: f"{k + 1}")
    lines += ["f " + " ".join(map(corner, face)) for face in faces]
    return ("\n".join(lines + ([tail] if tail else [])) + "\n").encode()
