"""The main job, from file to motion: what must hold on the bunny whatever the machine."""
import filecmp
import json
import os

from cli import done, expect, folder, run

SCENES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scenes")
SIZE = 0.2  # longest side of the bunny [m]


def result_of(scene, out, *options):
    got = run("run", os.path.join(SCENES, scene), "-o", out, "--quiet", *options, timeout=900)
    expect(scene + " runs " + " ".join(options[-1:]), got.returncode == 0, got.stderr)
    with open(os.path.join(out, "result.json")) as file:
        return json.load(file)


with folder() as scratch:
    # any linear field is reproduced, also near incompressibility: 1e-9 of the largest displacement
    for degree in (1, 2):
        for poisson in (0.3, 0.4999):
            r = result_of("patch-test.yaml", os.path.join(scratch, "patch"),
                          "--set", "bodies.0.method.degree=%d" % degree,
                          "--set", "bodies.0.material.poisson_ratio=%g" % poisson)
            expect("linear field on the sliced bunny, degree %d, nu %g" % (degree, poisson),
                   r["error"]["linf"] <= 1e-9 * r["displacement"]["max"], r["error"])

    # 0.4 s: it falls, hits the floor and is deepest; on 1, 2 and 3 threads
    short = ("--set", "time.duration=0.4", "--threads")
    folders = [os.path.join(scratch, "threads-%d" % n) for n in (1, 2, 3)]
    for n, out in enumerate(folders, 1):
        result_of("bunny-drop.yaml", out, *short, str(n))
    for name in ("surface.pc2", "history.csv", "probes.csv", "fields_0012.vtu"):
        for out in folders[1:]:
            expect("same bits of %s on another number of threads" % name,
                   filecmp.cmp(os.path.join(folders[0], name), os.path.join(out, name), shallow=False))

    # 2 s: it lies, carries its weight and is less than 0.5 % of its size in the floor
    r = result_of("bunny-drop.yaml", os.path.join(scratch, "rest"))
    expect("penetration below 0.5 % of the size", r["contact"]["penetration"] < 0.005 * SIZE, r["contact"])
    weight = 9.81 * r["bodies"][0]["mass"]
    expect("the floor carries the weight within 5 %",
           abs(r["contact"]["force"] - weight) < 0.05 * weight, (r["contact"], weight))
    expect("the sliced volume is that of the surface", abs(r["bodies"][0]["volume"] - 1.59981460e-3) < 1e-11,
           r["bodies"][0]["volume"])
done()
