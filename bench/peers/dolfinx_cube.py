"""The cube problem in dolfinx with PETSc's solvers; run by run.py, one case a process, a line of JSON out.

The case is the first argument, JSON: cell (hexahedron, tetrahedron), element (DPC, DQ, DG, CG), degree, n (cells
an axis), eta (penalty factor of interior faces), clamp (the same of clamped faces), scale (edge: over the cell's
edge; local: area over volume of each neighbour, as Lithe does), solver.
"""
import json
import resource
import sys
import time

import numpy as np
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from petsc4py import PETSc

YOUNG, POISSON, WEIGHT, TOLERANCE = 1e5, 0.3, 9.81, 1e-8
LAMBDA = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
MU = YOUNG / (2 * (1 + POISSON))


def sigma(u):
    return 2 * MU * ufl.sym(ufl.grad(u)) + LAMBDA * ufl.div(u) * ufl.Identity(3)


def penalties(case, domain):
    """Coefficients of the jump on interior and on clamped faces."""
    modulus = LAMBDA + 2 * MU
    if case["scale"] == "edge":
        return [fem.Constant(domain, case[key] * modulus / case["edge"]) for key in ("eta", "clamp")]
    volume, area = ufl.CellVolume(domain), ufl.FacetArea(domain)
    inner = case["eta"] * modulus * ufl.avg(area) * (1 / volume("+") + 1 / volume("-"))
    return [inner, case["clamp"] * modulus * area / volume]


def clamped_measure(domain, degree):
    facets = mesh.locate_entities_boundary(domain, 2, lambda x: np.isclose(x[2], 0))
    tags = mesh.meshtags(domain, 2, np.sort(facets), np.full(len(facets), 1, dtype=np.int32))
    return ufl.Measure("ds", domain=domain, subdomain_data=tags)(1, metadata={"quadrature_degree": 2 * degree})


def forms(case, domain, V):
    u, v, n = ufl.TrialFunction(V), ufl.TestFunction(V), ufl.FacetNormal(domain)
    # the rule that is exact for these elements; what dolfinx estimates is dearer
    dx, dS = (measure(metadata={"quadrature_degree": 2 * case["degree"]}) for measure in (ufl.dx, ufl.dS))
    a = ufl.inner(sigma(u), ufl.sym(ufl.grad(v))) * dx
    if case["element"] != "CG":
        inner, clamp = penalties(case, domain)
        ds = clamped_measure(domain, case["degree"])
        a += (inner * ufl.inner(ufl.jump(u), ufl.jump(v))
              - ufl.inner(ufl.dot(ufl.avg(sigma(u)), n("+")), ufl.jump(v))
              - ufl.inner(ufl.dot(ufl.avg(sigma(v)), n("+")), ufl.jump(u))) * dS
        a += (clamp * ufl.inner(u, v) - ufl.inner(ufl.dot(sigma(u), n), v)
              - ufl.inner(ufl.dot(sigma(v), n), u)) * ds
    load = ufl.inner(fem.Constant(domain, PETSc.ScalarType((0, 0, -WEIGHT))), v) * dx
    flags = {"cffi_extra_compile_args": ["-O3", "-march=native"]}
    return fem.form(a, jit_params=flags), fem.form(load, jit_params=flags)


def conditions(case, domain, V):
    if case["element"] != "CG":
        return []
    dofs = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[2], 0))
    return [fem.dirichletbc(np.zeros(3, dtype=PETSc.ScalarType), dofs, V)]


def rigid_modes(V):
    """The six rigid motions as PETSc wants them, orthonormal."""
    fields = [lambda x: np.array([np.ones_like(x[0]), 0 * x[0], 0 * x[0]]),
              lambda x: np.array([0 * x[0], np.ones_like(x[0]), 0 * x[0]]),
              lambda x: np.array([0 * x[0], 0 * x[0], np.ones_like(x[0])]),
              lambda x: np.array([x[1], -x[0], 0 * x[0]]),
              lambda x: np.array([0 * x[0], x[2], -x[1]]),
              lambda x: np.array([-x[2], 0 * x[0], x[0]])]
    columns = []
    for field in fields:
        f = fem.Function(V)
        f.interpolate(field)
        columns.append(f.vector.array.copy())
    q, _ = np.linalg.qr(np.array(columns).T)
    return vectors_of(q)


def vectors_of(columns):
    return [PETSc.Vec().createWithArray(np.ascontiguousarray(column)) for column in columns.T]


def to_monomials(case, V):
    """P for P^T A P in monomials about each cell's centre, its blocks, and the functions of each cell."""
    def scaled(x, n):
        """Coordinates from the centre of the cell that a point belongs to, over its edge; points come by cell."""
        x = x.reshape(3, -1, x.shape[1] // n) / case["edge"]
        return (x - np.floor(x.mean(axis=2, keepdims=True)) - 0.5).reshape(3, -1)

    cells = V.mesh.topology.index_map(3).size_local
    lists = V.dofmap.list.array.reshape(cells, -1)
    n = lists.shape[1]
    powers = [(i, j, d - i - j) for d in range(case["degree"] + 1) for i in range(d + 1) for j in range(d - i + 1)]
    blocks = np.zeros((cells, n, n))
    for column, (i, j, k) in enumerate(powers):
        f = fem.Function(V)

        def monomial(x):
            y = scaled(x, cells)
            value = y[0] ** i * y[1] ** j * y[2] ** k
            return np.array([value, 0 * value, 0 * value])

        f.interpolate(monomial)
        blocks[:, :, column] = f.vector.array.reshape(-1, 3)[lists, 0]
    P = PETSc.Mat().createAIJ([3 * n * cells, 3 * n * cells], bsize=3, nnz=n)
    for cell, dofs in enumerate(lists):
        columns = np.arange(n * cell, n * cell + n)
        for a in range(3):
            P.setValues((3 * dofs + a).astype(np.int32), (3 * columns + a).astype(np.int32), blocks[cell])
    P.assemble()
    return P, blocks, lists


def in_monomials(blocks, lists, mode):
    """Coefficients of a field in the monomials."""
    values = mode.array.reshape(-1, 3)[lists]
    return np.linalg.solve(blocks, values).reshape(-1)


def solver_of(case, A, modes, block):
    """PETSc's solver, not yet set up, and the matrix it works on."""
    ksp = PETSc.KSP().create()
    name = case["solver"]
    if name == "pbjacobi":  # one block a cell
        A.setOption(PETSc.Mat.Option.NEW_NONZERO_ALLOCATION_ERR, False)
        ptr, index, value = A.getValuesCSR()
        B = PETSc.Mat().createAIJ(A.size, bsize=block, csr=(ptr, index, value))
        A = B.convert("baij")
    if name in ("gamg", "gamg-monomials", "hypre"):
        A.setNearNullSpace(PETSc.NullSpace().create(vectors=modes))
    A.setOption(PETSc.Mat.Option.SPD, True)
    ksp.setOperators(A)
    pc = ksp.getPC()
    if name in ("mumps", "cholmod"):
        ksp.setType("preonly")
        pc.setType("cholesky")
        pc.setFactorSolverType(name)
    else:
        ksp.setType("cg")
        ksp.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
        ksp.setTolerances(rtol=TOLERANCE, max_it=20000)
        pc.setType(name.partition("-")[0])
        if name == "hypre":
            pc.setHYPREType("boomeramg")
            options = PETSc.Options()
            options["pc_hypre_boomeramg_strong_threshold"] = 0.5
            options["pc_hypre_boomeramg_coarsen_type"] = "HMIS"
            options["pc_hypre_boomeramg_interp_type"] = "ext+i"
            options["pc_hypre_boomeramg_P_max"] = 4
            options["pc_hypre_boomeramg_relax_type_all"] = "symmetric-SOR/Jacobi"
        ksp.setFromOptions()
    return ksp, A


def main():
    case = json.loads(sys.argv[1])
    kind = mesh.CellType.hexahedron if case["cell"] == "hexahedron" else mesh.CellType.tetrahedron
    domain = mesh.create_box(MPI.COMM_SELF, [np.zeros(3), np.ones(3)], case["n"], kind)
    V = fem.VectorFunctionSpace(domain, (case["element"], case["degree"]))
    a, load = forms(case, domain, V)
    bcs = conditions(case, domain, V)
    domain.topology.create_connectivity(2, 3)

    start = time.process_time()
    A = fem.petsc.create_matrix(a)
    fem.petsc.assemble_matrix(A, a, bcs=bcs)
    A.assemble()
    assemble = time.process_time() - start
    b = fem.petsc.assemble_vector(load)
    fem.petsc.set_bc(b, bcs)

    dofs, block = A.size[0], 3 * V.dofmap.dof_layout.num_dofs
    modes = rigid_modes(V)
    if case["solver"] == "gamg-monomials":
        P, blocks, lists = to_monomials(case, V)
        ptr, index, value = A.ptap(P).getValuesCSR()
        A = PETSc.Mat().createAIJ(A.size, bsize=block, csr=(ptr, index, value))
        columns = np.array([in_monomials(blocks, lists, mode) for mode in modes]).T
        modes = vectors_of(np.linalg.qr(columns)[0])
        load = b.duplicate()
        P.multTranspose(b, load)
        b = load
    ksp, A = solver_of(case, A, modes, block)
    x = b.duplicate()
    start = time.process_time()
    ksp.setUp()
    ksp.getPC().setUp()
    set_up = time.process_time() - start
    start = time.process_time()
    ksp.solve(b, x)
    solve = time.process_time() - start
    if ksp.getConvergedReason() < 0:
        sys.exit(f"did not converge, reason {ksp.getConvergedReason()} after {ksp.getIterationNumber()} iterations")
    print(json.dumps({
        "dofs": dofs, "assemble": assemble, "set_up": set_up, "solve": solve,
        "iterations": 0 if case["solver"] in ("mumps", "cholmod") else ksp.getIterationNumber(),
        "compliance": b.dot(x), "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024}))


main()
