/// The fast operator and transfers of the staggered method against their plain twins, and the operator's own properties.
#include "disc/staggered/staggered_multigrid_priv.h"
#include "staggered_shape.h"

#include <string.h>

static bool brick_inside(const double x[3]) {
  return x[0] > 0 && x[0] < 1 && x[1] > 0 && x[1] < 1 && (x[2] > 0 || x[2] == 0) && x[2] < 1;
}
static bool brick_held(const double x[3]) { return x[0] <= 1e-9; }
static double two_materials(const double x[3]) { return x[0] + 0.3 * x[1] > 0.6 ? 1e3 : 1; }
/// Materials and holes without any order, the same at the same place.
static double noise(const double x[3], int seed) {
  uint64_t s = (uint64_t)(1e4 * (x[0] + 2)) * 1000003 + (uint64_t)(1e4 * (x[1] + 2)) * 7919 +
               (uint64_t)(1e4 * (x[2] + 2)) * 104729 + (uint64_t)seed;
  test_random(&s);
  return test_random(&s);
}
static double random_young(const double x[3]) { return 0.5 + noise(x, 1); }
static bool random_inside(const double x[3]) {
  return x[0] > 0 && x[0] < 1 && x[1] > 0 && x[1] < 1 && x[2] >= 0 && x[2] < 1 && noise(x, 2) > 0.2;
}
static bool random_held(const double x[3]) { return noise(x, 3) > 0.95; }

static const ShapeDef cases[] = {
    {.dim = 2, .n = 70, .inside = ring_inside, .held = ring_held, .nu = 0.3, .rho = 2},
    {.dim = 2,
     .n = 70,
     .inside = ring_inside,
     .held = ring_held,
     .young = two_materials,
     .nu = 0.45,
     .rho = 1,
     .stretch = 0.4},
    {.dim = 2,
     .n = 40,
     .inside = random_inside,
     .held = random_held,
     .young = random_young,
     .nu = 0.2,
     .rho = 1},
    {.dim = 3, .n = 40, .inside = brick_inside, .held = brick_held, .nu = 0.3, .rho = 2},
    {.dim = 3,
     .n = 26,
     .inside = ball_inside,
     .held = ball_held,
     .young = two_materials,
     .nu = 0.3,
     .rho = 1,
     .stretch = 0.4},
    {.dim = 3,
     .n = 18,
     .inside = random_inside,
     .held = random_held,
     .young = random_young,
     .nu = 0.2,
     .rho = 1},
};
enum { N_CASES = sizeof cases / sizeof *cases };

typedef struct Fixture {
  LitheCtx *ctx;
  ShapeLevel shape;
  LthStaggeredMultigrid *M;
  LitheCount n;
} Fixture;

static Fixture fixture(const ShapeDef *def) {
  Fixture F = {.ctx = test_ctx()};
  F.shape = shape_level(F.ctx, def);
  CHECK_OK(F.ctx, lth_staggered_level_pack(F.ctx, &F.shape.level));
  F.n = 3 * F.shape.grid->n_slots;
  LthStaggeredMultigridDef d = {.level = &F.shape.level, .n_dofs = F.n};
  CHECK_OK(F.ctx, lth_staggered_multigrid_create(F.ctx, &d, &F.M));
  return F;
}

static void fixture_free(Fixture *F) {
  lth_staggered_multigrid_destroy(F->ctx, &F->M);
  shape_free(&F->shape);
  lithe_ctx_destroy(&F->ctx);
}

/// Random values where unknowns are not dead (or free).
static void randomise(const LthStaggeredLevel *l, uint64_t *seed, bool free, double *u[3]) {
  for (int a = 0; a < l->grid->dim; a++)
    for (LitheCount s = 0; s < l->grid->n_slots; s++)
      if (free ? l->state[a][s] == LTH_UNKNOWN_FREE : l->state[a][s] != LTH_UNKNOWN_DEAD)
        u[a][s] = 2 * test_random(seed) - 1;
}

static double largest(const LthSparseGrid *g, double *const u[3]) {
  double most = 0;
  for (int a = 0; a < g->dim; a++)
    for (LitheCount s = 0; s < g->n_slots; s++) most = fmax(most, fabs(u[a][s]));
  return most;
}

/// Take the kernels of an instruction set on all levels; false where this processor does not have it.
static bool take_kernels(Fixture *F, int isa) {
  for (int l = 0; l < F->M->n_levels; l++) {
    LthFastLevel *L = &F->M->level[l];
    const LthFastKernels *kernels = lth_fast_kernels_for(L->grid->dim, (LthIsa)isa);
    if (!kernels) return false;
    L->kernels = kernels;
  }
  return true;
}

static void matrix_free_operator_is_the_plain_one_to_rounding(void **state) {
  (void)state;
  for (int c = 0; c < N_CASES * LTH_N_ISAS; c++) {
    Fixture F = fixture(&cases[c / LTH_N_ISAS]);
    if (!take_kernels(&F, c % LTH_N_ISAS)) {
      fixture_free(&F);
      continue;
    }
    const LthSparseGrid *g = F.shape.grid;
    double *u[3], *y[3], *x = lth_alloc(F.ctx, F.n, 8), *Ax = lth_alloc(F.ctx, F.n, 8);
    uint64_t seed = 5;
    shape_vectors(&F.shape, g, u);
    shape_vectors(&F.shape, g, y);
    randomise(&F.shape.level, &seed, false, u);
    for (LitheCount s = 0; s < g->n_slots; s++)
      for (int a = 0; a < g->dim; a++) x[3 * s + a] = u[a][s];
    for (int k = 0; k < 2; k++) {
      double cm = k * 300, ck = 0.7;
      lth_staggered_apply_ref(F.ctx, &F.shape.level, cm, ck, (const double *const *)u, y);
      lth_staggered_multigrid_apply(F.M, lth_threads(F.ctx), cm, ck, false, x, Ax);
      double scale = largest(g, y);
      for (LitheCount s = 0; s < g->n_slots; s++)
        for (int a = 0; a < 3; a++)
          CHECK_NEAR(Ax[3 * s + a], a < g->dim ? y[a][s] : 0, 2e-15 * 10 * scale);
    }
    shape_vectors_free(&F.shape, u);
    shape_vectors_free(&F.shape, y);
    lth_free(F.ctx, x);
    lth_free(F.ctx, Ax);
    fixture_free(&F);
  }
}

/// Copy between a fast vector and components over slots.
static void to_fast(const LthFastLevel *L, LthFastVector v, double *const u[3]) {
  for (LitheCount s = 0; s < L->grid->n_slots; s++)
    for (int a = 0; a < L->grid->dim; a++)
      if (L->row[s / L->grid->side] > 0) *lth_fast_value(L, v, s, a) = (float)u[a][s];
}
static double fast_at(const LthFastLevel *L, LthFastVector v, int a, LitheCount s) {
  return *lth_fast_value(L, v, s, a);
}

static void check_level(Fixture *F, int l, double cm, double ck) {
  LthFastLevel *L = &F->M->level[l];
  const LthFastKernels *k = L->kernels;
  double *u[3], *b[3], *y[3];
  uint64_t seed = 11;
  shape_vectors(&F->shape, L->grid, u);
  shape_vectors(&F->shape, L->grid, b);
  shape_vectors(&F->shape, L->grid, y);
  randomise(L->level, &seed, true, u);
  randomise(L->level, &seed, true, b);
  to_fast(L, L->x, u);
  to_fast(L, L->b, b);
  lth_staggered_apply_ref(F->ctx, L->level, cm / F->M->unit, ck / F->M->unit,
                          (const double *const *)u, y);
  double scale = largest(L->grid, y) + 1;
  for (LitheIndex i = 0; i < L->n_active; i++) {
    LitheIndex block = L->active[i];
    LitheIndex hide = L->scaled[block];
    float same = L->same_scale[block];
    L->scaled[block] = -1;
    L->same_scale[block] = 1;
    k->residual(L, block);
    L->scaled[block] = hide;
    L->same_scale[block] = same;
    LitheCount n = L->grid->block_cells;
    for (LitheCount s = block * n; s < (block + 1) * n; s++)
      for (int a = 0; a < L->grid->dim; a++)
        if (L->level->state[a][s] == LTH_UNKNOWN_FREE)
          CHECK_NEAR(fast_at(L, L->y, a, s), b[a][s] - y[a][s], 2e-6 * scale);
  }
  lth_staggered_diagonal_ref(F->ctx, L->level, cm / F->M->unit, ck / F->M->unit, y);
  for (LitheIndex i = 0; i < L->n_active; i++) {
    k->start(L, L->active[i], 1);
    LitheCount n = L->grid->block_cells;
    for (LitheCount s = L->active[i] * n; s < (L->active[i] + 1) * n; s++)
      for (int a = 0; a < L->grid->dim; a++) {
        double want = L->level->state[a][s] == LTH_UNKNOWN_FREE ? b[a][s] / y[a][s] : 0;
        CHECK_NEAR(fast_at(L, L->x, a, s), want, 1e-6 * fabs(want));
      }
  }
  shape_vectors_free(&F->shape, u);
  shape_vectors_free(&F->shape, b);
  shape_vectors_free(&F->shape, y);
}

static void single_precision_rows_agree_on_every_level(void **state) {
  (void)state;
  for (int c = 0; c < N_CASES; c++) {
    Fixture F = fixture(&cases[c]);
    for (int k = 0; k < 2; k++) {
      CHECK_OK(F.ctx, lth_staggered_multigrid_prepare(F.ctx, F.M, 300 * k, 0.7));
      for (int isa = 0; isa < LTH_N_ISAS && take_kernels(&F, isa); isa++)
        for (int l = 0; l < F.M->n_levels; l++) check_level(&F, l, 300 * k, 0.7);
    }
    fixture_free(&F);
  }
}

static void check_transfer(Fixture *F, int l) {
  LthFastLevel *L = &F->M->level[l], *C = &F->M->level[l + 1];
  const LthFastKernels *k = L->kernels;
  double *u[3], *r[3], *Pu[3], *Rr[3];
  uint64_t seed = 13;
  shape_vectors(&F->shape, L->grid, r);
  shape_vectors(&F->shape, L->grid, Pu);
  shape_vectors(&F->shape, C->grid, u);
  shape_vectors(&F->shape, C->grid, Rr);
  randomise(C->level, &seed, true, u);
  randomise(L->level, &seed, true, r);
  lth_staggered_prolong_ref(F->ctx, C->level, L->level, (const double *const *)u, Pu);
  lth_staggered_restrict_ref(F->ctx, C->level, L->level, (const double *const *)r, Rr);
  lth_fast_level_clear(F->ctx, L);
  lth_fast_level_clear(F->ctx, C);
  to_fast(C, C->x, u);
  to_fast(L, L->b, r);
  for (LitheIndex b = 0; b < C->grid->n_blocks; b++) k->prolong_from(L, C, b, true);
  for (LitheIndex i = 0; i < L->n_active; i++) k->weigh(L, L->active[i]);
  for (LitheIndex i = 0; i < C->n_active; i++) k->restrict_to(L, C, C->active[i]);
  for (LitheCount s = 0; s < L->grid->n_slots; s++)
    for (int a = 0; a < L->grid->dim; a++) CHECK_NEAR(fast_at(L, L->x, a, s), Pu[a][s], 1e-6);
  for (LitheCount s = 0; s < C->grid->n_slots; s++)
    for (int a = 0; a < L->grid->dim; a++)
      if (C->level->state[a][s] == LTH_UNKNOWN_FREE)
        CHECK_NEAR(fast_at(C, C->b, a, s), Rr[a][s], 1e-5);
  shape_vectors_free(&F->shape, r);
  shape_vectors_free(&F->shape, Pu);
  shape_vectors_free(&F->shape, u);
  shape_vectors_free(&F->shape, Rr);
}

static void fast_transfers_are_the_plain_ones(void **state) {
  (void)state;
  for (int c = 0; c < N_CASES; c++) {
    Fixture F = fixture(&cases[c]);
    CHECK_OK(F.ctx, lth_staggered_multigrid_prepare(F.ctx, F.M, 0, 1));
    for (int isa = 0; isa < LTH_N_ISAS && take_kernels(&F, isa); isa++)
      for (int l = 0; l + 1 < F.M->n_levels; l++) check_transfer(&F, l);
    fixture_free(&F);
  }
}

/// Rows that the coarsest level's matrix is made of.
static void rows_are_those_of_the_operator(void **state) {
  (void)state;
  for (int c = 0; c < N_CASES; c++) {
    Fixture F = fixture(&cases[c]);
    const LthStaggeredLevel *l = &F.shape.level;
    double *u[3], *y[3];
    uint64_t seed = 17;
    shape_vectors(&F.shape, l->grid, u);
    shape_vectors(&F.shape, l->grid, y);
    randomise(l, &seed, false, u);
    lth_staggered_apply_ref(F.ctx, l, 3, 2, (const double *const *)u, y);
    double scale = largest(l->grid, y);
    for (int a = 0; a < l->grid->dim; a++)
      for (LitheCount s = 0; s < l->grid->n_slots; s++) {
        if (l->state[a][s] != LTH_UNKNOWN_FREE) continue;
        LthStaggeredEntry entry[LTH_STAGGERED_ROW];
        int n = lth_staggered_row(l, 3, 2, a, s, entry);
        double sum = 0;
        for (int e = 0; e < n; e++) sum += entry[e].value * u[entry[e].b][entry[e].slot];
        CHECK_NEAR(sum, y[a][s], 2e-15 * 10 * scale);
      }
    shape_vectors_free(&F.shape, u);
    shape_vectors_free(&F.shape, y);
    fixture_free(&F);
  }
}

static void uniform_blocks_are_found(void **state) {
  (void)state;
  Fixture F = fixture(&cases[3]);
  LitheIndex uniform = 0;
  for (LitheIndex b = 0; b < F.shape.grid->n_blocks; b++)
    uniform += F.M->level[0].kind[b] == LTH_BLOCK_UNIFORM;
  assert_true(uniform >= 27);
  fixture_free(&F);
}

/// Samples of every slot, before and after rows that are alike are kept once.
/// Samples of two levels on grids alike differ by a few roundings at most (0: not at all), states not at all.
static void check_samples(const LthStaggeredLevel *l, const LthStaggeredLevel *p, double most) {
  const double *one[] = {l->mu,       l->lambda,  l->volume,  l->shear[0], l->shear[1],
                         l->shear[2], l->mass[0], l->mass[1], l->mass[2]};
  const double *other[] = {p->mu,       p->lambda,  p->volume,  p->shear[0], p->shear[1],
                           p->shear[2], p->mass[0], p->mass[1], p->mass[2]};
  assert_int_equal(l->grid->n_slots, p->grid->n_slots);
  for (size_t v = 0; v < sizeof one / sizeof *one; v++)
    for (LitheCount s = 0; one[v] && s < l->grid->n_slots; s++) {
      const double want = lth_level_value(p, other[v], s);
      CHECK_NEAR(lth_level_value(l, one[v], s), want, most * fabs(want));
    }
  for (int a = 0; a < l->grid->dim; a++)
    assert_memory_equal(l->state[a], p->state[a], (size_t)l->grid->n_slots);
}

static void packed_levels_hold_the_same_samples(void **state) {
  (void)state;
  for (int c = 0; c < N_CASES; c++) {
    Fixture F = fixture(&cases[c]);
    ShapeLevel plain = shape_level(F.ctx, &cases[c]);
    check_samples(&F.shape.level, &plain.level, 0);
    if (c == 3)
      assert_true(F.shape.level.n_rows < plain.level.n_rows / 20); // a brick of one material
    shape_free(&plain);
    fixture_free(&F);
  }
}

/// Rows of packed levels that are alike are not averaged again.
static void packed_levels_are_coarsened_as_others_are(void **state) {
  (void)state;
  for (int c = 0; c < N_CASES; c++) {
    Fixture F = fixture(&cases[c]);
    ShapeLevel plain = shape_level(F.ctx, &cases[c]);
    const LthStaggeredLevel *fine[2] = {&F.shape.level, &plain.level};
    LthStaggeredLevel coarse[2] = {0};
    LthSparseGrid *grid[2];
    for (int k = 0; k < 2; k++)
      CHECK_OK(F.ctx, lth_staggered_coarsen(F.ctx, fine[k], &grid[k], &coarse[k]));
    check_samples(&coarse[0], &coarse[1], 4e-16);
    for (int k = 0; k < 2; k++) {
      lth_staggered_level_free(F.ctx, &coarse[k]);
      lth_sparse_grid_destroy(F.ctx, &grid[k]);
    }
    shape_free(&plain);
    fixture_free(&F);
  }
}

/// Rows of slots are in vectors if and only if some unknown of theirs is alive.
static void vectors_hold_rows_that_are_alive(void **state) {
  (void)state;
  for (int c = 0; c < N_CASES; c++) {
    Fixture F = fixture(&cases[c]);
    const LthFastLevel *L = &F.M->level[0];
    LitheIndex last = 0;
    for (LitheCount row = 0; row < L->grid->n_slots / L->grid->side; row++) {
      bool alive = false;
      for (int a = 0; a < L->grid->dim; a++)
        for (LitheCount s = row * L->grid->side; s < (row + 1) * L->grid->side; s++)
          alive |= F.shape.level.state[a][s] != LTH_UNKNOWN_DEAD;
      assert_int_equal(L->row[row], alive ? last + 1 : 0);
      last += alive;
    }
    assert_int_equal(L->n_rows, last + 1);
    fixture_free(&F);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(matrix_free_operator_is_the_plain_one_to_rounding),
      cmocka_unit_test(single_precision_rows_agree_on_every_level),
      cmocka_unit_test(fast_transfers_are_the_plain_ones),
      cmocka_unit_test(rows_are_those_of_the_operator),
      cmocka_unit_test(uniform_blocks_are_found),
      cmocka_unit_test(packed_levels_hold_the_same_samples),
      cmocka_unit_test(packed_levels_are_coarsened_as_others_are),
      cmocka_unit_test(vectors_hold_rows_that_are_alive),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
