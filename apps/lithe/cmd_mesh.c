/// `lithe mesh`: make the mesh of a scene, write it and report its quality.
#include "app.h"

#include <stdio.h>

static void print_json(const LitheMeshReport *r) {
  printf(
      "{\n  \"elements\": %d,\n  \"faces\": %d,\n  \"inner_faces\": %d,\n  \"boundary_faces\": "
      "%d,\n"
      "  \"merged\": %d,\n  \"components\": %d,\n  \"volume\": %.17g,\n  \"surface_area\": %.17g,\n"
      "  \"min_volume\": %.17g,\n  \"max_volume\": %.17g,\n  \"max_gap\": %.3g,\n"
      "  \"max_aspect\": %.6g,\n  \"full_cells\": %d,\n  \"cut_cells\": %d,\n  \"seconds\": "
      "%.3g\n}\n",
      r->elements, r->faces, r->inner_faces, r->boundary_faces, r->merged, r->components, r->volume,
      r->surface_area, r->min_volume, r->max_volume, r->max_gap, r->max_aspect, r->full_cells,
      r->cut_cells, r->seconds);
}

/// A staggered grid has no faces to speak of.
static void print_cells(const LitheMeshReport *r) {
  printf("  cells           %d full, %d cut\n", r->full_cells, r->cut_cells);
  printf("  parts           %d\n", r->components);
  printf("  volume          %.12g m^3, cells from %.3g to %.3g\n", r->volume, r->min_volume,
         r->max_volume);
}

static void print_faces(const LitheMeshReport *r) {
  printf("  faces           %d inside, %d on the boundary\n", r->inner_faces, r->boundary_faces);
  printf("  parts           %d\n", r->components);
  printf("  volume          %.12g m^3, elements from %.3g to %.3g\n", r->volume, r->min_volume,
         r->max_volume);
  printf("  surface area    %.12g m^2\n", r->surface_area);
  printf("  slivers merged  %d\n", r->merged);
  printf("  largest gap     %.2g of an element's area\n", r->max_gap);
  printf("  largest aspect  %.3g\n", r->max_aspect);
}

static void print_text(const LitheScene *scene, const LitheMeshReport *r, const char *path) {
  printf("%s: %d elements in %.3g s\n", lithe_scene_name(scene), r->elements, r->seconds);
  if (r->faces > 0) print_faces(r);
  if (r->full_cells + r->cut_cells > 0) print_cells(r);
  if (path) printf("  written         %s\n", path);
}

int cmd_mesh(const Args *args) {
  App app;
  LitheMeshReport report = {0};
  LitheStatus status = app_open(&app, args);
  if (status == LITHE_OK) status = lithe_mesh(app.ctx, app.scene, args->out, &report);
  progress_end(&app.progress);
  if (status == LITHE_OK && args->json) print_json(&report);
  if (status == LITHE_OK && !args->json && !args->quiet) print_text(app.scene, &report, args->out);
  return app_close(&app, status);
}
