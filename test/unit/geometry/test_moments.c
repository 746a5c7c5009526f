/// Moments against closed forms, an independent integrator, and the identities they must satisfy.
#include "check.h"
#include "polyhedra.h"

enum { MAX_MOMENTS = 455 };

static const double origin[3] = {0, 0, 0}, unit[3] = {1, 1, 1};

/// int_a^b x^n dx
static double segment(double a, double b, int n) {
  return (pow(b, n + 1) - pow(a, n + 1)) / (n + 1);
}

static double box_moment(const double min[3], const double max[3], const int e[3]) {
  double product = 1;
  for (int i = 0; i < 3; i++) product *= segment(min[i], max[i], e[i]);
  return product;
}

static double factorial(int n) { return tgamma(n + 1.0); }

static void orders_monomials_by_degree(void **state) {
  (void)state;
  const int(*e)[3] = lth_monomial3_exponents();
  const int expected[10][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {2, 0, 0},
                               {1, 1, 0}, {1, 0, 1}, {0, 2, 0}, {0, 1, 1}, {0, 0, 2}};
  assert_memory_equal(e, expected, sizeof expected);
  for (int q = 0; q < lth_monomials3(LTH_MOMENT_MAX_DEGREE); q++)
    assert_int_equal(lth_monomial3_index(e[q][0], e[q][1], e[q][2]), q);
  const int(*e2)[2] = lth_monomial2_exponents();
  const int expected2[6][2] = {{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}};
  assert_memory_equal(e2, expected2, sizeof expected2);
  for (int q = 0; q < lth_monomials2(LTH_MOMENT_MAX_DEGREE); q++)
    assert_int_equal(lth_monomial2_index(e2[q][0], e2[q][1]), q);
}

/// All moments of `s` equal `wanted(e)` to rounding. Coordinates are at most 1 in size, so that each of
/// the two dozen edges adds at most a few roundings of a term below the volume.
static void check_all(const TestSolid *s, int p, double (*wanted)(const int e[3])) {
  double m[MAX_MOMENTS];
  test_moments(s, p, origin, unit, m);
  const int(*e)[3] = lth_monomial3_exponents();
  for (int q = 0; q < lth_monomials3(p); q++)
    CHECK_NEAR(m[q], wanted(e[q]), 64 * 0x1p-53 * wanted(e[0]));
}

static const double box_min[3] = {-0.5, 0.25, -1}, box_max[3] = {1, 0.75, 0.5};
static double wanted_box(const int e[3]) { return box_moment(box_min, box_max, e); }

static void integrates_a_box_exactly(void **state) {
  (void)state;
  TestSolid s;
  test_box(&s, box_min, box_max);
  check_all(&s, LTH_MOMENT_MAX_DEGREE, wanted_box);
}

static double wanted_simplex(const int e[3]) {
  return factorial(e[0]) * factorial(e[1]) * factorial(e[2]) / factorial(e[0] + e[1] + e[2] + 3);
}

static void integrates_the_unit_simplex_exactly(void **state) {
  (void)state;
  TestSolid s;
  test_tetrahedron(&s, (double[12]){0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});
  check_all(&s, LTH_MOMENT_MAX_DEGREE, wanted_simplex);
  // relative accuracy of each single moment: all terms are positive here
  double m[MAX_MOMENTS];
  test_moments(&s, LTH_MOMENT_MAX_DEGREE, origin, unit, m);
  const int(*e)[3] = lth_monomial3_exponents();
  for (int q = 0; q < MAX_MOMENTS; q++) CHECK_NEAR(m[q] / wanted_simplex(e[q]), 1, 64 * 0x1p-53);
}

static const double ring_outer[8] = {-1, -0.75, 1, -0.75, 1, 1, -1, 1};
static const double ring_hole[8] = {-0.25, -0.5, 0.75, -0.5, 0.75, 0.5, -0.25, 0.5};
static double wanted_ring(const int e[3]) {
  return box_moment((double[3]){-1, -0.75, -0.5}, (double[3]){1, 1, 0.25}, e) -
         box_moment((double[3]){-0.25, -0.5, -0.5}, (double[3]){0.75, 0.5, 0.25}, e);
}

static void integrates_faces_with_holes_exactly(void **state) {
  (void)state;
  TestSolid s;
  test_prism(&s, 4, ring_outer, 4, ring_hole, -0.5, 0.25);
  check_all(&s, LTH_MOMENT_MAX_DEGREE, wanted_ring);
}

static double wanted_ell(const int e[3]) {
  return box_moment((double[3]){-1, -1, -0.5}, (double[3]){1, 0, 1}, e) +
         box_moment((double[3]){-1, 0, -0.5}, (double[3]){-0.5, 1, 1}, e);
}

static const double ell[12] = {-1, -1, 1, -1, 1, 0, -0.5, 0, -0.5, 1, -1, 1};

static void integrates_a_non_convex_solid_exactly(void **state) {
  (void)state;
  TestSolid s;
  test_prism(&s, 6, ell, 0, NULL, -0.5, 1);
  check_all(&s, LTH_MOMENT_MAX_DEGREE, wanted_ell);
}

static void ignores_vertices_on_straight_edges(void **state) {
  (void)state;
  // the L again, with T-junction vertices, one of them the first point of its loop
  static const double polygon[20] = {0,    -1, 1,    -1,  1,    -0.25, 1,  0, 0.5, 0,
                                     -0.5, 0,  -0.5, 0.5, -0.5, 1,     -1, 1, -1,  -1};
  TestSolid s;
  test_prism(&s, 10, polygon, 0, NULL, -0.5, 1);
  check_all(&s, LTH_MOMENT_MAX_DEGREE, wanted_ell);
}

/// A random non-convex, star-shaped solid: an octahedron with random radii, each face split in three by
/// a random pit or peak.
static void random_star(TestSolid *s, uint64_t *seed) {
  static const int tris[8][3] = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                 {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  memset(s, 0, sizeof *s);
  for (int k = 0; k < 6; k++) {
    double x[3] = {0};
    x[k / 2] = (k % 2 ? -1 : 1) * (0.5 + 0.5 * test_random(seed));
    test_add_point(s, x[0], x[1], x[2]);
  }
  for (int f = 0; f < 8; f++) {
    double r = 0.15 + 0.3 * test_random(seed), x[3];
    for (int i = 0; i < 3; i++) {
      x[i] = 0;
      for (int c = 0; c < 3; c++) x[i] += r * s->points[3 * tris[f][c] + i];
    }
    int tip = test_add_point(s, x[0], x[1], x[2]);
    for (int c = 0; c < 3; c++)
      test_add_loop(s, true, 3, (int[3]){tris[f][c], tris[f][(c + 1) % 3], tip});
  }
  test_finish(s);
}

static void agrees_with_signed_tetrahedra(void **state) {
  (void)state;
  uint64_t seed = 7;
  const int(*e)[3] = lth_monomial3_exponents();
  for (int repeat = 0; repeat < 3; repeat++) {
    TestSolid s;
    random_star(&s, &seed);
    double center[3], scale[3], m[MAX_MOMENTS];
    for (int i = 0; i < 3; i++)
      center[i] = 0.2 * test_random(&seed), scale[i] = 0.8 + 0.4 * test_random(&seed);
    test_moments(&s, LTH_MOMENT_MAX_DEGREE, center, scale, m);
    // |xi| <= 1.5 here: the largest term is 1.5^degree times the volume
    for (int q = repeat; q < MAX_MOMENTS; q += 13) {
      double bound = pow(1.5, e[q][0] + e[q][1] + e[q][2]) * m[0];
      CHECK_NEAR(m[q], test_oracle(&s, center, scale, e[q]), 64 * 0x1p-53 * bound);
    }
  }
}

enum { POWERS = 16 };

/// A polynomial in two variables, coefficients [i][j] of u^i v^j.
typedef struct Poly2 {
  long double c[POWERS][POWERS];
} Poly2;

/// p *= c0 + cu u + cv v
static void multiply_linear(Poly2 *p, long double c0, long double cu, long double cv) {
  Poly2 r = {0};
  for (int i = 0; i < POWERS - 1; i++)
    for (int j = 0; j < POWERS - 1 - i; j++) {
      r.c[i][j] += c0 * p->c[i][j];
      r.c[i + 1][j] += cu * p->c[i][j];
      r.c[i][j + 1] += cv * p->c[i][j];
    }
  *p = r;
}

/// int Q dv along an edge of the projected face, Q = int p du.
static long double edge_integral(const Poly2 *p, const double *a, const double *b, int u, int v) {
  enum { N = 8 };
  long double x[N], w[N], total = 0;
  test_gauss(N, x, w);
  for (int g = 0; g < N; g++) {
    long double s = a[u] + x[g] * ((long double)b[u] - a[u]);
    long double t = a[v] + x[g] * ((long double)b[v] - a[v]), row = s;
    for (int i = 0; i < POWERS; i++, row *= s) {
      long double value = row / (i + 1);
      for (int j = 0; j < POWERS; j++, value *= t) total += w[g] * p->c[i][j] * value;
    }
  }
  return total * ((long double)b[v] - a[v]);
}

/// Appendix A of Kaufmann et al. 2009 with planes n.x = d: integrate in x, project each face along the largest
/// component of its normal, integrate by Green's theorem over its edges.
static double by_projection(const TestSolid *s, const int e[3]) {
  long double total = 0;
  for (int f = 0; f < s->n_faces; f++) {
    LthFaceView face = test_face(s, f);
    const double *n = face.normal, *on = s->points + 3 * face.loop_point[face.loop_off[0]];
    int axis = 0;
    for (int i = 1; i < 3; i++)
      if (fabs(n[i]) > fabs(n[axis])) axis = i;
    int u = (axis + 1) % 3, v = (axis + 2) % 3, power[3] = {e[0] + 1, e[1], e[2]};
    long double d =
        (long double)n[0] * on[0] + (long double)n[1] * on[1] + (long double)n[2] * on[2];
    Poly2 p = {0};
    p.c[power[u]][power[v]] = 1.0L / (e[0] + 1);
    for (int k = 0; k < power[axis]; k++)
      multiply_linear(&p, d / n[axis], -(long double)n[u] / n[axis], -(long double)n[v] / n[axis]);
    long double sum = 0;
    for (LitheIndex l = 0; l < face.n_loops; l++)
      for (LitheIndex k = face.loop_off[l]; k < face.loop_off[l + 1]; k++) {
        LitheIndex next = k + 1 < face.loop_off[l + 1] ? k + 1 : face.loop_off[l];
        sum += edge_integral(&p, s->points + 3 * face.loop_point[k],
                             s->points + 3 * face.loop_point[next], u, v);
      }
    total += (long double)n[0] / n[axis] * sum;
  }
  return (double)total;
}

static void agrees_with_projected_faces(void **state) {
  (void)state;
  uint64_t seed = 17;
  const int(*e)[3] = lth_monomial3_exponents();
  for (int shape = 0; shape < 3; shape++) {
    TestSolid s;
    double R[9], zero[3] = {0}, m[35];
    if (shape == 0) random_star(&s, &seed);
    if (shape == 1) test_prism(&s, 4, ring_outer, 4, ring_hole, -0.5, 0.25);
    if (shape == 2) test_prism(&s, 6, ell, 0, NULL, -0.5, 1);
    test_axis_rotation((double[3]){2, -1, 3}, 0.4 + shape, R);
    if (shape < 2) test_transform(&s, R, zero); // the last keeps planes through the origin
    test_moments(&s, 4, origin, unit, m);
    // normals are rounded to double here: each face is off by that, times its size and 2^5
    for (int q = 0; q < 35; q++)
      CHECK_NEAR(m[q], by_projection(&s, e[q]), 24 * 32 * 0x1p-53 * m[0]);
  }
}

static void is_the_same_a_million_sizes_away(void **state) {
  (void)state;
  // coordinates and offset are multiples of 1/4: every point is exact, so the moments keep their bits
  TestSolid s, far;
  test_prism(&s, 6, ell, 0, NULL, -0.5, 1);
  far = s;
  double identity[9], offset[3] = {1e6, -3e6, 2e6}, center[3] = {0.25, 0, 0.5}, moved[3];
  lth_m3_identity(identity);
  test_transform(&far, identity, offset);
  lth_v3_add(center, offset, moved);
  double near_m[MAX_MOMENTS], far_m[MAX_MOMENTS];
  test_moments(&s, LTH_MOMENT_MAX_DEGREE, center, unit, near_m);
  test_moments(&far, LTH_MOMENT_MAX_DEGREE, moved, unit, far_m);
  assert_memory_equal(near_m, far_m, sizeof near_m);
}

static void turns_with_the_solid(void **state) {
  (void)state;
  TestSolid s;
  uint64_t seed = 11;
  for (int repeat = 0; repeat < 10; repeat++) {
    test_prism(&s, 4, ring_outer, 4, ring_hole, -0.5, 0.25);
    double m[10], r[10], R[9], axis[3], zero[3] = {0};
    for (int i = 0; i < 3; i++) axis[i] = test_random(&seed) - 0.5;
    test_axis_rotation(axis, 6 * test_random(&seed), R);
    test_moments(&s, 2, origin, unit, m);
    test_transform(&s, R, zero);
    test_moments(&s, 2, origin, unit, r);
    double tolerance = 64 * 0x1p-53 * m[0], first[3];
    CHECK_NEAR(r[0], m[0], tolerance);
    lth_m3_apply(R, m + 1, first);
    for (int i = 0; i < 3; i++) CHECK_NEAR(r[1 + i], first[i], tolerance);
    // second moments: R S R^T
    double S[9] = {m[4], m[5], m[6], m[5], m[7], m[8], m[6], m[8], m[9]}, RS[9], Rt[9], T[9];
    lth_m3_mul(R, S, RS);
    lth_m3_transpose(R, Rt);
    lth_m3_mul(RS, Rt, T);
    double got[9] = {r[4], r[5], r[6], r[5], r[7], r[8], r[6], r[8], r[9]};
    for (int i = 0; i < 9; i++) CHECK_NEAR(got[i], T[i], tolerance);
  }
}

static void gives_an_orthonormal_frame(void **state) {
  (void)state;
  uint64_t seed = 3;
  for (int repeat = 0; repeat < 50; repeat++) {
    double n[3] = {0}, t1[3], t2[3], cross[3];
    if (repeat < 6)
      n[repeat / 2] = repeat % 2 ? -1 : 1;
    else
      for (int i = 0; i < 3; i++) n[i] = test_random(&seed) - 0.5;
    lth_v3_normalize(n);
    lth_face_frame(n, t1, t2);
    lth_v3_cross(t1, t2, cross);
    CHECK_NEAR(lth_v3_norm(t1), 1, 4 * 0x1p-53);
    CHECK_NEAR(lth_v3_norm(t2), 1, 4 * 0x1p-53);
    CHECK_NEAR(lth_v3_dot(t1, t2), 0, 4 * 0x1p-53);
    for (int i = 0; i < 3; i++) CHECK_NEAR(cross[i], n[i], 4 * 0x1p-53);
  }
}

static void integrates_over_a_holed_face_exactly(void **state) {
  (void)state;
  TestSolid s;
  test_prism(&s, 4, ring_outer, 4, ring_hole, -0.5, 0.25);
  LthFaceView top = test_face(&s, 1);
  double t1[3] = {1, 0, 0}, t2[3] = {0, 1, 0}, from[3] = {0.25, -0.5, 0.25}, h = 1.5, m[91], c[3];
  lth_face_moments(12, from, t1, t2, h, &top, m);
  const int(*e)[2] = lth_monomial2_exponents();
  for (int q = 0; q < 91; q++) {
    int i = e[q][0], j = e[q][1];
    double s0 = -1.25 / h, s1 = 0.75 / h, u0 = -0.25 / h, u1 = 1.5 / h; // outer; hole below
    double wanted = h * h *
                    (segment(s0, s1, i) * segment(u0, u1, j) -
                     segment(-0.5 / h, 0.5 / h, i) * segment(0, 1 / h, j));
    CHECK_NEAR(m[q], wanted, 64 * 0x1p-53 * m[0]);
  }
  CHECK_NEAR(lth_face_area_centroid(&top, c), 2.5, 8 * 0x1p-53);
  CHECK_NEAR(c[0], -0.1, 8 * 0x1p-53); // (0 * 3.5 - 0.25 * 1) / 2.5
  CHECK_NEAR(c[1], 0.125 * 3.5 / 2.5, 8 * 0x1p-53);
  CHECK_NEAR(c[2], 0.25, 0);
}

/// sum_f n_x int_f x^a y^b z^c dA from in-plane moments, by expanding x = o + t1 s + t2 t.
static double face_flux(const TestSolid *s, int f, int axis, const int e[3]) {
  LthFaceView face = test_face(s, f);
  double t1[3], t2[3], c[3], m[91];
  lth_face_frame(face.normal, t1, t2);
  lth_face_area_centroid(&face, c);
  int p = e[0] + e[1] + e[2];
  lth_face_moments(p, c, t1, t2, 1, &face, m);
  double poly[91] = {1};
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < e[i]; k++) {
      double next[91] = {0};
      for (int q = 0; q < lth_monomials2(p - 1); q++) {
        int u = lth_monomial2_exponents()[q][0], v = lth_monomial2_exponents()[q][1];
        next[q] += c[i] * poly[q];
        next[lth_monomial2_index(u + 1, v)] += t1[i] * poly[q];
        next[lth_monomial2_index(u, v + 1)] += t2[i] * poly[q];
      }
      memcpy(poly, next, sizeof poly);
    }
  double sum = 0;
  for (int q = 0; q < lth_monomials2(p); q++) sum += poly[q] * m[q];
  return sum * face.normal[axis];
}

static void cells_and_faces_obey_the_divergence_theorem(void **state) {
  (void)state;
  uint64_t seed = 5;
  TestSolid s;
  double R[9], zero[3] = {0}, m[MAX_MOMENTS];
  test_axis_rotation((double[3]){1, 2, -1}, 0.7, R);
  for (int shape = 0; shape < 2; shape++) {
    if (shape == 0)
      test_prism(&s, 4, ring_outer, 4, ring_hole, -0.5, 0.25);
    else
      random_star(&s, &seed);
    test_transform(&s, R, zero);
    test_moments(&s, 7, origin, unit, m);
    for (int q = 0; q < lth_monomials3(7); q++)
      for (int axis = 0; axis < 3; axis++) {
        const int *e = lth_monomial3_exponents()[q];
        int lower[3] = {e[0], e[1], e[2]};
        lower[axis]--;
        double inside = 0, through = 0;
        if (lower[axis] >= 0)
          inside = e[axis] * m[lth_monomial3_index(lower[0], lower[1], lower[2])];
        for (int f = 0; f < s.n_faces; f++) through += face_flux(&s, f, axis, e);
        // expansion coefficients grow to (|c| + |t1| + |t2|)^7, near 3^7, over 24 faces
        CHECK_NEAR(through, inside, 24 * 2187 * 0x1p-53 * m[0]);
      }
  }
}

static void a_sliver_keeps_its_relative_accuracy(void **state) {
  (void)state;
  // a box one part in 2^30 thick, scaled to its own box: as exact as a cube
  double min[3] = {0, 0, 0}, max[3] = {1, 1, 0x1p-30}, m[MAX_MOMENTS];
  double center[3] = {0.5, 0.5, 0x1p-31}, scale[3] = {0.5, 0.5, 0x1p-31};
  TestSolid s;
  test_box(&s, min, max);
  test_moments(&s, 8, center, scale, m);
  const int(*e)[3] = lth_monomial3_exponents();
  for (int q = 0; q < lth_monomials3(8); q++) {
    double wanted = 0x1p-33;
    for (int i = 0; i < 3; i++) wanted *= segment(-1, 1, e[q][i]);
    CHECK_NEAR(m[q], wanted, 64 * 0x1p-53 * 0x1p-30);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(orders_monomials_by_degree),
      cmocka_unit_test(integrates_a_box_exactly),
      cmocka_unit_test(integrates_the_unit_simplex_exactly),
      cmocka_unit_test(integrates_faces_with_holes_exactly),
      cmocka_unit_test(integrates_a_non_convex_solid_exactly),
      cmocka_unit_test(ignores_vertices_on_straight_edges),
      cmocka_unit_test(agrees_with_signed_tetrahedra),
      cmocka_unit_test(agrees_with_projected_faces),
      cmocka_unit_test(is_the_same_a_million_sizes_away),
      cmocka_unit_test(turns_with_the_solid),
      cmocka_unit_test(gives_an_orthonormal_frame),
      cmocka_unit_test(integrates_over_a_holed_face_exactly),
      cmocka_unit_test(cells_and_faces_obey_the_divergence_theorem),
      cmocka_unit_test(a_sliver_keeps_its_relative_accuracy),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
