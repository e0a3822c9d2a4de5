"""Black and white at the pitch of the samples, on every kind of block: where texels leave their range first."""

from document import flat, sheet, soup
from models import WELDED, at_texel, checkers, occlusion, polygons
from pictures import png
from surfaces import model


def fins(corners, depth):
    """Two quads at each edge of a triangle, so that each edge has three faces and no face a partner.
    `corners` are (position, texel) pairs; the quads are `depth` texels deep."""
    faces = []
    for k in range(3):
        (a, from_texel), (b, to_texel) = corners[k], corners[(k + 1) % 3]
        for up in (0.5, -0.5):
            raise_by = lambda point: (point[0], point[1], point[2] + up)
            deeper = lambda texel: (texel[0] + 3 * depth, texel[1] + depth)
            quad = [(a, from_texel), (b, to_texel), (raise_by(b), deeper(to_texel)), (raise_by(a), deeper(from_texel))]
            faces.append([(point, at_texel(*texel)) for point, texel in quad])
    return faces


def lone(n, count):
    """Lone triangles that share every edge."""
    faces = []
    for number in range(count):
        x = 3 * number
        # The first edge goes to the diagonal of the block; the texels along it are of one color, those beside of the other.
        corners = [((x + 1, 0, 0), (n, 0)), ((x, 1, 0), (0, n)), ((x, 0, 0), (0, 0))]
        faces.append([(point, at_texel(*texel)) for point, texel in corners])
        faces += fins(corners, n)
    return polygons(faces, checkers())


def squares(n, side=3):
    """Quads of n segments a side."""
    place = lambda x, y: ((x, side - y, 0), at_texel(x * n, y * n))
    cell = lambda x, y: [place(x, y), place(x, y + 1), place(x + 1, y + 1), place(x + 1, y)]
    return polygons([cell(x, y) for y in range(side) for x in range(side)], checkers())


def checkered(cases):
    kinds = {
        "quads": (squares, {"quads": 9, "pairs": 0, "lone": 0}),
        "pairs": (lambda n: model(*sheet(3, 3, flat, lambda u, v: at_texel(3 * n * u, 3 * n * v)), checkers()),
                  {"quads": 0, "pairs": 9, "lone": 0}),
        "lone": (lambda n: lone(n, 1), {"quads": 6, "pairs": 0, "lone": 1}),
        "twins": (lambda n: lone(n, 2), {"quads": 12, "pairs": 0, "lone": 2}),
    }
    for kind, (build, counts) in kinds.items():
        for r in range(4):
            expect = {f"/papers/{name}": count for name, count in counts.items()}
            cases[f"checkers_{kind}_{r}"] = (f"Checkers at sample pitch on {kind} of exponent {r}", build(2**r), expect,
                                             {"resolution": f"fixed:{r}", **WELDED})


def worst():
    # Fins of half the triangle's area make every edge sample weigh what an inner one does, and give each
    # edge three faces. Of the three inner samples one is white: the border texel beyond it asks for -1.
    height = 3**0.5 / 2
    points = [(0, 0, 0), (1, 0, 0), (0.5, height, 0)]
    middle = (0.5, height / 3, 0)
    texels = [(0, 0), (4, 0), (0, 4)]
    faces = [[(point, at_texel(*texel, 8)) for point, texel in zip(points, texels)]]
    black = at_texel(6, 6, 8)
    for k in range(3):
        a, b = points[k], points[(k + 1) % 3]
        half = [(p + q) / 2 for p, q in zip(a, b)]
        outward = tuple(h + (h - m) * 3 / 2 for h, m in zip(half, middle))
        for tip in (outward, (half[0], half[1], height / 2)):
            faces.append([(a, black), (b, black), (tip, black)])
    spot = png(8, 8, lambda x, y: (255,) if (x, y) == (2, 1) else (0,), kind=0)
    return faces, spot


def white_face(cases):
    faces, spot = worst()
    # A third of the range, to each of the three samples of the one rule that is broken.
    cases["white_face_black_edges"] = (
        "A white sample inside of a lone triangle among black edges: each of three samples gives a third",
        occlusion(*soup(faces), spot), {"/papers/lone": 7, "/papers/level_0/change_max": 85.0},
        {"resolution": "fixed:2", **WELDED})
    bright = png(8, 8, lambda x, y: (0,) if (x, y) == (2, 1) else (255,), kind=0)
    cases["black_face_white_edges"] = ("The same the other way round", occlusion(*soup(faces), bright),
                                       {"/papers/level_0/change_max": 85.0}, {"resolution": "fixed:2", **WELDED})


def add(cases):
    for group in (checkered, white_face):
        group(cases)
