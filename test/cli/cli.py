"""Runs the program and compares what it says, word for word."""
import os
import subprocess
import sys
import tempfile

PROGRAM = os.path.abspath(sys.argv[1])
failures = []


def run(*args, cwd=None, env=None, timeout=120):
    return subprocess.run([PROGRAM, *args], cwd=cwd, env=env, timeout=timeout, capture_output=True, text=True)


def expect(name, condition, told=""):
    """Note a claim and whether it holds."""
    print("%s %s" % ("ok  " if condition else "FAIL", name))
    if not condition:
        failures.append(name)
        print("     " + str(told).replace("\n", "\n     "))


def check(name, args, out="", err="", status=0, cwd=None):
    """Exact texts; None: not looked at."""
    got = run(*args, cwd=cwd)
    told = "exit %d\n--- stdout\n%s--- stderr\n%s" % (got.returncode, got.stdout, got.stderr)
    expect(name, got.returncode == status and (out is None or got.stdout == out) and
           (err is None or got.stderr == err), told)
    return got


def folder():
    """A scratch folder that is removed at the end."""
    return tempfile.TemporaryDirectory(prefix="lithe-cli-")


def done():
    sys.exit(1 if failures else 0)
