"""The thesis' studies, the short ones: every verdict holds, and a solid that is not the thesis' one is found out. All of them run in
test_cli_study_all.py."""
import json
import os

from cli import done, expect, folder, run

SHORT = ["fig5.1", "fig5.5", "fig5.6", "fig5.7", "fig5.8", "fig5.9", "fig5.10"]
with folder() as home:
    for figure in SHORT:
        got = run("study", "dolny/" + figure, "--quick", "--json", "-o", "st", cwd=home, timeout=600)
        study = json.loads(got.stdout or "{}").get("studies", [{}])[0]
        failed = [c["what"] for c in study.get("checks", []) if not c["holds"]] + [study.get("stopped", "")]
        expect(figure + "_holds", got.returncode == 0 and failed == [""] and study["checks"], (failed, got.stderr))
        expect(figure + "_has_its_picture", study["pictures"] and all(
            os.path.exists(os.path.join(home, "st", study["name"], p + ".svg")) for p in study["pictures"]), study)

    # another material than the one that the stress of (5.1) belongs to
    got = run("study", "dolny/table5.1", "--quick", "--json", "-o", "bad", "--set",
              "bodies.0.material.young_modulus=2.6", cwd=home, timeout=300)
    failed = [c["what"] for c in json.loads(got.stdout)["studies"][0]["checks"] if not c["holds"]]
    expect("wrong_stiffness_is_found_out", got.returncode == 1 and any("order" in what for what in failed), failed)
done()
