"""Large deformation: a beam bent by half a turn, corotated and neo-Hookean; what neo-Hookean bodies need."""
import json
import math
import os

from cli import done, expect, folder, run

SCENE = os.path.join(os.path.dirname(__file__), "..", "..", "scenes", "beam-bent.yaml")

with folder() as home:
    coarse = ["--set", "bodies.0.method.cells=30", "--set", "time.steps=2"]
    for model in ("corotated", "neo-hookean"):
        out = os.path.join(home, model)
        got = run("run", SCENE, "-o", out, *coarse, "--set", "bodies.0.material.model=" + model)
        with open(os.path.join(out, "result.json")) as stream:
            result = json.load(stream)
        expect(model + "_bends_to_balance", got.returncode == 0 and result["solver"]["converged"], got.stderr)
        # E I k^2 / 2, three cells across: their second moment is a tenth too large
        want = 1e4 * 0.1**4 / 12 * math.pi**2 / 2
        expect(model + "_stores_the_energy_of_an_arc", 0.98 < result["energy"]["strain"] / want < 1.08, result["energy"])
        stress = result["probes"]["middle"]["stress"]
        expect(model + "_has_no_stress_on_the_neutral_line", abs(stress[1]) < 0.15 * 1e4 * math.pi * 0.05, stress)

    got = run("run", SCENE, "-o", os.path.join(home, "dg"), "--set", "bodies.0.material.model=neo-hookean", "--set",
              "bodies.0.method.kind=dg")
    expect("dg_says_what_neo_hookean_needs", got.returncode == 2 and "neo-hookean needs method staggered" in got.stderr, got.stderr)
    got = run("run", SCENE, "-o", os.path.join(home, "mixed"), "--set", "bodies.0.method.formulation=mixed")
    expect("mixed_is_for_linear_bodies", got.returncode == 2 and "formulation: mixed is for linear bodies" in got.stderr, got.stderr)
done()
