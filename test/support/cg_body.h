/// Small conforming bodies for tests: meshes of every element kind, matrix, dense linear algebra on it.
#pragma once

#include "check.h"

#include "base/tensor.h"
#include "disc/cg/cg_priv.h"
#include "la/engine.h"
#include "material/material.h"
#include "material/rotation.h"
#include "mesh/selection.h"

#include <lapacke.h>
#undef I

typedef struct CgBody {
  LitheCtx *ctx;
  LthElementMesh *elements;
  LthMesh *mesh;
  LthDisc *disc;
  LthBlockMatrix *K;
  double *x0, *x, *f0, *f, *r; ///< rest, position, loads, residual (n_dofs)
  double *young, *poisson, *density;
  LthPatches *patches[4];
  LthWeakConstraint weak[4];
  LthCgDef def;
} CgBody;

/// How the cube of a lattice cell is divided: corners among its eight and, as 8, its centre.
typedef struct CgSplit {
  int n_elements, n_corners;
  int8_t corner[6][8];
} CgSplit;

static inline CgSplit cg_split(LthElementKind kind) {
  static const CgSplit tets = {
      6, 4, {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6}, {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}}};
  static const CgSplit hexes = {1, 8, {{0, 1, 2, 3, 4, 5, 6, 7}}};
  static const CgSplit wedges = {2, 6, {{0, 1, 2, 4, 5, 6}, {0, 2, 3, 4, 6, 7}}};
  static const CgSplit pyramids = {6,
                                   5,
                                   {{0, 1, 2, 3, 8},
                                    {4, 7, 6, 5, 8},
                                    {0, 4, 5, 1, 8},
                                    {1, 5, 6, 2, 8},
                                    {2, 6, 7, 3, 8},
                                    {3, 7, 4, 0, 8}}};
  int n = lth_element_shape(kind)->n_corners;
  return n == 4 ? tets : n == 8 ? hexes : n == 6 ? wedges : pyramids;
}

/// A mesh of the unit cube with n^3 lattice cells while it grows.
typedef struct CgMaker {
  LitheCtx *ctx;
  LthElementMesh *m;
  double h;
} CgMaker;

/// The node at a place, a new one where there is none.
static inline LitheIndex cg_node_at(CgMaker *maker, const double x[3]) {
  LthElementMesh *m = maker->m;
  for (LitheIndex i = 0; i < m->n_nodes; i++)
    if (lth_v3_distance(x, m->nodes + 3 * i) < 1e-9 * maker->h) return i;
  lth_v3_copy(x, m->nodes + 3 * m->n_nodes);
  return m->n_nodes++;
}

/// Lattice point, moved by up to `distort` cells; points on the boundary stay in its planes.
static inline void cg_lattice_point(int n, const int at[3], double distort, double x[3]) {
  uint64_t seed = (uint64_t)(1 + at[0] + 37 * at[1] + 1009 * at[2]) * 7919;
  for (int a = 0; a < 3; a++) {
    double move = test_random(&seed) + test_random(&seed) - 1;
    bool is_rim = at[a] == 0 || at[a] == n;
    x[a] = (at[a] + (is_rim ? 0 : distort * move)) / n;
  }
}

static inline void cg_add_element(CgMaker *maker, LthElementKind kind, double corner[8][3]) {
  LthElementMesh *m = maker->m;
  LthCgKind reference, low;
  lth_cg_kind_init(kind, &reference);
  static const LthElementKind linear[9] = {
      [4] = LTH_TET4, [8] = LTH_HEX8, [6] = LTH_WEDGE6, [5] = LTH_PYRAMID5};
  lth_cg_kind_init(linear[reference.shape->n_corners], &low);
  LitheIndex first = m->element_off[m->n_elements];
  for (int i = 0; i < reference.n; i++) {
    double phi[LTH_CG_MAX], dphi[3 * LTH_CG_MAX], x[3] = {0};
    lth_cg_shape(&low, reference.node[i], phi, dphi);
    for (int c = 0; c < low.n; c++) lth_v3_axpy(phi[c], corner[c], x);
    m->element_node[first + i] = cg_node_at(maker, i < low.n ? corner[i] : x);
  }
  m->kind[m->n_elements] = (uint8_t)kind;
  m->element_off[++m->n_elements] = first + reference.n;
}

/// The unit cube of n^3 cells of a kind, inner points moved by up to `distort` cells; sides are straight.
static inline LthElementMesh *cg_cube(LitheCtx *ctx, LthElementKind kind, int n, double distort) {
  CgSplit split = cg_split(kind);
  LitheCount cap = (LitheCount)n * n * n * split.n_elements;
  CgMaker maker = {.ctx = ctx, .m = lth_alloc(ctx, 1, sizeof *maker.m), .h = 1.0 / n};
  LthElementMesh *m = maker.m;
  m->nodes = lth_alloc(ctx, 3 * cap * LTH_CG_MAX, sizeof *m->nodes);
  m->kind = lth_alloc(ctx, cap, sizeof *m->kind);
  m->element_off = lth_alloc(ctx, cap + 1, sizeof *m->element_off);
  m->element_node = lth_alloc(ctx, cap * LTH_CG_MAX, sizeof *m->element_node);
  static const int8_t place[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                     {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  for (int cell = 0; cell < n * n * n; cell++) {
    double cube[9][3] = {{0}};
    for (int c = 0; c < 8; c++) {
      int at[3] = {cell % n + place[c][0], cell / n % n + place[c][1], cell / n / n + place[c][2]};
      cg_lattice_point(n, at, distort, cube[c]);
      lth_v3_axpy(0.125, cube[c], cube[8]);
    }
    for (int e = 0; e < split.n_elements; e++) {
      double corner[8][3];
      for (int c = 0; c < split.n_corners; c++) lth_v3_copy(cube[split.corner[e][c]], corner[c]);
      cg_add_element(&maker, kind, corner);
    }
  }
  return m;
}

/// A body on elements, which it takes over: E = 1000, nu = 0.3, density 1, not warped.
static inline CgBody cg_body_of(LitheCtx *ctx, LthElementMesh *elements) {
  CgBody b = {.ctx = ctx, .elements = elements};
  CHECK_OK(ctx, lth_mesh_from_elements(ctx, elements, "test", &b.mesh));
  LitheCount n = 3 * (LitheCount)elements->n_nodes;
  double **vectors[] = {&b.x0, &b.x, &b.f0, &b.f, &b.r};
  for (int i = 0; i < 5; i++) *vectors[i] = lth_alloc(ctx, n, sizeof(double));
  double **constants[] = {&b.young, &b.poisson, &b.density};
  for (int i = 0; i < 3; i++) {
    *constants[i] = lth_alloc(ctx, b.mesh->n_cells, sizeof(double));
    for (LitheIndex c = 0; c < b.mesh->n_cells; c++)
      (*constants[i])[c] = i == 0 ? 1000 : i == 1 ? 0.3 : 1;
  }
  memcpy(b.x0, elements->nodes, sizeof *b.x0 * (size_t)n);
  memcpy(b.x, b.x0, sizeof *b.x * (size_t)n);
  b.def = (LthCgDef){.elements = elements,
                     .mesh = b.mesh,
                     .young = b.young,
                     .poisson = b.poisson,
                     .density = b.density};
  return b;
}

static inline CgBody cg_body(LthElementKind kind, int n, double distort) {
  LitheCtx *ctx = test_ctx();
  return cg_body_of(ctx, cg_cube(ctx, kind, n, distort));
}

/// Select boundary by the half space that `normal` points into, from `point`.
static inline LthPatches *cg_select(CgBody *b, int slot, const double point[3],
                                    const double normal[3]) {
  LthWhere where = {.kind = point ? LTH_WHERE_PLANE : LTH_WHERE_ALL};
  for (int a = 0; point && a < 3; a++) where.point[a] = point[a], where.normal[a] = normal[a];
  CHECK_OK(b->ctx, lth_select_boundary(b->ctx, b->mesh, &where, &b->patches[slot]));
  assert_true(b->patches[slot]->n > 0);
  return b->patches[slot];
}

static inline void cg_build(CgBody *b) {
  b->def.weak = b->weak;
  CHECK_OK(b->ctx, lth_cg_disc_create(b->ctx, &b->def, &b->disc));
  CHECK_OK(b->ctx, b->disc->table->matrix_create(b->ctx, b->disc, &b->K));
}

/// r = K x - f0 with the rotations as they stand, or with those of x where `turn`.
static inline void cg_force(CgBody *b, const double *x, bool turn, double *r) {
  if (turn) b->disc->table->update_rotations(b->disc, x);
  b->disc->table->assemble(b->disc, 0, b->K, b->f0);
  lth_block_matrix_apply(b->K, lth_threads(b->ctx), x, r);
  for (LitheCount i = 0; i < b->disc->n_dofs; i++) r[i] -= b->f0[i];
}

static inline double cg_max(LitheCount n, const double *v) {
  double max = 0;
  for (LitheCount i = 0; i < n; i++) max = fmax(max, fabs(v[i]));
  return max;
}

/// Forces are judged against the largest entry of K times the largest coordinate.
static inline double cg_scale(const CgBody *b) {
  return cg_max(b->K->value_off[b->K->block_off[b->K->n_rows]], b->K->values) *
         cg_max(b->disc->n_dofs, b->x);
}

static inline double *cg_dense(const CgBody *b) {
  const LthBlockMatrix *K = b->K;
  double *A = lth_alloc(b->ctx, K->n * K->n, sizeof *A);
  for (LitheIndex row = 0; row < K->n_rows; row++)
    for (LitheCount e = K->block_off[row]; e < K->block_off[row + 1]; e++)
      for (int k = 0; k < 9; k++)
        A[(3 * row + k / 3) * K->n + 3 * K->block_col[e] + k % 3] = K->values[K->value_off[e] + k];
  return A;
}

/// Eigenvalues of K in ascending order (n_dofs), freed by the caller.
static inline double *cg_eigenvalues(const CgBody *b) {
  double *A = cg_dense(b), *w = lth_alloc(b->ctx, b->K->n, sizeof *w);
  int n = (int)b->K->n;
  assert_int_equal(LAPACKE_dsyev(LAPACK_ROW_MAJOR, 'N', 'L', n, A, n, w), 0);
  lth_free(b->ctx, A);
  return w;
}

/// Solve K x = f + f0 with the unknowns that `held` marks left at x as it is; K is spoilt.
static inline void cg_solve(CgBody *b, const uint8_t *held) {
  const LthEngine *engine = lth_engine_find("cholesky");
  LthBlockMatrix *K = b->K;
  LthFactor *factor = NULL;
  lth_block_matrix_apply(K, 1, b->x, b->r);
  for (LitheCount i = 0; i < K->n; i++)
    b->r[i] = held && held[i] ? 0 : b->f[i] + b->f0[i] - b->r[i];
  for (LitheIndex row = 0; held && row < K->n_rows; row++)
    for (LitheCount e = K->block_off[row]; e < K->block_off[row + 1]; e++)
      for (int k = 0; k < 9; k++) {
        LitheCount i = 3 * row + k / 3, j = 3 * K->block_col[e] + k % 3;
        if (held[i] || held[j]) K->values[K->value_off[e] + k] = i == j;
      }
  CHECK_OK(b->ctx, engine->analyse(b->ctx, K, &factor));
  CHECK_OK(b->ctx, engine->factorize(b->ctx, factor, K));
  CHECK_OK(b->ctx, engine->solve(b->ctx, factor, b->r, b->r));
  engine->destroy(b->ctx, &factor);
  for (LitheCount i = 0; i < K->n; i++) b->x[i] += b->r[i];
}

/// x = A X + shift at all nodes.
static inline void cg_affine(const CgBody *b, const double A[9], const double shift[3], double *x) {
  for (LitheIndex i = 0; i < b->disc->n_funcs; i++) {
    lth_m3_apply(A, b->x0 + 3 * i, x + 3 * i);
    lth_v3_add(x + 3 * i, shift, x + 3 * i);
  }
}

static inline void cg_free(CgBody *b) {
  LitheCtx *ctx = b->ctx;
  lth_block_matrix_destroy(ctx, &b->K);
  lth_disc_destroy(ctx, &b->disc);
  lth_mesh_destroy(ctx, &b->mesh);
  lth_element_mesh_destroy(ctx, &b->elements);
  for (int i = 0; i < 4; i++)
    if (b->patches[i]) lth_patches_destroy(ctx, &b->patches[i]);
  double *blocks[] = {b->x0, b->x, b->f0, b->f, b->r, b->young, b->poisson, b->density};
  for (int i = 0; i < 8; i++) lth_free(ctx, blocks[i]);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}
