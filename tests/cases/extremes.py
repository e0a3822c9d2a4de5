"""Cases about things that are allowed and rare: empty, tiny, far, doubled, missing."""

from math import cos, pi, sin

from document import Gltf, obj, soup
from formats import HEAD, MTL, PLACES, SQUARE, UNIT, zipped
from pictures import GREEN, RED, WHITE, function, png, quadrants, ramp
from surfaces import CHANNEL, box, cuts, model, one_color, square


def pictures(cases):
    clear = png(8, 8, lambda x, y: (200, 100, 50, 0), kind=6)
    files = model(*soup([UNIT]), clear, alphaMode="BLEND")
    cases["alpha_all_transparent"] = ("Nothing but transparent texels", files, {f"{CHANNEL}/components": 4})
    cases["image_1x1"] = ("A picture of one texel", model(*soup([UNIT]), png(1, 1, lambda x, y: (9, 99, 199))),
                          {**one_color((9, 99, 199)), f"{CHANNEL}/psnr_db": 99.0})
    files = model(*soup([UNIT]), png(7, 3, lambda x, y: (30 * x, 80 * y, 100)))
    cases["image_7_by_3"] = ("A picture whose sides are no powers of two", files, {"/materials/0/pairs": 1})


def places(cases):
    tiled = function(lambda u, v: (128 + 90 * sin(2 * pi * u), 128 + 90 * cos(2 * pi * v), 100))
    far = model(*soup([square(box(4096, -2048, 4097, -2047)), square(box(-4096, 7, -4095, 8), (1, 0))]), tiled)
    cases["uv_thousands_of_tiles_away"] = ("Texture coordinates thousands of tiles apart", far, cuts(1, 0))
    below = [((-0.0 if x == 0 else x, y, z), place) for (x, y, z), place in square(box(0, 0, 1, 1), (-1, 0))]
    files = model(*soup([below, square(box(0, 0, 1, 1))]), function(lambda u, v: (90, 100 + 90 * v, 120)))
    cases["negative_zero"] = ("Two vertices at 0 and -0 are one", files, cuts(1, 0))
    gltf = Gltf()
    gltf.material(quadrants())
    primitive = gltf.primitive(*soup([UNIT]))
    del primitive["attributes"]["TEXCOORD_0"]
    gltf.mesh(primitive)
    corner = {"/materials/0/faces": 2, "/materials/0/exponents": [2]}
    cases["texcoord_missing"] = ("A textured primitive without texture coordinates reads (0, 0)",
                                 {"model.gltf": gltf.bytes()}, corner)


def sharing(cases):
    gltf = Gltf()
    gltf.material(function(lambda u, v: (60, 60 + 120 * v, 200 - 90 * abs(2 * u - 1))))
    left, right = square(box(0, 0, 1, 1)), square(box(0, 0, 1, 1), (1, 0))
    gltf.mesh(gltf.primitive(*soup([left])), gltf.primitive(*soup([right])))
    cases["primitives_weld"] = ("Two primitives of one material in one mesh are one surface",
                                {"model.gltf": gltf.bytes()}, {**cuts(1, 0), "/document/primitives": 2})
    gltf = Gltf()
    gltf.material(quadrants())
    vertices, indices = soup([square(box(0.1, 0.1, 0.4, 0.4))])
    second = gltf.accessor("VEC2", box(0, 0, 1, 1))
    occlusion = gltf.texture(png(8, 8, lambda x, y: (20 * x, 0, 0)))
    gltf.json["materials"][0]["occlusionTexture"] = {"index": occlusion, "texCoord": 1}
    gltf.mesh(gltf.primitive(vertices, indices, TEXCOORD_1=second))
    cases["slots_of_two_sets"] = (
        "Two slots with texture coordinates of their own end in one layout and one set", {"model.gltf": gltf.bytes()},
        {**one_color(RED), "/channels/1/slots": "occlusionTexture", "/materials/1": None,
         "/document/attributes": ["TEXCOORD_0"]},
    )
    files = model(*soup([UNIT, UNIT]), ramp())
    cases["coincident_same_way"] = ("Two sheets at one place, facing the same way", files, cuts(0, 0))


def normals(cases):
    def add(name, purpose, picture, vertices, indices, with_normals, expect):
        gltf = Gltf()
        gltf.material()
        gltf.json["materials"][0]["normalTexture"] = {"index": gltf.texture(picture)}
        more = {"NORMAL": gltf.accessor("VEC3", [(0, 0, 1)] * len(vertices))} if with_normals else {}
        gltf.mesh(gltf.primitive(vertices, indices, **more))
        cases[name] = (purpose, {"model.gltf": gltf.bytes()}, expect)

    expect = {f"{CHANNEL}/slots": "normalTexture", "/document/attributes/1": "TANGENT"}
    bumps = function(lambda u, v: (128 + 60 * sin(12 * u), 128 + 50 * sin(9 * v + 1), 220))
    unit = soup([UNIT])
    add("normal_without_normals", "A normal map on a primitive without normals", bumps, *unit, False, expect)
    add("normal_of_no_direction", "A normal map whose texels are zero vectors",
        png(4, 4, lambda x, y: (128, 128, 128) if x < 2 else (127, 127, 127)), *unit, True, expect)
    add("normal_black", "A normal map that points down everywhere", png(4, 4, lambda x, y: (0, 0, 0)), *unit, True, expect)
    still = soup([square([(0.3, 0.3)] * 4)])
    add("normal_uv_constant", "A normal map without tangents to read it in", bumps, *still, True, expect)
    flat = list(zip([(1, 0, 0), (1, 1, 0), (1, 0.5, 0)], [(1, 1), (1, 0), (1, 0.5)]))
    add("normal_zero_area_face", "A normal map over a face without area", bumps, *soup([UNIT, flat]), True,
        {**expect, "/materials/0/faces": 3})


def files(cases):
    gltf = Gltf()
    gltf.material(quadrants())
    gltf.mesh(gltf.primitive(*soup([square(box(0.6, 0.6, 0.9, 0.9))])))
    gltf.json["images"][0] = {"uri": "pictures/my%20picture.png"}
    loose = gltf.bytes()
    inner = {"model.gltf": loose, "pictures/my picture.png": quadrants()}
    cases["zip_with_an_encoded_name"] = ("A percent-encoded name in a folder of a zip", {"model.zip": zipped(inner)},
                                         one_color(WHITE))
    two = obj(SQUARE, [[0, 1, 2, 3]], PLACES, HEAD + "\no first", "o second\nusemtl paint\nf 1/1 2/2 3/3 4/4")
    cases["obj_two_objects"] = ("Two objects of one material are two meshes",
                                {"model.obj": two, "paint.mtl": MTL, "paint.png": ramp(16)},
                                {"/document/meshes": 2, "/materials/0/quads": 2, **cuts(0, 0)})
    scaled = b"newmtl paint\nmap_Kd -o 0.6 0.6 0 -s 0.3 0.3 1 paint.png\n"
    cases["obj_map_options"] = ("An MTL map with offset and scale", {
        "model.obj": obj(SQUARE, [[0, 1, 2, 3]], PLACES, HEAD), "paint.mtl": scaled, "paint.png": quadrants()},
        one_color(GREEN))


def add(cases):
    for group in (pictures, places, sharing, normals, files):
        group(cases)
