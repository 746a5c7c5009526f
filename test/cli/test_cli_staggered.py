"""Staggered bodies from outside: exact solutions, the numbers of the thesis' tables, files that VTK reads, bad input."""
import csv
import gzip
import json
import math
import os
import struct

import vtk
from vtk.util.numpy_support import vtk_to_numpy

from cli import done, expect, folder, run

BAR = """lithe: 1
bodies:
  - name: bar
    shape: {box: {min: [0, 0, 0], max: [1, 0.2, 0.3]}}
    material: {model: linear, young_modulus: 1 MPa, poisson_ratio: 0.3, density: 1000, yield_strength: 4 kPa}
    method: {kind: staggered, cells: 10}
    constraints:
      - {where: {plane: {point: [0, 0, 0], normal: [-1, 0, 0]}}, displacement: {normal: 0}}
      - {where: {normal: [0, -1, 0]}, displacement: {normal: 0}}
      - {where: {normal: [0, 0, -1]}, displacement: [null, null, 0]}
    loads:
      - {where: {face: {at: [1, 0.1, 0.1]}}, traction: [1 kPa, 0, 0]}
time: {kind: static}
probes:
  - {name: tip, point: [1, 0.2, 0.3]}
exact:
  displacement: ["1e-3*x", "-3e-4*y", "-3e-4*z"]
  stress: [["1e3", "0", "0"], ["0", "0", "0"], ["0", "0", "0"]]
output: {every: last, fields: [vti, vtu]}
"""

# mu = lambda = 1: the annulus of Dolny 2025, chapter 5
RING = """lithe: 1
dimension: 2
bodies:
  - name: ring
    shape: {annulus: {center: [0, 0], inner: 0.325, outer: 0.8}}
    material: {model: linear, young_modulus: 2.5, poisson_ratio: 0.25}
    method: {kind: staggered, grid: {min: [-1, -1], max: [1, 1], cells: [32, 32]}}
    constraints:
      - {where: all, position: ["cos(2*pi*x)*cos(2*pi*y)", "sin(2*pi*x)*sin(2*pi*y)"]}
    loads:
      - {body_force: ["8*pi^2*cos(2*pi*x)*cos(2*pi*y)", "8*pi^2*sin(2*pi*x)*sin(2*pi*y)"]}
exact:
  position: ["cos(2*pi*x)*cos(2*pi*y)", "sin(2*pi*x)*sin(2*pi*y)"]
time: {kind: static}
output: {every: last}
"""
INSIDE_HELD = ["bodies.0.constraints.0.where={disk: {center: [0, 0], radius: 0.325}}",
               "bodies.0.loads.1={where: {not: {disk: {center: [0, 0], radius: 0.6}}}, stress: "
               "[[\"-4*pi*sin(2*pi*x)*cos(2*pi*y)-4\", 0], [0, \"4*pi*sin(2*pi*x)*cos(2*pi*y)-4\"]]}"]

# u = a (r - 0.2^3 / r^2) e_r under outer pressure; unknowns are held where they are, a little inside of r = 0.2
LAMBDA, MU, INNER, OUTER = 0.3e6 / (1.3 * 0.4), 1e6 / 2.6, 0.2, 0.45
A = -1000 / (3 * LAMBDA + 2 * MU + 4 * MU * (INNER / OUTER)**3)
SHELL = """lithe: 1
bodies:
  - name: shell
    shape: {shell: {center: [0, 0, 0], inner: 0.2, outer: 0.45}}
    material: {model: linear, young_modulus: 1 MPa, poisson_ratio: 0.3}
    method: {kind: staggered, cells: 12}
    constraints:
      - {where: {sphere: {center: [0, 0, 0], radius: 0.2}}, displacement: [FX, FY, FZ]}
    loads:
      - {where: {not: {sphere: {center: [0, 0, 0], radius: 0.3}}}, pressure: 1 kPa}
exact:
  displacement: [FX, FY, FZ]
time: {kind: static}
solver: {threads: 1}
output: {every: last, fields: [vti]}
"""
for axis in "xyz":
    SHELL = SHELL.replace("F" + axis.upper(), "\"%.17g*(1-%.17g/(x*x+y*y+z*z)^1.5)*%s\"" % (A, INNER**3, axis))


def write(directory, name, text):
    with open(os.path.join(directory, name), "wb") as file:
        file.write(text if isinstance(text, bytes) else text.encode())


def result(directory, scene, *changes, out="out"):
    sets = [x for change in changes for x in ("--set", change)]
    got = run("run", scene, "--json", "-o", out, *sets, cwd=directory)
    return json.loads(got.stdout) if got.returncode == 0 else {"failed": got.stderr}


def near(got, wanted, relative):
    return abs(got - wanted) <= relative * abs(wanted)


def read_vtk(reader, directory, *path):
    reader.SetFileName(os.path.join(directory, *path))
    errors = []
    reader.AddObserver("ErrorEvent", lambda *event: errors.append(event))
    reader.Update()
    assert not errors and reader.GetErrorCode() == 0, path
    return reader.GetOutput()


def array(data, name):
    return vtk_to_numpy(data.GetArray(name))


def test_bar():
    with folder() as d:
        write(d, "bar.yaml", BAR)
        r = result(d, "bar.yaml")
        if "failed" in r:
            return expect("a_pulled_bar_runs", False, r)
        # uniform strain is in the space: what is left is rounding
        expect("a_pulled_bar_is_exact", r["error"]["linf"] < 1e-12 and r["error"]["stress"]["linf"] < 1e-5, r["error"])
        expect("so_is_its_energy", near(r["energy"]["strain"], 0.5 * 1000 * 1e-3 * 0.06, 1e-9), r["energy"])
        expect("its_support_carries_the_load", near(r["reaction"]["bodies.0.constraints.0"][0], -60, 1e-9) and
               all(abs(v) < 1e-6 for i in (1, 2) for v in r["reaction"]["bodies.0.constraints.%d" % i]), r["reaction"])
        expect("safety_is_yield_strength_over_stress", near(r["stress"]["safety"], 4, 1e-6), r["stress"])
        expect("its_corner_is_where_it_belongs",
               max(abs(a - b) for a, b in zip(r["probes"]["tip"]["displacement"], (1e-3, -6e-5, -9e-5))) < 1e-12, r)
        body = r["bodies"][0]
        expect("the_result_tells_the_grid", body["method"]["kind"] == "staggered" and body["elements"] == 60 and
               near(body["volume"], 0.06, 1e-12) and body["method"]["formulation"] == "displacement", body)

        image = read_vtk(vtk.vtkXMLImageDataReader(), d, "out", "fields_0000.vti")
        cells = image.GetCellData()
        expect("an_image_has_the_cells", image.GetDimensions() == (11, 3, 4) and
               array(cells, "fraction").min() == 1, image.GetDimensions())
        moved = array(cells, "displacement")
        expect("its_first_and_last_cells_moved_as_they_should", near(float(moved[0][0]), 5e-5, 1e-5) and
               near(float(moved[-1][0]), 9.5e-4, 1e-5), moved)
        voxels = read_vtk(vtk.vtkXMLUnstructuredGridReader(), d, "out", "fields_0000.vtu")
        expect("voxels_end_where_the_bar_does", voxels.GetNumberOfCells() == 60 and
               near(voxels.GetBounds()[1], 1.001, 1e-6) and near(voxels.GetBounds()[3], 0.2 - 6e-5, 1e-6),
               voxels.GetBounds())
        xx = array(voxels.GetCellData(), "stress")
        expect("they_know_their_stress", abs(xx[:, 0] - 1000).max() < 0.1 and abs(xx[:, 1:]).max() < 0.1, xx)

        # eigenvalues of free unknowns alone: the modulus drops out
        conditions = [result(d, "bar.yaml", "solver.condition=true", "bodies.0.method.cells=8",
                             "bodies.0.material.young_modulus=%g" % young, out="c").get("solver", {}).get("condition")
                      for young in (1e6, 1e-3)]
        expect("the_modulus_drops_out_of_the_condition_number",
               all(conditions) and near(conditions[0], conditions[1], 1e-6), conditions)

        # a bar that falls: nothing holds it, and it is stepped as every body
        fall = result(d, "bar.yaml", "bodies.0.constraints=[]", "bodies.0.loads=[]", "gravity=[0, -10, 0]",
                      "time={dynamic: {duration: 0.02, step: 0.01}}", "exact={}", out="fall")
        expect("a_free_bar_falls", "failed" not in fall and
               near(fall["displacement"]["max"], 10 * (1e-4 + 2e-4), 1e-6), fall)


BUNNY = "/usr/share/glmark2/models/bunny.obj"


def test_forecast():
    with folder() as d:
        write(d, "bar.yaml", BAR)
        free = run("check", "bar.yaml", "--json", cwd=d)
        expect("a_solve_without_a_matrix_has_no_nonzeros", "nonzeros" not in json.loads(free.stdout) and
               "nonzeros" not in run("check", "bar.yaml", cwd=d).stdout, free.stdout)
        for model in ("linear", "corotated"):
            sets = ("solver.linear=cholesky", "bodies.0.material.model=" + model, "bodies.0.method.cells=20")
            options = [x for s in sets for x in ("--set", s)]
            told = json.loads(run("check", "bar.yaml", "--json", *options, cwd=d).stdout)["nonzeros"]
            made = result(d, "bar.yaml", *sets)["bodies"][0]["nonzeros"]
            # a bar of 4 x 6 cells across is mostly boundary, where rows are shorter
            expect("nonzeros_of_a_%s_body_are_foreseen" % model, 0.6 < made / told < 1.1, (made, told))


THIN = """lithe: 1
bodies:
  - name: shell
    shape: {shell: {center: [0, 0, 0], outer: 1, inner: %g}}
    material: {model: linear, young_modulus: 1 GPa, poisson_ratio: 0.3, density: 1000}
    method: {kind: staggered, cells: %d}
    constraints:
      - {where: {plane: {point: [0, 0, -0.9], normal: [0, 0, -1]}}, displacement: [0, 0, 0]}
gravity: [0, 0, -9.81]
time: {kind: static}
output: {every: last, fields: [none]}
"""


def test_thin():
    """Memory of a compact and of a thin body is foreseen within 30 %, iterations do not grow, thin features are told."""
    with folder() as d:
        iterations = {}
        for name, inner, cells in (("compact", 0.2, 64), ("thin", 1 - 6 / 64, 64), ("finer", 1 - 6 / 96, 96)):
            write(d, name + ".yaml", THIN % (inner, cells))
            told = json.loads(run("check", name + ".yaml", "--json", cwd=d).stdout)["memory"]
            r = result(d, name + ".yaml")
            iterations[name] = r.get("solver", {}).get("iterations")
            # what sanitizers keep beside the program's own memory is foreseen by nobody
            if "sanitizers  no" in run("info").stdout:
                expect("memory_of_a_%s_body_is_foreseen" % name, 0.7 < told / r["memory"] < 1.3, (told, r["memory"]))
        expect("a_finer_shell_takes_few_iterations_more", iterations["finer"] <= 30, iterations)
        told = {cells: run("mesh", "thin.yaml", "--set", "bodies.0.method.cells=%d" % cells, cwd=d) for cells in (40, 80)}
        expect("thin_features_are_told_with_the_mesh", "in features thinner than three cells" in told[40].stderr and
               "thinner" not in told[80].stderr, told)


def test_bunny():
    """Two methods, one answer: its base clamped, under gravity."""
    if not os.path.exists(BUNNY):
        return
    scene = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scenes", "staggered-bunny.yaml")
    with folder() as d:
        # up to 1 cm, where both have faces of cells
        both = ["output.fields=[none]", "bodies.0.constraints.0.where.box.max=[1, 0.01, 1]",
                "bodies.0.constraints.0.interior=true"]
        cells = "{kind: %s, grid: {min: [-0.11, 0, -0.09], max: [0.11, 0.2, 0.09], cells: [%d, %d, %d]}}"
        grid = result(d, scene, *both, "bodies.0.method=" + cells % ("staggered", 44, 40, 36))
        mesh = result(d, scene, *both, "bodies.0.method=" + cells % ("dg, degree: 2", 22, 20, 18))
        expect("a_bunny_sags_as_with_dg", "failed" not in grid and "failed" not in mesh and
               near(grid["displacement"]["mean"], mesh["displacement"]["mean"], 0.02) and
               near(grid["energy"]["strain"], mesh["energy"]["strain"], 0.03), (grid, mesh))
        expect("its_energy_is_the_work_of_gravity",
               near(grid["energy"]["strain"], grid["energy"]["work"], 1e-6), grid.get("energy"))


def test_thesis():
    """THEORY-STAGGERED: tables of sections 3 (a) and 4.2 (B), at the unknowns."""
    with folder() as d:
        write(d, "ring.yaml", RING)
        for cells, l1, linf in ((32, 1.038e-2, 1.049e-2), (48, 4.168e-3, 4.427e-3), (64, 2.277e-3, 2.505e-3)):
            e = result(d, "ring.yaml", "bodies.0.method.grid.cells=[%d, %d]" % (cells, cells)).get("error", {})
            # four digits are known
            expect("table_5_2_at_%d" % cells, e and near(e["l1"], l1, 5e-4) and near(e["linf"], linf, 5e-4), e)
        for cells, l1, linf in ((32, 1.65e-2, 1.55e-2), (64, 4.54e-3, 4.90e-3)):
            e = result(d, "ring.yaml", "bodies.0.method.grid.cells=[%d, %d]" % (cells, cells),
                       *INSIDE_HELD).get("error", {})
            # three digits are known
            expect("table_5_1_at_%d" % cells, e and near(e["l1"], l1, 5e-3) and near(e["linf"], linf, 5e-3), e)
        image = read_vtk(vtk.vtkXMLImageDataReader(), d, "out", "fields_0000.vti")
        area = array(image.GetCellData(), "fraction").sum() * image.GetSpacing()[0] * image.GetSpacing()[1]
        expect("images_in_the_plane_are_flat_and_full", image.GetDimensions()[2] == 1 and
               near(float(area), math.pi * (0.8**2 - 0.325**2), 1e-6), area)


def test_shell():
    with folder() as d:
        write(d, "shell.yaml", SHELL)
        errors = []
        for cells in (12, 24):
            r = result(d, "shell.yaml", "bodies.0.method.cells=%d" % cells, out="s%d" % cells)
            errors.append(r.get("error"))
        size = -A * (OUTER - INNER**3 / OUTER**2)
        volume = 4 / 3 * math.pi * (OUTER**3 - INNER**3)
        expect("a_pressed_shell_converges", all(errors) and errors[1]["l1"] < 0.42 * errors[0]["l1"] and
               errors[1]["l1"] < 0.02 * size * volume, (errors, size))
        two = result(d, "shell.yaml", "bodies.0.method.cells=24", "solver.threads=2", out="two")
        with open(os.path.join(d, "s24", "fields_0000.vti"), "rb") as a, \
                open(os.path.join(d, "two", "fields_0000.vti"), "rb") as b:
            expect("threads_change_no_bit", "failed" not in two and a.read() == b.read())
        got = run("mesh", "shell.yaml", "--json", "-o", "m.vti", cwd=d)
        report = json.loads(got.stdout) if got.returncode == 0 else {}
        image = read_vtk(vtk.vtkXMLImageDataReader(), d, "m.vti")
        filled = array(image.GetCellData(), "fraction")
        expect("fractions_are_written_and_told", report and near(report["volume"], volume, 1e-3) and
               report["full_cells"] == int((filled == 1).sum()) and report["components"] == 1, (report, got.stderr))
        got = run("check", "shell.yaml", "--json", cwd=d)
        expect("check_tells_what_it_needs", got.returncode == 0 and
               json.loads(got.stdout)["elements"] == report["elements"], got.stdout + got.stderr)


BLOB = """lithe: 1
dimension: DIM
bodies:
  - name: blob
    shape: SHAPE
    material: {model: linear, young_modulus: 1 MPa, poisson_ratio: 0.3}
    method: {kind: staggered, cells: 20, fractions: smooth}
"""
WIDTH = 0.06  # 1.2 cells, half of the profile


def profile(s):
    return 1 if s <= -1 else 0 if s >= 1 else (1 - s - math.sin(math.pi * s) / math.pi) / 2


def corner(dim, n=24):
    """What a corner of a cube holds in addition, over WIDTH^dim: the profile of its distance at midpoints."""
    step, total = 2 / n, 0
    for i in range(n**dim):
        x = [-1 + (i // n**a % n + 0.5) * step for a in range(dim)]
        outside = math.sqrt(sum(max(v, 0)**2 for v in x))
        total += step**dim * (profile(outside or max(x)) - all(v < 0 for v in x))
    return total


def test_smooth():
    """Smooth fractions reach beyond the body, on whatever grid, but not beyond planes of symmetry."""
    moment = (1 / 6 - 1 / math.pi**2)  # of the profile less a step, twice
    square, edge = 1 + 4 * corner(2) * WIDTH**2, corner(2) * WIDTH**2
    # parts see 0.123 of a corner's WIDTH^2 where the integral is 0.117
    bodies = {"a_disk": (2, "{disk: {center: [0, 0], radius: 0.5}}",
                         math.pi / 4 * (1 + 2 * moment * (WIDTH / 0.5)**2), 1e-4),
              "a_ball": (3, "{sphere: {center: [0, 0, 0], radius: 0.5}}",
                         math.pi / 6 * (1 + 6 * moment * (WIDTH / 0.5)**2), 1e-4),
              "a_square": (2, "{box: {min: [0, 0], max: [1, 1]}}", square, 2e-4),
              "a_cube": (3, "{box: {min: [0, 0, 0], max: [1, 1, 1]}}",
                         1 + 12 * edge * (1 - 2 * WIDTH) + 8 * corner(3) * WIDTH**3, 4e-4)}
    with folder() as d:
        for name, (dim, shape, volume, tolerance) in bodies.items():
            write(d, "blob.yaml", BLOB.replace("DIM", str(dim)).replace("SHAPE", shape))
            got = run("mesh", "blob.yaml", "--json", cwd=d)
            told = json.loads(got.stdout).get("volume") if got.returncode == 0 else None
            expect(name + "_has_the_volume_of_its_smooth_profile", told and near(told, volume, tolerance), (told, volume))
        scene = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scenes", "ring.yaml")
        r = result(d, scene, "bodies.0.method.cells=32")
        larger = result(d, scene, "bodies.0.method={kind: staggered, fractions: smooth, grid: {min: [-0.05, -0.05], "
                        "max: [0.25, 0.25], cells: [48, 48]}}")
        expect("a_larger_grid_changes_nothing_of_a_ring_on_rollers", "failed" not in r and "failed" not in larger and
               all(near(larger["error"][k], r["error"][k], 1e-6) for k in ("l1", "l2", "linf")),
               (r.get("error"), larger.get("error")))
        expect("its_area_is_a_quarter_of_the_rings", near(r["bodies"][0]["volume"], math.pi * 0.03 / 4, 1e-5), r["bodies"])
        a, b = r["probes"]["inner"]["stress"][:2]
        hoop = 100e6 * 5 / 3
        expect("stress_where_a_roller_meets_the_free_boundary_is_good_to_one_cell", near(b, hoop, 0.03) and
               near(a, -100e6, 0.07), (a, b))


QUARTER = """lithe: 1
dimension: 2
bodies:
  - name: quarter
    shape: SHAPE
    material: {model: linear, young_modulus: 1, poisson_ratio: 0.3}
    method: {kind: staggered, cells: 64, fractions: smooth}
    constraints:
      - {where: {plane: {point: [0, 0], normal: [-1, 0]}}, displacement: [0, null]}
      - {where: {plane: {point: [0, 0], normal: [0, -1]}}, displacement: [null, 0]}
    loads: [LOAD]
exact: {displacement: ["UX", "UY"]}
output: {every: last}
time: {kind: static}
"""
RADIAL = "{intersection: [{annulus: {center: [0, 0], inner: 0.5, outer: 1}}, {box: {min: [0, 0], max: [1, 1]}}]}"
HOLE = "{difference: [{box: {min: [0, 0], max: [2, 2]}}, {disk: {center: [0, 0], radius: 0.5}}]}"


# A quarter of a plate whose middle line alone is held upright, one face of the grid thick
LINE = """lithe: 1
bodies:
  - name: plate
    shape:
      intersection:
        - {box: {min: [0, 0, 0], max: [2, 2, 0.2]}}
        - difference:
            - {cylinder: {from: [0, 0, 0], to: [0, 0, 0.2], radius: 1}}
            - {cylinder: {from: [0, 0, -1], to: [0, 0, 1], radius: 0.4}}
    material: {model: linear, young_modulus: 1 MPa, poisson_ratio: 0.3, density: 1000}
    method: {kind: staggered, cells: 32}
    constraints:
      - {where: {normal: [-1, 0, 0], within: 2 deg}, displacement: [0, null, null]}
      - {where: {normal: [0, -1, 0], within: 2 deg}, displacement: [null, 0, null]}
      - {where: {and: [{implicit: "0.81-x^2-y^2"}, {normal: [1, 1, 0], within: 60 deg}]}, displacement: [0, 0, null]}
      - where: {and: [{implicit: "0.81-x^2-y^2"}, {box: {min: [-1, -1, 0.085], max: [2, 2, 0.115]}}]}
        displacement: [null, null, 0]
gravity: [0, 0, -9.81]
time: {kind: static}
output: {every: last, fields: none}
"""


def test_thin_hold():
    """Coarse levels keep what a thin hold holds; without it, they would have a motion that nothing holds."""
    with folder() as d:
        write(d, "line.yaml", LINE)
        for cells in (32, 64):
            result(d, "line.yaml", "bodies.0.method.cells=%d" % cells)
            with open(os.path.join(d, "out", "history.csv")) as file:
                *_, last = csv.DictReader(file)
            expect("thin_hold_%d" % cells, int(last["linear_iterations"]) <= 20, str(last))


def fill(text):
    """Polynomials of angles in those of places."""
    for name, value in (("C2", "((x^2-y^2)/R^2)"), ("S2", "(2*x*y/R^2)"), ("C4", "(8*(x/R)^4-8*(x/R)^2+1)"),
                        ("S4", "(4*x*y*(x^2-y^2)/R^4)"), ("C3", "(4*(x/R)^3-3*x/R)"), ("S3", "(3*y/R-4*(y/R)^3)"),
                        ("R", "sqrt(x^2+y^2)")):
        text = text.replace(name, value)
    return text


def quarters():
    """Lame's ring, a ring that rotates, Kirsch's plate: plane strain, E = 1, nu = 0.3."""
    young, nu, a2 = 1 / 0.91, 3 / 7, 0.25
    lame = "1.3*%g/%g*(0.4 + 1/R^2)" % (a2, 1 - a2)
    spin = "%g*((3+N)*(1-N)/8*%g + (3+N)*(1+N)/8*%g/R^2 - (1-N^2)/8*R^2)" % (1 / young, 1 + a2, a2)
    spin = spin.replace("N", "%.17g" % nu)
    stress = ["1 - 0.25/R^2*(1.5*C2+C4) + 1.5*0.0625/R^4*C4", "-0.25/R^2*(0.5*S2+S4) + 1.5*0.0625/R^4*S4",
              "-0.25/R^2*(0.5*C2-C4) - 1.5*0.0625/R^4*C4"]
    ux = "0.1625*(5.6*x + 1/R*(2.8*x/R + C3) - 0.25/R^3*C3)"
    uy = "0.1625*(-2.4*y + 1/R*(-0.8*y/R + S3) - 0.25/R^3*S3)"
    yield ("a_ring_under_pressure", RADIAL, "{where: {disk: {center: [0, 0], radius: 0.75}}, pressure: 1}",
           "x*(%s)" % lame, "y*(%s)" % lame, (32, 64, 128))
    yield "a_ring_that_rotates", RADIAL, "{body_force: [x, y]}", "x*(%s)" % spin, "y*(%s)" % spin, (32, 64, 128)
    yield ("a_plate_with_a_hole", HOLE, "{where: {or: [{normal: [1, 0]}, {normal: [0, 1]}]}, stress: [[\"%s\", \"%s\"], "
           "[\"%s\", \"%s\"]]}" % (stress[0], stress[1], stress[1], stress[2]), ux, uy, (64, 128))


def test_free_boundaries():
    """Second order in the mean where boundaries are free and rollers meet them; at its worst place first order is left."""
    with folder() as d:
        for name, shape, load, ux, uy, cells in quarters():
            text = QUARTER.replace("SHAPE", shape).replace("LOAD", load).replace("UX", ux).replace("UY", uy)
            write(d, "q.yaml", fill(text) if "hole" in name else text.replace("R^2", "(x^2+y^2)"))
            errors = [result(d, "q.yaml", "bodies.0.method.cells=%d" % n).get("error") for n in cells]
            orders = {k: [math.log2(c[k] / f[k]) for c, f in zip(errors, errors[1:])] if all(errors) else [0]
                      for k in ("l1", "linf")}
            expect(name + "_converges", min(orders["l1"]) > 1.9 and min(orders["linf"]) > 0.9, (orders, errors))


def test_turned():
    """A turn of two sides: nothing to the corotated model, growth to the linear one."""
    scene = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scenes", "turned-square.yaml")
    small = ("bodies.0.method.cells=12", "output.fields=[none]")
    with folder() as d:
        r = result(d, scene, *small)
        expect("a_square_turns_and_nothing_else", "failed" not in r and r["error"]["linf"] < 1e-6 * 0.8, r)
        r = result(d, scene, *small, "bodies.0.material.model=linear")
        # where it belongs: 0.4 (cos 45 degrees - 1) = -0.117; the free side goes outward instead
        expect("under_the_linear_model_it_grows", "failed" not in r and r["probes"]["side"]["displacement"][0] > 0.02, r)


def nifti(n, voxels, affine):
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *n, 1, 1, 1, 1)
    struct.pack_into("<hh", header, 70, 2, 8)
    struct.pack_into("<f", header, 108, 352)
    header[123] = 2
    struct.pack_into("<h", header, 254, 1)
    struct.pack_into("<12f", header, 280, *affine)
    header[344:348] = b"n+1\0"
    return bytes(header) + bytes(voxels)


SCAN = """lithe: 1
bodies:
  - name: block
    shape: {image: {file: block.nii.gz, labels: [1, 2]}}
    material:
      - {where: {label: 1}, model: linear, young_modulus: 1 MPa, poisson_ratio: 0}
      - {model: linear, young_modulus: 2 MPa, poisson_ratio: 0}
    method: {kind: staggered}
    constraints:
      - {where: {plane: {point: [0.0075, 0, 0], normal: [-1, 0, 0]}}, displacement: [0, 0, 0]}
    loads:
      - {where: {normal: [1, 0, 0]}, total_force: [0.4, 0, 0]}
time: {kind: static}
output: {every: last, fields: [nifti, vti]}
"""


def test_scan():
    """Two rods of 4 voxels each, end to end, 2 x 2 voxels of 5 mm across; the voxels' second axis runs along x."""
    n = (6, 12, 5)
    voxels = [(1 if j < 6 else 2) if 2 <= i < 4 and 2 <= j < 10 and 1 <= k < 3 else 0
              for k in range(n[2]) for j in range(n[1]) for i in range(n[0])]
    affine = [0, 5, 0, 0, -5, 0, 0, 50, 0, 0, 5, 0]
    with folder() as d:
        write(d, "block.nii.gz", gzip.compress(nifti(n, voxels, affine)))
        write(d, "block.yaml", SCAN)
        r = result(d, "block.yaml")
        if "failed" in r:
            return expect("a_scan_runs_on_its_own_voxels", False, r)
        body = r["bodies"][0]
        expect("a_scan_runs_on_its_own_voxels", body["elements"] == 32 and near(body["volume"], 32 * 125e-9, 1e-6),
               body)
        # 4 kPa in 20 mm of each
        expect("each_rod_stretches_by_its_own_modulus", near(r["displacement"]["max"], 0.02 * 4e3 * (1e-6 + 0.5e-6), 1e-6),
               r["displacement"])
        with gzip.open(os.path.join(d, "out", "displacement_0000.nii.gz")) as file:
            data = file.read()
        dims = struct.unpack_from("<8h", data, 40)
        matrix = struct.unpack_from("<12f", data, 280)
        expect("volumes_lie_over_the_scan", dims[:6] == (5, 6, 12, 5, 1, 3) and
               all(abs(a - b) < 1e-4 for a, b in zip(matrix, affine)) and struct.unpack_from("<h", data, 68)[0] == 1007,
               (dims, matrix))
        values = struct.unpack_from("<%df" % (3 * len(voxels)), data, 352)
        at = 2 + 6 * (9 + 12 * 1)  # the last voxel of the rod: its middle is 2.5 mm before the end
        expect("they_hold_the_displacement", near(values[at], 4e3 * (20e-9 + 17.5e-9 / 2), 1e-5) and values[0] == 0,
               values[at])
        reader = vtk.vtkNIFTIImageReader()
        reader.TimeAsVectorOff()
        stress = read_vtk(reader, d, "out", "stress_0000.nii.gz")
        expect("vtk_reads_them", stress.GetDimensions() == (6, 12, 5), stress.GetDimensions())
        image = read_vtk(vtk.vtkXMLImageDataReader(), d, "out", "fields_0000.vti")
        labels = array(image.GetCellData(), "label")
        expect("cells_have_the_labels_of_the_scan", sorted(set(labels)) == [1, 2] and len(labels) == 32, labels)


def test_bad_input():
    with folder() as d:
        write(d, "bar.yaml", BAR)
        write(d, "ring.yaml", RING)
        for name, scene, change, says in (
                ("a_grid_beside_the_body_is_told", "bar.yaml",
                 "bodies.0.method={kind: staggered, grid: {min: [3, 3, 3], max: [4, 4, 4], cells: [4, 4, 4]}}",
                 "bodies.0.method.grid: it misses the body, which reaches from (0, 0, 0) to (1, 0.2, 0.3)"),
                ("a_floating_body_is_told", "bar.yaml", "bodies.0.constraints=[]",
                 "nothing holds the body against translation along x, translation along y, translation along z, "
                 "rotation about x"),
                ("so_is_one_that_slides", "bar.yaml", "bodies.0.constraints.2.displacement=[0, null, null]",
                 "nothing holds the body against translation along z; a static run needs"),
                ("in_the_plane_there_are_three_motions", "ring.yaml", "bodies.0.constraints=[]",
                 "against translation along x, translation along y, rotation about z through"),
                ("a_loose_piece_is_named", "bar.yaml",
                 "bodies.0.shape={union: [{box: {min: [0, 0, 0], max: [0.4, 0.2, 0.3]}}, {box: {min: [0.6, 0, 0], "
                 "max: [1, 0.2, 0.3]}}]}", "nothing holds the part around (0.6, 0, 0), one of 2, against"),
                ("a_constraint_beside_the_body_is_told", "bar.yaml",
                 "bodies.0.constraints.0.where={box: {min: [5, 5, 5], max: [6, 6, 6]}}",
                 "bodies.0.constraints.0.where: selects no unknown of the grid"),
                ("a_load_beside_the_body_is_told", "bar.yaml",
                 "bodies.0.loads.0.where={box: {min: [5, 5, 5], max: [6, 6, 6]}}",
                 "bodies.0.loads.0.where: selects nothing of the body's boundary"),
                ("half_needs_the_mixed_formulation", "bar.yaml",
                 "bodies.0={name: a, shape: {box: {min: [0, 0, 0], max: [1, 1, 1]}}, material: {model: linear, "
                 "young_modulus: 1, poisson_ratio: 0.5}, method: {kind: staggered, cells: 2, formulation: "
                 "displacement}}", "only the mixed formulation keeps volumes, got 0.5"),
                ("degrees_are_of_elements", "bar.yaml", "bodies.0.method.degree=2", "it is of elements, got degree"),
                ("so_is_enforce", "bar.yaml", "bodies.0.constraints.0.enforce=weak", "it is of elements, got it"),
                ("nodes_are_of_elements_too", "bar.yaml", "bodies.0.loads.0={where: all, point_force: [1, 0, 0]}",
                 "a grid has no nodes on the boundary"),
                ("a_scan_is_needed_for_its_voxels", "bar.yaml", "output.fields=[nifti]",
                 "nifti holds fields on the voxels of a scan"),
                ("a_resolution_is_needed", "bar.yaml", "bodies.0.method={kind: staggered}",
                 "expected exactly one of cells, cell_size, grid")):
            got = run("check", scene, "--set", change, cwd=d)
            expect(name, got.returncode == 2 and says in got.stderr, got.stdout + got.stderr)


test_bar()
test_forecast()
test_thin()
test_bunny()
test_thesis()
test_shell()
test_thin_hold()
test_smooth()
test_free_boundaries()
test_turned()
test_scan()
test_bad_input()
done()
