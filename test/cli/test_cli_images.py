"""Bodies from images from outside: selected, placed, made of what their voxels say; broken files refused."""
import gzip
import json
import os
import struct

from cli import done, expect, folder, run

N = 12


def nifti(voxels, affine, kind="B", code=2, units=2):
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, N, N, N, 1, 1, 1, 1)
    struct.pack_into("<hh", header, 70, code, 8 * struct.calcsize(kind))
    struct.pack_into("<f", header, 108, 352)
    header[123] = units
    struct.pack_into("<h", header, 254, 1)
    struct.pack_into("<12f", header, 280, *affine)
    header[344:348] = b"n+1\0"
    return bytes(header) + struct.pack("<%d%s" % (N**3, kind), *voxels)


def voxels(value):
    return [value(i, j, k) for k in range(N) for j in range(N) for i in range(N)]


def block(i, j, k):
    """8 x 4 x 4 voxels of two tissues; one voxel apart from it."""
    if 2 <= i < 10 and 4 <= j < 8 and 4 <= k < 8:
        return 1 if i < 6 else 2
    return 3 if (i, j, k) == (0, 0, 0) else 0


SCENE = """lithe: 1
bodies:
  - name: block
    shape: {image: {file: block.nii.gz, labels: [1, 2]}, resolution: 1 mm}
    material:
      - {where: {label: 1}, young_modulus: 1 MPa, poisson_ratio: 0.3, density: "1000 + 500*label"}
      - {where: {label: 2}, young_modulus: 4 MPa, poisson_ratio: 0.3, density: "1000*value"}
    method: {kind: dg, cell_size: 10 mm}
    constraints:
      - {where: {plane: {point: [0.012, 0, 0], normal: [-1, 0, 0]}}, displacement: [0, 0, 0]}
gravity: [-1, 0, 0]
time: {kind: static}
output: {every: last, fields: [none]}
"""


def write(directory, name, data):
    with open(os.path.join(directory, name), "wb") as file:
        file.write(data)


def reads(directory, *args):
    return run("check", "block.yaml", *[x for a in args for x in ("--set", a)], cwd=directory)


with folder() as d:
    straight = [5, 0, 0, 0, 0, 5, 0, 0, 0, 0, 5, 0]  # 5 mm, centres at whole multiples
    write(d, "block.nii.gz", gzip.compress(nifti(voxels(block), straight)))
    write(d, "block.yaml", SCENE.encode())
    got = run("run", "block.yaml", "--json", "-o", "result", cwd=d)
    expect("a_labelled_image_runs", got.returncode == 0, got.stderr)
    result = json.loads(got.stdout)
    body = result["bodies"][0]
    # 40 x 20 x 20 mm less bevelled edges: at most h^2 / 8 along 320 mm, h = 5 mm, and the corners
    volume = 40 * 20 * 20e-9
    lost = 320e-3 * 5e-3**2 / 8 + 8 * 5e-3**3 / 12
    expect("its_volume_is_that_of_the_voxels", volume - lost - 1e-7 < body["volume"] < volume + 1e-8, body["volume"])
    weight = result["reaction"]["bodies.0.constraints.0"][0]
    # densities 1500 and about 2000 (value is linear between voxels, so less near the surface)
    expect("label_and_value_make_the_density", 1.2 < weight / body["volume"] / 1000 < 1.75, weight / body["volume"])

    turned = [0, -5, 0, 100, 5, 0, 0, 200, 0, 2, 5, 300]  # a quarter turn about z, sheared
    write(d, "turned.nii", nifti(voxels(lambda i, j, k: float(block(i, j, k))), turned, "f", 16))
    got = run("mesh", "block.yaml", "--json", "-o", "m.vtu", "--set", "bodies.0.shape.image.file=turned.nii", cwd=d)
    expect("a_turned_image_has_the_same_volume", got.returncode == 0 and
           abs(json.loads(got.stdout)["volume"] - body["volume"]) < 0.03 * volume, got.stderr + got.stdout)
    got = run("run", "block.yaml", "--json", "-o", "turned", "--set", "bodies.0.shape.image.file=turned.nii", "--set",
              "bodies.0.constraints.0.where={plane: {point: [0, 0.212, 0], normal: [0, -1, 0]}}", cwd=d)
    expect("it_lies_where_its_header_says", got.returncode == 0, got.stderr)

    got = reads(d, "bodies.0.shape.image={file: block.nii.gz, threshold: 0.5}", "bodies.0.material={young_modulus: 1, "
                "poisson_ratio: 0, density: 1}")
    expect("islands_are_told", got.returncode == 0 and "it shows 2 islands of 1, 128 voxels" in got.stderr + got.stdout,
           got.stderr + got.stdout)
    got = reads(d, "bodies.0.shape.image={file: block.nii.gz, threshold: 0.5, islands: keep-largest}",
                "bodies.0.material={young_modulus: 1, poisson_ratio: 0, density: 1}")
    expect("all_but_the_largest_can_be_left_out", got.returncode == 0 and "only the largest is kept" in
           got.stderr + got.stdout, got.stderr + got.stdout)

    got = reads(d, "bodies.0.shape.image={file: block.nii.gz, threshold: 0.5, islands: remove-free}",
                "bodies.0.material={young_modulus: 1, poisson_ratio: 0, density: 1}",
                "bodies.0.constraints.0.where={label: 2}")
    expect("islands_that_nothing_holds_can_be_left_out", got.returncode == 0 and
           "1 of 2 islands (1 voxels, 1 in all) are held by no constraint" in got.stderr + got.stdout,
           got.stderr + got.stdout)
    got = reads(d, "bodies.0.shape.image={file: block.nii.gz, threshold: 0.5, islands: remove-free}",
                "bodies.0.material={young_modulus: 1, poisson_ratio: 0, density: 1}", "bodies.0.constraints=[]")
    expect("one_island_has_to_be_held", got.returncode == 2 and "no constraint holds any of the 2 islands" in got.stderr,
           got.stderr)

    for name, change, says in (
            ("a_threshold_out_of_range_says_the_range", "bodies.0.shape.image={file: block.nii.gz, threshold: 9}",
             "image.threshold: no voxel is above the threshold of 9: values are from 0 to 3"),
            ("a_label_that_is_nowhere_is_told", "bodies.0.shape.image.labels=[8]", "no voxel has the label 8"),
            ("a_label_of_a_selection_too", "bodies.0.material.0.where.label=9", "no voxel of the image has this label"),
            ("threshold_and_labels_exclude_each_other", "bodies.0.shape.image.threshold=1",
             "got both of threshold and labels"),
            ("value_needs_an_image", "bodies.0.shape={sphere: {center: [0, 0, 0], radius: 0.1}}",
             "value and label are known only in bodies made from images"),
            ("a_picture_is_no_volume", "bodies.0.shape.image.file=block.yaml", "no kind of volume is known")):
        got = reads(d, change)
        expect(name, got.returncode == 2 and says in got.stderr, got.stderr)
    write(d, "short.nii", nifti(voxels(block), straight)[:-100])
    got = reads(d, "bodies.0.shape.image.file=short.nii")
    expect("a_short_file_is_told", got.returncode == 2 and "short.nii: its data end too early, got 1628 bytes; "
           "expected 1728 for 12 x 12 x 12 voxels of 1 bytes" in got.stderr, got.stderr)

done()
