/// A small DG body for tests: mesh, space, operator, matrix, and dense linear algebra on it.
#pragma once

#include "check.h"

#include "base/tensor.h"
#include "disc/dg/dg_load.h"
#include "disc/dg/dg_operator.h"
#include "la/engine.h"

#include <lapacke.h>
#undef I
#include <string.h>

typedef struct TestBody {
  LitheCtx *ctx;
  LthMesh *mesh;
  LthDgSpace *space;
  LthDgOperator *op;
  LthBlockMatrix *K;
  double *x0, *x, *f0, *f, *r; ///< rest, position, loads, residual (n_dofs)
  double *young, *poisson;     ///< (n_cells)
  LthPatches *patches[4];      ///< of weak constraints and loads, freed with the body
  LthWeakConstraint weak[4];
  LthDgOperatorDef def;
} TestBody;

typedef bool (*TestWhere)(const double centroid[3], const double normal[3]);

/// Whole boundary faces that `where` takes by centroid and normal.
static inline LthPatches *test_patches(LitheCtx *ctx, const LthMesh *mesh, TestWhere where) {
  LthPatches *p = lth_alloc(ctx, 1, sizeof *p);
  LitheIndex n_loops = 0, n_corners = mesh->loop_off[mesh->face_loop_off[mesh->n_faces]];
  p->face = lth_alloc(ctx, mesh->n_faces, sizeof *p->face);
  p->loop_off_of = lth_alloc(ctx, mesh->n_faces + 1, sizeof *p->loop_off_of);
  p->loop_off = lth_alloc(ctx, mesh->face_loop_off[mesh->n_faces] + 1, sizeof *p->loop_off);
  p->loop_point = lth_alloc(ctx, n_corners, sizeof *p->loop_point);
  p->points = lth_alloc(ctx, 3 * (LitheCount)n_corners, sizeof *p->points);
  p->area = lth_alloc(ctx, mesh->n_faces, sizeof *p->area);
  p->centroid = lth_alloc(ctx, 3 * (LitheCount)mesh->n_faces, sizeof *p->centroid);
  for (LitheIndex f = 0; f < mesh->n_faces; f++) {
    const double *c = mesh->face_centroid + 3 * f;
    if (mesh->face_cell[2 * f + 1] >= 0 || !where(c, mesh->face_normal + 3 * f)) continue;
    p->face[p->n] = f;
    p->area[p->n] = mesh->face_area[f];
    lth_v3_copy(c, p->centroid + 3 * p->n);
    for (LitheIndex l = mesh->face_loop_off[f]; l < mesh->face_loop_off[f + 1]; l++) {
      for (LitheIndex k = mesh->loop_off[l]; k < mesh->loop_off[l + 1]; k++) {
        lth_v3_copy(mesh->points + 3 * mesh->loop_point[k], p->points + 3 * p->n_points);
        p->loop_point[p->n_points] = p->n_points;
        p->n_points++;
      }
      p->loop_off[++n_loops] = p->n_points;
    }
    p->loop_off_of[++p->n] = n_loops;
  }
  return p;
}

static inline void test_free_patches(LitheCtx *ctx, LthPatches *p) {
  if (!p) return;
  void *blocks[] = {p->face,   p->loop_off_of, p->loop_off, p->loop_point,
                    p->points, p->area,        p->centroid, p};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
}

static inline bool test_everywhere(const double c[3], const double n[3]) {
  (void)c, (void)n;
  return true;
}
static inline bool test_facing_down_x(const double c[3], const double n[3]) {
  (void)c;
  return n[0] < -0.999999;
}
static inline bool test_facing_up_x(const double c[3], const double n[3]) {
  (void)c;
  return n[0] > 0.999999;
}
static inline bool test_facing_down_z(const double c[3], const double n[3]) {
  (void)c;
  return n[2] < -0.999999;
}

typedef enum TestMesh { TEST_HEXAHEDRA, TEST_TETRAHEDRA } TestMesh;

/// Degree MIXED: element c has degree 1 + 7 c mod 4, so that neighbours differ; MIXED + 1: at least 2.
enum { MIXED = 5 };
static inline LthDgSpace *test_space(LitheCtx *ctx, const LthMesh *mesh, int degree) {
  LthDgSpace *space = NULL;
  uint8_t *mixed = lth_alloc(ctx, mesh->n_cells, sizeof *mixed);
  int lowest = degree < MIXED ? degree : degree - MIXED + 1;
  for (LitheIndex c = 0; c < mesh->n_cells; c++)
    mixed[c] = (uint8_t)(degree < MIXED ? degree : lowest + 7 * c % (5 - lowest));
  CHECK_OK(ctx, lth_dg_space_create(ctx, mesh, lowest, degree < MIXED ? NULL : mixed, &space));
  lth_free(ctx, mixed);
  return space;
}

/// A body on a mesh, which it takes over: E = 1000, nu = 0.3, IP, penalty auto, not warped.
static inline TestBody test_body_of(LitheCtx *ctx, LthMesh *mesh, int degree) {
  TestBody b = {.ctx = ctx, .mesh = mesh, .space = test_space(ctx, mesh, degree)};
  LitheCount n = b.space->n_dofs;
  double **vectors[] = {&b.x0, &b.x, &b.f0, &b.f, &b.r};
  for (int i = 0; i < 5; i++) *vectors[i] = lth_alloc(b.ctx, n, sizeof(double));
  b.young = lth_alloc(b.ctx, b.space->n_cells, sizeof *b.young);
  b.poisson = lth_alloc(b.ctx, b.space->n_cells, sizeof *b.poisson);
  for (LitheIndex c = 0; c < b.space->n_cells; c++) b.young[c] = 1000, b.poisson[c] = 0.3;
  lth_dg_rest(b.space, b.x0);
  memcpy(b.x, b.x0, sizeof *b.x * (size_t)n);
  b.def = (LthDgOperatorDef){.space = b.space, .young = b.young, .poisson = b.poisson, .eta = 10};
  return b;
}

static inline TestBody test_body(TestMesh kind, LthGrid grid, int degree) {
  LitheCtx *ctx = test_ctx();
  LthMesh *mesh = NULL;
  if (kind == TEST_HEXAHEDRA) CHECK_OK(ctx, lth_mesh_hexahedra(ctx, &grid, &mesh));
  if (kind == TEST_TETRAHEDRA) CHECK_OK(ctx, lth_mesh_tetrahedra(ctx, &grid, &mesh));
  return test_body_of(ctx, mesh, degree);
}

/// Hold all components where `where` says; returns the constraint for more to be set.
static inline LthWeakConstraint *test_hold(TestBody *b, TestWhere where) {
  LitheIndex i = b->def.n_weak++;
  b->patches[i] = test_patches(b->ctx, b->mesh, where);
  b->weak[i] = (LthWeakConstraint){.patches = b->patches[i], .fixed = {true, true, true}};
  return &b->weak[i];
}

/// Build the operator from b->def, and K and f0 at time t.
static inline void test_assemble(TestBody *b, double t) {
  if (!b->op) {
    b->def.weak = b->weak;
    CHECK_OK(b->ctx, lth_dg_operator_create(b->ctx, &b->def, &b->op));
    CHECK_OK(b->ctx, lth_dg_matrix_create(b->ctx, b->op, &b->K));
  }
  lth_dg_assemble(b->op, t, b->K, b->f0);
}

/// Free all but the context.
static inline void test_body_end(TestBody *b) {
  LitheCtx *ctx = b->ctx;
  lth_block_matrix_destroy(ctx, &b->K);
  lth_dg_operator_destroy(ctx, &b->op);
  lth_dg_space_destroy(ctx, &b->space);
  lth_mesh_destroy(ctx, &b->mesh);
  for (int i = 0; i < 4; i++) test_free_patches(ctx, b->patches[i]);
  double *blocks[] = {b->x0, b->x, b->f0, b->f, b->r, b->young, b->poisson};
  for (int i = 0; i < 7; i++) lth_free(ctx, blocks[i]);
}

static inline void test_body_free(TestBody *b) {
  test_body_end(b);
  assert_int_equal(lth_alloc_bytes(b->ctx), 0);
  lithe_ctx_destroy(&b->ctx);
}

/// r = K x - f0, the internal force.
static inline void test_force(const TestBody *b, const double *x, double *r) {
  lth_block_matrix_apply(b->K, lth_threads(b->ctx), x, r);
  for (LitheCount i = 0; i < b->K->n; i++) r[i] -= b->f0[i];
}

static inline double test_norm(LitheCount n, const double *v) {
  double sum = 0;
  for (LitheCount i = 0; i < n; i++) sum += v[i] * v[i];
  return sqrt(sum);
}

static inline double test_max(LitheCount n, const double *v) {
  double max = 0;
  for (LitheCount i = 0; i < n; i++) max = fmax(max, fabs(v[i]));
  return max;
}

/// Largest |K| and |x|: forces are judged against their product.
static inline double test_force_scale(const TestBody *b, const double *x) {
  return test_max(b->K->value_off[b->K->block_off[b->K->n_rows]], b->K->values) *
         test_max(b->K->n, x);
}

/// K as a dense matrix (n x n).
static inline double *test_dense(const TestBody *b) {
  const LthBlockMatrix *K = b->K;
  double *A = lth_alloc(b->ctx, K->n * K->n, sizeof *A);
  for (LitheIndex r = 0; r < K->n_rows; r++)
    for (LitheCount e = K->block_off[r]; e < K->block_off[r + 1]; e++) {
      LitheIndex c = K->block_col[e];
      LitheCount rows = K->row_off[r + 1] - K->row_off[r], cols = K->row_off[c + 1] - K->row_off[c];
      for (LitheCount i = 0; i < rows; i++)
        for (LitheCount j = 0; j < cols; j++)
          A[(K->row_off[r] + i) * K->n + K->row_off[c] + j] =
              K->values[K->value_off[e] + i * cols + j];
    }
  return A;
}

/// x = K^-1 (f + f0) by dense Cholesky.
static inline void test_solve(TestBody *b) {
  double *A = test_dense(b);
  for (LitheCount i = 0; i < b->K->n; i++) b->x[i] = b->f[i] + b->f0[i];
  int n = (int)b->K->n;
  assert_int_equal(LAPACKE_dposv(LAPACK_ROW_MAJOR, 'L', n, 1, A, n, b->x, 1), 0);
  lth_free(b->ctx, A);
}

#define TEST_REFINEMENTS 3

/// x = K^-1 (f + f0) by sparse Cholesky, refined: with stiffnesses that differ by 1e6 and nu = 0.499 rounding of the
/// factor is as large as the error of quartic elements.
static inline void test_solve_sparse(TestBody *b, const LthBlockMatrix *K, const double *f0) {
  const LthEngine *engine = lth_engine_find("cholesky");
  assert_non_null(engine);
  LthFactor *factor = NULL;
  CHECK_OK(b->ctx, engine->analyse(b->ctx, K, &factor));
  CHECK_OK(b->ctx, engine->factorize(b->ctx, factor, K));
  double *r = lth_alloc(b->ctx, K->n, sizeof *r), *dx = lth_alloc(b->ctx, K->n, sizeof *dx);
  for (LitheCount i = 0; i < K->n; i++) b->r[i] = b->f[i] + f0[i];
  CHECK_OK(b->ctx, engine->solve(b->ctx, factor, b->r, b->x));
  for (int round = 0; round < TEST_REFINEMENTS; round++) {
    lth_block_matrix_apply(K, lth_threads(b->ctx), b->x, r);
    for (LitheCount i = 0; i < K->n; i++) r[i] = b->r[i] - r[i];
    CHECK_OK(b->ctx, engine->solve(b->ctx, factor, r, dx));
    for (LitheCount i = 0; i < K->n; i++) b->x[i] += dx[i];
  }
  lth_free(b->ctx, r);
  lth_free(b->ctx, dx);
  engine->destroy(b->ctx, &factor);
}

/// Smallest and largest eigenvalue of K.
static inline void test_eigenvalues(const TestBody *b, double *min, double *max) {
  double *A = test_dense(b), *w = lth_alloc(b->ctx, b->K->n, sizeof *w);
  int n = (int)b->K->n;
  assert_int_equal(LAPACKE_dsyev(LAPACK_ROW_MAJOR, 'N', 'L', n, A, n, w), 0);
  *min = w[0], *max = w[n - 1];
  lth_free(b->ctx, A);
  lth_free(b->ctx, w);
}

/// A field of the space from a function of place, exact for its polynomials.
typedef void (*TestField)(const void *self, const double x[3], double value[3]);
static inline void test_project(const TestBody *b, TestField field, const void *self,
                                double *coef) {
  CHECK_OK(b->ctx, lth_dg_project(b->ctx, b->space, field, self, 8, coef));
}

/// A rotation about (1, 2, 3) by `angle`.
static inline void test_rotation(double angle, double R[9]) {
  double k[3] = {1 / sqrt(14), 2 / sqrt(14), 3 / sqrt(14)}, c = cos(angle), s = sin(angle);
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) R[3 * a + b] = (1 - c) * k[a] * k[b] + (a == b ? c : 0);
  R[1] -= s * k[2], R[2] += s * k[1], R[3] += s * k[2];
  R[5] -= s * k[0], R[6] -= s * k[1], R[7] += s * k[0];
}

/// coef -> A coef (+ b on the constants): an affine map of positions.
static inline void test_affine(const TestBody *b, const double A[9], const double shift[3],
                               const double *from, double *to) {
  for (LitheIndex c = 0; c < b->space->n_cells; c++)
    for (LitheIndex i = b->space->func_off[c]; i < b->space->func_off[c + 1]; i++) {
      double v[3];
      lth_m3_apply(A, from + 3 * (LitheCount)i, v);
      if (i == b->space->func_off[c]) lth_v3_add(v, shift, v);
      lth_v3_copy(v, to + 3 * (LitheCount)i);
    }
}

static inline void test_add_weight(TestBody *b, const double weight[3]) {
  double *one = lth_alloc(b->ctx, b->space->n_cells, sizeof *one);
  for (LitheIndex c = 0; c < b->space->n_cells; c++) one[c] = 1;
  lth_dg_add_gravity(b->space, one, weight, b->f);
  lth_free(b->ctx, one);
}

static inline void test_set_material(TestBody *b, double young, double poisson) {
  for (LitheIndex c = 0; c < b->space->n_cells; c++) b->young[c] = young, b->poisson[c] = poisson;
}

static inline double test_compliance(const TestBody *b) {
  double sum = 0;
  for (LitheCount i = 0; i < b->K->n; i++) sum += b->f[i] * (b->x[i] - b->x0[i]);
  return sum;
}

/// Three independent programs agree on the compliance of a unit cube of 10^3 hexahedra, E = 1e5, nu = .3,
/// clamped below, weight 9.81, with the penalty gamma (lambda + 2 mu) / h on inner and clamped faces.
/// Eq. (20) gives 2 eta / h inside, and Lithe 4 eta / h on clamped faces; the matrix is linear in eta, so
/// the clamped part at half the eta completes the same matrix.
static inline double test_reference_compliance(LthFlux flux, int degree, double gamma) {
  TestBody b = test_body(TEST_HEXAHEDRA, (LthGrid){{0, 0, 0}, {1, 1, 1}, {10, 10, 10}}, degree);
  test_set_material(&b, 1e5, 0.3);
  b.def.flux = flux;
  b.def.penalty = LTH_PENALTY_ETA;
  LthBlockMatrix *K = NULL;
  LitheCount n = 0;
  double *f0 = lth_alloc(b.ctx, b.space->n_dofs, sizeof *f0);
  test_hold(&b, test_facing_down_z);
  for (int part = 0; part < 3; part++) {
    b.def.eta = part == 1 ? gamma / 2 : gamma / 4;
    b.def.n_weak = part == 0 ? 1 : 0; // clamped at half - free at half + free
    double sign = part == 2 ? -1 : 1;
    test_assemble(&b, 0);
    if (!K) {
      CHECK_OK(b.ctx, lth_dg_matrix_create(b.ctx, b.op, &K));
      n = K->value_off[K->block_off[K->n_rows]];
      assert_int_equal(n, degree == 1 ? 921600 : 5760000); // 0.64 % of the full matrix
    }
    for (LitheCount i = 0; i < n; i++) K->values[i] += sign * b.K->values[i];
    for (LitheCount i = 0; i < K->n; i++) f0[i] += sign * b.f0[i];
    if (part == 2) break;
    lth_dg_operator_destroy(b.ctx, &b.op);
    lth_block_matrix_destroy(b.ctx, &b.K);
  }
  test_add_weight(&b, (double[3]){0, 0, -9.81});
  test_solve_sparse(&b, K, f0);
  double result = test_compliance(&b);
  lth_block_matrix_destroy(b.ctx, &K);
  lth_free(b.ctx, f0);
  test_body_free(&b);
  return result;
}
