"""Staggered bodies in the mixed form: nu = 0.5 by both ways of solving, against Lame's ring."""
import json
import os

from cli import done, expect, folder, run

RING = """lithe: 1
dimension: 2
bodies:
  - name: ring
    shape:
      intersection:
        - annulus: {center: [0, 0], inner: 0.1, outer: 0.2}
        - box: {min: [0, 0], max: [0.2, 0.2]}
    material: {model: linear, young_modulus: 2 MPa, poisson_ratio: %g, density: 1000}
    method: {kind: staggered, cells: 32, fractions: smooth}
    constraints:
      - {where: {plane: {point: [0, 0], normal: [-1, 0]}}, displacement: [0, null]}
      - {where: {plane: {point: [0, 0], normal: [0, -1]}}, displacement: [null, 0]}
    loads:
      - {where: {disk: {center: [0, 0], radius: 0.15}}, pressure: 1 kPa}
probes: [{name: middle, point: [0.12, 0.09]}]
"""
DYNAMIC = "time: {kind: dynamic, duration: 0.01, step: 1/1000}\noutput: {every: last, fields: none}\n"


def simulate(home, name, text):
    scene, out = os.path.join(home, name + ".yaml"), os.path.join(home, name)
    with open(scene, "w") as stream:
        stream.write(text)
    got = run("run", scene, "-o", out)
    if got.returncode != 0:
        print(got.stdout, got.stderr)
        return {}
    with open(os.path.join(out, "result.json")) as stream:
        return json.load(stream)


def middle(result):
    """Radial displacement and pressure at r = 0.15 m."""
    if "probes" not in result:
        return 0, 0
    probe = result["probes"]["middle"]
    return 0.8 * probe["displacement"][0] + 0.6 * probe["displacement"][1], probe["stress"][2]


with folder() as home:
    # nu = 0.5: u_r = 3/2 p a^2 b^2 / (E (b^2 - a^2) r), sigma_zz = p a^2 / (b^2 - a^2)
    result = simulate(home, "static", RING % 0.5)
    moved, stress = middle(result)
    expect("the_ring_opens_as_lame_says", abs(moved / (1.5 * 1e3 / 2e6 / 3 * 0.04 / 0.15) - 1) < 0.01, moved)
    expect("the_stress_across_is_the_pressure", abs(stress / (1e3 / 3) - 1) < 0.03, stress)
    expect("without_a_matrix_in_few_iterations",
           result["solver"]["linear"] == "multigrid" and result["solver"]["iterations"] < 20, result["solver"])
    again = simulate(home, "matrix", RING % 0.5 + "solver: {linear: cholesky}\n")
    expect("the_matrix_gives_the_same", abs(middle(again)[0] / moved - 1) < 1e-6 and
           abs(middle(again)[1] / stress - 1) < 1e-5 and again["solver"]["newton_iterations"] < 12, again.get("solver"))
    at = {}
    for way in ("multigrid", "cholesky"):
        at[way], _ = middle(simulate(home, way, RING % 0.5 + DYNAMIC + "solver: {linear: %s}\n" % way))
    expect("in_time_the_matrix_gives_the_same", at["multigrid"] > 0 and abs(at["cholesky"] / at["multigrid"] - 1) < 0.01,
           at)
done()
