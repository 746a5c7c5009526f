"""Meshes for tests, and writers of .msh and .inp files: a cube of hexahedra, wedges, pyramids and tetrahedra whose inner
quads are not planar, and a row of second-order elements."""
import random
import struct

# name: VTK cell type, Gmsh element type, deck type, corners, edges in VTK's order, faces with a node, body node
KINDS = {
    "tet4": (10, 4, "C3D4", 4, [], [], 0),
    "hex8": (12, 5, "C3D8", 8, [], [], 0),
    "wedge6": (13, 6, "C3D6", 6, [], [], 0),
    "pyramid5": (14, 7, "C3D5", 5, [], [], 0),
}
TET_EDGES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
HEX_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
WEDGE_EDGES = [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)]
PYRAMID_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)]
HEX_FACES = [(0, 3, 7, 4), (1, 2, 6, 5), (0, 1, 5, 4), (2, 3, 7, 6), (0, 1, 2, 3), (4, 5, 6, 7)]
WEDGE_FACES = [(0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)]
KINDS["tet10"] = (24, 11, "C3D10", 4, TET_EDGES, [], 0)
KINDS["hex20"] = (25, 17, "C3D20", 8, HEX_EDGES, [], 0)
KINDS["hex27"] = (29, 12, None, 8, HEX_EDGES, HEX_FACES, 1)
KINDS["wedge15"] = (26, 18, "C3D15", 6, WEDGE_EDGES, [], 0)
KINDS["wedge18"] = (32, 13, None, 6, WEDGE_EDGES, WEDGE_FACES, 0)
KINDS["pyramid13"] = (27, 19, None, 5, PYRAMID_EDGES, [], 0)

# Gmsh's reference manual, "Node ordering": edges and faces there, as pairs and quads of corners
GMSH_EDGES = {
    4: [(0, 1), (1, 2), (2, 0), (3, 0), (2, 3), (1, 3)],
    8: [(0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 7), (5, 6), (6, 7)],
    6: [(0, 1), (0, 2), (0, 3), (1, 2), (1, 4), (2, 5), (3, 4), (3, 5), (4, 5)],
    5: [(0, 1), (0, 3), (0, 4), (1, 2), (1, 4), (2, 3), (2, 4), (3, 4)],
}
GMSH_FACES = {
    8: [(0, 3, 2, 1), (0, 1, 5, 4), (0, 4, 7, 3), (1, 2, 6, 5), (2, 3, 7, 6), (4, 5, 6, 7)],
    6: [(0, 1, 4, 3), (0, 3, 5, 2), (1, 2, 5, 4)],
}


def mixed_mesh(n=3):
    """Points, cells (kind, points, label) and the triangles and quads of the side z = 0 (points)."""
    rng = random.Random(3)
    points, cells, floor = [], [], []
    number = {}
    for k in range(n + 1):
        for j in range(n + 1):
            for i in range(n + 1):
                at = [i, j, k]
                number[i, j, k] = len(points)
                # points of the cube's sides stay in them, so that its volume is one
                points.append([(x + (rng.uniform(-.2, .2) if 0 < x < n else 0)) / n for x in at])
    for k in range(n):
        for j in range(n):
            for i in range(n):
                p = [number[i + a, j + b, k + c] for c in (0, 1) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
                label = 1 + (i == n - 1)
                if (i, j) == (0, 0):
                    wedge = [p[1], p[3], p[0], p[5], p[7], p[4]]
                    cells.append(("tet4", [wedge[0], wedge[1], wedge[2], wedge[5]], label))
                    cells.append(("pyramid5", [wedge[0], wedge[3], wedge[4], wedge[1], wedge[5]], label))
                    cells.append(("wedge6", [p[1], p[2], p[3], p[5], p[6], p[7]], label))
                    if k == 0:
                        floor += [[p[1], p[3], p[0]], [p[1], p[2], p[3]]]
                    continue
                if k == 0:
                    floor.append(p[:4])
                if (i, j) == (1, 1):
                    middle = len(points)
                    points.append([sum(points[q][a] for q in p) / 8 for a in range(3)])
                    faces = [(0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7)]
                    for f in faces:  # turned outward here, inward as the base of a pyramid
                        cells.append(("pyramid5", [p[v] for v in reversed(f)] + [middle], label))
                else:
                    cells.append(("hex8", p, label))
    return points, cells, floor


CORNERS = {
    4: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
    8: [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]],
    6: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]],
    5: [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [.5, .5, 1]],
}
VOLUMES = {4: 1 / 6, 8: 1, 6: 1 / 2, 5: 1 / 3}


def second_order_mesh(kinds):
    """One element of each kind, side by side and sheared."""
    points, cells, volume = [], [], 0
    for place, kind in enumerate(kinds):
        n_corners, edges, faces, body = KINDS[kind][3:7]
        corners = [[x + .3 * y + 2 * place, y + .1 * z, z] for x, y, z in CORNERS[n_corners]]
        groups = [(c,) for c in range(n_corners)] + edges + faces + [tuple(range(n_corners))] * body
        first = len(points)
        points += [[sum(corners[c][a] for c in g) / len(g) for a in range(3)] for g in groups]
        cells.append((kind, list(range(first, len(points))), 1 + place % 2))
        volume += VOLUMES[n_corners]
    return points, cells, volume


def order_sum(points, cells):
    return sum((i + 1) * (points[p][0] + 2 * points[p][1] + 3 * points[p][2])
               for _, cell, _ in cells for i, p in enumerate(cell))


def gmsh_order(kind, cell):
    """The points of a cell given in VTK's order, in Gmsh's."""
    n_corners, edges, faces, body = KINDS[kind][3:7]
    at = {frozenset(g): cell[n_corners + i] for i, g in enumerate(list(edges) + list(faces))}
    result = cell[:n_corners]
    result = result + [at[frozenset(e)] for e in GMSH_EDGES[n_corners]] if edges else result
    result = result + [at[frozenset(f)] for f in GMSH_FACES[n_corners]] if faces else result
    return result + cell[len(cell) - body:] if body else result


class Msh:
    """Values of a Gmsh file, text or binary."""

    def __init__(self, path, binary, big=False):
        self.file = open(path, "wb")
        self.binary, self.order = binary, ">" if big else "<"

    def line(self, text):
        self.file.write((text + "\n").encode())

    def put(self, code, *values):
        if self.binary:
            self.file.write(struct.pack(self.order + code * len(values), *values))
        else:
            self.file.write((" ".join(repr(v) for v in values) + " ").encode())

    def end(self):
        self.file.write(b"" if self.binary else b"\n")


NAMES = '$PhysicalNames\n4\n2 7 "floor"\n3 1 "left part"\n3 2 "right part"\n0 9 "corner"\n$EndPhysicalNames'


def write_msh2(path, points, cells, floor, binary, big):
    """Numbers with gaps; elements of the right part also in group 5, which has no name, as Gmsh repeats them."""
    m = Msh(path, binary, big)
    m.line("$MeshFormat\n2.2 %d 8" % binary)
    if binary:
        m.put("i", 1)
        m.line("")
    m.line("$EndMeshFormat\n" + NAMES)
    m.line("$Nodes\n%d" % (len(points) + 1))
    for i, x in enumerate([[9., 9., 9.]] + points):  # a node that nothing uses
        m.put("i", 10 * i + 5)
        m.put("d", *map(float, x))
        m.end()
    m.line("$EndNodes\n$Elements")
    elements = [(15, [9, 1], [0])] if floor else []
    elements += [(2 if len(f) == 3 else 3, [7, 1], f) for f in floor]
    elements += [(KINDS[k][1], [mark, 1], gmsh_order(k, c)) for k, c, mark in cells]
    elements += [(KINDS[k][1], [5, 1], gmsh_order(k, c)) for k, c, mark in cells if mark == 2]
    m.line("%d" % len(elements))
    for i, (kind, tags, nodes) in enumerate(elements):
        nodes = [10 * p + 15 for p in nodes]
        if binary:
            m.put("i", kind, 1, len(tags), 3 * i + 2, *tags, *nodes)
        else:
            m.put("i", 3 * i + 2, kind, len(tags), *tags, *nodes)
        m.end()
    m.line("$EndElements\n$Comments\nanything $ at all\n$EndComments")
    m.file.close()


def write_msh4(path, points, cells, floor, binary, big):
    m = Msh(path, binary, big)
    m.line("$MeshFormat\n4.1 %d 8" % binary)
    if binary:
        m.put("i", 1)
        m.line("")
    m.line("$EndMeshFormat\n" + NAMES + "\n$Entities")
    box = [0., 0., 0., 1., 1., 1.]
    m.put("Q", 1, 0, 1, 2)
    m.end()
    m.put("i", 1), m.put("d", 0., 0., 0.), m.put("Q", 1), m.put("i", 9), m.end()
    m.put("i", 1), m.put("d", *box), m.put("Q", 1), m.put("i", -7), m.put("Q", 0), m.end()
    m.put("i", 1), m.put("d", *box), m.put("Q", 1), m.put("i", 1), m.put("Q", 1), m.put("i", 1), m.end()
    m.put("i", 2), m.put("d", *box), m.put("Q", 2), m.put("i", 2, 5), m.put("Q", 0), m.end()
    m.line("\n$EndEntities\n$Nodes")
    ids = [1000000 - 7 * i for i in range(len(points))]
    half = len(points) // 2
    m.put("Q", 2, len(points), min(ids), max(ids)), m.end()
    for dim, part in ((2, range(half)), (3, range(half, len(points)))):
        m.put("i", dim, 1, 1), m.put("Q", len(part)), m.end()  # parametric: as many more numbers as dimensions
        for i in part:
            m.put("Q", ids[i]), m.end()
        for i in part:
            m.put("d", *map(float, points[i])), m.put("d", *[.5] * dim), m.end()
    m.line("\n$EndNodes\n$Elements")
    blocks = [(0, 1, 15, [[0]])] if floor else []
    for n in (3, 4):
        if floor:
            blocks.append((2, 1, n - 1, [f for f in floor if len(f) == n]))
    for mark in (1, 2):
        for kind in sorted(set(k for k, _, _ in cells)):
            part = [gmsh_order(k, c) for k, c, w in cells if k == kind and w == mark]
            if part:
                blocks.append((3, mark, KINDS[kind][1], part))
    m.put("Q", len(blocks), sum(len(b[3]) for b in blocks), 1, 9999), m.end()
    number = 0
    for dim, tag, kind, part in blocks:
        m.put("i", dim, tag, kind), m.put("Q", len(part)), m.end()
        for nodes in part:
            number += 1
            m.put("Q", number, *[ids[p] for p in nodes]), m.end()
    m.line("\n$EndElements")
    m.file.close()


def write_inp(path, points, cells, floor):
    with open(path, "w") as f:
        f.write("** a deck\n*Heading\n anything\n*NODE, NSET=Nall\n")
        for i, x in enumerate(points):
            f.write("%d, %.17g, %.17g,%.17g\n" % ((2 * i + 1,) + tuple(x)))
        number = 0
        for kind in KINDS:
            for mark in (1, 2):
                part = [c for k, c, w in cells if k == kind and w == mark]
                if not part:
                    continue
                f.write("*element, type=%s, ELSET=%s\n" % (KINDS[kind][2].lower(), ["", "left", "Right"][mark]))
                for nodes in part:
                    number += 1
                    words = ["%d" % (2 * p + 1) for p in nodes]
                    f.write("%d, %s" % (number, ", ".join(words[:10])))
                    f.write((",\n " + ", ".join(words[10:]) if words[10:] else "") + "\n")
        f.write("*ELSET, ELSET=ALL, GENERATE\n1, %d\n*ELSET,ELSET=both\nLEFT, right\n" % number)
        bottom = sorted(set(2 * p + 1 for q in floor for p in q))
        f.write("*NSET, NSET=FLOOR\n")
        for i in range(0, len(bottom), 5):
            f.write(",".join("%d" % p for p in bottom[i:i + 5]) + ",\n")
        f.write("*STEP\n*STATIC\n*END STEP\n")
