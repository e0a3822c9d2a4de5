"""Positions and texture coordinates at the ends of what numbers can say, and grids of very different density."""

from math import inf, nan

from document import sheet, soup
from models import WELDED, at_texel, checkers, error, halves, polygons
from pictures import function, ramp
from surfaces import box, model, square

UV = lambda u, v: (u, v)


def densities(cases):
    ramps = function(lambda u, v: (255 * u, 255 * v, 255 * (int(16 * u + 16 * v) % 2)), 32)
    wide, thin = square(box(0, 0, 1, 1)), (1.00001, 0.5)
    side = [(wide[1][0], (1, 1)), ((1.02, 0.5, 0), thin), (wide[2][0], (1, 0))]
    cases["exponents_0_and_8"] = ("Vertex colors beside a face of 256 segments a side", model(*soup([wide, side]), ramps),
                                  {"/standard/exponents": [1, 0, 0, 0, 0, 0, 0, 0, 2]}, {"resolution": "area:64", **WELDED})
    # The coarse quads see single texels: black on one side of the sheet, white on the other.
    whole = {(2, 2): (0, 0), (3, 2): (1, 0), (3, 3): (1, 1), (2, 3): (0, 1)}
    faces = []
    for x, y in [(x, y) for y in range(5) for x in range(5)]:
        place = whole.get if (x, y) == (2, 2) else lambda p: at_texel(int(sum(p) > 4), 0, 128)
        faces.append([((p[0], 5 - p[1], 0), place(p)) for p in [(x, y), (x, y + 1), (x + 1, y + 1), (x + 1, y)]])
    cases["dense_among_coarse"] = ("A quad of 128 segments a side in the middle of 24 of one segment",
                                   polygons(faces, checkers(128, 128)),
                                   {"/standard/exponents": [24, 0, 0, 0, 0, 0, 0, 1]}, WELDED)


def positions(cases):
    def add(name, purpose, position, expect=None):
        cases[name] = (purpose, model(*sheet(4, 4, position, UV), halves(16)), {"/standard/faces": 32, **(expect or {})},
                       WELDED)

    add("at_1e6", "A sheet of side 1 at a million", lambda u, v: (u + 1e6, v - 1e6, 1e6))
    add("of_size_1e6", "A sheet of side a million", lambda u, v: (u * 1e6, v * 1e6, 0))
    add("of_size_1e_minus_6", "A sheet of side a millionth", lambda u, v: (u * 1e-6, v * 1e-6, 0))
    add("of_size_1e_minus_20", "A sheet whose areas vanish in single precision", lambda u, v: (u * 1e-20, v * 1e-20, 0))
    add("of_denormal_size", "A sheet whose positions are denormal", lambda u, v: (u * 1e-41, v * 1e-41, 0))
    add("of_size_1e9", "A sheet as large as allowed", lambda u, v: (u * 1e9, v * 1e9, 0))
    add("welded_to_a_line", "A sheet at a billion whose vertices fall together", lambda u, v: (9e8 + u, v, 0))
    huge, tiny = square(box(0, 0, 1, 1)), square(box(0, 0, 1, 1), (3, 0))
    faces = [[((x * 1e6, y * 1e6, z), uv) for (x, y, z), uv in huge], [((x * 1e-6, y * 1e-6, z), uv) for (x, y, z), uv in tiny]]
    cases["tiny_part_in_a_huge_scene"] = ("A square of a millionth beside one of a million",
                                          model(*soup(faces), halves(16)), {"/standard/faces": 4}, WELDED)
    for name, value in (("nan", nan), ("infinite", inf)):
        points = [((value, 0, 0), (0, 0)), ((1, 0, 0), (1, 0)), ((0, 1, 0), (0, 1))]
        cases[f"position_{name}"] = (f"A position that is {value}", model(points, [0, 1, 2], ramp(8)),
                                     error("invalid_model", "finite", "/accessors/0"))
    text = b"mtllib paint.mtl\nusemtl paint\nv 0 0 0\nv 1 nan 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n"
    files = polygons([square(box(0, 0, 1, 1))], ramp(8))
    cases["obj_position_nan"] = ("The same in OBJ", {**files, "model.obj": text}, error("invalid_model", "nan", "model.obj:4"))
    cases["position_too_far"] = ("A position beyond a billion",
                                 model([((2e9, 0, 0), (0, 0)), ((1, 0, 0), (1, 0)), ((0, 1, 0), (0, 1))], [0, 1, 2], ramp(8)),
                                 error("invalid_model", "1e9", "/accessors/0"))


def coordinates(cases):
    def add(name, purpose, places, expect, options=None):
        beside = square(box(0, 0, 1, 1), (1, 0))
        files = model(*soup([square(places), beside]), halves(8))
        cases[name] = (purpose, files, expect, options or WELDED)

    add("uv_nan", "A texture coordinate that is not a number", [(nan, 0), (1, 0), (1, 1), (0, 1)],
        error("invalid_model", "finite", "/accessors/1"))
    add("uv_infinite", "A texture coordinate without end", [(-inf, 0), (1, 0), (1, 1), (0, 1)],
        error("invalid_model", "finite", "/accessors/1"))
    add("uv_too_far", "A texture coordinate beyond a million", [(2e6, 0), (1, 0), (1, 1), (0, 1)],
        error("invalid_model", "1e6", "/accessors/1"))
    add("uv_huge", "Texture coordinates that span the most that is allowed and small shares of it",
        [(9e5, 9e5), (9e5 + 1, 9e5), (9e5 + 1, 9e5 + 1), (9e5, 9e5 + 1)], {"/standard/faces": 4})
    add("uv_span_huge", "A face over ten thousand repetitions of the picture", [(0, 1e4), (1e4, 1e4), (1e4, 0), (0, 0)],
        {"/standard/faces": 4}, {"resolution": "fixed:3", **WELDED})
    add("uv_constant", "A face that sees one point of the picture", [(0.3, 0.4)] * 4, {"/standard/exponents": [2, 0, 0, 2]})
    add("uv_on_a_line", "A face that sees a line of the picture", [(0, 0), (0.5, 0), (1, 0), (0.7, 0)],
        {"/standard/exponents": [2, 0, 0, 2]})


def add(cases):
    for group in (densities, positions, coordinates):
        group(cases)
