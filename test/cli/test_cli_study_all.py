"""All studies on one page, quick: every verdict holds, every study has its question, numbers, drawing, time and command."""
import html.parser
import json
import os
import re
import time

from cli import done, expect, folder, run

NAMES = [line.split()[0] for line in run("study").stdout.splitlines() if line.startswith("  ")]


class Page(html.parser.HTMLParser):
    """What stands in each section, and whether anything is fetched from elsewhere."""

    def __init__(self, text):
        super().__init__()
        self.sections, self.fetches, self.at = {}, [], None
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.fetches += [v for k, v in attrs.items() if k in ("src", "href", "xlink:href") and not v.startswith(("#", "data:"))]
        if tag == "section":
            self.at = self.sections.setdefault(attrs["id"], {"tags": [], "text": "", "verdicts": 0})
        if self.at is not None:
            self.at["tags"].append(tag)
            self.at["verdicts"] += attrs.get("class") in ("holds", "fails")

    def handle_endtag(self, tag):
        if tag == "section":
            self.at = None

    def handle_data(self, data):
        if self.at is not None:
            self.at["text"] += data


with folder() as home:
    began = time.time()
    got = run("study", "all", "--quick", "--json", "-o", "st", cwd=home, timeout=900)
    took = time.time() - began
    report = json.loads(got.stdout or "{}")
    studies = report.get("studies", [])
    failed = [s["name"] + ": " + c["what"] for s in studies for c in s["checks"] if not c["holds"]]
    failed += [s["name"] + " stopped: " + s["stopped"] for s in studies if "stopped" in s]
    expect("every_verdict_holds", got.returncode == 0 and not failed, (failed, got.stderr))
    expect("every_study_is_there", [s["name"] for s in studies] == NAMES, [s["name"] for s in studies])
    # three minutes on two quiet cores; other tests run beside this one, and a machine may have one core
    print("all of them took %.0f s, the longest: %s" % (took, ", ".join(
        "%s %.0f s" % (s["name"], s["seconds"]) for s in sorted(studies, key=lambda s: -s["seconds"])[:4])))
    bunny = os.path.exists("/usr/share/glmark2/models/bunny.obj")
    expect("every_study_has_verdicts", all(s["checks"] for s in studies if bunny or not s["name"].startswith("kaufmann/fig7")),
           [s["name"] for s in studies if not s["checks"]])
    expect("every_picture_is_a_file", all(os.path.getsize(os.path.join(home, "st", s["name"], p + ".svg")) > 0
                                          for s in studies for p in s["pictures"]), report)

    page = Page(open(os.path.join(home, "st/index.html")).read())
    expect("page_fetches_nothing", not page.fetches, page.fetches)
    expect("page_has_a_section_of_every_study", list(page.sections) == NAMES, list(page.sections))
    for study in studies:
        section = page.sections[study["name"]]
        expect(study["name"] + "_has_question_command_and_time",
               section["tags"].count("em") >= 1 and "lithe study %s --quick" % study["name"] in section["text"] and
               re.search(r", [0-9.]+ s", section["text"]) is not None, section["text"][:300])
        expect(study["name"] + "_has_all_verdicts", section["verdicts"] == len(study["checks"]), section["verdicts"])
        expect(study["name"] + "_has_its_drawings",
               section["tags"].count("figure") == len(study["plots"]) + len(study["pictures"]) or
               "gnuplot is not there" in section["text"], section["tags"])

    for study in studies:
        for name in study["plots"]:
            script = open(os.path.join(home, "st", study["name"], name + ".gp")).read()
            labels = re.findall(r'^set [xy]label "(.*)"$', script, re.M)
            expect("%s_%s_has_axes_with_units" % (study["name"], name), len(labels) == 2 and all(re.search(r"\[.+\]", l) for l in labels), labels)
            styles = re.findall(r"linespoints (pt \d+) ps [.\d]+ lw [.\d]+ (dt \d)", script)
            expect("%s_%s_is_read_without_colour" % (study["name"], name), len(styles) == len(set(styles)), styles)

# the page of the released state
docs = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../docs/studies")
if os.path.exists(docs):
    page = Page(open(os.path.join(docs, "all.html")).read())
    expect("docs_have_the_page_of_all_studies", list(page.sections) == NAMES and not page.fetches, (list(page.sections), page.fetches))
    expect("on_which_every_verdict_holds", "DOES NOT HOLD" not in str(page.sections) and "STOPPED" not in str(page.sections))
done()
