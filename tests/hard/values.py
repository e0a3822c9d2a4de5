"""Values at the ends of their range: wide channels, transparency, factors, pictures of odd size, nothing at all."""

from document import Gltf, obj, sheet, soup
from models import MTL, WELDED, checkers, error
from pictures import png, ramp
from surfaces import box, model, square

UNIT = square(box(0, 0, 1, 1))
FLAT = lambda u, v: (u, 1 - v, 0)
UV = lambda u, v: (u, v)


def wide(cases):
    grid = sheet(3, 3, FLAT, UV)
    many = lambda low, high, **more: checkers(16, 16, low, high, bits=16, **more)
    cases["wide_black_and_white"] = ("16 bits, from end to end", model(*grid, many((0,) * 3, (65535,) * 3)),
                                     {"/standard/channels/0/bits": 16}, WELDED)
    cases["wide_smallest_steps"] = ("16 bits, the two smallest codes beside the two largest",
                                    model(*grid, png(16, 16, lambda x, y: (x % 2, 65534 + y % 2, (x + y) % 2), bits=16)),
                                    {"/standard/channels/0/bits": 16}, WELDED)
    cases["wide_gray_alpha"] = ("16 bits of gray and alpha", model(*grid, many((0, 65535), (65535, 1), kind=4), alphaMode="BLEND"),
                                {"/standard/channels/0/bits": 16}, WELDED)


def alpha(cases):
    grid = sheet(4, 4, FLAT, UV)
    clear = png(16, 16, lambda x, y: (255 * (x % 2), 255 * (y % 2), 255, 0 if x < 8 else 255), kind=6)
    cases["alpha_0_region"] = ("One half without color", model(*grid, clear, alphaMode="BLEND"), {}, WELDED)
    spots = png(16, 16, lambda x, y: (255, 0, 255 * (x % 2), 255 * ((x + y) % 2)), kind=6)
    cases["alpha_checkers"] = ("Alpha in checkers at sample pitch", model(*grid, spots, alphaMode="BLEND"), {}, WELDED)
    cases["alpha_mask_checkers"] = ("The same under an alpha test", model(*grid, spots, alphaMode="MASK", alphaCutoff=0.5), {}, WELDED)
    cases["alpha_mask_beyond_1"] = ("An alpha test that nothing can pass", model(*grid, spots, alphaMode="MASK", alphaCutoff=7),
                                    {}, WELDED)
    nothing = png(8, 8, lambda x, y: (255 * (x % 2), 0, 0, 0), kind=6)
    cases["alpha_0_everywhere"] = ("Nothing but transparent texels", model(*grid, nothing, alphaMode="MASK"), {}, WELDED)


def factors(cases):
    # glTF has no float textures: values outside of [0, 1], and denormals, come in as factors, which pass through.
    gltf = Gltf()
    gltf.json["extensionsUsed"] = ["KHR_materials_emissive_strength"]
    gltf.material(checkers(8, 8), emissiveFactor=[1e-40, 1, 0.5],
                  extensions={"KHR_materials_emissive_strength": {"emissiveStrength": 1e30}})
    material = gltf.json["materials"][0]
    material["emissiveTexture"] = {"index": gltf.texture(checkers(8, 8, (0, 255, 0), (255, 0, 0)))}
    material["occlusionTexture"] = {"index": gltf.texture(checkers(8, 8, (0,), (255,), kind=0)), "strength": 1e-42}
    material["normalTexture"] = {"index": gltf.texture(checkers(8, 8, (0, 128, 128), (255, 128, 128))), "scale": 1e6}
    vertices, indices = sheet(3, 3, FLAT, UV)
    gltf.mesh(gltf.primitive(vertices, indices, NORMAL=gltf.accessor("VEC3", [(0, 0, 1)] * len(vertices))))
    cases["factors_extreme"] = ("Emission of 1e30, a normal scale of 1e6, an occlusion strength that is denormal",
                                {"model.gltf": gltf.bytes()}, {"/standard/channels/3/slots": "emissiveTexture"}, WELDED)
    for name, scale in (("zero", 0), ("denormal", 1e-42)):
        gltf = Gltf()
        gltf.material()
        picture = checkers(8, 8, (0, 0, 128), (255, 255, 0))
        gltf.json["materials"][0]["normalTexture"] = {"index": gltf.texture(picture), "scale": scale}
        gltf.mesh(gltf.primitive(vertices, indices, NORMAL=gltf.accessor("VEC3", [(0, 0, 1)] * len(vertices))))
        cases[f"normal_scale_{name}"] = (f"Normals that point down or sideways, at a scale of {scale:g}",
                                         {"model.gltf": gltf.bytes()}, {"/standard/channels/0/slots": "normalTexture"}, WELDED)


def pictures(cases):
    cases["source_1x1"] = ("A picture of one texel", model(*sheet(3, 3, FLAT, UV), png(1, 1, lambda x, y: (0, 255, 77))),
                           {"/standard/change_max": 0.0}, {"resolution": "fixed:3"})
    gray = lambda x, y: (255 * ((x + y) % 2),)
    cases["source_16384x1"] = ("A picture of one row", model(*soup([UNIT]), png(16384, 1, gray, kind=0)),
                               {"/standard/exponents": [0] * 11 + [2]}, WELDED)
    cases["source_1x16384"] = ("A picture of one column", model(*soup([UNIT]), png(1, 16384, gray, kind=0)),
                               {"/standard/exponents": [0] * 11 + [2]}, WELDED)
    cases["source_16385x1"] = ("A picture beyond the largest", model(*soup([UNIT]), png(16385, 1, gray, kind=0)),
                               error("image_too_large", "16385x1", "/images/0"))


def nothing(cases):
    text = b"mtllib paint.mtl\nusemtl paint\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"
    cases["empty_obj"] = ("Vertices without a face", {"model.obj": text, "paint.mtl": MTL, "paint.png": ramp(8)},
                          error("nothing_to_convert", "faces"))
    gltf = Gltf()
    gltf.material(ramp(8))
    cases["empty_scene"] = ("A material that nothing uses", {"model.gltf": gltf.bytes()}, error("nothing_to_convert", "faces"))
    gltf = Gltf()
    gltf.material(ramp(8))
    vertices, indices = soup([UNIT])
    gltf.mesh(gltf.primitive(vertices, indices), gltf.primitive(vertices, mode=0))
    gltf.mesh(gltf.primitive(vertices, mode=0))
    cases["points_beside_faces"] = ("Primitives without faces beside one with two", {"model.gltf": gltf.bytes()},
                                    {"/standard/faces": 2})
    one = obj([(0, 0, 0)] * 3, [[0, 1, 2]], [(0, 0), (1, 0), (0, 1)], "mtllib paint.mtl\nusemtl paint")
    cases["all_at_one_point"] = ("One triangle, all of it at one point", {"model.obj": one, "paint.mtl": MTL, "paint.png": checkers(8, 8)},
                                 {"/standard/warnings/zero_area_face": 1})


def add(cases):
    for group in (wide, alpha, factors, pictures, nothing):
        group(cases)
