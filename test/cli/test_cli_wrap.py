"""Surfaces with defects from outside: refused with the remedy, wrapped where the scene says so."""
import json
import os

from cli import done, expect, folder, run

SCENE = """lithe: 1
bodies:
  - name: tub
    shape: {mesh: {file: FILE, repair: wrap}}
    material: {young_modulus: 1e6, poisson_ratio: 0.3, density: 1000}
    method: {kind: dg, cells: 4}
    constraints:
      - {where: {plane: {point: [0, 0, 0], normal: [0, -1, 0]}}, displacement: [0, 0, 0]}
    embed: {surface: shape}
gravity: [0, -1, 0]
time: {kind: static}
output: {every: last, fields: [none], surface: [obj]}
"""

CORNERS = "".join("v %d %d %d\n" % (x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1))
SIDES = ["1 3 4 2", "1 2 6 5", "2 4 8 6", "3 1 5 7", "5 6 8 7"]  # y = 1 is open


def box(sides, shift=0):
    corners = CORNERS if not shift else "".join(
        "v %g %g %g\n" % (x + shift, y + shift, z + shift) for z in (0, 1) for y in (0, 1) for x in (0, 1))
    return corners + "vt 0.25 0.5\n" + "".join(
        "f " + " ".join(corner + "/1" for corner in side.split()) + "\n" for side in sides)


def write(directory, name, text):
    with open(os.path.join(directory, name), "w") as file:
        file.write(text)


with folder() as d:
    write(d, "tub.obj", box(SIDES))
    write(d, "tub.yaml", SCENE.replace("FILE", "tub.obj"))
    got = run("run", "tub.yaml", "-o", "result", "--json", cwd=d, timeout=300)
    expect("a_box_without_lid_runs", got.returncode == 0, got.stderr)
    result = json.loads(got.stdout)
    # chamfers at a quarter of a cell: twelve edges lose at most h^2 / 2
    volume = result["bodies"][0]["volume"]
    expect("its_volume_is_that_of_the_box", 1 - 6 / 16**2 < volume < 1 + 1e-9, volume)
    told = [w for w in result["warnings"] if "winding number" in w]
    expect("the_result_says_what_was_wrong_and_how_large",
           told == ["tub.obj: wrapped where its winding number is one half; found 4 open edges around 1 holes "
                    "(the largest is 1.41 m across)"], result["warnings"])
    lines = open(os.path.join(d, "result", "surface_0000.obj")).read().splitlines()
    expect("the_embedded_surface_is_the_file_s_own",
           sum(line.startswith("v ") for line in lines) == 8 and sum(line.startswith("f ") for line in lines) == 5 and
           any(line.startswith("vt 0.25 0.5") for line in lines), lines[:20])

    got = run("check", "tub.yaml", "--set", "bodies.0.shape.mesh.repair=strict", cwd=d)
    expect("strict_names_the_remedy", got.returncode == 2 and "4 open edges" in got.stderr and
           "or write `repair: wrap` beside file" in got.stderr, got.stderr)
    got = run("check", "tub.yaml", "--set", "bodies.0.shape.mesh.repair=strict", "--set",
              "bodies.0.shape.mesh.resolution=0.1", cwd=d)
    expect("resolution_belongs_to_wrap", got.returncode == 2 and
           "bodies.0.shape.mesh.resolution: it goes with repair: wrap" in got.stderr, got.stderr)

    coarse = run("mesh", "tub.yaml", "--json", "-o", "m.vtu", "--set", "bodies.0.shape.mesh.resolution=0.25", cwd=d)
    fine = run("mesh", "tub.yaml", "--json", "-o", "m.vtu", "--set", "bodies.0.shape.mesh.resolution=0.02", cwd=d)
    volumes = [json.loads(text.stdout)["volume"] for text in (coarse, fine)]
    expect("a_finer_resolution_comes_nearer", volumes[0] < volume < volumes[1] and volumes[1] > 1 - 6 * 0.02**2, volumes)

    write(d, "whole.obj", box(SIDES + ["3 7 8 4"]))
    write(d, "whole.yaml", SCENE.replace("FILE", "whole.obj"))
    got = json.loads(run("run", "whole.yaml", "-o", "result", "--json", cwd=d).stdout)
    expect("a_file_without_defects_stays_as_it_is", abs(got["bodies"][0]["volume"] - 1) < 1e-12 and
           not got["warnings"], got["warnings"])

    two = box(SIDES + ["3 7 8 4"]).replace("vt 0.25 0.5\n", "")
    other = box([" ".join(str(int(c) + 8) for c in side.split()) for side in SIDES + ["3 7 8 4"]], 0.5)
    write(d, "two.obj", two.replace("/1", "") + other.replace("vt 0.25 0.5\n", "").replace("/1", ""))
    write(d, "two.yaml", SCENE.replace("FILE", "two.obj"))
    got = run("mesh", "two.yaml", "-o", "m.vtu", "--json", "--set", "bodies.0.shape.mesh.resolution=0.05", cwd=d)
    volume = json.loads(got.stdout)["volume"]
    expect("overlapping_boxes_are_united", abs(volume - 1.875) < 15 * 0.05**2 and
           "pairs of triangles that cross or overlap" in got.stderr + got.stdout, got.stdout)

done()
