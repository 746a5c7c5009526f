#!/usr/bin/env python3
"""Solve the staggered matrix that bench_staggered exports with PETSc's GAMG and hypre's BoomerAMG (petsc4py).

    bench_staggered --dim 3 --cells 144 --export m.bin && bench/peers/staggered.py m.bin [--only gamg|hypre]

Conjugate gradients to a true relative residual of 1e-8; set-up and solve in seconds of one process. GAMG gets the rigid
motions, BoomerAMG the number of components: unknowns lie in blocks, absent ones with a row of the identity.
"""
import argparse
import sys
import time

import numpy as np

sys.path.insert(0, "/usr/lib/petscdir/petsc3.18/x86_64-linux-gnu-real/lib/python3/dist-packages")


def read(path):
    """CSR arrays, right-hand side, component and place of every unknown."""
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
    x = places - places.mean(axis=0)
    modes = [(part == a).astype(float) for a in range(3)]
    for a, b in ((0, 1), (1, 2), (2, 0)):
        modes.append(np.where(part == a, -x[:, b], np.where(part == b, x[:, a], 0)))
    if not (part == 2).any():
        modes = [modes[0], modes[1], modes[3]]
    return np.linalg.qr(np.array(modes).T)[0].T


def solve(PETSc, name, A, b, modes, unknowns):
    ksp = PETSc.KSP().create()
    ksp.setOperators(A)
    ksp.setType("cg")
    ksp.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
    ksp.setTolerances(rtol=1e-8, max_it=2000)
    if name == "gamg":
        vectors = [PETSc.Vec().createWithArray(m.copy(), bsize=A.getBlockSize()) for m in modes]
        A.setNearNullSpace(PETSc.NullSpace().create(vectors=vectors))
        ksp.getPC().setType("gamg")
    else:
        ksp.getPC().setType("hypre")
        ksp.getPC().setHYPREType("boomeramg")
    ksp.setFromOptions()
    x = b.duplicate()
    start = time.process_time()
    ksp.setUp()
    setup = time.process_time() - start
    ksp.solve(b, x)
    total = time.process_time() - start
    r = b - A * x
    print(f"{name}: {unknowns} unknowns, set-up {setup:.2f} s, total {total:.2f} s, "
          f"{ksp.its} iterations, true residual {r.norm() / b.norm():.1e}, {unknowns / total:.0f} unknowns/s")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("matrix")
    parser.add_argument("--only", choices=("gamg", "hypre"))
    options = parser.parse_args()
    import petsc4py
    petsc4py.init(["staggered", "-pc_hypre_boomeramg_strong_threshold", "0.5"])
    from petsc4py import PETSc
    off, col, val, rhs, places = read(options.matrix)
    import scipy.sparse as sp
    func, part = np.divmod(places[:, 0].astype(np.int64), 3)
    dim = int(part.max()) + 1
    func = np.unique(func, return_inverse=True)[1]
    to = dim * func + part
    n = dim * (int(func.max()) + 1)
    rows = np.repeat(to, np.diff(off))
    absent = np.setdiff1d(np.arange(n), to)
    scale = np.abs(val).max()
    matrix = sp.coo_matrix((np.concatenate([val, np.full(absent.size, scale)]),
                            (np.concatenate([rows, absent]), np.concatenate([to[col], absent]))),
                           shape=(n, n)).tocsr()
    matrix.sort_indices()
    A = PETSc.Mat().createAIJ(matrix.shape, csr=(matrix.indptr, matrix.indices, matrix.data), bsize=dim)
    A.setOption(PETSc.Mat.Option.SPD, True)
    full = np.zeros(n)
    full[to] = rhs
    b = PETSc.Vec().createWithArray(full, bsize=dim)
    modes = np.zeros((3 if dim == 2 else 6, n))
    modes[:, to] = rigid_motions(part, places[:, 1:])
    for name in ("gamg", "hypre"):
        if options.only in (None, name):
            solve(PETSc, name, A, b, modes, rhs.size)


if __name__ == "__main__":
    main()
