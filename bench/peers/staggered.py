#!/usr/bin/env python3
"""Lithe's staggered multigrid and five peers side by side on the same matrices, one thread each.

    bench/peers/staggered.py --bench build/release/bench/bench_staggered [--csv FILE] [--sizes 2:1266,3:128] [--lithe 2:512,...]
    bench/peers/staggered.py --matrix m.bin --only gamg          (one peer on what bench_staggered --export wrote)

Peers are PETSc's GAMG with the rigid motions, hypre's BoomerAMG with unknowns of a component told apart (plain, and with one
aggressive level), CHOLMOD and UMFPACK, all through petsc4py; UMFPACK and CHOLMOD in the plane alone, for their factors do not fit
in space. Iterative ones run conjugate gradients to a true relative residual of 1e-8. Seconds are from the assembled matrix (of
Lithe: from the discretisation) to the solution; peak memory is that of the process over what it held before the set-up.
"""
import argparse
import csv
import ctypes
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PETSC = "/usr/lib/petscdir/petsc3.18/x86_64-linux-gnu-real/lib/python3/dist-packages"
PYTHON = "/usr/bin/python3"  # the one that Debian's petsc4py belongs to
PEERS = {  # options of PETSc; whether it is for the plane alone
    "GAMG": ("-ksp_type cg -pc_type gamg", False),
    "BoomerAMG": ("-ksp_type cg -pc_type hypre -pc_hypre_type boomeramg -pc_hypre_boomeramg_strong_threshold 0.5", False),
    "BoomerAMG aggressive": ("-ksp_type cg -pc_type hypre -pc_hypre_type boomeramg -pc_hypre_boomeramg_strong_threshold 0.5 "
                             "-pc_hypre_boomeramg_agg_nl 1", False),
    "CHOLMOD": ("-ksp_type preonly -pc_type cholesky -pc_factor_mat_solver_type cholmod", True),
    "UMFPACK": ("-ksp_type preonly -pc_type lu -pc_factor_mat_solver_type umfpack", True),
}
COLUMNS = ["case", "nu", "solver", "threads", "unknowns", "grid s", "set-up s", "solve s", "total s", "us/unknown", "iterations",
           "residual", "bytes/unknown", "operator/memory bound", "dense/memory bound", "operator/moved bound",
           "fmg operators", "fmg work", "triad GB/s"]


def read(path):
    """CSR arrays, right-hand side, component and place of every unknown."""
    import numpy as np
    with open(path, "rb") as file:
        n, nnz = np.fromfile(file, np.int64, 2)
        off = np.zeros(n + 1, dtype=np.int64)
        np.cumsum(np.fromfile(file, np.int32, n), out=off[1:])
        col = np.fromfile(file, np.int32, nnz)
        val = np.fromfile(file, np.float64, nnz)
        rhs = np.fromfile(file, np.float64, n)
        return off, col, val, rhs, np.fromfile(file, np.float64, 4 * n).reshape(n, 4)


def rigid_motions(part, places):
    """Translations and rotations at the unknowns' own places, orthonormal."""
    import numpy as np
    x = places - places.mean(axis=0)
    modes = [(part == a).astype(float) for a in range(3)]
    for a, b in ((0, 1), (1, 2), (2, 0)):
        modes.append(np.where(part == a, -x[:, b], np.where(part == b, x[:, a], 0)))
    if not (part == 2).any():
        modes = [modes[0], modes[1], modes[3]]
    return np.linalg.qr(np.array(modes).T)[0].T


def blocks(path):
    """The matrix with unknowns in blocks of components, absent ones with a row of the identity; right-hand side, modes."""
    import numpy as np
    import scipy.sparse as sp
    off, col, val, rhs, places = read(path)
    func, part = np.divmod(places[:, 0].astype(np.int64), 3)
    dim = int(part.max()) + 1
    func = np.unique(func, return_inverse=True)[1]
    to = (dim * func + part).astype(np.int32)
    n = dim * (int(func.max()) + 1)
    full = np.zeros(n, dtype=np.int64)
    full[to] = np.diff(off)
    there = full > 0
    full[~there] = 1
    row = np.zeros(n + 1, dtype=np.int32)
    np.cumsum(full, out=row[1:])
    # rows keep their order, so that entries move as a whole: those of absent unknowns are let in
    cols = np.empty(row[-1], dtype=np.int32)
    vals = np.empty(row[-1])
    mine = np.repeat(there, full)
    cols[mine], vals[mine] = to[col], val
    cols[~mine], vals[~mine] = np.flatnonzero(~there), np.abs(val).max()
    matrix = sp.csr_matrix((vals, cols, row), shape=(n, n))
    matrix.sort_indices()
    b = np.zeros(n)
    b[to] = rhs
    modes = np.zeros((3 if dim == 2 else 6, n))
    modes[:, to] = rigid_motions(part, places[:, 1:])
    return matrix, b, modes, dim, rhs.size


def solve(path, name):
    """Print one row as a dictionary: a child process, so that peak memory is this solver's own."""
    sys.path.insert(0, PETSC)
    import petsc4py
    petsc4py.init(["staggered"] + PEERS[name][0].split())
    from petsc4py import PETSc
    matrix, rhs, motions, dim, unknowns = blocks(path)
    A = PETSc.Mat().createAIJ(matrix.shape, csr=(matrix.indptr, matrix.indices, matrix.data), bsize=dim)
    A.setOption(PETSc.Mat.Option.SPD, True)
    del matrix
    b = PETSc.Vec().createWithArray(rhs, bsize=dim)
    if name == "GAMG":
        vectors = [PETSc.Vec().createWithArray(m.copy(), bsize=dim) for m in motions]
        A.setNearNullSpace(PETSc.NullSpace().create(vectors=vectors))
    del motions
    ksp = PETSc.KSP().create()
    ksp.setOperators(A)
    ksp.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
    ksp.setTolerances(rtol=1e-8, max_it=2000)
    ksp.setFromOptions()
    if ksp.getType() == "preonly":
        ksp.setNormType(PETSc.KSP.NormType.NONE)
    x = b.duplicate()
    ctypes.CDLL(None).malloc_trim(0)
    with open("/proc/self/clear_refs", "w") as file:
        file.write("5")  # the peak counts from here
    before = memory("VmRSS")
    start = time.perf_counter()
    ksp.setUp()
    setup = time.perf_counter() - start
    ksp.solve(b, x)
    total = time.perf_counter() - start
    peak = memory("VmHWM") - before
    r = b - A * x
    print(json.dumps({"solver": name, "threads": 1, "unknowns": unknowns, "set-up s": f"{setup:.2f}", "solve s": f"{total - setup:.2f}",
                "total s": f"{total:.2f}", "us/unknown": f"{1e6 * total / unknowns:.2f}", "iterations": ksp.its,
                "residual": f"{r.norm() / b.norm():.1e}", "bytes/unknown": f"{peak / unknowns:.0f}"}))


def memory(what):
    """Bytes of this process that /proc tells of."""
    with open("/proc/self/status") as file:
        return 1024 * int(next(line for line in file if line.startswith(what)).split()[1])


def run_lithe(bench, dim, cells, nu, threads, export=None, form=None):
    command = [bench, "--csv", "--threads", str(threads), "--dim", str(dim), "--cells", str(cells), "--nu", str(nu)]
    command += [f"--{form}"] if form else []
    done = subprocess.run(command + (["--export", export] if export else []), check=True, capture_output=True, text=True)
    row = next(csv.DictReader(done.stdout.splitlines()))
    setup, solve_s = float(row["prepare s"]), float(row["solve s"])
    unknowns = int(row["unknowns"])
    return {"case": f"{dim}D {cells}", "nu": nu, "solver": f"Lithe, {form}" if form else "Lithe", "threads": threads, "unknowns": unknowns,
            "grid s": f"{float(row['fractions s']) + float(row['disc s']):.3f}", "set-up s": f"{setup:.3f}",
            "solve s": f"{solve_s:.3f}", "total s": f"{setup + solve_s:.3f}",
            "us/unknown": f"{1e6 * (setup + solve_s) / unknowns:.3f}", "iterations": row["iterations"],
            "residual": row["residual"], "bytes/unknown": row["bytes/unknown"],
            "operator/memory bound": row["operator/memory bound"], "dense/memory bound": row["dense/memory bound"],
            "operator/moved bound": row["operator/moved bound"], "fmg operators": row["fmg operators"], "fmg work": row["fmg work"],
            "triad GB/s": row["triad GB/s"]}


def run_peer(path, name):
    environment = dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
    done = subprocess.run([PYTHON, __file__, "--matrix", path, "--only", name], env=environment, capture_output=True, text=True)
    if done.returncode != 0:
        return {"solver": name, "threads": 1, "residual": "failed: " + done.stderr.strip().split("\n")[-1][:80]}
    return json.loads(done.stdout.strip().split("\n")[-1])


def cases(text):
    return [tuple(int(v) for v in part.split(":")) for part in text.split(",") if part]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--bench", default="build/release/bench/bench_staggered")
    parser.add_argument("--csv", default="bench/results/epyc-2-cores/staggered.csv")
    parser.add_argument("--sizes", default="2:1266,3:128", help="dim:cells that peers solve too")
    parser.add_argument("--lithe", default="2:512,2:1024,2:2048,2:4096,3:64,3:128,3:256",
                        help="dim:cells of Lithe alone, on one and two threads; at nu = 0.49 the first of each dimension")
    parser.add_argument("--matrix")
    parser.add_argument("--only", choices=sorted(PEERS))
    options = parser.parse_args()
    if options.matrix:
        solve(options.matrix, options.only)
        return
    with open(options.csv, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, restval="")
        writer.writeheader()

        def put(row):
            writer.writerow(row)
            file.flush()
            print(", ".join(f"{key} {value}" for key, value in row.items()), flush=True)

        with tempfile.TemporaryDirectory() as folder:
            for dim, cells in cases(options.sizes):
                path = str(Path(folder) / "matrix.bin")
                put(run_lithe(options.bench, dim, cells, 0.3, 1, path))
                for name, (_, plane) in PEERS.items():
                    if dim == 2 or not plane:
                        put({"case": f"{dim}D {cells}", "nu": 0.3, **run_peer(path, name)})
        nearly = set()
        for dim, cells in cases(options.lithe):
            for threads in (1, 2):
                put(run_lithe(options.bench, dim, cells, 0.3, threads))
            if dim not in nearly:
                put(run_lithe(options.bench, dim, cells, 0.49, 1))
                put(run_lithe(options.bench, dim, cells, 0.49, 1, form="displacement"))
            nearly.add(dim)


if __name__ == "__main__":
    main()
