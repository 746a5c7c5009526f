"""Shapes that cannot be used: every message names the place in the scene, what was found and what helps; status 2."""
import gzip
import json
import math
import os
import struct
import zlib

from cli import done, expect, folder, run

PLANE = """lithe: 1
dimension: 2
bodies:
  - name: b
    shape: {%s}
    material: {model: linear, young_modulus: 1000, poisson_ratio: 0.3, density: 1000}
    method: {kind: staggered, cells: 8}
    constraints:
      - {where: all, displacement: [0, 0]}
time: {kind: static}
output: {fields: none}
"""

SPACE = """lithe: 1
bodies:
  - name: b
    shape: {%s}
    material: {model: linear, young_modulus: 1000, poisson_ratio: %s, density: 1000}
    method: {kind: %s}
    constraints:
      - {where: all, displacement: [0, 0, 0]}
time: {kind: static}
output: {fields: none}
"""

BOX = "staggered, grid: {min: [-1, -1, -1], max: [1, 1, 1], cells: [8, 8, 8]}"


def nifti(voxels, n=(10, 10, 10), magic=b"n+1\0", kind=4):
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *n, 1, 1, 1, 1)
    struct.pack_into("<hh", header, 70, kind, 16)
    struct.pack_into("<8f", header, 76, 1, 1, 1, 1, 0, 0, 0, 0)
    struct.pack_into("<f", header, 108, 352)
    header[344:348] = magic
    return bytes(header) + voxels


def png(width, height, depth, colour, rows, more=b""):
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    head = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)
    body = b"".join(b"\0" + row for row in rows)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + more + chunk(b"IDAT", zlib.compress(body)) +
            chunk(b"IEND", b""))


voxels = b"".join(struct.pack("<h", 5 if all(2 <= (p // 10**a) % 10 < 8 for a in range(3)) else 0)
                  for p in range(1000))
NRRD = "NRRD0004\ntype: short\ndimension: 3\nsizes: 10 10 %d\nspacings: 1 1 1\nendian: little\nencoding: raw\n\n"
MHD = "ObjectType = Image\nNDims = 3\nDimSize = 10 10 10\nElementType = MET_SHORT\n%s"
files = {
    "ok.nii": nifti(voxels),
    "magic.nii": nifti(voxels, magic=b"abc\0"),
    "dims.nii": nifti(voxels, n=(-3, 10, 10)),
    "kind.nii": nifti(voxels, kind=1234),
    "short.nii": nifti(voxels[:500]),
    "head.nii": nifti(voxels)[:200],
    "cut.nii.gz": gzip.compress(nifti(os.urandom(2000)))[:900],
    "no.nii.gz": b"no gzip at all",
    "size.nrrd": (NRRD % 20).encode() + voxels,
    "gone.mhd": (MHD % "ElementDataFile = gone.raw\n").encode(),
    "none.mhd": (MHD % "").encode(),
    "nan.nii": nifti(struct.pack("<f", math.nan) * 1000, kind=16),
    "one.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    "black.png": png(8, 8, 8, 0, [bytes(8)] * 8),
    "cut.png": png(8, 8, 8, 0, [bytes(8)] * 8)[:50],
}


def image(file, select="threshold: 0.5"):
    return "image: {file: %s, %s%s}" % (file, select, ", spacing: [0.1, 0.1]" if "png" in file else "")


def space(shape, ratio="0.3", method=BOX):
    return SPACE % (shape, ratio, method)


def implicit(expression):
    return space('implicit: "%s"' % expression)


ball = "sphere: {center: [0, 0, 0], radius: 0.5}"
cases = [
    # polygons
    (PLANE % "polygon: [[0, 0], [1, 1], [1, 0], [0, 1]]",
     ["bad.yaml:5:", "bodies.0.shape.polygon", "crosses itself at about (0.5, 0.5)"]),
    (PLANE % "polygon: [[0, 0], [1, 1], [2, 2]]", ["loop 1 of the polygon has no area"]),
    (PLANE % "polygon: [[[0, 0], [1, 0], [1, 1], [0, 1]], [[2, 2], [3, 2], [3, 3]]]",
     ["loop 2 of the polygon is not inside the first", "a union of polygons"]),
    (PLANE % "polygon: [[[0, 0], [1, 0], [1, 1], [0, 1]], [[0.5, 0.5], [1.5, 0.5], [1.5, 0.7]]]",
     ["crosses itself at about (1, ", "loop 2"]),
    # masks and scans
    (PLANE % image("black.png"), ["image.threshold", "no voxel is above the threshold of 0.5: values are from 0 to 0"]),
    (PLANE % image("cut.png"), ["image.file", "the file ends too early"]),
    (space(image("ok.nii", "labels: [7]")), ["image.labels", "no voxel has the label 7: values are from 0 to 5"]),
    (space(image("nan.nii")), ["image.threshold", "no voxel has a value that is a number"]),
    (space("image: {file: ok.nii}"), ["got none of threshold and labels"]),
    (space(image("magic.nii")), ["no NIfTI-1 file", "n+1"]),
    (space(image("dims.nii")), ["-3 voxels along axis 1"]),
    (space(image("kind.nii")), ["values of type 1234 are not read"]),
    (space(image("short.nii")), ["its data end too early, got 500 bytes; expected 2000"]),
    (space(image("head.nii")), ["too short for a NIfTI-1 header, got 200 bytes"]),
    (space(image("cut.nii.gz")), ["its compressed data end too early", "the file is cut short"]),
    (space(image("no.nii.gz")), ["not compressed by gzip"]),
    (space(image("size.nrrd")), ["got 2000 bytes; expected 4000 for 10 x 10 x 20 voxels"]),
    (space(image("gone.mhd")), ["gone.raw", "No such file"]),
    (space(image("none.mhd")), ["without ElementDataFile"]),
    # surfaces
    (space("mesh: {file: one.obj, repair: wrap}", method="staggered, cells: 8"),
     ["bodies.0.shape: it is empty", "winds round no place by half"]),
    # expressions
    (implicit("log(x) + y^2 + z^2"), ["shape.implicit", "not a number everywhere in its box, got none at (-0.9"]),
    (implicit("x^2 - 0.25 + 0*sqrt(y)"), ["not a number everywhere in its box"]),
    (implicit("sqrt(-1)"), ["not a finite number"]),
    (implicit("1/0"), ["not a finite number"]),
    (implicit("1 + x^2"), ["bodies.0.shape", "nothing of the shape was found in the grid", "nowhere negative"]),
    # grids and methods
    (space(ball, method="staggered, grid: {min: [5, 5, 5], max: [6, 6, 6], cells: [8, 8, 8]}"),
     ["bodies.0.method.grid", "it misses the body, which reaches from (-0.5, -0.5, -0.5)"]),
    (space(ball, method="staggered, cells: 8, fraction: smooth"), ["bodies.0.method.fraction", "did you mean fractions"]),
    (space(ball, method="staggered, cells: 8, fractions: smoth"), ["did you mean smooth"]),
    (space(ball, method="staggered, cells: 8, fractions: {samples: 3}"), ["expected an even number"]),
    (space(ball, method="dg, cells: 4, fractions: smooth"),
     ["bodies.0.method.fractions", "it is of a staggered grid", "`kind: staggered`"]),
    (space(ball, method="cg, cells: 4, formulation: mixed"), ["bodies.0.method.formulation", "it is of a staggered grid"]),
    (space(ball, "0.5", "staggered, cells: 8").replace("model: linear, ", ""),
     ["bodies.0.material.poisson_ratio", "got 0.5 with model corotated", "`model: linear`"]),
    (space(ball, "0.5", "staggered, cells: 8, formulation: displacement"),
     ["bodies.0.material.poisson_ratio", "got 0.5", "`formulation: mixed`"]),
]

with folder() as d:
    for name, content in files.items():
        with open(os.path.join(d, name), "wb") as out:
            out.write(content)
    for text, parts in cases:
        with open(os.path.join(d, "bad.yaml"), "w") as out:
            out.write(text)
        got = run("run", "bad.yaml", "-o", "out", "--quiet", cwd=d)
        shape = text.split("shape: ")[1].split("\n")[0]
        told = "exit %d\n%s" % (got.returncode, got.stderr)
        expect("%s is refused" % shape, got.returncode == 2 and "bad.yaml" in got.stderr, told)
        for part in parts:
            expect("%s: %s" % (shape, part), part in got.stderr, told)

    # kinds of PNG: 16 bits, a palette, transparency; the same square of 4 x 4 pixels
    square = [[2 <= i < 6 and 2 <= j < 6 for i in range(8)] for j in range(8)]
    palette = struct.pack(">I", 6) + b"PLTE" + bytes([0, 0, 0, 255, 255, 255])
    palette += struct.pack(">I", zlib.crc32(palette[4:]))
    kinds = {
        "wide.png": png(8, 8, 16, 0, [b"".join(struct.pack(">H", 60000 * on) for on in row) for row in square]),
        "palette.png": png(8, 8, 8, 3, [bytes(row) for row in square], palette),
        "alpha.png": png(8, 8, 8, 6, [b"".join(bytes([255, 255, 255, 255 * on]) for on in row) for row in square]),
    }
    for name, content in kinds.items():
        with open(os.path.join(d, name), "wb") as out:
            out.write(content)
        with open(os.path.join(d, "good.yaml"), "w") as out:
            out.write(PLANE % image(name))
        got = run("run", "good.yaml", "-o", "out", "--json", "--quiet", cwd=d)
        expect("%s has its volume" % name, got.returncode == 0 and abs(json.loads(got.stdout)["bodies"][0]["volume"] - 0.16) < 1e-12,
               got.stderr + got.stdout)
done()
