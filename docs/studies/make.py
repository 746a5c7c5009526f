#!/usr/bin/env python3
"""Make docs/studies/README.md, all.html, a page for every group and their pictures from runs of the studies.

usage: docs/studies/make.py [FOLDER...]

FOLDER is what `lithe study` wrote (`-o FOLDER`); of a study in several of them the last counts. Without any, all studies are run
first by the release build.
"""
import json
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
HOME = ROOT / "docs/studies"
GROUPS = {"kaufmann": "The paper's figures and table (Kaufmann et al. 2009)", "dolny": "The thesis' tables and figures (Dolny 2025)",
          "adapt": "Elements that adapt",
          "validation": "The validation book: cases whose answer is known"}


def read(folder):
    """Studies of a run: its entries of study.json, each with its section of index.md and its folder."""
    studies = {}
    text = (folder / "index.md").read_text()
    sections = dict(re.findall(r"^## (\S+/\S+): (.*?)(?=^## \S+/\S+: |\Z)", text, re.S | re.M))
    report = json.load(open(folder / "study.json"))
    page = (folder / "index.html").read_text()
    parts = dict((name, whole) for whole, name in re.findall(r'(<section id="([^"]*)">.*?</section>)', page, re.S))
    rows = dict((name, whole) for whole, name in re.findall(r'(<tr><td><a href="#([^"]*)">.*?</tr>)', page, re.S))
    for study in report["studies"]:
        study["section"], study["home"] = sections[study["name"]], folder / study["name"]
        study["part"], study["row"] = parts[study["name"]], rows[study["name"]]
        study["head"] = page[:page.index("<h1>")]
        study["question"] = re.search(r"^\*(.*?)\*$", study["section"], re.S | re.M).group(1)
        studies[study["name"]] = study
    return studies


def order():
    """Names of all studies by the newest build."""
    built = max((ROOT / "build").glob("*/apps/lithe/lithe"), key=lambda p: p.stat().st_mtime)
    listed = subprocess.run([built, "study"], capture_output=True, text=True, check=True)
    return [line.split()[0] for line in listed.stdout.splitlines() if line.startswith("  ")]


def seconds(value):
    return "%.1f s" % value if value < 100 else "%.1f min" % (value / 60)


def verdict(study):
    held = sum(c["holds"] for c in study["checks"])
    if study.get("stopped"):
        return "**stopped**"
    return "%d of %d hold" % (held, len(study["checks"])) if held == len(study["checks"]) else "**%d of %d hold**" % (held, len(study["checks"]))


def anchor(study):
    heading = (study["name"] + ": " + study["title"]).lower()
    return re.sub(r"[^\w\- ]", "", heading).replace(" ", "-")


def write_group(group, studies):
    pictures = HOME / group
    shutil.rmtree(pictures, ignore_errors=True)
    with open(HOME / (group + ".md"), "w") as out:
        out.write("# %s\n\n`lithe study %s`, %s. Made by [make.py](make.py); [all studies](README.md).\n\n" %
                  (GROUPS[group], group, seconds(sum(s["seconds"] for s in studies))))
        for study in studies:
            out.write("## %s: %s" % (study["name"], study["section"]))
            for name in study["plots"] + study["pictures"]:
                svg = study["home"] / (name + ".svg")
                if svg.exists():
                    to = HOME / study["name"]
                    to.mkdir(parents=True, exist_ok=True)
                    shutil.copy(svg, to)


def write_page(studies, names):
    """The page of `lithe study all`, whole in one file: that of the program, or put together from several runs of it."""
    there = [studies[n] for n in names if n in studies]
    checks = [c for s in there for c in s["checks"]]
    with open(HOME / "all.html", "w") as out:
        out.write(re.sub(r"<title>.*?</title>", "<title>Lithe: all studies</title>", there[-1]["head"]))
        out.write("<h1>Lithe: all studies</h1>\n<p><code>lithe study all</code>, %s on two cores. %d of %d verdicts of %d studies hold. A verdict is "
                  "a computed number against a bound that stands with its reason in the study's source.</p>\n" %
                  (seconds(sum(s["seconds"] for s in there)), sum(c["holds"] for c in checks), len(checks), len(there)))
        out.write('<table class="list"><tr><th>study</th><th>what</th><th>verdicts that hold</th><th>all hold</th><th>seconds</th></tr>\n')
        out.write("\n".join(s["row"] for s in there) + "\n</table>\n")
        out.write("\n".join(s["part"] for s in there) + "\n</body></html>\n")


def write_index(studies, names):
    with open(HOME / "README.md", "w") as out:
        checks = [c for s in studies.values() for c in s["checks"]]
        out.write("# All studies\n\nWhat `lithe study all` computes anew, and what came out: %d studies with %d verdicts, %d of which hold, in %s "
                  "on two cores that\nothers used as well. A verdict is a computed number against a bound that stands with its reason in "
                  "the study's source. Made by [make.py](make.py);\nhow to run them: [lithe study](../reference/study.md). All on one page for a "
                  "browser: [all.html](all.html). Whether they could fail: [wrong factors](mutation.md).\nBesides: [the bunny's ears](ears.md), "
                  "[one answer by three methods](verify.md).\n" %
                  (len(studies), len(checks), sum(c["holds"] for c in checks), seconds(sum(s["seconds"] for s in studies.values()))))
        for group, title in GROUPS.items():
            out.write("\n## %s\n\n| study | question | verdicts | time |\n| --- | --- | --- | ---: |\n" % title)
            for name in names:
                if not name.startswith(group + "/") or name not in studies:
                    continue
                study = studies[name]
                out.write("| [%s](%s.md#%s) %s | %s | %s | %s |\n" %
                          (name.split("/")[1], group, anchor(study), study["title"], study["question"], verdict(study), seconds(study["seconds"])))
        missing = [n for n in names if n not in studies]
        if missing:
            out.write("\nNot run for this page: %s.\n" % ", ".join(missing))


def main():
    folders = [pathlib.Path(f) for f in sys.argv[1:]]
    if not folders:
        folders = [ROOT / "out/docs-studies"]
        if subprocess.run([ROOT / "build/release/apps/lithe/lithe", "study", "all", "-o", folders[0]]).returncode not in (0, 1):
            sys.exit("the studies could not be run")
    studies = {}
    for folder in folders:
        studies.update(read(folder))
    names = order()
    for group in GROUPS:
        write_group(group, [studies[n] for n in names if n.startswith(group + "/") and n in studies])
    write_index(studies, names)
    write_page(studies, names)


main()
