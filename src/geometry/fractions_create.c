/// Volume fractions of shapes and of functions: from a definition to the method that fills them.
#include "geometry/fractions_fill.h"

#include "base/tensor.h"

#define SAMPLES_MAX 64 ///< along a cell
#define MAP_CELLS 4    ///< of the grid, along one of a map that is asked for blocks alone

static LitheStatus check_def(LitheCtx *ctx, const LthFractionDef *def) {
  if (def->method == LTH_FRACTIONS_SAMPLES &&
      (def->samples < 2 || def->samples > SAMPLES_MAX || def->samples % 2))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "fractions from %d samples along a cell: expected an even number from 2 to %d",
               def->samples, SAMPLES_MAX);
  if (def->method == LTH_FRACTIONS_SMOOTH && !(def->half_width >= 0 && def->half_width < 100))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "smooth fractions with a half width of %g cells: expected from 0 to 100",
               def->half_width);
  return LITHE_OK;
}

static LthSide exact_side(const void *self, const double center[3], const double half[3]) {
  return lth_probe_side(self, center, half);
}

LitheStatus lth_fractions_create(LitheCtx *ctx, const LthShape *shape, int dim,
                                 const double origin[3], const double h[3], const LitheIndex n[3],
                                 const LthFractionDef *def, LthFractions **fractions) {
  LitheStatus status = LITHE_OK;
  LthProbe *probe = NULL;
  double smallest = h[0];
  *fractions = NULL;
  LITHE_TRY(check_def(ctx, def));
  for (int a = 1; a < dim; a++) smallest = fmin(smallest, h[a]);
  bool by_parts = shape->kind == LTH_SHAPE_WRAP || def->method == LTH_FRACTIONS_EXACT;
  LITHE_TRY_OR(done, lth_probe_create(ctx, shape, (by_parts ? MAP_CELLS : 1) * smallest, &probe));
  LthSampler sampler = {.probe = probe, .samples = def->samples};
  LthSmoother smoother = lth_fraction_smoother(probe, def, dim, h);
  LthFractionFiller filler = {&sampler, lth_fraction_sample_side, lth_fraction_fill_samples};
  if (def->method == LTH_FRACTIONS_EXACT)
    filler = dim == 2 ? lth_fraction_plane_filler(probe)
                      : (LthFractionFiller){probe, exact_side, lth_fraction_fill_exact};
  if (def->method == LTH_FRACTIONS_SMOOTH)
    filler = (LthFractionFiller){&smoother, lth_fraction_smooth_side, lth_fraction_fill_smooth};
  LITHE_TRY_OR(done, lth_fractions_build(ctx, &filler, dim, origin, h, n, fractions));
done:
  lth_probe_destroy(ctx, &probe);
  return status;
}

/// --- functions ---

typedef struct Given {
  LthPartFunction part;
  const void *self;
} Given;

static LthSide any_side(const void *self, const double center[3], const double half[3]) {
  (void)self, (void)center, (void)half;
  return LTH_SIDE_MIXED;
}

static LitheStatus fill_given(const void *self, LitheCtx *ctx, const LthFractionFrame *f,
                              const LthFractionRow *row) {
  const Given *given = self;
  int n = 2 * f->side, deep = f->dim == 3 ? n : 1;
  double low[3], at[3], size[3];
  (void)ctx;
  for (int a = 0; a < 3; a++) size[a] = 0.5 * f->h[a];
  for (LitheIndex m = 0; m < row->n; m++) {
    double *part = row->part + (LitheCount)m * f->block_cells * f->n_parts;
    lth_fraction_corner(f, row->at[m], row->j, row->k, low);
    for (int k = 0; k < deep; k++)
      for (int j = 0; j < n; j++)
        for (int i = 0; i < n; i++) {
          int place[3] = {i, j, k};
          for (int a = 0; a < 3; a++) at[a] = low[a] + place[a] * size[a];
          part[lth_fraction_place(f, i, j, k)] = given->part(given->self, at, size);
        }
  }
  return LITHE_OK;
}

LitheStatus lth_fractions_from(LitheCtx *ctx, int dim, const double origin[3], const double h[3],
                               const LitheIndex n[3], LthPartFunction part, const void *self,
                               LthFractions **fractions) {
  Given given = {.part = part, .self = self};
  LthFractionFiller filler = {.self = &given, .side = any_side, .fill = fill_given};
  return lth_fractions_build(ctx, &filler, dim, origin, h, n, fractions);
}

/// --- memory ---

LitheCount lth_fractions_forecast(int dim, const double h[3], const LitheIndex n[3], double area,
                                  double volume) {
  int side = dim == 3 ? LTH_BLOCK_SIDE_3D : LTH_BLOCK_SIDE_2D, n_parts = 1 << dim;
  double block = 1, places = 1, cell = 1, widest = 0;
  for (int a = 0; a < dim; a++) {
    cell *= h[a];
    block *= side;
    places *= n[a] / side + 3;
    widest = fmax(widest, h[a]);
  }

  // a plane of unit area meets at most sqrt(dim) cells' faces' worth of cells, and as many blocks
  double faces = sqrt((double)dim) * area * widest / cell + block / side;
  double n_cut = 2 * faces, n_surface = 4 * faces * side / block + 1;
  double n_blocks = fmin(n_surface + 2 * volume / (cell * block) + 27, places);
  double n_neighbors = dim == 3 ? 27 : 9;
  double kept = n_cut * n_parts * sizeof(double) + n_blocks * (block * sizeof(uint16_t) + 12);
  double of_grid =
      places * (2 + sizeof(LitheIndex)) + n_blocks * (3 + n_neighbors) * sizeof(LitheIndex);
  return (LitheCount)(2 * kept + of_grid);
}
