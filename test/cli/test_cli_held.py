"""What held sides of bodies do from outside: they carry what the body weighs, and hold where they say."""
import json
import math
import os

from cli import done, expect, folder, run

DISK = """lithe: 1
dimension: 2
bodies:
  - name: disk
    shape: {disk: {center: [0.013, -0.017], radius: 1}}
    material: {model: linear, young_modulus: 1 kPa, poisson_ratio: 0.3, density: 2}
    method: {kind: staggered, cells: 16}
    constraints: [{where: all, displacement: [0, 0]}]
gravity: [0, -10]
time: {kind: static}
solver: {tolerance: 1e-11}
probes:
  - {name: middle, point: [0.013, -0.017]}
  - {name: rim, point: [0.613, 0.683]}
output: {every: last, fields: [none]}
"""
# A pillar off the grid's lines, its foot in a socket that ends between unknowns.
PILLAR = """lithe: 1
bodies:
  - name: pillar
    shape: {cylinder: {from: [0, -1, 0], to: [0.3, 3, 0.1], radius: 1}}
    material: {model: linear, young_modulus: 1 MPa, poisson_ratio: 0.3, density: 1000}
    method: {kind: staggered, cells: 14}
    constraints:
      - {where: {plane: {point: [0, 0.1, 0], normal: [0, -1, 0]}}, interior: true, displacement: [0, 0, 0]}
gravity: [1, -10, 2]
time: {kind: static}
solver: {tolerance: 1e-11}
output: {every: last, fields: [none]}
"""
# The same beam twice: its end in a socket that the elements' faces meet, and without what is in there.
BEAM = """lithe: 1
bodies:
  - name: beam
    shape: {box: {min: [%g, 0, 0], max: [2, 0.5, 0.5]}}
    material: {model: linear, young_modulus: 1 MPa, poisson_ratio: 0.3, density: 1000}
    method: {kind: dg, cell_size: 0.25, degree: %d}
    constraints:
      - {where: {box: {min: [-1, -1, -1], max: [0.5, 1, 1]}}, displacement: [0, 0, 0], interior: %s}
gravity: [0, -10, 0]
time: {kind: static}
probes: [{name: tip, point: [2, 0.25, 0.25]}]
output: {every: last, fields: [none]}
"""


def result(where, text, *sets):
    with open(os.path.join(where, "scene.yaml"), "w") as stream:
        stream.write(text)
    options = [word for change in sets for word in ("--set", change)]
    got = run("run", "scene.yaml", "--json", "--quiet", "-o", "out", *options, cwd=where)
    return json.loads(got.stdout) if got.returncode == 0 else {"failed": got.stderr}


def near(a, b, tolerance):
    return abs(a - b) <= tolerance * abs(b)


def reaction(r):
    rows = list(r["reaction"].values())
    return [sum(row[a] for row in rows) for a in range(3)]


def test_curved_boundary():
    """A disk that is fixed all around: the displacement is zero on the circle and not at unknowns beyond it."""
    # of 256 and 512 cells, which differ by 5e-4; for 1 kg/m^3 and 9.81 m/s^2
    energy, middle, rim = 4 * 0.02183, 2 * 0.0028336, 2 * 0.0004247
    with folder() as d:
        runs = {n: result(d, DISK, "bodies.0.method.cells=%d" % n) for n in (16, 32, 64)}
        for n, share in ((16, 0.01), (32, 3e-3), (64, 1e-3)): # 14, 9 and 4 % where unknowns beyond it are at rest
            r, g = runs[n], 10 / 9.81
            got = [r["energy"]["strain"] / g**2, math.hypot(*r["probes"]["middle"]["displacement"]) / g,
                   math.hypot(*r["probes"]["rim"]["displacement"]) / g]
            told = [got[0] / energy - 1, got[1] / middle - 1, got[2] / rim - 1]
            expect("within_%g_percent_at_%d_cells" % (100 * share, n),
                   abs(told[0]) < share and abs(told[1]) < share and abs(told[2]) < 3 * share, told)
        weight = 2 * 10 * math.pi
        expect("what_holds_it_carries_its_weight",
               all(near(reaction(r)[1], weight, 1e-9) for r in runs.values()), [reaction(r) for r in runs.values()])
        r = result(d, DISK, 'bodies.0.loads=[{body_force: ["x*x", "1+y"]}]')
        m2 = math.pi * (0.25 + 0.013**2)  # integral of x^2; unknowns are midpoints of boxes
        expect("so_it_does_with_other_forces", near(reaction(r)[0], -m2, 0.02) and
               near(reaction(r)[1], weight - math.pi * (1 - 0.017), 1e-3), (reaction(r), m2))
        r = result(d, DISK, "bodies.0.constraints.0={where: {plane: {point: [0, 0.02], normal: [0, 1]}}, "
                   "displacement: [null, 0]}", "bodies.0.constraints.1={where: {plane: {point: [0.1, 0], "
                   "normal: [-1, 0]}}, displacement: [0, null]}")
        expect("so_do_sides_that_hold_one_component", "failed" not in r and near(reaction(r)[1], weight, 1e-9), r)


def test_socket():
    with folder() as d:
        for change in ("bodies.0.material.poisson_ratio=0.3", "bodies.0.material.poisson_ratio=0.48",
                       "bodies.0.constraints.0.displacement=[\"0.01*x\", 0, 0]"):
            r = result(d, PILLAR, change)
            weight = 1000 * r["bodies"][0]["volume"]
            expect("a_pillar_weighs_what_it_is: " + change,
                   all(near(a, -b * weight, 1e-8) for a, b in zip(reaction(r), (1, -10, 2))), (reaction(r), weight))


def test_elements():
    with folder() as d:
        for degree, share in ((1, 0.01), (2, 0.002)):
            deep, cut = [result(d, BEAM % (low, degree, word)) for low, word in ((0, "true"), (0.5, "false"))]
            tips = [r["probes"]["tip"]["displacement"][1] for r in (deep, cut)]
            expect("elements_in_a_socket_are_a_wall_to_others_of_degree_%d" % degree, near(*tips, share), tips)
            expect("which_weighs_all_%d" % degree, near(reaction(deep)[1], 1e4 * 0.5, 1e-9), reaction(deep))


PROBED = """lithe: 1
bodies:
  - name: box
    shape: {box: {min: [0, 0, 0], max: [1, 1, 1]}}
    material: {model: linear, young_modulus: 1 MPa, poisson_ratio: 0.3, density: 1000}
    method: {kind: %s, cells: 4}
    constraints: [{where: {plane: {point: [0, 0, 0], normal: [0, -1, 0]}}, displacement: [0, 0, 0]}]
gravity: [0, -10, 0]
time: {kind: static}
probes: [{name: far, point: [3, 0.6, 0.6]}, {name: near, point: [1.01, 0.6, 0.6]}, {name: last, point: [0.875, 0.625, 0.625]}]
output: {every: last, fields: [none]}
"""


def test_probes():
    """Beside the body: both methods say so, and read the nearest element and nothing that is carried far away."""
    with folder() as d:
        for kind in ("dg", "staggered"):
            r = result(d, PROBED % kind)
            told = [w for w in r["warnings"] if "probe" in w]
            expect("probes_beside_a_%s_body_are_told" % kind, len(told) == 2 and
                   "probe far: (3, 0.6, 0.6) lies outside the body at rest, 2.13 m from the centre of the nearest element, "
                   "(0.875, 0.625, 0.625); its values are those there; choose a point inside" in told[0] and
                   "carried on; choose a point inside" in told[1], told)
            p = r["probes"]
            expect("far_ones_of_%s_read_the_nearest_element" % kind,
                   p["far"]["displacement"] == p["last"]["displacement"], p)


def test_floating():
    """What nothing holds is told with the free motions and their place."""
    with folder() as d:
        bar = PROBED % "staggered"
        hold = "bodies.0.constraints="
        for name, change, says in (
                ("one_translation", hold + "[{where: {normal: [-1, 0, 0]}, displacement: [0, 0, null]}]",
                 "against translation along z;"),
                ("a_turn_about_an_axis",
                 hold + "[{where: {box: {min: [0.4, 0.6, -1], max: [0.6, 0.7, 2]}}, interior: true, displacement: "
                 "[0, null, null]}, {where: {box: {min: [0.6, 0.4, -1], max: [0.7, 0.6, 2]}}, interior: true, "
                 "displacement: [null, 0, null]}, {where: {normal: [0, 0, -1]}, displacement: {normal: 0}}]",
                 "against rotation about z through (0.625, 0.625,"),
                ("all_but_a_plane", hold + "[{where: {normal: [0, -1, 0]}, displacement: {normal: 0}}]",
                 "against translation along x, translation along z, rotation about y through (")):
            r = result(d, bar, change)
            expect("a_body_free_to_make_%s_is_told" % name, says in r.get("failed", ""), r.get("failed", r.get("probes")))


def test_next_to_nothing():
    """A solve whose displacements leave no digits of the forces does not count as one."""
    text = """lithe: 1
bodies:
  - name: block
    shape: {box: {min: [0, 0, 0], max: [1, 1, 1]}}
    material: {model: linear, young_modulus: "y < 0.25 ? %s : 1e9", poisson_ratio: 0.3, density: 1000}
    method: {kind: staggered, cells: 12}
    constraints:
      - {where: {normal: [0, -1, 0]}, displacement: [0, 0, 0]}
gravity: [0, -9.81, 0]
time: {kind: static}
output: {every: last, fields: [none]}
"""
    with folder() as d:
        lost = result(d, text % "1e-6").get("failed", "")
        expect("a_block_on_next_to_nothing_is_told", "nothing holds that part, or next to nothing" in lost, lost)
        soft = result(d, text % "1e5")
        expect("a_block_on_a_soft_layer_is_at_rest", soft.get("status") == "done", soft)


BLOCK = """lithe: 1
bodies:
  - name: block
    shape: {%s}
    material: %s
    method: {kind: staggered, cells: 8}
    constraints: [{where: {%s}, displacement: [0, 0, 0]}]
gravity: [0, -10, 0]
time: {kind: static}
solver: {tolerance: 1e-11}
output: {every: last, fields: [none]}
"""
BAR = "box: {min: [0, 0, 0], max: [0.4, 0.1, 0.1]}"
BALL = "sphere: {center: [0, 0, 0], radius: 0.1}"
LEFT = "plane: {point: [0, 0, 0], normal: [-1, 0, 0]}"
BELOW = "plane: {point: [0, 0, -0.08], normal: [0, 0, -1]}"
ONE = "{model: linear, young_modulus: %s, poisson_ratio: 0.3, density: %s}"


def test_material_ends_where_the_body_does():
    """Held sides and cut cells reach beyond the body; a material is not asked there."""
    rest = "model: linear, young_modulus: 1 MPa, poisson_ratio: 0.3, density: 1000}"
    parts = {"bar": (BAR, LEFT, 4, "box: {min: [0, 0, 0], max: [0.2, 0.1, 0.1]}", "box: {min: [0.2, 0, 0], max: [0.4, 0.1, 0.1]}"),
             "ball": (BALL, BELOW, 4e-3 / 3 * math.pi * 1000, "sphere: {center: [0, 0, 0], radius: 0.05}",
                      "shell: {center: [0, 0, 0], inner: 0.05, outer: 0.1}")}
    with folder() as d:
        for name, (shape, where, mass, first, second) in parts.items():
            r = result(d, BLOCK % (shape, "[{where: {%s}, %s, {where: {%s}, %s]" % (first, rest, second, rest), where))
            same = result(d, BLOCK % (shape, ONE % ("1 MPa", 1000), where))
            expect("a_list_that_covers_a_%s_and_no_more_is_enough" % name, "failed" not in r and
                   near(r["bodies"][0]["mass"], mass, 1e-9) and
                   near(r["displacement"]["max"], same["displacement"]["max"], 1e-7), (r, same))
        for name, shape, where, young in (("bar", BAR, LEFT, "'1e6*sqrt(x)+1e5'"),
                                          ("ball", BALL, BELOW, "'1e6*sqrt(0.011-x^2-y^2-z^2)+1e5'")):
            r = result(d, BLOCK % (shape, ONE % (young, 1000), where))
            expect("an_expression_need_not_be_defined_beyond_a_%s" % name, "failed" not in r and
                   near(reaction(r)[1], 10 * r["bodies"][0]["mass"], 1e-7), r)
        r = result(d, BLOCK % (BAR, ONE % ("'1e6*sqrt(x-0.2)+1e5'", 1000), LEFT))
        expect("but_inside_it_has_to_be", "not a number at" in r.get("failed", ""), r)


def test_mass_is_what_hangs():
    """The mass that is told is the one that gravity pulls at, also where the density varies within cells."""
    with folder() as d:
        r = result(d, BLOCK % (BAR, ONE % ("1 MPa", "'1000*(1+20*x^2)'"), LEFT))
        expect("a_bar_of_varying_density_weighs_its_mass", near(reaction(r)[1], 10 * r["bodies"][0]["mass"], 1e-9), r)
        r = result(d, BLOCK % (BALL, ONE % ("1 MPa", "'1000*(1+2000*x^2)'"), BELOW))
        # full parts of held sides weigh what the shape does in them as a whole
        expect("so_does_a_ball", near(reaction(r)[1], 10 * r["bodies"][0]["mass"], 2e-4) and
               near(r["bodies"][0]["mass"], 5e3 * 4e-3 / 3 * math.pi, 5e-3), r)


def test_out_of_reach():
    """A constraint that ends before the body begins does not hold it through the cells in between."""
    with folder() as d:
        for end in (-0.001, -0.02, -0.03, -0.04, -0.06):
            where = "box: {min: [-1, -1, -1], max: [%g, 1, 1]}" % end
            r = result(d, BLOCK % (BAR, ONE % ("1 MPa", 1000), where))
            told = r.get("failed", "")
            expect("a_constraint_that_ends_at_%g_does_not_reach" % end, "selects no unknown" in told or
                   "nothing holds the body against translation along x" in told, r)
        r = result(d, (BLOCK % (BAR, ONE % ("1 MPa", 1000), LEFT)).replace("cells: 8", "cell_size: 1"))
        expect("cells_that_leave_nothing_of_the_body_are_told", "its cells show nothing of the body" in r.get("failed", ""), r)


test_curved_boundary()
test_material_ends_where_the_body_does()
test_mass_is_what_hangs()
test_out_of_reach()
test_socket()
test_elements()
test_probes()
test_floating()
test_next_to_nothing()
done()
