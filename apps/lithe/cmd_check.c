/// `lithe check`: check a scene and say what a run of it would need.
#include "app.h"

#include <stdio.h>

static void print_json(const LitheForecast *f) {
  printf("{\n  \"elements\": %d,\n  \"inner_faces\": %d,\n  \"dofs\": %lld,\n", f->elements,
         f->inner_faces, (long long)f->unknowns);
  if (f->nonzeros > 0) printf("  \"nonzeros\": %lld,\n", (long long)f->nonzeros);
  printf("  \"steps\": %lld,\n  \"frames\": %d,\n  \"volume\": %.17g,\n  \"memory\": %.0f,\n"
         "  \"seconds\": %.3g,\n  \"linear\": \"%s\"\n}\n",
         (long long)f->steps, f->frames, f->volume, f->memory, f->seconds, f->linear);
}

static void print_text(const LitheScene *scene, const LitheForecast *f) {
  printf("%s: the scene is good; a run would need\n", lithe_scene_name(scene));
  printf("  elements     %d, %lld unknowns", f->elements, (long long)f->unknowns);
  if (f->nonzeros > 0) printf(", %lld nonzeros", (long long)f->nonzeros);
  printf("\n");
  printf("  volume       %.6g m^3\n", f->volume);
  printf("  solves       %lld, with %s\n", (long long)f->steps, f->linear);
  printf("  output times %d\n", f->frames);
  printf("  memory       about %.0f MB\n", f->memory / 1e6);
  printf("  time         about %.1g s\n", f->seconds);
}

int cmd_check(const Args *args) {
  App app;
  LitheForecast forecast = {0};
  LitheStatus status = app_open(&app, args);
  if (status == LITHE_OK) status = lithe_check(app.ctx, app.scene, &forecast);
  progress_end(&app.progress);
  if (status == LITHE_OK && args->json) print_json(&forecast);
  if (status == LITHE_OK && !args->json && !args->quiet) print_text(app.scene, &forecast);
  return app_close(&app, status);
}
