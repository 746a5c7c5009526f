/// Slicing random solids by random planes, many of them through vertices, edges and faces.
#include "check.h"
#include "mesh/mesh.h"
#include "slice_checks.h"
#include "solids.h"

#include <float.h>
#include <time.h>

static uint64_t seed;

static int random_int(int n) { return (int)(n * test_random(&seed)); }

static void random_rotation(double R[9]) {
  solid_rotation(test_random(&seed) - 0.5, test_random(&seed) - 0.5, test_random(&seed) - 0.5,
                 6 * test_random(&seed), R);
}

/// A tetrahedron with corners on a lattice; half of them with a coordinate in common.
static LthSurface *lattice_tetrahedron(LitheCtx *ctx, int n, double step) {
  for (;;) {
    LthSurface *s = solid_new(ctx, 4, 4);
    LitheIndex tris[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    memcpy(s->tris, tris, sizeof tris);
    for (int i = 0; i < 12; i++) s->points[i] = step * random_int(n);
    if (random_int(2)) {
      int axis = random_int(3);
      for (int i = 0; i < 3; i++) s->points[3 * i + axis] = s->points[axis];
    }
    double volume = solid_volume(s);
    if (volume < 0) solid_flip(s);
    if (fabs(volume) > 1e-6 * step * step * step) return s;
    solid_free(ctx, &s);
  }
}

/// Convex solids meet each cell in one piece at most.
static void check_one_element_a_cell(const LthMesh *m, const LthGrid *g) {
  char *seen = calloc((size_t)(g->cells[0] * g->cells[1] * g->cells[2]), 1);
  for (LitheIndex c = 0; c < m->n_cells; c++) {
    LitheIndex at[3];
    for (int a = 0; a < 3; a++) {
      at[a] = 0;
      while (at[a] + 1 < g->cells[a] &&
             m->cell_centroid[3 * c + a] > lth_grid_plane(g, a, at[a] + 1))
        at[a]++;
    }
    LitheIndex cell = at[0] + g->cells[0] * (at[1] + g->cells[1] * at[2]);
    assert_int_equal(seen[cell], 0);
    seen[cell] = 1;
  }
  free(seen);
}

static void tetrahedra_on_lattices(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  for (int i = 0; i < 300; i++) {
    double step = i % 3 == 0 ? 1 : i % 3 == 1 ? 0.5 : 1.0 / 3;
    LthSurface *s = lattice_tetrahedron(ctx, 5, step);
    LthGrid g = {{0, 0, 0}, {4 * step, 4 * step, 4 * step}, {4, 4, 4}};
    for (int a = 0; a < 3; a++) g.cells[a] = 1 + random_int(5);
    LthMesh *m = NULL;
    CHECK_OK(ctx, lth_mesh_slice(ctx, s, &g, 0, &m));
    check_sliced(ctx, s, m, 1);
    check_cell_volumes(s, &g, m, 1e-11);
    check_one_element_a_cell(m, &g);
    lth_mesh_destroy(ctx, &m);
    solid_free(ctx, &s);
  }
  lithe_ctx_destroy(&ctx);
}

/// True if cubes touch in an edge only: their surface would not be a manifold there.
static bool has_bad_edge(const char *full, const int n[3]) {
  for (int axis = 0; axis < 3; axis++) {
    int u = (axis + 1) % 3, v = (axis + 2) % 3, step[3] = {1, n[0], n[0] * n[1]}, x[3];
    for (x[2] = 0; x[2] < n[2]; x[2]++)
      for (x[1] = 0; x[1] < n[1]; x[1]++)
        for (x[0] = 0; x[0] < n[0]; x[0]++) {
          if (x[u] + 1 == n[u] || x[v] + 1 == n[v]) continue;
          const char *f = full + x[0] + n[0] * (x[1] + n[1] * x[2]);
          bool a = f[0], b = f[step[u]], c = f[step[v]], d = f[step[u] + step[v]];
          if (a == d && b == c && a != b) return true;
        }
  }
  return false;
}

/// Number of sets of cubes that hang together by faces without leaving their block of cubes.
static int count_pieces(const char *full, const int n[3], const int block[3]) {
  int total = n[0] * n[1] * n[2], pieces = 0, *stack = calloc((size_t)total, sizeof *stack);
  char *seen = calloc((size_t)total, 1);
  for (int start = 0; start < total; start++) {
    if (!full[start] || seen[start]) continue;
    int top = 0;
    pieces++;
    stack[top++] = start;
    seen[start] = 1;
    while (top > 0) {
      int c = stack[--top], x[3] = {c % n[0], c / n[0] % n[1], c / n[0] / n[1]};
      for (int k = 0; k < 6; k++) {
        int a = k / 2, y[3] = {x[0], x[1], x[2]};
        y[a] += k % 2 ? 1 : -1;
        if (y[a] < 0 || y[a] >= n[a] || y[a] / block[a] != x[a] / block[a]) continue;
        int d = y[0] + n[0] * (y[1] + n[1] * y[2]);
        if (!full[d] || seen[d]) continue;
        seen[d] = 1;
        stack[top++] = d;
      }
    }
  }
  free(stack);
  free(seen);
  return pieces;
}

static void unions_of_cubes(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  int n[3] = {4, 4, 3};
  for (int i = 0; i < 100; i++) {
    char full[48] = {0};
    double density = 0.3 + 0.6 * test_random(&seed);
    for (int j = 0; j < 48; j++) full[j] = test_random(&seed) < density;
    for (int tries = 0; has_bad_edge(full, n); tries++) full[random_int(48)] = 1;
    int any = 0;
    for (int j = 0; j < 48; j++) any |= full[j];
    if (!any) continue;
    LthSurface *s = solid_cubes(ctx, full, n[0], n[1], n[2]);
    int block[3];
    LthGrid g = {{0, 0, 0}, {4, 4, 4}, {1, 1, 1}};
    for (int a = 0; a < 3; a++) {
      block[a] = 1 << random_int(3);
      g.cells[a] = 4 / block[a];
    }
    if (i % 3 == 1) solid_move(s, NULL, 0.1, NULL);
    for (int a = 0; a < 3 && i % 3 == 1; a++) g.max[a] *= 0.1;

    // faces that miss their planes by rounding lie in them
    for (LitheIndex j = 0; j < 3 * s->n_points && i % 3 == 2; j++)
      s->points[j] += 4 * DBL_EPSILON * (random_int(9) - 4);
    LthMesh *m = NULL;
    CHECK_OK(ctx, lth_mesh_slice(ctx, s, &g, 0, &m));
    check_sliced(ctx, s, m, 1);
    assert_int_equal(m->n_cells, count_pieces(full, n, block));
    lth_mesh_destroy(ctx, &m);

    double R[9];
    random_rotation(R);
    solid_move(s, R, 1, NULL);
    solid_bounds(s, g.min, g.max);
    CHECK_OK(ctx, lth_mesh_slice(ctx, s, &g, 0.3 * test_random(&seed), &m));
    check_sliced(ctx, s, m, 1);
    lth_mesh_destroy(ctx, &m);
    solid_free(ctx, &s);
  }
  lithe_ctx_destroy(&ctx);
}

static LthSurface *random_round_solid(LitheCtx *ctx) {
  double R[9];
  LthSurface *s = NULL;
  switch (random_int(4)) {
  case 0:
    s = solid_sphere(ctx, 1 + random_int(6));
    break;
  case 1:
    s = solid_torus(ctx, 1, 0.1 + 0.8 * test_random(&seed), 3 + random_int(12), 3 + random_int(9));
    break;
  case 2:
    s = solid_star(ctx, 3 + random_int(6), 0.1 + 0.5 * test_random(&seed), 1,
                   test_random(&seed) + 0.05);
    break;
  default:
    s = solid_sphere(ctx, 2 + random_int(4));
    s = solid_join(ctx, s, solid_flip(solid_move(solid_sphere(ctx, 3), NULL, 0.5, NULL)));
    break;
  }
  if (random_int(3) > 0) {
    random_rotation(R);
    solid_move(s, R, 1, NULL);
  }
  return random_int(3) ? s
                       : solid_stretch(s, 1, 0.1 + test_random(&seed), 0.05 + test_random(&seed));
}

static void round_solids(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  for (int i = 0; i < 150; i++) {
    LthSurface *s = random_round_solid(ctx);
    LthGrid g;
    solid_bounds(s, g.min, g.max);

    // every third grid goes through the first point, others may leave parts of the solid outside
    for (int a = 0; a < 3; a++) {
      g.cells[a] = 1 + random_int(5);
      if (i % 3 == 0) g.min[a] = s->points[a], g.max[a] = g.min[a] + 1 + test_random(&seed);
      if (i % 3 == 1) g.min[a] -= test_random(&seed), g.max[a] += test_random(&seed);
    }
    LthMesh *m = NULL;
    CHECK_OK(ctx, lth_mesh_slice(ctx, s, &g, 0, &m));
    check_sliced(ctx, s, m, 1);
    check_cell_volumes(s, &g, m, 1e-11);
    lth_mesh_destroy(ctx, &m);
    solid_free(ctx, &s);
  }
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const char *fixed = getenv("LITHE_TEST_SEED");
  seed = fixed ? strtoull(fixed, NULL, 10) : (uint64_t)time(NULL);
  printf("LITHE_TEST_SEED=%llu\n", (unsigned long long)seed);
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(tetrahedra_on_lattices),
      cmocka_unit_test(unions_of_cubes),
      cmocka_unit_test(round_solids),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
