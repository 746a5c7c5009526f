"""Cuts that end inside a body, from the command line: their two sides collide."""
import csv
import json
import os
import signal

from cli import done, expect, folder, run
from resume import check_resumes, write

# held at the left, cut from above down to its last row of elements
BLOCK = """lithe: 1
bodies:
  - name: block
    shape: {box: {min: [0, 0, 0], max: [0.2, 0.1, 0.1]}}
    material: {model: corotated, young_modulus: 100 kPa, poisson_ratio: 0.3, density: 1000, damping: {stiffness: 2e-3}}
    method: {kind: dg, mesh: hexahedra, cells: [8, 4, 2], degree: 1}
    constraints: [{where: {plane: {point: [0.001, 0, 0], normal: [-1, 0, 0]}}, displacement: [0, 0, 0]}]
    loads: [{where: {plane: {point: [0.199, 0, 0], normal: [1, 0, 0]}}, traction: [LOAD, 0, 0]}]
cuts:
  - {at: 0.01, plane: {point: [0.11, 0, 0], normal: [1, 0, 0]}, within: {box: {min: [0, 0.025, -1], max: [1, 1, 1]}}, space: rest}
time: {kind: dynamic, duration: 0.25, step: 1/200}
probes: [{name: left, point: [0.1099, 0.0999, 0.05]}, {name: right, point: [0.1101, 0.0999, 0.05]}]
output: {every: 1/100, fields: [vtu], checkpoint: 0}
"""
CELL = 0.025
# nothing holds it, and it turns while it is cut where it is
FREE = """lithe: 1
bodies:
  - name: block
    shape: {box: {min: [-0.1, -0.05, -0.05], max: [0.1, 0.05, 0.05]}}
    material: {model: corotated, young_modulus: 30 kPa, poisson_ratio: 0.3, density: 1000}
    method: {kind: dg, mesh: hexahedra, cells: [8, 4, 2], degree: 1}
    initial: {velocity: ["20*y", "3*exp(-(x/0.03)^2)", "5*y"]}
cuts:
  - {at: 0.02, plane: {point: [0.01, 0, 0], normal: [1, 0.1, 0.2]}, within: {box: {min: [-1, -0.02, -1], max: [1, 1, 1]}}}
time: {kind: dynamic, duration: 0.15, step: 1/400}
contact: {friction: 0.2}
output: {every: 1/100, fields: [], checkpoint: 0}
"""


def table(d, name):
    with open(os.path.join(d, "out", name)) as file:
        return [{k: float(v) for k, v in row.items() if k != "name"} for row in csv.DictReader(file)]


def solve(d, text, *options):
    write(d, "scene.yaml", text)
    got = run("run", "scene.yaml", "-q", "-o", "out", *options, cwd=d)
    return got, json.load(open(os.path.join(d, "out", "result.json"))) if got.returncode == 0 else None


def overlap(d):
    """How far the upper ends of the two sides have passed through each other, at each output time."""
    rows = table(d, "probes.csv")
    name = lambda which: [k for k in rows[0] if k.startswith(which) and k.endswith("x") and "xx" not in k][0]
    return [row[name("left")] - row[name("right")] for row in rows]


with folder() as d:
    got, result = solve(d, BLOCK.replace("LOAD", "-500"))
    expect("a_crack_is_not_a_second_piece", result["topology"][0]["pieces"] == 1 and result["topology"][0]["split"] > 0, result["topology"])
    closed = max(overlap(d))
    expect("its_sides_stop_each_other", closed < 0.02 * CELL and result["contact"]["penetration"] < 0.02 * CELL, closed)
    pressed = result["contact"]["force"]
    expect("and_carry_most_of_the_load", 0.4 * 500 * 0.01 < pressed < 0.9 * 500 * 0.01, pressed)
    solve(d, BLOCK.replace("LOAD", "-500"), "--set", "contact={bodies: false}")
    expect("which_pass_through_each_other_without_contact", max(overlap(d)) > 40 * closed, (closed, max(overlap(d))))
    got, result = solve(d, BLOCK.replace("LOAD", "-500"), "--set", "time={kind: quasistatic, duration: 1, steps: 2}", "--set", "output.every=1/2")
    expect("in_equilibrium_too", got.returncode == 0 and result["solver"]["converged"] and max(overlap(d)) < 0.02 * CELL, got.stderr)
    expect("with_the_same_force", abs(result["contact"]["force"] / pressed - 1) < 0.02, (result["contact"], pressed))

with folder() as d:
    got, result = solve(d, BLOCK.replace("LOAD", "0"))
    rows = table(d, "history.csv")
    expect("a_crack_alone_moves_nothing", max(row["strain_energy"] + row["kinetic_energy"] for row in rows) < 1e-20, rows)

# all triangles of a crack one element deep reach to its front
with folder() as d:
    shallow = BLOCK.replace("LOAD", "-500").replace("[0, 0.025, -1]", "[0, 0.075, -1]")
    got, result = solve(d, shallow, "--set", "time={kind: quasistatic, duration: 1, steps: 2}", "--set", "output.every=1/2")
    closed = max(overlap(d))
    expect("a_crack_of_one_element_closes_too", got.returncode == 0 and result["solver"]["converged"] and closed < 0.02 * CELL and
           result["contact"]["force"] > 0.1 * 500 * 0.01, (closed, result["contact"]))
    solve(d, shallow, "--set", "contact={bodies: false}", "--set", "time={kind: quasistatic, duration: 1, steps: 2}", "--set", "output.every=1/2")
    expect("and_overlaps_without_contact", max(overlap(d)) > 10 * max(closed, 1e-4 * CELL), (closed, max(overlap(d))))

for kind in ("implicit-euler", "bdf2"):
    with folder() as d:
        got, result = solve(d, BLOCK.replace("LOAD", '"800*cos(12*t)"'), "--set", "time.integrator=" + kind, "--set", "time.duration=0.5")
        gap = overlap(d)
        expect("a_crack_opens (%s)" % kind, min(gap) < -0.5 * CELL, gap)
        expect("and_closes_and_no_further (%s)" % kind, -1e-3 * CELL < max(gap) < 0.05 * CELL and got.returncode == 0, gap)

with folder() as d:
    got, result = solve(d, FREE)
    rows = table(d, "history.csv")
    mass = 2
    expect("cracks_of_a_free_body_keep_its_momentum", max(abs(row["momentum_" + a] - rows[0]["momentum_" + a]) for row in rows for a in "xyz") < 1e-11 * mass, rows[-1])
    total = [row["strain_energy"] + row["kinetic_energy"] for row in rows]
    expect("and_give_no_energy", got.returncode == 0 and all(b < 1.01 * a for a, b in zip(total, total[1:])), total)
    expect("their_sides_did_meet", any(row["contacts"] > 0 and row["t"] > 0.02 for row in rows) and result["topology"][0]["pieces"] == 1, rows)

check_resumes("a crack that closes", BLOCK.replace("LOAD", "-500"), [(5, signal.SIGKILL)], ["contact.friction=0.3", "time.duration=0.1"])
done()
