"""The paper's figures and tables, quick: every verdict holds, all numbers are written without gnuplot, and a solid that is not
the paper's one is found out."""
import json
import os

from cli import done, expect, folder, run

FIGURES = ["fig1", "fig2", "fig3", "fig4", "fig5", "fig6", "fig7-ears", "fig9", "fig11", "fig12", "table1", "warp"]
with folder() as home:
    got = run("study", "kaufmann", "--quick", "--json", "-o", "st", cwd=home, timeout=600)
    report = json.loads(got.stdout or "{}")
    studies = report.get("studies", [])
    failed = [c["what"] for s in studies for c in s["checks"] if not c["holds"]]
    failed += [s["name"] + " stopped: " + s["stopped"] for s in studies if "stopped" in s]
    expect("every_verdict_on_the_paper_holds", got.returncode == 0 and not failed, (failed, got.stderr))
    expect("every_figure_is_there", sorted(s["name"] for s in studies) == sorted("kaufmann/" + f for f in FIGURES),
           [s["name"] for s in studies])
    bunny = os.path.exists("/usr/share/glmark2/models/bunny.obj")
    expect("every_study_has_verdicts", all(s["checks"] for s in studies if bunny or not s["name"].endswith("ears")), report)

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
