"""Boundary conditions from outside: what is held in part, strongly, moving; forces that balance."""
import json
import os

from cli import done, expect, folder, run

# uniaxial and sheared: any constant stress, with its linear field; E = 1000, nu = 0.25: lambda = mu = 400
STRESS = [[6, 2, -3], [2, -4, 1], [-3, 1, 5]]
YOUNG, NU = 1000.0, 0.25


def strain(a, b):
    trace = STRESS[0][0] + STRESS[1][1] + STRESS[2][2]
    return (1 + NU) / YOUNG * STRESS[a][b] - (NU / YOUNG * trace if a == b else 0)


# grad u is chosen upper triangular: u_x of x, y, z; u_y of y, z; u_z of z, so that u_n is zero on rollers
def component(a):
    terms = ["(%r)*%s" % (strain(a, b) * (1 if a == b else 2), "xyz"[b]) for b in range(a, 3)]
    return " + ".join(terms)


FIELD = [component(a) for a in range(3)]

BLOCK = """lithe: 1
bodies:
  - name: block
    shape: {box: {min: [0, 0, 0], max: [1, 0.8, 0.6]}}
    material: {model: linear, young_modulus: %r, poisson_ratio: %r, density: 1000}
    method: {kind: dg, cells: [3, 2, 2], mesh: %s, degree: %s}
    constraints:
%s
    loads:
      - {where: all, stress: %s}
time: {kind: static}
solver: {linear: cholesky, tolerance: 1e-12}
exact:
  displacement: ["%s", "%s", "%s"]
output: {every: last, fields: [none]}
"""


def lines(*constraints):
    return "\n".join("      - " + c for c in constraints)


def write(directory, text, name="scene.yaml"):
    with open(os.path.join(directory, name), "w") as file:
        file.write(text)


def result(directory, *args):
    got = run("run", "scene.yaml", "--json", *args, cwd=directory)
    return json.loads(got.stdout) if got.returncode == 0 else got.stderr


def near(got, want, tolerance):
    return all(abs(g - w) <= tolerance for g, w in zip(got, want))


LOW = ["{normal: [-1, 0, 0]}", "{normal: [0, -1, 0]}", "{normal: [0, 0, -1]}"]
MASKS = [["\"%s\"" % FIELD[a] if a == b else "null" for b in range(3)] for a in range(3)]
# u_n on the face x = 0 is not zero: a roller there takes -u_x, along the outward normal
ROLLERS = ["{normal: \"-(%s)\"}" % FIELD[a] for a in range(3)]
held_in_part = {
    "null_components": ["{where: %s, displacement: [%s]}" % (LOW[a], ", ".join(MASKS[a])) for a in range(3)],
    "rollers": ["{where: %s, displacement: %s}" % (LOW[a], ROLLERS[a]) for a in range(3)],
    "both": ["{where: %s, displacement: %s}" % (LOW[0], ROLLERS[0]),
             "{where: %s, displacement: [%s]}" % (LOW[1], ", ".join(MASKS[1])),
             "{where: %s, displacement: %s}" % (LOW[2], ROLLERS[2])],
    # a corner held wholly, on boundary that others hold in part
    "overlaps": ["{where: %s, displacement: [%s]}" % (LOW[0], ", ".join(MASKS[0])),
                 "{where: {and: [{normal: [-1, 0, 0]}, {box: {min: [-1, -1, -1], max: [1, 0.4, 0.3]}}]}, "
                 "displacement: [%s]}" % ", ".join("\"%s\"" % f for f in FIELD),
                 "{where: {normal: [-1, 0, 0]}, displacement: [null, \"%s\", null]}" % FIELD[1]],
}
with folder() as d:
    for name, constraints in held_in_part.items():
        for mesh, degree in (("hexahedra", 1), ("tetrahedra", 2), ("slice", 3), ("slice", "\"x > 0.5 ? 1 : 3\"")):
            write(d, BLOCK % (YOUNG, NU, mesh, degree, lines(*constraints), STRESS, *FIELD))
            told = result(d)
            # 1e-9 of the displacement
            expect("a_load_on_%s_of_degree_%s_leaves_the_exact_field" % (name, degree),
                   isinstance(told, dict) and told["error"]["linf"] < 1e-11, told if isinstance(told, str) else told["error"])
            if name in ("overlaps",) or not isinstance(told, dict):
                continue
            for a in range(3):
                area = [0.48, 0.6, 0.8][a]
                # the outward normal is -e_a, so that the support pulls with -sigma_aa
                want = [-STRESS[a][a] * area if b == a else 0 for b in range(3)]
                got = told["reaction"]["bodies.0.constraints.%d" % a]
                expect("reaction_%d_of_%s_of_degree_%s_is_its_own_component" % (a, name, degree),
                       near(got, want, 1e-8), (got, want))

    # elements that are held strongly in some components, with what the field says there
    strong = [c.replace("{where", "{enforce: strong, where") for c in held_in_part["null_components"]]
    for degree in (1, 3):
        write(d, BLOCK % (YOUNG, NU, "hexahedra", degree, lines(*strong), STRESS, *FIELD))
        told = result(d)
        expect("strong_components_of_degree_%d_leave_the_exact_field" % degree,
               isinstance(told, dict) and told["error"]["linf"] < 1e-11, told if isinstance(told, str) else told["error"])
        total = [sum(told["reaction"]["bodies.0.constraints.%d" % i][a] for i in range(3)) for a in range(3)]
        expect("strong_components_of_degree_%d_balance" % degree, near(total, [0, 0, 0], 1e-8), total)

    # strong rollers hold elements along an axis
    squeeze = BLOCK.replace("    loads:\n      - {where: all, stress: %s}\n", "").replace("exact:\n  displacement: [\"%s\", \"%s\", \"%s\"]\n", "")
    rollers = ["{where: %s, displacement: {normal: 0}, enforce: strong}" % w for w in LOW] + \
              ["{where: {normal: [1, 0, 0]}, displacement: {normal: -0.01}, enforce: strong}"]
    write(d, squeeze % (YOUNG, 0.0, "hexahedra", 2, lines(*rollers)))
    told = result(d)
    # nu = 0: the middle third takes all the shortening (the outer ones move as wholes), and its stress is
    # E 0.01 / (1/3) = 30; the averages with elements that have no strain leave a sixth of it out
    expect("strong_rollers_squeeze", isinstance(told, dict) and
           24 * 0.48 < -told["reaction"]["bodies.0.constraints.3"][0] < 30 * 0.48, told)
    expect("strong_rollers_balance", isinstance(told, dict) and
           near([sum(told["reaction"]["bodies.0.constraints.%d" % i][a] for i in range(4)) for a in range(3)],
                [0, 0, 0], 1e-8), told)
    slanted = squeeze.replace("    material", "    place: {rotate: {axis: [0, 0, 1], angle: 30 deg}}\n    material")
    write(d, slanted % (YOUNG, 0.0, "slice", 1, lines("{where: {face: {at: [0, 0.2, 0.3], angle: 5 deg}}, "
                                                      "displacement: {normal: 0}, enforce: strong}")))
    told = result(d)
    expect("a_slanted_strong_roller_is_refused", isinstance(told, str) and
           "bodies.0.constraints.0.enforce: a strong roller holds elements along an axis" in told and
           "`enforce: weak`" in told, told)
    write(d, squeeze % (YOUNG, 0.0, "hexahedra", 1, lines("{where: all, displacement: {normal: 0}, interior: true}")))
    told = result(d)
    expect("a_roller_has_no_interior", isinstance(told, str) and "interior: a roller is of the boundary" in told, told)

    # directions at an angle on the same boundary
    skew = ["{where: {face: {at: [0, 0.2, 0.3], angle: 5 deg}}, displacement: {normal: 0}}",
            "{where: {face: {at: [0, 0.2, 0.3], angle: 5 deg}}, displacement: [0, null, null]}"]
    write(d, slanted % (YOUNG, 0.0, "slice", 1, lines(*skew)))
    told = result(d)
    expect("skew_holds_on_one_boundary_are_refused", isinstance(told, str) and
           "bodies.0.constraints.1.where: overlaps another constraint" in told, told)
    write(d, BLOCK.replace("exact:\n  displacement: [\"%s\", \"%s\", \"%s\"]\n", "").replace("where: all, stress: %s", "where: {normal: [-1, 0, 0]}, pressure: 5") %
          (YOUNG, NU, "hexahedra", 1, lines("{where: {normal: [-1, 0, 0]}, displacement: {normal: 0}}",
                                            "{where: {normal: [0, 0, -1]}, displacement: [0, 0, 0]}")))
    told = result(d)
    expect("a_pressure_on_rollers_alone_is_refused", isinstance(told, str) and
           "selects only boundary that a constraint holds" in told, told)

# forces that balance, scenes of all kinds: reactions + loads = inertia
MOVING = """lithe: 1
bodies:
  - name: bar
    shape: {box: {min: [0, 0, 0], max: [1, 0.2, 0.2]}}
    material: {model: %s, young_modulus: 10 kPa, poisson_ratio: 0.3, density: 1000}
    method: {kind: dg, mesh: hexahedra, cells: [5, 1, 1], degree: %d}
    constraints:
      - {where: {normal: [-1, 0, 0]}, displacement: [0, 0, 0], enforce: %s}
      - {where: {normal: [1, 0, 0]}, displacement: ["0.02*t", null, "0.1*t*t"], enforce: %s}
    loads:
      - {where: {normal: [0, 1, 0]}, traction: ["3*t", 0, "2*x"]}
      - {where: {normal: [0, 0, 1]}, total_force: [0, 0.5, 0]}
      - {where: {normal: [0, -1, 0]}, stress: [[1, "t", 0], ["t", 2, 0], [0, 0, 3]]}
gravity: [0, -1, 0]
time: %s
solver: {linear: cholesky, tolerance: 1e-12, newton: {tolerance: 1e-10, iterations: 50}}
output: {every: 0.125, fields: [none]}
"""
QUASI, DYNAMIC = "{kind: quasistatic, steps: 4, duration: 1}", "{kind: dynamic, step: 0.125, duration: %g, integrator: %s}"


def force_at(t):
    """Of all loads: traction and stress on 1 x 0.2 each, the force, the weight of 40 kg."""
    # stress on n = -e_y: -(t, 2, 0)
    return [0.2 * 3 * t - 0.2 * t, 0.5 - 0.2 * 2 - 40, 0.2 * 1]


def inertia(directory, *args):
    """Rate of the momentum over the last of eight steps, as implicit Euler sees it."""
    def momentum(duration):
        return result(directory, *args, "--set", "time.duration=%g" % duration)["momentum"]
    return [(a - b) / 0.125 for a, b in zip(momentum(1), momentum(0.875))]


with folder() as d:
    for model in ("linear", "corotated"):
        for enforce in ("weak", "strong"):
            for degree in (1, 2, 3):
                name = "%s_%s_degree_%d" % (model, enforce, degree)
                write(d, MOVING % (model, degree, enforce, enforce, QUASI))
                told = result(d)
                held = [sum(r[a] for r in told["reaction"].values()) for a in range(3)] if isinstance(told, dict) else [9] * 3
                # 40 N times the tolerance, and what rounding leaves of the stiffness times the length
                expect("quasistatic_forces_balance_" + name, near([h + f for h, f in zip(held, force_at(1))], [0] * 3, 1e-6),
                       (held, told if isinstance(told, str) else told["solver"]))
                if model == "linear":
                    gap = told["energy"]["work"] - told["energy"]["strain"]
                    expect("work_is_the_strain_energy_" + name, told["energy"]["strain"] > 0.1 and
                           abs(gap) < 1e-6 * told["energy"]["strain"], told["energy"])
                if degree == 2 and model == "corotated":
                    continue
                integrator = "implicit-euler" if model == "linear" else "newton-euler"
                write(d, MOVING % (model, degree, enforce, enforce, DYNAMIC % (1, integrator)))
                told = result(d)
                held = [sum(r[a] for r in told["reaction"].values()) for a in range(3)] if isinstance(told, dict) else [9] * 3
                want = inertia(d)
                expect("dynamic_forces_balance_" + name, max(abs(w) for w in want) > 1 and
                       near([h + f for h, f in zip(held, force_at(1))], want, 1e-6), (held, force_at(1), want))

    # a pressure that follows: the push on the end of a bar that is turned by a quarter turn turns with it
    write(d, MOVING.replace("    loads:", "    loads:\n      - {where: {normal: [1, 0, 0]}, pressure: 5, follower: true}").
          replace("displacement: [0, 0, 0], enforce: %s", "position: [\"-y\", \"x\", \"z\"], enforce: %s").
          replace("      - {where: {normal: [1, 0, 0]}, displacement: [\"0.02*t\", null, \"0.1*t*t\"], enforce: %s}\n", "").
          replace("    shape", "    initial: {displacement: [\"-y - x\", \"x - y\", 0]}\n    shape") % ("corotated", 1, "weak", QUASI))
    told = result(d, "--set", "gravity=[0, 0, 0]", "--set", "bodies.0.loads.1.traction=[0, 0, 0]",
                  "--set", "bodies.0.loads.2.total_force=[0, 0, 0]", "--set", "bodies.0.loads.3.stress=[[0,0,0],[0,0,0],[0,0,0]]")
    held = told["reaction"]["bodies.0.constraints.0"] if isinstance(told, dict) else told
    # 5 Pa on 0.04 m^2, shrunk by the pressure by 2 nu p / E at most
    expect("a_following_pressure_turns", isinstance(told, dict) and near(held, [0, 0.2, 0], 2e-3) and abs(held[0]) < 1e-4, held)

# a rim of many facets holds as a rim of few does: linear elements do not feel the facets
RIM = """lithe: 1
bodies:
  - name: disk
    shape: {cylinder: {from: [0, 0, 0], to: [0, 0, 0.5], radius: 1}, resolution: %s}
    material: {model: linear, young_modulus: 1000, poisson_ratio: 0.3, density: 1}
    method: {kind: dg, cells: 4, degree: 1}
    constraints:
      - {where: {and: [{not: {normal: [0, 0, 1], within: 5 deg}}, {not: {normal: [0, 0, -1], within: 5 deg}}]}, displacement: [0, 0, 0]}
gravity: [0, 0, -10]
time: {kind: static}
output: {every: last, fields: [none]}
"""
with folder() as d:
    energies = []
    for resolution in (0.1, 0.03):
        write(d, RIM % resolution)
        energies.append(result(d)["energy"]["strain"])
    expect("facets_of_a_held_rim_add_no_stiffness", abs(energies[0] - energies[1]) < 0.01 * energies[0], energies)

done()
