/// Figure 5.1: where the error of Tables 5.1 and 5.2 lies.
#include "study/dolny_studies.h"

#include "disc/staggered/staggered.h"
#include "study/draw.h"

#define PANEL 380. // [px]

/// Largest error of a component at the unknowns of each pixel's cells; negative where there is no material.
typedef struct ErrorMap {
  LthStudyRun *run;
  int n; ///< pixels along a side
  double *error, largest;
} ErrorMap;

static LitheStatus look_at_errors(void *user, LitheCtx *ctx, const LthWorld *world,
                                  LitheIndex frame) {
  ErrorMap *map = user;
  const LthBody *body = world->bodies[0];
  const LthStaggered *s = lth_staggered_of(body->disc);
  const double *x = lth_body_position(body);
  (void)ctx;
  (void)frame;
  for (int k = 0; k < map->n * map->n; k++) map->error[k] = -1;
  map->largest = 0;
  for (LitheIndex i = 0; i < s->disc.n_funcs; i++)
    for (int a = 0; a < 2; a++) {
      double at[3];
      if (s->held[3 * (LitheCount)i + a]) continue;
      lth_staggered_place(s, i, a, at);
      if (lth_shape_value(s->shape, at) > 0) continue; // beyond the surface, as result.json's error
      int px = (int)floor((at[0] + 1) / 2 * map->n), py = (int)floor((1 - at[1]) / 2 * map->n);
      if (px < 0 || py < 0 || px >= map->n || py >= map->n) continue;
      double e =
          fabs(x[3 * (LitheCount)i + a] - at[a] - lth_value_at(&world->scene->exact[a], at, 0));
      double *pixel = &map->error[py * map->n + px];
      *pixel = fmax(*pixel, e);
      map->largest = fmax(map->largest, e);
    }
  return LITHE_OK;
}

/// Logarithmic over two decades and a half below `largest`; nothing is white.
static LitheStatus draw_map(const ErrorMap *map, LthDrawing *d, double largest, double left) {
  uint8_t *rgb;
  LTH_NEW(map->run->ctx, rgb, 3 * (LitheCount)map->n * map->n);
  for (int k = 0; k < map->n * map->n; k++) {
    uint8_t *pixel = rgb + 3 * (size_t)k;
    pixel[0] = pixel[1] = pixel[2] = 255;
    if (map->error[k] >= 0) lth_colour_bytes(1 + log10(map->error[k] / largest) / 2.5, pixel);
  }
  lth_draw_panel(d, (double[]){-1, -1, 1, 1}, left, 30, PANEL);
  lth_draw_pixels(d, map->n, map->n, rgb);
  lth_free(map->run->ctx, rgb);
  return LITHE_OK;
}

static LitheStatus draw_maps(LthStudyRun *run, const ErrorMap maps[2]) {
  LthDrawing d = {.ctx = run->ctx};
  double largest = fmax(maps[0].largest, maps[1].largest);
  lth_draw_begin(&d, 2 * PANEL + 120, PANEL + 40);
  for (int k = 0; k < 2; k++) {
    lth_draw_words(&d, 10 + k * (PANEL + 10), 18,
                   k == 0 ? "held on both sides" : "traction outside");
    LITHE_TRY(draw_map(maps + k, &d, largest, k * (PANEL + 10)));
  }
  lth_draw_bar(&d, 2 * PANEL + 30, 60, PANEL - 60, "error [m], log", largest / pow(10, 2.5),
               largest);
  const char *svg = lth_draw_end(&d, &run->arena);
  if (!svg) LITHE_FAIL(run->ctx, LITHE_NO_MEMORY, "out of memory in a study");
  lth_study_picture(
      &run->report, "error-maps",
      "Largest error of a component at the unknowns (Fig. 5.1): dark is small, light is large",
      svg);
  return LITHE_OK;
}

LitheStatus lth_study_error_maps(LthStudyRun *run) {
  int cells = run->quick ? 128 : 512;
  ErrorMap maps[2];
  for (int k = 0; k < 2; k++) {
    LthStudyResult result;
    LthExactCase which = lth_exact_manufactured(k == 0);
    LthExactMethod method = {.cells = cells, .fractions = "exact"};
    maps[k] = (ErrorMap){.run = run, .n = cells};
    maps[k].error = lth_arena_take(&run->arena, sizeof(double) * (size_t)cells * (size_t)cells);
    if (!maps[k].error) LITHE_FAIL(run->ctx, LITHE_NO_MEMORY, "out of memory in a study");
    LthRunLook look = {look_at_errors, maps + k};
    LITHE_TRY(lth_study_run_text(run, k == 0 ? "held" : "traction",
                                 lth_exact_scene(run, "Error map", &which, &method), &look,
                                 &result));
  }
  LITHE_TRY(draw_maps(run, maps));
  lth_study_at_most(
      &run->report, "largest error with traction over that with held sides",
      maps[1].largest / maps[0].largest, 3,
      "the thesis finds about a decade between the two (Fig. 5.1); with exact fractions both "
      "are of second order with like constants");
  return LITHE_OK;
}
