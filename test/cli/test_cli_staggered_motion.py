"""Staggered bodies that move: free fall, spin, contact with a floor and with each other, the surface, going on after a stop."""
import csv
import json
import math
import os

from cli import done, expect, folder, run

BALL = """
  - name: %s
    shape: {sphere: {center: [%g, %g, 0], radius: 0.1}}
    material: {model: linear, young_modulus: 30 kPa, poisson_ratio: 0.3, density: 1000}
    method: {kind: %s, cells: 6%s}
"""
MASS = 4 / 3 * math.pi * 0.1**3 * 1000
G = 9.81


def simulate(home, name, text, *options):
    scene, out = os.path.join(home, name + ".yaml"), os.path.join(home, name)
    with open(scene, "w") as stream:
        stream.write("lithe: 1\nbodies:" + text)
    got = run("run", scene, "-o", out, *options)
    if got.returncode not in (0, 3):
        print(got.stdout, got.stderr)
        return {}, []
    with open(os.path.join(out, "result.json")) as stream:
        result = json.load(stream)
    with open(os.path.join(out, "history.csv")) as stream:
        return result, [{k: float(v) for k, v in row.items()} for row in csv.DictReader(stream)]


with folder() as home:
    result, history = simulate(home, "fall", BALL % ("ball", 0.03, 0.5, "staggered", "") + """
gravity: [0, -9.81, 0]
time: {kind: dynamic, duration: 0.1, step: 1/100}
output: {every: last, fields: none}
""")
    expect("free_fall_has_the_momentum_of_its_weight", abs(result["momentum"][1] / (-MASS * G * 0.1) - 1) < 1e-3,
           result["momentum"])
    # the weight acts at the centre, 0.03 m beside the origin
    turn = result["angular_momentum"]
    expect("and_the_angular_momentum_of_its_place",
           abs(turn[2] / (0.03 * result["momentum"][1]) - 1) < 1e-6 and abs(turn[0]) < 1e-7 * abs(turn[2]), turn)

    floor = """
gravity: [0, -9.81, 0]
colliders: [{plane: {point: [0, 0, 0], normal: [0, 1, 0]}}]
contact: {friction: 0.3, damping: 0.02}
time: {kind: dynamic, duration: 0.6, step: 1/100}
output: {every: 0.1, fields: none, surface: [pc2]}
"""
    ball = BALL % ("ball", 0, 0.11, "staggered", "")
    ball = ball.replace("density: 1000}", "density: 1000, damping: {mass: 20}}")
    result, history = simulate(home, "floor", ball + "    embed: {surface: shape}\n" + floor)
    force = result["contact"]["force"]
    expect("a_ball_comes_to_rest_on_the_floor", abs(force / (MASS * G) - 1) < 0.05, result["contact"])
    expect("and_hardly_sinks_in", result["contact"]["penetration"] < 0.005 * 0.2, result["contact"])
    expect("its_surface_is_written", os.path.getsize(os.path.join(home, "floor", "surface.pc2")) > 1000)
    result, history = simulate(home, "nodes", ball + floor.replace(", surface: [pc2]", ""))
    expect("nodes_of_the_boundary_carry_it_too", abs(result["contact"]["force"] / (MASS * G) - 1) < 0.05,
           result["contact"])

    # a ball that slides as it lands, all the way to nu = 0.5: without a matrix, and as with one
    landing = BALL.replace("30 kPa", "100 kPa").replace("0.3, density", "%g, density").replace("radius: 0.1", "radius: 0.05")
    landing = landing.replace("cells: 6", "cells: 10")
    for nu in (0.3, 0.4999, 0.5):
        got = {}
        for linear in ("auto", "cholesky"):
            got[linear], history = simulate(home, "landing", landing % ("ball", 0, 0.055, nu, "staggered", "") + """
    initial: {velocity: [0.3, -1, 0]}
gravity: [0, -9.81, 0]
colliders: [{plane: {point: [0, 0, 0], normal: [0, 1, 0]}}]
contact: {friction: 0.3}
time: {kind: dynamic, integrator: newmark, duration: 0.03, step: 1/500}
output: {every: last, fields: none}
""", "--set", "solver.linear=" + linear)
        auto, other = got["auto"], got["cholesky"]
        expect("a_ball_of_nu_%g_lands_without_a_matrix" % nu, auto["status"] == "done" and auto["solver"]["linear"] == "multigrid",
               auto["solver"])
        expect("as_it_does_with_one", abs(auto["energy"]["kinetic"] / other["energy"]["kinetic"] - 1) < 1e-3,
               (auto["energy"], other["energy"]))

    two = BALL % ("left", -0.11, 0, "staggered", "") + "    initial: {velocity: [1, 0, 0]}\n"
    two += BALL % ("right", 0.11, 0, "dg", ", degree: 1") + "    initial: {velocity: [-1, 0, 0]}\n"
    result, history = simulate(home, "impact", two + """
time: {kind: dynamic, duration: 0.08, step: 1/200}
output: {every: 0.02, fields: none}
""")
    most = max(row["contacts"] for row in history)
    expect("a_staggered_and_a_dg_body_touch", most > 3, history)
    expect("and_keep_their_momentum", all(abs(row["momentum_" + a] - history[0]["momentum_" + a]) < 1e-6 * MASS for row in history for a in "xyz"),
           history)
done()
