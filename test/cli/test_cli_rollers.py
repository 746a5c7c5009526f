"""Rollers of staggered bodies on boundary that is not along an axis: planes at an angle and curved sides."""
import json
import math
import os

from cli import done, expect, folder, run

PLANE = """lithe: 1
dimension: 2
bodies:
  - name: body
    shape: SHAPE
    material: {model: linear, young_modulus: 1, poisson_ratio: 0.3}
    method: {kind: staggered, cells: 32}
    constraints:
CONSTRAINTS
    loads: [LOAD]
exact: {displacement: ["UX", "UY"]}
output: {every: last, fields: none}
time: {kind: static}
"""


def fill(text, **values):
    for name, value in values.items():
        text = text.replace(name, value)
    return text.replace("    loads: []\n", "")


def held(*sides):
    """Rollers on the sides of half spaces, by a point, a normal and what is prescribed."""
    return "\n".join("      - {where: {plane: {point: %s, normal: %s}}, displacement: {normal: %s}}" %
                     (list(point), list(normal), value) for point, normal, value in sides)


def result(directory, text, *changes):
    with open(os.path.join(directory, "r.yaml"), "w") as file:
        file.write(text)
    got = run("run", "r.yaml", "--json", "-o", "out", *[x for c in changes for x in ("--set", c)], cwd=directory)
    if got.returncode != 0:
        print(got.stderr)
        return {"failed": got.stderr}
    return json.loads(got.stdout)


def errors(directory, text, cells, *changes):
    results = [result(directory, text, "bodies.0.method.cells=%d" % n, *changes) for n in cells]
    return [r.get("error", {"l1": math.inf, "linf": math.inf}) for r in results], results[-1]


def orders(values, key):
    return [math.log2(a[key] / b[key]) for a, b in zip(values, values[1:])]


def reaction(r, i):
    return r.get("reaction", {}).get("bodies.0.constraints.%d" % i, [math.inf] * 3)


def near(a, b, tolerance):
    return all(abs(x - y) <= tolerance * max(map(abs, b)) for x, y in zip(a, b))


def square(angle):
    """Corners and axes of a unit square at an angle, beside the grid."""
    e = (math.cos(angle), math.sin(angle))
    f = (-e[1], e[0])
    o = (0.013, 0.007)
    return e, f, [[o[i] + j * e[i] + k * f[i] for i in range(2)] for j, k in ((0, 0), (1, 0), (1, 1), (0, 1))]


def pressed_square(angle, value="-0.01"):
    """On rollers all around, of which one side is pushed in: its strain is the same everywhere."""
    e, f, corners = square(angle)
    back = [(-v[0], -v[1]) for v in (e, f)]
    sides = held((corners[0], back[0], "0"), (corners[0], back[1], "0"), (corners[2], e, value), (corners[2], f, "0"))
    ux, uy = ("-0.01*%.17g*(%.17g*(x-%.17g)+%.17g*(y-%.17g))" % (e[i], e[0], corners[0][0], e[1], corners[0][1])
              for i in range(2))
    return fill(PLANE, SHAPE="{polygon: %s}" % corners, CONSTRAINTS=sides, LOAD="", UX=ux, UY=uy)


def test_patch():
    stress = [0.01 * m for m in (0.7 / 0.52, 0.3 / 0.52)]  # lambda + 2 mu and lambda, E = 1
    with folder() as d:
        for degrees in (30, 45, 71):
            e, f, _ = square(math.radians(degrees))
            found, r = errors(d, pressed_square(math.radians(degrees)), (16, 32, 64, 128))
            expect("a_linear_field_is_met_at_%d_degrees" % degrees, found[-1]["l1"] < 1e-3 * 0.01 and
                   found[-1]["linf"] < 5e-3 * 0.01 and sum(orders(found, "l1")) > 3 * 1.0, (found, orders(found, "l1")))
            for i, (normal, s) in enumerate(zip((e, f, e, f), (stress[0], stress[1], -stress[0], -stress[1]))):
                expect("its_reaction_%d_is_the_stress_at_%d_degrees" % (i, degrees),
                       near(reaction(r, i), [s * normal[0], s * normal[1], 0], 5e-3), (reaction(r, i), s, normal))
        text = pressed_square(math.radians(30), "\"-0.01*t\"").replace("{kind: static}",
                                                                      "{kind: quasistatic, steps: 4, duration: 1}")
        r = result(d, text)
        energy = r.get("energy", {"work": 0, "strain": 1})
        expect("work_of_a_roller_that_moves_is_the_energy", abs(energy["work"] - energy["strain"]) <
               1e-9 * energy["strain"] and abs(energy["strain"] - 0.5 * 0.01 * stress[0]) < 1e-2 * energy["strain"],
               energy)


def ring(angle):
    """A sector of a ring that rotates: plane strain, E = 1, nu = 0.3."""
    young, nu, a2, c, s = 1 / 0.91, 3 / 7, 0.25, math.cos(angle), math.sin(angle)
    ur = "(%.17g*((3+N)*(1-N)/8*%g + (3+N)*(1+N)/8*%g/(x^2+y^2) - (1-N^2)/8*(x^2+y^2)))" % (1 / young, 1 + a2, a2)
    ur = ur.replace("N", "%.17g" % nu)
    side = "{box: {min: [0, 0], max: [1, 1]}}" if angle > 1.5 else \
        "{polygon: [[0, 0], [2, 0], [%.17g, %.17g]]}" % (2 * c, 2 * s)
    return fill(PLANE, SHAPE="{intersection: [{annulus: {center: [0, 0], inner: 0.5, outer: 1}}, %s]}" % side,
                CONSTRAINTS=held(((0, 0), (0, -1), "0"), ((0, 0), (-s, c), "0")), LOAD="{body_force: [x, y]}",
                UX="x*" + ur, UY="y*" + ur)


def test_ring():
    """A sector between a roller along an axis and one at an angle: of first order, as a quarter is."""
    cells = (32, 64, 128, 256)
    with folder() as d:
        for degrees, fractions in ((30, "exact"), (45, "exact"), (62, "exact"), (30, "smooth")):
            name = "of_a_ring_of_%d_degrees_%s" % (degrees, fractions)
            a = math.radians(degrees)
            found, r = errors(d, ring(a), cells, "bodies.0.method.fractions=" + fractions)
            expect("errors_" + name, sum(orders(found, "l1")) > 3 * 0.9 and
                   found[-1]["linf"] < 5e-3 * r["displacement"]["max"], (found, orders(found, "l1")))
            force = 0.875 / 3  # of two forces across the sides that hold the load in balance
            expect("reaction_" + name, near(reaction(r, 1), [-force * math.sin(a), force * math.cos(a), 0], 1e-3),
                   (reaction(r, 1), force))


def test_disk():
    """A curved side that is pressed in evenly: as linear as its displacement."""
    rollers = held(((0, 0), (0, -1), "0"), ((0, 0), (-1, 0), "0")) + \
        "\n      - {where: {not: {disk: {center: [0, 0], radius: 0.9}}}, displacement: {normal: -0.01}}"
    text = fill(PLANE, SHAPE="{intersection: [{disk: {center: [0, 0], radius: 1}}, {box: {min: [0, 0], max: [1, 1]}}]}",
                CONSTRAINTS=rollers, LOAD="", UX="-0.01*x", UY="-0.01*y")
    with folder() as d:
        found, r = errors(d, text, (32, 64, 128))
        force = 0.01 / 0.52  # 2 (lambda + mu) times the strain, on a projection of 1
        expect("a_disk_is_pressed_evenly", found[-1]["linf"] < 3e-3 * 0.01 and sum(orders(found, "l1")) > 2 * 0.9,
               (found, orders(found, "l1")))
        expect("its_side_carries_the_pressure", near(reaction(r, 2), [-force, -force, 0], 5e-3), (reaction(r, 2), force))
        steps = [result(d, text, "bodies.0.method.cells=%d" % n, "solver.linear=multigrid").get("solver", {})
                 .get("iterations", 1000) for n in (32, 64, 128)]
        expect("iterations_are_bounded_under_refinement", max(steps) <= 40, steps)


BLOCK = """lithe: 1
dimension: 2
bodies:
  - name: block
    shape: {polygon: CORNERS}
    material: {model: linear, young_modulus: 1e7, poisson_ratio: 0.3, density: 1000}
    method: {kind: staggered, cells: 24}
    constraints:
      - {where: {normal: [0.5, -0.8660254037844386], within: 5 deg}, displacement: {normal: 0}}
probes: [{name: middle, point: [0.6, 0.9]}]
gravity: [0, -10]
output: {every: last, fields: none}
time: {kind: dynamic, duration: 0.5, step: 0.01, integrator: bdf2}
"""


def test_slide():
    """A block on a slope without friction: it slides as a point does, and the slope carries the weight's normal part."""
    c, s = math.cos(math.pi / 6), 0.5
    corners = [[0, 0], [2 * c, 2 * s], [2 * c - s, 2 * s + c], [-s, c]]
    with folder() as d:
        text = BLOCK.replace("CORNERS", str(corners))
        r = result(d, text)
        slid = 0.5 * 10 * s * 0.5**2
        moved = r.get("probes", {}).get("middle", {}).get("displacement", [0, 0])
        expect("a_block_slides_down_a_slope", near(moved[:2], [-slid * c, -slid * s], 1e-2), (moved, slid))
        r = result(d, text, "time.integrator=implicit-euler")
        weight = 2 * 1000 * 10 * c
        expect("the_slope_carries_the_normal_part_of_its_weight", near(reaction(r, 0), [-weight * s, weight * c, 0], 1e-6),
               (reaction(r, 0), weight))


SHELL = """lithe: 1
bodies:
  - name: sector
    shape: {intersection: [{shell: {center: [0, 0, 0], inner: 0.5, outer: 1}}, {implicit: "-y"}, {implicit: "-z"}, SIDE]}
    material: {model: linear, young_modulus: 1, poisson_ratio: 0.3}
    method: {kind: staggered, cells: 24}
    constraints:
      - {where: {plane: {point: [0, 0, 0], normal: [0, -1, 0]}}, displacement: {normal: 0}}
      - {where: {plane: {point: [0, 0, 0], normal: [0, 0, -1]}}, displacement: {normal: 0}}
      - {where: {plane: {point: [0, 0, 0], normal: NORMAL}}, displacement: {normal: 0}}
    loads: [{where: {sphere: {center: [0, 0, 0], radius: 0.75}}, pressure: 1}]
exact: {displacement: ["x*UR", "y*UR", "z*UR"]}
output: {every: last, fields: none}
time: {kind: static}
""".replace("UR", "%.17g*(0.4+0.65/(x^2+y^2+z^2)^1.5)" % (0.125 / 0.875))


def test_shell():
    """A sector of a hollow sphere of 30 degrees, a third of an octant."""
    text = SHELL.replace("SIDE", "{implicit: \"0.8660254037844386*y-0.5*x\"}").replace("NORMAL",
                                                                                      "[-0.5, 0.8660254037844386, 0]")
    octant = SHELL.replace("SIDE", "{implicit: \"-x\"}").replace("NORMAL", "[-1, 0, 0]")
    with folder() as d:
        part, _ = errors(d, text, (12, 24))
        whole, _ = errors(d, octant, (24,))
        expect("a_sector_of_a_sphere_converges", part[1]["l1"] < part[0]["l1"] / 2, part)
        expect("its_errors_add_up_to_less_than_those_of_the_octant", part[1]["l1"] < whole[0]["l1"], (part, whole))


def test_refusals():
    with folder() as d:
        text = pressed_square(0.5)
        for name, change, says in (
                ("large_deformation_is_refused", "bodies.0.material.model=neo-hookean",
                 "staggered bodies of large deformation are held along the axes"),
                ("so_is_one_half", "bodies.0.material.poisson_ratio=0.5",
                 "rollers that are not along an axis do not keep volumes")):
            told = result(d, text, change).get("failed", "")
            expect(name, says in told, told)


test_patch()
test_ring()
test_disk()
test_slide()
test_shell()
test_refusals()
done()
