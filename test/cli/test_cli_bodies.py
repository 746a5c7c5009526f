"""Several bodies from outside: they rest on each other, collide, and are tied."""
import json
import math
import os

from cli import check, done, expect, folder, run

os.environ["OMP_WAIT_POLICY"] = "passive"  # other tests want their cores

STACK = """lithe: 1
bodies:
  - name: lower
    shape: {box: {min: [-0.1, 0.0005, -0.1], max: [0.1, 0.1, 0.1]}}
    material: {model: corotated, young_modulus: 1e5, poisson_ratio: 0.3, density: 1000, damping: {stiffness: 5e-3}}
    method: {kind: dg, mesh: hexahedra, cells: [2, 1, 2], degree: 1}
  - name: upper
    shape: {box: {min: [-0.08, 0.101, -0.07], max: [0.09, 0.2, 0.08]}}
    material: {model: corotated, young_modulus: 1e5, poisson_ratio: 0.3, density: 1000, damping: {stiffness: 5e-3}}
    method: {kind: dg, mesh: tetrahedra, cells: [1, 1, 1], degree: 1}
gravity: [0, -9.81, 0]
colliders:
  - plane: {point: [0, 0, 0], normal: [0, 1, 0]}
contact: {friction: 0.3}
time: {kind: dynamic, duration: 0.6, step: 1/120}
output: {every: last}
"""

# the same two as parts of one body, not so near, and a third one on top
PARTS = """lithe: 1
bodies:
  - name: both
    shape: {union: [{box: {min: [-0.1, 0.0005, -0.1], max: [0.1, 0.1, 0.1]}}, {box: {min: [-0.08, 0.12, -0.07], max: [0.09, 0.2, 0.08]}}], resolution: 0.03}
    material: &soft {model: corotated, young_modulus: 1e5, poisson_ratio: 0.3, density: 1000, damping: {stiffness: 5e-3}}
    method: {kind: dg, cells: 4, degree: 1}
  - name: top
    shape: {box: {min: [-0.05, 0.201, -0.05], max: [0.06, 0.26, 0.05]}}
    material: *soft
    method: {kind: cg, mesh: hexahedra, cells: [2, 1, 2]}
gravity: [0, -9.81, 0]
colliders:
  - plane: {point: [0, 0, 0], normal: [0, 1, 0]}
contact: {friction: 0.3}
probes: [{name: upper, point: [0, 0.16, 0]}]
time: {kind: dynamic, duration: 0.35, step: 1/120}
output: {every: last}
"""

# a soft ball that flies at a hard cube, free in space
IMPACT = """lithe: 1
bodies:
  - name: ball
    shape: {sphere: {center: [-0.12, 0.01, 0.02], radius: 0.1}}
    material: {model: corotated, young_modulus: 2e5, poisson_ratio: 0.3, density: 1000}
    method: {kind: dg, cells: 4, degree: 1}
    initial: {velocity: [2, 0, 0]}
  - name: cube
    shape: {box: {min: [0, -0.1, -0.1], max: [0.2, 0.1, 0.1]}}
    material: {model: corotated, young_modulus: 1e6, poisson_ratio: 0.3, density: 500}
    method: {kind: dg, mesh: hexahedra, cells: 2, degree: 1}
contact: {friction: 0.2}
time: {kind: dynamic, duration: 0.12, step: 1/500}
solver: {tolerance: 1e-11}
output: {every: 0.04}
"""

# a block pressed on a cube, at rest
PRESSED = """lithe: 1
bodies:
  - name: cube
    shape: {box: {min: [-0.1, 0, -0.1], max: [0.1, 0.1, 0.1]}}
    material: {model: corotated, young_modulus: 1e5, poisson_ratio: 0.3}
    method: {kind: dg, mesh: hexahedra, cells: [4, 2, 4], degree: 1}
    constraints: [{where: {plane: {point: [0, 0, 0], normal: [0, -1, 0]}}, displacement: [0, 0, 0]}]
  - name: block
    shape: {box: {min: [-0.1, 0.1, -0.1], max: [0.1, 0.2, 0.1]}}
    material: {model: corotated, young_modulus: 1e5, poisson_ratio: 0.3}
    method: {kind: dg, mesh: hexahedra, cells: [3, 2, 3], degree: 1}
    constraints: [{where: {plane: {point: [0, 0.2, 0], normal: [0, 1, 0]}}, displacement: [0, "-0.01*t", 0]}]
contact: {friction: 0.5}
time: {kind: quasistatic, steps: 2, duration: 1}
output: {every: last}
"""

# a ball that is pressed on a cube and dragged over it: the loads that equilibria with friction used to fail on
DRAGGED = """lithe: 1
bodies:
  - name: cube
    shape: {box: {min: [-0.1, 0, -0.1], max: [0.1, 0.1, 0.1]}}
    material: {model: corotated, young_modulus: 1e5, poisson_ratio: 0.3}
    method: {kind: dg, mesh: hexahedra, cells: [4, 3, 4], degree: 1}
    constraints: [{where: {plane: {point: [0, 0, 0], normal: [0, -1, 0]}}, displacement: [0, 0, 0]}]
  - name: ball
    shape: {sphere: {center: [-0.0391, 0.2, 0.0038], radius: 0.1}}
    material: {model: corotated, young_modulus: 1e5, poisson_ratio: 0.3}
    method: {kind: dg, cells: 4, degree: 1}
    constraints: [{where: {plane: {point: [0, 0.25, 0], normal: [0, 1, 0]}}, displacement: ["0.03*t", "-0.0137*min(2*t,1)", "0.01*t"]}]
contact: {friction: 0.3}
time: {kind: quasistatic, steps: 4, duration: 1}
output: {every: last}
"""

# a quarter of a half ball (its planes of symmetry slide) on a block a thousand times stiffer
HERTZ = """lithe: 1
bodies:
  - name: ball
    shape: {intersection: [{sphere: {center: [0, 0.1, 0], radius: 0.1}}, {box: {min: [0, -0.01, 0], max: [0.2, 0.1, 0.2]}}]}
    material: {model: linear, young_modulus: 1e5, poisson_ratio: 0.3}
    method: {kind: dg, cells: %d, degree: 1}
    constraints:
      - {where: {normal: [-1, 0, 0], within: 1 deg}, displacement: {normal: 0}}
      - {where: {normal: [0, 0, -1], within: 1 deg}, displacement: {normal: 0}}
      - {where: {normal: [0, 1, 0], within: 1 deg}, displacement: [null, -0.008, null]}
  - name: block
    shape: {box: {min: [-0.05, -0.08, -0.05], max: [0.15, 0, 0.15]}}
    material: {model: linear, young_modulus: 1e8, poisson_ratio: 0.3}
    method: {kind: cg, mesh: hexahedra, cells: [%d, 2, %d], degree: 1}
    constraints: [{where: {plane: {point: [0, -0.08, 0], normal: [0, -1, 0]}}, displacement: [0, 0, 0]}]
contact: {friction: 0}
time: static
"""


def approach(force, modulus=1e5, poisson=0.3, radius=0.1):
    """How far a ball between rigid planes gives way at each (Hertz 1882, finite ball: Tatara 1991)."""
    stiff = modulus / (1 - poisson**2)
    a = (3 * force * radius / (4 * stiff)) ** (1 / 3)
    far = (a * a + 4 * radius**2) ** 0.5
    return 3 * force / (4 * stiff * a) - force / (math.pi * modulus) * (
        2 * (1 + poisson) * radius**2 / far**3 + (1 - poisson**2) / far)


def hertz_force(depth):
    low, high = 0, 1e4
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if approach(middle) < depth else (low, middle)
    return low


# a block on a larger one: coincident faces of 0.25 m^2, with nodes of the lower one close beside them
SMALLER = """lithe: 1
bodies:
  - name: low
    shape: {box: {min: [0, 0, 0], max: [1, 1, 0.5]}}
    material: {model: linear, young_modulus: 1e6, poisson_ratio: 0.3}
    method: {kind: %s, cells: [4, 4, 2]}
    constraints: [{where: {normal: [0, 0, -1]}, displacement: [0, 0, 0]}]
  - name: up
    shape: {box: {min: [0.25, 0.25, 0.5], max: [0.75, 0.75, 1]}}
    material: {model: linear, young_modulus: 1e6, poisson_ratio: 0.3}
    method: {kind: cg, cells: [2, 2, 2]}
    loads: [{where: {normal: [0, 0, 1]}, traction: [0, 0, 1000]}]
tie: [{bodies: [low, up]}]
time: static
output: {fields: none}
"""

TIED = """lithe: 1
bodies:
  - name: left
    shape: {box: {min: [0, 0, 0], max: [0.5, 0.2, 0.2]}}
    material: {model: linear, young_modulus: 1e6, poisson_ratio: 0.3}
    method: {kind: dg, mesh: hexahedra, cells: [3, 2, 2], degree: 1}
    constraints: [{where: {not: {normal: [1, 0, 0], within: 1 deg}}, displacement: &field
      ["0.01*x + 0.02*y", "-0.01*y + 0.03*z", "0.02*z - 0.01*x"]}]
  - name: right
    shape: {box: {min: [0.5, 0, 0], max: [1, 0.2, 0.2]}}
    material: {model: linear, young_modulus: 1e6, poisson_ratio: 0.3}
    method: {kind: dg, cells: [3, 3, 1], degree: 2}
    constraints: [{where: {not: {normal: [-1, 0, 0], within: 1 deg}}, displacement: *field}]
tie:
  - {bodies: [left, right], where: {plane: {point: [0.4999, 0, 0], normal: [1, 0, 0]}}}
time: static
exact: {displacement: *field}
"""

# an open box of eight points, closed by a surface of many more
OPEN_BOX = "".join("v %g %g %g\n" % (x, y, z) for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.1, 0.1)) + """\
f 1 2 4 3
f 5 7 8 6
f 1 5 6 2
f 1 3 7 5
f 2 6 8 4
"""
WRAPPED = """lithe: 1
bodies:
  - name: table
    shape: {box: {min: [-0.2, -0.3, -0.2], max: [0.2, -0.101, 0.2]}}
    material: {model: linear, young_modulus: 1e5, poisson_ratio: 0.3, density: 1000}
    method: {kind: dg, mesh: hexahedra, cells: [2, 1, 2], degree: 1}
    constraints: [{where: {normal: [0, -1, 0], within: 1 deg}, displacement: [0, 0, 0]}]
  - name: wrapped
    shape: {mesh: {file: open.obj, repair: wrap}}
    material: {model: corotated, young_modulus: 1e5, poisson_ratio: 0.3, density: 1000, damping: {stiffness: 5e-3}}
    method: {kind: dg, cells: 2, degree: 1}
    embed: {surface: shape}
gravity: [0, -9.81, 0]
time: {kind: dynamic, duration: 0.5, step: 1/120}
output: {every: last}
"""

BENT = """lithe: 1
bodies:
  - name: left
    shape: {box: {min: [0, 0, 0], max: [%s, 0.2, 0.2]}}
    material: {model: corotated, young_modulus: 1e6, poisson_ratio: 0.3, density: 1000}
    method: {kind: dg, mesh: hexahedra, cells: [%d, 2, 2], degree: 2}
    constraints: [{where: {plane: {point: [0, 0, 0], normal: [-1, 0, 0]}}, displacement: [0, 0, 0]}]
%s
gravity: [0, -8, 0]
time: static
"""
RIGHT = """  - name: right
    shape: {box: {min: [0.5, 0, 0], max: [1, 0.2, 0.2]}}
    material: {model: corotated, young_modulus: 1e6, poisson_ratio: 0.3, density: 1000}
    method: {kind: dg, mesh: tetrahedra, cells: [4, 1, 2], degree: 2}
tie: [{bodies: [left, right]}]"""


def write(directory, name, text):
    with open(os.path.join(directory, name), "w") as file:
        file.write(text)


def solve(directory, name, text, *more):
    """Run a scene; its result, or None with the reason told."""
    write(directory, name + ".yaml", text)
    got = run("run", name + ".yaml", "-q", "-o", name, *more, cwd=directory)
    expect(name + "_runs", got.returncode == 0 and got.stderr == "", got.stderr)
    with open(os.path.join(directory, name, "result.json")) as file:
        return json.load(file)


def near(a, b, tolerance):
    return abs(a - b) <= tolerance * abs(b)


with folder() as d:
    stack = solve(d, "stack", STACK)
    lower, upper = (b["mass"] * 9.81 for b in stack["bodies"])
    pair = stack["contact"]["pairs"]
    expect("a_body_carries_the_one_above", len(pair) == 1 and pair[0]["bodies"] == ["lower", "upper"] and
           near(pair[0]["force"], upper, 0.02), (pair, upper))
    expect("the_floor_carries_both", near(stack["contact"]["force"] - pair[0]["force"], lower + upper, 0.02), stack["contact"])
    expect("bodies_hardly_sink_into_each_other", 0 < stack["contact"]["penetration"] < 0.005 * 0.17, stack["contact"])
    apart = solve(d, "apart", STACK, "--set", "contact.bodies=false", "--set", "time.duration=0.3")
    expect("bodies_pass_through_each_other_where_asked", "pairs" not in apart["contact"] and
           apart["bodies"][1]["displacement"]["max"] > 0.05, apart)

    parts = solve(d, "parts", PARTS)
    pair = {tuple(p["bodies"]): p["force"] for p in parts["contact"]["pairs"]}
    top = parts["bodies"][1]["mass"] * 9.81
    # the upper part is a box of 0.17 x 0.08 x 0.15 m with edges cut off
    expect("parts_of_a_body_rest_on_each_other", set(pair) == {("both", "both"), ("both", "top")} and
           0.93 < (pair[("both", "both")] - top) / (0.00204 * 9810) < 1.01 and near(pair[("both", "top")], top, 0.02), pair)
    expect("and_end_where_they_fell", abs(parts["probes"]["upper"]["displacement"][1] + 0.022) < 0.002, parts["probes"])
    through = solve(d, "through", PARTS, "--set", "contact.bodies=false", "--set", "time.duration=0.1")
    expect("and_pass_through_each_other_where_asked", "pairs" not in through["contact"] and
           through["probes"]["upper"]["displacement"][1] < -0.04, through["probes"])

    pressed = solve(d, "pressed", PRESSED)
    below, above = (pressed["reaction"]["bodies.%d.constraints.0" % b][1] for b in (0, 1))
    push = pressed["contact"]["pairs"][0]["force"]
    expect("a_pressed_pair_is_balanced", below > 5 and near(-above, below, 1e-6) and 0.8 * below < push < 1.3 * below, (below, above, push))
    for name, more in (("dragged", ()), ("slippery", ("contact.friction=0",)),
                       ("of_nodes", ("bodies.0.method={kind: cg, mesh: hexahedra, cells: [3, 2, 3]}",
                                     "bodies.1.method={kind: cg, mesh: voxels, cells: 5}"))):
        dragged = solve(d, name, DRAGGED, *(word for value in more for word in ("--set", value)))
        held, drags = (dragged["reaction"]["bodies.%d.constraints.0" % b] for b in (0, 1))
        tangent = math.hypot(held[0], held[2]) / held[1]
        expect(name + "_reactions_balance", dragged["solver"]["residual"] <= 1e-8 and held[1] > 20 and all(
            abs(held[i] + drags[i]) < 1e-6 * held[1] for i in range(3)), (held, drags))
        # the patch under the ball leans by some degrees, more than friction's limit alone would say
        expect(name + "_is_held_back_by_friction", tangent < 0.1 if name == "slippery" else 0.2 < tangent < 0.4, tangent)
    misses = []
    for cells in (6, 10):
        pushed = solve(d, "hertz%d" % cells, HERTZ % (cells, cells, cells))
        misses.append(abs(4 * abs(pushed["reaction"]["bodies.0.constraints.2"][1]) / hertz_force(0.008) - 1))
    expect("a_pressed_ball_pushes_as_theory_says", misses[1] < 0.02 and misses[1] < 0.5 * misses[0], misses)
    conforming = solve(d, "conforming", STACK, "--set", "bodies.0.method.kind=cg", "--set", "time.duration=0.4")
    expect("conforming_and_discontinuous_bodies_touch", near(conforming["contact"]["pairs"][0]["force"], upper, 0.05),
           conforming["contact"])

    start = 2 * 1000 * 4 / 3 * 3.14159 * 0.1**3
    impact = solve(d, "impact", IMPACT)
    p = impact["momentum"]
    ball = impact["bodies"][0]["mass"] * 2
    expect("an_impact_keeps_momentum", near(p[0], ball, 1e-9) and abs(p[1]) + abs(p[2]) < 1e-9 * ball and
           near(ball, start, 0.1), (p, ball))
    expect("and_makes_no_energy", impact["energy"]["kinetic"] + impact["energy"]["strain"] < ball, impact["energy"])
    expect("they_part", impact["contact"]["points"] == 0 and impact["bodies"][1]["displacement"]["max"] > 0.02, impact["contact"])
    for threads in ("1", "3"):
        solve(d, "threads" + threads, IMPACT, "--set", "solver.threads=" + threads)
    bits = [open(os.path.join(d, "threads" + n, "history.csv")).read() for n in ("1", "3")]
    expect("bits_do_not_depend_on_threads", bits[0] == bits[1])

    write(d, "open.obj", OPEN_BOX)
    wrapped = solve(d, "wrapped", WRAPPED)
    expect("a_wrapped_body_rests_on_another", near(wrapped["contact"]["pairs"][0]["force"], 0.008 * 1000 * 9.81, 0.03),
           wrapped["contact"])

    tied = solve(d, "tied", TIED)
    expect("a_tie_passes_linear_fields", tied["error"]["linf"] < 1e-11, tied["error"])
    expect("a_tie_is_told", tied["ties"] == [{"bodies": ["left", "right"], "faces": 12, "face_area": tied["ties"][0]["face_area"],
                                              "springs": 0, "spring_area": 0}] and
           near(tied["ties"][0]["face_area"], 0.04, 1e-12), tied["ties"])
    whole = solve(d, "whole", BENT % ("1", 8, ""))
    halves = solve(d, "halves", BENT % ("0.5", 4, RIGHT))
    expect("tied_halves_bend_as_the_whole", near(halves["displacement"]["max"], whole["displacement"]["max"], 0.005) and
           halves["displacement"]["max"] > 0.2, (halves["displacement"], whole["displacement"]))
    weight = halves["reaction"]["bodies.0.constraints.0"]
    expect("the_held_half_carries_both", near(weight[1], 320, 1e-6), weight)
    gap = solve(d, "gap", (BENT % ("0.5", 4, RIGHT)).replace("min: [0.5, 0, 0]", "min: [0.501, 0, 0]"))
    expect("springs_bridge_a_gap", gap["ties"][0]["faces"] == 0 and gap["ties"][0]["springs"] > 0 and
           near(gap["displacement"]["max"], whole["displacement"]["max"], 0.03), (gap["ties"], gap["displacement"]))
    for kind in ("dg", "cg"):
        beside = solve(d, "smaller", SMALLER % kind)
        expect("springs_leave_out_what_lies_beside: " + kind, near(beside["ties"][0]["spring_area"], 0.25, 1e-12) and
               near(beside["reaction"]["bodies.0.constraints.0"][2], -250, 1e-6), beside["ties"])

    def refuse(name, text, message):
        write(d, "bad.yaml", text)
        check(name, ("run", "bad.yaml", "-q"), err=message + "\n", status=2, cwd=d)

    refuse("an_unknown_body_is_named", TIED.replace("[left, right]", "[left, rihgt]"),
           'bad.yaml:15:21: tie.0.bodies.1: no body has this name, got "rihgt"; expected the name of one of the bodies')
    refuse("a_body_is_not_tied_to_itself", TIED.replace("[left, right]", "[left, left]"),
           'bad.yaml:15:21: tie.0.bodies.1: a body cannot be tied to itself, got "left" twice; expected two bodies')
    refuse("what_is_apart_is_not_tied", (BENT % ("0.5", 4, RIGHT)).replace("min: [0.5, 0, 0]", "min: [0.75, 0, 0]"),
           "lithe: bad.yaml:12:7: tie.0: left and right have nothing to tie: their surfaces are 0.25 m apart where they are nearest, and only "
           "surfaces that face each other within 0.0269 m (a quarter of a cell) are tied; move the bodies together or widen `where`")
    refuse("an_empty_where_is_told", TIED.replace("tie:\n  - {bodies: [left, right], where: {plane: {point: [0.4999",
                                                  "tie:\n  - {bodies: [left, right], where: {plane: {point: [0.7"),
           "lithe: bad.yaml:15:5: tie.0.where: selects nothing of the body's boundary; the body reaches from (0, 0, 0) to (0.5, 0.2, 0.2)")
    loose = BENT % ("0.5", 4, RIGHT.replace("tie: [{bodies: [left, right]}]", "").replace("min: [0.5", "min: [0.8"))
    got = run("check", "loose.yaml", cwd=d) if write(d, "loose.yaml", loose) is None else None
    write(d, "near.yaml", loose.replace("min: [0.8", "min: [0.501"))
    leaning = run("check", "near.yaml", cwd=d)
    expect("check_lets_a_body_lean_on_another_as_run_does", leaning.returncode == 0, leaning.stderr)
    expect("a_loose_body_is_told_in_static_runs", got.returncode == 2 and "nothing holds the body against" in got.stderr, got.stderr)

    surfaces = STACK.replace("output: {every: last}", "output: {every: last, surface: [obj]}").replace("duration: 0.6", "duration: 0.02")
    for name, embed in (("no_body_has", ""), ("the_second_body_has", "    embed: {}\n")):
        with open(os.path.join(d, "surfaces.yaml"), "w") as file:
            file.write(surfaces.replace("gravity:", embed + "gravity:"))
        got = run("run", "surfaces.yaml", "-o", name, "--json", cwd=d)
        result = json.loads(got.stdout)
        warned = [w for w in result["warnings"] if "embed" in json.dumps(w)]
        written = [f for f in os.listdir(os.path.join(d, name)) if f.endswith(".obj")]
        expect(name + "_a_surface_and_that_is_told", bool(warned) == (not embed) and bool(written) == bool(embed) and
               all("surface" not in b for b in result["bodies"]), (warned, written, got.stderr))

done()
