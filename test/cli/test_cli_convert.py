"""`lithe convert`: what a deck becomes, and what it says of decks that a scene cannot say."""
import json
import os

from cli import check, done, expect, folder, run

BAR = """*HEADING
A bar
*NODE, NSET=ALL
1, 0, 0, 0
2, 2, 0, 0
3, 2, 1, 0
4, 0, 1, 0
5, 0, 0, 1
6, 2, 0, 1
7, 2, 1, 1
8, 0, 1, 1
9, 4, 0, 0
10, 4, 1, 0
11, 4, 0, 1
12, 4, 1, 1
*ELEMENT, TYPE=C3D8, ELSET=LEFT
1, 1, 2, 3, 4, 5, 6, 7, 8
*ELEMENT, TYPE=C3D8, ELSET=RIGHT
2, 2, 9, 10, 3, 6, 11, 12, 7
*ELSET, ELSET=BAR
LEFT, RIGHT
*NSET, NSET=FOOT
1, 4, 5, 8
*BOUNDARY
FOOT, 1
1, 2, 3
4, 3
*MATERIAL, NAME=SOFT
*ELASTIC
1000., 0.
*DENSITY
2.
"""
ONE = "*SOLID SECTION, ELSET=BAR, MATERIAL=SOFT\n"
STEP = "*STEP\n*STATIC\n"
END = "*NODE PRINT, NSET=ALL\nU\n*END STEP\n"


def convert(deck, *options):
    """Exit status, standard output and error, the scene and the sets beside it."""
    with folder() as f:
        with open(os.path.join(f, "bar.inp"), "w") as out:
            out.write(deck)
        got = run("convert", "bar.inp", "bar.yaml", *options, cwd=f)
        texts = []
        for name in ("bar.yaml", "bar-sets.inp"):
            path = os.path.join(f, name)
            texts.append(open(path).read() if os.path.exists(path) else "")
    return got, texts[0], texts[1]


def refused(name, deck, err, *options):
    got, scene, _ = convert(deck, *options)
    expect(name, got.returncode == 2 and got.stderr == "lithe: " + err + "\n" and scene == "",
           "exit %d\n%s" % (got.returncode, got.stderr))


PULLED = BAR + ONE + STEP + "*DLOAD\nRIGHT, P4, -3.\n" + END
got, scene, sets = convert(PULLED)
expect("says_what_it_found_and_what_to_do_next", got.returncode == 0 and got.stderr == "" and got.stdout == """\
bar.inp: 2 elements, 12 nodes, 1 material, 3 supports, 1 load
  written         bar.yaml
  mesh            bar-sets.inp, with 3 more sets
  run it          lithe run bar.yaml
""", got.stdout + got.stderr)
with folder() as f:
    with open(os.path.join(f, "bar.inp"), "w") as out:
        out.write(PULLED)
    os.mkdir(os.path.join(f, "bar.yaml"))
    failed = run("convert", "bar.inp", "bar.yaml", cwd=f)
    expect("says_when_the_scene_cannot_be_written",
           failed.returncode == 4 and "bar.yaml" in failed.stderr and failed.stdout == "",
           "exit %d\n%s%s" % (failed.returncode, failed.stdout, failed.stderr))
expect("scene_reads_like_one", scene == """\
# bar.inp, end of step 1, translated by lithe convert. Numbers are the deck's own, so that
# lengths, forces and stresses are in its units: mm, N, MPa stay mm, N, MPa in the result.
lithe: 1
title: "A bar"

bodies:
  - name: part
    method:
      kind: cg  # the deck's elements and nodes; dg: the same cells, degree 1 to 4
      mesh: {file: "bar-sets.inp"}
    material: {model: linear, young_modulus: 1000, poisson_ratio: 0, density: 2}  # SOFT
    constraints:
      - {where: {label: "FOOT"}, displacement: [0, null, null]}  # 4 nodes
      - {where: {label: "HELD-1"}, displacement: [null, 0, null]}  # 1 node
      - {where: {label: "HELD-2"}, displacement: [null, null, 0]}  # 2 nodes
    loads:
      - {where: {label: "PRESSED-1"}, pressure: -3}  # 1 face

time: static
output: {fields: [vtu]}
""", scene)
expect("sets_without_a_name_stand_beside_the_deck", sets == """\
** Nodes and faces that bar.inp holds or loads, but does not name; written by lithe convert.
*INCLUDE, INPUT=bar.inp
*NSET, NSET=HELD-1
1
*NSET, NSET=HELD-2
1, 4
*SURFACE, NAME=PRESSED-1, TYPE=ELEMENT
2, S4
""", sets)

_, scene, _ = convert(BAR + ONE + STEP + "*CLOAD\nALL, 3, 1.\n7, 3, 2.\n*CLOAD\n7, 1, -1.\n" + END)
expect("nodal_forces_of_a_step_add_up", "point_force: [-1, 0, 3]}  # on 1 node\n" in scene and
       "point_force: [0, 0, 1]}  # on each of 11 nodes\n" in scene, scene)
TWO_STEPS = BAR + ONE + STEP + "*CLOAD\n7, 3, 2.\n" + END + STEP + "*CLOAD\n7, 3, 5.\n*BOUNDARY\n7, 2, 2, 0.5\n" + END
_, scene, _ = convert(TWO_STEPS)
expect("later_steps_replace_and_keep", "point_force: [0, 0, 5]}" in scene and
       "displacement: [null, 0.5, null]" in scene and "end of step 2" in scene, scene)
_, scene, _ = convert(TWO_STEPS, "--step", "1")
expect("an_earlier_step_can_be_asked_for", "point_force: [0, 0, 2]}" in scene and "0.5" not in scene, scene)
_, scene, _ = convert(BAR + "*MATERIAL, NAME=HARD\n*ELASTIC\n9000., 0.1\n*SOLID SECTION, ELSET=BAR, MATERIAL=SOFT\n"
                      "*SOLID SECTION, ELSET=RIGHT, MATERIAL=HARD\n" + STEP + END)
expect("the_last_section_comes_first", scene.index('label: "RIGHT"') < scene.index('label: "BAR"') and
       "young_modulus: 9000" in scene, scene)
_, scene, _ = convert(BAR + ONE + STEP + "*DLOAD\nBAR, GRAV, 9.81, 0, 0, -2\nBAR, CENTRIF, 4., 1, 0, 0, 1, 0, 0\n" + END)
expect("body_forces_are_translated", "gravity: [0, 0, -9.81]\n" in scene and
       '{body_force: ["0", "8*(y - 0)", "8*(z - 0)"]}' in scene, scene)
_, scene, _ = convert(BAR.replace("FOOT", "bar") + ONE + STEP + END)
expect("a_name_of_two_sets_is_not_used", 'label: "bar"' not in scene and 'label: "HELD-1"' in scene, scene)
_, scene, _ = convert(BAR + ONE + "*AMPLITUDE, NAME=HALF\n0., 0.5, 1., 0.5\n" + STEP +
                      "*CLOAD, AMPLITUDE=HALF\n7, 3, 2.\n" + END)
expect("constant_amplitudes_are_factors", "point_force: [0, 0, 1]}" in scene, scene)

with folder() as f:
    with open(os.path.join(f, "bar.inp"), "w") as out:
        out.write(PULLED)
    run("convert", "bar.inp", "bar.yaml", "--quiet", cwd=f)
    got = run("run", "bar.yaml", "--json", "--quiet", cwd=f)
    told = json.loads(got.stdout) if got.returncode == 0 else {}
    # a bar of length 4 under 3 Pa of tension, nu = 0: 4 * 3 / 1000
    expect("converted_scene_runs_and_is_right", abs(told.get("displacement", {}).get("max", 0) - 0.012) < 1e-12,
           got.stderr)

refused("plasticity_is_named", BAR + "*PLASTIC\n1., 0.\n" + ONE + STEP + END,
        "bar.inp:33: *PLASTIC: plasticity cannot be translated")
refused("unknown_cards_are_named", BAR + ONE + "*FROBNICATE\n" + STEP + END,
        "bar.inp:34: *FROBNICATE: this card cannot be translated; linear elastic static solids can")
refused("large_strains_are_named", BAR + ONE + "*STEP, NLGEOM\n*STATIC\n" + END,
        "bar.inp:34: *STEP: NLGEOM (large strains) cannot be translated, Lithe's corotated material is another one; "
        "without NLGEOM the deck can")
refused("shells_are_named", BAR.replace("C3D8, ELSET=L", "S8R, ELSET=L") + ONE + STEP + END,
        "bar.inp:16: *ELEMENT: TYPE=S8R cannot be translated; C3D4, C3D6, C3D8, C3D8R, C3D10, C3D15, C3D20 and "
        "C3D20R can")
refused("steps_of_other_kinds_are_named", BAR + ONE + STEP + END + "*STEP\n*FREQUENCY\n3\n*END STEP\n",
        "bar.inp:40: *FREQUENCY: eigenfrequencies cannot be translated (step 2; --step 1 translates what is before it)")
refused("varying_amplitudes_are_named", BAR + ONE + "*AMPLITUDE, NAME=UP\n0., 0., 1., 1.\n" + STEP +
        "*CLOAD, AMPLITUDE=UP\n7, 3, 2.\n" + END,
        "bar.inp:38: *CLOAD: AMPLITUDE=UP varies (see line 34); only constant ones can be translated")
refused("unknown_sets_are_named", BAR + ONE + STEP + "*CLOAD\nTOP, 3, 2.\n" + END,
        "bar.inp:37: there is no set of nodes 'TOP'")
refused("rotations_are_named", BAR + ONE + STEP + "*BOUNDARY\nFOOT, 4, 4\n" + END,
        "bar.inp:37: degree of freedom 4 cannot be translated; solids have 1, 2 and 3")
refused("elements_without_section_are_named",
        BAR + "*SOLID SECTION, ELSET=LEFT, MATERIAL=SOFT\n" + STEP + END,
        "bar.inp:19: element 2 (hex8) has no material, expected a *SOLID SECTION")
refused("a_deck_without_steps_is_named", BAR + ONE, "bar.inp: there is no *STEP, expected at least one")
refused("a_step_beyond_the_last_is_named", BAR + ONE + STEP + END, "bar.inp: there is no step 3, the deck has 1",
        "--step", "3")
refused("loads_on_part_of_the_body_are_named", BAR + ONE + STEP + "*DLOAD\nLEFT, GRAV, 9.81, 0, 0, -1\n" + END,
        "bar.inp:37: *DLOAD: GRAV on some elements only cannot be translated; it can on all")
refused("faces_that_are_not_there_are_named", BAR + ONE + STEP + "*DLOAD\nLEFT, P7, 1.\n" + END,
        "bar.inp:37: element 1 (hex8) has no face 7")
check("a_missing_deck_is_named", ["convert", "none.inp", "a.yaml"], status=2,
      err="lithe: none.inp: cannot be read: No such file or directory\n")
done()
