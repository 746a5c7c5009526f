/// Faces as simple polygons: areas add up, orientation is kept, every loop edge stays an edge.
#include "base/tensor.h"
#include "check.h"
#include "geometry/face_polygon.h"

#define MAX_POINTS 400

/// A face being put together, loop by loop, in the plane z = 0.
typedef struct Builder {
  double points[3 * MAX_POINTS];
  LitheIndex loop_off[20], loop_point[MAX_POINTS], n_points, n_loops;
} Builder;

static void add_loop(Builder *b, int n, double x, double y, double radius, double wobble,
                     bool hole) {
  for (int i = 0; i < n; i++) {
    double angle = 2 * M_PI * (hole ? n - i : i) / n;
    double r = radius * (1 + wobble * (i % 2));
    double *p = b->points + 3 * b->n_points;
    p[0] = x + r * cos(angle), p[1] = y + r * sin(angle), p[2] = 0;
    b->loop_point[b->n_points] = b->n_points;
    b->n_points++;
  }
  b->loop_off[++b->n_loops] = b->n_points;
}

static LthFaceView view_of(const Builder *b) {
  static const double up[3] = {0, 0, 1};
  return (LthFaceView){b->points, b->loop_off, b->loop_point, b->n_loops, up};
}

static double area_of(const Builder *b, const LitheIndex *p, LitheIndex n, double *smallest) {
  double sum = 0;
  for (LitheIndex i = 1; i + 1 < n; i++) {
    const double *o = b->points + 3 * p[0], *a = b->points + 3 * p[i],
                 *c = b->points + 3 * p[i + 1];
    sum += ((a[0] - o[0]) * (c[1] - o[1]) - (a[1] - o[1]) * (c[0] - o[0])) / 2;
  }
  *smallest = fmin(*smallest, sum);
  return sum;
}

/// How often the directed edge a -> b occurs in all polygons.
static int count_edge(const LthPolygonList *list, LitheIndex a, LitheIndex b) {
  int count = 0;
  for (LitheCount i = 0; i < list->n; i += list->items[i] + 1)
    for (LitheIndex k = 0, n = list->items[i]; k < n; k++)
      count += list->items[i + 1 + k] == a && list->items[i + 1 + (k + 1) % n] == b;
  return count;
}

/// Areas add up to the face's, no polygon is turned over, and the border is exactly the loops.
static void check_face(const Builder *b, LitheIndex expected_polygons) {
  LitheCtx *ctx = test_ctx();
  LthPolygonList list = {0};
  LthFaceView face = view_of(b);
  double centroid[3], sum = 0, smallest = HUGE_VAL;
  double area = lth_face_area_centroid(&face, centroid);
  CHECK_OK(ctx, lth_face_polygons(ctx, &face, &list));
  assert_int_equal(list.n_polygons, expected_polygons);
  for (LitheCount i = 0; i < list.n; i += list.items[i] + 1)
    sum += area_of(b, list.items + i + 1, list.items[i], &smallest);
  CHECK_NEAR(sum, area, 1e-13 * b->n_points);
  CHECK_AT_LEAST(smallest, 0);
  for (LitheIndex l = 0; l < b->n_loops; l++)
    for (LitheIndex i = b->loop_off[l]; i < b->loop_off[l + 1]; i++) {
      LitheIndex next = i + 1 < b->loop_off[l + 1] ? i + 1 : b->loop_off[l];
      assert_int_equal(count_edge(&list, i, next), 1);
      assert_int_equal(count_edge(&list, next, i), 0);
    }
  lth_polygon_list_free(ctx, &list);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void keeps_a_single_loop_as_it_is(void **state) {
  (void)state;
  Builder b = {0};
  add_loop(&b, 12, 0, 0, 1, 0.5, false);
  check_face(&b, 1);
}

static void cuts_a_ring_into_triangles(void **state) {
  (void)state;
  Builder b = {0};
  add_loop(&b, 4, 0, 0, 1, 0, false);
  add_loop(&b, 4, 0, 0, 0.5, 0, true);
  check_face(&b, 8);
}

static void cuts_many_holes_of_any_form(void **state) {
  (void)state;
  Builder b = {0};
  add_loop(&b, 60, 0, 0, 1, 0.1, false);
  for (int i = 0; i < 6; i++) add_loop(&b, 7 + 2 * i, 0.6 * cos(i), 0.6 * sin(i), 0.2, 0.3, true);
  add_loop(&b, 30, 0, 0, 0.15, -0.4, true);
  // n + 2 holes - 2 triangles
  check_face(&b, b.n_points + 2 * 7 - 2);
}

static void gives_each_outer_loop_its_own_holes(void **state) {
  (void)state;
  Builder b = {0};
  add_loop(&b, 9, 5, 0, 0.4, 0, true);
  add_loop(&b, 20, 0, 0, 1, 0, false);
  add_loop(&b, 16, 5, 0, 1, 0, false);
  add_loop(&b, 8, 0, 0, 0.3, 0, true);
  add_loop(&b, 5, 5, 0, 0.2, 0, false); // an island in the first hole
  check_face(&b, (20 + 8) + (16 + 9) + 1);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(keeps_a_single_loop_as_it_is),
      cmocka_unit_test(cuts_a_ring_into_triangles),
      cmocka_unit_test(cuts_many_holes_of_any_form),
      cmocka_unit_test(gives_each_outer_loop_its_own_holes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
