/// Penalties of faces against their formulas, docs/theory/dg.md, section 3.
#include "dg_body.h"
#include "disc/dg/dg_priv.h"

static const double lambda = 1000 * 0.3 / (1.3 * 0.4), mu = 1000 / 2.6;

/// Cubes of side h: C_K = 6 / h for constant gradients, centroids at h / 2 from faces.
static const LthGrid cubes = {{0, 0, 0}, {1.5, 1.5, 1.5}, {3, 3, 3}};
#define SIDE 0.5

static double along_low(const LthDgPenalty *p) {
  return p->low_iso[0] + p->low_normal[0][0] + p->low_normal[0][1];
}

static double along_full(const LthDgPenalty *p) {
  return p->full_iso + p->full_normal[0] + p->full_normal[1];
}

static void mean_jump_of_linear_elements_has_the_bound_alone(void **state) {
  (void)state;
  TestBody b = test_body(TEST_HEXAHEDRA, cubes, 1);
  test_assemble(&b, 0);
  // two sides of weight 1/2: 2 * (2 (1/2)^2 6 / h) = 6 / h
  for (LitheIndex f = 0; f < b.op->n_faces; f++) {
    const LthDgPenalty *p = &b.op->faces[f].penalty;
    CHECK_NEAR(p->full_iso + p->low_iso[0], 6 / SIDE * mu, 1e-9);
    CHECK_NEAR(along_full(p) + along_low(p), 6 / SIDE * (lambda + 2 * mu), 1e-9);
  }
  test_body_free(&b);
}

static void rest_of_the_jump_of_linear_elements_has_the_springs(void **state) {
  (void)state;
  TestBody b = test_body(TEST_HEXAHEDRA, cubes, 1);
  test_assemble(&b, 0);
  for (LitheIndex f = 0; f < b.op->n_faces; f++) {
    const LthDgPenalty *p = &b.op->faces[f].penalty;
    CHECK_NEAR(p->full_iso, mu / SIDE, 1e-9);
    CHECK_NEAR(along_full(p), 1000 / SIDE, 1e-9);
  }
  test_body_free(&b);
}

/// Quadratic elements: mu on all of the jump, lambda on its part of degree 1.
static void higher_degrees_have_mu_on_all_of_the_jump(void **state) {
  (void)state;
  TestBody b = test_body(TEST_HEXAHEDRA, cubes, 2);
  test_assemble(&b, 0);
  for (LitheIndex f = 0; f < b.op->n_faces; f++) {
    const LthDgFace *face = &b.op->faces[f];
    const LthDgPenalty *p = &face->penalty;
    double bound = 0;
    for (int s = 0; s < 2; s++)
      bound += 2 * face->weight[s] * face->weight[s] * b.space->trace_constant[face->cell[s]];
    CHECK_NEAR(face->weight[0] + face->weight[1], 1, 1e-14);
    CHECK_NEAR(p->full_iso, bound * mu, 1e-9 * bound * mu);
    CHECK_NEAR(along_full(p), 2 * bound * mu, 1e-9 * bound * mu);
    CHECK_NEAR(p->low_iso[0], 0, 1e-12);
    CHECK_NEAR(along_low(p), bound * lambda, 1e-9 * bound * lambda);
  }
  test_body_free(&b);
}

/// The largest mean square of a linear function's trace over its mean square in a cube: 1 + x / h and so on make
/// int_dK / int_K = 6 / h for constants and more for others.
static void trace_constant_bounds_every_function(void **state) {
  (void)state;
  TestBody b = test_body(TEST_HEXAHEDRA, cubes, 1);
  for (LitheIndex c = 0; c < b.space->n_cells; c++)
    CHECK_NEAR(b.space->trace_constant[c], 6 / SIDE, 1e-12);
  test_body_free(&b);
  // degree 2 has linear gradients: t = 2 x / h has int t^2 = 2 h^2 + 4 h^2 / 3 on the faces, h^3 / 3 inside
  b = test_body(TEST_HEXAHEDRA, cubes, 2);
  for (LitheIndex c = 0; c < b.space->n_cells; c++)
    CHECK_NEAR(b.space->trace_constant[c], 10 / SIDE, 1e-10);
  test_body_free(&b);
}

static void equation_20_is_taken_to_the_letter(void **state) {
  (void)state;
  TestBody b = test_body(TEST_HEXAHEDRA, cubes, 1);
  b.def.penalty = LTH_PENALTY_ETA_PLAIN;
  b.def.eta = 7;
  test_assemble(&b, 0);
  // eta (A / V + A / V)
  for (LitheIndex f = 0; f < b.op->n_faces; f++) {
    CHECK_NEAR(b.op->faces[f].penalty.full_iso, 7 * 2 / SIDE, 1e-10);
    CHECK_NEAR(along_full(&b.op->faces[f].penalty), 7 * 2 / SIDE, 1e-10);
  }
  test_body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(mean_jump_of_linear_elements_has_the_bound_alone),
      cmocka_unit_test(rest_of_the_jump_of_linear_elements_has_the_springs),
      cmocka_unit_test(higher_degrees_have_mu_on_all_of_the_jump),
      cmocka_unit_test(trace_constant_bounds_every_function),
      cmocka_unit_test(equation_20_is_taken_to_the_letter),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
