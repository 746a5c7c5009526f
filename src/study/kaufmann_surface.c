/// Figures 5 to 7: surfaces that follow a discontinuous body, contact on them, and what slicing keeps apart.
#include "study/kaufmann_studies.h"
#include "study/view.h"

#include "embed/embedding.h"

#include <string.h>
#include <unistd.h>

// --- Figure 5 ---

static const char bend_scene[] =
    "# A bar of four cubes, clamped on the left, bends under its weight; its surface is embedded "
    "(Fig. 5).\n"
    "lithe: 1\n"
    "title: Embedded bar\n"
    "bodies:\n"
    "  - name: bar\n"
    "    shape: {box: {min: [0, 0, 0], max: [4, 1, 1]}}\n"
    "    material: {model: corotated, young_modulus: 1 kPa, poisson_ratio: 0.3, density: 1}\n"
    "    method: {kind: dg, cells: [4, 1, 1], mesh: hexahedra, degree: 1}\n"
    "    embed: {surface: shape, interpolation: mls}\n"
    "    constraints:\n"
    "      - {where: {plane: {point: [0, 0, 0], normal: [-1, 0, 0]}}, displacement: [0, 0, 0]}\n"
    "gravity: [0, 0, -5]\n"
    "time: static\n"
    "output: {fields: none, surface: [obj]}\n";

#define N_LINE 157 // of the upper side, x from 0.05 to 3.95

/// A curve on the upper side, y = 0.5: its slope, and how value and normal differ on both sides of x = 1, 2, 3 at
/// distances of 1e-2, 1e-3, 1e-4.
typedef struct Curve {
  double x[N_LINE], slope[N_LINE]; ///< [m], [degrees]
  double gap[3], kink[3];          ///< largest of the three planes [m], [degrees]
  LthView view;
} Curve;

/// Where points (n x 3) of the body are.
static LitheStatus follow(LitheCtx *ctx, const LthBody *body, int n, const double *rest,
                          double *now) {
  LthEmbedding *embedding = NULL;
  LITHE_TRY(lth_build_points(ctx, body, n, rest, NULL, &embedding));
  lth_embedding_apply(embedding, 1, lth_body_displacement(body), now);
  lth_embedding_destroy(ctx, &embedding);
  return LITHE_OK;
}

/// Angle of the line from a to b against x [degrees].
static double angle_of(const double *a, const double *b) {
  return atan2(b[2] - a[2], b[0] - a[0]) * 180 / M_PI;
}

static LitheStatus look_at_planes(LitheCtx *ctx, const LthBody *body, Curve *curve) {
  for (int k = 0; k < 3; k++) {
    double d = pow(10, -2 - k), rest[36], now[36];
    for (int i = 0; i < 12; i++) {
      static const double at[4] = {-2, -1, 1, 2};
      rest[3 * i] = 1 + i / 4 + d * at[i % 4];
      rest[3 * i + 1] = 0.5;
      rest[3 * i + 2] = 1;
    }
    LITHE_TRY(follow(ctx, body, 12, rest, now));
    curve->gap[k] = curve->kink[k] = 0;
    for (int plane = 0; plane < 3; plane++) {
      const double *p = now + 12 * plane;
      double off = 0; // both sides continued to the plane
      for (int a = 0; a < 3; a++) off += pow(2 * p[3 + a] - p[a] - (2 * p[6 + a] - p[9 + a]), 2);
      curve->gap[k] = fmax(curve->gap[k], sqrt(off));
      curve->kink[k] = fmax(curve->kink[k], fabs(angle_of(p, p + 3) - angle_of(p + 6, p + 9)));
    }
  }
  return LITHE_OK;
}

#define FINE 24 // lines of a picture a metre

/// A side of the bar, m x n metres, with a line where elements end.
static LitheStatus see_side(LitheCtx *ctx, const LthBody *body, const double origin[3], int along,
                            int m, int across, int n, LthView *view) {
  LitheStatus status = LITHE_OK;
  double *rest = NULL, *now = NULL;
  int columns = m * FINE + 1, rows = n * FINE + 1;
  LTH_NEW_OR(done, ctx, rest, 3 * columns * rows);
  LTH_NEW_OR(done, ctx, now, 3 * columns * rows);
  for (int k = 0; k < columns * rows; k++) {
    for (int a = 0; a < 3; a++) rest[3 * k + a] = origin[a];
    rest[3 * k + along] += (double)(k % columns) / FINE;
    rest[3 * k + across] += (double)(k / columns) / FINE;
  }
  LITHE_TRY_OR(done, follow(ctx, body, columns * rows, rest, now));
  status = lth_view_add_grid(view, columns, rows, now, FINE);
done:
  lth_free(ctx, rest);
  lth_free(ctx, now);
  return status;
}

static LitheStatus see_bar(LitheCtx *ctx, const LthBody *body, LthView *view) {
  static const double corner[3] = {0, 0, 0}, top[3] = {0, 0, 1}, end[3] = {4, 0, 0};
  LITHE_TRY(see_side(ctx, body, corner, 0, 4, 2, 1, view));
  LITHE_TRY(see_side(ctx, body, top, 0, 4, 1, 1, view));
  return see_side(ctx, body, end, 1, 1, 2, 1, view);
}

static LitheStatus look_at_curve(void *user, LitheCtx *ctx, const LthWorld *world,
                                 LitheIndex frame) {
  Curve *curve = user;
  double rest[6 * N_LINE], now[6 * N_LINE];
  (void)frame;
  for (int i = 0; i < 2 * N_LINE; i++) {
    curve->x[i / 2] = 0.05 + 3.9 * (i / 2) / (N_LINE - 1);
    rest[3 * i] = curve->x[i / 2] + (i % 2 ? 1e-4 : -1e-4);
    rest[3 * i + 1] = 0.5;
    rest[3 * i + 2] = 1;
  }
  LITHE_TRY(follow(ctx, world->bodies[0], 2 * N_LINE, rest, now));
  for (int i = 0; i < N_LINE; i++) curve->slope[i] = angle_of(now + 6 * i, now + 6 * i + 3);
  curve->view.n = 0;
  LITHE_TRY(see_bar(ctx, world->bodies[0], &curve->view));
  return look_at_planes(ctx, world->bodies[0], curve);
}

LitheStatus lth_study_smoothness(LthStudyRun *run) {
  static const char *const names[2] = {"stitched", "mls"};
  static Curve curves[2];
  LthStudyReport *r = &run->report;
  for (int k = 0; k < 2; k++) {
    LthStudyResult result;
    LthRunLook look = {look_at_curve, curves + k};
    curves[k].view = (LthView){.run = run, .label = names[k]};
    const char *const sets[] = {lth_study_print(run, "bodies.0.embed.interpolation=%s", names[k])};
    LITHE_TRY(lth_study_run_with(run, names[k], bend_scene, 1, sets, &look, &result));
  }
  LthTable *slope = lth_study_table(r, "slope", "Slope of the upper side along the bar", NULL);
  slope->is_curve = true;
  lth_table_column(slope, "x", "m", 4);
  for (int k = 0; k < 2; k++) lth_table_column(slope, names[k], "degrees", 5);
  for (int i = 0; i < N_LINE; i++)
    lth_table_row(slope, NULL, (double[]){curves[0].x[i], curves[0].slope[i], curves[1].slope[i]});
  LthTable *t = lth_study_table(r, "jumps", "Jumps across element boundaries, at a distance", NULL);
  lth_table_column(t, "distance", "m", 1);
  for (int k = 0; k < 2; k++) {
    lth_table_column(t, lth_study_print(run, "%s: value", names[k]), "m", 3);
    lth_table_column(t, lth_study_print(run, "%s: normal", names[k]), "degrees", 3);
  }
  for (int i = 0; i < 3; i++)
    lth_table_row(t, NULL,
                  (double[]){pow(10, -2 - i), curves[0].gap[i], curves[0].kink[i], curves[1].gap[i],
                             curves[1].kink[i]});
  LthPlot *plot =
      lth_study_plot(r, "slope", "Slope of an embedded surface across elements (Fig. 5)",
                     "x [m]; elements end at 1, 2, 3", "slope [degrees]");
  for (int k = 0; k < 2; k++) lth_plot_series(plot, names[k], slope, 0, k + 1);
  lth_study_at_least(r, "stitched: jump of the normal at 1e-4 m [degrees]", curves[0].kink[2], 2,
                     "\"C0 artifacts\": a kink that is seen in shading, however near one looks");
  lth_study_at_most(r, "stitched: jump of the value at 1e-4 m over the bar's height",
                    curves[0].gap[2], 1e-3,
                    "averages at the mesh points make the surface continuous");
  lth_study_at_most(
      r, "MLS: jump of the normal at 1e-4 m [degrees]", curves[1].kink[2], 0.05,
      "smooth weights: the normal is continuous, so that the jump falls with the distance");
  lth_study_at_most(r, "MLS: that over the one at 1e-3 m", curves[1].kink[2] / curves[1].kink[1],
                    0.15, "in proportion to the distance");
  double step = 0;
  for (int i = 1; i < N_LINE; i++)
    step = fmax(step, fabs(curves[1].slope[i] - curves[1].slope[i - 1]));
  lth_study_at_most(
      r, "MLS: largest change of slope in 0.025 m, all along the bar [degrees]", step, 0.5,
      "the bar bends by at most 12 degrees in a metre: 0.3 in a step. A Gaussian that "
      "is merely cut off, as in the paper, leaves kinks of a degree where the reach "
      "of a sample ends");
  lth_study_at_most(r, "MLS: jump of the value at 1e-4 m over the bar's height", curves[1].gap[2],
                    1e-6, "continuous");
  const LthView views[2] = {curves[0].view, curves[1].view};
  return lth_views_draw(run, 2, views, (const double[]){0.2, -1, 0.3}, (const double[]){0, 0, 1},
                        "bars", "The embedded surface; lines stand where elements end");
}

// --- Figure 6 ---

static const char ball_scene[] =
    "# A soft ball of 5 cm on a floor; contact acts on the mesh's nodes or on the embedded surface "
    "(Fig. 6).\n"
    "lithe: 1\n"
    "title: Ball on a floor\n"
    "bodies:\n"
    "  - name: ball\n"
    "    shape: {sphere: {center: [0, 5 cm, 0], radius: 5 cm}, resolution: 1 cm}\n"
    "    material: {model: corotated, young_modulus: 20 kPa, poisson_ratio: 0.4, density: 1000, "
    "damping: {mass: 10}}\n"
    "    method: {kind: dg, cells: 3, degree: 1}\n"
    "    embed: {surface: shape}\n"
    "gravity: [0, -9.81, 0]\n"
    "colliders:\n"
    "  - plane: {point: [0, 0, 0], normal: [0, 1, 0]}\n"
    "contact: {points: surface}\n"
    "time: {kind: dynamic, duration: 0.5, step: 1/100}\n"
    "output: {every: last, fields: none, surface: [obj]}\n";

typedef struct Depths {
  double surface, height; ///< lowest point of the embedded surface below the floor, highest one [m]
  LthTable *profile;      ///< distance from the axis and height of its lower points [mm]
} Depths;

static LitheStatus look_at_depth(void *user, LitheCtx *ctx, const LthWorld *world,
                                 LitheIndex frame) {
  Depths *d = user;
  const LthBody *body = world->bodies[0];
  double *now;
  (void)frame;
  LTH_NEW(ctx, now, 3 * (LitheCount)body->embedding->n_points);
  lth_embedding_apply(body->embedding, 1, lth_body_displacement(body), now);
  d->surface = d->height = -INFINITY;
  for (LitheIndex i = 0; i < body->embedding->n_points; i++) {
    d->surface = fmax(d->surface, -now[3 * i + 1]);
    d->height = fmax(d->height, now[3 * i + 1]);
    if (now[3 * i + 1] < 0.02 && i % 2 == 0)
      lth_table_row(d->profile, NULL,
                    (double[]){1e3 * hypot(now[3 * i], now[3 * i + 2]), 1e3 * now[3 * i + 1]});
  }
  lth_free(ctx, now);
  return LITHE_OK;
}

LitheStatus lth_study_contact(LthStudyRun *run) {
  static const char *const names[2] = {"nodes", "surface"};
  LthStudyReport *r = &run->report;
  LthTable *t =
      lth_study_table(r, "depth", "A ball of radius 5 cm at rest on a floor", "contact acts on");
  lth_table_column(t, "surface below the floor", "mm", 3);
  lth_table_column(t, "contact's own penetration", "mm", 3);
  lth_table_column(t, "contact points", "", 0);
  lth_table_column(t, "highest point", "mm", 4);
  LthPlot *plot =
      lth_study_plot(r, "plot-profile", "Lower side of a ball on the floor at 0 (Fig. 6)",
                     "distance from the axis [mm]", "height of the surface [mm]");
  double depth[2];
  for (int k = 0; k < 2; k++) {
    LthStudyResult result;
    Depths d = {.profile = lth_study_table(r, lth_study_print(run, "profile-%s", names[k]),
                                           "Points of the lower side", NULL)};
    d.profile->is_curve = true;
    lth_table_column(d.profile, "distance from the axis", "mm", 4);
    lth_table_column(d.profile, "height", "mm", 4);
    LthRunLook look = {look_at_depth, &d};
    const char *const sets[] = {lth_study_print(run, "contact.points=%s", names[k])};
    LITHE_TRY(lth_study_run_with(run, names[k], ball_scene, 1, sets, &look, &result));
    depth[k] = d.surface;
    lth_plot_printed(plot, lth_study_print(run, "contact on %s", names[k]), d.profile, 0, 1);
    lth_table_row(t, names[k],
                  (double[]){1e3 * d.surface,
                             1e3 * lth_study_number(&result, "contact.penetration"),
                             lth_study_number(&result, "contact.points"), 1e3 * d.height});
  }
  lth_study_at_least(r, "nodes: depth of the surface below the floor over the radius",
                     depth[0] / 0.05, 0.03,
                     "nodes lie on the lines where cells meet: what bulges between them is not "
                     "held (Fig. 6, left)");
  lth_study_at_most(
      r, "surface: depth below the floor over the radius", depth[1] / 0.05, 0.01,
      "every point of the surface is held, up to the penalty's own give (Fig. 6, right)");
  lth_study_at_most(r, "surface over nodes", depth[1] / depth[0], 0.2,
                    "embedded contact is what the figure wants");
  return LITHE_OK;
}

// --- Figure 7 ---

static const char bunny_file[] = "/usr/share/glmark2/models/bunny.obj";

static const char ears_scene[] =
    "# One ear of the bunny is pulled; both pass through the same cells (Fig. 7).\n"
    "lithe: 1\n"
    "title: One ear pulled\n"
    "bodies:\n"
    "  - name: bunny\n"
    "    shape: {mesh: {file: /usr/share/glmark2/models/bunny.obj, fit: 20 cm}}\n"
    "    material: {model: corotated, young_modulus: 50 kPa, poisson_ratio: 0.4, density: 1000}\n"
    "    method: {kind: dg, cells: 6, degree: 1}\n"
    "    embed: {surface: shape}\n"
    "    constraints:\n"
    "      - {where: {plane: {point: [0, 15 cm, 0], normal: [0, -1, 0]}}, displacement: [0, 0, "
    "0]}\n"
    "    loads:\n"
    "      - {where: {sphere: {center: [-6.8 cm, 19.6 cm, -6.9 cm], radius: 2 cm}}, total_force: "
    "[0.2 N, 0, 0]}\n"
    "time: static\n"
    "probes:\n"
    "  - {name: pulled, point: [-6.83 cm, 19.2 cm, -6.94 cm]}\n"
    "  - {name: other, point: [-0.35 cm, 19.2 cm, -2.3 cm]}\n"
    "output: {fields: none}\n";

static double motion(LthStudyRun *run, const LthStudyResult *r, const char *probe) {
  double sum = 0;
  for (int a = 0; a < 3; a++)
    sum += pow(lth_study_number(r, lth_study_print(run, "probes.%s.displacement.%d", probe, a)), 2);
  return sqrt(sum);
}

enum { CELLS, ELEMENTS, PULLED, SHARE, EMBEDDED_PULLED, EMBEDDED_SHARE, COLUMNS };

LitheStatus lth_study_ears(LthStudyRun *run) {
  static const int cells[] = {4, 5, 6, 8};
  LthStudyReport *r = &run->report;
  if (access(bunny_file, R_OK) != 0) {
    lth_study_say(r, "Left out: %s is not there (Debian: glmark2-data). Nothing was run.",
                  bunny_file);
    return LITHE_OK;
  }
  LthTable *t =
      lth_study_table(r, "ears", "How far the other ear moves, as a share of the pulled one", NULL);
  lth_table_column(t, "cells along the longest side", "", 0);
  lth_table_column(t, "elements, sliced", "", 0);
  lth_table_column(t, "pulled, sliced", "mm", 3);
  lth_table_column(t, "share, sliced", "", 2);
  lth_table_column(t, "pulled, embedded", "mm", 3);
  lth_table_column(t, "share, embedded", "", 2);
  double most = 0, least = INFINITY;
  LthView views[2] = {
      {.run = run, .label = "sliced, 6 cells", .of_surface = true, .times = 4},
      {.run = run, .label = "pure embedding, 6 cells", .of_surface = true, .times = 4}};
  const LthRunLook looks[2] = {{lth_view_look, views}, {lth_view_look, views + 1}};
  for (int i = 0; i < 4; i++) {
    if (run->quick && cells[i] != 6) continue;
    LthStudyResult sliced, embedded;
    const char *const dg[] = {lth_study_print(run, "bodies.0.method.cells=%d", cells[i])};
    const char *const cg[] = {
        lth_study_print(run, "bodies.0.method={kind: cg, mesh: embedded, cells: %d}", cells[i])};
    LITHE_TRY(lth_study_run_with(run, lth_study_print(run, "sliced-%d", cells[i]), ears_scene, 1,
                                 dg, cells[i] == 6 ? looks : NULL, &sliced));
    LITHE_TRY(lth_study_run_with(run, lth_study_print(run, "embedded-%d", cells[i]), ears_scene, 1,
                                 cg, cells[i] == 6 ? looks + 1 : NULL, &embedded));
    double row[COLUMNS] = {cells[i], lth_study_number(&sliced, "bodies.0.elements")};
    row[PULLED] = 1e3 * motion(run, &sliced, "pulled");
    row[SHARE] = 1e3 * motion(run, &sliced, "other") / row[PULLED];
    row[EMBEDDED_PULLED] = 1e3 * motion(run, &embedded, "pulled");
    row[EMBEDDED_SHARE] = 1e3 * motion(run, &embedded, "other") / row[EMBEDDED_PULLED];
    lth_table_row(t, NULL, row);
    most = row[SHARE] <= most ? most : row[SHARE];
    least = fmin(least, row[EMBEDDED_SHARE] / row[SHARE]);
  }
  LthPlot *plot = lth_study_plot(r, "plot-ears",
                                 "One ear is pulled: how far the other one goes with it (Fig. 7)",
                                 "cells along the longest side [-]",
                                 "motion of the other ear over that of the pulled one [-]");
  plot->log_y = true;
  lth_plot_series(plot, "sliced (dg)", t, CELLS, SHARE);
  lth_plot_series(plot, "pure embedding (cg)", t, CELLS, EMBEDDED_SHARE);
  lth_study_at_most(r, "sliced: largest share of all grids", most, 0.02,
                    "each ear has elements of its own; what is left goes through the head");
  lth_study_at_least(
      r, "pure embedding over sliced: smallest ratio of the shares", least, 5,
      "\"a pure embedded simulation could lead to an erroneous coupling of the ears\"");
  return lth_views_draw(run, 2, views, (const double[]){0.1, 0.25, 1}, (const double[]){0, 1, 0},
                        "bunnies",
                        "One ear is pulled to the right, the body is held below; displacements are "
                        "drawn four times as large");
}
