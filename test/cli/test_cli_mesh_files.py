"""Meshes from files: exact on affine fields, groups by their names, and what is wrong said with file and line."""
import json
import os
import sys

from cli import check, done, expect, folder, run

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from mesh_files import mixed_mesh, write_inp, write_msh2, write_msh4  # noqa: E402

PATCH = """lithe: 1
bodies:
  - name: cube
    material: {model: linear, young_modulus: 1e6, poisson_ratio: 0.3}
    method: {kind: dg, mesh: {file: cube.msh}}
    constraints:
      - {where: all, displacement: ["0.01*x + 0.02*y", "0.03*z - 0.01*x", "0.005*x - 0.02*y + 0.01*z"]}
time: static
solver: {linear: cholesky}
exact: {displacement: ["0.01*x + 0.02*y", "0.03*z - 0.01*x", "0.005*x - 0.02*y + 0.01*z"]}
output: {every: last, fields: [vtu]}
"""

PULL = """lithe: 1
bodies:
  - name: cube
    material:
      - {where: {label: RIGHT PART}, young_modulus: 2e6, poisson_ratio: 0, density: 1000, model: linear}
      - {young_modulus: 1e6, poisson_ratio: 0, density: 1000, model: linear}
    method: {kind: dg, mesh: {file: cube.msh}, degree: 1}
    constraints:
      - {where: {label: floor}, displacement: [0, 0, 0]}
    loads:
      - {where: {and: [{label: 2}, {normal: [1, 0, 0], within: 1 deg}]}, total_force: [0, 0, 5]}
      - {where: {label: left part}, pressure: 1}
time: static
output: {every: last, fields: [vtu]}
"""


def write(directory, name, text):
    with open(os.path.join(directory, name), "w") as file:
        file.write(text)


def result(directory, *args):
    got = run("run", *args, "--json", cwd=directory)
    expect("run_ends_well", got.returncode == 0 and got.stderr == "", got.stderr)
    return json.loads(got.stdout)


def refuses(name, directory, scene, *parts, options=()):
    got = run("run", scene, "-o", "refused", *options, cwd=directory)
    found = got.returncode == 2 and all(part in got.stderr for part in parts)
    expect(name, found and not os.path.exists(os.path.join(directory, "refused")), (got.returncode, got.stderr))


with folder() as d:
    points, cells, floor = mixed_mesh()
    write_msh4(os.path.join(d, "cube.msh"), points, cells, floor, 1, False)
    write_msh2(os.path.join(d, "old.msh"), points, cells, floor, 0, False)
    write_inp(os.path.join(d, "cube.inp"), points, cells, floor)
    write(d, "patch.yaml", PATCH)
    write(d, "pull.yaml", PULL)

    for degree in ("1", "2"):
        for name in ("cube.msh", "cube.inp"):
            body = result(d, "patch.yaml", "--set", "bodies.0.method.degree=" + degree, "--set",
                          "bodies.0.method.mesh.file=" + name)
            error = body["error"]
            # the field is up to 0.04 large; penalties and a condition of some 1e4 stand between it and rounding
            expect("affine_fields_are_exact_on_mixed_elements", error["linf"] < 1e-9 * 0.04, (name, degree, error))
            expect("the_mesh_is_told", body["bodies"][0]["method"]["mesh"] == "file" and
                   body["bodies"][0]["elements"] == len(cells) and abs(body["bodies"][0]["volume"] - 1) < 1e-13,
                   body["bodies"][0])

    body = result(d, "patch.yaml", "--set", "bodies.0.method.kind=cg")
    expect("conforming_elements_are_exact_too", body["error"]["linf"] < 1e-9 * 0.04, body["error"])

    got = result(d, "pull.yaml")
    reaction = got["reaction"]["bodies.0.constraints.0"]
    # the pressure acts on the left part's share of the sides, whose edge on each is a polyline; not on the held floor
    def share(line, along):
        return sum((points[a][0] + points[b][0]) / 2 * (points[b][along] - points[a][along]) for a, b in zip(line, line[1:]))

    top = share([2 + 4 * j + 48 for j in range(4)], 1)
    front, back = share([2 + 16 * k for k in range(4)], 2), share([2 + 12 + 16 * k for k in range(4)], 2)
    want = [-1, back - front, top - 5]
    expect("reactions_balance_loads_on_groups", all(abs(a - b) < 1e-7 for a, b in zip(reaction, want)), (reaction, want))
    same = result(d, "pull.yaml", "--set", "bodies.0.method.mesh.file=old.msh")
    expect("both_versions_of_gmsh_give_the_same", abs(same["displacement"]["max"] - got["displacement"]["max"]) <
           1e-9 * got["displacement"]["max"], (same["displacement"], got["displacement"]))

    # a mesh that was written is a mesh that can be read
    expect("a_mesh_is_written", run("mesh", "patch.yaml", "-o", "again.vtu", cwd=d).returncode == 0)
    again = result(d, "patch.yaml", "--set", "bodies.0.method.mesh.file=again.vtu")
    expect("a_written_mesh_is_read_again", again["bodies"][0]["elements"] == len(cells) and
           again["error"]["linf"] < 1e-9 * 0.04, again)
    run("run", "patch.yaml", "-o", "moved", cwd=d)
    moved = result(d, "patch.yaml", "--set", "bodies.0.method.mesh.file=moved/fields_0000.vtu")
    # written as floats: 24 bits of place and displacement
    expect("written_fields_are_read_at_rest", moved["bodies"][0]["elements"] == len(cells) and
           abs(moved["bodies"][0]["volume"] - 1) < 1e-6 and moved["error"]["linf"] < 1e-6, moved)

    # place and unit; what is embedded is the boundary, or the shape where there is one
    small = result(d, "patch.yaml", "--set", "bodies.0.method.mesh.unit=mm", "--set",
                   "bodies.0.place={rotate: {axis: [0, 0, 1], angle: 30 deg}, translate: [0.5, 0, 0]}", "--set",
                   "bodies.0.embed={surface: shape}", "--set", "output.surface=[obj]", "-o", "small")
    expect("unit_and_place_apply", abs(small["bodies"][0]["volume"] - 1e-9) < 1e-20, small["bodies"][0])
    obj = open(os.path.join(d, "small", [n for n in sorted(os.listdir(os.path.join(d, "small"))) if n.endswith(".obj")][0]))
    lines = obj.read().splitlines()
    n_outer = sum(1 for p in points if any(x in (0, 1) for x in p))
    expect("the_boundary_is_embedded", sum(x.startswith("v ") for x in lines) == n_outer and
           sum(x.startswith("f ") for x in lines) >= 54, len(lines))
    got = run("check", "pull.yaml", cwd=d)
    expect("check_counts_the_elements", got.returncode == 0 and str(len(cells)) in got.stdout, got.stdout + got.stderr)

    write(d, "typo.yaml", PULL.replace("{label: floor}", "{label: flor}"))
    refuses("an_unknown_group_lists_those_there_are", d, "typo.yaml", "typo.yaml:9:25: bodies.0.constraints.0.where.label: "
            'no group of the mesh file, got "flor"; expected one of', "floor", "left part", "did you mean floor?")
    write(d, "box.yaml", PULL.replace("mesh: {file: cube.msh}", "mesh: hexahedra, cells: 2").replace(
        "    method", "    shape: {box: {min: [0, 0, 0], max: [1, 1, 1]}}\n    method"))
    refuses("a_box_has_no_groups", d, "box.yaml", "a group of a mesh file, and this body has none", "got \"floor\"")
    write(d, "cells.yaml", PATCH.replace("mesh: {file: cube.msh}", "mesh: {file: cube.msh}, cells: 8"))
    refuses("a_file_has_its_own_cells", d, "cells.yaml", "bodies.0.method.cells: the mesh is a file's, which has its own")
    write(d, "shape.yaml", PATCH.replace("mesh: {file: cube.msh}", "cells: 8"))
    refuses("without_a_file_there_is_a_shape", d, "shape.yaml", "bodies.0.shape: missing; expected a shape such as")
    text = open(os.path.join(d, "cube.inp")).read()
    write(d, "short.inp", text[:text.index("*ELSET")].rstrip()[:-8])
    write(d, "none.inp", "*HEADING\n")
    for name, part in (("short.inp", "short.inp:"), ("none.inp", "it has no volume elements"),
                       ("nowhere.msh", "cannot be read"), ("patch.yaml", "expected .msh (Gmsh), .vtu or .inp")):
        write(d, "bad.yaml", PATCH.replace("cube.msh", name))
        refuses("a_bad_file_is_named_" + name, d, "bad.yaml", "bad.yaml:5:37: bodies.0.method.mesh.file: ", part)

done()
