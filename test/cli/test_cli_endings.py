"""Runs that do not reach their end: what was written stays valid, and the exit status says what happened."""
import json
import os
import re
import resource
import signal
import struct
import subprocess
import time

from cli import PROGRAM, done, expect, folder, run

DROP = """lithe: 1
bodies:
  - name: block
    shape: {box: {min: [0, 0.02, 0], max: [0.1, 0.12, 0.1]}}
    material: {model: corotated, young_modulus: 50 kPa, poisson_ratio: 0.4, density: 1000}
    method: {kind: dg, mesh: hexahedra, cells: 4, degree: 1}
    embed: {surface: shape}
gravity: [0, -9.81, 0]
time: {kind: dynamic, duration: 1000, step: 1/100}
output: {every: 1/100, fields: [vtu], surface: [pc2]}
"""


def write(directory, text):
    with open(os.path.join(directory, "drop.yaml"), "w") as file:
        file.write(text)


def rows(directory):
    try:
        return open(os.path.join(directory, "out", "drop", "history.csv")).read().splitlines()
    except FileNotFoundError:
        return []


def check_files(directory, what):
    """Every file that an end of any kind leaves behind is whole."""
    out = os.path.join(directory, "out", "drop")
    table = rows(directory)
    expect(what + ": history ends with a whole row", len({row.count(",") for row in table}) == 1, table[-1:])
    listed = re.findall(r'file="([^"]+)"', open(os.path.join(out, "fields.pvd")).read())
    on_disk = sorted(name for name in os.listdir(out) if name.endswith(".vtu"))
    expect(what + ": every listed file is there and complete", all(
        open(os.path.join(out, name), "rb").read().endswith(b"</VTKFile>\n") for name in listed), listed[-1:])
    expect(what + ": no file is unlisted by more than one", 0 <= len(on_disk) - len(listed) <= 1,
           (len(on_disk), len(listed)))
    data = open(os.path.join(out, "surface.pc2"), "rb").read()
    _, _, points, _, _, samples = struct.unpack_from("<12siiffi", data)
    expect(what + ": the cache holds whole frames", len(data) == 32 + 12 * points * samples, (len(data), samples))
    expect(what + ": no temporary file remains", not [x for x in os.listdir(out) if "tmp" in x or "temp" in x or
                                                     x.endswith("~")], os.listdir(out)[:5])


with folder() as d:
    write(d, DROP)
    process = subprocess.Popen([PROGRAM, "run", "drop.yaml"], cwd=d, stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 60
    while len(rows(d)) < 5 and time.monotonic() < deadline:
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    expect("interrupt_gives_status_130", process.returncode == 130, (process.returncode, err))
    expect("interrupt_is_told", err == "lithe: interrupted\n" and out.startswith("drop: interrupted after "), (out, err))
    result = json.load(open(os.path.join(d, "out", "drop", "result.json")))
    expect("result_says_interrupted", result["status"] == "interrupted" and 0 < result["simulated"] < 1000)
    check_files(d, "interrupted")

with folder() as d:
    write(d, DROP)
    got = run("run", "drop.yaml", "--quiet", "--set", "time.duration=0.05", cwd=d)
    expect("a_short_run_is_whole", got.returncode == 0, got.stderr)

    # a limit on the size of files stands for a full disk: the cache is the first to reach it
    limit = os.path.getsize(os.path.join(d, "out", "drop", "surface.pc2")) + 1000
    process = subprocess.run([PROGRAM, "run", "drop.yaml", "--quiet"], cwd=d, capture_output=True, text=True,
                             timeout=120,
                             preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
    expect("a_full_disk_gives_status_4", process.returncode == 4, (process.returncode, process.stderr))
    expect("a_full_disk_is_told_with_the_file", re.fullmatch(
        r"lithe: out/drop/\S+: cannot be written: File too large\n", process.stderr), process.stderr)
    expect("no_result_stands_beside_torn_files", not os.path.exists(os.path.join(d, "out", "drop", "result.json")))
    check_files(d, "full disk")
done()
