"""Faces of bad shape, and edges and vertices with many faces."""

from math import cos, pi, sin

from document import sheet, soup
from models import WELDED, checkers, halves, polygons
from pictures import function
from surfaces import box, model, square

CORNERS = [(0, 1), (1, 1), (1, 0), (0, 0)]


def quad(points):
    return list(zip(points, CORNERS))


def faces(cases):
    beside = square(box(0, 0, 1, 1), (1, 0))

    def add(name, purpose, points, expect=None):
        both = polygons([quad(points), beside], halves(8))
        cases[name] = (purpose, both, {"/standard/quads": 2, **(expect or {})}, WELDED)

    no_area = {"/standard/warnings/zero_area_face": 1}
    add("quad_on_a_line", "A quad whose corners lie on one line", [(1, 0, 0), (1, 1, 0), (1, 0.5, 0), (1, 0.25, 0)], no_area)
    add("quad_at_a_point", "A quad whose corners are one point", [(1, 0, 0)] * 4,
        {"/standard/quads": 1, "/standard/warnings/zero_area_face": 2})
    add("quad_folded", "A quad whose two halves lie on each other", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (1, 0, 0)])
    add("quad_crossing_itself", "A quad whose two sides cross", [(0, 0, 0), (1, 1, 0), (1, 0, 0), (0, 1, 0)])
    add("quad_concave", "A quad with a corner that points in", [(0, 0, 0), (1, 0, 0), (0.4, 0.4, 0), (0, 1, 0)])
    add("quad_bent", "A quad whose corners lie in no plane", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 3)])
    ring = [(cos(pi * k / 3), sin(pi * k / 3), 0) for k in range(7)]
    pole = [[(ring[k], (k / 6, 1)), (ring[k + 1], ((k + 1) / 6, 1)), ((0, 0, 1), ((k + 1) / 6, 0)), ((0, 0, 1), (k / 6, 0))]
            for k in range(6)]
    waves = function(lambda u, v: (127 + 127 * cos(2 * pi * u), 255 * v, 127 + 127 * cos(pi * (4 * u + v))))
    cases["quads_at_a_pole"] = ("Quads around a point, each with a side of no length there, as of a sphere", polygons(pole, waves),
                                {"/standard/quads": 0, "/standard/warnings/zero_area_face": 6}, WELDED)
    strip = [quad([(k, 0, 0), (k + 1, 0, 0), (k + 1, 1e-6, 0), (k, 1e-6, 0)]) for k in range(3)]
    cases["needle_quads"] = ("Quads a million times as long as wide", polygons(strip, halves(8)), {"/standard/quads": 3},
                             {"resolution": "fixed:2", **WELDED})
    needles = [[((0, 0, 0), (0, 0)), ((1, 0, 0), (1, 0)), ((0.5, 1e-6, 0), (0.5, 1))],
               [((1, 0, 0), (1, 0)), ((0, 0, 0), (0, 0)), ((0.5, -1e-6, 0), (0.5, 1))],
               [((1, 0, 0), (1, 0)), ((0.5, 1e-6, 0), (0.5, 1)), ((1, 1, 0), (1, 1))]]
    cases["needle_triangles"] = ("Triangles a million times as long as wide, beside one that is not",
                                 model(*soup(needles), halves(8)), {"/standard/faces": 3}, {"resolution": "fixed:3", **WELDED})


def fans(cases):
    for valence in (3, 4, 1000):
        around = [2 * pi * k / valence for k in range(valence)]
        vertices = [((0, 0, 0.3), (0.5, 0.5))]
        vertices += [((cos(a), sin(a), 0), (0.5 + 0.5 * cos(a), 0.5 + 0.5 * sin(a))) for a in around]
        indices = [index for k in range(valence) for index in (0, 1 + k, 1 + (k + 1) % valence)]
        cases[f"valence_{valence}"] = (f"A cone of {valence} faces around one vertex, black and white",
                                       model(vertices, indices, halves(16)), {"/standard/faces": valence}, WELDED)


def shared_edges(cases):
    for count in (3, 5):
        wings = []
        for k in range(count):
            x, y = cos(2 * pi * k / count), sin(2 * pi * k / count)
            wings.append(list(zip([(0, 0, 0), (x, y, 0), (x, y, 1), (0, 0, 1)],
                                  [(0, 1), (0.2 + k / 7, 1), (0.2 + k / 7, 0), (0, 0)])))
        cases[f"edge_of_{count}_faces"] = (f"{count} faces at one edge, black and white", model(*soup(wings), halves(16)),
                                           {"/standard/faces": 2 * count}, WELDED)

    def half_turn(u, v):
        along, across = 2 * pi * u, (v - 0.5) * 0.6
        radius = 1 + across * cos(along / 2)
        return (radius * cos(along), radius * sin(along), across * sin(along / 2))

    vertices, indices = sheet(6, 2, half_turn, lambda u, v: (u, v))
    for row in range(3):
        at, start = row * 7 + 6, (2 - row) * 7
        vertices[at] = (vertices[start][0], vertices[at][1])
    cases["moebius_strip"] = ("A strip with one side, black and white", model(vertices, indices, halves(16)),
                              {"/standard/faces": 24}, WELDED)
    unit = square(box(0, 0, 1, 1))
    back = [unit[k] for k in (0, 3, 2, 1)]
    cases["sheets_back_to_back"] = ("Two sheets at one place that face away from each other, black and white",
                                    model(*soup([unit, back]), halves(8)), {"/standard/faces": 4}, WELDED)
    for count in (2, 3):
        cases[f"face_{count}_times"] = (f"One triangle {count} times", model(*soup([unit[:3]] * count), halves(8)),
                                        {"/standard/faces": count}, WELDED)


def pieces(cases):
    islands = [square(box(0, 0, 1, 1), (2 * (k % 8), 2 * (k // 8)))[:3] for k in range(64)]
    cases["all_boundary"] = ("Triangles of which no two meet", model(*soup(islands), checkers(8, 8)),
                             {"/standard/faces": 64, "/standard/cut_edges": 0})
    colors = function(lambda u, v: (255 if int(4 * u) % 2 else 0, 255 if int(4 * v) % 2 else 0, 255 * (int(4 * u) % 3) / 2), 16)
    corner = lambda x, y: box(x / 4 + 0.1, y / 4 + 0.1, x / 4 + 0.15, y / 4 + 0.15)
    odd = [square(corner((3 * k) % 4, (5 * k + k // 4) % 4), (k % 4, k // 4)) for k in range(16)]
    cases["all_cuts"] = ("Squares of which no two agree at their edge", model(*soup(odd), colors), {"/standard/cut_edges": 24},
                         {"cut": "0"})
    cases["single_triangle"] = ("Nothing but one triangle, black and white",
                                model(*soup([unit_triangle()]), checkers(8, 8)), {"/standard/faces": 1})
    chain = [square(box(k / 32, 0, (k + 1) / 32, 1), (k, 0)) for k in range(32)]
    cases["long_strip"] = ("A strip of 32 squares, 32 times as long as wide", model(*soup(chain), halves(32)),
                           {"/standard/faces": 64}, WELDED)
    side = range(6)
    step = [[((x + a, y + b, 0), ((x + a) / 6, (y + b) / 6)) for a, b in ((0, 0), (0, 1), (1, 1), (1, 0))] for x in side for y in side]
    triangles = [part for face in step for part in (face[:3], face[:1] + face[2:])]
    for name, faces in (("quads", step), ("triangles", triangles)):
        cases[f"black_and_white_{name}"] = (f"A sheet of {name} of one segment, black on one side and white on the other",
                                            polygons(faces, halves(32)), {"/standard/faces": len(faces)},
                                            {"resolution": "fixed:0", **WELDED})
    cases["bent_sheet"] = ("A sheet whose every vertex stands elsewhere, black and white",
                           model(*sheet(5, 5, lambda u, v: (u, v, sin(37 * u) * cos(53 * v)), lambda u, v: (u, v)), checkers(32, 32)),
                           {"/standard/faces": 50}, WELDED)


def neighbors(cases):
    """Faces that meet in ways that no tool should write, and all do."""
    unit = square(box(0, 0, 1, 1))
    right = square(box(0, 0, 1, 1), (1, 0))
    against = [right[k] for k in (0, 3, 2, 1)]
    cases["opposite_winding"] = ("Two squares that wind against each other", polygons([unit, against], halves(8)),
                                 {"/standard/quads": 2}, WELDED)
    short = lambda low: [((x, (low + y) / 2, z), (u, v)) for (x, y, z), (u, v) in right]
    cases["t_junction"] = ("A square beside two of half its height: no edge is shared",
                           polygons([unit, short(0), short(1)], halves(8)), {"/standard/quads": 3, "/standard/cut_edges": 0}, WELDED)
    gap = [((x + 1e-6, y, z), uv) for (x, y, z), uv in right]
    cases["nearly_welded"] = ("Two squares a millionth apart: they do not touch", polygons([unit, gap], halves(8)),
                              {"/standard/quads": 2, "/standard/cut_edges": 0}, WELDED)


def unit_triangle():
    return list(zip([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1), (1, 1), (0, 0)]))


def add(cases):
    for group in (faces, fans, shared_edges, pieces, neighbors):
        group(cases)
