/// Levels and transfers of the staggered multigrid: what P keeps, R = P^T, rule A on every level, thin features.
#include "disc/staggered/staggered_walls.h"
#include "staggered_body.h"
#include "staggered_shape.h"

static const ShapeDef ring = {
    .dim = 2, .n = 96, .inside = ring_inside, .held = ring_held, .nu = 0.3, .rho = 2};
static const ShapeDef ball = {
    .dim = 3, .n = 32, .inside = ball_inside, .held = ball_held, .nu = 0.3, .rho = 2};

typedef struct Levels {
  ShapeLevel shape;
  LthStaggeredHierarchy *H;
} Levels;

static Levels levels_of(const ShapeDef *def, LitheCount enough) {
  Levels L = {0};
  LitheCtx *ctx = test_ctx();
  L.shape = shape_level(ctx, def);
  lth_free(ctx, L.shape.level.volume); // plain interpolation
  L.shape.level.volume = NULL;
  LthCoarsenDef coarsen = {.enough = enough};
  CHECK_OK(ctx, lth_staggered_hierarchy_create(ctx, &L.shape.level, &coarsen, &L.H));
  return L;
}

static void levels_free(Levels *L) {
  LitheCtx *ctx = L->shape.ctx;
  lth_staggered_hierarchy_destroy(ctx, &L->H);
  shape_free(&L->shape);
  lithe_ctx_destroy(&ctx);
}

/// u_a = c_a + sum_b g_ab x_b at the unknowns of a level that are not dead.
static void set_linear(const LthStaggeredLevel *l, const double c[3], const double g[3][3],
                       double *u[3]) {
  for (int a = 0; a < l->grid->dim; a++)
    for (LitheCount s = 0; s < l->grid->n_slots; s++) {
      LitheIndex cell[3];
      double at[3] = {0.5, 0.5, 0.5}, x[3];
      lth_sparse_grid_cell(l->grid, s, cell);
      at[a] = 0;
      lth_sparse_grid_place(l->grid, cell, at, x);
      u[a][s] = c[a];
      for (int b = 0; b < l->grid->dim; b++) u[a][s] += g[a][b] * x[b];
    }
}

static bool any_is_held(const LthStaggeredLevel *l, int a, int n, const LitheCount slot[8]) {
  bool any = false;
  for (int i = 0; i < n; i++) any |= l->state[a][slot[i]] == LTH_UNKNOWN_HELD;
  return any;
}

static void check_prolong(const ShapeDef *def) {
  Levels L = levels_of(def, 0);
  LthStaggeredLevel *f = &L.H->level[0], *k = &L.H->level[1];
  const double c[3] = {1, -2, 3}, zero[3][3] = {{0}},
               g[3][3] = {{1, 2, 3}, {-1, 4, 2}, {0.5, 1, -3}};
  double *fine[3], *coarse[3], *exact[3];
  shape_vectors(&L.shape, f->grid, fine);
  shape_vectors(&L.shape, f->grid, exact);
  shape_vectors(&L.shape, k->grid, coarse);
  for (int linear = 0; linear < 2; linear++) {
    set_linear(k, c, linear ? g : zero, coarse);
    set_linear(f, c, linear ? g : zero, exact);
    lth_staggered_prolong_ref(L.shape.ctx, k, f, (const double *const *)coarse, fine);
    LitheCount n_full = 0;
    for (int a = 0; a < def->dim; a++)
      for (LitheCount s = 0; s < f->grid->n_slots; s++) {
        if (f->state[a][s] != LTH_UNKNOWN_FREE) continue;
        LitheIndex cell[3];
        LitheCount slot[8];
        double weight[8];
        lth_sparse_grid_cell(f->grid, s, cell);
        int n = lth_staggered_parents(k, f, 0, a, cell, slot, weight);
        bool full = n == (cell[a] & 1 ? 2 : 1) << (def->dim - 1);
        if (any_is_held(k, a, n, slot)) continue; // the next test
        n_full += full;
        if (!linear || full) CHECK_NEAR(fine[a][s], exact[a][s], 1e-14 * 10);
      }
    assert_true(n_full > L.H->n_free[0] / 2);
  }
  shape_vectors_free(&L.shape, fine);
  shape_vectors_free(&L.shape, exact);
  shape_vectors_free(&L.shape, coarse);
  levels_free(&L);
}

static void prolongation_keeps_constants_up_to_walls_and_linear_fields_inside(void **state) {
  (void)state;
  check_prolong(&ring);
  check_prolong(&ball);
}

/// In fine cells; 0 where nothing held is near.
static void set_distance(const LthStaggeredLevel *l, double cells, double *const u[3]) {
  for (int a = 0; a < l->grid->dim; a++)
    for (LitheCount s = 0; s < l->grid->n_slots; s++) {
      LitheIndex cell[3];
      lth_sparse_grid_cell(l->grid, s, cell);
      if (l->state[a][s] == LTH_UNKNOWN_FREE)
        u[a][s] = cells * lth_staggered_wall_distance(l, a, cell);
    }
}

static void prolongation_keeps_the_distance_from_a_wall(void **state) {
  (void)state;
  for (int deep = 0; deep < 2; deep++) {
    Levels L = levels_of(deep ? &ball : &ring, 0);
    LthStaggeredLevel *f = &L.H->level[0], *k = &L.H->level[1];
    double *fine[3], *coarse[3], *exact[3];
    shape_vectors(&L.shape, f->grid, fine);
    shape_vectors(&L.shape, f->grid, exact);
    shape_vectors(&L.shape, k->grid, coarse);
    set_distance(k, 2, coarse);
    set_distance(f, 1, exact);
    lth_staggered_prolong_ref(L.shape.ctx, k, f, (const double *const *)coarse, fine);
    LitheCount n_beside = 0;
    for (int a = 0; a < f->grid->dim; a++)
      for (LitheCount s = 0; s < f->grid->n_slots; s++) {
        if (f->state[a][s] != LTH_UNKNOWN_FREE) continue;
        LitheIndex cell[3];
        LitheCount slot[8];
        double weight[8];
        bool any = false, all = true;
        lth_sparse_grid_cell(f->grid, s, cell);
        int n = lth_staggered_parents(k, f, 0, a, cell, slot, weight);
        for (int i = 0; i < n; i++) {
          any |= k->state[a][slot[i]] == LTH_UNKNOWN_FREE;
          all &= k->state[a][slot[i]] != LTH_UNKNOWN_FREE || coarse[a][slot[i]] > 0;
        }
        if (!any || !all || exact[a][s] == 0 || !any_is_held(k, a, n, slot)) continue;
        CHECK_NEAR(fine[a][s], exact[a][s], 1e-14 * exact[a][s]);
        n_beside++;
      }
    assert_true(n_beside > 20);
    shape_vectors_free(&L.shape, fine);
    shape_vectors_free(&L.shape, exact);
    shape_vectors_free(&L.shape, coarse);
    levels_free(&L);
  }
}

static void randomise(const LthStaggeredLevel *l, uint64_t *seed, double *u[3]) {
  for (int a = 0; a < l->grid->dim; a++)
    for (LitheCount s = 0; s < l->grid->n_slots; s++)
      u[a][s] = l->state[a][s] == LTH_UNKNOWN_FREE ? 2 * test_random(seed) - 1 : 0;
}

static double product(const LthStaggeredLevel *l, double *const u[3], double *const v[3]) {
  double sum = 0;
  for (int a = 0; a < l->grid->dim; a++)
    for (LitheCount s = 0; s < l->grid->n_slots; s++) sum += u[a][s] * v[a][s];
  return sum;
}

static void check_adjoint(const ShapeDef *def) {
  Levels L = levels_of(def, 0);
  uint64_t seed = 7;
  for (int i = 0; i + 1 < L.H->n_levels; i++) {
    LthStaggeredLevel *f = &L.H->level[i], *k = &L.H->level[i + 1];
    double *rf[3], *pf[3], *uk[3], *rk[3];
    shape_vectors(&L.shape, f->grid, rf);
    shape_vectors(&L.shape, f->grid, pf);
    shape_vectors(&L.shape, k->grid, uk);
    shape_vectors(&L.shape, k->grid, rk);
    randomise(f, &seed, rf);
    randomise(k, &seed, uk);
    lth_staggered_prolong_ref(L.shape.ctx, k, f, (const double *const *)uk, pf);
    lth_staggered_restrict_ref(L.shape.ctx, k, f, (const double *const *)rf, rk);
    double scale = sqrt(product(f, rf, rf) * product(f, pf, pf));
    CHECK_NEAR(product(f, rf, pf), product(k, rk, uk), 1e-14 * scale);
    shape_vectors_free(&L.shape, rf);
    shape_vectors_free(&L.shape, pf);
    shape_vectors_free(&L.shape, uk);
    shape_vectors_free(&L.shape, rk);
  }
  levels_free(&L);
}

static void restriction_is_the_transpose_on_every_level(void **state) {
  (void)state;
  check_adjoint(&ring);
  check_adjoint(&ball);
}

/// Rule A, word by word, and that no mass is lost.
static void check_rules(const ShapeDef *def) {
  Levels L = levels_of(def, 0);
  assert_true(L.H->n_levels >= 3 && !L.H->stopped_thin);
  for (int i = 0; i < L.H->n_levels; i++) {
    LthStaggeredLevel *l = &L.H->level[i];
    const LthSparseGrid *g = l->grid;
    for (LitheCount s = 0; s < g->n_slots; s++) {
      LitheIndex c[3];
      lth_sparse_grid_cell(g, s, c);
      for (int a = 0; a < def->dim; a++) {
        LitheCount before = lth_sparse_grid_along(g, c, a, -1),
                   after = lth_sparse_grid_along(g, c, a, 1);
        bool touches = l->mu[s] > 0 || (before >= 0 && l->mu[before] > 0);
        if (l->state[a][s] != LTH_UNKNOWN_HELD)
          assert_int_equal(l->state[a][s], touches ? LTH_UNKNOWN_FREE : LTH_UNKNOWN_DEAD);
        if (l->state[a][s] == LTH_UNKNOWN_DEAD) assert_true(l->mass[a][s] == 0);
        if (l->mu[s] > 0) assert_true(after >= 0); // its high face has a slot
      }
    }
  }
  levels_free(&L);
}

static void rule_a_holds_on_every_level(void **state) {
  (void)state;
  check_rules(&ring);
  check_rules(&ball);
}

/// A square held on its left side: inner coefficients stay as they are, the held side stays held.
static bool square_inside(const double x[3]) {
  return x[0] > 0.125 && x[0] < 0.875 && x[1] > 0.125 && x[1] < 0.875;
}
static bool square_held(const double x[3]) { return x[0] <= 0.125 + 1e-9; }

static void uniform_material_stays_uniform(void **state) {
  (void)state;
  const ShapeDef square = {
      .dim = 2, .n = 64, .inside = square_inside, .held = square_held, .nu = 0.25, .rho = 3};
  Levels L = levels_of(&square, 100);
  for (int i = 0; i < L.H->n_levels; i++) {
    LthStaggeredLevel *l = &L.H->level[i];
    LitheIndex middle = ((64 >> i) + 2) / 2;
    LitheCount s = lth_sparse_grid_slot(l->grid, middle, middle, 0);
    CHECK_NEAR(l->mu[s], 0.4, 1e-15);
    CHECK_NEAR(l->lambda[s], 0.4, 1e-15);
    CHECK_NEAR(l->shear[2][s], 0.4, 1e-15);
    CHECK_NEAR(l->mass[0][s], 3, 1e-14);
    bool held = false;
    for (LitheIndex I = 0; I < middle; I++)
      held |= l->state[0][lth_sparse_grid_slot(l->grid, I, middle, 0)] == LTH_UNKNOWN_HELD;
    assert_true(held);
  }
  levels_free(&L);
}

/// A comb: teeth of an eighth, gaps of an eighth.
static bool comb_inside(const double x[3]) {
  if (x[0] < 0 || x[0] > 1 || x[1] < 0 || x[1] > 1) return false;
  return x[1] < 0.2 || fmod(x[0] * 4 + 0.01, 1) < 0.5;
}

static void coarsening_stops_where_features_have_three_cells(void **state) {
  (void)state;
  const ShapeDef comb = {.dim = 2, .n = 128, .inside = comb_inside, .nu = 0.3, .rho = 1};
  Levels L = levels_of(&comb, 10);
  assert_true(L.H->stopped_thin);
  assert_int_equal(L.H->n_levels, 3); // teeth of 16, 8, 4 cells
  levels_free(&L);
}

static void only_blocks_with_material_are_kept(void **state) {
  (void)state;
  Levels L = levels_of(&ball, 0);
  LthStaggeredLevel *l = &L.H->level[0];
  assert_true(l->grid->n_blocks <
              (LitheIndex)(l->grid->n_block[0] * l->grid->n_block[1] * l->grid->n_block[2]));
  levels_free(&L);
}

/// All of the box that is held lies behind n . x = c.
typedef struct Plane {
  double n[3], c;
} Plane;

static bool is_behind(const void *self, const double x[3]) {
  const Plane *p = self;
  return lth_v3_dot(p->n, x) <= p->c;
}

typedef struct Walled {
  Plane plane;
  LthStaggeredHold hold;
  SgBody b;
  LthStaggeredHierarchy *H;
} Walled;

/// A unit box of 16 cells a side; `w` keeps its place.
static void walled_create(Walled *w, int dim, Plane plane) {
  w->plane = plane;
  w->hold = (LthStaggeredHold){
      .selects = is_behind, .self = &w->plane, .fixed = {true, true, dim == 3}, .is_wall = true};
  SgDef def = {.dim = dim,
               .high = {1, 1, dim == 3 ? 1 : 0},
               .n = {16, 16, dim == 3 ? 16 : 1},
               .part = sg_full,
               .holds = &w->hold,
               .n_holds = 1};
  sg_create(&w->b, &def);
  LthCoarsenDef coarsen = {.enough = 1};
  CHECK_OK(w->b.ctx, lth_staggered_hierarchy_create(w->b.ctx, &w->b.s->level, &coarsen, &w->H));
  assert_true(w->H->n_levels >= 3);
}

static void walled_free(Walled *w) {
  lth_staggered_hierarchy_destroy(w->b.ctx, &w->H);
  sg_free(&w->b);
}

/// Where halving has found the wall to be, in cells of the finest level.
#define HALVED (1.0 / 1024)

static LitheCount check_distances(const LthStaggeredLevel *l, const Plane *p, double fine) {
  const LthSparseGrid *g = l->grid;
  LitheCount n = 0;
  for (int a = 0; a < g->dim; a++)
    for (LitheCount s = 0; s < g->n_slots; s++) {
      LitheIndex cell[3];
      double at[3] = {0.5, 0.5, 0.5}, x[3];
      if (l->state[a][s] != LTH_UNKNOWN_FREE) continue;
      at[a] = 0;
      lth_sparse_grid_cell(g, s, cell);
      lth_sparse_grid_place(g, cell, at, x);
      if (g->dim == 2) x[2] = 0;
      // ways along the axes that the plane cuts are alike
      const double most = fmax(fabs(p->n[0]), fabs(p->n[1]));
      const double before = (lth_v3_dot(p->n, x) - p->c) / g->h[0];
      if (before / most > 2 || before / most < 0.1) continue;
      bool inside =
          true; // the ways end in the box (slanting ones away from its sides), and nothing is held beside it
      const bool slants = p->n[0] * p->n[1] != 0;
      for (int b = 0; b < g->dim; b++) {
        if (p->n[b] != 0)
          inside &= x[b] > (ceil(before / p->n[b]) + (slants ? 1 : -0.1)) * g->h[0] && x[b] < 1;
        for (int k = -4; p->n[b] == 0 && k <= 4; k++)
          inside &= lth_level_state(l, a, lth_sparse_grid_along(g, cell, b, k)) != LTH_UNKNOWN_HELD;
      }
      if (!inside) continue;
      CHECK_NEAR(lth_staggered_wall_distance(l, a, cell), before / lth_v3_norm(p->n),
                 2 * HALVED * fine / g->h[0]);
      n++;
    }
  return n;
}

static void walls_are_where_they_are_on_every_level(void **state) {
  (void)state;
  const Plane plane[] = {
      {{0, 1, 0}, 0.16}, {{0, 1, 0}, 0.22}, {{1, 0, 0}, 0.27}, {{1, 1, 0}, 0.69}};
  for (int dim = 2; dim <= 3; dim++)
    for (int i = 0; i < 4; i++) {
      Walled w;
      walled_create(&w, dim, plane[i]);
      for (int l = 0; l < (i < 3 ? 3 : 2); l++)
        assert_true(check_distances(&w.H->level[l], &w.plane, w.H->level[0].grid->h[0]) > 0);
      walled_free(&w);
    }
}

/// Of u_y = the distance from a wall across y.
static double energy_before_wall(LitheCtx *ctx, const LthStaggeredLevel *l, double y0) {
  const LthSparseGrid *g = l->grid;
  double *u[3] = {NULL}, *y[3] = {NULL}, sum = 0;
  for (int a = 0; a < g->dim; a++) {
    u[a] = lth_alloc(ctx, g->n_slots, sizeof *u[a]);
    y[a] = lth_alloc(ctx, g->n_slots, sizeof *y[a]);
  }
  for (LitheCount s = 0; s < g->n_slots; s++) {
    LitheIndex cell[3];
    lth_sparse_grid_cell(g, s, cell);
    if (l->state[1][s] == LTH_UNKNOWN_FREE) u[1][s] = g->origin[1] + g->h[1] * cell[1] - y0;
  }
  lth_staggered_apply_ref(ctx, l, 0, 1, (const double *const *)u, y);
  for (LitheCount s = 0; s < g->n_slots; s++) sum += 0.5 * u[1][s] * y[1][s];
  for (int a = 0; a < g->dim; a++) lth_free(ctx, u[a]), lth_free(ctx, y[a]);
  return sum;
}

// At these places no coarse face beside the box is held where one in it is free, whose shear would count.
static void material_before_a_wall_is_as_stiff_on_every_level(void **state) {
  (void)state;
  const double place[] = {0.1, 0.11, 0.22, 0.23};
  for (int dim = 2; dim <= 3; dim++)
    for (int i = 0; i < 4; i++) {
      Walled w;
      walled_create(&w, dim, (Plane){{0, 1, 0}, place[i]});
      const double modulus = 1000 * 0.7 / (1.3 * 0.4); // 2 mu + lambda
      for (int l = 0; l < 3; l++)
        CHECK_NEAR(energy_before_wall(w.b.ctx, &w.H->level[l], place[i]) /
                       (0.5 * modulus * (1 - place[i])),
                   1, 2 * HALVED / 16 / (1 - place[i]));
      walled_free(&w);
    }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(prolongation_keeps_constants_up_to_walls_and_linear_fields_inside),
      cmocka_unit_test(prolongation_keeps_the_distance_from_a_wall),
      cmocka_unit_test(walls_are_where_they_are_on_every_level),
      cmocka_unit_test(material_before_a_wall_is_as_stiff_on_every_level),
      cmocka_unit_test(restriction_is_the_transpose_on_every_level),
      cmocka_unit_test(rule_a_holds_on_every_level),
      cmocka_unit_test(uniform_material_stays_uniform),
      cmocka_unit_test(coarsening_stops_where_features_have_three_cells),
      cmocka_unit_test(only_blocks_with_material_are_kept),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
