"""Combined shapes keep their sharp edges: volume and weight are those of the drawing."""
import json
import os

from cli import done, expect, folder, run

SCENE = """lithe: 1
bodies:
  - name: bracket
    shape: {union: [{box: {min: [0, 0, 0], max: [1, 0.3, 0.5]}}, {box: {min: [0, 0.3, 0], max: [0.3, 1, 0.5]}}]}
    material: {young_modulus: 1e7, poisson_ratio: 0.3, density: 1000}
    method: {kind: dg, cells: 6}
    constraints:
      - {where: {plane: {point: [0, 1, 0], normal: [0, 1, 0]}}, displacement: [0, 0, 0]}
    embed: {}
gravity: [0, -10, 0]
time: {kind: static}
output: {every: last, fields: [none], surface: [obj]}
"""
VOLUME = (0.3 + 0.3 * 0.7) * 0.5

with folder() as d:
    with open(os.path.join(d, "bracket.yaml"), "w") as file:
        file.write(SCENE)
    got = run("run", "bracket.yaml", "-o", "result", "--json", cwd=d, timeout=300)
    expect("an_l_of_two_boxes_runs", got.returncode == 0, got.stderr)
    result = json.loads(got.stdout)
    body = result["bodies"][0]
    expect("its_volume_is_exact", abs(body["volume"] / VOLUME - 1) < 1e-12, body["volume"])
    expect("its_mass_is_exact", abs(body["mass"] / (1000 * VOLUME) - 1) < 1e-12, body["mass"])
    reaction = result["reaction"]["bodies.0.constraints.0"]
    weight = 1e4 * VOLUME
    expect("its_support_carries_its_weight", max(abs(reaction[0]), abs(reaction[1] - weight), abs(reaction[2])) <
           1e-9 * weight, reaction)
    expect("nothing_is_warned_of", not result["warnings"], result["warnings"])
    expect("no_cut_is_told_of", "surface" not in body, body)

    got = run("mesh", "bracket.yaml", "-o", "m.vtu", "--json", "--set", "bodies.0.shape.resolution=0.3", cwd=d)
    volume = json.loads(got.stdout)["volume"]
    expect("a_coarse_resolution_changes_no_plane", abs(volume / VOLUME - 1) < 1e-12, volume)

    got = run("mesh", "bracket.yaml", "-o", "m.vtu", "--json", "--set",
              "bodies.0.shape={difference: [{box: {min: [0, 0, 0], max: [1, 1, 0.5]}}, "
              "{box: {min: [0.3, 0.3, 0], max: [1, 1, 0.5]}}], resolution: 0.11}", cwd=d)
    volume = json.loads(got.stdout)["volume"]
    expect("a_difference_gives_the_same_l", abs(volume / VOLUME - 1) < 1e-12, volume)
done()
