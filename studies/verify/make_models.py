#!/usr/bin/env python3
"""Surfaces (.obj) and second-order meshes (.msh) of the bodies that `lithe verify` compares methods on.

Each body is a few mapped blocks: the outer faces of fine blocks are the surface that dg and staggered cut, coarse
blocks with curved edges are the elements of cg. Run it in this folder; it writes the same files every time.
"""
import itertools
import math

# order of Gmsh's 27-node hexahedron, places 0..2 along the three axes
CORNERS = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2)]
EDGES = [(0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 7), (5, 6), (6, 7)]
FACES = [(1, 1, 0), (1, 0, 1), (0, 1, 1), (2, 1, 1), (1, 2, 1), (1, 1, 2)]
NODES = CORNERS + [tuple((CORNERS[a][i] + CORNERS[b][i]) // 2 for i in range(3)) for a, b in EDGES] + FACES + [(1, 1, 1)]


class Points:
    """Places with numbers; equal ones have one."""

    def __init__(self):
        self.number, self.places = {}, []

    def add(self, x):
        key = tuple(round(v * 1e9) for v in x)
        if key not in self.number:
            self.number[key] = len(self.places)
            self.places.append(x)
        return self.number[key]


def write_mesh(name, blocks, n):
    """blocks: maps from the unit cube; n: elements along its axes."""
    points, elements = Points(), []
    for block in blocks:
        for cell in itertools.product(*map(range, n)):
            elements.append([points.add(block(*[(c + q / 2) / m for c, q, m in zip(cell, node, n)])) for node in NODES])
    with open(name, "w") as out:
        out.write("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%d\n" % len(points.places))
        for i, x in enumerate(points.places):
            out.write("%d %.12g %.12g %.12g\n" % (i + 1, *x))
        out.write("$EndNodes\n$Elements\n%d\n" % len(elements))
        for i, nodes in enumerate(elements):
            out.write("%d 12 2 1 1 %s\n" % (i + 1, " ".join(str(k + 1) for k in nodes)))
        out.write("$EndElements\n")


def write_surface(name, blocks, n):
    """Outer faces of the blocks: those that belong to one cell alone."""
    points, faces = Points(), {}
    for block in blocks:
        for cell in itertools.product(*map(range, n)):
            for axis in range(3):
                for side in (0, 1):
                    ring = [(0, 0), (1, 0), (1, 1), (0, 1)] if side else [(0, 0), (0, 1), (1, 1), (1, 0)]
                    corners = []
                    for a, b in ring:
                        at = list(cell)
                        at[axis] += side
                        at[(axis + 1) % 3] += a
                        at[(axis + 2) % 3] += b
                        corners.append(points.add(block(*[c / m for c, m in zip(at, n)])))
                    key = tuple(sorted(corners))
                    faces[key] = None if key in faces else corners
    kept = [f for f in faces.values() if f]
    used = sorted({k for f in kept for k in f})
    number = {k: i + 1 for i, k in enumerate(used)}
    with open(name, "w") as out:
        for k in used:
            out.write("v %.12g %.12g %.12g\n" % tuple(points.places[k]))
        for f in kept:
            out.write("f %s\n" % " ".join(str(number[k]) for k in f))


def cylinder(r, t, z):
    angle = math.pi / 2 * t
    return ((1 + r) * math.cos(angle), (1 + r) * math.sin(angle), z / 2)


def plate(half):
    """From the hole of radius 1 to the sides of a square of 4, in two halves; grading towards the hole."""

    def block(r, t, z):
        angle = math.pi / 4 * (t + half)
        outer = (4, 4 * math.tan(angle)) if half == 0 else (4 / math.tan(angle), 4)
        s = r * (0.4 + 0.6 * r)
        return tuple((1 - s) * a + s * b for a, b in zip((math.cos(angle), math.sin(angle)), outer)) + (z / 2,)

    return block


def sphere(corner):
    """The third of an octant around an axis: a quadrilateral on the sphere, from radius 1 to 2."""
    axes = [[1.0 if i == (corner + k) % 3 else 0.0 for i in range(3)] for k in range(3)]
    middle = [sum(axis[i] for axis in axes) / 3 for i in range(3)]

    def block(a, b, r):
        sides = [[(p + q) / 2 for p, q in zip(axes[0], axes[k])] for k in (1, 2)]
        x = [(1 - a) * (1 - b) * axes[0][i] + a * (1 - b) * sides[0][i] + a * b * middle[i] + (1 - a) * b * sides[1][i]
             for i in range(3)]
        length = math.sqrt(sum(v * v for v in x))
        return tuple((1 + r) * v / length for v in x)

    return block


def write(name, blocks, coarse, surface):
    write_surface(name + ".obj", blocks, surface)
    for k in (1, 2):
        write_mesh("%s-%d.msh" % (name, k), blocks, [k * n for n in coarse])


write("cylinder", [cylinder], (2, 3, 1), (4, 96, 2))
write("plate", [plate(0), plate(1)], (3, 2, 1), (12, 32, 2))
write("sphere", [sphere(0), sphere(1), sphere(2)], (2, 2, 2), (24, 24, 4))
