"""Cases about the surface: how texture coordinates, edges and shapes of faces are converted."""

from math import cos, pi, sin

from document import Gltf, U16, flat, sheet, soup
from pictures import BLUE, GREEN, RED, WHITE, function, png, quadrants, ramp

CHANNEL = "/channels/0"


def model(vertices, indices, picture, info=None, sampler=None, **material):
    """One mesh of one material with a base color."""
    gltf = Gltf()
    gltf.material(picture, info, **material)
    if sampler:
        gltf.json["textures"][0]["sampler"] = gltf.push("samplers", sampler)
    gltf.mesh(gltf.primitive(vertices, indices))
    return {"model.gltf": gltf.bytes()}


def cuts(seam, cut):
    """Edges where charts meet, and edges that stay cut."""
    return {f"{CHANNEL}/seam_edges": seam, f"{CHANNEL}/cut_edges": cut}


def square(places, at=(0, 0)):
    """A square of side 1 with these places at its corners, counter-clockwise from the lower left."""
    x, y = at
    return list(zip([(x, y, 0), (x + 1, y, 0), (x + 1, y + 1, 0), (x, y + 1, 0)], places))


def box(left, top, right, bottom):
    """Places of a square that shows this part of the picture upright."""
    return [(left, bottom), (right, bottom), (right, top), (left, top)]


def one_color(color):
    return {f"{CHANNEL}/corners": [list(color)] * 3}


def wrap(cases):
    # Outside of [0, 1] each mode shows another quadrant.
    places = box(1.6, 1.1, 1.9, 1.4)
    for name, mode, color in (("repeat", 10497, GREEN), ("mirror", 33648, BLUE), ("clamp", 33071, WHITE)):
        files = model(*soup([square(places)]), quadrants(), sampler={"wrapS": mode, "wrapT": mode})
        cases[f"wrap_{name}"] = (f"Texture coordinates beyond 1 with wrap mode {name}", files, one_color(color))
    tiled = function(lambda u, v: (128 + 90 * sin(2 * pi * u), 128 + 90 * cos(2 * pi * v), 100))
    files = model(*soup([square(box(-1.5, -0.5, 0.5, 1.5)), square(box(3.5, 7.5, 5.5, 9.5), (1, 0))]), tiled)
    cases["wrap_tiled_seam"] = ("A seam between two tiles of one repeating picture", files, cuts(1, 0))


def transforms(cases):
    unit = box(0, 0, 1, 1)
    transform = lambda **values: {"extensions": {"KHR_texture_transform": values}}
    used = {"extensionsUsed": ["KHR_texture_transform"]}

    def add(name, purpose, info, color, second=None):
        gltf = Gltf()
        gltf.json |= used if "extensions" in info else {}
        gltf.material(quadrants(), info)
        vertices, indices = soup([square(unit)])
        more = {}
        if second:
            more = {
                "TEXCOORD_0": gltf.accessor("VEC2", [(0.2, 0.2)] * 4),
                "TEXCOORD_1": gltf.accessor("VEC2", second),
            }
        gltf.mesh(gltf.primitive(vertices, indices, **more))
        cases[name] = (purpose, {"model.gltf": gltf.bytes()}, one_color(color))

    scaled = transform(offset=[0.6, 0.1], scale=[0.3, 0.3])
    add("transform_scale_offset", "KHR_texture_transform: scale, then offset", scaled, GREEN)
    turned = transform(offset=[0.1, 0.9], rotation=pi / 2, scale=[0.3, 0.3])
    add("transform_rotation", "KHR_texture_transform: the way a rotation turns", turned, BLUE)
    second = box(0.6, 0.6, 0.9, 0.9)
    add("texcoord_set_1", "A texture that reads TEXCOORD_1", {"texCoord": 1}, WHITE, second)
    both = {"texCoord": 0, **transform(texCoord=1)}
    add("transform_texcoord", "KHR_texture_transform puts another set in place", both, WHITE, second)


def seams(cases):
    left, right = box(0, 0, 0.5, 1), box(0.5, 0, 1, 1)

    def pair(name, purpose, a, b, picture, expect):
        files = model(*soup([square(a), square(b, (1, 0))]), picture)
        cases[name] = (purpose, files, expect)

    pair("uv_mirrored", "Two halves that share one part of the picture, mirrored", left,
         [left[1], left[0], left[3], left[2]], ramp(), cuts(0, 0))
    pair("uv_overlapping", "Two squares that share one part of the picture: their seam disagrees", left, left,
         ramp(), cuts(1, 1))
    # Each half of the picture holds the color of its place, once as it stands and once turned by 90 degrees.
    place = lambda x, y: (40 + 80 * x, 60 + 90 * y, 120)
    upright = lambda u, v: place((u - 0.05) / 0.4, (0.95 - v) / 0.9)
    island = lambda u, v: upright(u, v) if u < 0.5 else place(1 + (0.95 - v) / 0.9, (u - 0.55) / 0.4)
    turned = [(0.55, 0.95), (0.55, 0.05), (0.95, 0.05), (0.95, 0.95)]
    pair("seam_that_agrees", "Two charts turned against each other, one color at their seam: welded",
         box(0.05, 0.05, 0.45, 0.95), turned,
         function(island, 64), {**cuts(1, 0), f"{CHANNEL}/welded_share": 1.0})
    pair("seam_painted_hard", "Two charts of two colors: the edge between them is kept", box(0.1, 0.1, 0.4, 0.4),
         box(0.6, 0.1, 0.9, 0.4), quadrants(), {**cuts(1, 1), **one_color(RED), f"{CHANNEL}/cut_share": 1.0})
    pair("uv_constant", "All corners at one place of the picture", [(0.3, 0.7)] * 4, [(0.3, 0.7)] * 4, quadrants(),
         {**cuts(0, 0), **one_color(BLUE), "/materials/0/exponents": [4]})
    left = lambda u, v: place(2.4 * u - 0.1, 1 - v)
    right = lambda u, v: place(0.9 + 2.4 * (u - 0.5), 1 - v)[:2] + (210 if v < 0.5 else 120,)
    island = lambda u, v: left(u, v) if u < 0.5 else right(u, v)
    faces = []
    for column, start in ((0, 0.1 / 2.4), (1, 0.5 + 0.1 / 2.4)):
        for row in range(4):
            top = 1 - (row + 1) / 4
            places = box(start, top, start + 1 / 2.4, top + 1 / 4)
            corners = square(places, (column, 0))
            faces.append([((x, (row + y) / 4, z), uv) for (x, y, z), uv in corners])
    cases["cut_ends_inside"] = ("A seam that disagrees from its middle to the border: two of four edges are cut",
                                model(*soup(faces), function(island, 96)), cuts(4, 2))


def palette(cases):
    colors = [(200, 30, 30), (30, 160, 60), (40, 60, 200), (230, 210, 40)]
    picture = png(4, 1, lambda x, y: colors[x])
    faces = []
    for number, at in enumerate([(0, 0), (1, 0), (0, 1), (1, 1)]):
        faces.append(square([((number + 0.5) / 4, 0.5)] * 4, at))
    expect = {**cuts(4, 4), **one_color(colors[0]), "/materials/0/exponents": [8]}
    cases["palette_low_poly"] = ("One palette color a face: the hard edges stay", model(*soup(faces), picture), expect)


def shared_edges(cases):
    """Three wings on one edge, and sheets on top of each other."""

    def wings(turns, places):
        faces = []
        for turn, (low, high) in zip(turns, places):
            x, y = cos(turn), sin(turn)
            corners = [(0, 0, 0), (x, y, 0), (x, y, 1), (0, 0, 1)]
            faces.append(list(zip(corners, [(low, 1), (high, 1), (high, 0), (low, 0)])))
        return soup(faces)

    third = 2 * pi / 3
    agreeing = model(*wings([0, third, 2 * third], [(0, 0.4), (0, 0.7), (0, 1)]), ramp())
    cases["three_faces_agree"] = ("Three faces at one edge with one color there: welded", agreeing, cuts(0, 0))
    picture = function(lambda u, v: (60 + 120 * v, 90, 200 if u > 0.6 else 80))
    odd = model(*wings([0, third, 2 * third], [(0.1, 0.4), (0.1, 0.5), (0.7, 1)]), picture)
    # One edge, and each of its three pairs is looked at: what two of them agree on does not count.
    cases["three_faces_disagree"] = ("Three faces at one edge, one of another color: cut for all", odd,
                                     {f"{CHANNEL}/cut_edges": 1})
    vertices, indices = soup([square(box(0, 0, 1, 1))])
    back = [k + 4 for triangle in (indices[:3], indices[3:]) for k in reversed(triangle)]
    double = model(vertices * 2, indices + back, ramp())
    cases["coincident_sheets"] = ("Two sheets at one place, back to back, of one color", double, cuts(0, 0))


def shapes(cases):
    triangle = lambda points: soup([list(zip(points, [(0, 1), (1, 1), (0, 0)]))])
    place = lambda u, v: (u, v)
    cases["single_triangle"] = (
        "Nothing but one triangle", model(*triangle([(0, 0, 0), (1, 0, 0), (0, 1, 0)]), ramp(16)),
        {"/materials/0/lone": 1, "/materials/0/faces": 1, "/materials/0/pairs": 0},
    )

    def half_turn(u, v):
        along, across = 2 * pi * u, (v - 0.5) * 0.6
        radius = 1 + across * cos(along / 2)
        return (radius * cos(along), radius * sin(along), across * sin(along / 2))

    # Mirrored at half way, so that both ends show one color, the one upside down.
    picture = function(lambda u, v: (60 + 120 * abs(2 * u - 1), 100 + 80 * sin(pi * v), 90))
    vertices, indices = sheet(12, 2, half_turn, place)
    ends = {(12, row): (0, 2 - row) for row in range(3)}
    for (column, row), (to_column, to_row) in ends.items():
        vertices[row * 13 + column] = (vertices[to_row * 13 + to_column][0], vertices[row * 13 + column][1])
    cases["moebius_strip"] = ("A strip with one side: its ends meet upside down", model(vertices, indices, picture),
                              {**cuts(2, 0), "/materials/0/faces": 48})
    needle = triangle([(0, 0, 0), (1, 0, 0), (0.5, 1e-5, 0)])
    cases["needle"] = ("A face ten thousand times as long as wide", model(*needle, ramp(16)), {})
    faces = [square(box(0, 0, 1, 1))]
    flat_face = list(zip([(1, 0, 0), (1, 1, 0), (1, 0.5, 0)], [(1, 1), (1, 0), (1, 0.5)]))
    cases["zero_area_face"] = ("A face of three points in a row beside a real one", model(*soup(faces + [flat_face]), ramp()),
                               {"/warnings/zero_area_face": 1, "/materials/0/faces": 3})
    point = list(zip([(1, 0, 0), (1, 0, 0), (1, 1, 0)], [(1, 1), (1, 1), (1, 0)]))
    cases["zero_length_edge"] = ("A face with two corners at one point", model(*soup(faces + [point]), ramp()),
                                 {"/warnings/zero_area_face": 1, "/materials/0/faces": 3})
    vertices, indices = soup(faces)
    cases["repeated_index"] = ("A face that names one vertex twice", model(vertices, indices + [0, 1, 1], ramp()),
                               {"/warnings/degenerate_face": 1, "/materials/0/faces": 3})


def fans(cases):
    for valence in (3, 4, 100):
        around = [2 * pi * k / valence for k in range(valence)]
        vertices = [((0, 0, 0.3), (0.5, 0.5))]
        vertices += [((cos(a), sin(a), 0), (0.5 + 0.5 * cos(a), 0.5 + 0.5 * sin(a))) for a in around]
        indices = []
        for k in range(valence):
            indices += [0, 1 + k, 1 + (k + 1) % valence]
        cases[f"valence_{valence}"] = (f"A cone of {valence} faces around one vertex", model(vertices, indices, ramp()),
                                       {"/materials/0/faces": valence, **cuts(0, 0)})


def exponents(cases):
    # The narrow face beside the wide one sees less than one texel of the picture.
    wide, thin = square(box(0, 0, 0.98, 1)), square(box(0.98, 0, 0.985, 1), (1, 0))
    side = [(wide[1][0], (0.98, 1)), (thin[1][0], (0.9801, 0.5)), (wide[2][0], (0.98, 0))]
    picture = function(lambda u, v: (120 + 120 * sin(9 * u + 4 * v), 120 + 100 * cos(7 * v), 60 + 150 * u), 64)
    cases["exponents_0_and_6"] = ("Vertex colors beside a face of the finest grid: one edge, two densities",
                                  model(*soup([wide, side]), picture),
                                  {"/materials/0/exponents": [1, 0, 0, 0, 0, 0, 2], **cuts(0, 0)})
    for name, scale, shift in (("far_away", 1, 1e6), ("tiny", 1e-6, 0)):
        position = lambda u, v: (u * scale + shift, v * scale - shift, shift)
        files = model(*sheet(4, 4, position, lambda u, v: (u, v)), ramp())
        cases[f"scale_{name}"] = (f"A sheet of size {scale:g} at {shift:g}", files,
                                  {"/materials/0/faces": 32, "/materials/0/pairs": 16, **cuts(0, 0)})


def add(cases):
    for group in (wrap, transforms, seams, palette, shared_edges, shapes, fans, exponents):
        group(cases)
