"""Slice the bunny with the program and let VTK read, close and measure the polyhedra.

usage: check_bunny_mesh.py PROGRAM SOURCE_DIR
"""
import json
import os
import subprocess
import sys

program, source = sys.argv[1:]
made = subprocess.run([program, "mesh", os.path.join(source, "scenes", "bunny-drop.yaml"), "-o", "bunny.vtu", "--json"],
                      check=True, capture_output=True, text=True)
report = json.loads(made.stdout)
assert report["max_gap"] < 1e-12, report
subprocess.run([sys.executable, os.path.join(source, "test", "golden", "check_vtu.py"), "bunny.vtu",
                str(report["volume"])], check=True)
