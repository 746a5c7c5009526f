/// What the reader makes of the staggered method and of scenes in two dimensions.
#include "base/tensor.h"
#include "scene_text.h"

static Reading read_override(const char *override) {
  Reading r =
      read_with(SMALL_SCENE, 2, (const char *const[]){"bodies.0.method.kind=staggered", override});
  CHECK_OK(r.ctx, r.status);
  return r;
}

static void reads_the_keys_of_the_staggered_method(void **state) {
  (void)state;
  Reading r = read_override("title=defaults");
  const LthSceneBody *b = &r.scene->bodies[0];
  assert_int_equal(r.scene->dimension, 3);
  assert_int_equal(b->method_kind, LTH_METHOD_STAGGERED);
  assert_int_equal(b->fractions.method, LTH_FRACTIONS_EXACT);
  assert_false(b->has_fractions);
  assert_int_equal(b->formulation, LTH_FORMULATION_AUTO);
  assert_int_equal(b->resolution.cells[0], 4);
  end_reading(&r);
  r = read_override("bodies.0.method.fractions={samples: 8}");
  assert_int_equal(r.scene->bodies[0].fractions.method, LTH_FRACTIONS_SAMPLES);
  assert_int_equal(r.scene->bodies[0].fractions.samples, 8);
  assert_true(r.scene->bodies[0].has_fractions);
  end_reading(&r);
  r = read_override("bodies.0.method.fractions=smooth");
  assert_int_equal(r.scene->bodies[0].fractions.method, LTH_FRACTIONS_SMOOTH);
  end_reading(&r);
  r = read_override("bodies.0.method.formulation=mixed");
  assert_int_equal(r.scene->bodies[0].formulation, LTH_FORMULATION_MIXED);
  end_reading(&r);
}

#define EXPECT_STAGGERED_ERROR(override, line)                                                     \
  expect_lines(SMALL_SCENE, 2, (const char *const[]){"bodies.0.method.kind=staggered", override},  \
               (const char *const[]){line, NULL})

static void refuses_what_a_staggered_grid_cannot_take(void **state) {
  (void)state;
  EXPECT_STAGGERED_ERROR("bodies.0.method.fractions={samples: 5}",
                         "--set bodies.0.method.fractions={samples: 5}: "
                         "bodies.0.method.fractions.samples: control volumes share halves of "
                         "cells, got 5 samples; expected an even number");
  EXPECT_STAGGERED_ERROR("bodies.0.method.mesh=hexahedra",
                         "--set bodies.0.method.mesh=hexahedra: bodies.0.method.mesh: a staggered "
                         "grid has no mesh, got \"hexahedra\"; expected cells, cell_size or grid "
                         "alone");
}

static void takes_incompressible_bodies_where_mixed_may_be_taken(void **state) {
  (void)state;
  const char *half = "bodies.0.material.poisson_ratio=0.5";
  Reading r = read_override(half);
  end_reading(&r);
#define NOT_MIXED(with)                                                                            \
  "--set bodies.0.material.poisson_ratio=0.5: bodies.0.material.poisson_ratio: only the mixed "    \
  "formulation keeps volumes, got 0.5 with " with                                                  \
  "; expected a number < 0.5, or `kind: staggered` with `formulation: mixed`"
  EXPECT_OVERRIDE_ERROR("bodies.0.material.poisson_ratio=0.5", NOT_MIXED("kind dg"));
  expect_lines(SMALL_SCENE, 3,
               (const char *const[]){"bodies.0.method.kind=staggered",
                                     "bodies.0.method.formulation=displacement", half},
               (const char *const[]){NOT_MIXED("formulation displacement"), NULL});
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(reads_the_keys_of_the_staggered_method),
      cmocka_unit_test(refuses_what_a_staggered_grid_cannot_take),
      cmocka_unit_test(takes_incompressible_bodies_where_mixed_may_be_taken),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
