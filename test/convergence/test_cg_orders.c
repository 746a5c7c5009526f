/// Manufactured solutions: conforming elements converge with order k + 1 in L2 and k in their gradients; a compliance
/// that independent codes agree on; the same cantilever as by the discontinuous method.
#include "manufactured.h"

#include "cg_body.h"

static void hold_and_pull(CgBody *b, TestSolution *s, TestComponent component[9]) {
  static const double origin[3] = {0, 0, 0}, down[3] = {0, -1, 0};
  lth_lame(1000, s->poisson, &s->lambda, &s->mu);
  for (int i = 0; i < 9; i++) component[i] = (TestComponent){s, i / 3, i % 3};
  for (LitheIndex c = 0; c < b->mesh->n_cells; c++) b->poisson[c] = s->poisson;
  b->weak[0].patches = cg_select(b, 0, origin, down);
  for (int a = 0; a < 3; a++) {
    b->weak[0].fixed[a] = true;
    b->weak[0].value[a] = (LthValue){0, test_solution_value, &component[3 * a]};
  }
  b->def.n_weak = 1;
  cg_build(b);
  LthWhere held = {.kind = LTH_WHERE_PLANE, .normal = {0, -1, 0}};
  LthWhere rest = {.kind = LTH_WHERE_NOT, .children = &held, .n_children = 1};
  CHECK_OK(b->ctx, lth_select_boundary(b->ctx, b->mesh, &rest, &b->patches[1]));
  LthLoad pull = {.kind = LTH_LOAD_STRESS, .patches = b->patches[1]},
          volume = {.kind = LTH_LOAD_BODY_FORCE};
  for (int i = 0; i < 9; i++) pull.stress[i] = (LthValue){0, test_solution_stress, &component[i]};
  for (int a = 0; a < 3; a++)
    volume.value[a] = (LthValue){0, test_solution_force, &component[4 * a]};
  CHECK_OK(b->ctx, b->disc->table->add_load(b->ctx, b->disc, &pull, 0, NULL, b->f));
  CHECK_OK(b->ctx, b->disc->table->add_load(b->ctx, b->disc, &volume, 0, NULL, b->f));
  b->disc->table->assemble(b->disc, 0, b->K, b->f0);
}

static TestErrors errors_of(LthElementKind kind, int n, double poisson) {
  CgBody b = cg_body(kind, n, 0.05);
  TestSolution s = {.poisson = poisson};
  TestComponent component[9];
  TestErrors sum = {0};
  LthCgRule rule;
  hold_and_pull(&b, &s, component);
  cg_solve(&b, NULL);
  const LthCgDisc *d = lth_cg_of(b.disc);
  lth_cg_mass_rule(kind, &rule);
  for (LitheIndex e = 0; e < b.elements->n_elements; e++)
    for (int q = 0; q < rule.n; q++) {
      double X[3], J[9], phi[LTH_CG_MAX], dphi[3 * LTH_CG_MAX], u[3], H[9], got[3] = {0};
      double F[9] = {0};
      lth_cg_map(d, e, rule.xi[q], X, J, phi, dphi);
      double w = rule.weight[q] * lth_cg_space_gradients(d->kind[kind].n, J, dphi);
      for (int i = 0; i < d->kind[kind].n; i++) {
        const double *x = b.x + 3 * lth_cg_nodes(d, e)[i];
        lth_v3_axpy(phi[i], x, got);
        for (int k = 0; k < 9; k++) F[k] += x[k / 3] * dphi[3 * i + k % 3];
      }
      test_solution(&s, X, u);
      test_solution_gradient(&s, X, H);
      for (int a = 0; a < 3; a++) sum.l2 += w * pow(got[a] - X[a] - u[a], 2);
      for (int i = 0; i < 9; i++) sum.h1 += w * pow(F[i] - (i % 4 == 0) - H[i], 2);
    }
  cg_free(&b);
  return (TestErrors){sqrt(sum.l2), sqrt(sum.h1)};
}

static void every_kind_converges_with_its_order(void **state) {
  (void)state;
  for (int k = LTH_TET4; k < LTH_POLYHEDRON; k++) {
    int degree = lth_element_shape((LthElementKind)k)->degree, n = degree == 1 ? 8 : 2;
    TestErrors coarse = errors_of((LthElementKind)k, n, 0.3),
               fine = errors_of((LthElementKind)k, 2 * n, 0.3);
    double l2 = log2(coarse.l2 / fine.l2), h1 = log2(coarse.h1 / fine.h1);
    // coarse meshes are before their asymptotic range by some tenths
    CHECK_AT_LEAST(l2, degree + 1 - 0.2);
    CHECK_AT_LEAST(h1, degree - 0.15);
  }
}

/// The unit cube on a grid, E = 1e5, nu = 0.3, 9.81 N/m^3 downwards, nodes of z = 0 held.
static double compliance(LitheIndex n, LitheCount *n_values) {
  LitheCtx *ctx = test_ctx();
  LthElementMesh *elements = NULL;
  LthGrid grid = {{0, 0, 0}, {1, 1, 1}, {n, n, n}};
  CHECK_OK(ctx, lth_element_mesh_grid(ctx, &grid, 1, false, false, NULL, &elements));
  CgBody b = cg_body_of(ctx, elements);
  for (LitheIndex c = 0; c < b.mesh->n_cells; c++) b.young[c] = 1e5;
  cg_build(&b);
  uint8_t *held = lth_alloc(ctx, b.disc->n_dofs, 1);
  for (LitheCount i = 0; i < b.disc->n_dofs; i++) held[i] = b.x0[i / 3 * 3 + 2] == 0;
  b.disc->table->add_gravity(b.disc, (double[3]){0, 0, -9.81}, b.f);
  b.disc->table->assemble(b.disc, 0, b.K, b.f0);
  *n_values = 0;
  for (LitheIndex row = 0; row < b.K->n_rows; row++)
    for (LitheCount e = b.K->block_off[row]; e < b.K->block_off[row + 1]; e++)
      *n_values += !held[3 * row] && !held[3 * b.K->block_col[e]] ? 9 : 0;
  cg_solve(&b, held);
  double sum = 0;
  for (LitheCount i = 0; i < b.disc->n_dofs; i++) sum += b.f[i] * (b.x[i] - b.x0[i]);
  lth_free(ctx, held);
  cg_free(&b);
  return sum;
}

/// Four programs agree on 2.94665530e-4 for 15 cells a side, from 0.82 million values.
static void compliance_of_trilinear_hexahedra_agrees_with_independent_codes(void **state) {
  (void)state;
  LitheCount n_values = 0;
  CHECK_NEAR(compliance(15, &n_values), 2.94665530e-4, 0.5e-12);
  CHECK_NEAR((double)n_values, 0.82e6, 0.005e6);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_kind_converges_with_its_order),
      cmocka_unit_test(compliance_of_trilinear_hexahedra_agrees_with_independent_codes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
