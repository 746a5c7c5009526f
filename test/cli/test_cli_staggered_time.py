"""Staggered bodies in time: orders of the integrators, what they conserve, holds that move, pressure that follows."""
import json
import math
import os

from cli import done, expect, folder, run

# A soft block on a wall, pulled down more and more: smooth in time.
SWING = """lithe: 1
dimension: 2
bodies:
  - name: block
    shape: {polygon: [[0, 0], [1, 0.05], [1, 0.5], [0, 0.45]]}
    material: {model: linear, young_modulus: 40, poisson_ratio: 0.3, density: 1}
    method: {kind: staggered, cells: 8}
    constraints: [{where: {plane: {point: [0, 0], normal: [-1, 0]}}, displacement: [0, 0]}]
    loads: [{body_force: [0, "-40*t^3"]}]
time: {kind: dynamic, duration: 0.4, step: 1/40, integrator: %s}
solver: {tolerance: 1e-12}
probes: [{name: tip, point: [0.9, 0.3]}]
output: {every: last, fields: none}
"""
# A free disk that breathes, falls and turns.
FLIGHT = """lithe: 1
dimension: 2
bodies:
  - name: disk
    shape: {disk: {center: [0.1, 0.2], radius: 0.5}}
    material: {model: linear, young_modulus: 100, poisson_ratio: 0.3, density: 2}
    method: {kind: staggered, cells: 12}
    initial: {velocity: ["0.2+0.3*(x-0.1)", "-0.2*(y-0.2)+0.1"]}
gravity: [0, %g]
time: {kind: dynamic, duration: 0.5, step: 1/50, integrator: %s}
solver: {tolerance: 1e-12}
output: {every: 0.1, fields: none}
"""
CARRIED = """lithe: 1
dimension: 2
bodies:
  - name: disk
    shape: {disk: {center: [0.013, 0.02], radius: 1}}
    material: {model: linear, young_modulus: 1 kPa, poisson_ratio: 0.3, density: 2}
    method: {kind: staggered, cells: 10}
    constraints: [{where: %s, displacement: ["0.5*3*t^2", "-t"]}]
    initial: {velocity: [0, -1]}
gravity: [0, -10]
time: %s
solver: {tolerance: 1e-12}
probes: [{name: middle, point: [0.1, 0.1]}]
output: {every: last, fields: none}
"""
# A square that its left strip turns by a right angle, pressed from its far side.
TURNED = """lithe: 1
dimension: 2
bodies:
  - name: square
    shape: {box: {min: [0, 0], max: [1, 1]}}
    material: {model: corotated, young_modulus: 1 kPa, poisson_ratio: 0.3, density: 1}
    method: {kind: staggered, cells: 8}
    constraints:
      - where: {box: {min: [-1, -1], max: [0.3, 2]}}
        position: ["x*cos(pi/2*t)-y*sin(pi/2*t)", "x*sin(pi/2*t)+y*cos(pi/2*t)"]
    loads: [{where: {normal: [1, 0]}, pressure: 2, follower: %s}]
gravity: [0, 0]
time: {kind: quasistatic, steps: 10, duration: 1}
probes: [{name: corner, point: [1, 1]}]
output: {every: last, fields: none}
"""


def simulate(where, text, *sets):
    with open(os.path.join(where, "scene.yaml"), "w") as stream:
        stream.write(text)
    options = [word for change in sets for word in ("--set", change)]
    got = run("run", "scene.yaml", "--json", "--quiet", "-o", "out", *options, cwd=where)
    return json.loads(got.stdout) if got.returncode == 0 else {"failed": got.stderr}


def tip(r):
    return r["probes"]["tip"]["displacement"][1]


def test_orders(home):
    """Three steps, each half of the one before: differences fall by 2 or 4."""
    ends = {}
    for integrator, order in (("implicit-euler", 1), ("newton-euler", 1), ("bdf2", 2), ("newmark", 2)):
        got = [tip(simulate(home, SWING % integrator, "time.step=1/%d" % n)) for n in (80, 160, 320)]
        observed = math.log2((got[0] - got[1]) / (got[1] - got[2]))
        expect("%s_is_of_order_%d" % (integrator, order), abs(observed - order) < 0.2, (got, observed))
        ends[integrator] = got[2] + (got[2] - got[1]) / (2**order - 1)
    most = max(ends.values())
    expect("all_tend_to_one_motion", all(abs(e - most) < 2e-3 * abs(most) for e in ends.values()), ends)


def test_flight(home):
    for integrator in ("implicit-euler", "newton-euler", "bdf2", "newmark"):
        r = simulate(home, FLIGHT % (-3, integrator))
        mass = 2 * math.pi * 0.25
        expect("momentum_of_flight_by_" + integrator,
               abs(r["momentum"][0] - 0.2 * mass) < 1e-8 * mass and
               abs(r["momentum"][1] - (0.1 - 1.5) * mass) < 1e-8 * mass, r["momentum"])
        r = simulate(home, FLIGHT % (0, integrator))
        # x p_y - y p_x about the origin is that of the centre, which moves along (0.2, 0.1) from (0.1, 0.2)
        expect("angular_momentum_of_flight_by_" + integrator,
               abs(r["angular_momentum"][2] - (0.1 * 0.1 - 0.2 * 0.2) * mass) < 1e-8 * mass, r["angular_momentum"])
    first = simulate(home, FLIGHT % (0, "newmark"), "time.duration=1/50")["energy"]
    last = simulate(home, FLIGHT % (0, "newmark"), "time.duration=2")["energy"]
    expect("newmark_keeps_the_energy", abs(last["strain"] + last["kinetic"] - first["strain"] - first["kinetic"]) <
           1e-9 * first["kinetic"], (first, last))
    last = simulate(home, FLIGHT % (0, "implicit-euler"), "time.duration=2")["energy"]
    expect("implicit_euler_damps", last["strain"] + last["kinetic"] < 0.99 * (first["strain"] + first["kinetic"]), last)


def test_moving_holds(home):
    r = simulate(home, CARRIED % ("all", "{kind: quasistatic, steps: 2, duration: 2}"), "gravity=[0, 0]")
    u = r["probes"]["middle"]["displacement"]
    expect("a_carried_body_does_not_strain", abs(u[0] - 6) < 1e-9 and abs(u[1] + 2) < 1e-9 and
           r["energy"]["strain"] < 1e-15, (u, r["energy"]))
    r = simulate(home, CARRIED % ("{disk: {center: [0, 0], radius: 3}}",
                                  "{kind: dynamic, duration: 0.5, step: 1/20}"))
    weight = 2 * math.pi
    force = r["reaction"]["bodies.0.constraints.0"]
    expect("what_accelerates_it_is_mass_times_acceleration",
           abs(force[0] - 3 * weight) < 1e-6 * weight and abs(force[1] - 10 * weight) < 1e-6 * weight, (force, weight))


def test_follower(home):
    fixed, turned = [simulate(home, TURNED % word) for word in ("false", "true")]
    rows = [r["reaction"]["bodies.0.constraints.0"] for r in (fixed, turned)]
    # 2 Pa on a side of 1 m: against x as it was, or against the side's normal, which is y now
    expect("pressure_stays_as_it_was", abs(rows[0][0] - 2) < 1e-6 and abs(rows[0][1]) < 1e-6, rows)
    expect("or_follows_the_side", abs(rows[1][1] - 2) < 0.01 and abs(rows[1][0]) < 0.01, rows)
    u = turned["probes"]["corner"]["displacement"]
    expect("the_square_is_turned", abs(1 + u[0] + 1) < 0.02 and abs(u[1]) < 0.02, u)


with folder() as folder_name:
    test_orders(folder_name)
    test_flight(folder_name)
    test_moving_holds(folder_name)
    test_follower(folder_name)
done()
