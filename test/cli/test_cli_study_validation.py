"""The validation book, its fast part: every case is there, every method meets what is known, and a wrong material is found out. All
cases run in test_cli_study_all.py."""
import json

from cli import done, expect, folder, run

CASES = ["patch-test", "tension", "cantilever", "cook", "cylinder", "sphere", "kirsch", "le1", "le10", "hertz", "bar"]
QUICK = ["patch-test", "tension", "cook", "le10"]
with folder() as home:
    for name in QUICK:
        got = run("study", "validation/" + name, "--quick", "--json", "-o", "st", cwd=home, timeout=600)
        report = json.loads(got.stdout or "{}")
        studies = report.get("studies", [{}])
        failed = [c["what"] for c in studies[0].get("checks", []) if not c["holds"]] + [studies[0].get("stopped", "")]
        expect(name + "_is_met", got.returncode == 0 and failed == [""], (failed, got.stderr))
        expect(name + "_has_verdicts", len(studies[0].get("checks", [])) > 0, report)

    got = run("study", "validation/tension", "--json", "-o", "bad", "--set", "bodies.0.material.poisson_ratio=0.2", cwd=home)
    report = json.loads(got.stdout or "{}")
    expect("wrong_material_is_found_out", got.returncode == 1 and not all(c["holds"] for c in report["studies"][0]["checks"]), report)
names = [line.split()[0] for line in run("study").stdout.splitlines() if line.startswith("  ")]
expect("every_case_is_listed", [n for n in names if n.startswith("validation/")] == ["validation/" + c for c in CASES], names)
done()
