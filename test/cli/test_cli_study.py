"""Studies and sweeps: what is written, what is told, and that a verdict that does not hold is not hidden."""
import csv
import html.parser
import json
import os
import shutil

from cli import check, done, expect, folder, run

NAMES = [line.split()[0] for line in run("study").stdout.splitlines() if line.startswith("  ")]
SCENE = """lithe: 1
bodies:
  - name: bar
    shape: {box: {min: [0, 0, 0], max: [2, 1, 1]}}
    material: {model: linear, young_modulus: 1 MPa, poisson_ratio: 0.3, density: 1000}
    method: {kind: cg, cells: 2}
    constraints: [{where: {normal: [-1, 0, 0]}, displacement: ["0", "0", "0"]},
                  {where: {normal: [1, 0, 0]}, displacement: ["0.1*sin(pi*y)", "0", "0"]}]
time: static
exact: {displacement: ["0", "0", "0"]}
output: {fields: none}
"""


def rows(path):
    with open(path, newline="") as stream:
        return list(csv.reader(stream))


class Page(html.parser.HTMLParser):
    """Is every element closed, and is nothing fetched from elsewhere?"""

    def __init__(self, text):
        super().__init__()
        self.open, self.sound, self.n_svg, self.fetches = [], True, 0, []
        self.feed(text)
        self.sound = self.sound and not self.open

    def handle_starttag(self, tag, attrs):
        self.n_svg += tag == "svg"
        self.fetches += [v for k, v in attrs if k in ("src", "href", "xlink:href") and not v.startswith(("#", "data:"))]
        if tag not in ("meta", "br"):
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        pass

    def handle_endtag(self, tag):
        if self.open and self.open[-1] == tag:
            self.open.pop()
        else:
            self.sound = False


expect("studies_are_listed", "validation/patch-test" in NAMES, NAMES)
got = run("study", "nothing")
expect("unknown_study_lists_the_known_ones", got.returncode == 2 and all(n in got.stderr for n in NAMES), got.stderr)
check("sweep_needs_a_scene", ["study", "--sweep", "a=1"], status=2, err="lithe: study: --sweep needs a scene file\n")

with folder() as home:
    got = run("study", "validation/patch-test", "--quick", "-o", "st", cwd=home)
    expect("study_that_holds_ends_with_0", got.returncode == 0 and "1 of 1 verdicts hold" in got.stdout, got)
    table = rows(os.path.join(home, "st/validation/patch-test/errors.csv"))
    expect("table_has_units_and_all_rows", table[0] == ["method", "unknowns", "largest error [m]"] and
           len(table) == 6, table)
    report = json.load(open(os.path.join(home, "st/study.json")))
    expect("verdict_has_value_bound_and_reason", report["studies"][0]["holds"] is True and
           set(report["studies"][0]["checks"][0]) == {"what", "value", "at_most", "reason", "holds"}, report)
    page = Page(open(os.path.join(home, "st/index.html")).read())
    expect("page_is_sound_and_fetches_nothing", page.sound and not page.fetches, (page.open, page.fetches))
    got = run("run", "st/validation/patch-test/case-1.yaml", "-q", cwd=home)
    expect("scene_of_a_study_runs_alone", got.returncode == 0, got.stderr)

    # the scene is not what the study thinks it is
    got = run("study", "validation/patch-test", "--quick", "-o", "bad", "--json", "--set",
              'bodies.0.constraints.0.displacement=["0.01*x","0","0"]', cwd=home)
    report = json.loads(got.stdout)
    expect("verdict_that_does_not_hold_ends_with_1", got.returncode == 1 and "do not hold" in got.stderr and
           report["studies"][0]["holds"] is False, got)
    expect("page_tells_what_does_not_hold", "DOES NOT HOLD" in open(os.path.join(home, "bad/index.html")).read())
    got = run("study", "validation/patch-test", "-o", "stop", "--set", "bodies.0.material.poisson_ratio=3", cwd=home)
    expect("study_that_cannot_run_ends_with_1", got.returncode == 1 and "STOPPED" in got.stdout, got)

    # sweeps
    open(os.path.join(home, "bar.yaml"), "w").write(SCENE)
    got = run("study", "bar.yaml", "--sweep", "bodies.0.method.cells=2,4,8", "--sweep",
              "bodies.0.material.poisson_ratio=0,0.3", cwd=home)
    expect("sweep_runs_every_combination", got.returncode == 0 and
           len(rows(os.path.join(home, "out/bar-sweep/runs.csv"))) == 7, got)
    expect("sweep_makes_a_table_for_each_other_value", "bodies.0.method.cells for poisson_ratio=0.3" in got.stdout,
           got.stdout)
    levels = {r[0]: r for r in rows(os.path.join(home, "out/bar-sweep/levels-2.csv"))}
    energy = [float(x) for x in levels["energy.strain [J]"][1:]]
    # the edge load is known: ratio of successive steps r gives order log2 r and the limit
    steps = energy[0] - energy[1], energy[1] - energy[2]
    expect("orders_and_limits_follow_from_the_values", steps[0] / steps[1] > 1 and
           abs(2 ** energy[3] - steps[0] / steps[1]) < 1e-9 * steps[0] / steps[1] and
           abs(energy[4] - (energy[2] - steps[1] / (steps[0] / steps[1] - 1))) < 1e-9 * energy[2], energy)
    runs = rows(os.path.join(home, "out/bar-sweep/runs.csv"))
    column = runs[0].index("error.l2")
    errors = [float(r[column]) for r in runs[4:]]
    told = [r for r in rows(os.path.join(home, "out/bar-sweep/levels-2.csv")) if r[0] == "error.l2"][0]
    expect("errors_have_the_order_of_the_last_levels", abs(2 ** float(told[4]) - errors[1] / errors[2]) < 1e-9 and
           told[5] == "", told)
    check("what_is_no_sweep_is_refused", ["study", "bar.yaml", "--sweep", "cells"], status=2, cwd=home,
          err="lithe: --sweep cells: expected PATH=VALUE,VALUE,... with 1 to 64 values, as in "
          "bodies.0.method.cells=8,16,32\n")
    got = run("study", "bar.yaml", "--sweep", "bodies.0.method.cells=2,4", "--sweep",
              "bodies.0.material.poisson_ratio=0,0.7", "-o", "none", cwd=home)
    expect("bad_value_is_told_before_anything_runs", got.returncode == 2 and "poisson_ratio" in got.stderr and
           not os.path.exists(os.path.join(home, "none/run-001")), got)

    # drawings
    if shutil.which("gnuplot"):
        page = Page(open(os.path.join(home, "out/bar-sweep/index.html")).read())
        expect("plots_stand_inside_the_page", page.n_svg == 2 and page.sound and not page.fetches,
               (page.n_svg, page.open, page.fetches))
    got = run("study", "bar.yaml", "--sweep", "bodies.0.method.cells=2,4,8", "-o", "plain", cwd=home,
              env={"PATH": "/nonexistent"})
    files = os.listdir(os.path.join(home, "plain"))
    expect("missing_gnuplot_is_named_with_its_package", got.returncode == 0 and "gnuplot-nox" in got.stderr, got)
    expect("without_gnuplot_the_numbers_are_written_all_the_same", "errors.gp" in files and "runs.csv" in files and
           "index.html" in files and "errors.svg" not in files, files)
done()
