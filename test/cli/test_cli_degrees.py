"""Degrees 1 to 4 from outside: numbers, expressions of place, what is refused."""
import json
import os

import vtk

from cli import check, done, expect, folder, run

BAR = """lithe: 1
bodies:
  - name: bar
    shape: {box: {min: [0, 0, 0], max: [1, 0.2, 0.2]}}
    material: {model: linear, young_modulus: 1e6, poisson_ratio: 0.3, density: 1000}
    method: {kind: dg, mesh: hexahedra, cells: [5, 1, 1], degree: %s}
    constraints:
      - {where: {normal: [-1, 0, 0]}, displacement: [0, 0, 0]}
gravity: [0, -1, 0]
time: {kind: static}
probes:
  - {name: tip, point: [1, 0.1, 0.1]}
output: {every: last, fields: [vtu]}
"""

# u_x is cubic, and its body force is linear: elements of degree 3 and 4 hold it exactly
CUBIC = """lithe: 1
bodies:
  - name: ball
    shape: {sphere: {center: [0, 0, 0], radius: 1}}
    material: {model: linear, young_modulus: 2.6, poisson_ratio: 0.3, density: 1}
    method: {kind: dg, cells: 3, degree: "x > 0 ? 4 : 3"}
    constraints:
      - {where: all, displacement: ["0.01*y^3 + 0.02*y^2*z", "0", "0"]}
    loads:
      - {body_force: ["-(0.06*y + 0.04*z)", "0", "0"]}
time: {kind: static}
solver: {linear: cholesky, tolerance: 1e-12}
exact:
  displacement: ["0.01*y^3 + 0.02*y^2*z", "0", "0"]
output: {every: last, fields: [none]}
"""


# K of degree 4 is so large that rounding of places leaves 1e-6 of these small forces
SOFT = """lithe: 1
bodies:
  - name: bar
    shape: {box: {min: [0, 0, 0], max: [20 cm, 2 cm, 2 cm]}}
    material: {young_modulus: 1 MPa, poisson_ratio: 0.45, density: 1.1 g/cm^3}
    method: {cells: [10, 2, 2], degree: 4}
    constraints:
      - {where: {normal: [-1, 0, 0]}, displacement: [0, 0, 0]}
gravity: [0, -0.1, 0]
time: static
output: {fields: none}
"""


def write(directory, text, name="bar.yaml"):
    with open(os.path.join(directory, name), "w") as file:
        file.write(text)


def result(directory, *args):
    got = run("run", "bar.yaml", "--json", *args, cwd=directory)
    return json.loads(got.stdout) if got.returncode == 0 else got.stderr


def cell_array(path, name):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    array = reader.GetOutput().GetCellData().GetArray(name)
    return [array.GetTuple1(i) for i in range(array.GetNumberOfTuples())]


with folder() as d:
    tips = []
    for degree, functions in ((1, 4), (2, 10), (3, 20), (4, 35)):
        write(d, BAR % degree)
        told = result(d)
        tips.append(told["probes"]["tip"]["displacement"][1])
        expect("degree_%d_has_its_functions" % degree, told["bodies"][0]["dofs"] == 15 * functions and
               told["bodies"][0]["method"]["degree"] == degree, told)
        reaction = told["reaction"]["bodies.0.constraints.0"]
        expect("degree_%d_balances_its_weight" % degree, abs(reaction[1] - 40) < 1e-6 * 40, reaction)
    expect("tips_converge_with_the_degree", abs(tips[3] - tips[2]) < 0.5 * abs(tips[2] - tips[1]), tips)

    # centroids 0.1, 0.3 ... 0.9: degrees 1, 2, 3, 3, 4
    write(d, BAR % '"1.05 + 3*x"')
    told = result(d)
    body = told["bodies"][0]
    expect("an_expression_gives_each_element_its_degree", body["dofs"] == 3 * (4 + 10 + 20 + 20 + 35) and
           body["method"]["degree"] == [1, 4], body)
    degrees = cell_array(os.path.join(d, "out", "bar", "fields_0000.vtu"), "degree")
    expect("fields_hold_the_degree_of_each_element", degrees == [1, 2, 3, 3, 4], degrees)
    forecast = json.loads(run("check", "bar.yaml", "--json", cwd=d).stdout)
    expect("a_check_counts_mixed_degrees", forecast["dofs"] == body["dofs"] and
           forecast["nonzeros"] == body["nonzeros"], forecast)
    for extra in (["--set", "bodies.0.material.model=corotated"], ["--set", "bodies.0.constraints.0.enforce=strong"],
                  ["--set", "solver.linear=pcg", "--set", "solver.condition=true"],
                  ["--set", "bodies.0.method.flux=bz"],
                  ["--set", "time={kind: dynamic, duration: 0.02, step: 0.01}",
                   "--set", "bodies.0.initial={velocity: ['y*y', 0, 0]}"]):
        told = result(d, *extra)
        expect("mixed_degrees_run_with " + extra[-1], isinstance(told, dict) and told["status"] == "done", told)

    check("a_degree_out_of_range_names_the_place", ["check", "bar.yaml", "--set", "bodies.0.method.degree=2 + 3*x"],
          err="lithe: bar.yaml:3:5: bodies.0.method.degree: it is 4.7 at the centroid (0.9, 0.1, 0.1) of an element; "
              "expected an expression that rounds to 1 to 4 everywhere in the body, as with min(max(.., 1), 4)\n",
          status=2, cwd=d)
    check("an_undefined_degree_is_named", ["run", "bar.yaml", "--set", "bodies.0.method.degree=1 + log(x - 0.2)"],
          err="lithe: --set bodies.0.method.degree=1 + log(x - 0.2): bodies.0.method.degree: not a number at (0.1, 0.1, 0.1), "
              "t = 0, got \"1 + log(x - 0.2)\"; expected a finite number\n", status=2, cwd=d)
    write(d, CUBIC)
    told = result(d)
    expect("a_cubic_field_has_no_error", isinstance(told, dict) and told["error"]["l2"] < 1e-10 and
           told["error"]["linf"] < 1e-9, told)
    write(d, SOFT)
    told = result(d)
    expect("an_equilibrium_of_degree_4_ends_where_rounding_does",
           isinstance(told, dict) and told["solver"]["newton_iterations"] < 20 and
           told["solver"]["residual"] < 1e-5 and
           abs(told["reaction"]["bodies.0.constraints.0"][1] / 0.0088 - 1) < 1e-5, told)

done()
