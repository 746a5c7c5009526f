/// A staggered 2D body at several times: outlines of its cells where they are then, drawn side by side.
#include "study/frames.h"

#include "disc/staggered/staggered.h"
#include "geometry/shape_foot.h"
#include "scene/measure.h"
#include "study/draw.h"

#include <stdio.h>
#include <string.h>

#define SHADES 40 ///< of colour: cells of one shade are one path in the file

/// Signed distance from the shape's boundary, negative inside.
static double distance(const LthBody *body, const double x[3], double h) {
  LthFoot foot;
  if (lth_shape_foot(&body->def->shape, x, h, &foot)) return foot.distance;
  return lth_shape_value(&body->def->shape, x) <= 0 ? -h : h;
}

/// The part of a cell inside the shape as a polygon at rest: the boundary is a line between edges of the cell. Returns
/// the number of corners.
static int clip_cell(const LthBody *body, const LthSparseGrid *g, const LitheIndex cell[3],
                     double rest[2 * LTH_FRAME_CORNERS]) {
  static const double corner[4][3] = {{0, 0, .5}, {1, 0, .5}, {1, 1, .5}, {0, 1, .5}};
  double at[4][3], d[4], rounding = 1e-9 * g->h[0];
  int n = 0;
  for (int k = 0; k < 4; k++) {
    lth_sparse_grid_place(g, cell, corner[k], at[k]);
    at[k][2] = 0;
    d[k] = distance(body, at[k], g->h[0]) - rounding;
  }
  for (int k = 0; k < 4; k++) {
    int next = (k + 1) % 4;
    if (d[k] < 0) memcpy(rest + (size_t)2 * n++, at[k], 2 * sizeof *rest);
    if ((d[k] < 0) == (d[next] < 0)) continue;
    double s = d[k] / (d[k] - d[next]);
    for (int a = 0; a < 2; a++) rest[2 * n + a] = at[k][a] + s * (at[next][a] - at[k][a]);
    n++;
  }
  return n;
}

static bool reserve_cells(LthStudyRun *run, LthFrame *f, LitheIndex n) {
  f->cap = n;
  f->corners = lth_arena_take(&run->arena, sizeof *f->corners * (size_t)n);
  f->place = lth_arena_take(&run->arena, sizeof *f->place * 2 * LTH_FRAME_CORNERS * (size_t)n);
  f->value = lth_arena_take(&run->arena, sizeof *f->value * (size_t)n);
  return f->corners && f->place && f->value;
}

static double area_of(int n, const double *xy) {
  double sum = 0;
  for (int i = 0; i < n; i++) {
    const double *p = xy + (size_t)2 * i, *q = xy + (size_t)2 * ((i + 1) % n);
    sum += (p[0] * q[1] - p[1] * q[0]) / 2;
  }
  return sum;
}

static void take_cell(LthFrame *f, const LthBody *body, const LthStaggered *s, LitheIndex c,
                      const double *coef) {
  static const double middle[3] = {.5, .5, .5};
  double *place = f->place + (size_t)2 * LTH_FRAME_CORNERS * (size_t)f->n, x[3], u[3], stress[6];
  LitheIndex cell[3];
  lth_sparse_grid_cell(s->grid, s->cell_slot[c], cell);
  int n = clip_cell(body, s->grid, cell, place);
  if (n < 3 || area_of(n, place) < 1e-6 * s->grid->h[0] * s->grid->h[1]) return;
  for (int i = 0; i < n; i++) {
    memcpy(x, place + (size_t)2 * i, 2 * sizeof *x);
    x[2] = 0;
    lth_disc_sample(body->disc, c, coef, x, u);
    for (int a = 0; a < 2; a++) place[2 * i + a] += u[a];
  }
  lth_sparse_grid_place(s->grid, cell, middle, x);
  x[2] = 0;
  body->disc->table->stress(body->disc, c, lth_body_position(body), x, stress);
  f->value[f->n] = lth_von_mises(stress);
  f->area += area_of(n, place);
  f->corners[f->n++] = n;
}

/// Held unknowns within half a cell of the boundary, where they are now.
static void take_held(LthFrame *f, const LthBody *body, const LthStaggered *s, const double *coef) {
  const double *x = lth_body_position(body);
  for (LitheIndex i = 0; i < s->disc.n_funcs; i++)
    for (int a = 0; a < 2; a++) {
      LitheCount k = 3 * (LitheCount)i + a;
      double at[3], u[3];
      if (s->held[k] != LTH_HELD || f->n_held == f->cap_held) continue;
      lth_staggered_place(s, i, a, at);
      if (fabs(distance(body, at, s->grid->h[0])) > 0.51 * s->grid->h[0]) continue;
      LitheIndex c = s->cell[s->slot[i]];
      if (c < 0) continue;
      lth_disc_sample(body->disc, c, coef, at, u);
      u[a] = x[k] - at[a];
      for (int b = 0; b < 2; b++) f->held[2 * f->n_held + b] = at[b] + u[b];
      f->n_held++;
    }
}

LitheStatus lth_frames_look(void *user, LitheCtx *ctx, const LthWorld *world, LitheIndex frame) {
  LthFrames *frames = user;
  LthStudyRun *run = frames->run;
  const LthBody *body = world->bodies[0];
  const LthStaggered *s = lth_staggered_of(body->disc);
  if (frame >= LTH_FRAMES_MAX) return LITHE_OK;
  LthFrame *f = &frames->frame[frame];
  *f = (LthFrame){.time = lth_simulation_time(world->sim), .cap_held = 2000};
  f->held = lth_arena_take(&run->arena, sizeof *f->held * 2 * (size_t)f->cap_held);
  if (!f->held || !reserve_cells(run, f, s->disc.n_cells))
    LITHE_FAIL(ctx, LITHE_NO_MEMORY, "out of memory in a study");
  const double *coef = lth_body_displacement(body);
  for (LitheIndex c = 0; c < s->disc.n_cells; c++) take_cell(f, body, s, c, coef);
  take_held(f, body, s, coef);
  frames->n = frame + 1;
  return LITHE_OK;
}

static void find_box(const LthFrames *frames, double box[4], double *largest) {
  box[0] = box[1] = INFINITY;
  box[2] = box[3] = -INFINITY;
  *largest = 0;
  for (int k = 0; k < frames->n; k++) {
    const LthFrame *f = &frames->frame[k];
    for (int c = 0; c < f->n; c++) {
      *largest = fmax(*largest, f->value[c]);
      for (int i = 0; i < 2 * f->corners[c]; i++) {
        double x = f->place[(size_t)2 * LTH_FRAME_CORNERS * (size_t)c + (size_t)i];
        box[i % 2] = fmin(box[i % 2], x);
        box[2 + i % 2] = fmax(box[2 + i % 2], x);
      }
    }
  }
  for (int a = 0; a < 2; a++) {
    double margin = 0.03 * (box[2 + a] - box[a]);
    box[a] -= margin;
    box[2 + a] += margin;
  }
}

static int shade_of(double share) { return share > 0 ? (int)fmin(share * SHADES, SHADES - 1) : 0; }

static void draw_frame(const LthFrame *f, LthDrawing *d, double largest) {
  char colour[LTH_COLOUR_MAX];
  for (int shade = 0; shade < SHADES; shade++) {
    lth_draw_area_begin(d, lth_colour(0.15 + 0.85 * (shade + 0.5) / SHADES, colour));
    for (int c = 0; c < f->n; c++)
      if (shade_of(f->value[c] / largest) == shade)
        lth_draw_area_add(d, f->corners[c], f->place + (size_t)2 * LTH_FRAME_CORNERS * (size_t)c);
    lth_draw_area_end(d);
  }
  for (int i = 0; i < f->n_held; i++)
    lth_draw_dot(d, f->held + (size_t)2 * (size_t)i, 1.6, "#ff9933");
}

LitheStatus lth_frames_draw(const LthFrames *frames, const char *name, const char *caption) {
  LthStudyRun *run = frames->run;
  LthDrawing d = {.ctx = run->ctx};
  double box[4], largest, width = 210, height;
  if (frames->n == 0) return LITHE_OK;
  find_box(frames, box, &largest);
  if (!(largest > 0)) largest = 1;
  height = width * (box[3] - box[1]) / (box[2] - box[0]);
  lth_draw_begin(&d, frames->n * (width + 10) + 80, height + 40);
  for (int k = 0; k < frames->n; k++) {
    char words[60];
    snprintf(words, sizeof words, "(%c) t = %.3g s", 'a' + k, frames->frame[k].time);
    lth_draw_words(&d, k * (width + 10) + 4, 16, words);
    lth_draw_panel(&d, box, k * (width + 10), 24, width);
    draw_frame(&frames->frame[k], &d, largest);
  }
  lth_draw_bar(&d, frames->n * (width + 10) + 8, 44, height * 0.6, "[Pa]", 0, largest);
  const char *svg = lth_draw_end(&d, &run->arena);
  if (!svg) LITHE_FAIL(run->ctx, LITHE_NO_MEMORY, "out of memory in a study");
  lth_study_picture(&run->report, name, caption, svg);
  return LITHE_OK;
}
