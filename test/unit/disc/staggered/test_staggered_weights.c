/// Means of elastic constants that vary within a cell, against docs/theory/staggered.md.
#include "disc/staggered/staggered_priv.h"
#include "material/material.h"
#include "staggered_body.h"

static const double young[2] = {1000, 3000}, density[2] = {1, 5};
static double poisson[2];
#define H 0.25

/// Halves of cells along x are of two materials.
static void striped(const void *self, const double x[3], double *E, double *nu, double *rho) {
  (void)self;
  int k = (int)floor(2 * x[0] / H) & 1;
  *E = young[k], *nu = poisson[k], *rho = density[k];
}

static double harmonic(double a, double b) { return 2 / (1 / a + 1 / b); }

static void check_body(int dim, LthFormulation formulation, double first, double second) {
  double lambda[2], mu[2];
  poisson[0] = first, poisson[1] = second;
  for (int k = 0; k < 2; k++) lth_lame(young[k], poisson[k], lambda + k, mu + k);
  SgBody b;
  SgDef def = {.dim = dim,
               .high = {1, 1, dim == 3 ? 1 : 0},
               .n = {4, 4, dim == 3 ? 4 : 1},
               .part = sg_full,
               .material = {.eval = striped},
               .formulation = formulation};
  sg_create(&b, &def);
  const LthStaggeredLevel *level = &b.s->level;
  for (LitheIndex c = 0; c < b.disc->n_cells; c++) {
    LitheCount slot = lth_level_at(level, b.s->cell_slot[c]);
    CHECK_NEAR(level->mu[slot], harmonic(mu[0], mu[1]), 1e-10);
    CHECK_NEAR(level->lambda[slot], harmonic(lambda[0], lambda[1]), 1e-13 * lambda[0]);
    CHECK_NEAR(level->volume[slot], 1, 1e-14);
    if (formulation == LTH_FORM_MIXED)
      CHECK_NEAR(level->compliance[slot], 0.5 / lambda[0] + 0.5 / lambda[1], 1e-13 / lambda[0]);
  }
  // low edges and faces of the last cell are inside the body and have both materials around them as well
  LitheCount slot = lth_level_at(level, b.s->cell_slot[b.disc->n_cells - 1]);
  for (int e = dim == 3 ? 0 : 2; e < 3; e++)
    CHECK_NEAR(level->shear[e][slot], harmonic(mu[0], mu[1]), 1e-10);
  for (int a = 0; a < dim; a++) CHECK_NEAR(level->mass[a][slot], 3, 1e-12);
  sg_free(&b);
}

static void stripes_within_cells_have_harmonic_means(void **state) {
  (void)state;
  check_body(2, LTH_FORM_DISPLACEMENT, 0.3, 0.2);
  check_body(3, LTH_FORM_DISPLACEMENT, 0.3, 0.2);
}

/// Below, pressures are dropped.
static void compressibilities_of_stripes_are_averaged(void **state) {
  (void)state;
  check_body(2, LTH_FORM_MIXED, 0.499, 0.498);
  check_body(3, LTH_FORM_MIXED, 0.499, 0.498);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(stripes_within_cells_have_harmonic_means),
      cmocka_unit_test(compressibilities_of_stripes_are_averaged),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
