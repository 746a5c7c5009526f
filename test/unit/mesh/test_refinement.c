/// Divided cells come back, whatever happened to others; those that were cut do not.
#include "topology_ops.h"

#include "mesh/refinement.h"

static uint64_t seed = 11;

typedef struct Body {
  LitheCtx *ctx;
  LthTopology *t;
  LthRefinement r;
  uint8_t level[10000]; ///< by record
} Body;

static void take(Body *b, int solid) {
  *b = (Body){.ctx = test_ctx()};
  LthMesh *mesh = topology_solid(b->ctx, solid);
  CHECK_OK(b->ctx, lth_topology_create(b->ctx, mesh, &b->t));
  lth_mesh_destroy(b->ctx, &mesh);
}

static void end(Body *b) {
  CHECK_OK(b->ctx, lth_topology_check(b->ctx, b->t, 0, NULL));
  lth_topology_destroy(b->ctx, &b->t);
  lth_refinement_free(b->ctx, &b->r);
  assert_int_equal(lth_alloc_bytes(b->ctx), 0);
  lithe_ctx_destroy(&b->ctx);
}

static void forget(Body *b) {
  CHECK_OK(b->ctx, lth_refinement_follow(b->ctx, &b->r, b->t));
  CHECK_OK(b->ctx, lth_topology_forget(b->ctx, b->t));
}

/// Divide a cell and give its parts their level; returns how many there are.
static int divide(Body *b, LitheIndex cell, LthDivision division) {
  LthSplit split;
  double normal[3];
  int n = 0;
  topology_direction(&seed, normal);
  uint8_t level = b->level[cell];
  CHECK_OK(b->ctx,
           lth_refinement_divide(b->ctx, &b->r, b->t, cell, level, division, normal, &split));
  for (LitheIndex i = split.first; i < b->t->log.n_births; i++) {
    LitheIndex part = b->t->log.births[i].cell;
    if (!b->t->cells[part].is_live) continue;
    b->level[part] = (uint8_t)(level + 1);
    n++;
  }
  return n;
}

/// Merge every family that can be; returns how many.
static int merge_all(Body *b) {
  LitheIndex *off = NULL, *list = NULL, n_families = b->r.n_families;
  int n = 0;
  CHECK_OK(b->ctx, lth_refinement_list(b->ctx, &b->r, b->t, &off, &list));
  for (LitheIndex f = 0; f < n_families; f++) {
    LitheIndex count = off[f + 1] - off[f], merged = -1;
    bool may;
    CHECK_OK(b->ctx, lth_refinement_may_merge(b->ctx, &b->r, b->t, list + off[f], count, &may));
    if (!may) continue;
    uint8_t level = b->r.families[f].level;
    CHECK_OK(b->ctx, lth_refinement_merge(b->ctx, &b->r, b->t, f, list + off[f], &merged));
    b->level[merged] = level;
    n++;
  }
  lth_free(b->ctx, off);
  lth_free(b->ctx, list);
  forget(b);
  return n;
}

/// Whatever is divided, in whatever order, merging brings the first cells back.
static void divided_cells_come_back(void **state) {
  (void)state;
  for (int solid = 0; solid < TOPOLOGY_SOLIDS; solid++) {
    static Body b;
    take(&b, solid);
    LitheIndex first = b.t->n_live_cells;
    double volume[64];
    assert_true(first <= 64);
    for (LitheIndex c = 0; c < first; c++) volume[c] = b.t->cells[c].volume;
    int n_divided = 0;
    for (int i = 0; i < 12; i++) {
      n_divided += divide(&b, topology_random_cell(b.t, &seed),
                          i % 2 ? LTH_DIVIDE_EIGHT : LTH_DIVIDE_TWO) > 0;
      if (i % 4 == 3) forget(&b);
    }
    assert_true(n_divided >= 11);
    forget(&b);
    assert_true(b.t->n_live_cells > first + 30);
    for (int n; (n = merge_all(&b)) > 0;) n_divided -= n;
    assert_int_equal(n_divided, 0);
    assert_int_equal(b.t->n_live_cells, first);
    double sum = 0, want = 0;
    for (LitheIndex c = 0; c < b.t->n_cells; c++) {
      if (!b.t->cells[c].is_live) continue;
      assert_int_equal(b.level[c], 0);
      assert_int_equal(lth_refinement_family(&b.r, c), -1);
      sum += b.t->cells[c].volume * b.t->cells[c].volume;
    }
    for (LitheIndex c = 0; c < first; c++) want += volume[c] * volume[c];
    CHECK_NEAR(sum, want, 1e-12 * want);
    for (LitheIndex f = 0; f < b.r.n_families; f++) assert_int_equal(b.r.families[f].n, 0);
    end(&b);
  }
}

static LitheIndex first_alive(const Body *b, int level) {
  for (LitheIndex c = 0; c < b->t->n_cells; c++)
    if (b->t->cells[c].is_live && b->level[c] == level) return c;
  return -1;
}

/// A cube is divided twice; one of the smallest is cut: its family and the one around it stay apart, others come back.
static void a_cut_breaks_the_families_around_it_alone(void **state) {
  (void)state;
  static Body b;
  take(&b, 0);
  assert_int_equal(divide(&b, 0, LTH_DIVIDE_EIGHT), 8);
  assert_int_equal(divide(&b, 1, LTH_DIVIDE_EIGHT), 8);
  LitheIndex one = first_alive(&b, 1);
  assert_int_equal(divide(&b, one, LTH_DIVIDE_EIGHT), 8);
  forget(&b);
  LthPlane p = {.normal = {0.3, 0.5, 0.8}};
  LthSplit split;
  LitheIndex smallest = first_alive(&b, 2);
  lth_v3_copy(b.t->cells[smallest].centroid, p.point);
  CHECK_OK(b.ctx, lth_topology_split(b.ctx, b.t, smallest, &p, LTH_TAG_CUT, &split));
  for (LitheIndex i = 0; i < split.n; i++) b.level[b.t->log.births[split.first + i].cell] = 2;
  forget(&b);
  assert_int_equal(merge_all(&b), 1);
  assert_int_equal(merge_all(&b), 0);
  assert_int_equal(b.t->n_live_cells, 7 + 7 + 7 + 2);
  end(&b);
}

/// Both halves of a cut cell are divided as other cells are, and each comes back; the two never become one.
static void parts_beside_a_cut_do_not_merge_across_it(void **state) {
  (void)state;
  static Body b;
  take(&b, 0);
  LthPlane p = {{0.3, 0.2, 0.25}, {0.6, 0.8, 0}};
  topology_cut_all(b.ctx, b.t, &p, LTH_TAG_CUT);
  forget(&b);
  LitheIndex before = b.t->n_live_cells;
  for (int i = 0; i < 6; i++) divide(&b, topology_random_cell(b.t, &seed), LTH_DIVIDE_EIGHT);
  while (merge_all(&b) > 0) {
  }
  assert_int_equal(b.t->n_live_cells, before);
  end(&b);
}

/// Small parts go to a sibling, and the family still comes back.
static void slivers_go_to_siblings(void **state) {
  (void)state;
  for (int solid = 2; solid < TOPOLOGY_SOLIDS; solid += 6) {
    static Body b;
    take(&b, solid);
    LitheIndex first = b.t->n_live_cells, n_slivers = 0;
    for (LitheIndex c = 0; c < first; c++) divide(&b, c, LTH_DIVIDE_EIGHT);
    LitheIndex parts = b.t->n_live_cells;
    CHECK_OK(b.ctx,
             lth_refinement_merge_slivers(b.ctx, &b.r, b.t, 0, LTH_DIVIDE_EIGHT, 0.4, &n_slivers));
    assert_true(n_slivers > 0);
    assert_int_equal(b.t->n_live_cells, parts - n_slivers);
    forget(&b);
    assert_int_equal(merge_all(&b), first);
    assert_int_equal(b.t->n_live_cells, first);
    end(&b);
  }
}

/// A refinement goes through an archive: what is merged afterwards is the same.
static void an_archive_holds_the_families(void **state) {
  (void)state;
  static Body b;
  take(&b, 0);
  divide(&b, 0, LTH_DIVIDE_EIGHT);
  divide(&b, first_alive(&b, 1), LTH_DIVIDE_TWO);
  forget(&b);
  LthArchive archive = {0};
  lth_archive_begin(&archive, b.ctx);
  lth_refinement_archive(b.ctx, &b.r, &archive);
  assert_int_equal(archive.status, LITHE_OK);
  LthArchive in = {0};
  lth_refinement_free(b.ctx, &b.r);
  lth_archive_open(&in, b.ctx, archive.data, archive.size);
  lth_refinement_archive(b.ctx, &b.r, &in);
  assert_int_equal(in.status, LITHE_OK);
  lth_archive_free(b.ctx, &archive);
  assert_int_equal(merge_all(&b) + merge_all(&b), 2);
  assert_int_equal(b.t->n_live_cells, 8);
  end(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(divided_cells_come_back),
      cmocka_unit_test(a_cut_breaks_the_families_around_it_alone),
      cmocka_unit_test(parts_beside_a_cut_do_not_merge_across_it),
      cmocka_unit_test(slivers_go_to_siblings),
      cmocka_unit_test(an_archive_holds_the_families),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
