"""Cases about files: accessors, images, materials, OBJ, archives, and what passes through."""

import io
import struct
import zipfile
from math import cos, sin

from document import F32, Gltf, U8, U16, U32, flat, obj, sheet, soup
from pictures import BLUE, GREEN, RED, WHITE, function, jpeg, png, quadrants, ramp
from surfaces import CHANNEL, box, cuts, model, one_color, square

UNIT = square(box(0, 0, 1, 1))
SAME = lambda u, v: (u, v)
GRAY = {f"{CHANNEL}/components": 1}


def accessors(cases):
    def add(name, purpose, change, expect):
        gltf = Gltf()
        gltf.material(quadrants())
        vertices, indices = soup([square(box(0.6, 0.1, 0.9, 0.4))])
        gltf.mesh(change(gltf, vertices, indices))
        cases[name] = (purpose, {"model.gltf": gltf.bytes()}, expect)

    two = {"/materials/0/faces": 2, **one_color(GREEN)}
    for bits, component in ((8, U8), (16, U16), (32, U32)):
        add(f"indices_u{bits}", f"Indices of {bits} bits",
            lambda gltf, v, i: gltf.primitive(v, i, index_type=component), two)
    for bits, component, top in ((8, U8, 255), (16, U16, 65535)):
        def narrow(gltf, vertices, indices):
            rows = [[round(value * top) for value in vertex[1]] for vertex in vertices]
            places = gltf.accessor("VEC2", rows, component, normalized=True)
            return gltf.primitive(vertices, indices, TEXCOORD_0=places)
        add(f"texcoords_u{bits}", f"Texture coordinates as normalized {bits}-bit integers", narrow, two)
    add("mode_strip", "A triangle strip without indices",
        lambda gltf, v, i: gltf.primitive([v[0], v[1], v[3], v[2]], mode=5), {**two, "/materials/0/pairs": 1})
    add("mode_fan", "A triangle fan with indices", lambda gltf, v, i: gltf.primitive(v, [0, 1, 2, 3], mode=6),
        {**two, "/materials/0/pairs": 1})

    def sparse(gltf, vertices, indices):
        primitive = gltf.primitive([(p, (0.2, 0.2)) for p, _ in vertices], indices)
        accessor = gltf.json["accessors"][primitive["attributes"]["TEXCOORD_0"]]
        at = gltf.accessor("SCALAR", [[k] for k in range(4)], U16)
        to = gltf.accessor("VEC2", [place for _, place in vertices])
        views = [gltf.json["accessors"][number]["bufferView"] for number in (at, to)]
        del gltf.json["accessors"][-2:]
        accessor["sparse"] = {"count": 4, "indices": {"bufferView": views[0], "componentType": U16},
                              "values": {"bufferView": views[1]}}
        return primitive
    add("accessor_sparse", "Texture coordinates replaced by a sparse accessor", sparse, two)

    def interleaved(gltf, vertices, indices):
        rows = [list(p) + list(uv) for p, uv in vertices]
        primitive = gltf.primitive(vertices, indices)
        view = gltf.json["bufferViews"]
        position, place = (gltf.json["accessors"][primitive["attributes"][name]] for name in ("POSITION", "TEXCOORD_0"))
        both = gltf.view(b"".join(struct.pack("<5f", *row) for row in rows), byteStride=20)
        position |= {"bufferView": both}
        place |= {"bufferView": both, "byteOffset": 12}
        return primitive
    add("accessor_interleaved", "Positions and texture coordinates in turns in one view", interleaved, two)


def images(cases):
    def add(name, purpose, picture, places, expect, media_type="image/png"):
        gltf = Gltf()
        gltf.material()
        slot = {"index": gltf.texture(picture, media_type)}
        gltf.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = slot
        gltf.mesh(gltf.primitive(*soup([square(places)])))
        cases[name] = (purpose, {"model.gltf": gltf.bytes()}, expect)

    low_right = box(0.6, 0.6, 0.9, 0.9)
    deep = lambda code: (code * 257, code * 100, 40000)
    add("png_16_bit", "A PNG of 16 bits stays one", png(16, 16, lambda x, y: deep(10 + x * y), bits=16),
        box(0, 0, 1, 1), {f"{CHANNEL}/bits": 16})
    add("png_gray", "A gray PNG stays gray", png(16, 16, lambda x, y: (200 if x > 7 and y > 7 else 20,), kind=0),
        low_right, {**GRAY, **one_color([200])})
    add("png_gray_alpha", "Gray with an alpha that an opaque material does not show",
        png(16, 16, lambda x, y: (90, 10 * x), kind=4), low_right, {**GRAY, **one_color([90]), f"{CHANNEL}/psnr_db": 99.0})
    entries = [RED, GREEN, BLUE, (90, 91, 92)]
    add("png_palette", "A PNG with a palette",
        png(16, 16, lambda x, y: ((x > 7) + 2 * (y > 7),), kind=3, palette=entries), low_right, one_color(entries[3]))
    add("jpeg", "A gray baseline JPEG", jpeg([40, 90, 160, 220]), low_right, {**GRAY, **one_color([220])}, "image/jpeg")


def alphas(cases):
    # Green where it is opaque; what is transparent has a red that must not show.
    picture = function(lambda u, v: (0, 200, 0, 255) if u < 0.55 else (255, 0, 0, 0), 32, kind=6)
    files = model(*soup([UNIT]), picture, alphaMode="MASK", alphaCutoff=0.5)
    cases["alpha_mask"] = ("A masked material keeps its share of surface", files,
                           {f"{CHANNEL}/components": 4, "/effects": ["merged_pairs", "beyond_vertex_colors", "alpha_weighting", "alpha_coverage"]})
    files = model(*soup([UNIT]), picture, alphaMode="BLEND")
    cases["alpha_blend"] = ("Transparent texels have no say in color", files,
                            {f"{CHANNEL}/components": 4, "/effects": ["merged_pairs", "beyond_vertex_colors", "alpha_weighting"]})
    # Half of the seam is transparent on one side: it has no vote there.
    picture = function(lambda u, v: (0, 0, 255, 0) if u > 0.5 else (90, 200, 90, 255), 64, kind=6)
    right = square(box(0.6, 0, 0.9, 1), (1, 0))
    files = model(*soup([square(box(0.1, 0, 0.4, 1)), right]), picture, alphaMode="BLEND")
    cases["alpha_no_vote"] = ("A seam with one transparent side is no cut", files, cuts(1, 0))
    files = model(*soup([square(box(0.1, 0, 0.4, 1))]), picture)
    cases["alpha_opaque"] = ("An opaque material does not keep an alpha that nobody sees", files,
                             {f"{CHANNEL}/components": 3, **one_color((90, 200, 90))})
    picture = function(lambda u, v: (90, 200, 90, 255 if u < 0.5 else 40), 64, kind=6)
    files = model(*soup([square(box(0.1, 0, 0.4, 1)), right]), picture)
    cases["alpha_unseen_seam"] = ("Two charts of one color, with an alpha each that an opaque material does not show",
                                  files, {**cuts(1, 0), f"{CHANNEL}/psnr_db": 99.0})


def normals(cases):
    bumps = function(lambda u, v: (128 + 60 * sin(12 * u), 128 + 50 * sin(9 * v + 1), 220))

    def add(name, purpose, with_tangent, expect, **info):
        gltf = Gltf()
        gltf.material()
        gltf.json["materials"][0]["normalTexture"] = {"index": gltf.texture(bumps), **info}
        vertices, indices = sheet(3, 3, lambda u, v: (u, 1 - v, 0.2 * sin(3 * u)), SAME)
        normal = lambda u: [-0.6 * cos(3 * u), 0, 1]
        unit = lambda n: [c / sum(d * d for d in n) ** 0.5 for c in n]
        rows = [unit(normal(p[0])) for p, _ in vertices]
        more = {"NORMAL": gltf.accessor("VEC3", rows)}
        if with_tangent:
            more["TANGENT"] = gltf.accessor("VEC4", [unit([n[2], 0, -n[0]]) + [1] for n in rows])
        gltf.mesh(gltf.primitive(vertices, indices, **more))
        cases[name] = (purpose, {"model.gltf": gltf.bytes()}, expect)

    expect = {f"{CHANNEL}/slots": "normalTexture", **cuts(0, 0), "/document/attributes/0": "NORMAL",
              "/document/attributes/1": "TANGENT"}
    add("normal_with_tangent", "A normal map in the source's own frames", True, expect)
    add("normal_without_tangent", "A normal map whose frames follow from the texture coordinates", False, expect)
    add("normal_scale_half", "A normal map with scale 0.5", True, expect, scale=0.5)


def slots(cases):
    gltf = Gltf()
    gltf.material(ramp())
    shared = gltf.texture(function(lambda u, v: (255 * u, 255 * v, 90)))
    material = gltf.json["materials"][0]
    material["pbrMetallicRoughness"]["metallicRoughnessTexture"] = {"index": shared}
    material["occlusionTexture"] = {"index": shared, "strength": 0.7}
    material["emissiveTexture"] = {"index": gltf.texture(quadrants())}
    material["emissiveFactor"] = [1, 1, 1]
    gltf.mesh(gltf.primitive(*soup([UNIT])))
    cases["slots_shared_image"] = (
        "Occlusion, roughness and metalness in one image are one channel", {"model.gltf": gltf.bytes()},
        {"/channels/1/slots": "metallicRoughnessTexture occlusionTexture", "/channels/2/slots": "emissiveTexture",
         "/channels/3": None},
    )
    gltf = Gltf()
    gltf.material(quadrants(), name="left")
    gltf.material(ramp(), name="right")
    left = gltf.primitive(*soup([square(box(0.1, 0.1, 0.4, 0.4))]))
    right = gltf.primitive(*soup([square(box(0, 0, 1, 1), (1, 0))]), material=1)
    gltf.mesh(left, right)
    cases["materials_two_in_a_mesh"] = (
        "Two materials meet in one mesh: an edge between them joins nothing", {"model.gltf": gltf.bytes()},
        {"/materials/0/faces": 2, "/materials/1/faces": 2, "/channels/0/cut_edges": 0, "/channels/1/cut_edges": 0,
         **one_color(RED)},
    )
    gltf = Gltf()
    gltf.material(ramp())
    for shift in (0, 1):
        gltf.mesh(gltf.primitive(*soup([square(box(0, 0, 1, 1), (shift, 0))])))
    cases["material_over_two_meshes"] = (
        "One material on two meshes: one layout, nothing welded between them", {"model.gltf": gltf.bytes()},
        {"/materials/0/faces": 4, "/materials/1": None, **cuts(0, 0), "/document/meshes": 2},
    )
    gltf = Gltf()
    gltf.material(ramp())
    node = gltf.mesh(gltf.primitive(*soup([UNIT])))
    gltf.node(mesh=0, translation=[3, 0, 0], scale=[2, 2, 2])
    gltf.node(mesh=0, rotation=[0, 0, 1, 0])
    cases["instances"] = ("One mesh at three nodes is converted once", {"model.gltf": gltf.bytes()},
                          {"/materials/0/faces": 2, "/document/nodes": 3, "/document/meshes": 1, "/document/kept": True})


def passing(cases):
    gltf = Gltf()
    gltf.material(ramp())
    vertices, indices = soup([UNIT])
    joints = gltf.accessor("VEC4", [(0, 1, 0, 0)] * 4, U8)
    weights = gltf.accessor("VEC4", [(0.75, 0.25, 0, 0)] * 4)
    primitive = gltf.primitive(vertices, indices, JOINTS_0=joints, WEIGHTS_0=weights)
    primitive["targets"] = [{"POSITION": gltf.accessor("VEC3", [(0, 0, 0.5)] * 4)}]
    mesh = gltf.push("meshes", {"primitives": [primitive], "weights": [0.5], "extras": {"kept": [1, "two"]}})
    first = gltf.node(translation=[0, 0, 0], name="root")
    second = gltf.push("nodes", {"translation": [1, 0, 0], "name": "arm"})
    gltf.json["nodes"][first]["children"] = [second]
    matrix = [1.0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
    skin = gltf.push("skins", {"joints": [first, second], "inverseBindMatrices": gltf.accessor("MAT4", [matrix] * 2)})
    gltf.node(mesh=mesh, skin=skin)
    times, turns = gltf.accessor("SCALAR", [[0], [1]], min=[0], max=[1]), gltf.accessor("VEC3", [(0, 0, 0), (1, 1, 1)])
    gltf.push("animations", {
        "samplers": [{"input": times, "output": turns}],
        "channels": [{"sampler": 0, "target": {"node": first, "path": "translation"}}],
    })
    cases["skin_morph_animation"] = (
        "Skin, morph target, animation and extras pass through", {"model.gltf": gltf.bytes()},
        {"/document/kept": True, "/document/skins": 1, "/document/animations": 1, "/document/targets": 1},
    )
    gltf = Gltf()
    gltf.material(ramp())
    gltf.material(name="plain")
    lines = gltf.primitive([((0, 0, 0), (0, 0)), ((1, 1, 1), (1, 1))], mode=1)
    plain = gltf.primitive(*soup([square(box(0, 0, 1, 1), (4, 0))]), material=1)
    gltf.mesh(gltf.primitive(*soup([UNIT])), lines, plain)
    cases["lines_and_plain_material"] = (
        "Lines and a material without a texture stay as they were", {"model.gltf": gltf.bytes()},
        {"/materials/0/faces": 2, "/materials/1": None, "/document/primitives": 3},
    )


MTL = b"newmtl paint\nmap_Kd paint.png\n"
HEAD = "mtllib paint.mtl\nusemtl paint"
SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
PLACES = [(0, 0), (1, 0), (1, 1), (0, 1)]


def objects(cases):
    def add(name, purpose, text, expect, picture=ramp(16), main="model.obj"):
        cases[name] = (purpose, {main: text, "paint.mtl": MTL, "paint.png": picture}, expect)

    kinds = lambda quads, lone, pairs: {"/materials/0/quads": quads, "/materials/0/lone": lone, "/materials/0/pairs": pairs}
    add("obj_single_quad", "A quad stays a quad", obj(SQUARE, [[0, 1, 2, 3]], PLACES, HEAD), kinds(1, 0, 0))
    up = [(0.1, 0.6), (0.4, 0.6), (0.4, 0.9), (0.1, 0.9)]
    add("obj_v_points_up", "OBJ's v points up: 0.9 is near the picture's top", obj(SQUARE, [[0, 1, 2, 3]], up, HEAD),
        one_color(RED), quadrants())
    house = SQUARE + [(0.5, 1.6, 0)]
    places = [(0.1, 0), (0.9, 0), (0.9, 0.6), (0.1, 0.6), (0.5, 1)]
    add("obj_quad_and_triangle", "A triangle on a quad", obj(house, [[0, 1, 2, 3], [3, 2, 4]], places, HEAD),
        {**kinds(1, 1, 0), **cuts(0, 0)})
    dart = [(0, 0, 0), (1, 0.9, 0), (0, 1.8, 0), (0.4, 0.9, 0)]
    places = [(x / 2, y / 2) for x, y, _ in dart]
    add("obj_concave_quad", "A quad with a corner that points in", obj(dart, [[0, 1, 2, 3]], places, HEAD), kinds(1, 0, 0))
    shape = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0), (1, 2, 0), (0, 2, 0)]
    places = [(x / 2, y / 2) for x, y, _ in shape]
    add("obj_polygon", "A six-sided L is cut into four triangles", obj(shape, [list(range(6))], places, HEAD),
        {"/materials/0/faces": 4, "/materials/0/quads": 0, **cuts(0, 0)})
    colored = [p + (p[0], 0.5, p[1]) for p in SQUARE]
    add("obj_vertex_colors", "Vertex colors pass through beside the texture", obj(colored, [[0, 1, 2, 3]], PLACES, HEAD),
        {**kinds(1, 0, 0), "/document/attributes/0": "COLOR_0"})
    negative = HEAD + "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf -3/-3 -2/-2 -1/-1"
    add("obj_negative_numbers", "Vertices counted from the end", (negative + "\n").encode(), kinds(0, 1, 0))


def archives(cases):
    inner = {"scene/model.obj": obj(SQUARE, [[0, 1, 2, 3]], PLACES, HEAD), "scene/paint.mtl": MTL,
             "scene/paint.png": quadrants()}
    expect = {"/materials/0/quads": 1}
    cases["zip_with_a_folder"] = ("A zip whose model stands in a folder with its files", {"model.zip": zipped(inner)}, expect)


def zipped(files):
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w", zipfile.ZIP_STORED) as archive:
        for name, data in files.items():
            entry = zipfile.ZipInfo(name, (2000, 1, 1, 0, 0, 0))
            entry.create_system = 3
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, data)
    return memory.getvalue()


def add(cases):
    for group in (accessors, images, alphas, normals, slots, passing, objects, archives):
        group(cases)
