"""Bodies that are cut while they move, from the command line."""
import csv
import json
import os
import signal

from cli import check, done, expect, folder, run
from resume import BENDING, FALLING, check_resumes, write

DROP = FALLING % ("0.2", "[4, 2, 2]", ", sliver: 1e-4") + """cuts:
  - {at: 0, plane: {point: [0.05, 0.05, 0.05], normal: [1, 0, 0.3]}}
  - {at: 0.031, plane: {point: [0.12, 0.05, 0.05], normal: [1, 0.1, 0.2]}}
  - {at: 0.07, plane: {point: [0.1, 0.05, 0.04], normal: [0.1, 0.2, 1]}, space: rest}
time: {kind: dynamic, duration: 0.15, step: 1/200}
probes: [{name: corner, point: [0.19, 0.09, 0.09]}]
output: {every: 1/100, fields: [vtu], surface: [pc2], checkpoint: 0}
"""
BEND = BENDING + """cuts:
  - {at: 0.4, plane: {point: [0, 0.4, 0], normal: [0, 1, 0]}, space: rest}
time: {kind: quasistatic, steps: 8, duration: 1}
probes: [{name: tip, point: [4, 0.5, 0.5]}]
output: {fields: [vtu], checkpoint: 0}
"""


CUBE = """lithe: 1
bodies:
  - name: cube
    shape: {box: {min: [0, 0, 0], max: [1, 1, 1]}}
    material: {young_modulus: 1 MPa, poisson_ratio: 0.4, density: 1000}
    method: {kind: dg, mesh: hexahedra, cells: [5, 5, 5], degree: 1}
    constraints: [{where: {plane: {point: [0, 0.001, 0], normal: [0, -1, 0]}}, displacement: [0, 0, 0]}]
    loads: [{where: {plane: {point: [0, 0.999, 0], normal: [0, 1, 0]}}, traction: [0, -1, 0]}]
cuts:
  - CUT
time: static
output: {fields: [vtu]}
"""

LOSE = """lithe: 1
bodies:
  - name: bar
    shape: {box: {min: [0, 0, 0], max: [1, 0.2, 0.2]}}
    material: {young_modulus: 1e5, poisson_ratio: 0.3, density: 1000}
    method: {kind: dg, cells: [10, 2, 2], degree: 1}
    embed: {}
    constraints: [{where: {plane: {point: [0.001, 0, 0], normal: [-1, 0, 0]}}, displacement: [0, 0, 0]}]
    loads:
      - {where: {plane: {point: [0.999, 0, 0], normal: [1, 0, 0]}}, traction: [0, -10, 0]}
      - {where: {plane: {point: [0.999, 0, 0], normal: [1, 0, 0]}}, point_force: [0, -1, 0]}
  - name: block
    shape: {box: {min: [1, 0, 0], max: [1.2, 0.2, 0.2]}}
    material: {young_modulus: 1e5, poisson_ratio: 0.3, density: 1000}
    method: {kind: dg, cells: [2, 2, 2], degree: 1}
tie: [{bodies: [bar, block]}]
contact: {bodies: false}
gravity: [0, -9.81, 0]
cuts: [{at: 0.025, body: bar, carve: {box: {min: [0.23, -5, -5], max: [0.77, 5, 5]}}, keep: inside, space: rest}]
time: {kind: dynamic, duration: 0.1, step: 0.01}
output: {every: 0.02, fields: [vtu], surface: [pc2], checkpoint: 0}
"""


def solve(d, text, *options):
    write(d, "scene.yaml", text)
    got = run("run", "scene.yaml", "-q", "-o", "out", *options, cwd=d)
    result = json.load(open(os.path.join(d, "out", "result.json"))) if got.returncode == 0 else None
    return got, result


def history(d):
    with open(os.path.join(d, "out", "history.csv")) as file:
        return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]


check_resumes("cut", DROP, [(2, signal.SIGKILL), (9, signal.SIGINT)])
for kind in ("bdf2", "newmark"):
    check_resumes("cut by " + kind, DROP, [(7, signal.SIGKILL)], ["time.integrator=" + kind, "colliders=[]"])
check_resumes("pieces whose steps do not end", DROP, [(7, signal.SIGKILL), (12, signal.SIGKILL)], ["time.integrator=newmark"])
check_resumes("bend and cut", BEND, [(5, signal.SIGKILL)])
check_resumes("bend and cut a linear bar", BEND, [(5, signal.SIGKILL)], ["bodies.0.material.model=linear"])

check_resumes("carved out of its supports", LOSE, [(2, signal.SIGKILL), (6, signal.SIGKILL)])

with folder() as d:
    got, result = solve(d, LOSE)
    lost = [loss["what"] for loss in result["lost"]]
    expect("a_run_goes_on_where_carving_leaves_nothing_of_selections", lost == [
        "bodies.0.constraints.0", "bodies.0.loads.0", "bodies.0.loads.1", "tie.0"], result["lost"])
    expect("each_is_warned_of_once", [sum("acts on nothing" in w and name + ":" in w for w in result["warnings"])
                                      for name in lost] == [1, 1, 1, 1], result["warnings"])
    expect("and_pushes_no_more", result["reaction"]["bodies.0.constraints.0"] == [0, 0, 0], result["reaction"])
    rows = history(d)
    gain = [rows[-1]["momentum_y"] - rows[-2]["momentum_y"], rows[-1]["t"] - rows[-2]["t"]]
    mass = 1000 * (0.54 * 0.04 + 0.008)
    expect("what_is_left_falls", abs(gain[0] + 9.81 * mass * gain[1]) < 1e-9 * mass, gain)
    static = solve(d, LOSE, "--set", "time={kind: quasistatic, duration: 0.1, steps: 10}")[0]
    expect("but_for_equilibria_nothing_holds_it", static.returncode == 2 and "nothing holds" in static.stderr, static.stderr)
    first = solve(d, LOSE, "--set", "cuts.0.at=0")[0]
    expect("and_at_the_start_it_is_an_error", first.returncode == 2 and "selects nothing" in first.stderr, first.stderr)

with folder() as d:
    lying = CUBE.replace("CUT", "{plane: {point: [0, 0.5, 0], normal: [0, 1, 0]}, space: rest}")
    lying = lying.replace("[0, -1, 0]", "[0.1, -1, 0]")
    slides = solve(d, lying)[0]
    expect("a_piece_that_may_slide_has_no_equilibrium", slides.returncode == 3 and "contact.friction" in slides.stderr, slides.stderr)
    expect("and_friction_holds_it", solve(d, lying, "--set", "contact.friction=0.3")[0].returncode == 0)

with folder() as d:
    got, result = solve(d, DROP)
    notes = result["topology"]
    expect("every_cut_is_told", [n["cut"] for n in notes] == [0, 1, 2] and not any(n["missed"] for n in notes), notes)
    expect("each_before_the_step_in_which_it_falls", abs(notes[1]["time"] - 0.03) < 1e-12 and
           abs(notes[2]["time"] - 0.07) < 1e-12, notes)
    expect("pieces_are_counted", notes[0]["pieces"] == 2 and 3 <= notes[1]["pieces"] <= notes[2]["pieces"] - 3, notes)
    expect("volume_stays", all(abs(n["volume"] / 0.002 - 1) < 1e-13 for n in notes), notes)
    expect("kinetic_energy_stays", all(abs(n["kinetic_energy"][1] - n["kinetic_energy"][0]) <=
                                       1e-13 * n["kinetic_energy"][0] for n in notes), notes)
    expect("elements_are_those_of_the_last_cut", result["bodies"][0]["elements"] == notes[2]["elements"], result["bodies"])
    expect("volume_of_the_history_stays", abs(history(d)[-1]["volume"] / 0.002 - 1) < 0.1, history(d)[-1])

# a diagonal through edges of elements that have come apart a little: needles along the edges are merged with what they hang at
DIAGONAL = """lithe: 1
bodies:
  - shape: {box: {min: [0, 0, 0], max: [1, 1, 1]}}
    material: {young_modulus: 1e5, poisson_ratio: 0.3, density: 1000}
    method: {kind: dg, cells: CELLS, degree: DEGREE}
gravity: [0, -9.81, 0]
colliders: [{plane: {point: [0, 0, 0], normal: [0, 1, 0]}}]
contact: {friction: 0.2}
cuts:
  - {at: 0.1, plane: {point: [0.5, 0, 0.5], normal: [1, 0, 1]}}
time: {kind: dynamic, duration: 0.3, step: 0.01}
output: {every: 0.01, fields: []}
"""
with folder() as d:
    for cells, degree in ((2, 1), (4, 1), (2, 2)):
        got, result = solve(d, DIAGONAL.replace("CELLS", str(cells)).replace("DEGREE", str(degree)))
        note, total = result["topology"][0], [row["strain_energy"] + row["kinetic_energy"] - row["work"] for row in history(d)]
        expect("needles_of_a_diagonal_cut_are_merged", note["merged"] > 0 and abs(note["volume"] - 1) < 1e-13, note)
        expect("and_energy_only_falls", all(b < a + 1e-3 * result["energy"]["work"] for a, b in zip(total, total[1:])), total)

# few elements, nu near 1/2: jumps that were there are weighed by stiffer penalties after the cut, which the result tells
JUMPS = """lithe: 1
bodies:
  - shape: {box: {min: [0, 0, 0], max: [1, 0.4, 0.6]}}
    material: {model: linear, young_modulus: 1 MPa, poisson_ratio: 0.49, density: 1000}
    method: {kind: dg, cells: 4, degree: 1, sliver: 0}
    initial: {velocity: ["5*(y-.5)*z", "1-5*(x-.5)", "5*sin(4*x)"]}
cuts:
  - {at: 0.045, blade: {path: [[0.667, 0.281, 0.25], [0.333, 0.581, 0.0025], [1.148, 0.667, -0.0325], [0.892, 0.421, 1]], depth: [-0.493, -0.356, 0.799]}}
contact: {bodies: false}
time: {kind: dynamic, duration: 0.12, step: 0.01}
output: {every: 0.01, fields: []}
"""
with folder() as d:
    for kind in ("implicit-euler", "bdf2", "newmark"):
        got, result = solve(d, JUMPS, "--set", "time.integrator=" + kind)
        note = result["topology"][0]
        rise, jumps = ([note[key][1] - note[key][0] for key in ("strain_energy", "jump_energy")])
        expect("strain_energy_rises_by_that_of_jumps_alone (%s)" % kind, rise > 0.1 * note["strain_energy"][0] and
               abs(rise - jumps) < 1e-12 * note["strain_energy"][1], note)
        total = [row["strain_energy"] + row["kinetic_energy"] for row in history(d)]
        expect("and_the_step_takes_it_away_again (%s)" % kind, max(total) < 1.001 * total[0], total)

# pieces thinner than a percent of an element, pressed flat by others: contact gives no energy, and every step has an end
for kind in ("implicit-euler", "newton-euler", "bdf2", "newmark"):
    for sliver in ("1e-4", "0.1"):
        for friction in ("0.3", "0"):
            with folder() as d:
                what = "%s, sliver %s, friction %s" % (kind, sliver, friction)
                got, result = solve(d, DROP, "--set", "time.integrator=" + kind, "--set", "bodies.0.method.sliver=" + sliver,
                                    "--set", "contact.friction=" + friction, "--set", "output.every=1/200", "--set", "output.fields=[]")
                expect("steps_of_pieces_end (%s)" % what, got.returncode == 0 and result["solver"]["converged"], got.stderr)
                frozen = result["solver"].get("frozen_steps", 0)
                expect("most_by_the_iteration (%s)" % what, frozen <= (12 if kind == "newmark" else 8), frozen)
                expect("and_that_is_told (%s)" % what, (frozen > 0) == any("does not end" in w for w in result["warnings"]), result)
                total = [row["strain_energy"] + row["kinetic_energy"] - row["work"] for row in history(d)]
                rise = max(b - a for a, b in zip(total, total[1:]))
                expect("they_gain_no_energy (%s)" % what, max(total) < 1.001 * total[0] and
                       (rise < 0.1 * total[0] or kind == "newmark"), total) # which nothing damps

# nothing is left: before the run an error, in the middle of it nothing changes
EATEN = LOSE.replace("{min: [0.23, -5, -5], max: [0.77, 5, 5]}}, keep: inside", "BOX")
for keep, box in (("inside", "{min: [5, 0, 0], max: [6, 1, 1]}"), ("outside", "{min: [-9, -9, -9], max: [9, 9, 9]}"),
                  ("inside", "{min: [-1, -1, -1], max: [1e-14, 2, 2]}")):
    with folder() as d:
        whole = solve(d, LOSE.replace("cuts:", "probes: []\ncuts:").replace("max: [0.77", "max: [9").replace("min: [0.23", "min: [-9"))
        before = history(d)
        got, result = solve(d, EATEN.replace("BOX", "%s}, keep: %s" % (box, keep)))
        expect("a_carve_that_would_leave_nothing_is_not_made", got.returncode == 0 and result["bodies"][0]["elements"] == 40, got.stderr)
        note = result["topology"][0]
        expect("which_is_told", note["refused"] and not note["missed"] and note["elements"] == 40 and "strain_energy" not in note and
               sum("cuts.0.carve: nothing would be left of the body `bar`" in w for w in result["warnings"]) == 1, (note, result["warnings"]))
        expect("and_nothing_changes", history(d) == before, box)
        first = solve(d, EATEN.replace("BOX", "%s}, keep: %s" % (box, keep)), "--set", "cuts.0.at=0")[0]
        expect("before_the_run_it_is_an_error", first.returncode == 2 and "nothing is left of the body `bar`" in first.stderr, first.stderr)

with folder() as d:
    got, result = solve(d, BEND)
    expect("a_bar_that_is_cut_along_is_softer", result["reaction"]["bodies.0.constraints.1"][1] < 0, result["reaction"])
    whole = solve(d, BEND.replace("at: 0.4, plane: {point: [0, 0.4, 0]", "at: 0.4, plane: {point: [0, 4, 0]"))[1]
    expect("which_takes_less_force", abs(result["reaction"]["bodies.0.constraints.1"][1]) <
           0.7 * abs(whole["reaction"]["bodies.0.constraints.1"][1]), (result["reaction"], whole["reaction"]))
    expect("a_miss_is_told", whole["topology"][0]["missed"] and "kinetic_energy" not in whole["topology"][0] and "strain_energy" in result["topology"][0] and "cuts.0: it misses all bodies" in whole["warnings"][0],
           whole["warnings"])

with folder() as d:
    write(d, "scene.yaml", BEND.replace("point: [0, 0.4, 0], normal: [0, 1, 0]", "point: [2, 0, 0], normal: [1, 0, 0]")
          .replace("enforce: strong", "enforce: weak").replace('displacement: [0, "-t*t", 0]', "displacement: [null, null, 0]") + "contact: {bodies: false}\n")
    check("a_piece_that_nothing_holds_is_named", ["run", "scene.yaml", "-q", "-o", "out"], None, None, 2, cwd=d)
    write(d, "cg.yaml", BEND.replace("kind: dg", "kind: cg"))
    check("other_methods_are_refused", ["run", "cg.yaml", "-q"], "",
          "cg.yaml:11:5: cuts.0: cuts need method dg, and body `bar` has another; expected `body` with the name of a dg "
          "body, or `method: {kind: dg}`\n", 2, cwd=d)
    write(d, "late.yaml", BEND.replace("at: 0.4", "at: 1"))
    check("a_cut_after_the_end_is_refused", ["run", "late.yaml", "-q"], "",
          "late.yaml:11:10: cuts.0.at: the run ends before it, got 1 s; expected less than the duration, 1 s\n", 2, cwd=d)
with folder() as d:
    def cut(text):
        got, result = solve(d, CUBE.replace("CUT", text))
        return result["topology"][0] if result else got.stderr

    part = "within: {box: {min: [0, 0.5, 0], max: [1, 1, 1]}}"
    n = cut("{plane: {point: [0.5, 0, 0], normal: [1, 0, 0]}, %s}" % part)
    expect("a_cut_within_a_shape_ends_there", n["split"] == 15 and n["pieces"] == 1 and abs(n["area"] - 0.6) < 1e-12, n)
    n = cut("{plane: {point: [0.4, 0, 0], normal: [1, 0, 0]}, %s}" % part)
    expect("and_parts_along_faces", n["split"] == 0 and n["separated"] == 15 and abs(n["area"] - 0.6) < 1e-12, n)
    n = cut("{blade: {path: [[0.5, 1.1, -0.1], [0.5, 0.7, -0.1], [0.7, 0.5, -0.1], [0.79, 0.5, -0.1]], depth: [0, 0, 1.2]}}")
    # down to the bend, askew, and on to the end of the last element
    expect("a_blade_bends_inside_elements", abs(n["area"] - (0.3 + 0.2 * 2 ** 0.5 + 0.1)) < 1e-12 and n["pieces"] == 1, n)
    n = cut("{blade: {path: [[0.5, 1.1, -0.1], [0.5, 0.7, -0.1]], depth: [0, 0, 0.55]}}")
    expect("and_ends_at_its_depth_to_the_element", abs(n["area"] - 0.4 * 0.6) < 1e-12, n)
    n = cut("{blade: {path: [[0.5, 1.1, -0.1], [0.5, 0.6, -0.1]], depth: [0, 0, 1.2]}}")
    expect("one_that_ends_on_a_face_goes_no_further", abs(n["area"] - 0.4) < 1e-12 and n["split"] == 10, n)
    moved = CUBE.replace("time: static", "gravity: [0, 0, 0]\ntime: {kind: dynamic, duration: 0.02, step: 0.01}").replace(
        "    constraints", "    initial: {displacement: [0, 1, 0]}\n    constraints", 1).replace("displacement: [0, 0, 0]", "displacement: [0, 1, 0]")
    n = solve(d, moved.replace("CUT", "{at: 0.01, blade: {path: [[0.5, 2.1, -0.1], [0.5, 1.5, -0.1]], depth: [0, 0, 1.2]}}"))[1]["topology"][0]
    expect("a_blade_is_where_the_body_has_moved", abs(n["area"] - 0.6) < 1e-12 and n["split"] == 15, n)
    turned = CUBE.replace("time: static", "time: {kind: dynamic, duration: 0.03, step: 0.01}").replace(
        "    constraints", '    initial: {velocity: ["2*(y-.5)^2", "(.5-x)*z", "z*z"]}\n    constraints', 1)
    for degree in (1, 2):
        bent = turned.replace("degree: 1", "degree: %d" % degree).replace("cells: [5, 5, 5]", "cells: [3, 3, 3]")
        blade = "{at: 0.015, SPACE blade: {path: [[-0.5, 0.4, -0.5], [0.47, 0.62, -0.5], [1.5, 0.37, -0.5]], depth: [0, 0.1, 2]}}"
        n, rest = (solve(d, bent.replace("CUT", blade.replace("SPACE", s)))[1]["topology"][0] for s in ("", "space: rest,"))
        expect("a_bent_blade_parts_a_body_that_moves", n["pieces"] == 2 and n["separated"] > 0, n)
        expect("and_cuts_what_it_cuts_at_rest", rest["pieces"] == 2 and abs(n["area"] / rest["area"] - 1) < 0.03, (n, rest))
    n = solve(d, moved.replace("CUT", "{at: 0.01, plane: {point: [0.5, 0, 0], normal: [1, 0, 0]}, within: {box: {min: [0, 1.49, 0], max: [1, 2, 1]}}}"))[1]["topology"][0]
    expect("and_so_is_what_a_plane_cuts_within", abs(n["area"] - 0.6) < 1e-12 and n["split"] == 15, n)
    n = cut("{carve: {box: {min: [0.1, -0.1, 0.15], max: [0.83, 2, 0.9]}}, keep: inside}")
    expect("carving_keeps_the_inside", abs(n["volume"] - 0.73 * 0.75) < 1e-12 and n["pieces"] == 1, n)
    n = cut("{carve: {box: {min: [0.1, 0.13, 0.15], max: [0.83, 0.77, 0.9]}}, keep: outside}")
    expect("or_the_outside", abs(n["volume"] - (1 - 0.73 * 0.64 * 0.75)) < 1e-12 and n["pieces"] == 1, n)
    n = cut("{carve: {box: {min: [-1, 0.5, 0.15], max: [2, 2, 0.9]}}, keep: outside}")
    expect("surfaces_that_carving_lays_open_are_boundary", abs(n["volume"] - (1 - 0.5 * 0.75)) < 1e-12, n)
    told = cut("{carve: {box: {min: [1.1, 0, 0], max: [2, 1, 1]}}, keep: inside}")
    expect("a_carve_that_leaves_nothing_says_so", told == "lithe: scene.yaml:10:5: cuts.0.carve: nothing is left of the body "
           "`cube`, no part of which is inside the solid; move or turn it, or keep the other side\n", told)
    for key, text, err in (
            ("within", "{blade: {path: [[0, 0, 0], [1, 0, 0]], depth: [0, 0, 1]}, within: {sphere: {center: [0, 0, 0], radius: 1}}}",
             "scene.yaml:10:63: cuts.0.within: it belongs to plane, got no plane; leave it out\n"),
            ("keep", "{carve: {sphere: {center: [0, 0, 0], radius: 1}}}",
             "scene.yaml:10:5: cuts.0.keep: missing; expected inside, outside or both\n"),
            ("far", "{blade: {path: [[-1e200, 0, 0], [1e200, 0, 0]], depth: [0, 0, 1e200]}}",
             "scene.yaml:10:13: cuts.0.blade: its places are too far away; expected less than 1e100 m\n"),
            ("path", "{blade: {path: [[0, 0, 0], [0, 0, 1]], depth: [0, 0, 1]}}",
             "scene.yaml:10:13: cuts.0.blade: edge 0 of its path does not sweep a surface: its ends are the same place, or the "
             "depth runs along it; expected different places, and a depth across them\n")):
        write(d, "scene.yaml", CUBE.replace("CUT", text))
        check("a_wrong_%s_is_refused" % key, ["run", "scene.yaml", "-q"], "", err, 2, cwd=d)
done()
