/// Figure 8: a bar that is refined while it bends, and coarse again when it is let go; and what a refinement releases.
#include "study/kaufmann_studies.h"

#include "scene/adapt.h"
#include "study/draw.h"

#define FRAMES_MAX 64
#define CORNERS_MAX 32

#define BAR                                                                                        \
  "lithe: 1\n"                                                                                     \
  "title: A bar that is refined where stress gathers\n"                                            \
  "bodies:\n"                                                                                      \
  "  - name: bar\n"                                                                                \
  "    shape: {box: {min: [0, 0, 0], max: [4.5, 1, 1]}}\n"                                         \
  "    material: {model: corotated, young_modulus: 1 kPa, poisson_ratio: 0.3, density: 1}\n"       \
  "    method: {kind: dg, cells: [9, 2, 2], mesh: hexahedra, degree: 2}\n"                         \
  "    constraints:\n"                                                                             \
  "      - {where: {plane: {point: [0, 0, 0], normal: [-1, 0, 0]}}, displacement: [0, 0, 0]}\n"

static const char bent_scene[] = BAR
    "    loads: [{body_force: [0, 0, \"t < 1 ? -t : t - 2\"]}]\n"
    "gravity: [0, 0, 0]\n"
    "adapt:\n"
    "  h: {criterion: principal-stress, threshold: 20, coarsen: 0.7, split: eight, max_level: 2}\n"
    "time: {kind: quasistatic, steps: 20, duration: 2}\n"
    "output: {fields: none}\n";

static const char fall_scene[] =
    BAR "gravity: [0, 0, -1]\n"
        "adapt:\n"
        "  h: {criterion: principal-stress, threshold: 20, split: eight, max_level: 1}\n"
        "time: {kind: dynamic, duration: 1.2, step: 0.025}\n"
        "output: {every: 0.025, fields: none}\n";

/// What is seen of a bar at its output times.
typedef struct Bar {
  int n;
  double time[FRAMES_MAX], elements[FRAMES_MAX], root[FRAMES_MAX][3];
  LthDrawing *drawing; ///< NULL: not drawn
  double drawn_at, left;
} Bar;

/// The front of the bar as it is now: every boundary face that looks along -y, a polygon shaded by its level.
static void draw_front(const Bar *bar, const LthBody *body) {
  static const double box[4] = {-0.1, -0.7, 4.6, 1.15};
  const LthMesh *mesh = body->mesh;
  const double *x = lth_body_position(body);
  LthDrawing *d = bar->drawing;
  char colour[LTH_COLOUR_MAX];
  lth_draw_panel(d, box, bar->left, 24, 320);
  for (LitheIndex f = 0; f < mesh->n_faces; f++) {
    double place[2 * CORNERS_MAX];
    LitheIndex first = mesh->loop_off[mesh->face_loop_off[f]],
               n = mesh->loop_off[mesh->face_loop_off[f] + 1] - first,
               cell = mesh->face_cell[2 * f];
    if (mesh->face_cell[2 * f + 1] >= 0 || mesh->face_normal[3 * f + 1] > -0.9 || n > CORNERS_MAX)
      continue;
    for (LitheIndex i = 0; i < n; i++) {
      double at[3];
      lth_dg_sample(body->space, cell, x,
                    mesh->points + 3 * (LitheCount)mesh->loop_point[first + i], at);
      place[2 * i] = at[0], place[2 * i + 1] = at[2];
    }
    int level = body->change->level[body->change->cell_record[cell]];
    lth_draw_area_begin(d, lth_colour(0.9 - 0.18 * level, colour));
    lth_draw_area_add(d, n, place);
    lth_draw_area_end(d);
    for (LitheIndex i = 0; i < n; i++)
      lth_draw_line(d, place + 2 * i, place + 2 * ((i + 1) % n), 0.7, "#303030");
  }
}

static LitheStatus look(void *user, LitheCtx *ctx, const LthWorld *world, LitheIndex frame) {
  static const double at[3] = {0.3, 0.3, 0.8}; // near the clamp, off all faces
  Bar *bar = user;
  const LthBody *body = world->bodies[0];
  (void)ctx;
  if (frame >= FRAMES_MAX) return LITHE_OK;
  bar->n = frame + 1;
  bar->time[frame] = lth_simulation_time(world->sim);
  bar->elements[frame] = lth_body_elements(body);
  LitheIndex cell = 0;
  for (LitheIndex c = 0; c < body->mesh->n_cells; c++) { // boxes overlap where planes are oblique
    const double *box = body->mesh->cell_box + 6 * (LitheCount)c;
    bool holds = true;
    for (int a = 0; a < 3; a++) holds = holds && at[a] >= box[a] && at[a] <= box[3 + a];
    if (holds) cell = c;
  }
  lth_dg_sample(body->space, cell, lth_body_position(body), at, bar->root[frame]);
  if (bar->drawing && fabs(bar->time[frame] - bar->drawn_at) < 1e-9) draw_front(bar, body);
  return LITHE_OK;
}

static LitheStatus bend(LthStudyRun *run, const char *division, int levels, Bar *bar) {
  LthStudyResult r;
  LthRunLook see = {look, bar};
  const char *const sets[] = {lth_study_print(run, "adapt.h.split=%s", division),
                              lth_study_print(run, "adapt.h.max_level=%d", levels)};
  return lth_study_run_with(run, division, bent_scene, 2, sets, &see, &r);
}

static double at_full_load(const Bar *bar) {
  double elements = NAN;
  for (int i = 0; i < bar->n; i++)
    if (fabs(bar->time[i] - 1) < 1e-9) elements = bar->elements[i];
  return elements;
}

static LitheStatus draw_bars(LthStudyRun *run, Bar bar[2]) {
  LthDrawing d = {.ctx = run->ctx};
  lth_draw_begin(&d, 670, 160);
  lth_draw_words(&d, 8, 16, "(a) in eight, two levels");
  lth_draw_words(&d, 348, 16, "(b) in two, three levels");
  for (int i = 0; i < 2; i++) bar[i].drawing = &d, bar[i].drawn_at = 1, bar[i].left = 340 * i;
  LITHE_TRY(bend(run, "eight", 2, bar));
  LITHE_TRY(bend(run, "two", 3, bar + 1));
  const char *svg = lth_draw_end(&d, &run->arena);
  if (!svg) LITHE_FAIL(run->ctx, LITHE_NO_MEMORY, "out of memory in a study");
  lth_study_picture(&run->report, "bars",
                    "The bar under its full load, seen from the side; darker elements are of a "
                    "higher level",
                    svg);
  return LITHE_OK;
}

static void tell_counts(LthStudyReport *r, const Bar bar[2]) {
  LthTable *t =
      lth_study_table(r, "elements", "Elements of the bar while its load grows and falls", NULL);
  lth_table_column(t, "load over full load", "", 2);
  lth_table_column(t, "in eight", "", 4);
  lth_table_column(t, "in two", "", 4);
  lth_table_column(t, "time", "", 3);
  for (int i = 0; i < bar[0].n && i < bar[1].n; i++) {
    double time = bar[0].time[i],
           row[] = {time < 1 ? time : 2 - time, bar[0].elements[i], bar[1].elements[i], time};
    lth_table_row(t, NULL, row);
  }
  LthPlot *plot = lth_study_plot(r, "elements", "Elements while the bar bends and comes back",
                                 "time [times that of full load]", "elements [-]");
  lth_plot_series(plot, "in eight", t, 3, 1);
  lth_plot_series(plot, "in two", t, 3, 2);
  const double eight = at_full_load(bar), two = at_full_load(bar + 1);
  lth_study_at_most(r, "in eight: elements at full load off 274, relative", fabs(eight / 274 - 1),
                    0.25, "34 divisions are printed; load and threshold are not, and decide");
  lth_study_at_most(r, "in two: elements at full load off 77, relative", fabs(two / 77 - 1), 0.25,
                    "41 divisions are printed; the same threshold has to do for both");
  lth_study_at_least(r, "in eight over in two, at full load", eight / two, 3,
                     "274 / 77 = 3.6: divisions across the stress alone are the cheaper ones");
  lth_study_at_most(r, "elements at the end, in eight", bar[0].elements[bar[0].n - 1], 36,
                    "all families are merged again without a load");
  lth_study_at_most(r, "elements at the end, in two", bar[1].elements[bar[1].n - 1], 36,
                    "the same");
}

/// Largest jump of the velocity from one step to the next at the point near the clamp, of what refinement adds.
static double jolt(const Bar *bar, const Bar *plain) {
  double most = 0;
  for (int i = 2; i < bar->n && i < plain->n; i++)
    for (int a = 0; a < 3; a++) {
      double d[3];
      for (int k = 0; k < 3; k++) d[k] = bar->root[i - k][a] - plain->root[i - k][a];
      most = fmax(most, fabs(d[0] - 2 * d[1] + d[2]) / (bar->time[i] - bar->time[i - 1]));
    }
  return most;
}

static LitheStatus fall(LthStudyRun *run, const char *name, const char *set, Bar *bar) {
  LthStudyResult r;
  LthRunLook see = {look, bar};
  return lth_study_run_with(run, name, fall_scene, 1, &set, &see, &r);
}

static LitheStatus tell_release(LthStudyRun *run) {
  static const double blends[] = {0, 0.0625, 0.125, 0.25};
  LthStudyReport *r = &run->report;
  Bar *bar = lth_arena_take(&run->arena, 2 * sizeof *bar);
  if (!bar) LITHE_FAIL(run->ctx, LITHE_NO_MEMORY, "out of memory in a study");
  LITHE_TRY(fall(run, "fall-plain", "adapt.h.threshold=1e9", bar));
  LthTable *t = lth_study_table(
      r, "release",
      "The bar falls and is divided by eight: what that adds to the motion near its clamp", NULL);
  lth_table_column(t, "time constant over step", "", 3);
  lth_table_column(t, "largest jump of velocity in a step", "m/s", 3);
  for (int i = 0; i < 4; i++) {
    LITHE_TRY(fall(run, lth_study_print(run, "fall-%g", blends[i]),
                   lth_study_print(run, "adapt.blend=%g", blends[i]), bar + 1));
    double row[] = {blends[i] / 0.025, jolt(bar + 1, bar)};
    lth_table_row(t, NULL, row);
  }
  lth_study_say(
      r, "0 is the paper's way: coefficients are taken over (here exactly), and what the new "
         "functions release acts at once. Five steps is what a scene has that says nothing.");
  lth_study_at_most(r, "jump of velocity with five steps over that at once",
                    lth_table_at(t, 2, 1) / lth_table_at(t, 0, 1), 0.5,
                    "what is held back at first leaves 1 - exp(-1/5) = 0.18 of the force to the "
                    "first step");
  lth_study_at_most(r, "the same with ten over five", lth_table_at(t, 3, 1) / lth_table_at(t, 2, 1),
                    1, "the longer, the softer");
  return LITHE_OK;
}

LitheStatus lth_study_refinement(LthStudyRun *run) {
  Bar *bar = lth_arena_take(&run->arena, 2 * sizeof *bar);
  if (!bar) LITHE_FAIL(run->ctx, LITHE_NO_MEMORY, "out of memory in a study");
  LITHE_TRY(draw_bars(run, bar));
  tell_counts(&run->report, bar);
  return tell_release(run);
}
