/// Blades that bend: what they cut at rest, in closed form, and in a body that is not at rest. There elements take the blade back to
/// rest each by its own map; what is on two sides of it comes apart all the same, and no more.
#include "base/tensor.h"
#include "cut_cube.h"
#include "mesh/topology.h"

#include <math.h>

#define ROUNDING 1e-11 ///< of an area of the unit cube: sums over a few hundred faces
#define PLACE 300

/// A cube that has moved by `displacement` and been cut by a blade; `sliver` 0 merges nothing.
static Cut make(int degree, int cells, const char *displacement, const char *path) {
  char text[1500];
  int n = snprintf(
      text, sizeof text,
      "lithe: 1\nbodies:\n  - name: cube\n    shape: {box: {min: [0, 0, 0], max: [1, 1, 1]}}\n"
      "    material: {young_modulus: 1e4, poisson_ratio: 0.3, density: 1000}\n"
      "    method: {kind: dg, mesh: hexahedra, cells: %d, degree: %d, sliver: 0}\n"
      "    initial: {displacement: [%s]}\ncontact: {bodies: false}\n"
      "cuts: [{at: 0.05, blade: {path: [%s], depth: [0, 0.1, 2]}}]\n"
      "time: {kind: dynamic, duration: 1, step: 0.1}\n",
      cells, degree, displacement, path);
  assert_true(n < (int)sizeof text);
  return cut_made(text, 0.1);
}

/// Both sides of a cut have its area, and every element is closed.
static void check_sides(Cut *c) {
  double area = 0;
  CHECK_OK(c->reading.ctx, lth_topology_check(c->reading.ctx, c->t, 0, NULL));
  for (LitheIndex i = 0; i < c->t->n_faces; i++)
    if (c->t->faces[i].is_live && c->t->faces[i].tag <= LTH_TAG_CUT) area += c->t->faces[i].area;
  // crumbs that are taken away take theirs along
  if (c->note.n_removed == 0) CHECK_NEAR(area, 2 * c->note.area, ROUNDING);
}

/// Moved by about `strain` of its size, by polynomials that elements of `degree` do not have but for degree 2.
static void expect_two(int degree, int cells, const char *path, double strain) {
  char displacement[PLACE];
  snprintf(displacement, sizeof displacement,
           "\"%g*((y-.5)^2+x*z)\", \"%g*((x-.4)*z+x*x)\", \"%g*z*(z-x)\"", strain, -strain, strain);
  Cut rest = make(degree, cells, "0, 0, 0", path);
  Cut moved = make(degree, cells, displacement, path);
  assert_int_equal(rest.note.pieces, 2);
  if (moved.note.pieces != 2)
    fail_msg("%d pieces: degree %d, %d cells, moved by %g, path %s", moved.note.pieces, degree,
             cells, strain, path);
  // areas at rest: less by the stretch, at most 3 of the gradient's 2 * strain in a direction, and by wedges
  double off = fabs(moved.note.area - rest.note.area);
  if (!(off <= 6 * strain * rest.note.area + ROUNDING))
    fail_msg("area %.6f at rest %.6f: degree %d, %d cells, moved by %g, path %s", moved.note.area,
             rest.note.area, degree, cells, strain, path);
  check_sides(&moved);
  end(&moved);
  end(&rest);
}

static void a_bent_blade_parts_a_body_in_motion(void **state) {
  (void)state;
  static const double strains[] = {1e-7, 1e-4, 1e-2, 0.03};
  static const char *const paths[] = {
      "[-0.5, 0.4, -0.5], [0.47, 0.62, -0.5], [1.5, 0.37, -0.5]",
      "[-0.5, 0.4, -0.5], [0.47, 0.62, -0.5], [1.5, 0.88, -0.5]", // by less than two degrees
      "[-0.5, 0.4, -0.5], [0.5, 0.6, -0.5], [1.5, 0.37, -0.5]",   // in a face of two cells
      "[0.31, -0.5, -0.5], [0.37, 0.61, -0.5], [1.5, 0.7, -0.5]", // by a right angle
  };
  for (int degree = 1; degree <= 2; degree++)
    for (int cells = 2; cells <= 4 - degree + 1; cells++)
      for (int p = 0; p < 4; p++)
        for (int s = 0; s < 4; s++) expect_two(degree, cells, paths[p], strains[s]);
}

static void so_does_one_with_many_bends(void **state) {
  (void)state;
  uint64_t seed = 11;
  for (int i = 0; i < 24; i++) {
    char path[PLACE];
    int bends = 2 + i % 4, n = snprintf(path, sizeof path, "[-0.5, 0.5, -0.5]");
    for (int k = 0; k < bends; k++)
      n += snprintf(path + n, sizeof path - (size_t)n, ", [%.4f, %.4f, -0.5]",
                    (k + 0.2 + 0.6 * test_random(&seed)) / bends, 0.25 + 0.4 * test_random(&seed));
    snprintf(path + n, sizeof path - (size_t)n, ", [1.5, 0.5, -0.5]");
    expect_two(1 + i / 4 % 2, 2 + i % 3, path, 0.01);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_bent_blade_parts_a_body_in_motion),
      cmocka_unit_test(so_does_one_with_many_bends),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
