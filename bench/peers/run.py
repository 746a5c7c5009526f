#!/usr/bin/env python3
"""Solve one problem with Lithe, dolfinx, FreeFEM and CalculiX side by side, on the same unknowns.

    bench/peers/run.py [--lithe PROGRAM] [--all] [--only WORD] [--csv FILE]

The unit cube, E = 1e5, nu = 0.3, body force 9.81 downwards, clamped at z = 0 (weakly in DG). Every solution's
compliance b.u is held against reference digits on which independent codes agree; a mismatch is an error (status
1). Programs that are not installed are named and left out. One process and one thread a case; CPU seconds.

Penalty: the peers use eta (lambda + 2 mu) / h on interior and clamped faces. Lithe's number form is eq. (20) times
(lambda + 2 mu): area over volume of each neighbour, and twice as much on clamped faces as inside. On cubes half
of eta gives the same interior terms; the clamped ones (and on tetrahedra all) differ, therefore Lithe is held
against digits of its own form, which dolfinx computes too (--all checks that once more).
"""
import argparse
import csv
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PYTHON = "/usr/bin/python3"  # the one that Debian's dolfinx belongs to
PLUGINS = "/usr/lib/freefem++"
DIGITS = 2e-6  # the reference digits below are given to this relative accuracy or better

# name: cell, cells an axis, element, degree, eta, reference digits of the peers' form, of Lithe's form, long
PROBLEMS = {
    "IP P1 hex 10^3": dict(cell="hexahedron", n=[10] * 3, element="DPC", degree=1, eta=20,
                           peers=2.81695505e-4, lithe=2.80391661e-4),
    "IP P2 hex 10^3": dict(cell="hexahedron", n=[10] * 3, element="DPC", degree=2, eta=40,
                           peers=2.94883907e-4, lithe=2.94737205e-4),
    "IP P1 hex 20^3": dict(cell="hexahedron", n=[20] * 3, element="DPC", degree=1, eta=20,
                           peers=2.89566e-4, lithe=None),
    "IP P1 tet 5x5x7x6": dict(cell="tetrahedron", n=[5, 5, 7], element="DG", degree=1, eta=20,
                              peers=2.89099e-4, lithe=2.88330248e-4),
    "IP P2 tet 5x5x7x6": dict(cell="tetrahedron", n=[5, 5, 7], element="DG", degree=2, eta=40,
                              peers=2.95159e-4, lithe=None),
    "IP Q1 hex 10^3": dict(cell="hexahedron", n=[10] * 3, element="DQ", degree=1, eta=20,
                           peers=2.93462e-4, lithe=None, long=True),
    "IP P1 hex 30^3": dict(cell="hexahedron", n=[30] * 3, element="DPC", degree=1, eta=20,
                           peers=2.92220e-4, lithe=None, long=True),
    "IP P2 hex 20^3": dict(cell="hexahedron", n=[20] * 3, element="DPC", degree=2, eta=40,
                           peers=2.95836833e-4, lithe=None, long=True),
    "CG Q1 hex 15^3": dict(cell="hexahedron", n=[15] * 3, element="CG", degree=1, eta=0,
                           peers=2.94665530e-4, lithe=2.94665530e-4),
    "CG Q1 hex 40^3": dict(cell="hexahedron", n=[40] * 3, element="CG", degree=1, eta=0,
                           peers=2.95987548e-4, lithe=2.95987548e-4, long=True),
}


class Unavailable(Exception):
    """A case that this machine or this version cannot run; the text says why."""


def run_child(command, env=None, cwd=None):
    """Exit status, standard output, standard error, CPU seconds and peak bytes of a command on one thread."""
    environment = dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", **(env or {}))
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        child = subprocess.Popen(command, stdout=out, stderr=err, env=environment, cwd=cwd)
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        texts = []
        for file in (out, err):
            file.seek(0)
            texts.append(file.read().decode(errors="replace"))
    return child.returncode, texts[0], texts[1], usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024


def last_json(text):
    for line in reversed(text.splitlines()):
        if line.startswith("{"):
            return json.loads(line)
    return None


def why(text):
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("INFO")]
    return lines[-1].strip() if lines else "no message"


# ---------------------------------------------------------------------------------------------- the programs


def run_dolfinx(problem, solver, lithe_form=False):
    case = dict(cell=problem["cell"], n=problem["n"], element=problem["element"], degree=problem["degree"],
                eta=problem["eta"], clamp=problem["eta"], edge=0.1 if problem["cell"] == "tetrahedron"
                else 1 / problem["n"][0], scale="edge", solver=solver)
    if lithe_form and problem["cell"] == "hexahedron":
        case.update(clamp=2 * problem["eta"])
    elif lithe_form:
        case.update(scale="local", eta=problem["eta"] / 2, clamp=2 * problem["eta"])
    command = [PYTHON, HERE / "dolfinx_cube.py", json.dumps(case)]
    status, out, err, _, memory = run_child(command)
    row = last_json(out)
    if status != 0 or row is None:
        raise Unavailable(why(err))
    row["memory"] = memory
    return row


def run_freefem(problem, solver):
    n, penalty = problem["n"], problem["eta"] / 0.1
    command = ["FreeFem++", "-nw", "-v", "0", HERE / "freefem_cube.edp", "--case", problem["degree"], n[0], n[2],
               penalty, solver]
    status, out, err, _, memory = run_child([str(word) for word in command], env={"FF_LOADPATH": PLUGINS})
    row = last_json(out)
    if status != 0 or row is None:
        raise Unavailable(why(out + err))
    row["memory"] = memory
    return row


def write_deck(path, n, solver):
    """The cube as a CalculiX deck of C3D8 elements."""
    node = lambda i, j, k: 1 + i + (n + 1) * (j + (n + 1) * k)
    axis = range(n + 1)
    with open(path, "w") as f:
        f.write("*NODE, NSET=ALL\n")
        for k in axis:
            for j in axis:
                for i in axis:
                    f.write(f"{node(i, j, k)}, {i / n:.15g}, {j / n:.15g}, {k / n:.15g}\n")
        f.write("*ELEMENT, TYPE=C3D8, ELSET=CUBE\n")
        number = 0
        for k in range(n):
            for j in range(n):
                for i in range(n):
                    number += 1
                    corners = [node(i + a, j + b, k + c) for c in (0, 1)
                               for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
                    f.write(f"{number}, " + ", ".join(map(str, corners)) + "\n")
        f.write("*NSET, NSET=BASE, GENERATE\n" f"1, {(n + 1) ** 2}\n")
        f.write("*BOUNDARY\nBASE, 1, 3\n*MATERIAL, NAME=SOFT\n*ELASTIC\n1e5, 0.3\n*DENSITY\n1.\n")
        f.write("*SOLID SECTION, ELSET=CUBE, MATERIAL=SOFT\n*STEP\n*STATIC" +
                ("" if solver == "SPOOLES" else ", SOLVER=ITERATIVE CHOLESKY") + "\n")
        f.write("*DLOAD\nCUBE, GRAV, 9.81, 0., 0., -1.\n*NODE PRINT, NSET=ALL\nU\n*END STEP\n")


def deck_compliance(path, n):
    """b.u from the printed displacements: the consistent load of a node is its share of the eight cells."""
    share = [0.5 if i in (0, n) else 1.0 for i in range(n + 1)]
    total = 0.0
    for line in open(path):
        words = line.split()
        if len(words) == 4 and words[0].isdigit():
            index = int(words[0]) - 1
            i, j, k = index % (n + 1), index // (n + 1) % (n + 1), index // (n + 1) ** 2
            total -= share[i] * share[j] * share[k] * float(words[3])
    return 9.81 * total / n**3


def run_calculix(problem, solver):
    n = problem["n"][0]
    with tempfile.TemporaryDirectory() as folder:
        write_deck(Path(folder) / "cube.inp", n, solver)
        status, out, err, cpu, memory = run_child(["ccx", "-i", "cube"], cwd=folder)
        if status != 0:
            raise Unavailable(why(out + err))
        compliance = deck_compliance(Path(folder) / "cube.dat", n)
    return dict(dofs=3 * n * (n + 1) ** 2, assemble=None, set_up=None, solve=cpu, iterations=None,
                compliance=compliance, memory=memory)


def lithe_scene(problem, solver, penalty):
    method = dict(kind="cg" if problem["element"] == "CG" else "dg", cells=problem["n"],
                  mesh="hexahedra" if problem["cell"] == "hexahedron" else "tetrahedra", degree=problem["degree"])
    constraint = dict(where=dict(box=dict(min=[-1, -1, -1], max=[2, 2, 0])), displacement=[0, 0, 0])
    if method["kind"] == "dg":
        method["penalty"] = penalty
    else:
        constraint["enforce"] = "strong"
    return dict(
        lithe=1,
        bodies=[dict(name="cube", shape=dict(box=dict(min=[0, 0, 0], max=[1, 1, 1])),
                     material=dict(model="linear", young_modulus=1e5, poisson_ratio=0.3, density=1),
                     method=method, constraints=[constraint])],
        gravity=[0, 0, -9.81], time="static", solver=dict(linear=solver, tolerance=1e-8, threads=1),
        output=dict(fields=["none"]))


def run_lithe(program, problem, solver, penalty):
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "cube.yaml"
        scene.write_text(json.dumps(lithe_scene(problem, solver, penalty)))
        status, out, err, cpu, memory = run_child(
            [program, "run", scene, "-o", Path(folder) / "out", "--quiet"])
        if status != 0:
            raise Unavailable(why(err))
        result = json.loads((Path(folder) / "out/result.json").read_text())
    clock = result["time"]
    busy = min(1.0, cpu / clock["total"])  # the program's clock is the wall's; other jobs may share the core
    return dict(dofs=result["bodies"][0]["dofs"], assemble=busy * (clock["integrate"] + clock["assemble"]),
                set_up=busy * clock["factor"], solve=busy * clock["solve"],
                iterations=result["solver"]["iterations"] if result["solver"]["linear"] != "cholesky" else 0,
                compliance=2 * result["energy"]["work"], memory=memory)


# ------------------------------------------------------------------------------------------------- the table


def installed(*packages):
    """Which of these Debian packages are missing."""
    query = ["dpkg-query", "-W", "-f=${Status}"]
    return [p for p in packages
            if "ok installed" not in subprocess.run(query + [p], capture_output=True, text=True).stdout]


def find_programs(lithe):
    """Which programs there are; says what is missing."""
    missing = {"dolfinx": installed("python3-dolfinx"), "FreeFEM": installed("freefem++", "libfreefem++"),
               "CalculiX": installed("calculix-ccx")}
    for name, packages in missing.items():
        if packages:
            print(f"{name} is left out: install {' '.join(packages)}")
    found = {name for name, packages in missing.items() if not packages}
    if shutil.which(lithe) or Path(lithe).is_file():
        found.add("Lithe")
    else:
        print(f"Lithe is left out: no program {lithe}; build it with ./dev build")
    return found


def cases_of(problem, lithe, found):
    """(program, solver, what to call, reference compliance or None) of one problem."""
    is_dg, is_tet = problem["element"] != "CG", problem["cell"] == "tetrahedron"
    large = problem["n"][0] ** 3 * problem["degree"] > (4000 if is_dg else 40000)
    cases = []
    if "dolfinx" in found:
        solvers = ["gamg"] + (["pbjacobi"] if is_dg else ["hypre"]) + ([] if large else ["mumps", "cholmod"])
        solvers += ["gamg-monomials"] if problem["element"] == "DPC" else []
        for solver in solvers:
            cases.append(("dolfinx", solver, lambda s=solver: run_dolfinx(problem, s), problem["peers"]))
    if "FreeFEM" in found and is_tet:
        for solver in ("MUMPS", "UMFPACK") if problem["degree"] == 1 else ("MUMPS",):
            cases.append(("FreeFEM", solver, lambda s=solver: run_freefem(problem, s), problem["peers"]))
    if "CalculiX" in found and not is_dg:
        for solver in ["ICCG"] + ([] if large else ["SPOOLES"]):
            cases.append(("CalculiX", solver, lambda s=solver: run_calculix(problem, s), problem["peers"]))
    if "Lithe" in found and problem["element"] != "DQ":
        for solver in ["pcg", "multigrid"] + ([] if large else ["cholesky"]):
            cases.append(("Lithe", solver, lambda s=solver: run_lithe(lithe, problem, s, problem["eta"] / 2),
                          problem["lithe"]))
        if is_dg:
            cases.append(("Lithe", "auto, own penalty", lambda: run_lithe(lithe, problem, "auto", "auto"), None))
    return cases


def seconds(value):
    return "-" if value is None else f"{value:.3f}"


def total(row):
    return sum(row[key] or 0 for key in ("assemble", "set_up", "solve"))


def print_row(program, solver, row, verdict):
    iterations = "-" if row["iterations"] is None else str(row["iterations"])
    print(f"  {program:9}{solver:18}{row['dofs']:9}{seconds(row['assemble']):>10}{seconds(row['set_up']):>9}"
          f"{seconds(row['solve']):>9}{total(row):9.3f}{iterations:>7}{row['memory'] / 2**20:8.0f}"
          f"  {row['compliance']:.9e}  {verdict}", flush=True)


def judge(row, reference):
    if reference is None:
        return "-", True
    error = abs(row["compliance"] / reference - 1)
    return ("agrees", True) if error < DIGITS else (f"WRONG: expected {reference:.9e}", False)


def lithe_reference(name, problem, found):
    """Lithe's digits for a problem: as listed, else of the same form in dolfinx."""
    if problem["lithe"] is None and problem["element"] in ("DPC", "DG") and "dolfinx" in found:
        try:
            problem["lithe"] = run_dolfinx(problem, "gamg", lithe_form=True)["compliance"]
        except Unavailable as error:
            print(f"  no reference for Lithe's penalty in {name}: {error}")


def check_listed(found):
    """The digits listed for Lithe's form once more from dolfinx."""
    good = True
    for name, problem in PROBLEMS.items():
        if problem["lithe"] and problem["element"] in ("DPC", "DG") and "dolfinx" in found:
            verdict, agrees = judge(run_dolfinx(problem, "mumps", lithe_form=True), problem["lithe"])
            print(f"{name}: Lithe's form in dolfinx {verdict}")
            good = good and agrees
    return good


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--lithe", default=str(ROOT / "build/release/apps/lithe/lithe"), help="the program")
    parser.add_argument("--all", action="store_true", help="the long problems too")
    parser.add_argument("--only", default="", help="problems whose name holds this")
    parser.add_argument("--csv", help="write the rows into this file as well")
    options = parser.parse_args()

    found = find_programs(options.lithe)
    good = check_listed(found) if options.all else True
    rows = []
    for name, problem in PROBLEMS.items():
        if options.only not in name or (problem.get("long") and not (options.all or options.only)):
            continue
        if "Lithe" in found:
            lithe_reference(name, problem, found)
        print(f"\n{name}\n  {'program':9}{'solver':18}{'unknowns':>9}{'assemble':>10}{'set up':>9}{'solve':>9}"
              f"{'total s':>9}{'iter.':>7}{'MiB':>8}  compliance b.u")
        for program, solver, call, reference in cases_of(problem, options.lithe, found):
            try:
                row = call()
            except Unavailable as error:
                print(f"  {program:9}{solver:18} left out: {error}", flush=True)
                continue
            verdict, agrees = judge(row, reference)
            good = good and agrees
            print_row(program, solver, row, verdict)
            rows.append(dict(problem=name, program=program, solver=solver, **row))

    if options.csv and rows:
        with open(options.csv, "w", newline="") as f:
            writer = csv.DictWriter(f, fieldnames=list(rows[0]))
            writer.writeheader()
            writer.writerows(rows)
    if not good:
        print("\na compliance does not agree with the reference", file=sys.stderr)
    return 0 if good else 1


sys.exit(main())
