"""One scene by several methods: agreement is found where it is, and denied where it is not."""
import json
import os

from cli import check, done, expect, folder, run

SCENE = """lithe: 1
bodies:
  - name: beam
    shape: {box: {min: [0, 0, 0], max: [2, 1, 1]}}
    material: {model: linear, young_modulus: 1 MPa, poisson_ratio: 0.3, density: 1000}
    method: {kind: dg, cells: 4, degree: 2}
    constraints: [{where: {plane: {point: [0, 0, 0], normal: [-1, 0, 0]}}, displacement: [0, 0, 0]}]
time: static
gravity: [0, -10, 0]
probes: [{name: tip, point: [1.9, 0.5, 0.5]}]
output: {fields: none}
"""

with folder() as home:
    scene = os.path.join(home, "beam.yaml")
    out = os.path.join(home, "out")
    with open(scene, "w") as stream:
        stream.write(SCENE)

    got = run("verify", scene, "--methods", "dg,cg", "--cells", "2,4,8", "--tolerance", "2%", "-o", out)
    expect("methods_agree_on_a_beam", got.returncode == 0, got.stdout + got.stderr)
    text = got.stdout
    expect("displacements_energies_and_stresses_are_told",
           all(word in text for word in ("energy.strain", "probes.tip.displacement", "probes.tip.von_mises")), text)
    with open(os.path.join(out, "study.json")) as stream:
        report = json.load(stream)
    expect("verdicts_are_in_the_report", "probes.tip.displacement" in json.dumps(report), report)
    expect("every_run_is_kept", os.path.exists(os.path.join(out, "cg-8", "result.json")), os.listdir(out))

    got = run("verify", scene, "--methods", "dg,cg", "--cells", "2,4", "--tolerance", "0.00001", "-o", out)
    expect("methods_that_are_too_far_apart_fail", got.returncode == 1 and "DOES NOT HOLD" in got.stdout,
           got.stdout + got.stderr)
    own = SCENE.replace("{kind: dg, cells: 4, degree: 2}",
                        "{kind: staggered, cell_size: 0.5, fractions: {smooth: 2}}")
    with open(scene, "w") as stream:
        stream.write(own.replace("{box: {min: [0, 0, 0], max: [2, 1, 1]}}", "{sphere: {center: [0, 0, 0], radius: 1.03}}"))
    got = run("verify", scene, "--methods", "staggered,dg", "--cells", "5,10", "-o", out)
    direct = run("run", scene, "-o", os.path.join(home, "direct"))
    with open(os.path.join(out, "staggered-5", "result.json")) as stream:
        by_verify = json.load(stream)["energy"]["strain"]
    with open(os.path.join(home, "direct", "result.json")) as stream:
        alone = json.load(stream)["energy"]["strain"]
    expect("a_body_keeps_all_settings_of_its_own_method", by_verify == alone, (by_verify, alone, got.stderr, direct.stderr))
    got = run("verify", scene, "--methods", "dg,fem", "-o", out)
    expect("unknown_method_lists_the_known", got.returncode == 2 and "dg,staggered,cg" in got.stderr, got.stderr)
    got = run("verify", scene, "--methods", "dg", "-o", out)
    expect("one_method_has_nothing_to_compare", got.returncode == 2 and "fewer than two" in got.stderr, got.stderr)
    got = run("verify", scene, "--cells", "4,x", "-o", out)
    expect("cells_are_numbers", got.returncode == 2 and "8,16,32" in got.stderr, got.stderr)

check("tolerance_is_a_share", ["verify", "a.yaml", "--tolerance", "2"], status=2,
      err="lithe: --tolerance: expected a share between 0 and 1, as in 1%, got '2'\n")
done()
