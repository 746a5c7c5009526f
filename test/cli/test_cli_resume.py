"""A run that was killed or interrupted goes on with the same bits as one that was not."""
import os
import re
import shutil
import signal

from cli import done, expect, folder, run
from resume import BENDING, FALLING, check_resumes, contents, kill_after, write

DROP = FALLING % ("0.1", "3", "") + """time: {kind: dynamic, duration: 0.3, step: 1/200}
probes: [{name: corner, point: [0.1, 0.102, 0.1]}]
output: {every: 1/50, fields: [vtu], surface: [pc2, obj], checkpoint: 0}
"""
BEND = BENDING + """time: {kind: quasistatic, steps: 8, duration: 1}
probes: [{name: tip, point: [4, 0.5, 0.5]}]
output: {fields: [vtu], checkpoint: 0}
"""


PILE = """lithe: 1
bodies:
  - name: lower
    shape: {box: {min: [-0.1, 0.0005, -0.1], max: [0.1, 0.1, 0.1]}}
    material: {model: corotated, young_modulus: 1e5, poisson_ratio: 0.3, density: 1000}
    method: {kind: dg, mesh: hexahedra, cells: [2, 1, 2], degree: 1}
  - name: left
    shape: {box: {min: [-0.08, 0.101, -0.07], max: [0, 0.2, 0.08]}}
    material: {model: corotated, young_modulus: 1e5, poisson_ratio: 0.3, density: 1000, damping: {mass: 0.5}}
    method: {kind: dg, mesh: hexahedra, cells: [1, 1, 1], degree: 2}
  - name: right
    shape: {box: {min: [0, 0.101, -0.07], max: [0.08, 0.2, 0.08]}}
    material: {model: corotated, young_modulus: 1e5, poisson_ratio: 0.3, density: 1000}
    method: {kind: dg, mesh: hexahedra, cells: [1, 1, 1], degree: 1}
    initial: {velocity: [0.3, -0.3, 0]}
tie: [{bodies: [left, right]}]
gravity: [0, -9.81, 0]
colliders:
  - plane: {point: [0, 0, 0], normal: [0, 1, 0]}
contact: {friction: 0.3}
time: {kind: dynamic, duration: 0.12, step: 1/100}
output: {every: 1/100, fields: [vtu], checkpoint: 0}
"""


check_resumes("drop", DROP, [(2, signal.SIGKILL), (6, signal.SIGINT), (11, signal.SIGTERM), (13, signal.SIGKILL)])
check_resumes("bend", BEND, [(3, signal.SIGKILL), (6, signal.SIGINT)])
for kind in ("newton-euler", "bdf2", "newmark"):
    check_resumes("drop by " + kind, DROP.replace("duration: 0.3", "duration: 0.16"), [(7, signal.SIGKILL)],
                  ["time.integrator=" + kind])
check_resumes("pile", PILE, [(6, signal.SIGKILL)])
check_resumes("drop by pcg", DROP, [(6, signal.SIGKILL)], ["solver.linear=pcg"])
levels = ["solver.linear=multigrid", "bodies.0.method.cells=5"]  # more than the coarsest level alone
check_resumes("drop by multigrid", DROP.replace("duration: 0.3", "duration: 0.14"), [(7, signal.SIGKILL)], levels)
check_resumes("bend by multigrid", BEND, [(3, signal.SIGKILL)], ["solver.linear=multigrid", "bodies.0.method.cells=[8, 3, 3]"])


# --- what cannot be resumed is told, and nothing is lost ---

def refused(name, args, err, cwd):
    before = contents(os.path.join(cwd, "out"))
    got = run("run", *args, cwd=cwd)
    expect(name, got.returncode == 2 and re.fullmatch(err, got.stderr), (got.returncode, got.stderr))
    expect(name + "_and_touches_nothing", contents(os.path.join(cwd, "out")) == before)


with folder() as d:
    write(d, "scene.yaml", DROP)
    kill_after(d, ["scene.yaml", "-o", "out"], os.path.join(d, "out"), 5, signal.SIGKILL)
    path = os.path.join(d, "out", "checkpoint")
    good = open(path, "rb").read()
    resume = ["--resume", "out"]
    write(d, "scene.yaml", DROP.replace("0.3, -0.5", "0.4, -0.5"))
    refused("a_changed_scene_is_refused", resume, r"lithe: out/checkpoint: the scene scene\.yaml, a file that it names "
            r"or an override differs from what .*; put it back, or run the scene anew\n", d)
    os.remove(os.path.join(d, "scene.yaml"))
    refused("a_missing_scene_is_named", resume, r"lithe: /.*/scene\.yaml: cannot be read: No such file or directory\n", d)
    write(d, "scene.yaml", DROP)
    for what, data in (("cut", good[:-1]), ("flipped", good[:500] + bytes([good[500] ^ 1]) + good[501:])):
        open(path, "wb").write(data)
        refused("a_%s_checkpoint_is_refused" % what, resume, r"lithe: out/checkpoint: the checkpoint is damaged: .*\n", d)
    open(path, "wb").write(b"something else entirely, long enough to have a head")
    refused("a_foreign_file_is_refused", resume, r"lithe: out/checkpoint: this is not a checkpoint of lithe\n", d)
    open(path, "wb").write(good)
    shutil.move(os.path.join(d, "out", "surface.pc2"), os.path.join(d, "kept"))
    got = run("run", *resume, cwd=d)
    expect("a_missing_cache_is_named", got.returncode == 2 and "out/surface.pc2: the file is gone" in got.stderr, got.stderr)
    shutil.move(os.path.join(d, "kept"), os.path.join(d, "out", "surface.pc2"))
    got = run("run", *resume, "-q", cwd=d)
    expect("and_put_back_it_goes_on", got.returncode == 0, got.stderr)
    os.remove(path)
    refused("no_checkpoint_is_named", resume, r"lithe: out: there is no checkpoint in this folder to go on from; .*\n", d)
    refused("no_folder_is_named", ["--resume", "nowhere"], r"lithe: nowhere: there is no checkpoint .*\n", d)
    for option in (["scene.yaml"], ["-o", "other"], ["--set", "time.duration=1"]):
        refused("resume_alone_is_enough_%s" % option[0].strip("-"), resume + option,
                r"lithe: run: --resume DIR finds the scene, its values and its folder itself; leave '.*' out\n", d)

with folder() as d:  # a mesh file is part of the scene
    write(d, "box.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    write(d, "scene.yaml", DROP.replace("{box: {min: [0, 0.002, 0], max: [0.1, 0.102, 0.1]}}",
                                        "{mesh: {file: box.obj, fit: 0.1}}").replace("mesh: hexahedra, ", "")
          .replace("point: [0.1, 0.102, 0.1]", "point: [0, 0.01, 0]"))
    kill_after(d, ["scene.yaml", "-o", "out"], os.path.join(d, "out"), 4, signal.SIGKILL)
    text = open(os.path.join(d, "box.obj")).read()
    write(d, "box.obj", text.replace("v 1 0 0", "v 1.0001 0 0"))
    refused("a_changed_mesh_is_refused", ["--resume", "out"], r"lithe: out/checkpoint: the scene .* differs .*\n", d)
    write(d, "box.obj", text)
    got = run("run", "--resume", "out", "-q", cwd=d)
    expect("the_mesh_put_back_it_goes_on", got.returncode == 0, got.stderr)
done()
