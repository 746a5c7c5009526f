"""Scenes in two dimensions from outside: masks and shapes, and what is refused in them."""
import json
import os
import struct
import zlib

from cli import done, expect, folder, run

SCENE = """lithe: 1
dimension: 2
bodies:
  - name: plate
    shape: {image: {file: mask.png, threshold: 100, spacing: [1 cm, 1 cm]}}
    material: {model: linear, young_modulus: "1e6*value", poisson_ratio: 0.3}
    method: {kind: staggered, cell_size: 5 mm}
    constraints:
      - {where: {box: {min: [0, 0], max: [1, 0.01]}}, displacement: [0, 0]}
      - {where: {box: {min: [0, 0.025], max: [1, 1]}}, displacement: [0, -0.1 mm]}
    loads:
      - {body_force: [0, 0]}
output: {fields: [none]}
"""


def chunk(name, data):
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


def png(rows):
    header = struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, 0, 0, 0, 0)
    data = b"".join(b"\0" + bytes(row) for row in rows)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(data)) + chunk(b"IEND", b""))


def write(directory, name, data):
    with open(os.path.join(directory, name), "wb") as file:
        file.write(data)


def checks(directory, *changes):
    return run("check", "plate.yaml", *[x for c in changes for x in ("--set", c)], cwd=directory)


with folder() as d:
    write(d, "plate.yaml", SCENE.encode())
    write(d, "mask.png", png([[0, 0, 0, 0], [0, 200, 0, 50], [0, 200, 200, 0], [0, 200, 150, 0]]))
    write(d, "cut.png", png([[255] * 40] * 40)[:60])
    write(d, "text.png", b"no picture")
    for name, change, says in (
            ("a_mask_that_is_cut_is_told", "bodies.0.shape.image.file=cut.png",
             "bodies.0.shape.image.file: ./cut.png: at byte "),
            ("what_is_no_picture_is_told", "bodies.0.shape.image.file=text.png", "no PNG image that can be read"),
            ("a_missing_mask_is_told", "bodies.0.shape.image.file=none.png", "cannot be read: No such file"),
            ("a_threshold_out_of_range_says_the_range", "bodies.0.shape.image.threshold=255",
             "no voxel is above the threshold of 255: values are from 0 to 200"),
            ("a_volume_is_no_mask", "bodies.0.shape.image.file=brain.nii.gz", "cannot be read"),
            ("a_mesh_is_refused", "bodies.0.shape={mesh: {file: bunny.obj}}",
             "bodies.0.shape.mesh: it is of scenes in three dimensions, got mesh in `dimension: 2`"),
            ("three_entries_are_refused", "bodies.0.loads.0.body_force=[0, 0, 1]",
             "bodies.0.loads.0.body_force: wrong length, got a list of 3; expected a list of 2 numbers [N/m^3]"),
            ("a_polygon_that_crosses_itself_is_told",
             "bodies.0.shape={polygon: [[0, 0], [3, 0], [0, 2], [4, 3]]}", "touches or crosses itself"),
            ("dg_is_refused", "bodies.0.method={kind: dg, cells: [4, 4]}",
             "bodies.0.method.kind: it works in three dimensions alone, got \"dg\"; expected staggered"),
            ("one_half_needs_mixed", "bodies.0.material={young_modulus: 1, poisson_ratio: 0.5}", None)):
        changes = [change] if says else [change, "bodies.0.method.formulation=displacement"]
        got = checks(d, *changes)
        expect(name, got.returncode == 2 and (says or "only the mixed formulation keeps volumes") in got.stderr,
               got.stderr)
    got = checks(d, "dimension=3")
    expect("a_mask_is_no_volume", got.returncode == 2 and "a flat image, got \"mask.png\" in three dimensions" in
           got.stderr, got.stderr)

    # five pixels of 1 cm, the upper end pushed down onto the base
    got = run("run", "plate.yaml", "--json", "-o", "result", cwd=d)
    expect("a_mask_runs", got.returncode == 0, got.stderr)
    result = json.loads(got.stdout) if got.returncode == 0 else {}
    body = result.get("bodies", [{}])[0]
    expect("its_area_is_that_of_its_pixels", abs(body.get("volume", 0) - 5e-4) < 1e-15, body)
    forces = [result.get("reaction", {}).get("bodies.0.constraints.%d" % i, [0, 0])[1] for i in range(2)]
    expect("the_base_carries_what_pushes", forces[0] > 0 and abs(sum(forces)) < 1e-9 * forces[0], forces)

SCENES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scenes")
with folder() as d:
    errors = []
    for cells in (16, 32):
        got = run("run", os.path.join(SCENES, "ring.yaml"), "--json", "-o", os.path.join(d, str(cells)), "--set",
                  "bodies.0.method.cells=%d" % cells, "--set", "output.fields=[none]")
        expect("the_ring_runs_on_%d_cells" % cells, got.returncode == 0, got.stderr)
        errors.append(json.loads(got.stdout)["error"]["l1"] if got.returncode == 0 else 1)
    expect("its_error_falls_with_the_square_of_the_cell", errors[0] > 3 * errors[1], errors)


# a bar under tension in the plane, all sides chosen as faces that grow along the boundary curve up to its corners
FACES = """lithe: 1
dimension: 2
bodies:
  - name: plate
    shape: {%s}
    material: {model: linear, young_modulus: 1 MPa, poisson_ratio: 0.3}
    method: {kind: staggered, cells: 20}
    constraints:
      - {where: {face: {at: [0, 0.2]}}, displacement: [0, null]}
      - {where: {face: {at: [0.5, 0]}}, displacement: {normal: 0}}
    loads:
      - {where: {face: {at: [1, 0.2]}}, traction: [1 kPa, 0]}
exact: {displacement: ["x*0.91e-3", "-y*0.39e-3"]}
time: {kind: static}
output: {every: last, fields: [none]}
"""
with folder() as d:
    for shape in ("box: {min: [0, 0], max: [1, 0.4]}", "polygon: [[[0, 0], [1, 0], [1, 0.4], [0, 0.4]]]"):
        write(d, "faces.yaml", (FACES % shape).encode())
        got = run("run", "faces.yaml", "-o", "faces", cwd=d)
        expect("faces_of_plane_shapes_are_held_and_loaded", got.returncode == 0, got.stderr)
        error = json.load(open(os.path.join(d, "faces", "result.json")))["error"]
        expect("with_the_exact_answer_%s" % shape[:3], error["linf"] < 1e-9 * 0.91e-3, error)
with folder() as d:
    cut = (FACES % "box: {min: [0, 0], max: [1, 0.4]}").replace("time:", "cuts: [{plane: {point: [0.5, 0], normal: [1, 0]}}]\ntime:")
    write(d, "cut.yaml", cut.encode())
    got = run("check", "cut.yaml", cwd=d)
    expect("cuts_are_refused_in_the_plane", got.returncode == 2 and "cuts.0: cuts need method dg, which bodies in the plane do not have" in
           got.stderr, got.stderr)
done()
