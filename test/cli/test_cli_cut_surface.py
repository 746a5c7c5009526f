"""Embedded surfaces of bodies that are cut, as files: closed, with the volume of the body, points with numbers for life."""
import json
import math
import os
import signal
import struct
from collections import Counter

from cli import done, expect, folder, run
from resume import check_resumes, write
from surfaces import ball

BALL = """lithe: 1
bodies:
  - name: ball
    shape: {sphere: {center: [0, 0.1, 0], radius: 0.08}, resolution: 20 mm}
    material: {model: corotated, young_modulus: 20 kPa, poisson_ratio: 0.3, density: 1000}
    method: {kind: dg, cells: 3, degree: 1}
    embed: {surface: shape}
    initial: {velocity: [0.1, -0.2, 0.3]}
cuts:
  - {at: 0, plane: {point: [0.01, 0.1, 0], normal: [1, 0, 0.3]}}
  - {at: 0.021, plane: {point: [0.01, 0.11, 0], normal: [0.1, 1, 0.2]}}
  - {at: 0.041, plane: {point: [0.01, 0.1, 0], normal: [0, 0.4, 1]}, space: rest}
time: {kind: dynamic, duration: 0.06, step: 1/200}
output: {every: 1/100, fields: [none], surface: [pc2], checkpoint: 0}
"""
BLOCK = """lithe: 1
bodies:
  - name: block
    shape: {box: {min: [0, 0.002, 0], max: [0.2, 0.102, 0.1]}}
    material: {model: corotated, young_modulus: 20 kPa, poisson_ratio: 0.4, density: 1000, damping: {stiffness: 1e-3}}
    method: {kind: dg, mesh: hexahedra, cells: [4, 2, 2], degree: 1, sliver: 0.01}
    embed: {surface: {file: ball.obj}}
    initial: {velocity: [0.3, -0.1, 0.1]}
cuts:
  - {at: 0, plane: {point: [0.05, 0.05, 0.05], normal: [1, 0, 0.3]}}
  - {at: 0.031, plane: {point: [0.12, 0.05, 0.05], normal: [1, 0.1, 0.2]}}
time: {kind: dynamic, duration: 0.06, step: 1/200}
output: {every: 1/100, fields: [none], surface: [ply, obj], checkpoint: 0}
"""


class Surface:
    def __init__(self, path):
        self.x, self.uv, self.polys, self.corners, self.groups, group = [], [], [], [], [], None
        for line in open(path):
            w = line.split()
            if w[0] == "v":
                self.x.append(tuple(map(float, w[1:4])))
            elif w[0] == "vt":
                self.uv.append(tuple(map(float, w[1:3])))
            elif w[0] == "g":
                group = w[1]
            elif w[0] == "f":
                self.polys.append([int(c.split("/")[0]) - 1 for c in w[1:]])
                self.corners.append([int(c.split("/")[1]) - 1 if "/" in c else -1 for c in w[1:]])
                self.groups.append(group)

    def open_edges(self):
        count = Counter()
        for poly in self.polys:
            for a, b in zip(poly, poly[1:] + poly[:1]):
                count[min(a, b), max(a, b)] += 1 if a < b else -1
        return [edge for edge, n in count.items() if n]

    def volume(self):
        def det(a, b, c):
            return (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]))
        return sum(det(self.x[p[0]], self.x[p[i]], self.x[p[i + 1]]) for p in self.polys for i in range(1, len(p) - 1)) / 6

    def parts(self):
        root = list(range(len(self.x)))

        def find(i):
            while root[i] != i:
                root[i] = root[root[i]]
                i = root[i]
            return i
        for p in self.polys:
            for q in p:
                root[find(q)] = find(p[0])
        return len({find(p[0]) for p in self.polys})


def solve(d, text):
    write(d, "scene.yaml", text)
    got = run("run", "scene.yaml", "-q", "-o", "out", cwd=d)
    expect("runs_well", got.returncode == 0 and got.stderr == "", got.stderr)
    return json.load(open(os.path.join(d, "out", "result.json")))


with folder() as d:
    result = solve(d, BALL)
    out = os.path.join(d, "out")
    told = result["bodies"][0]["surface"]
    expect("a_cache_ends_with_the_first_cut_of_the_run", told["pc2_frames"] == 3 and told["numbered_from"] == "surface_0003.obj", told)
    names = sorted(n for n in os.listdir(out) if n.startswith("surface"))
    expect("numbered_files_follow", names == ["surface.obj", "surface.pc2"] +
           ["surface_%04d.obj" % i for i in range(3, 7)], names)
    head = open(os.path.join(out, "surface.pc2"), "rb").read()
    surfaces = [Surface(os.path.join(out, name)) for name in ["surface.obj"] + names[2:]]
    _, _, n, _, _, samples = struct.unpack("<12siiffi", head[:32])
    expect("the_cache_holds_what_came_before", (n, samples, len(head)) == (len(surfaces[0].x), 3, 32 + 36 * n), (n, samples))
    expect("all_are_closed", not any(s.open_edges() for s in surfaces), [len(s.open_edges()) for s in surfaces])
    expect("numbers_of_points_only_grow", [len(s.x) for s in surfaces] == sorted(len(s.x) for s in surfaces), None)
    expect("parts_are_those_of_the_body", [s.parts() for s in surfaces] == [2, 4, 4, 8, 8], [s.parts() for s in surfaces])
    whole = surfaces[0].volume()
    expect("their_volumes_add_up", abs(whole / result["bodies"][0]["volume"] - 1) < 1e-8, whole)
    expect("in_motion_too", all(abs(s.volume() / whole - 1) < 1e-3 for s in surfaces), [s.volume() for s in surfaces])
    for s in surfaces:
        cuts = [i for i, g in enumerate(s.groups) if g == "cut"]
        expect("cuts_have_a_group_and_come_last", cuts and cuts == list(range(cuts[0], len(s.polys))), s.groups[-1])
        expect("and_a_texture", all(c >= 0 for i in cuts for c in s.corners[i]), None)
    rest = surfaces[0]
    texture = {}
    for i, poly in enumerate(rest.polys):
        if rest.groups[i] == "cut":
            for p, c in zip(poly, rest.corners[i]):
                texture.setdefault(tuple(round(v, 9) for v in rest.x[p]), set()).add(tuple(round(v, 9) for v in rest.uv[c]))
    expect("both_sides_have_the_same_texture", texture and all(len(v) == 1 for v in texture.values()), texture)

with folder() as d:
    ball(os.path.join(d, "ball.obj"), (0.1, 0.052, 0.05), 0.047)
    result = solve(d, BLOCK)
    out = os.path.join(d, "out")
    first, before, after = (Surface(os.path.join(out, "surface_%04d.obj" % i)) for i in (0, 3, 6))
    given = Surface(os.path.join(d, "ball.obj"))
    expect("another_surface_is_cut_as_the_body_is", (first.parts(), before.parts(), after.parts()) == (1, 1, 2), (first.parts(), before.parts(), after.parts()))
    expect("its_parts_are_closed", not first.open_edges() and not after.open_edges(), (first.open_edges(), after.open_edges()))
    expect("and_have_its_volume", abs(first.volume() / given.volume() - 1) < 1e-8 and abs(after.volume() / given.volume() - 1) < 0.02,
           (given.volume(), first.volume(), after.volume()))
    expect("its_points_come_first", all(math.dist(a, b) < 1e-9 for a, b in zip(given.x, first.x)), None)
    expect("ply_is_written_as_well", os.path.exists(os.path.join(out, "surface_0006.ply")), None)
    expect("without_a_cache_there_is_nothing_to_tell", "surface" not in result["bodies"][0], result["bodies"][0])

with folder() as d:
    ball(os.path.join(d, "ball.obj"), (0.1, 0.052, 0.05), 0.047)
    head, tail = BLOCK.split("cuts:")
    solve(d, head + "cuts: [{at: 0, carve: {box: {min: [-1, -1, -1], max: [0.09, 1, 1]}}, keep: inside}]\ntime:" + tail.split("time:")[1])
    left = Surface(os.path.join(d, "out", "surface_0000.obj"))
    h = 0.09 - 0.053
    cap = math.pi * h * h * (3 * 0.047 - h) / 3
    expect("what_a_carve_takes_away_takes_its_surface_along", not left.open_edges() and abs(left.volume() / cap - 1) < 0.04,
           (left.volume(), cap))

with folder() as d:
    write(d, "sheet.obj", "v 0 0.05 0\nv 0.2 0.05 0\nv 0.2 0.05 0.1\nv 0 0.05 0.1\nf 1 2 3 4\n")
    head, tail = BLOCK.replace("ball.obj", "sheet.obj").split("cuts:")
    cut = "cuts:\n  - {at: 0.031, plane: {point: [0.12, 0.05, 0.05], normal: [1, 0.1, 0.2]}, space: rest}\ntime:"
    result = solve(d, head.replace("initial: {velocity: [0.3, -0.1, 0.1]}", "") + cut + tail.split("time:")[1])
    before, after = (Surface(os.path.join(d, "out", "surface_%04d.obj" % i)) for i in (3, 6))
    expect("a_sheet_is_shown_until_a_cut", len(before.polys) == 1 and len(before.x) == 4, before.polys)
    expect("then_the_boundary_of_the_body_is", not after.open_edges() and after.parts() == 2 and
           abs(after.volume() / result["bodies"][0]["volume"] - 1) < 1e-3, (after.open_edges(), after.parts(), after.volume()))
    expect("behind_the_points_of_the_sheet", all(math.dist(p, q) < 1e-2 for p, q in zip(before.x, after.x)), after.x[:4])
    expect("and_a_warning_says_so", any("not closed" in w for w in result["warnings"]), result["warnings"])

check_resumes("cut ball", BALL, [(2, signal.SIGKILL), (4, signal.SIGKILL), (6, signal.SIGINT)])
with folder() as d:
    ball(os.path.join(d, "ball.obj"), (0.1, 0.052, 0.05), 0.047)
    check_resumes("cut block", BLOCK.replace("ball.obj", os.path.join(d, "ball.obj")), [(5, signal.SIGKILL)])
done()
