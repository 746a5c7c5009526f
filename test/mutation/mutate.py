#!/usr/bin/env python3
"""Does a wrong factor in a main formula fail a study or a test? Every mutant of mutants.py is put into a copy of the sources, the
copy is built, and its checks run until one of them fails; one that none finds is a survivor. Exit status 1 where there is one, or a
mutant that does not fit the sources, or a check that fails without any.

usage: mutate.py [--only WORD] [--short] [--all] [--resume] [--fit] [--table FILE] [--jobs N]
"""
import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys
import time

from mutants import CHECKS, MUTANTS, SHORT

ROOT = pathlib.Path(__file__).resolve().parents[2]
HOME = ROOT / "build" / "mutation"
TREE, BUILD, SCRATCH, KNOWN = HOME / "tree", HOME / "build", HOME / "scratch", HOME / "found.json"
NOTHING = "**nothing: "  # of a row: no check has found it
PATIENCE = 300  # seconds: a check that takes longer has not ended, and that is a failure


def copy_sources():
    """Tracked and new files; one that is as before keeps its time, so that little is built."""
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, capture_output=True, text=True, check=True)
    wanted = {f for f in listed.stdout.splitlines() if (ROOT / f).is_file() and not f.startswith("docs/")}
    for name in wanted:
        source, to = ROOT / name, TREE / name
        if to.exists() and to.read_bytes() == source.read_bytes():
            continue
        to.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(source, to)
        os.utime(to)
    for old in [p for p in TREE.rglob("*") if p.is_file()]:
        if str(old.relative_to(TREE)) not in wanted:
            old.unlink()


def configure():
    command = ["cmake", "-S", str(TREE), "-B", str(BUILD), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DLITHE_ASSERTS=ON",
               "-DLITHE_BENCH=OFF"]
    if shutil.which("ccache"):
        command.append("-DCMAKE_C_COMPILER_LAUNCHER=ccache")
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


def build(target, jobs):
    return subprocess.run(["cmake", "--build", str(BUILD), "-j", str(jobs), "--target", target], capture_output=True, text=True)


def run(command):
    """Exit status; None where it did not end."""
    try:
        return subprocess.run(command, cwd=SCRATCH, capture_output=True, text=True, timeout=PATIENCE,
                              env=dict(os.environ, LITHE_TEST_SOURCE=str(TREE), OMP_WAIT_POLICY="passive"))
    except subprocess.TimeoutExpired:
        return None


def run_study(name, jobs):
    made = build("lithe_app", jobs)
    if made.returncode:
        return "does not build", made.stdout[-2000:]
    shutil.rmtree(SCRATCH / "out", ignore_errors=True)
    got = run([str(BUILD / "apps/lithe/lithe"), "study", name, "--quick", "--json", "-o", "out"])
    if got is None:
        return "fails", "did not end"
    if got.returncode == 0:
        return "holds", ""
    if got.returncode != 1:
        return ("fails", "exit status %d" % got.returncode)
    study = json.loads(got.stdout)["studies"][0]
    why = [c["what"] for c in study["checks"] if not c["holds"]] or ["stopped: " + study.get("stopped", "")]
    return "fails", why[0]


def run_test(name, jobs):
    made = build(name, jobs)
    if made.returncode:
        return "does not build", made.stdout[-2000:]
    place = [p for p in (BUILD / "test").rglob(name) if p.is_file() and os.access(p, os.X_OK)]
    got = run([str(place[0])])
    if got is None:
        return "fails", "did not end"
    if got.returncode == 0:
        return "holds", ""
    failed = [line.split("]")[1].strip() for line in (got.stdout + got.stderr).splitlines() if line.startswith("[  FAILED  ]")]
    return "fails", next((f for f in failed if not f[0].isdigit()), "exit status %d" % got.returncode).split(":")[-1].strip()


def run_cli(name, jobs):
    made = build("lithe_app", jobs)
    if made.returncode:
        return "does not build", made.stdout[-2000:]
    got = run([sys.executable, str(TREE / "test/cli" / ("test_cli_%s.py" % name)), str(BUILD / "apps/lithe/lithe")])
    if got is None:
        return "fails", "did not end"
    if got.returncode == 0:
        return "holds", ""
    failed = [line[5:] for line in got.stdout.splitlines() if line.startswith("FAIL ")]
    return "fails", failed[0] if failed else "exit status %d" % got.returncode


def check(name, jobs):
    kind, _, rest = name.partition(" ")
    return {"study": run_study, "cli": run_cli}[kind](rest, jobs) if rest else run_test(name, jobs)


def key(group, mutant):
    return "%s: %s: %s: %s" % (group, mutant[0], mutant[1], mutant[3])


def checks_of(group, mutant):
    groups = mutant[4] if len(mutant) > 4 else (group,)
    return list(dict.fromkeys(c for g in groups for c in CHECKS[g]))


def try_mutant(group, mutant, args):
    """(verdict, by what, why): verdict is found, survives or error."""
    what, name, old, new = mutant[:4]
    file = TREE / "src" / name
    text = file.read_text()
    if text.count(old) != 1:
        return "error", "", "'%s' stands %d times in src/%s" % (old, text.count(old), name)
    file.write_text(text.replace(old, new))
    found = []
    try:
        for c in checks_of(group, mutant):
            verdict, why = check(c, args.jobs)
            if verdict == "does not build":
                return "error", c, "does not build: " + why
            if verdict == "fails":
                found.append((c, why))
                if not args.all:
                    break
    finally:
        file.write_text(text)
    if not found:
        return "survives", "", ""
    return "found", ", ".join(c for c, _ in found), found[0][1]


def check_fit(chosen):
    """Every text that a mutant replaces stands in the sources once: those that do not are told."""
    good = True
    for group, (what, name, old, *_) in chosen:
        file = ROOT / "src" / name
        n = file.read_text().count(old) if file.is_file() else 0
        if n != 1:
            print("error: %s, %s: '%s' stands %d times in src/%s" % (group, what, old, n, name))
            good = False
    return good


def check_unchanged(chosen, args):
    """Checks that fail without any mutant prove nothing."""
    good = True
    for c in dict.fromkeys(c for g, m in chosen for c in checks_of(g, m)):
        verdict, why = check(c, args.jobs)
        if verdict != "holds":
            print("error: %s %s without any mutant: %s" % (c, verdict, why))
            good = False
    return good


def table_row(group, mutant, verdict, by, why):
    """Cells of the table but for the last, which says of which run they are."""
    if not by:
        by = NOTHING + "%s**" % verdict
    elif by.startswith("study "):
        by = "`lithe %s`" % by
    else:
        by = "`test_%s`" % by.replace(" ", "_") if by.startswith("cli ") else "`%s`" % by
    return [group, mutant[0], "`%s`" % mutant[1], by, why.replace("_", " ").replace("|", "/")[:110]]


def read_table(path):
    """Rows of a table that was written before, by formula, wrong factor and file."""
    lines = pathlib.Path(path).read_text().splitlines() if pathlib.Path(path).exists() else []
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| ")]
    return {tuple(row[:3]): row[:5] for row in rows if len(row) >= 5 and row[2].startswith("`")}


def write_table(path, tried, known, seconds):
    """All mutants: those of this run, and of the others what is known from earlier ones, or stands in the table as it is."""
    before, rows = read_table(path), []
    for group, mutant in [(g, m) for g, list_ in MUTANTS.items() for m in list_]:
        name = key(group, mutant)
        if name in known:
            row = table_row(group, mutant, *known[name][:3])
        else:
            row = before.get((group, mutant[0], "`%s`" % mutant[1])) or table_row(group, mutant, "not tried", "", "")
        rows.append([*row, "last" if name in tried else "earlier"])
    found, n_new = sum(not row[3].startswith(NOTHING) for row in rows), sum(row[5] == "last" for row in rows)
    when = "All were tried in one run of %.0f minutes." % (seconds / 60)
    if n_new < len(rows):
        when = "%d were tried in the last run of the script, and %d are carried over from earlier ones, as the last column says." % (
            n_new, len(rows) - n_new)
    with open(path, "w") as out:
        out.write("# Wrong factors, and what finds them\n\n")
        out.write("Made by `./dev mutate` ([mutants.py](../../test/mutation/mutants.py) has the list): each row is one wrong factor in one "
                  "formula, put into a copy of\nthe sources; the first study (`--quick`) or test that fails is named. "
                  "%d of %d are found.\n%s\n\n" % (found, len(rows), when))
        out.write("| formula | wrong factor in | file | found by | what fails | run |\n| --- | --- | --- | --- | --- | --- |\n")
        out.writelines("| %s |\n" % " | ".join(row) for row in rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--only", default="", help="mutants whose group or name has this word")
    parser.add_argument("--short", action="store_true", help="one mutant of each main formula")
    parser.add_argument("--all", action="store_true", help="all checks of every mutant, not the first that finds it")
    parser.add_argument("--resume", action="store_true", help="keep what an earlier run found, try the others")
    parser.add_argument("--fit", action="store_true", help="only look whether every mutant fits the sources")
    parser.add_argument("--table", help="write the table to this file; rows of mutants that are not tried now stay, and say so")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    args = parser.parse_args()
    began_all = time.time()
    chosen = [(g, MUTANTS[g][i]) for g, i in SHORT] if args.short else [(g, m) for g, list_ in MUTANTS.items() for m in list_]
    chosen = [(g, m) for g, m in chosen if args.only in g or args.only in m[0]]
    fits = check_fit(chosen)
    if args.fit or not fits:
        return 0 if fits else 1
    SCRATCH.mkdir(parents=True, exist_ok=True)
    copy_sources()
    configure()
    known = json.loads(KNOWN.read_text()) if KNOWN.exists() else {}
    if not args.resume:
        for group, mutant in chosen:
            known.pop(key(group, mutant), None)
    todo = [(g, m) for g, m in chosen if known.get(key(g, m), [""])[0] != "found"]
    if not check_unchanged(todo, args):
        return 1
    rows = []
    for k, (group, mutant) in enumerate(chosen):
        began = time.time()
        if (group, mutant) in todo:
            known[key(group, mutant)] = try_mutant(group, mutant, args)
            KNOWN.write_text(json.dumps(known, indent=1))
        verdict, by, why = known[key(group, mutant)][:3]
        rows.append((group, mutant, verdict, by, why))
        print("%3d of %d  %-8s %s, %s: %s %s (%.0f s)" % (k + 1, len(chosen), verdict, group, mutant[0], by, why[:90], time.time() - began),
              flush=True)
    bad = [r for r in rows if r[2] != "found"]
    print("%d of %d wrong factors are found" % (len(rows) - len(bad), len(rows)))
    if args.table:
        write_table(args.table, {key(g, m) for g, m in todo}, known, time.time() - began_all)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
