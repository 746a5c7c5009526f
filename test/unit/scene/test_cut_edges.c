/// Where blades end and where they bend: the elements that a facet reaches, no more and no less, and parts of a bent cut whose volumes
/// are known in closed form.
#include "base/tensor.h"
#include "cut_cube.h"
#include "mesh/topology.h"

#include <math.h>

#define CELLS 5
#define ROUNDING 1e-12 ///< of a length, an area and a volume of the unit cube

/// A corner of the path: x, y.
typedef double Corner[2];

static Cut make(int cells, const char *blade) {
  char text[1000];
  int n = snprintf(
      text, sizeof text,
      "lithe: 1\nbodies:\n  - name: cube\n    shape: {box: {min: [0, 0, 0], max: [1, 1, 1]}}\n"
      "    material: {young_modulus: 1e6, poisson_ratio: 0.3, density: 1000}\n"
      "    method: {kind: dg, mesh: hexahedra, cells: %d, degree: 1, sliver: 0}\n"
      "contact: {bodies: false}\ncuts: [{blade: {%s}}]\ntime: {kind: dynamic, duration: 1, step: "
      "0.1}\n",
      cells, blade);
  assert_true(n < (int)sizeof text);
  return cut_made(text, 0);
}

// --- ends ---

/// Is there a line along an edge of p that has q on its other side?
static bool is_apart(double p[][2], double q[][2]) {
  double turn =
      (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
  for (int i = 0; i < 4; i++) {
    const double *a = p[i], *b = p[(i + 1) % 4];
    double most = -1;
    for (int k = 0; k < 4; k++)
      most = fmax(most, copysign(1, turn) *
                            ((b[0] - a[0]) * (q[k][1] - a[1]) - (b[1] - a[1]) * (q[k][0] - a[0])));
    if (most <= ROUNDING) return true;
  }
  return false;
}

/// Squares of the middle section that a parallelogram has a part of.
static int count_reached(double corner[4][2]) {
  int n = 0;
  for (int j = 0; j < CELLS; j++)
    for (int k = 0; k < CELLS; k++) {
      double low[2] = {1.0 * j / CELLS, 1.0 * k / CELLS},
             high[2] = {1.0 * (j + 1) / CELLS, 1.0 * (k + 1) / CELLS};
      double square[4][2] = {
          {low[0], low[1]}, {high[0], low[1]}, {high[0], high[1]}, {low[0], high[1]}};
      n += !is_apart(corner, square) && !is_apart(square, corner);
    }
  return n;
}

/// A facet in the plane x = 0.5, through the middle of elements: from p to q, and d deep.
static void expect_reach(const double p[2], const double q[2], const double d[2]) {
  char blade[300];
  double corner[4][2] = {
      {p[0], p[1]}, {q[0], q[1]}, {q[0] + d[0], q[1] + d[1]}, {p[0] + d[0], p[1] + d[1]}};
  int want = count_reached(corner);
  snprintf(blade, sizeof blade,
           "path: [[0.5, %.17g, %.17g], [0.5, %.17g, %.17g]], depth: [0, %.17g, %.17g]", p[0], p[1],
           q[0], q[1], d[0], d[1]);
  Cut c = make(CELLS, blade);
  if (c.note.n_split != want)
    fail_msg("%d elements instead of %d by %s", c.note.n_split, want, blade);
  CHECK_NEAR(c.note.area, 1.0 * want / (CELLS * CELLS), ROUNDING);
  end(&c);
}

/// Its edges between two layers, and by 5 % of its length to both sides of there.
static void a_blade_reaches_what_is_before_its_edges(void **state) {
  (void)state;
  static const double off[] = {0, 1e-6, -1e-6, 0.05, -0.05};
  static const int layers[] = {2, 2, 3, 2, 3};
  for (int axis = 0; axis < 2; axis++) // the end of its path, then of its depth
    for (int i = 0; i < 5; i++) {
      char blade[200];
      double edge = 0.6 + 0.5 * off[i];
      snprintf(blade, sizeof blade,
               axis ? "path: [[0.5, -0.1, 1.1], [0.5, 1.1, 1.1]], depth: [0, 0, %.17g]"
                    : "path: [[0.5, 1.1, -0.1], [0.5, %.17g, -0.1]], depth: [0, 0, 1.2]",
               axis ? edge - 1.1 : edge);
      Cut c = make(CELLS, blade);
      if (c.note.n_split != CELLS * layers[i])
        fail_msg("%d elements instead of %d by %s", c.note.n_split, CELLS * layers[i], blade);
      CHECK_NEAR(c.note.area, 1.0 * layers[i] / CELLS, ROUNDING);
      assert_int_equal(c.t->n_live_cells, CELLS * (CELLS * CELLS + layers[i]));
      end(&c);
    }
}

static void slanted_blades_cut_all_that_they_reach_and_nothing_else(void **state) {
  (void)state;
  uint64_t seed = 7;
  double x[6];
  for (int i = 0; i < 60; i++) {
    for (int k = 0; k < 6; k++) {
      x[k] = test_random(&seed);
      x[k] = k < 4 ? 1.2 * x[k] - 0.1 : 1.6 * x[k] - 0.8;
    }
    double sides = fabs((x[2] - x[0]) * x[5] - (x[3] - x[1]) * x[4]);
    if (sides > 0.02) expect_reach(x, x + 2, x + 4);
  }
}

// --- bends ---

/// Both sides of the cut lie in a leg: down to the bend, and on from there.
static void check_legs(const LthTopology *t, const Corner bend, const double to[2],
                       const double length[2]) {
  double area[2] = {0, 0};
  for (LitheIndex i = 0; i < t->n_faces; i++) {
    const LthTopologyFace *f = t->faces + i;
    if (!f->is_live || f->tag > LTH_TAG_CUT) continue;
    assert_int_equal(f->cell[1], -1);
    double from[2] = {f->centroid[0] - bend[0], f->centroid[1] - bend[1]};
    bool is_first = from[1] > 0 && fabs(from[0]) <= ROUNDING;
    double aside = from[0] * to[1] - from[1] * to[0];
    bool is_second = from[0] * to[0] + from[1] * to[1] > 0 && fabs(aside) <= ROUNDING;
    if (!is_first && !is_second)
      fail_msg("a face of the cut at (%g, %g)", f->centroid[0], f->centroid[1]);
    area[!is_first] += f->area;
  }
  for (int leg = 0; leg < 2; leg++) CHECK_NEAR(area[leg], 2 * length[leg], ROUNDING);
}

/// From above straight down to `bend` and on along `to`: one element, two parts, that with the corner (1, 1) of volume `right`.
static void expect_parts(const Corner bend, const double to[2], double length, double right) {
  char blade[300];
  snprintf(
      blade, sizeof blade,
      "path: [[%.17g, 1.5, -0.1], [%.17g, %.17g, -0.1], [%.17g, %.17g, -0.1]], depth: [0, 0, 1.2]",
      bend[0], bend[0], bend[1], bend[0] + 1.5 * to[0], bend[1] + 1.5 * to[1]);
  Cut c = make(1, blade);
  if (c.t->n_live_cells != 2) fail_msg("%d elements by %s", c.t->n_live_cells, blade);
  assert_int_equal(c.note.pieces, 2);
  CHECK_NEAR(c.note.area, 1 - bend[1] + length, ROUNDING);
  for (LitheIndex i = 0; i < c.t->n_cells; i++) {
    const LthTopologyCell *cell = c.t->cells + i;
    if (!cell->is_live) continue;
    bool is_right = cell->centroid[0] > bend[0];
    CHECK_NEAR(cell->volume, is_right ? right : 1 - right, ROUNDING);
  }
  check_legs(c.t, bend, to, (double[]){1 - bend[1], length});
  end(&c);
}

/// The second leg leaves through the side x = 1.
static void both_legs_of_a_bend_part_an_element_where_they_are(void **state) {
  (void)state;
  static const double down[] = {0, 0.1, 0.5, 0.9}; // 90 to 48 degrees
  static const Corner bend = {0.47, 0.53};
  for (int i = 0; i < 4; i++) {
    double norm = hypot(1, down[i]), b = 1 - bend[0];
    expect_parts(bend, (double[]){1 / norm, -down[i] / norm}, b * norm,
                 b * (1 - bend[1]) + 0.5 * b * b * down[i]);
  }
}

/// It leaves through the bottom, next to where the first would: down to angles that count as none.
static void slight_bends_end_a_leg_as_sharp_ones_do(void **state) {
  (void)state;
  static const double aside[] = {0.3, 1e-2, 1e-4, 1e-6, 1e-7, 1e-8};
  static const Corner bend = {0.47, 0.53};
  for (int i = 0; i < 6; i++) {
    double norm = hypot(1, aside[i]), b = bend[1];
    expect_parts(bend, (double[]){aside[i] / norm, -1 / norm}, b * norm,
                 1 - bend[0] - 0.5 * b * b * aside[i]);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_blade_reaches_what_is_before_its_edges),
      cmocka_unit_test(slanted_blades_cut_all_that_they_reach_and_nothing_else),
      cmocka_unit_test(both_legs_of_a_bend_part_an_element_where_they_are),
      cmocka_unit_test(slight_bends_end_a_leg_as_sharp_ones_do),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
