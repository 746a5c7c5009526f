/// Figure 10, right: a solid carved out of a cube of elements by the planes of its own triangles.
#include "study/kaufmann_studies.h"
#include "study/view.h"

#include "io/file.h"

#include <math.h>
#include <string.h>
#include <unistd.h>

#define MANY 20000 ///< triangles that are drawn without their edges

static const char bunny_file[] = "/usr/share/glmark2/models/bunny.obj";

/// A cube with room for both solids; %s: the file of what is carved, what stays.
static const char carve_scene[] =
    "# A solid carved out of a cube of elements (Fig. 10, right).\n"
    "lithe: 1\n"
    "title: Carved out of a cube\n"
    "bodies:\n"
    "  - name: cube\n"
    "    shape: {box: {min: [-0.12, -0.01, -0.1], max: [0.12, 0.23, 0.14]}}\n"
    "    material: {young_modulus: 100 kPa, poisson_ratio: 0.3, density: 1000}\n"
    "    method: {kind: dg, degree: 1, cells: 4}\n"
    "cuts:\n"
    "  - {at: 0, carve: {mesh: {file: %s, fit: 0.2}}, keep: both}\n"
    "time: {kind: dynamic, step: 1 ms, duration: 1 ms}\n"
    "output: {fields: none}\n";

/// The same solid, sliced.
static const char slice_scene[] =
    "# The solid of the carving alone, sliced.\n"
    "lithe: 1\n"
    "title: Sliced\n"
    "bodies:\n"
    "  - shape: {mesh: {file: %s, fit: 0.2}}\n"
    "    material: {young_modulus: 100 kPa, poisson_ratio: 0.3, density: 1000}\n"
    "    method: {kind: dg, degree: 1, cells: 6}\n"
    "time: {kind: dynamic, step: 1 ms, duration: 1 ms}\n"
    "output: {fields: none}\n";

/// What is seen of the elements after carving.
typedef struct Carved {
  LthView view;
  LthMeshQuality quality;
  double cut[2]
            [2]; ///< area [m^2] and number of the cut's faces, of elements in and out of the solid
} Carved;

/// Parts that reach the cube's sides are outside of the solid, others in it.
static LitheStatus measure(LitheCtx *ctx, const LthMesh *m, Carved *carved) {
  LitheStatus status = LITHE_OK;
  LitheIndex *part = NULL, n;
  uint8_t *is_out = NULL;
  LTH_NEW_OR(done, ctx, part, m->n_cells);
  LTH_NEW_OR(done, ctx, is_out, m->n_cells);
  LITHE_TRY_OR(done, lth_mesh_parts(ctx, m, part, &n));
  for (LitheIndex f = 0; f < m->n_faces; f++)
    if (m->face_cell[2 * f + 1] < 0 && m->face_tag[f] > LTH_TAG_CUT)
      is_out[part[m->face_cell[2 * f]]] = 1;
  for (LitheIndex f = 0; f < m->n_faces; f++) {
    if (m->face_tag[f] > LTH_TAG_CUT) continue;
    double *cut = carved->cut[is_out[part[m->face_cell[2 * f]]]];
    cut[0] += m->face_area[f];
    cut[1]++;
  }
  LITHE_TRY_OR(done, lth_mesh_quality(ctx, m, &carved->quality));
done:
  lth_free(ctx, part);
  lth_free(ctx, is_out);
  return status;
}

static LitheStatus look(void *user, LitheCtx *ctx, const LthWorld *world, LitheIndex frame) {
  Carved *carved = user;
  memset(carved->cut, 0, sizeof carved->cut);
  LITHE_TRY(measure(ctx, world->bodies[0]->mesh, carved));
  LITHE_TRY(lth_view_look(&carved->view, ctx, world, frame));
  // the faces of a bunny are smaller than their outlines are wide
  if (carved->view.n > MANY) memset(carved->view.edges, 0, (size_t)carved->view.n);
  return LITHE_OK;
}

/// A cube of side 1 with a spike of each corner, four of whose edges dent each side to its middle: half its volume.
static LitheStatus write_star(LthStudyRun *run, const char *name) {
  LthFileWriter writer;
  char *path;
  LITHE_TRY(lth_path_join(run->ctx, run->folder, name, &path));
  LitheStatus status = lth_file_open(run->ctx, path, &writer);
  lth_free(run->ctx, path);
  LITHE_TRY(status);
  for (int i = 0; i < 8; i++) fprintf(writer.stream, "v %d %d %d\n", i & 1, i >> 1 & 1, i >> 2 & 1);
  fputs("v 0 .5 .5\nv 1 .5 .5\nv .5 0 .5\nv .5 1 .5\nv .5 .5 0\nv .5 .5 1\n", writer.stream);
  for (int i = 0; i < 8; i++) {
    const int x = 9 + (i & 1), y = 11 + (i >> 1 & 1), z = 13 + (i >> 2 & 1);
    const bool is_even = ((i ^ i >> 1 ^ i >> 2) & 1) != 0;
    const int ring[3] = {x, is_even ? y : z, is_even ? z : y};
    for (int k = 0; k < 3; k++)
      fprintf(writer.stream, "f %d %d %d\n", i + 1, ring[k], ring[(k + 1) % 3]);
  }
  return lth_file_commit(run->ctx, &writer);
}

/// Carve, keeping what is in the solid and then, if asked for, both sides, and write a row of each.
static LitheStatus carve(LthStudyRun *run, const char *name, const char *file, int cells, int n,
                         Carved *in, LthTable *t) {
  static const char *const keep[2] = {"inside", "both"};
  Carved both = {.view = {.run = run}};
  Carved *carved[2] = {in, &both};
  LthStudyResult sliced, result;
  const char *solid = lth_study_print(run, "%s-sliced", name);
  LITHE_TRY(lth_study_run_text(run, solid, lth_study_print(run, slice_scene, file), NULL, &sliced));
  const double exact = lth_study_number(&sliced, "bodies.0.volume"), cube = 0.24 * 0.24 * 0.24;
  for (int k = 0; k < n; k++) {
    const char *const sets[] = {lth_study_print(run, "bodies.0.method.cells=%d", cells),
                                lth_study_print(run, "cuts.0.keep=%s", keep[k])};
    LthRunLook looks = {look, carved[k]};
    const char *scene = lth_study_print(run, "%s-%s", name, keep[k]);
    LITHE_TRY(lth_study_run_with(run, scene, lth_study_print(run, carve_scene, file), 2, sets,
                                 &looks, &result));
    const Carved *c = carved[k];
    const double total = c->cut[0][0] + c->cut[1][0];
    lth_table_row(t, scene,
                  (double[]){cells, lth_study_number(&result, "bodies.0.elements"),
                             c->cut[0][1] + c->cut[1][1], c->quality.volume,
                             fabs(c->quality.volume / (k == 0 ? exact : cube) - 1),
                             k == 0 ? NAN : fabs(c->cut[0][0] - c->cut[1][0]) / total,
                             c->quality.max_gap, lth_study_number(&result, "time.total")});
  }
  return LITHE_OK;
}

static void judge(LthStudyReport *r, const LthTable *t) {
  enum { MISS = 4, MISFIT, GAP };
  double miss = 0, misfit = 0, gap = 0;
  for (int i = 0; i < t->n_rows; i++) {
    miss = fmax(miss, lth_table_at(t, i, MISS));
    if (!isnan(lth_table_at(t, i, MISFIT))) misfit = fmax(misfit, lth_table_at(t, i, MISFIT));
    gap = fmax(gap, lth_table_at(t, i, GAP));
  }
  lth_study_at_most(r, "volume against that of the sliced solid, and of the cube, relative", miss,
                    1e-9, "parts thinner than rounding stay with a neighbour");
  lth_study_at_most(r, "areas of the two sides of the cut: difference over sum", misfit, 1e-9,
                    "both sides fit");
  lth_study_at_most(r, "gap of any element over its area", gap, 1e-9, "each is closed");
}

LitheStatus lth_study_carve(LthStudyRun *run) {
  static Carved carved[2];
  LthStudyReport *r = &run->report;
  LthTable *t = lth_study_table(r, "carve", "Solids carved out of a cube of elements (Fig. 10)",
                                "solid, what stays");
  lth_table_column(t, "cells along the cube", "", 0);
  lth_table_column(t, "elements", "", 0);
  lth_table_column(t, "faces of the cut", "", 0);
  lth_table_column(t, "volume", "m^3", 8);
  lth_table_column(t, "off the exact volume, relative", "", 2);
  lth_table_column(t, "misfit of the two sides' areas", "", 2);
  lth_table_column(t, "largest gap over area", "", 2);
  lth_table_column(t, "time", "s", 2);
  for (int k = 0; k < 2; k++) carved[k] = (Carved){.view = {.run = run}};
  carved[0].view.label = "star";
  carved[1].view.label = "bunny";
  LITHE_TRY(write_star(run, "star.obj"));
  LITHE_TRY(carve(run, "star", "star.obj", 4, 2, carved, t));
  int n = 1;
  if (!run->quick && access(bunny_file, R_OK) == 0) {
    LITHE_TRY(carve(run, "bunny", bunny_file, 20, 1, carved + 1, t));
    n = 2;
  } else if (!run->quick) {
    lth_study_say(r, "The bunny is left out: %s is not there (Debian: glmark2-data).", bunny_file);
  }
  LthView views[2] = {carved[0].view, carved[1].view};
  judge(r, t);
  return lth_views_draw(run, n, views, (const double[]){0.4, 0.4, 1}, (const double[]){0, 1, 0},
                        "carved-drawn", "What the carving leaves inside, and its elements");
}
