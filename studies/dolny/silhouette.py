#!/usr/bin/env python3
"""The outline of the Stanford bunny seen from the side, as a polygon for bunny.yaml.

usage: silhouette.py [/usr/share/glmark2/models/bunny.obj]

Projects all triangles along z onto pixels, fills small holes, walks around the largest piece, drops points that lie within
a pixel of the line between their neighbours (Douglas and Peucker 1973), and prints the polygon, 1 m tall, standing on y = 0.
"""
import sys

import numpy

PIXELS = 500


def read(path):
    points, faces = [], []
    for line in open(path):
        word = line.split()
        if word[:1] == ["v"]:
            points.append([float(x) for x in word[1:3]])
        elif word[:1] == ["f"]:
            ring = [int(w.split("/")[0]) - 1 for w in word[1:]]
            faces += [(ring[0], ring[i], ring[i + 1]) for i in range(1, len(ring) - 1)]
    return numpy.array(points), numpy.array(faces)


def fill(points, faces):
    low, high = points.min(0), points.max(0)
    scale = PIXELS / (high[1] - low[1])
    at = (points - low) * scale + 3
    image = numpy.zeros((PIXELS + 6, int((high[0] - low[0]) * scale) + 7), bool)
    for a, b, c in at[faces]:
        x0, y0 = numpy.floor(numpy.min([a, b, c], 0)).astype(int)
        x1, y1 = numpy.ceil(numpy.max([a, b, c], 0)).astype(int)
        y, x = numpy.mgrid[y0:y1 + 1, x0:x1 + 1]

        def side(p, q):
            return (q[0] - p[0]) * (y + .5 - p[1]) - (q[1] - p[1]) * (x + .5 - p[0])
        s = side(a, b), side(b, c), side(c, a)
        image[y0:y1 + 1, x0:x1 + 1] |= (numpy.min(s, 0) >= 0) | (numpy.max(s, 0) <= 0)
    return image


def walk(image):
    """Corners of the pixels around the first piece, counter-clockwise, by keeping material on the left."""
    y, x = numpy.argwhere(image)[0]
    start, at, step = (x, y), (x, y), (1, 0)
    ring = []
    while True:
        ring.append(at)
        for turn in (1, 0, -1):  # right first keeps diagonal pixels apart
            dx, dy = step if turn == 0 else (step[1] * turn, -step[0] * turn)
            left = at[1] + (dy + dx - 1) // 2, at[0] + (dx - dy - 1) // 2
            right = at[1] + (dy - dx - 1) // 2, at[0] + (dx + dy - 1) // 2
            if image[left] and not image[right]:
                step = dx, dy
                break
        at = at[0] + step[0], at[1] + step[1]
        if at == start:
            return numpy.array(ring, float)


def simplify(line, tolerance):
    if len(line) < 3:
        return [line[0]]
    a, d = line[0], line[-1] - line[0]
    length = numpy.hypot(*d)
    e = line - a
    off = numpy.abs(e[:, 0] * d[1] - e[:, 1] * d[0]) / length if length > 0 else numpy.hypot(e[:, 0], e[:, 1])
    i = int(off.argmax())
    if off[i] <= tolerance:
        return [line[0]]
    return simplify(line[:i + 1], tolerance) + simplify(line[i:], tolerance)


def main():
    points, faces = read(sys.argv[1] if len(sys.argv) > 1 else "/usr/share/glmark2/models/bunny.obj")
    ring = walk(fill(points, faces))
    half = len(ring) // 2
    ring = numpy.array(simplify(ring[:half + 1], 1.2) + simplify(numpy.vstack([ring[half:], ring[:1]]), 1.2))
    ring -= [ring[:, 0].mean(), ring[:, 1].min()]
    ring /= ring[:, 1].max()
    print(len(ring), "points", file=sys.stderr)
    print("[%s]" % ", ".join("[%.3f, %.3f]" % tuple(p) for p in ring))


main()
