/// Shape functions, rules and the inverse of the map, on every kind of element.
#include "check.h"

#include "base/tensor.h"
#include "disc/cg/cg_shape.h"

#define N LTH_ELEMENT_MAX_NODES
#define FOR_KINDS(k) for (int k = LTH_TET4; k < LTH_POLYHEDRON; k++)

/// A place inside the reference element.
static void random_place(const LthCgKind *kind, uint64_t *seed, double xi[3]) {
  for (int a = 0; a < 3; a++) xi[a] = 2 * test_random(seed) - 1;
  lth_cg_clamp(kind, xi);
  for (int a = 0; a < 3; a++) xi[a] = 0.1 * kind->center[a] + 0.9 * xi[a];
}

static void functions_are_one_at_their_node_and_zero_at_others(void **state) {
  (void)state;
  FOR_KINDS(k) {
    LthCgKind kind;
    lth_cg_kind_init((LthElementKind)k, &kind);
    for (int i = 0; i < kind.n; i++) {
      double phi[N], dphi[3 * N];
      lth_cg_shape(&kind, kind.node[i], phi, dphi);
      for (int j = 0; j < kind.n; j++) CHECK_NEAR(phi[j], i == j, 1e-11); // the apex is a limit
    }
  }
}

/// Monomials that every function space of the degree holds; serendipity and pyramids hold all of P2.
static void functions_reproduce_polynomials_of_their_degree(void **state) {
  (void)state;
  static const int power[10][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {2, 0, 0},
                                   {0, 2, 0}, {0, 0, 2}, {1, 1, 0}, {0, 1, 1}, {1, 0, 1}};
  uint64_t seed = 7;
  FOR_KINDS(k) {
    LthCgKind kind;
    lth_cg_kind_init((LthElementKind)k, &kind);
    for (int trial = 0; trial < 20; trial++) {
      double xi[3], phi[N], dphi[3 * N];
      random_place(&kind, &seed, xi);
      lth_cg_shape(&kind, xi, phi, dphi);
      for (int q = 0; q < (kind.shape->degree == 1 ? 4 : 10); q++) {
        double sum = 0, want = 1;
        for (int a = 0; a < 3; a++) want *= pow(xi[a], power[q][a]);
        for (int i = 0; i < kind.n; i++) {
          double at = 1;
          for (int a = 0; a < 3; a++) at *= pow(kind.node[i][a], power[q][a]);
          sum += phi[i] * at;
        }
        CHECK_NEAR(sum, want, 1e-14);
      }
    }
  }
}

static void gradients_are_those_of_the_values(void **state) {
  (void)state;
  uint64_t seed = 11;
  FOR_KINDS(k) {
    LthCgKind kind;
    lth_cg_kind_init((LthElementKind)k, &kind);
    for (int trial = 0; trial < 10; trial++) {
      double xi[3], phi[N], dphi[3 * N], up[N], down[N], none[3 * N], h = 1e-5;
      random_place(&kind, &seed, xi);
      lth_cg_shape(&kind, xi, phi, dphi);
      for (int a = 0; a < 3; a++) {
        double moved[3] = {xi[0], xi[1], xi[2]};
        moved[a] = xi[a] + h;
        lth_cg_shape(&kind, moved, up, none);
        moved[a] = xi[a] - h;
        lth_cg_shape(&kind, moved, down, none);
        // third derivatives of the rational ones grow towards the apex
        for (int i = 0; i < kind.n; i++)
          CHECK_NEAR(dphi[3 * i + a], (up[i] - down[i]) / (2 * h), 1e-6);
      }
    }
  }
}

static void rules_give_volume_and_centre_of_the_reference_element(void **state) {
  (void)state;
  FOR_KINDS(k) {
    LthCgKind kind;
    lth_cg_kind_init((LthElementKind)k, &kind);
    int n = kind.shape->n_corners;
    double volume = n == 4 ? 1.0 / 6 : n == 5 ? 4.0 / 3 : n == 6 ? 1 : 8;
    for (int which = 0; which < 3; which++) {
      LthCgRule rule;
      if (which == 2)
        lth_cg_mass_rule(kind.kind, &rule);
      else
        lth_cg_stiffness_rule(kind.kind, which == 1, &rule);
      double sum = 0, center[3] = {0};
      for (int q = 0; q < rule.n; q++) {
        double xi[3];
        lth_v3_copy(rule.xi[q], xi);
        assert_false(lth_cg_clamp(&kind, xi));
        sum += rule.weight[q];
        lth_v3_axpy(rule.weight[q] / volume, rule.xi[q], center);
      }
      CHECK_NEAR(sum, volume, 1e-14 * 8);
      for (int a = 0; a < 3; a++) CHECK_NEAR(center[a], kind.center[a], 1e-14);
    }
  }
}

static void the_named_rules_have_their_number_of_points(void **state) {
  (void)state;
  static const int points[LTH_POLYHEDRON][2] = {
      [LTH_TET4] = {1, 1},        [LTH_TET10] = {4, 4},      [LTH_HEX8] = {8, 8},
      [LTH_HEX20] = {27, 8},      [LTH_HEX27] = {27, 27},    [LTH_WEDGE6] = {6, 2},
      [LTH_WEDGE15] = {9, 9},     [LTH_WEDGE18] = {27, 27},  [LTH_PYRAMID5] = {8, 8},
      [LTH_PYRAMID13] = {27, 27}, [LTH_PYRAMID14] = {27, 27}};
  FOR_KINDS(k)
  for (int reduced = 0; reduced < 2; reduced++) {
    LthCgRule rule;
    lth_cg_stiffness_rule((LthElementKind)k, reduced == 1, &rule);
    assert_int_equal(rule.n, points[k][reduced]);
  }
}

/// The divergence theorem on the reference element: sum of area vectors 0, int x . n = 3 V.
static void faces_close_around_the_element_and_point_outward(void **state) {
  (void)state;
  FOR_KINDS(k) {
    LthCgKind kind;
    lth_cg_kind_init((LthElementKind)k, &kind);
    double sum[3] = {0}, flux = 0;
    for (int f = 0; f < kind.shape->n_faces; f++) {
      int n = kind.shape->face[f].n_corners;
      LthCgPlaneRule plane;
      LthCgFaceRule rule;
      lth_cg_plane_rule(n, 3, &plane);
      lth_cg_face_rule(&kind, n, kind.shape->face[f].node, &plane, &rule);
      for (int q = 0; q < rule.n; q++) {
        double area[3];
        lth_v3_cross(rule.a[q], rule.b[q], area);
        lth_v3_axpy(rule.weight[q], area, sum);
        flux += rule.weight[q] * lth_v3_dot(area, rule.xi[q]);
      }
    }
    LthCgRule volume;
    double V = 0;
    lth_cg_mass_rule(kind.kind, &volume);
    for (int q = 0; q < volume.n; q++) V += volume.weight[q];
    for (int a = 0; a < 3; a++) CHECK_NEAR(sum[a], 0, 1e-13);
    CHECK_NEAR(flux, 3 * V, 1e-13 * 24);
  }
}

static void clamping_takes_places_to_the_element_and_leaves_inner_ones(void **state) {
  (void)state;
  uint64_t seed = 5;
  FOR_KINDS(k) {
    LthCgKind kind;
    lth_cg_kind_init((LthElementKind)k, &kind);
    for (int trial = 0; trial < 50; trial++) {
      double xi[3], again[3];
      for (int a = 0; a < 3; a++) xi[a] = 6 * test_random(&seed) - 3;
      lth_cg_clamp(&kind, xi);
      for (int a = 0; a < 3; a++) again[a] = 0.999 * xi[a] + 0.001 * kind.center[a];
      assert_false(lth_cg_clamp(&kind, again));
    }
    double none[3] = {NAN, NAN, NAN};
    lth_cg_clamp(&kind, none);
    for (int a = 0; a < 3; a++) assert_true(isfinite(none[a]));
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(functions_are_one_at_their_node_and_zero_at_others),
      cmocka_unit_test(functions_reproduce_polynomials_of_their_degree),
      cmocka_unit_test(gradients_are_those_of_the_values),
      cmocka_unit_test(rules_give_volume_and_centre_of_the_reference_element),
      cmocka_unit_test(the_named_rules_have_their_number_of_points),
      cmocka_unit_test(faces_close_around_the_element_and_point_outward),
      cmocka_unit_test(clamping_takes_places_to_the_element_and_leaves_inner_ones),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
