"""Runs that are killed and go on: what the tests of --resume have in common."""
import json
import os
import signal
import subprocess
import time

from cli import PROGRAM, expect, folder, run

os.environ["OMP_WAIT_POLICY"] = "passive"  # other tests want their cores

# a soft block that falls on an oblique floor; what remains to be said follows
FALLING = """lithe: 1
bodies:
  - name: block
    shape: {box: {min: [0, 0.002, 0], max: [%s, 0.102, 0.1]}}
    material: {model: corotated, young_modulus: 20 kPa, poisson_ratio: 0.4, density: 1000, damping: {stiffness: 1e-3}}
    method: {kind: dg, mesh: hexahedra, cells: %s, degree: 1%s}
    embed: {surface: shape}
    initial: {velocity: [0.3, -0.5, 0.1]}
gravity: [0, -9.81, 0]
colliders:
  - plane: {point: [0, 0, 0], normal: [0.1, 1, 0]}
contact: {friction: 0.3}
"""
# a bar that is bent by its ends; cuts, time and output follow
BENDING = """lithe: 1
bodies:
  - name: bar
    shape: {box: {min: [0, 0, 0], max: [4, 1, 1]}}
    material: {model: corotated, young_modulus: 1000, poisson_ratio: 0.3, density: 1}
    method: {kind: dg, mesh: hexahedra, cells: [6, 2, 2], degree: 1}
    constraints:
      - {where: {box: {min: [-1, -1, -1], max: [0.01, 2, 2]}}, displacement: [0, 0, 0]}
      - {where: {box: {min: [3.99, -1, -1], max: [5, 2, 2]}}, displacement: [0, "-t*t", 0], enforce: strong}
"""


def write(directory, name, text):
    with open(os.path.join(directory, name), "w") as file:
        file.write(text)


def rows(out):
    try:
        return len(open(os.path.join(out, "history.csv")).read().splitlines())
    except FileNotFoundError:
        return 0


def kill_after(directory, args, out, n_rows, number):
    """Start a run and end it by a signal once its history has so many rows."""
    process = subprocess.Popen([PROGRAM, "run", *args, "-q"], cwd=directory, stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 60
    checkpoint = os.path.join(out, "checkpoint")
    while (rows(out) < n_rows or not os.path.exists(checkpoint)) and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.001)
    process.send_signal(number)
    _, err = process.communicate(timeout=60)
    return process.returncode, err


def contents(out):
    """Every file's bytes; of result.json what is not time or memory. The checkpoint has times inside."""
    files = {}
    for name in sorted(os.listdir(out)):
        if name == "checkpoint":
            continue
        data = open(os.path.join(out, name), "rb").read()
        if name == "result.json":
            result = json.loads(data)
            for key in ("time", "memory", "threads"):
                del result[key]
            for note in result.get("topology", []):
                note.pop("processor_seconds", None)
            data = json.dumps(result).encode()
        files[name] = data
    return files


def differences(a, b):
    a, b = contents(a), contents(b)
    return [name for name in sorted(set(a) | set(b)) if a.get(name) != b.get(name)]


def check_resumes(what, scene, places, sets=()):
    """Kill at several places, go on, compare every file with those of an uninterrupted run."""
    options = [x for s in sets for x in ("--set", s)]
    with folder() as d:
        write(d, "scene.yaml", scene)
        reference = os.path.join(d, "reference")
        got = run("run", "scene.yaml", "-q", "-o", "reference", "--threads", "1", *options, cwd=d)
        expect(what + ": the uninterrupted run ends well", got.returncode == 0, got.stderr)
        again = os.path.join(d, "plain")
        got = run("run", "scene.yaml", "-q", "-o", "plain", "--set", "output.checkpoint=1e9", *options, cwd=d)
        expect(what + ": checkpoints change nothing", not differences(reference, again), differences(reference, again))
        for n_rows, number in places:
            out = os.path.join(d, "out-%d-%d" % (n_rows, number))
            name = os.path.basename(out)
            first = ["scene.yaml", "-o", name, "--threads", "2", *options]
            status, err = kill_after(d, first, out, n_rows, number)
            if number == signal.SIGKILL:
                expect("%s: killed at row %d" % (what, n_rows), status in (-signal.SIGKILL, 0), (status, err))
            else:
                expect("%s: interrupted at row %d" % (what, n_rows), status in (130, 0) and
                       (status == 0 or err == "lithe: interrupted; `lithe run --resume %s` goes on from here\n" % name),
                       (status, err))
            # once more: what has been resumed can be resumed
            kill_after(d, ["--resume", name, "--threads", "1"], out, n_rows + 2, signal.SIGKILL)
            # from elsewhere, by another path
            got = run("run", "--resume", out, "-q", cwd="/")
            expect("%s: goes on after row %d" % (what, n_rows), got.returncode == 0, got.stderr)
            expect("%s: the same bits after row %d" % (what, n_rows), not differences(reference, out),
                   differences(reference, out))
