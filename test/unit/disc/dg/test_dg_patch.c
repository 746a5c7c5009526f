/// Patch tests: fields of the space are reproduced under weak constraints and loads of every kind.
#include "dg_body.h"
#include "topology_ops.h"

/// u_a = c[a][0] + c[a][1..3] . x + quadratic, all times (1 + t).
typedef struct Field {
  double constant[3], gradient[9], quadratic[3][6]; ///< xx yy zz yz zx xy
} Field;

static const Field linear = {
    {0.1, -0.2, 0.3}, {0.02, -0.03, 0.05, 0.01, 0.04, -0.02, 0.03, 0.06, -0.05}, {{0}}};
static const Field curved = {{0.1, -0.2, 0.3},
                             {0.02, -0.03, 0.05, 0.01, 0.04, -0.02, 0.03, 0.06, -0.05},
                             {{0.03, 0.02, -0.05, 0.04, 0.01, 0.06},
                              {-0.02, 0.05, 0.03, 0.01, -0.04, 0.02},
                              {0.04, -0.03, 0.02, -0.06, 0.05, 0.01}}};

static double field_value(const Field *field, int a, const double x[3]) {
  const double *q = field->quadratic[a];
  return field->constant[a] + lth_v3_dot(field->gradient + 3 * a, x) + q[0] * x[0] * x[0] +
         q[1] * x[1] * x[1] + q[2] * x[2] * x[2] + q[3] * x[1] * x[2] + q[4] * x[2] * x[0] +
         q[5] * x[0] * x[1];
}

static void field_gradient(const Field *field, const double x[3], double H[9]) {
  for (int a = 0; a < 3; a++) {
    const double *q = field->quadratic[a];
    H[3 * a] = field->gradient[3 * a] + 2 * q[0] * x[0] + q[4] * x[2] + q[5] * x[1];
    H[3 * a + 1] = field->gradient[3 * a + 1] + 2 * q[1] * x[1] + q[3] * x[2] + q[5] * x[0];
    H[3 * a + 2] = field->gradient[3 * a + 2] + 2 * q[2] * x[2] + q[3] * x[1] + q[4] * x[0];
  }
}

typedef struct Probe {
  const Field *field;
  int row, column;
  double lambda, mu;
} Probe;

static double displacement(const void *self, const double x[3], double t) {
  const Probe *p = self;
  return (1 + t) * field_value(p->field, p->row, x);
}

static double position(const void *self, const double x[3], double t) {
  const Probe *p = self;
  return x[p->row] + (1 + t) * field_value(p->field, p->row, x);
}

static double normal_displacement(const void *self, const double x[3], double t) {
  const Probe *p = self; // the plane x_row = max
  return displacement(p, x, t);
}

static double stress(const void *self, const double x[3], double t) {
  const Probe *p = self;
  double H[9];
  field_gradient(p->field, x, H);
  double trace = p->row == p->column ? p->lambda * (H[0] + H[4] + H[8]) : 0;
  return (1 + t) * (trace + p->mu * (H[3 * p->row + p->column] + H[3 * p->column + p->row]));
}

/// -div sigma of a quadratic field: lambda grad div u + mu (grad div u + laplace u).
static double body_force(const void *self, const double x[3], double t) {
  (void)x;
  const Probe *p = self;
  const double(*q)[6] = p->field->quadratic;
  double grad_div[3] = {2 * q[0][0] + q[1][5] + q[2][4], q[0][5] + 2 * q[1][1] + q[2][3],
                        q[0][4] + q[1][3] + 2 * q[2][2]};
  double laplace = 2 * (q[p->row][0] + q[p->row][1] + q[p->row][2]);
  return -(1 + t) * ((p->lambda + p->mu) * grad_div[p->row] + p->mu * laplace);
}

static void exact_position(const void *self, const double x[3], double value[3]) {
  const Field *field = self;
  for (int a = 0; a < 3; a++) value[a] = x[a] + 1.5 * field_value(field, a, x);
}

static bool not_down_x(const double c[3], const double n[3]) { return !test_facing_down_x(c, n); }
static bool not_along_x(const double c[3], const double n[3]) {
  return !test_facing_down_x(c, n) && !test_facing_up_x(c, n);
}

/// The part of a surface on this side of the middle of its box.
static bool lower_half(const double c[3], const double n[3]) {
  (void)n;
  return c[0] < 0;
}
static bool upper_half(const double c[3], const double n[3]) { return !lower_half(c, n); }

typedef enum Support { HELD, HELD_AS_POSITION, HELD_AND_PULLED, ROLLING, HALF_HELD } Support;

static TestWhere held_part(Support support) {
  if (support == HALF_HELD) return lower_half;
  return support >= HELD_AND_PULLED ? test_facing_down_x : test_everywhere;
}

static TestWhere pulled_part(Support support) {
  if (support == HALF_HELD) return upper_half;
  return support == ROLLING ? not_along_x : not_down_x;
}

/// Rounding of a residual beside |K| |x|: places are rounded, and cells are thin beside their size.
static double rounding(const TestBody *b) {
  double most = 1;
  for (LitheIndex c = 0; c < b->space->n_cells; c++) {
    const double *box = b->space->mesh->cell_box + 6 * c;
    most = fmax(most, b->space->trace_constant[c] * 0.5 * lth_v3_distance(box, box + 3));
  }
  return 1e-12 + 16 * 0x1p-52 * most;
}

/// Solve under `support` at t = 0.5 and compare every coefficient with the field's. Thin cells make matrices whose
/// condition times rounding is more than the usual 1e-9.
static void check_reproduced_to(double tolerance, TestBody b, const Field *field, Support support,
                                double poisson) {
  for (LitheIndex c = 0; c < b.space->n_cells; c++) b.poisson[c] = poisson;
  Probe probe[9];
  double lambda, mu, t = 0.5;
  lth_lame(1000, poisson, &lambda, &mu);
  for (int i = 0; i < 9; i++) probe[i] = (Probe){field, i / 3, i % 3, lambda, mu};
  LthWeakConstraint *hold = test_hold(&b, held_part(support));
  hold->is_position = support == HELD_AS_POSITION;
  for (int a = 0; a < 3; a++)
    hold->value[a] =
        (LthValue){0, support == HELD_AS_POSITION ? position : displacement, &probe[3 * a]};
  if (support == ROLLING) {
    LthWeakConstraint *roller = test_hold(&b, test_facing_up_x);
    roller->normal_only = true;
    roller->value[0] = (LthValue){0, normal_displacement, &probe[0]};
  }
  test_assemble(&b, t);

  LthLoad volume = {.kind = LTH_LOAD_BODY_FORCE}, surface = {.kind = LTH_LOAD_STRESS};
  for (int a = 0; a < 3; a++) volume.value[a] = (LthValue){0, body_force, &probe[3 * a]};
  CHECK_OK(b.ctx, lth_dg_add_load(b.ctx, b.space, &volume, t, NULL, b.f));
  if (support >= HELD_AND_PULLED) {
    surface.patches = b.patches[3] = test_patches(b.ctx, b.mesh, pulled_part(support));
    for (int i = 0; i < 9; i++) surface.stress[i] = (LthValue){0, stress, &probe[i]};
    CHECK_OK(b.ctx, lth_dg_add_load(b.ctx, b.space, &surface, t, NULL, b.f));
  }
  if (support == ROLLING) { // the roller's face carries its shear
    LthLoad shear = {.kind = LTH_LOAD_TRACTION, .patches = b.weak[1].patches};
    for (int a = 1; a < 3; a++) shear.value[a] = (LthValue){0, stress, &probe[3 * a]};
    CHECK_OK(b.ctx, lth_dg_add_load(b.ctx, b.space, &shear, t, NULL, b.f));
  }
  test_solve_sparse(&b, b.K, b.f0);
  test_project(&b, exact_position, field, b.r);
  for (LitheCount i = 0; i < b.K->n; i++) CHECK_NEAR(b.x[i], b.r[i], tolerance);

  // the field's own residual knows no condition number
  double *force = lth_alloc(b.ctx, b.K->n, sizeof *force), scale = test_force_scale(&b, b.r);
  test_force(&b, b.r, force);
  for (LitheCount i = 0; i < b.K->n; i++) CHECK_NEAR(force[i], b.f[i], rounding(&b) * scale);
  lth_free(b.ctx, force);
  test_body_free(&b);
}

static void check_reproduced(TestBody b, const Field *field, Support support, double poisson) {
  check_reproduced_to(1e-9, b, field, support, poisson);
}

static const LthGrid grid = {{0.2, -0.3, 0.1}, {1.2, 0.7, 0.8}, {2, 2, 2}};
static const LthGrid small = {{0.2, -0.3, 0.1}, {1.2, 0.7, 0.8}, {1, 2, 1}};

static void linear_fields_on_hexahedra(void **state) {
  (void)state;
  for (int k = 1; k <= 2; k++)
    for (int support = HELD; support <= ROLLING; support++)
      check_reproduced(test_body(TEST_HEXAHEDRA, grid, k), &linear, (Support)support, 0.3);
}

static void linear_fields_on_tetrahedra(void **state) {
  (void)state;
  for (int k = 1; k <= 2; k++)
    for (int support = HELD; support <= ROLLING; support++)
      check_reproduced(test_body(TEST_TETRAHEDRA, small, k), &linear, (Support)support, 0.3);
}

static void quadratic_fields_with_their_body_force(void **state) {
  (void)state;
  for (int k = 2; k <= 3; k++)
    for (int support = HELD; support <= ROLLING; support++) {
      check_reproduced(test_body(TEST_HEXAHEDRA, small, k), &curved, (Support)support, 0.3);
      check_reproduced(test_body(TEST_TETRAHEDRA, small, 2), &curved, (Support)support, 0.3);
    }
}

/// A solid about the origin, turned off the grid's axes, in n cells along its longest side.
static TestBody sliced(LitheCtx *ctx, LthSurface *s, LitheIndex n, double sliver, int degree) {
  double R[9], size = 0;
  test_rotation(0.9, R);
  solid_move(s, R, 1, (double[3]){0, 0, 0});
  LthGrid cells;
  solid_bounds(s, cells.min, cells.max);
  for (int a = 0; a < 3; a++) size = fmax(size, cells.max[a] - cells.min[a]);
  for (int a = 0; a < 3; a++)
    cells.cells[a] = (LitheIndex)ceil((double)n * (cells.max[a] - cells.min[a]) / size);
  LthMesh *mesh = NULL;
  CHECK_OK(ctx, lth_mesh_slice(ctx, s, &cells, sliver, &mesh));
  solid_free(ctx, &s);
  return test_body_of(ctx, mesh, degree);
}

static void linear_fields_on_sliced_solids(void **state) {
  (void)state;
  for (int k = 1; k <= 2; k++)
    for (int solid = 0; solid < 3; solid++)
      for (int held = 0; held < 2; held++) {
        LitheCtx *ctx = test_ctx();
        LthSurface *s = solid == 0   ? solid_torus(ctx, 1, 0.45, 12, 6)
                        : solid == 1 ? solid_star(ctx, 5, 0.4, 1, 0.5)
                                     : solid_sphere(ctx, 5);
        double sliver = solid == 2 ? 0 : 0.05;
        check_reproduced(sliced(ctx, s, 3, sliver, k), &linear, held ? HELD : HALF_HELD, 0.3);
      }
}

static void quadratic_fields_on_sliced_solids(void **state) {
  (void)state;
  for (int held = 0; held < 2; held++) {
    LitheCtx *ctx = test_ctx();
    check_reproduced(sliced(ctx, solid_torus(ctx, 1, 0.45, 12, 6), 3, 0.05, 2), &curved,
                     held ? HELD : HALF_HELD, 0.3);
    ctx = test_ctx();
    check_reproduced(sliced(ctx, solid_star(ctx, 5, 0.4, 1, 0.5), 3, 0.05, 2), &curved,
                     held ? HELD : HALF_HELD, 0.4999);
  }
}

static void nearly_incompressible_fields(void **state) {
  (void)state;
  check_reproduced(test_body(TEST_HEXAHEDRA, grid, 1), &linear, HELD_AND_PULLED, 0.4999);
  check_reproduced(test_body(TEST_TETRAHEDRA, small, 2), &curved, ROLLING, 0.4999);
}

static void every_penalty_of_the_paper_is_consistent(void **state) {
  (void)state;
  for (int kind = LTH_PENALTY_ETA; kind <= LTH_PENALTY_ETA_PLAIN; kind++) {
    TestBody b = test_body(TEST_HEXAHEDRA, grid, 1);
    b.def.penalty = (LthPenaltyKind)kind;
    b.def.eta = kind == LTH_PENALTY_ETA ? 5 : 1e4;
    check_reproduced(b, &linear, HELD_AND_PULLED, 0.3);
  }
}

/// A body whose cells were split, merged and cut at random; slivers merged.
static TestBody shuffled(LitheCtx *ctx, int solid, int degree, uint64_t *seed) {
  LthMesh *mesh = topology_solid(ctx, solid);
  LthTopology *t = NULL;
  LthPlane last = {{0, 0, 0}, {0, 0, 1}};
  TopologyRun run = {0};
  LitheIndex n = 0;
  CHECK_OK(ctx, lth_topology_create(ctx, mesh, &t));
  lth_mesh_destroy(ctx, &mesh);
  for (int i = 0; i < 12; i++) topology_random_operation(ctx, t, &last, 12, seed, &run);
  CHECK_OK(ctx,
           lth_topology_merge_slivers(ctx, t, 0, NULL, 1e-3 * t->volume / t->n_live_cells, &n));
  CHECK_OK(ctx, lth_topology_mesh(ctx, t, 0, NULL, &mesh, NULL, NULL));
  lth_topology_destroy(ctx, &t);
  return test_body_of(ctx, mesh, degree);
}

/// All of the boundary, the sides of cuts included, is held: the field goes through every cut.
static void fields_on_cells_that_were_split_merged_and_cut(void **state) {
  (void)state;
  uint64_t seed = 11;
  for (int i = 0; i < 3 * TOPOLOGY_SOLIDS; i++) {
    check_reproduced_to(1e-6, shuffled(test_ctx(), i % TOPOLOGY_SOLIDS, 1, &seed), &linear, HELD,
                        0.3);
    check_reproduced_to(1e-6, shuffled(test_ctx(), i % TOPOLOGY_SOLIDS, 2, &seed), &curved, HELD,
                        0.3);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(linear_fields_on_hexahedra),
      cmocka_unit_test(linear_fields_on_tetrahedra),
      cmocka_unit_test(quadratic_fields_with_their_body_force),
      cmocka_unit_test(linear_fields_on_sliced_solids),
      cmocka_unit_test(quadratic_fields_on_sliced_solids),
      cmocka_unit_test(nearly_incompressible_fields),
      cmocka_unit_test(every_penalty_of_the_paper_is_consistent),
      cmocka_unit_test(fields_on_cells_that_were_split_merged_and_cut),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
