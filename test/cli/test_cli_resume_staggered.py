"""Staggered bodies go on after a stop with the same bits: contact, large rotations, pressures, both dimensions."""
import signal

from cli import done
from resume import check_resumes

DROP = """lithe: 1
bodies:
  - name: block
    shape: {box: {min: [0, 0.002, 0], max: [0.1, 0.102, 0.1]}}
    material: {model: linear, young_modulus: 20 kPa, poisson_ratio: 0.4, density: 1000, damping: {stiffness: 1e-3}}
    method: {kind: staggered, cells: 5}
    embed: {surface: shape}
    initial: {velocity: [0.03, -0.5, 0.01]}
gravity: [0, -9.81, 0]
colliders:
  - plane: {point: [0, 0, 0], normal: [0.1, 1, 0]}
contact: {friction: 0.3}
time: {kind: dynamic, duration: 0.08, step: 1/200}
probes: [{name: corner, point: [0.1, 0.102, 0.1]}]
output: {every: 1/100, fields: [vti, vtu], surface: [pc2], checkpoint: 0}
"""

# a plate in the plane, held at one end, that swings
PLATE = """lithe: 1
dimension: 2
bodies:
  - name: plate
    shape: {annulus: {center: [0, 0], inner: 0.2, outer: 0.5}}
    material: {model: linear, young_modulus: 1 MPa, poisson_ratio: 0.3, density: 1000, damping: {mass: 1, stiffness: 1e-4}}
    method: {kind: staggered, cells: 24}
    constraints:
      - {where: {face: {at: [0.2, 0]}}, displacement: [0, 0]}
    initial: {velocity: ["-y", "x"]}
gravity: [0, -9.81]
time: {kind: dynamic, duration: 0.2, step: 1/100}
output: {every: 1/50, fields: [vti], checkpoint: 0}
"""


def model(name):
    return "bodies.0.material.model=" + name


poisson = "bodies.0.material.poisson_ratio=0.5"
check_resumes("block that drops", DROP, [(5, signal.SIGKILL), (9, signal.SIGINT)], ["solver.linear=cholesky"])
check_resumes("block without a matrix", DROP, [(6, signal.SIGKILL)], ["bodies.0.material.young_modulus=1e5"])
check_resumes("corotated block", DROP, [(6, signal.SIGKILL)], [model("corotated"), "bodies.0.method.cells=3"])
for kind in ("bdf2", "newmark", "newton-euler"):
    check_resumes("plate by " + kind, PLATE, [(5, signal.SIGKILL)], ["time.integrator=" + kind])
check_resumes("corotated plate", PLATE, [(6, signal.SIGKILL)], [model("corotated"), "time.integrator=bdf2"])
check_resumes("plate without a matrix", PLATE, [(6, signal.SIGKILL)], ["solver.linear=multigrid"])
check_resumes("incompressible plate", PLATE, [(4, signal.SIGKILL), (9, signal.SIGTERM)], [poisson])
check_resumes("incompressible plate by newmark", PLATE, [(6, signal.SIGKILL)], [poisson, "time.integrator=newmark"])
check_resumes("incompressible block", DROP.replace("colliders:\n  - plane: {point: [0, 0, 0], normal: [0.1, 1, 0]}\n", "")
              .replace("contact: {friction: 0.3}\n", ""), [(5, signal.SIGKILL)], [poisson, "bodies.0.method.cells=4"])
done()
