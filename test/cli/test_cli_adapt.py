"""Elements that are divided, merged back and change their degree, from the command line."""
import csv
import json
import os
import signal

from cli import done, expect, folder, run
from resume import FALLING, check_resumes, write

BAR = """lithe: 1
bodies:
  - name: bar
    shape: {box: {min: [0, 0, 0], max: [4.5, 1, 1]}}
    material: {model: corotated, young_modulus: 1 kPa, poisson_ratio: 0.3, density: 1}
    method: {kind: dg, cells: [9, 2, 2], mesh: hexahedra, degree: %d}
    constraints:
      - {where: {plane: {point: [0, 0, 0], normal: [-1, 0, 0]}}, displacement: [0, 0, 0]}
"""
STATIC = BAR % 2 + """gravity: [0, 0, -1]
adapt:
  h: {criterion: principal-stress, threshold: 20, split: eight, max_level: 2}
time: static
output: {fields: [vtu]}
"""
# pushed down and let go: refined while the load is there, coarse again once it has swung back
SWING = (BAR % 1).replace("1 kPa", "10 kPa") + """    loads: [{body_force: [0, 0, "t < 0.15 ? -10 : 0"]}]
gravity: [0, 0, 0]
adapt:
  h: {criterion: principal-stress, threshold: 60, coarsen: 0.6, split: two, max_level: 3}
time: {kind: dynamic, duration: 1.5, step: 0.025}
output: {every: 0.05, fields: [vtu], checkpoint: 0}
"""
# a block that falls, is cut, and has elements refined and raised where it lands
FALL = FALLING % ("0.2", "[4, 2, 2]", "") + """cuts:
  - {at: 0.041, plane: {point: [0.12, 0.05, 0.05], normal: [1, 0.1, 0.2]}}
adapt:
  h: {criterion: principal-stress, threshold: 1500, max_level: 1, every: 2}
  p: {criterion: rotation, threshold: 0.05, max_degree: 2, every: 3}
time: {kind: dynamic, duration: 0.12, step: 1/200}
output: {every: 1/100, fields: none, surface: [pc2], checkpoint: 0}
"""


def solve(d, text, *options):
    write(d, "scene.yaml", text)
    got = run("run", "scene.yaml", "-q", "-o", "out", *options, cwd=d)
    path = os.path.join(d, "out", "result.json")
    return got, json.load(open(path)) if os.path.exists(path) else None


def history(d):
    with open(os.path.join(d, "out", "history.csv")) as file:
        return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]


with folder() as d:
    got, result = solve(d, STATIC)
    expect("a_bent_bar_divides_by_eight", result["bodies"][0]["elements"] == 316, result["bodies"])
    body = result["adapt"]["bodies"][0]
    expect("counts_are_told", body["elements_first"] == 36 and body["elements_most"] == 316 and
           body["divided"] == 40 and body["level"] == [0, 2] and body["degree"] == [2, 2], body)
    expect("one_look_with_all_its_solves", result["adapt"]["looks"] == 1 and result["adapt"]["changes"] == 2, result["adapt"])
    expect("volume_stays", abs(result["bodies"][0]["volume"] / 4.5 - 1) < 1e-13, result["bodies"])
    expect("history_has_the_elements", history(d)[-1]["elements"] == 316 and
           history(d)[-1]["unknowns"] == result["bodies"][0]["dofs"], history(d))
    vtu = open(os.path.join(d, "out", "fields_0000.vtu"), "rb").read()
    expect("fields_have_the_level", b'Name="level"' in vtu)
    got, result = solve(d, STATIC, "--set", "adapt.h.split=two", "--set", "adapt.h.max_level=3")
    expect("and_by_two_into_fewer", result["bodies"][0]["elements"] == 80, result["bodies"])
    got, result = solve(d, STATIC, "--set", "adapt.max_elements=100")
    expect("no_more_than_allowed", result["bodies"][0]["elements"] <= 100 and
           any("max_elements" in w for w in result["warnings"]), result["warnings"])
    got, result = solve(d, STATIC, "--set", "adapt.h.threshold=1 MPa")
    expect("nothing_above_the_threshold_changes_nothing", result["bodies"][0]["elements"] == 36 and
           result["adapt"]["changes"] == 0, result["adapt"])

with folder() as d:
    # degrees alone: the error estimate falls below its share, and the bar gets softer
    text = STATIC.replace("degree: 2", "degree: 1").replace(
        "h: {criterion: principal-stress, threshold: 20, split: eight, max_level: 2}",
        "p: {criterion: error-estimate, threshold: 0.1, max_degree: 3}")
    got, result = solve(d, text)
    body = result["adapt"]["bodies"][0]
    expect("degrees_rise", body["raised"] > 36 and body["degree"][1] == 3 and body["divided"] == 0 and
           result["bodies"][0]["elements"] == 36, body)
    coarse = solve(d, text.replace("0.1", "10"))[1]
    fine = solve(d, text.replace("degree: 1", "degree: 3"))[1]
    gain = (result["energy"]["strain"] - coarse["energy"]["strain"]) / (fine["energy"]["strain"] - coarse["energy"]["strain"])
    expect("and_bring_most_of_what_the_highest_everywhere_brings", 0.8 < gain < 1.01, gain)

with folder() as d:
    got, result = solve(d, SWING)
    n = [row["elements"] for row in history(d)]
    expect("a_swinging_bar_is_refined", max(n) > 100, n)
    expect("and_coarse_again", 36 in n[n.index(max(n)):] and result["adapt"]["bodies"][0]["merged"] > 90, n)
    expect("merging_moves_no_momentum_by_itself", result["adapt"]["largest_change_of_kinetic_energy"] <
           1e-2 * max(row["kinetic_energy"] for row in history(d)), result["adapt"])

with folder() as d:
    got, result = solve(d, FALL)
    body = result["adapt"]["bodies"][0]
    expect("a_scene_cuts_and_adapts", body["divided"] > 0 and body["raised"] > 0 and
           result["topology"][0]["pieces"] == 2, result["adapt"])
    expect("both_keep_the_volume", abs(result["bodies"][0]["volume"] / 0.002 - 1) < 1e-12, result["bodies"])  # but for a crumb
    got, result = solve(d, FALL, "--set", "colliders=[]", "--set", "cuts=[]", "--set", "gravity=[0, 0, 0]", "--set", "adapt.p.threshold=1e-9",
                        "--set", "bodies.0.initial.velocity=['z', 'x', '0.1']", "--set", "adapt.h.threshold=1")
    rows = history(d)
    expect("momentum_stays", abs(rows[0]["momentum_y"] - 0.2) < 1e-12 and all(abs(rows[-1]["momentum_" + a] - rows[0]["momentum_" + a]) < 1e-10 *
                                 abs(rows[0]["momentum_y"]) for a in "xyz") and result["adapt"]["changes"] >= 2 and rows[-1]["elements"] > rows[0]["elements"], rows[-1])

FREE = """lithe: 1
bodies:
  - name: ball
    shape: {sphere: {center: [0, 0, 0], radius: 0.1}}
    material: {model: corotated, young_modulus: 30 kPa, poisson_ratio: 0.3, density: 1000}
    method: {kind: dg, cells: 2, degree: 1}
    initial: {velocity: ["20*y", "3*exp(-(x/0.03)^2)", "5*y"]}
time: {kind: dynamic, duration: 0.03, step: 1/400, integrator: %s}
adapt: {%s}
output: {every: 0.01, fields: none}
solver: {tolerance: 1.0e-11}
"""
RULES = {"two": "h: {criterion: principal-stress, threshold: 1000, split: two, max_level: 1, coarsen: %g}",
         "eight": "h: {criterion: principal-stress, threshold: 1000, split: eight, max_level: 1, coarsen: %g}",
         "p": "p: {criterion: principal-stress, threshold: 1000, max_degree: 2, coarsen: %g}"}


def drift(rows, name):
    first, last = ([row[name + "_" + a] for a in "xyz"] for row in (rows[0], rows[-1]))
    return sum((p - q) ** 2 for p, q in zip(first, last)) ** 0.5 / sum(p * p for p in first) ** 0.5


with folder() as d:
    # a spinning body that nothing touches: what holds new functions back neither pushes nor turns it
    for integrator in ["implicit-euler", "newton-euler", "bdf2", "newmark"]:
        for rule, text in RULES.items():
            got, result = solve(d, FREE % (integrator, text % 1e-9))
            rows = history(d)
            expect(f"held_back_forces_have_no_resultant_{integrator}_{rule}", drift(rows, "momentum") < 1e-11 and
                   drift(rows, "angular_momentum") < 1e-11 and result["adapt"]["changes"] > 0 and abs(rows[-1]["work"]) > 1e-3,
                   (drift(rows, "momentum"), drift(rows, "angular_momentum"), result["adapt"], rows[-1]["work"]))
        for rule, threshold in (("two", 2000), ("p", 1500)):
            got, result = solve(d, FREE % (integrator, RULES[rule] % 0.9), "--set", "time.duration=0.06", "--set", "adapt.%s.threshold=%d" % ("p" if rule == "p" else "h", threshold))
            body = result["adapt"]["bodies"][0]
            expect(f"nor_where_elements_are_merged_{integrator}_{rule}", drift(history(d), "momentum") < 1e-11 and drift(history(d), "angular_momentum") < 1e-11 and
                   body["merged"] + body["lowered"] > 0, (drift(history(d), "momentum"), drift(history(d), "angular_momentum"), body))


def jolt(d, text, *options):
    """Largest jump of the velocity near the clamp between two steps, beside that of the bar that is not refined."""
    def place(*more):
        solve(d, text, *options, *more)
        with open(os.path.join(d, "out", "probes.csv")) as file:
            return [[float(row["root_u" + a]) for a in "xyz"] for row in csv.DictReader(file)]
    fine, plain = place(), place("--set", "adapt.h.threshold=1e9")
    off = [[p - q for p, q in zip(a, b)] for a, b in zip(fine, plain)]
    return max(abs(a[i] - 2 * b[i] + c[i]) for a, b, c in zip(off, off[1:], off[2:]) for i in range(3))


with folder() as d:
    # elements of degree 2 that are divided by eight: what the new functions release comes to act by and by
    text = STATIC.replace("time: static", "time: {kind: dynamic, duration: 1.2, step: 0.025}").replace(
        "output: {fields: [vtu]}", "output: {every: 0.025, fields: none}\nprobes: [{name: root, point: [0.3, 0.3, 0.8]}]")
    text = text.replace("max_level: 2", "max_level: 1")
    hard, soft = jolt(d, text, "--set", "adapt.blend=0"), jolt(d, text)
    expect("what_is_released_is_held_back", 0 < soft < 0.5 * hard, (soft, hard))

check_resumes("swing", SWING, [(8, signal.SIGKILL), (25, signal.SIGINT)])
check_resumes("fall", FALL, [(3, signal.SIGKILL), (8, signal.SIGINT)])
check_resumes("estimate", SWING.replace("principal-stress, threshold: 60", "error-estimate, threshold: 1"), [(9, signal.SIGKILL)],
              ["time.integrator=bdf2", "time.duration=1"])

with folder() as d:
    write(d, "scene.yaml", STATIC.replace("threshold: 20", "threshold: 20 mm"))
    got = run("check", "scene.yaml", cwd=d)
    expect("a_threshold_has_the_criterion's_unit", got.returncode == 2 and "adapt.h.threshold" in got.stderr and "Pa" in got.stderr,
           got.stderr)
    write(d, "scene.yaml", STATIC.replace("threshold: 20", "threshold: 0"))
    got = run("check", "scene.yaml", cwd=d)
    expect("a_threshold_is_positive", got.returncode == 2 and "adapt.h.threshold" in got.stderr, got.stderr)
    write(d, "scene.yaml", STATIC.replace("kind: dg", "kind: cg"))
    got = run("check", "scene.yaml", cwd=d)
    expect("other_methods_do_not_adapt", got.returncode == 2 and "kind: dg" in got.stderr, got.stderr)

done()
