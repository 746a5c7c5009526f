/// Random blades with bends, and carving, through bodies that move: their embedded surfaces are cut wherever the elements
/// are, have two polygons at every edge, keep their volume, and no vertex follows elements of two sides.
#include "base/tensor.h"
#include "closed_soup.h"
#include "geometry/bvh.h"
#include "random_text.h"
#include "scene/cut.h"
#include "scene/cut_surface.h"
#include "scene_text.h"

#include <math.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

#define CUTS 2
#define STEP 0.01
#define ROUND 9   ///< halves of a meridian of the ball
#define PROBES 40 ///< of a blade, in each direction

/// Three to eight facets that turn to and fro, from below the body upward or to its inside.
static void add_blade(Text *t, int i) {
  int n = 3 + pick(6);
  double x = between(-1.1, -0.2), y = between(-0.5, 0.5), angle = between(-0.6, 0.6);
  ADD(t, "  - {at: %g, space: %s, blade: {path: [", STEP * (i + 0.5),
      pick(2) ? "rest" : "deformed");
  for (int k = 0; k <= n; k++) {
    ADD(t, "%s[%.3f, %.3f, %.3f]", k ? ", " : "", x, y, -1.3 + 0.05 * (k % 2));
    double length = between(0.06, 2.6 / n);
    x += length * cos(angle);
    y += length * sin(angle);
    angle += between(-0.7, 0.7);
  }
  ADD(t, "], depth: [%.3f, %.3f, %.3f]}}\n", between(-0.3, 0.3), between(-0.3, 0.3),
      pick(3) ? 2.6 : between(0.6, 2.4));
}

/// A box of which both sides stay; round solids are carved by test_cli_cut_closed.
static void add_carve(Text *t, int i) {
  double x = between(-0.6, 0.6), y = between(-0.4, 0.4), z = between(-0.4, 0.4);
  ADD(t, "  - {at: %g, space: %s, keep: both, carve: {", STEP * (i + 0.5),
      pick(2) ? "rest" : "deformed");
  ADD(t, "box: {min: [%.3f, %.3f, %.3f], max: [%.3f, %.3f, %.3f]}}}\n", x, y, z,
      x + between(0.2, 0.8), y + between(0.2, 0.6), z + between(0.2, 0.6));
}

static void add_solid(Text *t) {
  switch (pick(3)) {
  case 0:
    ADD(t, "    shape: {sphere: {center: [0, 0, 0], radius: %.3f}, resolution: 0.3}\n",
        between(0.6, 1));
    break;
  case 1:
    ADD(t, "    shape: {box: {min: [-1, -0.7, -0.6], max: [1, 0.7, 0.6]}}\n");
    break;
  default:
    ADD(t, "    shape: {difference: [{box: {min: [-1, -0.7, -0.6], max: [1, 0.7, 0.6]}}, "
           "{cylinder: {from: "
           "[0, 0, -1], to: [0, 0.2, 1], radius: 0.3}}], resolution: 0.3}\n");
  }
}

/// A ball as a file: a surface of its own.
static void write_ball(const char *path, const double center[3], double radius) {
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  for (int i = 0; i <= ROUND; i++)
    for (int j = 0; j < (i % ROUND ? 2 * ROUND : 1); j++) {
      double t = M_PI * i / ROUND, p = M_PI * j / ROUND;
      fprintf(file, "v %.17g %.17g %.17g\n", center[0] + radius * sin(t) * cos(p),
              center[1] + radius * cos(t), center[2] - radius * sin(t) * sin(p));
    }
  for (int i = 0; i < ROUND; i++)
    for (int j = 0; j < 2 * ROUND; j++) {
      int low = 2 + 2 * ROUND * (i - 1), high = low + 2 * ROUND, next = (j + 1) % (2 * ROUND);
      if (i == 0)
        fprintf(file, "f 1 %d %d\n", 2 + j, 2 + next);
      else if (i == ROUND - 1)
        fprintf(file, "f %d %d %d\n", low + j, high, low + next);
      else
        fprintf(file, "f %d %d %d %d\n", low + j, high + j, high + next, low + next);
    }
  fclose(file);
}

static void write_scene(Text *t, const char *ball) {
  static const char *const degrees[] = {"1", "1", "2", "\"2+x\""};
  t->n = 0;
  ADD(t, "lithe: 1\nbodies:\n  - name: solid\n");
  add_solid(t);
  ADD(t,
      "    material: {young_modulus: 1e4, poisson_ratio: 0.3, density: 1000}\n"
      "    method: {kind: dg, cells: %d, degree: %s, flux: ip, sliver: %s}\n",
      2 + pick(3), degrees[pick(4)], pick(2) ? "0.05" : "0.002");
  if (ball)
    ADD(t, "    embed: {surface: {file: %s}}\n", ball);
  else
    ADD(t, "    embed: {surface: shape}\n");
  ADD(t, "    initial: {velocity: [\"y\", \"1+x*3\", \"x-y\"], displacement: [\"0.05*y\", 0, "
         "\"0.03*x*y\"]}\ngravity: [0, -9.81, 0]\ncuts:\n");
  for (int i = 0; i < CUTS; i++) pick(4) ? add_blade(t, i) : add_carve(t, i);
  ADD(t, "time: {kind: dynamic, duration: 1, step: 0.01}\nsolver: {linear: cholesky}\n");
  assert_true(t->n < sizeof t->at);
}

static Text text;
static uint64_t begin;
#define FAIL(...)                                                                                  \
  do {                                                                                             \
    char what[500];                                                                                \
    snprintf(what, sizeof what, __VA_ARGS__);                                                      \
    fail_msg("LITHE_TEST_SEED=%llu: %s\n%s", (unsigned long long)begin, what, text.at);            \
  } while (0)

// --- the surface is closed ---

static void check_closed(const LthSoup *s) {
  LitheIndex open[2];
  if (!soup_is_closed(s, open)) FAIL("edge %d %d is open", open[0], open[1]);
  if (!soup_is_manifold(s, open)) FAIL("edge %d %d has not two polygons", open[0], open[1]);
}

// --- its parts have the volume of their elements ---

static double polygon_volume(const LthSoup *s, LitheIndex p) {
  double volume = 0;
  for (LitheIndex i = s->poly_off[p] + 1; i + 1 < s->poly_off[p + 1]; i++) {
    const double *x = s->points + 3 * s->poly_point[s->poly_off[p]],
                 *y = s->points + 3 * s->poly_point[i], *z = s->points + 3 * s->poly_point[i + 1];
    double c[3];
    lth_v3_cross(y, z, c);
    volume += lth_v3_dot(x, c) / 6;
  }
  return volume;
}

static void check_volumes(const LthTopology *t, const LthSkin *skin, const LitheIndex *part,
                          double whole) {
  const LthSoup *s = skin->soup;
  double *volume = calloc((size_t)t->n_cells, sizeof *volume), sum = 0;
  for (LitheIndex p = 0; p < s->n_polys; p++) {
    LitheIndex of = part[skin->cell[s->poly_point[s->poly_off[p]]]];
    for (LitheIndex i = s->poly_off[p]; i < s->poly_off[p + 1]; i++)
      if (part[skin->cell[s->poly_point[i]]] != of) FAIL("polygon %d hangs on two parts", p);
    volume[of] += polygon_volume(s, p);
  }
  for (LitheIndex c = 0; c < t->n_cells; c++) sum += volume[c];
  if (!(fabs(sum - whole) < 1e-11 * whole)) FAIL("volume %.17g was %.17g", sum, whole);
  for (LitheIndex c = 0; c < t->n_cells; c++)
    if (t->cells[c].is_live) volume[part[c]] -= t->cells[c].volume;
  for (LitheIndex c = 0; c < t->n_cells; c++)
    if (!(fabs(volume[c]) < 1e-11 * whole)) FAIL("part %d is off by %g", c, volume[c]);
  free(volume);
}

// --- vertices follow one side ---

static void check_sides(const LthBody *body, const LitheIndex *part) {
  const LthEmbedding *e = body->embedding;
  const LitheIndex *record = body->change->cell_record;
  for (LitheIndex p = 0; p < e->n_points; p++)
    for (LitheCount i = e->off[p]; i < e->off[p + 1]; i++)
      for (LitheCount k = e->sample_row_off[e->sample[i]]; k < e->sample_row_off[e->sample[i] + 1];
           k++)
        if (part[record[e->sample_row[k]]] != part[record[e->cell[p]]])
          FAIL("vertex %d follows two parts", p);
}

// --- rows that are kept are those of a whole embedding ---

static void check_same(const void *a, const void *b, size_t size, const char *name) {
  if (memcmp(a, b, size) != 0) FAIL("kept rows differ: %.20s", name);
}

static void check_rows(LitheCtx *ctx, const LthBody *body) {
  const LthEmbedding *got = body->embedding;
  LthEmbedding *want = NULL;
  CHECK_OK(ctx, lth_embedding_create(ctx, body->space, got->n_points, got->rest, got->cell,
                                     body->def->interpolation, body->def->samples, &want));
  size_t n = (size_t)want->off[want->n_points], n_samples = (size_t)want->n_samples;
  if (got->n_samples != want->n_samples || got->n_own != want->n_own) FAIL("other samples");
  check_same(got->off, want->off, sizeof *want->off * ((size_t)want->n_points + 1), "lengths");
  check_same(got->sample, want->sample, sizeof *want->sample * n, "samples");
  check_same(got->weight, want->weight, sizeof *want->weight * n, "weights");
  check_same(got->sample_point, want->sample_point, 3 * sizeof(double) * n_samples, "places");
  lth_embedding_destroy(ctx, &want);
}

// --- the surface is cut all along a blade ---

static bool is_on_cut(const LthTopology *t, const double x[3]) {
  for (LitheIndex i = 0; i < t->n_faces; i++) {
    const LthTopologyFace *f = t->faces + i;
    if (!f->is_live || f->is_line || f->tag > LTH_TAG_CUT) continue;
    LthFaceView v = lth_topology_face(t, i);
    if (lth_face_distance2(&v, x) < 1e-18) return true;
  }
  return false;
}

static double winding(const LthTopology *t, const double x[3]) {
  double angle = 0;
  for (LitheIndex i = 0; i < t->n_faces; i++) {
    if (!t->faces[i].is_live || t->faces[i].cell[1] >= 0) continue;
    LthFaceView v = lth_topology_face(t, i);
    for (LitheIndex l = 0; l < v.n_loops; l++)
      for (LitheIndex k = v.loop_off[l] + 1; k + 1 < v.loop_off[l + 1]; k++)
        angle +=
            lth_solid_angle(v.points + 3 * v.loop_point[v.loop_off[l]],
                            v.points + 3 * v.loop_point[k], v.points + 3 * v.loop_point[k + 1], x);
  }
  return angle / (4 * M_PI);
}

/// A little to both sides of the blade: on it, solid angles of faces in its plane have any sign.
static bool is_inside(const LthTopology *t, const double x[3], const double normal[3]) {
  for (int side = -1; side <= 1; side += 2) {
    double beside[3];
    lth_v3_copy(x, beside);
    lth_v3_axpy(1e-6 * side, normal, beside);
    if (winding(t, beside) < 0.5) return false;
  }
  return true;
}

/// Where the blade is in both the body and what its surface encloses, that is cut.
static void check_blade(const LthTopology *body, const LthTopology *solid, const LthSceneCut *cut,
                        int *n_probes) {
  for (LitheIndex i = 0; i + 1 < cut->n_path; i++)
    for (int k = 0; k < PROBES; k++) {
      double x[3], edge[3], normal[3], along = between(0.01, 0.99), down = between(0.01, 0.99);
      lth_v3_sub(cut->path[i + 1], cut->path[i], edge);
      lth_v3_cross(edge, cut->depth, normal);
      lth_v3_normalize(normal);
      lth_v3_copy(cut->path[i], x);
      lth_v3_axpy(along, edge, x);
      lth_v3_axpy(down, cut->depth, x);
      if (!is_inside(body, x, normal) || !is_inside(solid, x, normal)) continue;
      ++*n_probes;
      if (!is_on_cut(solid, x)) FAIL("facet %d is not cut at (%g %g %g)", i, x[0], x[1], x[2]);
    }
}

static void check(LitheCtx *ctx, const LthBody *body, const LthSceneCut *cut, double whole,
                  int *n_probes) {
  const LthCutSurface *surface = body->change->surface;
  const LthTopology *t = surface->solid ? surface->solid : body->change->topology;
  LitheIndex *part = find_parts(t), *of_body = find_parts(body->change->topology);
  check_closed(surface->skin->soup);
  check_volumes(t, surface->skin, part, whole);
  check_sides(body, of_body);
  check_rows(ctx, body);
  if (cut->at_rest && cut->kind == LTH_CUT_BLADE)
    check_blade(body->change->topology, t, cut, n_probes);
  free(part);
  free(of_body);
}

static int run_body(bool is_other, int *n_probes) {
  int n_cuts = 0;
  double times[2], whole = 0;
  LthWorld *world = NULL;
  char ball[40] = "";
  begin = seed;
  if (is_other) {
    double center[3] = {between(-0.3, 0.3), between(-0.2, 0.2), between(-0.1, 0.1)};
    snprintf(ball, sizeof ball, "blades-%d.obj", (int)getpid());
    write_ball(ball, center, between(0.3, 0.5));
  }
  write_scene(&text, is_other ? ball : NULL);
  Reading r = read_with(text.at, 0, NULL);
  if (r.status == LITHE_OK) r.status = lth_world_create(r.ctx, r.scene, times, &world);
  if (is_other) remove(ball);
  if (r.status == LITHE_OK) {
    const LthBodyChange *c = world->bodies[0]->change;
    whole = (c->surface->solid ? c->surface->solid : c->topology)->volume;
  }
  for (int i = 0; i < CUTS && r.status == LITHE_OK; i++) {
    bool changed = false;
    r.status = lth_world_cut_due(r.ctx, world, STEP * (i + 1), &changed);
    if (r.status != LITHE_OK) break;
    n_cuts += changed;
    if (changed) check(r.ctx, world->bodies[0], r.scene->cuts + i, whole, n_probes);
    r.status = lth_simulation_step(r.ctx, world->sim, STEP);
  }
  if (r.status != LITHE_OK) FAIL("%s", lithe_ctx_message(r.ctx));
  lth_world_destroy(r.ctx, &world);
  end_reading(&r);
  return n_cuts;
}

static void run_bodies(bool is_other) {
  const char *much = getenv("LITHE_TEST_OPERATIONS");
  int n = much ? atoi(much) : 4, n_cuts = 0, n_bodies = 0, n_probes = 0;
  for (; n_cuts < n && n_bodies < n; n_bodies++) n_cuts += run_body(is_other, &n_probes);
  printf("%d cuts of %d bodies, %d places looked at\n", n_cuts, n_bodies, n_probes);
  assert_true(n_cuts >= n);
  assert_true(n < 30 || n_probes > n); // few bodies may have blades in deformed space alone
}

static void surfaces_follow_blades_with_bends(void **state) {
  (void)state;
  run_bodies(false);
}

static void surfaces_of_their_own_follow_them_too(void **state) {
  (void)state;
  run_bodies(true);
}

int main(void) {
  const char *fixed = getenv("LITHE_TEST_SEED");
  seed = fixed ? strtoull(fixed, NULL, 10) : (uint64_t)time(NULL);
  printf("LITHE_TEST_SEED=%llu\n", (unsigned long long)seed);
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(surfaces_follow_blades_with_bends),
      cmocka_unit_test(surfaces_of_their_own_follow_them_too),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
