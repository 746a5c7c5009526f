/// Pieces of a solid's surface in one tetrahedron: vertices where their fields are zero, and the inside on one side alone.
#include "ctx_fixture.h"

#include "base/tensor.h"
#include "geometry/sharp_cell.h"

#define N_FIELDS 5

/// Union of two balls, less the union of two others, cut with a fifth: any formula of five fields does.
static LthShape shapes[8];

static LthShape *five_fields(void) {
  for (int i = 0; i < N_FIELDS; i++)
    shapes[i] = (LthShape){.kind = LTH_SHAPE_SPHERE, .a = {2 * i, 0, 0}, .radius = 1};
  shapes[5] = (LthShape){.kind = LTH_SHAPE_UNION, .children = shapes, .n_children = 2};
  LthShape all = {.kind = LTH_SHAPE_DIFFERENCE, .children = shapes + 2, .n_children = 3};
  shapes[6] = all;
  shapes[7] = (LthShape){.kind = LTH_SHAPE_UNION, .children = shapes + 5, .n_children = 2};
  return &shapes[7];
}

static double value_at(const LthCell *c, int field, const double w[4]) {
  double value = 0;
  for (int k = 0; k < 4; k++) value += w[k] * c->value[field][k];
  return value;
}

static LthFieldSide side_at(const LthCell *c, const double w[4]) {
  LthFieldSide side[N_FIELDS];
  for (int i = 0; i < N_FIELDS; i++) side[i] = value_at(c, i, w) < 0 ? -1 : 1;
  return lth_solid_side(c->solid, side);
}

static void fill(LthCell *c, uint64_t *seed) {
  for (int i = 0; i < N_FIELDS; i++) {
    c->field[i] = i;
    do
      for (int k = 0; k < 4; k++) c->value[i][k] = test_random(seed) - 0.5;
    while ((c->value[i][0] < 0) == (c->value[i][1] < 0) &&
           (c->value[i][0] < 0) == (c->value[i][2] < 0) &&
           (c->value[i][0] < 0) == (c->value[i][3] < 0));
  }
  c->n = N_FIELDS;
}

static void check_vertices(const LthCell *c) {
  for (int v = 0; v < c->n_vertices; v++) {
    double sum = 0;
    for (int k = 0; k < 4; k++) {
      double w = c->vertex[v].weight[k];
      if (!(c->vertex[v].simplex >> k & 1)) CHECK_NEAR(w, 0, 0);
      CHECK_AT_LEAST(w, -1e-9);
      sum += w;
    }
    CHECK_NEAR(sum, 1, 1e-12);
    for (int i = 0; i < c->vertex[v].n; i++)
      CHECK_NEAR(value_at(c, c->vertex[v].field[i], c->vertex[v].weight), 0, 1e-10);
  }
}

/// A little off the middle of a piece, on either side of it.
static void check_piece(const LthCell *c, const LthCellPiece *p) {
  double middle[4] = {0}, step[4], mean = 0, rise = 0;
  for (int v = 0; v < p->n; v++)
    for (int k = 0; k < 4; k++) middle[k] += c->vertex[p->vertex[v]].weight[k] / p->n;
  for (int k = 0; k < 4; k++) mean += c->value[p->field][k] / 4;
  for (int k = 0; k < 4; k++) step[k] = c->value[p->field][k] - mean;
  for (int k = 0; k < 4; k++) rise += step[k] * c->value[p->field][k];
  for (int i = 0; i < N_FIELDS; i++) // other fields may be nearer than the step
    if (i != p->field && fabs(value_at(c, i, middle)) < 1e-6) return;
  for (int positive = 0; positive < 2; positive++) {
    double at[4];
    for (int k = 0; k < 4; k++) at[k] = middle[k] + (positive ? 1e-8 : -1e-8) / rise * step[k];
    assert_int_equal(side_at(c, at), (positive != 0) == p->is_turned ? -1 : 1);
  }
}

static void pieces_part_inside_from_outside(void **state) {
  Fixture *f = *state;
  LthSolid *solid = NULL;
  LthFieldSide side[N_FIELDS];
  LthCell *c = calloc(1, sizeof *c);
  LitheIndex n_pieces = 0;
  uint64_t seed = 11;
  CHECK_OK(f->ctx, lth_solid_create(f->ctx, five_fields(), &solid));
  assert_int_equal(solid->n_fields, N_FIELDS);
  c->solid = solid;
  c->side = side;
  for (int trial = 0; trial < 2000; trial++) {
    fill(c, &seed);
    c->is_odd = trial % 2;
    assert_true(lth_cell_surface(c));
    check_vertices(c);
    for (int p = 0; p < c->n_pieces; p++)
      if (c->piece[p].is_kept && c->piece[p].n <= 4) check_piece(c, &c->piece[p]), n_pieces++;
  }
  CHECK_AT_LEAST(n_pieces, 2000);
  lth_solid_destroy(f->ctx, &solid);
  free(c);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, setup, teardown)

int main(void) {
  const struct CMUnitTest tests[] = {TEST(pieces_part_inside_from_outside)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
