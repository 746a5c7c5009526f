/// Fractions of the boxes around faces and edges: those of one solid, whatever control volume asks.
#include "staggered_body.h"

#include "disc/staggered/staggered_priv.h"

static const LthShape ball = {.kind = LTH_SHAPE_SPHERE, .a = {0.03, -0.02, 0.05}, .radius = 0.7};

/// Mean over the h-box around `center` by the four samples an axis of the lattice that lie in it.
static double sampled_mean(const LthSparseGrid *g, const double center[3]) {
  int count = 0, n_samples = g->dim == 3 ? 64 : 16;
  for (int i = 0; i < n_samples; i++) {
    double x[3] = {0, 0, 0};
    for (int a = 0; a < g->dim; a++) x[a] = center[a] + g->h[a] * ((i >> 2 * a & 3) / 4.0 - 0.375);
    count += lth_shape_value(&ball, x) <= 0;
  }
  return (double)count / n_samples;
}

/// Of the low x, y and z faces and edges of a cell.
static void check_cell(const LthStaggered *s, LitheIndex func, const LitheCount *slot,
                       const int stride[3], void *self) {
  double at[3], x[3];
  LitheIndex cell[3];
  (void)func;
  lth_sparse_grid_cell(s->grid, *slot, cell);
  for (int a = 0; a < 3; a++) {
    for (int b = 0; b < 3; b++) at[b] = b == a ? 0 : 0.5;
    lth_sparse_grid_place(s->grid, cell, at, x);
    if (a < s->dim)
      CHECK_NEAR(lth_staggered_face_fraction(s, slot, stride, a), sampled_mean(s->grid, x), 1e-14);
    for (int b = 0; b < 3; b++) at[b] = b == a ? 0.5 : 0;
    lth_sparse_grid_place(s->grid, cell, at, x);
    if (a == 2 || s->dim == 3)
      CHECK_NEAR(lth_staggered_edge_fraction(s, slot, stride, a), sampled_mean(s->grid, x), 1e-14);
  }
#pragma omp atomic
  ++*(LitheCount *)self;
}

static void faces_and_edges_are_means_of_their_own_samples(void **state) {
  (void)state;
  for (int dim = 2; dim <= 3; dim++) {
    LitheCount seen = 0;
    SgBody b;
    sg_create(&b, &(SgDef){.dim = dim,
                           .low = {-1, -0.9, -0.95},
                           .high = {1, 0.9, 0.95},
                           .n = {20, 20, dim == 3 ? 20 : 1},
                           .shape = &ball,
                           .method = {.method = LTH_FRACTIONS_SAMPLES, .samples = 4}});
    lth_staggered_visit(b.s, check_cell, &seen);
    assert_int_equal(seen, b.disc->n_dofs / 3);
    sg_free(&b);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(faces_and_edges_are_means_of_their_own_samples),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
