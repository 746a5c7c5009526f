#!/usr/bin/env python3
"""CalculiX's own test decks through `lithe convert` and `lithe run`, held against CalculiX's printed results.

    calculix_table.py PROGRAM [--quick] [--write docs/reference/calculix.md] [--keep FOLDER] [DECK ...]

Every deck of Debian's calculix-ccx-test is given to the converter. What it translates is run with cg (the deck's own
elements: displacements at the nodes and stresses at the integration points, to the printed digits) and with dg of
degrees 2 and 3 on the same cells (within discretisation error, which is stated). Exit status 1: a figure differs; 77: the
package is not installed. --quick: a few decks, cg only.
"""
import argparse
import gzip
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

DECKS = Path("/usr/share/doc/calculix-ccx-test/examples/test")
QUICK = ["achtelc", "achteld", "achtelp", "beam8p", "beam10p", "beam20p", "beamd", "beampset"]
# printed with 7 digits (.dat) or 6 (.frd): half a unit in the last one, and as much again of the largest number
# for what CalculiX's own rounding leaves where the exact value is 0
DIGITS = {"dat": 5.1e-7, "frd": 5.1e-6}
FLOOR = 2e-8

# ------------------------------------------------------------------------------------------------- CalculiX's files


def read_text(path):
    """A file of the package, which Debian may have compressed; None where it is missing."""
    if path.exists():
        return path.read_bytes().decode("latin1")
    packed = path.with_name(path.name + ".gz")
    return gzip.open(packed).read().decode("latin1") if packed.exists() else None


class Deck:
    """Nodes and elements of a deck."""

    def __init__(self, text):
        self.nodes, self.elements, self.title = {}, {}, ""
        card, numbers, open_element = "", [], None
        for line in text.splitlines():
            if line.startswith("**") or not line.strip():
                continue
            if line.startswith("*"):
                words = [w.strip().upper().replace(" ", "") for w in line[1:].split(",")]
                card = words[0]
                kind = next((w[5:] for w in words if w.startswith("TYPE=")), "")
                open_element = None
                continue
            fields = [f.strip() for f in line.split(",")]
            if card == "NODE":
                values = [float(f.upper().replace("D", "E") or 0) for f in fields[1:4]]
                self.nodes[int(fields[0])] = values + [0.0] * (3 - len(values))
            elif card == "ELEMENT":
                numbers = [int(f) for f in fields if f]
                if open_element is None:
                    open_element = numbers[0]
                    self.elements[open_element] = (kind, numbers[1:])
                else:
                    self.elements[open_element][1].extend(numbers)
                if not line.rstrip().endswith(","):
                    open_element = None


def read_dat(text, step):
    """{"U": {node: vector}, "S": {(element, point): xx yy zz xy xz yz}} of the last time printed, or of step 1."""
    result, block = {"U": {}, "S": {}}, None
    for line in text.splitlines():
        words = line.split()
        if not words:
            continue
        if "for set" in line:
            if step == 1 and float(words[-1]) > 1:
                break
            block = "U" if line.strip().startswith("displacements") else \
                "S" if line.strip().startswith("stresses") else None
            continue
        if block == "U" and len(words) == 4:
            result["U"][int(words[0])] = [float(w) for w in words[1:]]
        elif block == "S" and len(words) >= 8:
            result["S"][int(words[0]), int(words[1])] = [float(w) for w in words[2:8]]
    return result


def read_frd(text, step):
    """Displacements of the last step, or of step 1."""
    result, inside = {"U": {}, "S": {}}, False
    for line in text.splitlines():
        if "100CL" in line and step == 1 and float(line.split()[2]) > 1:
            break
        if line.startswith(" -4"):
            inside = line[5:].split()[0] == "DISP"
        elif line.startswith(" -3"):
            inside = False
        elif inside and line.startswith(" -1"):
            result["U"][int(line[3:13])] = [float(line[13 + 12 * i:25 + 12 * i]) for i in range(3)]
    return result


def run_calculix(name, text):
    """What CalculiX prints where it solves directly; None where it is not installed."""
    if not shutil.which("ccx"):
        return None
    with tempfile.TemporaryDirectory() as folder:
        direct = re.sub(r"(?im)^(\*STATIC)\s*,\s*SOLVER\s*=\s*ITERATIVE.*$", r"\1", text)
        (Path(folder) / (name + ".inp")).write_bytes(direct.encode("latin1"))
        subprocess.run(["ccx", "-i", name], cwd=folder, capture_output=True, timeout=600)
        return read_text(Path(folder) / (name + ".dat"))


def read_reference(name, text, step):
    """Printed results of a deck and where they stand; (None, "") where there are none."""
    dat, where = read_text(DECKS / (name + ".dat.ref")), "dat"
    if re.search(r"(?i)SOLVER\s*=\s*ITERATIVE", text):  # its last digits are those of an iteration
        dat, where = run_calculix(name, text) or "", "dat of ccx, direct solver"
    if dat:
        result = read_dat(dat, step)
        if result["U"] or result["S"]:
            return result, where
    frd = read_text(DECKS / (name + ".frd.ref"))
    if frd:
        result = read_frd(frd, step)
        if result["U"]:
            return result, "frd"
    return None, ""


# ---------------------------------------------------------------------------------- CalculiX's integration points

CORNERS = [(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)]
EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]


def hex_shape(n, xi):
    corner = np.array(CORNERS, dtype=float)
    if n == 8:
        return np.prod(1 + corner * xi, axis=1) / 8
    mid = np.array([(corner[a] + corner[b]) / 2 for a, b in EDGES])
    at_corner = np.prod(1 + corner * xi, axis=1) * (corner @ xi - 2) / 8
    at_mid = np.prod(np.where(mid == 0, 1 - xi**2, 1 + mid * xi), axis=1) / 4
    return np.concatenate([at_corner, at_mid])


def tet_shape(n, xi):
    r = np.array([1 - xi.sum(), *xi])
    if n == 4:
        return r
    pairs = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
    return np.concatenate([r * (2 * r - 1), [4 * r[a] * r[b] for a, b in pairs]])


def wedge_shape(n, xi):
    r, z = np.array([1 - xi[0] - xi[1], xi[0], xi[1]]), xi[2]
    low, high = (1 - z) / 2, (1 + z) / 2
    if n == 6:
        return np.concatenate([r * low, r * high])
    pairs = [(0, 1), (1, 2), (2, 0)]
    return np.concatenate([r * ((2 * r - 1) * low - (1 - z * z) / 2), r * ((2 * r - 1) * high - (1 - z * z) / 2),
                           [4 * r[a] * r[b] * low for a, b in pairs], [4 * r[a] * r[b] * high for a, b in pairs],
                           r * (1 - z * z)])


def grid_points(line):
    return [np.array([x, y, z]) for z in line for y in line for x in line]


def integration_points(kind, nodes):
    """Places of an element's integration points, in CalculiX's order."""
    two, three = [-1 / 3**0.5, 1 / 3**0.5], [-0.6**0.5, 0.0, 0.6**0.5]
    a, b = 0.25 - 0.05 * 5**0.5, 0.25 + 0.15 * 5**0.5
    triangle = [(1 / 6, 1 / 6), (2 / 3, 1 / 6), (1 / 6, 2 / 3)]
    shape, points = {
        "C3D8": (hex_shape, grid_points(two)), "C3D8R": (hex_shape, [np.zeros(3)]),
        "C3D20": (hex_shape, grid_points(three)), "C3D20R": (hex_shape, grid_points(two)),
        "C3D4": (tet_shape, [np.full(3, 0.25)]),
        "C3D10": (tet_shape, [np.array(p) for p in ((a, a, a), (b, a, a), (a, b, a), (a, a, b))]),
        "C3D6": (wedge_shape, [np.array([1 / 3, 1 / 3, z]) for z in two]),
        "C3D15": (wedge_shape, [np.array([*p, z]) for z in three for p in triangle])}[kind]
    x = np.array(nodes)
    return [shape(len(nodes), xi) @ x for xi in points]


# --------------------------------------------------------------------------------------------------------- one deck


def call(*command):
    return subprocess.run([str(c) for c in command], capture_output=True, text=True, errors="replace", timeout=600)


def probes_of(deck, reference):
    """Name and place of everything that the reference prints."""
    probes = [(f"n{node}", deck.nodes[node]) for node in reference["U"] if node in deck.nodes]
    places = {}
    for element, point in reference["S"]:
        if element not in places:
            kind, nodes = deck.elements[element]
            places[element] = integration_points(kind, [deck.nodes[n] for n in nodes])
        probes.append((f"s{element}-{point}", places[element][point - 1]))
    return probes


def used(deck):
    return {n for _, nodes in deck.elements.values() for n in nodes}


def enlarge_gravity(scene):
    """Where gravity alone acts it is taken a million times, and so is what CalculiX printed: the positions of a run
    carry 16 digits, which leaves 7 for displacements of a billionth of the body's size. Returns the factor."""
    text = scene.read_text()
    found = re.search(r"(?m)^gravity: \[(.*)\]$", text)
    if not found or "loads:" in text:
        return 1
    enlarged = ", ".join("%.17g" % (1e6 * float(g)) for g in found.group(1).split(","))
    scene.write_text(text.replace(found.group(0), f"gravity: [{enlarged}]"))
    return 1e6


def run_lithe(program, scene, folder, *options):
    """The result of a run, or the first line of what it said."""
    got = call(program, "run", scene, "-o", folder, "--quiet", *options)
    if got.returncode != 0:
        return None, (got.stderr.strip().splitlines() or ["no message"])[0]
    return json.loads((Path(folder) / "result.json").read_text()), ""


def pairs(result, reference):
    """Computed and printed numbers side by side: displacements (n x 3), stresses (n x 6)."""
    probes = result["probes"]
    u = [(probes[f"n{node}"]["displacement"], value) for node, value in reference["U"].items()]
    s = []
    for (element, point), value in reference["S"].items():
        xx, yy, zz, yz, zx, xy = probes[f"s{element}-{point}"]["stress"]
        s.append(([xx, yy, zz, xy, zx, yz], value))
    return [np.array(p, dtype=float).reshape(-1, 2, len(p[0][0])) if p else np.zeros((0, 2, 1)) for p in (u, s)]


def excess(both, digits):
    """Largest difference over what the printed digits leave open: met where <= 1."""
    if not len(both):
        return None
    ours, theirs = both[:, 0], both[:, 1]
    allowed = digits * 10 ** np.floor(np.log10(np.maximum(np.abs(theirs), 1e-300))) + FLOOR * np.abs(theirs).max()
    return float((np.abs(ours - theirs) / allowed).max())


def relative(both):
    """Euclidean distance over Euclidean length."""
    return None if not len(both) else float(np.linalg.norm(both[:, 0] - both[:, 1]) / np.linalg.norm(both[:, 1]))


def distances(row):
    """Of dg 2 from CalculiX and from dg 3, and of CalculiX from dg 3; None where it was not run."""
    two, three = row.get("dg2"), row.get("dg3")
    if two is None or three is None:
        return None
    between = np.stack([two[:, 0], three[:, 0]], axis=1)
    return relative(two), relative(between), relative(three[:, ::-1])


def reason(message):
    """Why the converter refused, without the path and the remedies."""
    lines = [line[7:] for line in message.splitlines() if line.startswith("lithe: ")] or ["no message"]
    place = re.match(r"\S*\.inp(?::(\d+))?: ", lines[-1])
    text = lines[-1][place.end():] if place else lines[-1]
    return (f"line {place.group(1)}: " if place and place.group(1) else "") + re.split(r"; (?!-)|, Lithe's", text)[0]


def study(program, name, folder, with_dg):
    """A row of the table."""
    text = read_text(DECKS / (name + ".inp"))
    source = Path(folder) / (name + ".inp")
    source.write_bytes(text.encode("latin1"))
    scene = Path(folder) / (name + ".yaml")
    got, step = call(program, "convert", source, scene), 0
    if "; --step 1 translates" in got.stderr:
        got, step = call(program, "convert", source, scene, "--step", 1), 1
    if got.returncode != 0:
        return dict(name=name, state="left out", reason=reason(got.stderr), crashed=got.returncode != 2)
    deck = Deck(text)
    kinds = sorted({kind for kind, _ in deck.elements.values()})
    row = dict(name=name + (" (step 1)" if step else ""), kinds=kinds, n_nodes=len(used(deck)), n_elements=len(deck.elements), crashed=False)
    reference, where = read_reference(name, text, step)
    if reference is None:
        return dict(row, state="left out", reason="is translated; there is no printed result to hold it against")
    factor = enlarge_gravity(scene)
    if factor != 1:
        row["where_note"] = f", gravity times {factor:g}"
    reference["U"] = {n: factor * np.array(v) for n, v in reference["U"].items() if n in used(deck)}
    reference["S"] = {p: factor * np.array(v) for p, v in reference["S"].items()}
    probes = probes_of(deck, reference)
    with open(scene, "a") as f:
        f.write("solver: {linear: cholesky, tolerance: 1e-12}\nprobes:\n")
        for label, at in probes:
            f.write("  - {name: %s, point: [%s]}\n" % (label, ", ".join("%.17g" % v for v in at)))
    result, message = run_lithe(program, scene, Path(folder) / (name + "-cg"), "--set", "output.fields=[none]")
    if result is None:
        return dict(row, state="failed", reason="cg: " + message)
    u, s = pairs(result, reference)
    row.update(u=excess(u, DIGITS[where[:3]]), s=excess(s, DIGITS[where[:3]]), n_u=len(u), n_s=len(s), where=where)
    row["u_error"], row["s_error"] = relative(u), relative(s)
    row["state"] = "met" if max(v for v in (row["u"], row["s"], 0) if v is not None) <= 1 else "differs"
    for degree in (2, 3) if with_dg else ():
        result, message = run_lithe(program, scene, Path(folder) / f"{name}-dg{degree}", "--set",
                                    "output.fields=[none]", "--set", "bodies.0.method.kind=dg", "--set",
                                    f"bodies.0.method.degree={degree}")
        row[f"dg{degree}"] = pairs(result, reference)[0] if result else None
        row["dg_reason"] = "held at single nodes" if "selects nothing of the" in message else message
    return row


# ------------------------------------------------------------------------------------------------------- the table


def number(value, form="%.1e"):
    return "-" if value is None else form % value


def write_page(rows, path):
    """docs/reference/calculix.md"""
    run = [r for r in rows if r["state"] in ("met", "differs")]
    out = [r for r in rows if r["state"] not in ("met", "differs")]
    lines = [
        "# CalculiX's test decks", "",
        "<!-- made by test/golden/calculix_table.py --write; run that instead of changing this -->", "",
        f"All {len(rows)} decks of Debian's `calculix-ccx-test` (2.11), translated by",
        "[`lithe convert`](convert.md) and run: " + f"{len(run)} are linear elastic static solids that a scene can say, "
        f"{len(out)} are left out, each", "with the reason.", "",
        "## Run", "",
        "`cg` computes on the deck's own nodes with the deck's own elements and integration points. *Printed* is how many",
        "displacements and stresses CalculiX printed; *met* says that all of them agree to the last printed digit (the",
        "largest difference is given in units of what the digits leave open, 1 being half a unit of the last one and",
        f"{FLOOR:g} of the largest number). The three last columns are Euclidean distances of displacements at the nodes",
        "over their length: of dg of degree 2 on the same cells, held weakly, from CalculiX; the same from dg of degree 3; and",
        "of CalculiX from dg of degree 3. Where the second is the smallest, dg of degree 2 differs from CalculiX by what",
        "CalculiX's elements leave. Forces at nodes have no finite displacement under them in the limit, so these do not",
        "go to zero. Supports of single nodes hold nothing of a discontinuous solid, whose weak supports are areas.", "",
        "| deck | elements | nodes | printed u, stress | cg against the printed digits (u, stress) | dg 2 - CalculiX | dg 2 - dg 3 "
        "| CalculiX - dg 3 |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |"]
    for r in run:
        verdict = f"{r['state']} ({number(r['u'], '%.2f')}, {number(r['s'], '%.2f')})"
        d = distances(r)
        dg = " | ".join(number(v) for v in d) if d else r.get("dg_reason", "-") + " | - | -"
        lines.append(f"| {r['name']} | {r['n_elements']} {' '.join(r['kinds'])} | {r['n_nodes']} | "
                     f"{r['n_u']}, {r['n_s']} ({r['where']}{r.get('where_note', '')}) | {verdict} | {dg} |")
    lines += ["", "## Left out", "", "| deck | reason |", "| --- | --- |"]
    lines += [f"| {r['name']} | {r['reason'].replace('|', '/')} |" for r in out]
    Path(path).write_text("\n".join(lines) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("decks", nargs="*")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--write")
    parser.add_argument("--keep", help="write scenes and results into this folder")
    options = parser.parse_args()
    if not DECKS.is_dir():
        print("calculix-ccx-test is not installed")
        return 77
    names = options.decks or (QUICK if options.quick else
                              sorted({f.name.split(".inp")[0] for f in DECKS.glob("*.inp*")}))
    rows = []
    with tempfile.TemporaryDirectory(prefix="lithe-calculix-") as scratch:
        folder = options.keep or scratch
        os.makedirs(folder, exist_ok=True)
        for name in names:
            row = study(os.path.abspath(options.program), name, folder, not options.quick)
            rows.append(row)
            if row["state"] in ("met", "differs"):
                print(f"{name:14} {row['state']:8} u {number(row['u'], '%.2f')} ({number(row['u_error'])})  "
                      f"stress {number(row['s'], '%.2f')} ({number(row['s_error'])})  dg " +
                      (" ".join(number(v) for v in distances(row)) if distances(row) else
                       row.get("dg_reason", "")), flush=True)
            else:
                print(f"{name:14} {row['state']:8} {row['reason']}", flush=True)
    if options.write:
        write_page(rows, options.write)
    bad = [r["name"] for r in rows if r["state"] in ("differs", "failed") or r["crashed"]]
    if options.quick:
        bad += [r["name"] for r in rows if r["state"] != "met"]
    if bad:
        print("not met: " + " ".join(bad))
    return 1 if bad else 0


sys.exit(main())
