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

    got = run("verify", scene, "--methods", "dg,cg", "--cells", "cg:2,6;2,4", "--tolerance", "9%", "-o", out + "-own")
    expect("methods_may_have_resolutions_of_their_own", sorted(n for n in os.listdir(out + "-own") if "-" in n) ==
           ["cg-2", "cg-6", "dg-2", "dg-4"], (got.stdout + got.stderr, os.listdir(out + "-own")))
    got = run("verify", scene, "--methods", "dg,cg", "--cells", "staggered:2,6;2,4", "-o", out)
    expect("names_are_of_methods_that_run", got.returncode == 2 and "staggered is none of the methods" in got.stderr,
           got.stderr)

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

# A wall between two smooth walls: all three methods, elements of cg from a file; and one in the plane.
STUDIES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "studies", "verify")
PLANE = """lithe: 1
dimension: 2
bodies:
  - name: block
    shape: {difference: [{box: {min: [0, 0], max: [2, 1]}}, {disk: {center: [2, 0], radius: 0.3}}]}
    material: {model: linear, young_modulus: 1 MPa, poisson_ratio: 0.3, density: 1000}
    method: {kind: staggered, cells: 16}
    constraints: [{where: {plane: {point: [0.01, 0], normal: [-1, 0]}}, displacement: [0, 0]}]
time: static
gravity: [0, -10]
probes: [{name: tip, point: [1.8, 0.7]}]
output: {fields: none}
"""
TWO = SCENE.replace("time: static", """  - name: post
    shape: {box: {min: [0, 2, 0], max: [1, 3, 1]}}
    material: {model: linear, young_modulus: 2 MPa, poisson_ratio: 0.2, density: 500}
    method: {kind: staggered, cells: 2}
    constraints: [{where: {plane: {point: [0, 2, 0], normal: [0, -1, 0]}}, displacement: [0, 0, 0]}]
time: static""")

with folder() as home:
    out = os.path.join(home, "wall")
    meshes = ",".join(os.path.join(STUDIES, "cylinder-%d.msh" % k) for k in (1, 2))
    got = run("verify", os.path.join(STUDIES, "cylinder.yaml"), "--cells", "8,12,16", "--meshes", meshes, "-o", out)
    expect("three_methods_agree_on_a_curved_wall", got.returncode == 0 and "Method staggered" in got.stdout,
           got.stdout + got.stderr)
    with open(os.path.join(out, "staggered-16", "result.json")) as stream:
        inner = json.load(stream)["probes"]["inner"]
    radius = 0.8 * 2 ** 0.5
    lame = 1e-3 / 3 * 1.3 * (0.4 * radius + 4 / radius)
    found = inner["displacement"][0] * 2 ** 0.5
    expect("and_with_lame", abs(found / lame - 1) < 0.01, (found, lame))

    scene = os.path.join(home, "plane.yaml")
    with open(scene, "w") as stream:
        stream.write(PLANE)
    got = run("verify", scene, "--cells", "16,32,64", "--tolerance", "2%", "-o", os.path.join(home, "plane"))
    expect("fractions_are_compared_in_the_plane",
           got.returncode == 0 and "Method exact" in got.stdout and "Method smooth" in got.stdout,
           got.stdout + got.stderr)

    scene = os.path.join(home, "two.yaml")
    with open(scene, "w") as stream:
        stream.write(TWO)
    got = run("verify", scene, "--methods", "dg,cg", "--cells", "4,8", "--tolerance", "5%", "-o",
              os.path.join(home, "two"))
    expect("several_bodies_change_their_method_together",
           got.returncode == 0 and "bodies.1" in got.stdout, got.stdout + got.stderr)

check("tolerance_is_a_share", ["verify", "a.yaml", "--tolerance", "2"], status=2,
      err="lithe: --tolerance: expected a share between 0 and 1, as in 1%, got '2'\n")
done()
