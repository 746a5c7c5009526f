"""Scenes from outside: what a run writes, what it says, and how it ends."""
import json
import os

from cli import check, done, expect, folder, run

BEAM = """lithe: 1
title: Cantilever
bodies:
  - name: beam
    shape: {box: {min: [0, 0, 0], max: [1, 0.2, 0.2]}}
    material: {model: linear, young_modulus: 1e6, poisson_ratio: 0.3, density: 1000}
    method: {kind: dg, mesh: hexahedra, cells: [5, 1, 1], degree: 2}
    constraints:
      - {where: {plane: {point: [0, 0, 0], normal: [-1, 0, 0]}}, displacement: [0, 0, 0]}
gravity: [0, -1, 0]
time: {kind: static}
probes:
  - {name: tip, point: [1, 0.1, 0.1]}
output: {every: last, fields: [vtu]}
"""


def write(directory, text, name="beam.yaml"):
    path = os.path.join(directory, name)
    with open(path, "w") as file:
        file.write(text)
    return path


def read_json(*path):
    with open(os.path.join(*path)) as file:
        return json.load(file)


with folder() as d:
    write(d, BEAM)
    got = run("run", "beam.yaml", "-o", "result", cwd=d)
    expect("a_run_ends_well", got.returncode == 0 and got.stderr == "", got.stderr)
    expect("a_run_says_where_the_result_is", "\n  result            result/result.json\n" in got.stdout, got.stdout)
    result = read_json(d, "result", "result.json")
    body = result["bodies"][0]
    expect("result_tells_the_body", result["status"] == "done" and body["elements"] == 5 and
           body["dofs"] == 150 and abs(body["volume"] - 0.04) < 1e-15, body)
    reaction = result["reaction"]["bodies.0.constraints.0"]
    expect("reaction_carries_the_weight", abs(reaction[1] - 40) < 1e-6 * 40, reaction)
    strong = json.loads(run("run", "beam.yaml", "--json", "--set", "bodies.0.constraints.0.enforce=strong", "-o", "strong",
                            cwd=d).stdout)["reaction"]["bodies.0.constraints.0"]
    expect("a_strong_constraint_carries_the_weight", abs(strong[1] - 40) < 1e-6 * 40 and abs(strong[0]) < 1e-5, strong)
    pulled = json.loads(run("run", "beam.yaml", "--json", "--set", "gravity=[0, 0, 0]", "-o", "pulled", "--set",
                            "bodies.0.loads=[{where: {box: {min: [1, -1, -1], max: [2, 1, 0]}}, point_force: [0, 0, -3]}]",
                            cwd=d).stdout)
    reaction = pulled["reaction"]["bodies.0.constraints.0"]
    expect("a_point_force_acts_on_every_node", abs(reaction[2] - 6) < 1e-6 * 6, reaction)
    soft, hard = (json.loads(run("run", "beam.yaml", "--json", "-o", "stiff", "--set", "bodies.0.material.model=corotated",
                                 "--set", "gravity=[0, -1e-3, 0]", "--set", "bodies.0.material.young_modulus=%g" % young,
                                 cwd=d).stdout) for young in (1e8, 1e12))
    # displacements of 4e-12 of the length: nothing but their own 16 digits in positions of size 1 may be lost
    expect("stiffness_alone_scales_displacements", abs(1e4 * hard["displacement"]["max"] / soft["displacement"]["max"] - 1)
           < 1e-3, (soft["displacement"], hard["displacement"]))
    check("a_point_force_without_nodes_is_named", ["run", "beam.yaml", "--quiet", "--set",
          "bodies.0.loads=[{where: {normal: [1, 0, 0]}, point_force: [0, 0, -3]}]"], cwd=d, status=2, err=(
              "lithe: --set bodies.0.loads=[{where: {normal: [1, 0, 0]}, point_force: [0, 0, -3]}]: "
              "bodies.0.loads.0.where: selects no node of the mesh; the body reaches from "
              "(0, 0, 0) to (1, 0.2, 0.2), and shapes, planes and labels select nodes\n"))
    files = set(os.listdir(os.path.join(d, "result")))
    expect("a_static_run_writes_one_state", files == {"result.json", "history.csv", "probes.csv",
                                                      "fields.pvd", "fields_0000.vtu"}, files)
    rows = open(os.path.join(d, "result", "probes.csv")).read().splitlines()
    expect("probes_have_a_row_an_output", len(rows) == 2 and rows[0].startswith("t,tip_ux,tip_uy"), rows)
    expect("default_folder_is_named_by_the_scene", run("run", "beam.yaml", "--quiet", cwd=d).stdout == "" and
           os.path.exists(os.path.join(d, "out", "beam", "result.json")))

    got = run("run", "beam.yaml", "--json", cwd=d)
    expect("json_is_the_result_on_standard_output",
           json.loads(got.stdout) == read_json(d, "out", "beam", "result.json"), got.stdout)
    coarse = run("run", "beam.yaml", "--json", "--set", "bodies.0.method.degree=1", cwd=d)
    expect("set_overrides_a_value", json.loads(coarse.stdout)["bodies"][0]["dofs"] == 60, coarse.stdout)
    one = json.loads(run("run", "beam.yaml", "--json", "--threads", "1", cwd=d).stdout)
    two = json.loads(run("run", "beam.yaml", "--json", "--threads", "2", cwd=d).stdout)
    expect("threads_do_not_change_the_bits", one["threads"] == 1 and two["threads"] == 2 and
           one["probes"] == two["probes"] and one["energy"] == two["energy"])

    got = run("check", "beam.yaml", "--json", cwd=d)
    forecast = json.loads(got.stdout)
    expect("check_counts_without_running", forecast["elements"] == 5 and forecast["dofs"] == 150 and
           forecast["nonzeros"] == body["nonzeros"] and not got.stderr, forecast)
    got = run("mesh", "beam.yaml", "-o", "mesh.vtu", "--json", cwd=d)
    report = json.loads(got.stdout)
    expect("mesh_reports_and_writes", report["elements"] == 5 and report["inner_faces"] == 4 and
           os.path.exists(os.path.join(d, "mesh.vtu")), report)

# a linear field, prescribed all round, is met to rounding, on sliced elements of a body in any place
PATCH = """lithe: 1
bodies:
  - name: ball
    shape: {sphere: {center: [0, 0, 0], radius: 1}}
    material: {model: linear, young_modulus: 1e6, poisson_ratio: 0.3, density: 1000}
    method: {kind: dg, cells: 3, degree: 1}
    constraints:
      - {where: all, displacement: ["0.01*x + 0.02*y", "-0.01*y", "0.03*z - 0.01*x"]}
time: {kind: static}
solver: {linear: cholesky, tolerance: 1e-12}
exact:
  displacement: ["0.01*x + 0.02*y", "-0.01*y", "0.03*z - 0.01*x"]
output: {every: last, fields: [none]}
"""
with folder() as d:
    write(d, PATCH, "patch.yaml")
    got = run("run", "patch.yaml", "--json", cwd=d)
    error = json.loads(got.stdout)["error"] if got.returncode == 0 else {}
    # 1e-9 of the displacement; h1 also carries the differences' 1e-9
    expect("a_linear_field_has_no_error", error and error["l2"] < 1e-10 and error["linf"] < 1e-10 and
           error["l1"] < 1e-10 and error["h1"] < 1e-9, (error, got.stderr))
    off = run("run", "patch.yaml", "--json", "--set", "exact.displacement=['0.01*x + 0.02*y','-0.01*y','0.03*z']", cwd=d)
    error = json.loads(off.stdout)["error"] if off.returncode == 0 else {}
    # |e| = 0.01 |x|: over the unit ball, l1 = 0.01 pi/2, l2^2 = 1e-4 4 pi/15, h1^2 = 1e-4 4 pi/3
    near = lambda got, want: abs(got - want) < 0.02 * want
    expect("error_norms_are_integrals_over_the_body", error and near(error["l1"], 0.01 * 3.14159 / 2) and
           near(error["l2"], 0.01 * (4 * 3.14159 / 15) ** 0.5) and near(error["h1"], 0.01 * (4 * 3.14159 / 3) ** 0.5) and
           0.0095 < error["linf"] <= 0.01, (error, off.stderr))

# the surface of a box has points at its corners only; the elements between them touch the floor as well
DROP = """lithe: 1
bodies:
  - name: block
    shape: {box: {min: [-0.1, 0, -0.1], max: [0.1, 0.1, 0.1]}}
    material: {young_modulus: 50 kPa, poisson_ratio: 0.3, density: 1000, damping: {mass: 5}}
    method: {cells: 4}
    embed: {}
gravity: [0, -10, 0]
colliders:
  - plane: {point: [0, 0, 0], normal: [0, 1, 0]}
time: {kind: dynamic, duration: 0.5, step: 1/100}
probes:
  - {name: middle, point: [0, 0, 0]}
output: {fields: [none], surface: [none]}
"""
with folder() as d:
    write(d, DROP, "drop.yaml")
    got = run("run", "drop.yaml", "--json", cwd=d)
    sunk = json.loads(got.stdout)["probes"]["middle"]["displacement"][1] if got.returncode == 0 else None
    expect("the_middle_of_a_large_polygon_stays_on_the_floor", sunk is not None and -0.001 < sunk < 0.001, (sunk, got.stderr))
    got = run("run", "drop.yaml", "--json", "--set", "contact.points=surface", cwd=d)
    expect("touching_at_corners_only_is_told", got.returncode == 0 and "`auto` adds the nodes" in got.stderr, got.stderr)

    with open(os.path.join(d, "tet.obj"), "w") as file:
        file.write("v 0 0 0\nv 30 0 0\nv 0 30 0\nv 0 0 30\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    got = run("run", "drop.yaml", "--set", "bodies.0.embed.surface=tet.obj", "--set", "colliders=[]", "--set", "time.duration=0.01",
              cwd=d)
    expect("an_embedded_surface_elsewhere_is_told", got.returncode == 0 and
           "bodies.0.embed.surface: 3 of 4 points lie outside the body, up to 29.9 m away" in got.stderr, got.stderr)

# ways to fail: the message says what, where and what helps
with folder() as d:
    write(d, BEAM)
    check("missing_file_is_bad_input", ["run", "none.yaml"], err=None, status=2, cwd=d)
    empty = BEAM.replace("point: [0, 0, 0], normal: [-1, 0, 0]", "point: [-1, 0, 0], normal: [-1, 0, 0]")
    write(d, empty, "empty.yaml")
    check("empty_selection_names_the_path_and_the_body", ["run", "empty.yaml"], status=2, cwd=d,
          err="lithe: empty.yaml:9:9: bodies.0.constraints.0.where: selects nothing of the body's boundary; "
              "the body reaches from (0, 0, 0) to (1, 0.2, 0.2)\n")
    expect("check_finds_an_empty_selection", run("check", "empty.yaml", cwd=d).returncode == 2)
    write(d, BEAM.replace("displacement: [0, 0, 0]}", "displacement: [0, null, 0]}"), "free.yaml")
    got = run("check", "free.yaml", cwd=d)
    expect("check_finds_a_free_body", got.returncode == 2 and "translation along y" in got.stderr, got.stderr)
    got = run("run", "free.yaml", cwd=d)
    expect("a_free_static_body_names_its_motions", got.returncode == 2 and "translation along y" in got.stderr and
           not os.path.exists(os.path.join(d, "out", "free", "result.json")), got.stderr)
    write(d, "lithe: 1\nbodies:\n  - {name: a, shap: {box: {}}}\n", "bad.yaml")
    got = run("check", "bad.yaml", cwd=d)
    expect("all_errors_of_a_file_come_at_once", got.returncode == 2 and got.stdout == "" and
           len(got.stderr.splitlines()) > 1 and all(x.startswith("bad.yaml:") for x in got.stderr.splitlines()),
           got.stderr)

    # shapes and grids that do not fit each other
    write(d, BEAM.replace("cells: [5, 1, 1]", "grid: {min: [0, 0, 0], max: [0.8, 0.2, 0.2], cells: [4, 1, 1]}"), "grid.yaml")
    check("a_grid_of_hexahedra_is_the_box", ["check", "grid.yaml"], status=2, cwd=d,
          err="lithe: grid.yaml:4:5: bodies.0.method.grid: hexahedra and tetrahedra fill the whole grid, so it has to "
              "be the box: got 0 to 0.8 along x where the box has 0 to 1; or use `mesh: slice`\n")
    check("a_grid_holds_the_sliced_body", ["check", "grid.yaml", "--set", "bodies.0.method.mesh=slice"], status=2, cwd=d,
          err="lithe: grid.yaml:4:5: bodies.0.method.grid: it does not hold the body, which reaches from (0, 0, 0) to "
              "(1, 0.2, 0.2); got a grid from (0, 0, 0) to (0.8, 0.2, 0.2)\n")
    check("an_empty_intersection_is_named", ["check", "beam.yaml", "--set", "bodies.0.method.mesh=slice", "--set",
          "bodies.0.shape={intersection: [{sphere: {center: [0,0,0], radius: 1}}, {sphere: {center: [5,0,0], radius: 1}}]}"],
          err="lithe: beam.yaml:4:5: bodies.0.shape: it is empty: its parts have no space in common; move or enlarge "
              "them\n", status=2, cwd=d)
    check("a_mesh_is_written_as_vtu", ["mesh", "beam.yaml", "-o", "beam.msh"], status=2, cwd=d,
          err="lithe: beam.msh: a mesh is written as VTU, fractions of a grid as VTI; expected a name with .vtu or "
          ".vti\n")

    # an expression that comes out undefined is named, in whichever step that is
    load = "    loads:\n      - {where: {normal: [1, 0, 0]}, traction: [0, \"%s\", 0]}\ngravity"
    write(d, BEAM.replace("gravity", load % "1/(x - 1)"), "gap.yaml")
    got = run("run", "gap.yaml", cwd=d)
    expect("an_infinite_load_is_bad_input", got.returncode == 2 and got.stderr.startswith(
        "lithe: gap.yaml:11:52: bodies.0.loads.0.traction.1: infinite at (1, ") and got.stderr.endswith(
            ', t = 0, got "1/(x - 1)"; expected a finite number\n'), got.stderr)
    expect("nothing_wrong_is_called_a_result", not os.path.exists(os.path.join(d, "out", "gap", "result.json")))
    late = BEAM.replace("gravity", load % "sqrt(0.5 - t)").replace("{kind: static}",
                                                                  "{kind: quasistatic, steps: 4, duration: 1}")
    write(d, late, "late.yaml")
    got = run("run", "late.yaml", cwd=d)
    expect("a_load_undefined_later_is_bad_input", got.returncode == 2 and
           "traction.1: not a number at (1, " in got.stderr and "t = 0.75" in got.stderr, got.stderr)
    motion = BEAM.replace("{kind: static}", "{kind: dynamic, duration: 0.1, step: 0.01}") + \
        "colliders:\n  - plane: {point: [0, -1, 0], normal: [0, 1, 0], motion: {translate: [0, \"log(0.05 - t)\", 0]}}\n"
    write(d, motion, "motion.yaml")
    got = run("run", "motion.yaml", cwd=d)
    expect("an_undefined_motion_is_bad_input", got.returncode == 2 and "motion.translate.1: " in got.stderr, got.stderr)
    expect("an_unwritable_folder_is_status_4", run("run", "beam.yaml", "-o", "/proc/none", cwd=d).returncode == 4)

with folder() as d:
    # where a constraint holds everything a load is no part of the problem
    press = "    loads:\n      - {where: %s, pressure: 1 kPa}\ngravity"
    tips = []
    for name, where in (("all", "all"), ("free", "{not: {normal: [-1, 0, 0]}}"), ("held", "{normal: [-1, 0, 0]}")):
        write(d, BEAM.replace("gravity", press % where), name + ".yaml")
        got = run("run", name + ".yaml", cwd=d)
        if name == "held":
            expect("a_load_on_held_boundary_only_is_refused", got.returncode == 2 and
                   "selects only boundary that a constraint holds" in got.stderr, got.stderr)
        else:
            tips.append(read_json(d, "out", name, "result.json")["displacement"])
    expect("held_boundary_feels_no_load", tips[0] == tips[1], tips)
done()
