"""The thesis' studies, quick: every verdict holds, and a solid that is not the thesis' one is found out."""
import json
import os

from cli import done, expect, folder, run

with folder() as home:
    got = run("study", "dolny", "--quick", "--json", "-o", "st", cwd=home, timeout=600)
    report = json.loads(got.stdout or "{}")
    failed = [c["what"] for s in report.get("studies", []) for c in s["checks"] if not c["holds"]]
    failed += [s["name"] + " stopped: " + s["stopped"] for s in report.get("studies", []) if "stopped" in s]
    expect("every_verdict_on_the_thesis_holds", got.returncode == 0 and not failed, (failed, got.stderr))
    expect("every_figure_has_its_picture", all(
        os.path.exists(os.path.join(home, "st", s["name"], p + ".svg"))
        for s in report["studies"] for p in s["pictures"]) and sum(len(s["pictures"]) for s in report["studies"]) >= 8,
        report)

    # another material than the one that the stress of (5.1) belongs to
    got = run("study", "dolny/table5.1", "--quick", "--json", "-o", "bad", "--set",
              "bodies.0.material.young_modulus=2.6", cwd=home, timeout=300)
    failed = [c["what"] for c in json.loads(got.stdout)["studies"][0]["checks"] if not c["holds"]]
    expect("wrong_stiffness_is_found_out", got.returncode == 1 and any("order" in what for what in failed), failed)
done()
