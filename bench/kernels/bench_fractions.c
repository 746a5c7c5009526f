/// Time, memory and error of volume fractions: each method on solids at growing resolution, cells along the longest
/// side; a surface from a file, a ball, a thin shell, a drilled block, two crossing surfaces as one.
///
///   bench_fractions [--csv] [--mesh FILE] [--from N] [--cells N] [--threads N] [--method NAME] [--shape NAME]
///
/// Cells go from --from (64) on, doubled up to --cells (256). /// Errors are of the volume, over that in closed form or of the triangles.
#include "base/tensor.h"
#include "geometry/fractions.h"
#include "geometry/shape.h"
#include "io/surface_file.h"

#include <stdio.h>
#include <stdlib.h>

#define METHODS 3

typedef struct Options {
  bool csv;
  const char *mesh;
  LitheIndex from, cells;
  int threads;
  const char *method, *shape; ///< these alone; NULL: all
} Options;

typedef struct Case {
  const char *name;
  const LthShape *shape;
  double volume; ///< [m^3], NAN: not known
  double area;   ///< [m^2]
} Case;

static const struct {
  const char *name;
  LthFractionDef def;
} methods[METHODS] = {
    {"samples 4", {.method = LTH_FRACTIONS_SAMPLES, .samples = 4}},
    {"exact", {.method = LTH_FRACTIONS_EXACT}},
    {"smooth", {.method = LTH_FRACTIONS_SMOOTH}},
};

static void check(LitheCtx *ctx, LitheStatus status) {
  if (status == LITHE_OK) return;
  fprintf(stderr, "%s\n", lithe_ctx_message(ctx));
  exit(1);
}

/// Cubes over the box of the shape, a cell and a third away from it.
static void place_grid(const LthShape *shape, LitheIndex cells, double origin[3], double h[3],
                       LitheIndex n[3]) {
  double min[3], max[3], longest = 0;
  lth_shape_bounds(shape, min, max);
  for (int a = 0; a < 3; a++) longest = fmax(longest, max[a] - min[a]);
  for (int a = 0; a < 3; a++) {
    h[a] = longest / (cells - 2.67);
    n[a] = (LitheIndex)ceil((max[a] - min[a]) / h[a] + 2.67);
    origin[a] = 0.5 * (min[a] + max[a] - h[a] * n[a]);
  }
}

static void run(LitheCtx *ctx, const Options *o, const Case *c, LitheIndex cells, int m) {
  double origin[3], h[3];
  LitheIndex n[3];
  LthFractions *f = NULL;
  place_grid(c->shape, cells, origin, h, n);
  double start = lth_now();
  LitheCount before = lth_alloc_bytes(ctx);
  check(ctx, lth_fractions_create(ctx, c->shape, 3, origin, h, n, &methods[m].def, &f));
  double seconds = lth_now() - start;
  double bytes = (double)(lth_alloc_bytes(ctx) - before);
  double most = (double)lth_fractions_forecast(3, h, n, c->area, f->volume);
  LitheCount n_cut = f->first[f->grid->n_blocks];
  const char *format = o->csv ? "%s,%s,%d,%.3f,%lld,%d,%.1f,%.1f,%.2e\n"
                              : "%-12s %-10s %5d %8.3f %10lld %8d %9.1f %9.1f %10.2e\n";
  printf(format, c->name, methods[m].name, cells, seconds, (long long)n_cut, f->grid->n_blocks,
         bytes / 1048576, most / 1048576, fabs(f->volume / c->volume - 1));
  fflush(stdout);
  lth_fractions_destroy(ctx, &f);
}

static void run_case(LitheCtx *ctx, const Options *o, const Case *c) {
  if (o->shape && strcmp(o->shape, c->name) != 0) return;
  for (int m = 0; m < METHODS; m++)
    for (LitheIndex cells = o->from; cells <= o->cells; cells *= 2)
      if (!o->method || strcmp(o->method, methods[m].name) == 0) run(ctx, o, c, cells, m);
}

/// A file that is no solid, as it is wrapped: its volume is not known otherwise.
static void run_wrapped(LitheCtx *ctx, const Options *o, const LthSoup *soup, double volume) {
  LthWrap *wrap = NULL;
  check(ctx, lth_wrap_create(ctx, soup, o->mesh, &wrap));
  LthShape wrapped = {.kind = LTH_SHAPE_WRAP, .wrap = wrap};
  run_case(ctx, o, &(Case){"wrapped", &wrapped, volume, lth_surface_area(wrap->raw)});
  lth_wrap_destroy(ctx, &wrap);
}

static void run_file(LitheCtx *ctx, const Options *o) {
  LthSoup *soup = NULL;
  LthSurface *surface = NULL;
  LthShape mesh = {.kind = LTH_SHAPE_MESH};
  double volume = NAN;
  check(ctx, lth_soup_read(ctx, o->mesh, &soup));
  if (lth_surface_from_soup(ctx, soup, o->mesh, NULL, &surface) == LITHE_OK) {
    mesh.surface = surface;
    volume = lth_surface_volume(surface);
    check(ctx, lth_shape_prepare(ctx, &mesh));
    run_case(ctx, o, &(Case){"mesh", &mesh, volume, lth_surface_area(surface)});
  }
  run_wrapped(ctx, o, soup, volume);
  lth_shape_free(ctx, &mesh);
  lth_surface_destroy(ctx, &surface);
  lth_soup_destroy(ctx, &soup);
}

static void run_shapes(LitheCtx *ctx, const Options *o) {
  LthShape ball = {.kind = LTH_SHAPE_SPHERE, .a = {0.01, 0.02, 0.03}, .radius = 1};
  LthShape shell = {.kind = LTH_SHAPE_SHELL, .radius = 1, .inner = 0.99};
  LthShape two[2] = {
      {.kind = LTH_SHAPE_BOX, .a = {-1, -0.7, -0.31}, .b = {1, 0.7, 0.32}},
      {.kind = LTH_SHAPE_CYLINDER, .a = {0.1, 0, -2}, .b = {0.1, 0, 2}, .radius = 0.5}};
  LthShape drilled = {.kind = LTH_SHAPE_DIFFERENCE, .children = two, .n_children = 2};
  run_case(ctx, o, &(Case){"ball", &ball, 4 * M_PI / 3, 4 * M_PI});
  run_case(ctx, o,
           &(Case){"shell", &shell, 4 * M_PI / 3 * (1 - 0.970299), 4 * M_PI * (1 + 0.9801)});
  run_case(ctx, o,
           &(Case){"drilled", &drilled, 2 * 1.4 * 0.63 - M_PI * 0.25 * 0.63,
                   2 * (2 * 1.4 - M_PI * 0.25) + (2 * 3.4 + M_PI) * 0.63});
}

int main(int argc, char **argv) {
  Options o = {.from = 64, .cells = 256};
  for (int i = 1; i < argc; i++) {
    bool has_value = i + 1 < argc;
    if (!strcmp(argv[i], "--csv"))
      o.csv = true;
    else if (!strcmp(argv[i], "--mesh") && has_value)
      o.mesh = argv[++i];
    else if (!strcmp(argv[i], "--cells") && has_value)
      o.cells = atoi(argv[++i]);
    else if (!strcmp(argv[i], "--from") && has_value)
      o.from = atoi(argv[++i]);
    else if (!strcmp(argv[i], "--threads") && has_value)
      o.threads = atoi(argv[++i]);
    else if (!strcmp(argv[i], "--method") && has_value)
      o.method = argv[++i];
    else if (!strcmp(argv[i], "--shape") && has_value)
      o.shape = argv[++i];
    else
      return fprintf(stderr, "bench_fractions: unknown option %s\n", argv[i]), 2;
  }
  LitheCtxDef def = lithe_ctx_def_default();
  LitheCtx *ctx = lithe_ctx_create(&def);
  lth_set_threads(ctx, o.threads);
  printf(o.csv ? "shape,method,cells,seconds,cut,blocks,mib,forecast_mib,volume_error\n"
               : "shape        method     cells  seconds        cut   blocks       MiB  forecast "
                 "volume err\n");
  if (o.mesh) run_file(ctx, &o);
  run_shapes(ctx, &o);
  lithe_ctx_destroy(&ctx);
  return 0;
}
