"""Conforming elements from outside: the same scenes by --set, their meshes, what is refused."""
import json
import os

from cli import check, done, expect, folder, run

CG = ["--set", "bodies.0.method.kind=cg"]

BAR = """lithe: 1
bodies:
  - name: bar
    shape: {box: {min: [0, 0, 0], max: [4, 1, 1]}}
    material: {model: linear, young_modulus: 1000, poisson_ratio: 0.3, density: 1}
    method: {mesh: hexahedra, cells: [8, 2, 2], degree: 2}
    constraints:
      - {where: {normal: [-1, 0, 0]}, displacement: [0, 0, 0]}
gravity: [0, 0, -1]
time: static
output: {every: last, fields: [none]}
"""

STEEL = """lithe: 1
bodies:
  - name: beam
    shape: {box: {min: [0, 0, 0], max: [1, 0.1, 0.2]}}
    material: {model: linear, young_modulus: 210 GPa, poisson_ratio: 0.3}
    method: {kind: cg, cells: [10, 2, 2], degree: 2}
    place: {translate: %s}
    constraints:
      - {where: {normal: [-1, 0, 0]}, displacement: [0, 0, 0]}
    loads:
      - {where: {normal: [1, 0, 0]}, total_force: [0, 0, -500 N]}
time: static
output: {fields: none}
"""

BALL = """lithe: 1
bodies:
  - name: ball
    shape: {sphere: {center: [0, 0, 0], radius: 1}}
    material: {model: linear, young_modulus: 1000, poisson_ratio: 0.3, density: 1}
    method: {cells: 6}
    constraints:
      - {where: {plane: {point: [0, 0, -0.7], normal: [0, 0, -1]}}, displacement: [0, 0, 0]}
    loads:
      - {where: {plane: {point: [0, 0, 0.7], normal: [0, 0, 1]}}, total_force: [0, 0, 10]}
    embed: {surface: shape}
gravity: [0, 1, 0]
time: static
output: {every: last, fields: [none], surface: [ply]}
"""

PATCH = """lithe: 1
bodies:
  - name: block
    shape: {box: {min: [0, 0, 0], max: [1, 1, 1]}}
    material: {model: %s, young_modulus: 1000, poisson_ratio: 0.3}
    method: {kind: cg, mesh: %s, cells: 3, degree: %d}
    constraints:
      - {where: all, displacement: ["0.01*x + 0.02*y", "0.01*z", "-0.03*y"]%s}
time: static
solver: {tolerance: 1e-12, newton: {tolerance: 1e-12}}
exact: {displacement: ["0.01*x + 0.02*y", "0.01*z", "-0.03*y"]}
output: {every: last, fields: [none]}
"""

BAD = """lithe: 1
bodies:
  - name: ball
    shape: {sphere: {center: [0, 0, 0], radius: 1}}
    material: {young_modulus: 1000, poisson_ratio: 0.3}
    method: {kind: cg, cells: 4, mesh: %s, degree: %s}
time: static
"""


def write(directory, text, name="scene.yaml"):
    with open(os.path.join(directory, name), "w") as file:
        file.write(text)


def result(directory, *args):
    got = run("run", "scene.yaml", "--json", *args, cwd=directory)
    return json.loads(got.stdout) if got.returncode == 0 else got.stderr


with folder() as scratch:
    write(scratch, BAR)
    dg, cg = result(scratch), result(scratch, *CG)
    expect("both methods bend a cantilever alike",
           abs(cg["displacement"]["max"] / dg["displacement"]["max"] - 1) < 0.01,
           (cg["displacement"], dg["displacement"]))
    expect("held nodes carry the weight", abs(cg["reaction"]["bodies.0.constraints.0"][2] - 4) < 1e-6,
           cg["reaction"])
    expect("the result names the method", cg["bodies"][0]["method"] ==
           {"kind": "cg", "mesh": "hexahedra", "degree": 2, "element": "hex27"}, cg["bodies"][0])
    expect("unknowns are those of nodes", cg["bodies"][0]["dofs"] == 3 * 17 * 5 * 5, cg["bodies"][0])
    tips = {}
    for element in ("hex27", "hex20", "hex20r"):
        got = result(scratch, *CG, "--set", "bodies.0.method.element=" + element)
        tips[element] = got["displacement"]["max"]
    expect("elements of degree 2 differ a little and agree", len(set(tips.values())) == 3 and
           max(tips.values()) < 1.01 * min(tips.values()), tips)
    forecast = run("check", "scene.yaml", *CG, cwd=scratch)
    expect("a check counts the same unknowns", forecast.returncode == 0 and "1275" in forecast.stdout,
           forecast.stdout + forecast.stderr)

with folder() as scratch:
    write(scratch, STEEL % "[0, 0, 0]")
    here = result(scratch)
    write(scratch, STEEL % "[100, 50, -30]")
    there = result(scratch)
    expect("a stiff beam far from the origin bends as it does there", isinstance(there, dict) and
           abs(there["displacement"]["max"] / here["displacement"]["max"] - 1) < 1e-6, there)

with folder() as scratch:
    write(scratch, BALL)
    dg, voxels = result(scratch), result(scratch, *CG)
    embedded = result(scratch, *CG, "--set", "bodies.0.method.mesh=embedded")
    expect("voxels stand for a ball where nothing is said",
           voxels["bodies"][0]["method"]["mesh"] == "voxels", voxels["bodies"][0])
    expect("embedded keeps the volume of the slices",
           abs(embedded["bodies"][0]["volume"] / dg["bodies"][0]["volume"] - 1) < 1e-12,
           (embedded["bodies"][0], dg["bodies"][0]))
    expect("embedded pulls about as far as slices",
           0.7 < embedded["displacement"]["max"] / dg["displacement"]["max"] < 1.1,
           (embedded["displacement"], dg["displacement"]))
    for name, got in (("voxels", voxels), ("embedded", embedded)):
        weight, force = got["bodies"][0]["mass"], got["reaction"]["bodies.0.constraints.0"]
        expect("reactions of %s balance pull and weight" % name,
               abs(force[1] + weight) < 1e-6 and abs(force[2] + 10) < 1e-6, force)

for model in ("linear", "corotated"):
    for mesh, degree in (("hexahedra", 1), ("hexahedra", 2), ("tetrahedra", 1), ("tetrahedra", 2)):
        for enforce in ("", ", enforce: weak"):
            with folder() as scratch:
                write(scratch, PATCH % (model, mesh, degree, enforce))
                got = result(scratch)
                expect("a linear field is exact: %s, %s of degree %d%s" % (model, mesh, degree, enforce),
                       isinstance(got, dict) and got["error"]["linf"] < 1e-12, got)

with folder() as scratch:
    write(scratch, BAD % ("slice", "3"))
    check("cg has no slices and no degree 3", ["run", "scene.yaml"], status=2, cwd=scratch, err=(
        "scene.yaml:6:40: bodies.0.method.mesh: slices are of dg, got \"slice\"; expected hexahedra, "
        "tetrahedra, voxels or embedded\n"
        "scene.yaml:6:55: bodies.0.method.degree: cg has elements of degree 1 and 2, got \"3\"; expected 1 "
        "or 2\n"))

done()
