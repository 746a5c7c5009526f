"""The paper's figures, the short ones: all are listed, verdicts hold, numbers are written without gnuplot, and a solid that is
not the paper's one is found out. All of them run in test_cli_study_all.py."""
import json
import os

from cli import done, expect, folder, run

FIGURES = ["fig1", "fig2", "fig3", "fig4", "fig5", "fig6", "fig7-ears", "fig7-slices", "fig8", "fig9", "fig10-pencil", "fig11", "fig12", "slivers", "table1", "warp"]
SHORT = ["fig10-pencil", "slivers", "fig2", "fig4", "fig5", "fig6", "fig11", "fig12"]
names = [line.split()[0] for line in run("study").stdout.splitlines() if line.startswith("  ")]
expect("every_figure_is_listed", set("kaufmann/" + f for f in FIGURES) <= set(names), names)
with folder() as home:
    for figure in SHORT:
        got = run("study", "kaufmann/" + figure, "--quick", "--json", "-o", "st", cwd=home, timeout=600)
        report = json.loads(got.stdout or "{}")
        study = report.get("studies", [{}])[0]
        failed = [c["what"] for c in study.get("checks", []) if not c["holds"]] + [study.get("stopped", "")]
        expect(figure + "_holds", got.returncode == 0 and failed == [""] and study["checks"], (failed, got.stderr))

    # no gnuplot in sight: it is named with its package, and the numbers are there
    got = run("study", "kaufmann/fig1", "--quick", "-o", "bare", cwd=home, env=dict(os.environ, PATH="/nowhere"))
    expect("missing_gnuplot_is_named", got.returncode == 0 and "gnuplot-nox" in got.stderr, got.stderr)
    expect("numbers_are_written_without_it", os.path.getsize(os.path.join(home, "bare/kaufmann/fig1/errors.csv")) > 200
           and not os.path.exists(os.path.join(home, "bare/kaufmann/fig1/errors.svg")), os.listdir(home))

    # another material than the one that the rigid cells are compared with is no harm, another load is
    got = run("study", "kaufmann/fig3", "--quick", "--json", "-o", "bad", "--set", "bodies.0.loads.0.total_force=[0, 0, -0.0011]",
              cwd=home, timeout=300)
    failed = [c["what"] for c in json.loads(got.stdout)["studies"][0]["checks"] if not c["holds"]]
    expect("wrong_load_is_found_out", got.returncode == 1 and any("rigid" in what for what in failed), failed)
done()
