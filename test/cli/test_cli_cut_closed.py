"""Random cuts of bodies at rest and in motion: each edge of the surfaces that are written has two polygons, and they hold what the elements hold."""
import json
import math
import os
import random
import time
from collections import Counter

from cli import done, expect, folder, run
from resume import write
from surfaces import ball

# touched themselves along edges before these were parted: carves, blades and planes that end inside, of both kinds of surfaces
KNOWN = [4, 7, 11, 13, 16, 21]
AT_REST = [2, 6, 23]
N_RANDOM = int(os.environ.get("LITHE_TEST_OPERATIONS", "3"))
FIRST = int(os.environ.get("LITHE_TEST_SEED", str(int(time.time()) % 10**6 + 1000)))


def place(r, *half):
    return "[%s]" % ", ".join("%.3f" % r.uniform(-h, h) for h in half)


def blade(r):
    n, x, y, angle, path = r.randint(2, 6), r.uniform(-1.1, -.2), r.uniform(-.5, .5), r.uniform(-.6, .6), []
    for k in range(n + 1):
        path.append("[%.3f, %.3f, %.3f]" % (x, y, -1.3 + .05 * (k % 2)))
        length = r.uniform(.06, 2.6 / n)
        x, y, angle = x + length * math.cos(angle), y + length * math.sin(angle), angle + r.uniform(-.7, .7)
    return "blade: {path: [%s], depth: [%.3f, %.3f, %.3f]}" % (
        ", ".join(path), r.uniform(-.3, .3), r.uniform(-.3, .3), r.choice([2.6, r.uniform(.6, 2.4)]))


def solid(r):
    kind = r.choice(["sphere", "box", "cylinder"])
    if kind == "sphere":
        return "sphere: {center: %s, radius: %.3f}" % (place(r, .6, .4, .4), r.uniform(.2, .6))
    if kind == "cylinder":
        return "cylinder: {from: [%.3f, %.3f, -1], to: [%.3f, %.3f, 1], radius: %.3f}" % (
            r.uniform(-.6, .6), r.uniform(-.4, .4), r.uniform(-.6, .6), r.uniform(-.4, .4), r.uniform(.1, .4))
    low = [r.uniform(-h, h) for h in (.6, .4, .4)]
    high = [a + r.uniform(.2, h) for a, h in zip(low, (.8, .6, .6))]
    return "box: {min: [%.3f, %.3f, %.3f], max: [%.3f, %.3f, %.3f]}" % (*low, *high)


def cut(r, at):
    space, kind = r.choice(["rest", "deformed", "deformed"]), r.choice(["plane", "plane", "blade", "carve", "carve"])
    if kind == "plane":
        what = "plane: {point: %s, normal: %s}" % (place(r, .5, .3, .3), place(r, 1, 1, 1))
        if r.random() < .4:
            what += ", within: {sphere: {center: %s, radius: %.3f}}" % (place(r, .6, .4, .4), r.uniform(.2, .7))
    elif kind == "blade":
        what = blade(r)
    else:
        what = "carve: {%s}, keep: %s" % (solid(r), r.choice(["both", "both", "outside", "inside"]))
    return "  - {at: %g, space: %s, %s}\n" % (at, space, what)


def scene(r, is_other, moves):
    cells = r.randint(2, 4)
    shape = r.choice([
        "{sphere: {center: [0, 0, 0], radius: %.3f}, resolution: 0.3}" % r.uniform(.6, 1),
        "{box: {min: [-1, -0.7, -0.6], max: [1, 0.7, 0.6]}}",
        "{difference: [{box: {min: [-1, -0.7, -0.6], max: [1, 0.7, 0.6]}}, {cylinder: {from: [0, 0, -1], to: [0, 0.2, 1], radius: 0.3}}], resolution: 0.3}"])
    text = """lithe: 1
bodies:
  - name: solid
    shape: %s
    material: {young_modulus: 1e4, poisson_ratio: 0.3, density: 1000}
    method: {kind: dg, cells: %d, degree: %d, flux: ip, sliver: %s}
    embed: {surface: %s}
""" % (shape, cells, 1 if cells > 3 else r.choice([1, 1, 2]), r.choice(["0.05", "0.002", "0"]), "{file: ball.obj}" if is_other else "shape")
    if moves:
        text += '    initial: {velocity: ["y", "1+x*3", "x-y"], displacement: ["0.05*y", 0, "0.03*x*y"]}\n'
    text += "cuts:\n" + "".join(cut(r, .01 * (i + .5) if moves else 0) for i in range(3))
    return text + """time: {kind: dynamic, duration: 0.03, step: 0.01}
solver: {linear: cholesky}
output: {every: 1/100, fields: [none], surface: [obj]}
"""


def load(path):
    points, polys = [], []
    for line in open(path):
        w = line.split()
        if w and w[0] == "v":
            points.append(tuple(map(float, w[1:4])))
        elif w and w[0] == "f":
            polys.append([int(c.split("/")[0]) - 1 for c in w[1:]])
    return points, polys


def odd_edges(polys):
    """Edges that have other than one polygon in each direction."""
    count = Counter((a, b) for p in polys for a, b in zip(p, p[1:] + p[:1]))
    return [(a, b) for (a, b), n in count.items() if n != 1 or count[b, a] != 1]


def volume(points, polys):
    def det(a, b, c):
        return (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]))
    return sum(det(points[p[0]], points[p[i]], points[p[i + 1]]) for p in polys for i in range(1, len(p) - 1)) / 6


n_surfaces = n_volumes = 0
odd, off = [], []
for seed in KNOWN + AT_REST + list(range(FIRST, FIRST + N_RANDOM)):
    r = random.Random(seed)
    is_other, moves = r.random() < .5, r.random() < .8
    text = scene(r, is_other, moves)
    with folder() as d:
        write(d, "scene.yaml", text)
        if is_other:
            ball(os.path.join(d, "ball.obj"), (r.uniform(-.3, .3), r.uniform(-.2, .2), r.uniform(-.1, .1)), r.uniform(.3, .5), n=9)
        got = run("run", "scene.yaml", "-q", "-o", "out", cwd=d)
        if got.returncode == 2 and "nothing is left" in got.stderr:
            continue
        expect("seed_%d_runs" % seed, got.returncode == 0, got.stderr + text)
        if got.returncode:
            continue
        names = sorted(name for name in os.listdir(os.path.join(d, "out")) if name.endswith(".obj"))
        for name in names:
            points, polys = load(os.path.join(d, "out", name))
            n_surfaces += 1
            if odd_edges(polys):
                odd.append((seed, name, odd_edges(polys)[:3]))
        if not moves and not is_other:
            want = json.load(open(os.path.join(d, "out", "result.json")))["topology"][-1]["volume"]
            n_volumes += 1
            points, polys = load(os.path.join(d, "out", names[0]))
            if not abs(volume(points, polys) - want) < 1e-7 * want:
                off.append((seed, volume(points, polys), want))
print("seeds %s and %d to %d: %d surfaces, %d volumes" % (KNOWN, FIRST, FIRST + N_RANDOM - 1, n_surfaces, n_volumes))
expect("every_edge_has_two_polygons", n_surfaces > 20 and not odd, odd)
expect("at_rest_surfaces_hold_what_the_elements_hold", n_volumes > 0 and not off, off)
# Cells of a body that falls and turns as one have planes of their own at rest, which are the same but for rounding.
with folder() as d:
    write(d, "falls.yaml", """lithe: 1
bodies:
  - name: solid
    shape: {box: {min: [0, 0, 0], max: [1, 1, 1]}}
    material: {young_modulus: 1e5, poisson_ratio: 0.3, density: 1000}
    method: {kind: dg, cells: 4, degree: 1, flux: ip}
    initial: {velocity: [0.1, 0.2, 0]}
    embed: {surface: shape}
gravity: [0, 0, -9.81]
cuts:
  - {at: 0.05, plane: {point: [0.31, 0, 0], normal: [1, 0.2, 0.1]}}
time: {kind: dynamic, duration: 0.06, step: 0.01}
output: {every: last, fields: [none], surface: [obj]}
""")
    got = run("run", "falls.yaml", "-q", "-o", "out", cwd=d)
    expect("falling_body_runs", got.returncode == 0, got.stderr)
    points, polys = load(os.path.join(d, "out", sorted(n for n in os.listdir(os.path.join(d, "out")) if n.endswith(".obj"))[-1]))

    def area(p):
        a, sums = points[p[0]], [0, 0, 0]
        for q, r in zip(p[1:], p[2:]):
            u, v = [x - y for x, y in zip(points[q], a)], [x - y for x, y in zip(points[r], a)]
            for k in range(3):
                sums[k] += u[k - 2] * v[k - 1] - u[k - 1] * v[k - 2]
        return math.hypot(*sums) / 2

    thin = [p for p in polys if area(p) < 1e-6]
    expect("planes_of_a_body_that_moves_as_one_are_one", not thin, "%d of %d polygons are a rounding wide" % (len(thin), len(polys)))
done()
