/// Cost and error of exact moments against sub-tessellation and sampling (Kaufmann et al. 2009, Fig. 4).
///
/// The solid is the unit cube without the corner x + y + z > 2.5. Times are the best of several runs on one
/// core; the last table uses all of them. `--csv` prints the same numbers as comma-separated rows.
#include "base/tensor.h"
#include "disc/dg/dg_space.h"
#include "geometry/moments.h"
#include "geometry/quadrature.h"
#include "mesh/mesh.h"

#include <stdio.h>
#include <stdlib.h>

enum { MONOMIALS = 35, RUNS = 7 };

static const double cut_points[] = {0, 0, 0, 1, 0, 0, 1, 1, 0,   0, 1,   0, 0,   0, 1,
                                    1, 0, 1, 0, 1, 1, 1, 1, 0.5, 1, 0.5, 1, 0.5, 1, 1};
static const LitheIndex cut_loops[] = {0, 3, 2, 1, 0, 1, 5, 4, 0, 4, 6, 3, 1, 2, 7,
                                       8, 5, 3, 6, 9, 7, 2, 4, 5, 8, 9, 6, 7, 9, 8};
static const LitheIndex cut_off[] = {0, 4, 8, 12, 17, 22, 27, 30};
enum { CUT_FACES = 7 };

static LthFaceView cut_face(int f) {
  static const double no_normal[3] = {0, 0, 0}; // cell moments do not read it
  return (LthFaceView){cut_points, cut_off + f, cut_loops, 1, no_normal};
}

static double factorial(int n) { return n < 2 ? 1 : n * factorial(n - 1); }
static double choose(int n, int k) { return factorial(n) / (factorial(k) * factorial(n - k)); }

/// Cube minus corner, the corner's x = 1 - u expanded: the closed form.
static double exact(const int e[3]) {
  double corner = 0;
  for (int i = 0; i <= e[0]; i++)
    for (int j = 0; j <= e[1]; j++)
      for (int k = 0; k <= e[2]; k++) {
        int n = i + j + k;
        double sign = n % 2 ? -1 : 1;
        corner += sign * choose(e[0], i) * choose(e[1], j) * choose(e[2], k) * factorial(i) *
                  factorial(j) * factorial(k) / factorial(n + 3) * pow(0.5, n + 3);
      }
  return 1.0 / ((e[0] + 1) * (e[1] + 1) * (e[2] + 1)) - corner;
}

/// An integrator of all monomials up to degree p; `detail` is its resolution.
typedef void (*IntegrateFn)(int p, int detail, double *moments);

static void by_divergence(int p, int detail, double *m) {
  const double zero[3] = {0, 0, 0}, one[3] = {1, 1, 1};
  (void)detail;
  memset(m, 0, sizeof(double) * (size_t)lth_monomials3(p));
  for (int f = 0; f < CUT_FACES; f++) {
    LthFaceView face = cut_face(f);
    lth_moments_add_face(p, zero, one, &face, 1, m);
  }
}

/// A symmetric rule on the tetrahedron: barycentric points and weights that sum to 1.
typedef struct TetRule {
  int n;
  double bary[64][4], weight[64];
} TetRule;

static void add_orbit(TetRule *rule, const double b[4], double weight) {
  // all distinct permutations of (b0, b1, b1, b1) or (b0, b0, b1, b1)
  for (int i = 0; i < 4; i++)
    for (int j = i; j < 4; j++) {
      bool pairs = b[2] == b[0];
      if (pairs ? i == j : i != j) continue;
      for (int k = 0; k < 4; k++) rule->bary[rule->n][k] = k == i || k == j ? b[0] : b[1];
      rule->weight[rule->n++] = weight;
    }
}

/// 1 point (degree 1), 4 points (2), 14 points (5; Walkington 2000), or 27 collapsed Gauss points (5).
static TetRule tet_rule(int n) {
  TetRule rule = {0};
  if (n == 1) {
    rule = (TetRule){1, {{0.25, 0.25, 0.25, 0.25}}, {1}};
  } else if (n == 4) {
    double a = 0.1381966011250105;
    add_orbit(&rule, (double[4]){1 - 3 * a, a, a, a}, 0.25);
  } else if (n == 14) {
    double a = 0.3108859192633006, b = 0.09273525031089123, c = 0.04550370412564965;
    add_orbit(&rule, (double[4]){1 - 3 * a, a, a, a}, 0.11268792571801585);
    add_orbit(&rule, (double[4]){1 - 3 * b, b, b, b}, 0.07349304311636194);
    add_orbit(&rule, (double[4]){c, 0.5 - c, c, 0.5 - c}, 0.04254602077708147);
  } else {
    LthSimplexRule collapsed;
    rule.n = 27;
    if (lth_simplex_rule(NULL, 3, 5, &collapsed)) return rule;
    for (int k = 0; k < 27; k++)
      rule.weight[k] = lth_simplex_rule_point(&collapsed, k, rule.bary[k]);
  }
  return rule;
}

static void add_sample(int p, const double x[3], double weight, double *m) {
  double values[MONOMIALS];
  lth_monomials3_eval(p, x, values);
  for (int q = 0; q < lth_monomials3(p); q++) m[q] += weight * values[q];
}

static void by_tetrahedra(int p, int detail, double *m) {
  static TetRule rules[28];
  TetRule *rule = &rules[detail];
  if (rule->n == 0) *rule = tet_rule(detail);
  memset(m, 0, sizeof(double) * (size_t)lth_monomials3(p));
  for (int f = 0; f < CUT_FACES; f++)
    for (LitheIndex k = cut_off[f] + 1; k + 1 < cut_off[f + 1]; k++) {
      // the apex is point 0, the origin: its own faces give nothing
      const double *a = cut_points + 3 * cut_loops[cut_off[f]], *b = cut_points + 3 * cut_loops[k],
                   *c = cut_points + 3 * cut_loops[k + 1];
      double w[3];
      lth_v3_cross(b, c, w);
      double volume = lth_v3_dot(a, w) / 6;
      for (int g = 0; volume != 0 && g < rule->n; g++) {
        double x[3];
        for (int i = 0; i < 3; i++)
          x[i] = rule->bary[g][1] * a[i] + rule->bary[g][2] * b[i] + rule->bary[g][3] * c[i];
        add_sample(p, x, volume * rule->weight[g], m);
      }
    }
}

/// Midpoints of a lattice of detail^3 boxes, those inside counted.
static void by_lattice(int p, int detail, double *m) {
  double h = 1.0 / detail, weight = h * h * h;
  memset(m, 0, sizeof(double) * (size_t)lth_monomials3(p));
  for (int i = 0; i < detail; i++)
    for (int j = 0; j < detail; j++)
      for (int k = 0; k < detail; k++) {
        double x[3] = {(i + 0.5) * h, (j + 0.5) * h, (k + 0.5) * h};
        if (x[0] + x[1] + x[2] <= 2.5) add_sample(p, x, weight, m);
      }
}

static void by_chance(int p, int detail, double *m) {
  uint64_t seed = 1;
  memset(m, 0, sizeof(double) * (size_t)lth_monomials3(p));
  for (int s = 0; s < detail; s++) {
    double x[3];
    for (int i = 0; i < 3; i++) {
      seed ^= seed >> 12, seed ^= seed << 25, seed ^= seed >> 27;
      x[i] = (double)((seed * 0x2545F4914F6CDD1Du) >> 11) * 0x1p-53;
    }
    if (x[0] + x[1] + x[2] <= 2.5) add_sample(p, x, 1.0 / detail, m);
  }
}

/// Best time of one call [s].
static double time_call(IntegrateFn integrate, int p, int detail, double *m) {
  double best = 1e30;
  for (int run = 0, calls = 1; run < RUNS; run++) {
    double start = lth_now();
    for (int c = 0; c < calls; c++) integrate(p, detail, m);
    double time = lth_now() - start;
    if (time / calls < best) best = time / calls;
    if (time < 2e-3) calls = 1 + (int)(calls * 4e-3 / (time + 1e-9));
  }
  return best;
}

static bool csv;

/// NAN: no error to tell.
static void print_row(const char *group, const char *method, double time, double error) {
  printf(csv ? "%s,%s,%.9g," : "%-25s %-38s %11.0f ns", group, method, csv ? time : 1e9 * time);
  if (!isnan(error)) printf(csv ? "%.3g" : "   %9.1e", error);
  printf("\n");
}

static void compare(const char *group, int p, const char *method, IntegrateFn integrate,
                    int detail) {
  double m[MONOMIALS], worst = 0;
  double time = time_call(integrate, p, detail, m);
  const int(*e)[3] = lth_monomial3_exponents();
  // x^2 alone, or the worst of all monomials
  int first = p == 2 ? lth_monomial3_index(2, 0, 0) : 0,
      last = p == 2 ? first + 1 : lth_monomials3(p);
  for (int q = first; q < last; q++) {
    double wanted = exact(e[q]), error = fabs(m[q] - wanted) / wanted;
    if (error > worst) worst = error;
  }
  print_row(group, method, time, worst);
}

/// Largest detail whose cost is at most that of the divergence theorem.
static int equal_cost(int p, IntegrateFn integrate, double factor) {
  double m[MONOMIALS], budget = time_call(by_divergence, p, 0, m);
  int detail = 1;
  while (detail < 1000000) {
    int next = (int)(detail * factor) + 1;
    if (time_call(integrate, p, next, m) > budget) break;
    detail = next;
  }
  return detail;
}

static void corner_cut_cube(int p) {
  const char *group = p == 2 ? "x^2 (of 10, degree <= 2)" : "all 35, degree <= 4";
  char name[64];
  compare(group, p, "divergence theorem", by_divergence, 0);
  compare(group, p, "tetrahedra, 1 point", by_tetrahedra, 1);
  compare(group, p, "tetrahedra, 4 points", by_tetrahedra, 4);
  compare(group, p, "tetrahedra, 14 points", by_tetrahedra, 14);
  compare(group, p, "tetrahedra, 27 points", by_tetrahedra, 27);
  int detail = equal_cost(p, by_lattice, 1);
  snprintf(name, sizeof name, "midpoint lattice %d^3 (equal cost)", detail);
  compare(group, p, name, by_lattice, detail);
  compare(group, p, "midpoint lattice 16^3", by_lattice, 16);
  compare(group, p, "midpoint lattice 64^3", by_lattice, 64);
  detail = equal_cost(p, by_chance, 1.25);
  snprintf(name, sizeof name, "Monte Carlo %d points (equal cost)", detail);
  compare(group, p, name, by_chance, detail);
  compare(group, p, "Monte Carlo 100000 points", by_chance, 100000);
}

/// Cell moments of degree 2k about centroids, and in-plane moments of all faces.
static void mesh_moments(LitheCtx *ctx, const LthMesh *mesh, int degree, double *cells,
                         double *faces) {
  int n3 = lth_monomials3(2 * degree), n2 = lth_monomials2(2 * degree);
#pragma omp parallel num_threads(lth_threads(ctx))
  {
#pragma omp for schedule(static) nowait
    for (LitheIndex c = 0; c < mesh->n_cells; c++) {
      double *m = cells + (LitheCount)n3 * c, scale[3];
      memset(m, 0, sizeof *m * (size_t)n3);
      for (int i = 0; i < 3; i++)
        scale[i] = 0.5 * (mesh->cell_box[6 * c + 3 + i] - mesh->cell_box[6 * c + i]);
      for (LitheIndex k = mesh->cell_face_off[c]; k < mesh->cell_face_off[c + 1]; k++) {
        LthFaceView face = lth_mesh_face(mesh, mesh->cell_face[k]);
        lth_moments_add_face(2 * degree, mesh->cell_centroid + 3 * c, scale, &face,
                             lth_mesh_side(mesh, mesh->cell_face[k], c), m);
      }
    }
#pragma omp for schedule(static)
    for (LitheIndex f = 0; f < mesh->n_faces; f++) {
      double t1[3], t2[3];
      LthFaceView face = lth_mesh_face(mesh, f);
      lth_face_frame(face.normal, t1, t2);
      lth_face_moments(2 * degree, mesh->face_centroid + 3 * f, t1, t2, sqrt(mesh->face_area[f]),
                       &face, faces + (LitheCount)n2 * f);
    }
  }
}

static LitheStatus thousand_elements(LitheCtx *ctx, const char *kind, LthMesh *mesh) {
  LitheStatus status = LITHE_OK;
  double *cells = NULL, *faces = NULL;
  LTH_NEW_OR(done, ctx, cells, (LitheCount)lth_monomials3(8) * mesh->n_cells);
  LTH_NEW_OR(done, ctx, faces, (LitheCount)lth_monomials2(8) * mesh->n_faces);
  for (int degree = 1; degree <= 4; degree++) {
    char name[64];
    double best = 1e30;
    for (int run = 0; run < RUNS; run++) {
      double start = lth_now();
      mesh_moments(ctx, mesh, degree, cells, faces);
      double time = lth_now() - start;
      if (time < best) best = time;
    }
    snprintf(name, sizeof name, "%s, degree %d, %d threads", kind, degree, lth_threads(ctx));
    print_row("1000 elements and faces", name, best * 1000 / mesh->n_cells, NAN);
  }
done:
  lth_free(ctx, cells);
  lth_free(ctx, faces);
  return status;
}

/// Moments, orthogonal bases and trace constants.
static LitheStatus thousand_bases(LitheCtx *ctx, const char *kind, const LthMesh *mesh) {
  for (int degree = 1; degree <= LTH_DG_MAX_DEGREE; degree++) {
    char name[64];
    double best = 1e30;
    for (int run = 0; run < RUNS; run++) {
      LthDgSpace *space = NULL;
      double start = lth_now();
      LITHE_TRY(lth_dg_space_create(ctx, mesh, degree, NULL, &space));
      double time = lth_now() - start;
      lth_dg_space_destroy(ctx, &space);
      if (time < best) best = time;
    }
    snprintf(name, sizeof name, "%s, degree %d, %d threads", kind, degree, lth_threads(ctx));
    print_row("1000 bases", name, best * 1000 / mesh->n_cells, NAN);
  }
  return LITHE_OK;
}

static LitheStatus meshes(LitheCtx *ctx) {
  LitheStatus status = LITHE_OK;
  LthMesh *hexahedra = NULL, *tetrahedra = NULL;
  LthGrid ten = {{0, 0, 0}, {1, 1, 1}, {10, 10, 10}}, six = {{0, 0, 0}, {1, 1, 1}, {6, 6, 6}};
  LITHE_TRY_OR(done, lth_mesh_hexahedra(ctx, &ten, &hexahedra));
  LITHE_TRY_OR(done, lth_mesh_tetrahedra(ctx, &six, &tetrahedra));
  LITHE_TRY_OR(done, thousand_elements(ctx, "hexahedra", hexahedra));
  LITHE_TRY_OR(done, thousand_elements(ctx, "tetrahedra", tetrahedra));
  LITHE_TRY_OR(done, thousand_bases(ctx, "hexahedra", hexahedra));
  LITHE_TRY_OR(done, thousand_bases(ctx, "tetrahedra", tetrahedra));
done:
  lth_mesh_destroy(ctx, &hexahedra);
  lth_mesh_destroy(ctx, &tetrahedra);
  return status;
}

int main(int argc, char **argv) {
  csv = argc > 1 && strcmp(argv[1], "--csv") == 0;
  printf(csv ? "integrals,method,seconds,relative error\n"
             : "integrals                method                                          time   "
               "rel. error\n");
  corner_cut_cube(2);
  corner_cut_cube(4);
  LitheCtxDef def = lithe_ctx_def_default();
  LitheCtx *ctx = lithe_ctx_create(&def);
  if (!ctx) return EXIT_FAILURE;
  LitheStatus status = meshes(ctx);
  if (status) fprintf(stderr, "bench_moments: %s\n", lithe_ctx_message(ctx));
  lithe_ctx_destroy(&ctx);
  return lithe_status_exit(status);
}
