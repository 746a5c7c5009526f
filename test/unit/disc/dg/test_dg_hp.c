/// Degrees 1 to 4, mixed in one mesh: polynomials are reproduced, the matrix is definite, thin and stiff
/// neighbours do not spoil it.
#include "dg_body.h"
#include "one_cell.h"
#include "solids.h"

#define MAX_TERMS 35

/// u_a = sum_q c[a][q] x^i y^j z^k over the graded monomials of `degree`.
typedef struct Polynomial {
  int degree;
  double c[3][MAX_TERMS], lambda, mu;
} Polynomial;

typedef struct Term {
  const Polynomial *p;
  int row, column;
} Term;

static Polynomial random_polynomial(int degree, double poisson) {
  Polynomial p = {.degree = degree};
  uint64_t seed = 40 + (uint64_t)degree;
  for (int i = 0; i < 3 * MAX_TERMS; i++)
    p.c[i / MAX_TERMS][i % MAX_TERMS] = 0.1 * test_random(&seed) - 0.05;
  lth_lame(1000, poisson, &p.lambda, &p.mu);
  return p;
}

/// The derivative of component a, order[b] times along axis b.
static double derivative(const Polynomial *p, int a, const int order[3], const double x[3]) {
  const int(*e)[3] = lth_monomial3_exponents();
  double sum = 0;
  for (int q = 0; q < lth_monomials3(p->degree); q++) {
    double term = p->c[a][q];
    for (int b = 0; b < 3; b++) {
      for (int i = 0; i < order[b]; i++) term *= e[q][b] - i;
      if (term != 0) term *= pow(x[b], e[q][b] - order[b]);
    }
    sum += term;
  }
  return sum;
}

static double first(const Polynomial *p, int a, int b, const double x[3]) {
  int order[3] = {b == 0, b == 1, b == 2};
  return derivative(p, a, order, x);
}

static double second(const Polynomial *p, int a, int b, int c, const double x[3]) {
  int order[3] = {(b == 0) + (c == 0), (b == 1) + (c == 1), (b == 2) + (c == 2)};
  return derivative(p, a, order, x);
}

static double displacement(const void *self, const double x[3], double t) {
  (void)t;
  const Term *term = self;
  return derivative(term->p, term->row, (int[3]){0, 0, 0}, x);
}

static double stress(const void *self, const double x[3], double t) {
  (void)t;
  const Term *s = self;
  double trace = 0;
  for (int a = 0; a < 3 && s->row == s->column; a++) trace += s->p->lambda * first(s->p, a, a, x);
  return trace + s->p->mu * (first(s->p, s->row, s->column, x) + first(s->p, s->column, s->row, x));
}

static double body_force(const void *self, const double x[3], double t) {
  (void)t;
  const Term *s = self;
  double sum = 0;
  for (int b = 0; b < 3; b++)
    sum += (s->p->lambda + s->p->mu) * second(s->p, b, b, s->row, x) +
           s->p->mu * second(s->p, s->row, b, b, x);
  return -sum;
}

static void exact_position(const void *self, const double x[3], double value[3]) {
  for (int a = 0; a < 3; a++) value[a] = x[a] + derivative(self, a, (int[3]){0, 0, 0}, x);
}

static bool held(const double c[3], const double n[3]) {
  (void)n;
  return c[0] + c[1] < 0.3;
}
static bool pulled(const double c[3], const double n[3]) { return !held(c, n); }

/// Held on a part of its boundary and pulled on the rest, a body has the coefficients of the polynomial.
static void check_reproduced(TestBody b, int degree, double poisson, double tolerance) {
  Polynomial p = random_polynomial(degree, poisson);
  Term term[9];
  for (int i = 0; i < 9; i++) term[i] = (Term){&p, i / 3, i % 3};
  for (LitheIndex c = 0; c < b.space->n_cells; c++) b.poisson[c] = poisson;
  LthWeakConstraint *hold = test_hold(&b, held);
  for (int a = 0; a < 3; a++) hold->value[a] = (LthValue){0, displacement, &term[3 * a]};
  test_assemble(&b, 0);
  LthLoad volume = {.kind = LTH_LOAD_BODY_FORCE}, surface = {.kind = LTH_LOAD_STRESS};
  surface.patches = b.patches[3] = test_patches(b.ctx, b.mesh, pulled);
  for (int a = 0; a < 3; a++) volume.value[a] = (LthValue){0, body_force, &term[3 * a]};
  for (int i = 0; i < 9; i++) surface.stress[i] = (LthValue){0, stress, &term[i]};
  CHECK_OK(b.ctx, lth_dg_add_load(b.ctx, b.space, &volume, 0, NULL, b.f));
  CHECK_OK(b.ctx, lth_dg_add_load(b.ctx, b.space, &surface, 0, NULL, b.f));
  test_solve_sparse(&b, b.K, b.f0);
  test_project(&b, exact_position, &p, b.r);
  for (LitheCount i = 0; i < b.K->n; i++) CHECK_NEAR(b.x[i], b.r[i], tolerance);
  test_body_free(&b);
}

static const LthGrid small = {{0.2, -0.3, 0.1}, {1.2, 0.7, 0.8}, {1, 2, 1}},
                     one = {{0.2, -0.3, 0.1}, {1.2, 0.7, 0.8}, {1, 1, 1}};

static TestBody sliced_torus(int degree) {
  LitheCtx *ctx = test_ctx();
  LthSurface *s = solid_torus(ctx, 1, 0.45, 12, 6);
  double R[9];
  test_rotation(0.9, R);
  solid_move(s, R, 1, (double[3]){0, 0, 0});
  LthGrid cells = {.cells = {3, 3, 2}};
  solid_bounds(s, cells.min, cells.max);
  LthMesh *mesh = NULL;
  CHECK_OK(ctx, lth_mesh_slice(ctx, s, &cells, 0.05, &mesh));
  solid_free(ctx, &s);
  return test_body_of(ctx, mesh, degree);
}

static void polynomials_of_the_degree_are_reproduced(void **state) {
  (void)state;
  for (int k = 1; k <= 4; k++) {
    check_reproduced(test_body(TEST_HEXAHEDRA, small, k), k, 0.3, 1e-9);
    check_reproduced(test_body(TEST_TETRAHEDRA, one, k), k, k == 3 ? 0.4999 : 0.3, 1e-9);
  }
  check_reproduced(sliced_torus(3), 3, 0.3, 1e-9);
}

static void mixed_degrees_reproduce_polynomials_of_the_lowest(void **state) {
  (void)state;
  for (int lowest = 1; lowest <= 3; lowest++) {
    int degree = MIXED + lowest - 1;
    check_reproduced(test_body(TEST_HEXAHEDRA, small, degree), lowest, 0.3, 1e-9);
    check_reproduced(test_body(TEST_TETRAHEDRA, one, degree), lowest, lowest == 2 ? 0.4999 : 0.3,
                     1e-9);
  }
  check_reproduced(sliced_torus(MIXED), 1, 0.3, 1e-9);
  check_reproduced(sliced_torus(MIXED + 1), 2, 0.3, 1e-9);
}

/// Degrees and stiffnesses differ from cell to cell, rotations at random: no negative eigenvalue.
static void check_definite(TestMesh kind, int degree, double poisson, double contrast) {
  TestBody b =
      test_body(kind,
                (LthGrid){{0, 0, 0},
                          {1, 0.7, 0.4},
                          {kind == TEST_HEXAHEDRA ? 2 : 1, kind == TEST_HEXAHEDRA ? 2 : 1, 1}},
                degree);
  uint64_t seed = 5;
  for (LitheIndex c = 0; c < b.space->n_cells; c++) {
    b.young[c] = 1000 * pow(contrast, test_random(&seed));
    b.poisson[c] = poisson;
  }
  b.def.warped = true;
  test_hold(&b, test_facing_down_x)->fixed[1] = false;
  test_assemble(&b, 0);
  double min, max;
  for (int turned = 0; turned < 2; turned++) {
    for (LitheCount i = 0; i < b.K->n && turned; i++) b.x[i] += 2 * test_random(&seed) - 1;
    lth_dg_update_rotations(b.op, b.x);
    test_assemble(&b, 0);
    test_eigenvalues(&b, &min, &max);
    CHECK_AT_LEAST(min, -1e-12 * max);
  }
  test_body_free(&b);
}

static void mixed_degrees_are_never_indefinite(void **state) {
  (void)state;
  for (int kind = 0; kind < 2; kind++) {
    TestMesh mesh = kind ? TEST_TETRAHEDRA : TEST_HEXAHEDRA;
    check_definite(mesh, MIXED, -0.5, 1e6);
    check_definite(mesh, MIXED, 0.3, 1);
    check_definite(mesh, MIXED, 0.499, 1e6);
    check_definite(mesh, MIXED + 1, 0.499, 1);
  }
  check_definite(TEST_HEXAHEDRA, 3, 0.499, 1e6);
  check_definite(TEST_HEXAHEDRA, 4, 0.3, 1e6);
}

/// Condition number of K after scaling by its diagonal blocks: from K x = e D x. `free`: the first six eigenvalues are
/// rigid motions.
static double block_condition(const TestBody *b, bool free) {
  LitheCount n = b->K->n;
  double *A = test_dense(b), *D = lth_alloc(b->ctx, n * n, sizeof *D),
         *w = lth_alloc(b->ctx, n, sizeof *w);
  for (LitheIndex r = 0; r < b->K->n_rows; r++)
    for (LitheCount i = b->K->row_off[r]; i < b->K->row_off[r + 1]; i++)
      for (LitheCount j = b->K->row_off[r]; j < b->K->row_off[r + 1]; j++)
        D[i * n + j] = A[i * n + j];
  assert_int_equal(LAPACKE_dsygv(LAPACK_ROW_MAJOR, 1, 'N', 'L', (int)n, A, (int)n, D, (int)n, w),
                   0);
  double condition = w[n - 1] / w[free ? 6 : 0];
  lth_free(b->ctx, A);
  lth_free(b->ctx, D);
  lth_free(b->ctx, w);
  return condition;
}

/// Three unit cubes and a layer of thickness t on the last.
static TestBody layered(double t, int degree) {
  LitheCtx *ctx = test_ctx();
  LthMesh *mesh = NULL;
  LthSurface *s = solid_box(ctx, (double[3]){0, 0, 0}, (double[3]){3 + t, 1, 1});
  LthGrid grid = {{0, 0, 0}, {4, 1, 1}, {4, 1, 1}};
  CHECK_OK(ctx, lth_mesh_slice(ctx, s, &grid, 0, &mesh));
  solid_free(ctx, &s);
  TestBody b = test_body_of(ctx, mesh, degree);
  assert_int_equal(b.space->n_cells, 4);
  test_hold(&b, test_facing_down_x);
  test_assemble(&b, 0);
  return b;
}

/// With plain averages the number grows like 1 / t: 1.9e5 for k = 1.
static void thin_elements_do_not_spoil_the_condition(void **state) {
  (void)state;
  for (int k = 1; k <= 3; k++) {
    double condition[2];
    for (int thin = 0; thin < 2; thin++) {
      TestBody b = layered(thin ? 1e-3 : 0.5, k);
      condition[thin] = block_condition(&b, false);
      test_body_free(&b);
    }
    CHECK_AT_MOST(condition[1], 2 * condition[0]);
  }
}

/// Largest over smallest eigenvalue of K but for the six rigid motions, of a body that nothing holds.
static double free_condition(TestBody b) {
  test_assemble(&b, 0);
  LitheCount n = b.K->n;
  double *A = test_dense(&b), *w = lth_alloc(b.ctx, n, sizeof *w);
  assert_int_equal(LAPACKE_dsyev(LAPACK_ROW_MAJOR, 'N', 'L', (int)n, A, (int)n, w), 0);
  double condition = w[n - 1] / w[6];
  lth_free(b.ctx, A);
  lth_free(b.ctx, w);
  test_body_free(&b);
  return condition;
}

/// A tetrahedron, and in it one of its shape `scale` times as large with four elements around it.
static LthMesh *nested_tetrahedra(LitheCtx *ctx, double scale) {
  static const double corner[12] = {1, 1, 1, 1, -1, -1, -1, 1, -1, -1, -1, 1};
  static const int opposite[4][3] = {
      {1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}}; // ccw from outside
  double points[24];
  for (int i = 0; i < 24; i++) points[i] = (i < 12 ? 1 : scale) * corner[i % 12];
  LitheIndex loop_off[15], face_loop_off[15], loop_point[48], face_cell[28], n = 0, f = 0;
  for (int k = 0; k < 4; k++) // outer faces of elements 1 + k, then the inner element's
    for (int inner = 0; inner < 2; inner++, f++) {
      loop_off[f] = n;
      for (int i = 0; i < 3; i++) loop_point[n++] = opposite[k][i] + 4 * inner;
      face_cell[2 * f] = inner ? 0 : 1 + k, face_cell[2 * f + 1] = inner ? 1 + k : -1;
    }
  for (int a = 0; a < 4; a++)
    for (int b = a + 1; b < 4;
         b++, f++) { // between the elements that do not lie opposite a corner of the edge
      int pair[2] = {-1, -1};
      for (int k = 0; k < 4; k++)
        if (k != a && k != b) pair[pair[0] >= 0] = k;
      // out of the first: towards the corner that lies opposite to it
      double u[3], v[3], normal[3], far[3];
      lth_v3_sub(points + 3 * b, points + 3 * a, u);
      lth_v3_sub(points + 12 + 3 * b, points + 3 * a, v);
      lth_v3_cross(u, v, normal);
      lth_v3_sub(points + 3 * pair[0], points + 3 * a, far);
      const LitheIndex loop[4] = {a, b, 4 + b, 4 + a};
      bool out = lth_v3_dot(normal, far) > 0;
      loop_off[f] = n;
      for (int i = 0; i < 4; i++) loop_point[n++] = loop[out ? i : 3 - i];
      face_cell[2 * f] = 1 + pair[0], face_cell[2 * f + 1] = 1 + pair[1];
    }
  loop_off[f] = n;
  for (int i = 0; i <= 14; i++) face_loop_off[i] = i;
  LthMeshDef def = {.n_points = 8,
                    .n_faces = 14,
                    .n_cells = 5,
                    .points = points,
                    .face_loop_off = face_loop_off,
                    .loop_off = loop_off,
                    .loop_point = loop_point,
                    .face_cell = face_cell,
                    .cell_size = 1};
  LthMesh *mesh = NULL;
  CHECK_OK(ctx, lth_mesh_create(ctx, &def, &mesh));
  return mesh;
}

/// Figure 11 of the paper, where the number grows to 1e7 for k = 1 and 1e12 for k = 2: volumes differ up to 1e6.
static void small_elements_do_not_spoil_the_condition(void **state) {
  (void)state;
  static const double scale[3] = {0.3, 0.1, 0.01};
  for (int k = 1; k <= 3; k++) {
    double condition[3];
    for (int i = 0; i < 3; i++) {
      LitheCtx *ctx = test_ctx();
      TestBody b = test_body_of(ctx, nested_tetrahedra(ctx, scale[i]), k);
      test_assemble(&b, 0);
      condition[i] = block_condition(&b, true);
      test_body_free(&b);
    }
    for (int i = 1; i < 3; i++) CHECK_AT_MOST(condition[i], 1.2 * condition[0]);
  }
}

/// Figure 12: two cubes of one element with a neck between them.
static void thin_necks_do_not_spoil_the_condition(void **state) {
  (void)state;
  static const double neck[3] = {0.5, 1e-2, 1e-8};
  for (int k = 1; k <= 4; k++) {
    double condition[3];
    for (int i = 0; i < 3; i++) {
      double h = neck[i] / 2;
      double dumbbell[24] = {-1.5, -0.5, -0.5, -0.5, -0.5, -h, 0.5,  -h, 0.5,  -0.5, 1.5,  -0.5,
                             1.5,  0.5,  0.5,  0.5,  0.5,  h,  -0.5, h,  -0.5, 0.5,  -1.5, 0.5};
      TestSolid solid;
      test_prism(&solid, 12, dumbbell, 0, NULL, -0.5, 0.5);
      LitheCtx *ctx = test_ctx();
      condition[i] = free_condition(test_body_of(ctx, test_one_cell(ctx, &solid), k));
    }
    for (int i = 1; i < 3; i++) CHECK_AT_MOST(condition[i], 1.3 * condition[0]);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(polynomials_of_the_degree_are_reproduced),
      cmocka_unit_test(mixed_degrees_reproduce_polynomials_of_the_lowest),
      cmocka_unit_test(mixed_degrees_are_never_indefinite),
      cmocka_unit_test(thin_elements_do_not_spoil_the_condition),
      cmocka_unit_test(small_elements_do_not_spoil_the_condition),
      cmocka_unit_test(thin_necks_do_not_spoil_the_condition),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
