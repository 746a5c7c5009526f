#!/usr/bin/env python3
"""Draw bone-slice.png: a lateral slice of a vertebral body as a scanner might show it, made up but plausible.

Values are densities of bone mineral [mg/cm^3], one pixel is 0.1 mm. A cortical ring and end plates enclose
struts along the sides of Voronoi cells that are longer than wide, thicker where the load goes. Every run
gives the same pixels.
"""
import pathlib
import struct
import zlib

import numpy

WIDTH, HEIGHT = 300, 280  # pixels
PIXEL = 0.1  # mm
SEED = 7


def outline(x, y):
    """About the distance to the rim [mm], positive inside: a box of 27 x 26 mm with hollow sides and round corners."""
    side = 13.4 - 2.2 * (1 - (y / 13) ** 2) - numpy.abs(x)
    end = 13.0 - 0.8 * (1 - (x / 13.4) ** 2) - numpy.abs(y)
    return -numpy.log(numpy.exp(-2 * side) + numpy.exp(-2 * end)) / 2


def seeds(random):
    """Centres of the cells: a lattice of rows, shaken; tall cells in the middle, small ones near the ends."""
    points = []
    y = -15.0
    while y < 15:
        tall = 1.15 + 0.75 * (1 - min(abs(y) / 13, 1) ** 2)
        shift = random.uniform(0, 1)
        for i in range(-16, 17):
            points.append(((i + shift) * 1.0 + random.normal(0, 0.17), y + random.normal(0, 0.22) * tall))
        y += tall
    return numpy.array(points)


def nearest_two(x, y, points):
    """Distances to the nearest two centres in a metric that favours upright sides, and the nearest's number."""
    first = numpy.full(x.shape, numpy.inf)
    second = numpy.full(x.shape, numpy.inf)
    which = numpy.zeros(x.shape, dtype=int)
    for k, (px, py) in enumerate(points):
        d = numpy.hypot(x - px, 0.62 * (y - py))
        second = numpy.minimum(second, numpy.maximum(first, d))
        which = numpy.where(d < first, k, which)
        first = numpy.minimum(first, d)
    return first, second, which


def draw():
    random = numpy.random.RandomState(SEED)
    j, i = numpy.mgrid[0:HEIGHT, 0:WIDTH]
    x = (i + 0.5 - WIDTH / 2) * PIXEL
    y = (HEIGHT / 2 - j - 0.5) * PIXEL
    rim = outline(x, y)
    points = seeds(random)
    first, second, which = nearest_two(x, y, points)
    width = 0.155 + 0.05 * random.uniform(-1, 1, len(points))[which] + 0.05 * numpy.exp(-((x / 6) ** 2))
    strut = 1 / (1 + numpy.exp((second - first - width) / 0.03))
    shell = 1 / (1 + numpy.exp((rim - 0.55) / 0.05))
    bone = numpy.maximum(780 * strut * (0.9 + 0.2 * random.uniform(size=len(points))[which]), 1080 * shell)
    body = 1 / (1 + numpy.exp(-rim / 0.04))
    values = body * (numpy.maximum(bone, 90) + random.normal(0, 12, bone.shape))
    return (10 * numpy.clip(numpy.rint(values / 10), 0, 6000)).astype(">u2")


def chunk(name, data):
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


def write(path, pixels):
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    header = struct.pack(">IIBBBBB", pixels.shape[1], pixels.shape[0], 16, 0, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9))
                     + chunk(b"IEND", b""))


if __name__ == "__main__":
    write(pathlib.Path(__file__).with_name("bone-slice.png"), draw())
