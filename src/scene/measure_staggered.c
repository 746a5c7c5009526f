/// Figures of staggered bodies: displacements and stresses of cells, errors at the unknowns.
#include "scene/measure_staggered.h"

#include "base/tensor.h"

#define HALF                                                                                       \
  0.5 // cells that are less full have stresses that say little of the material beside them

/// Is corner q of a cell in or on its material? That part is full, but for rounding.
static bool has_corner(const LthBody *body, LitheCount slot, int q) {
  return lth_fractions_part(body->staggered->fractions, slot, q) > 1 - 1e-9;
}

/// Largest |u| at those corners of a cell that are of its material.
static double largest_at_corners(const LthBody *body, LitheIndex cell, const double *u) {
  const LthStaggered *s = lth_staggered_of(body->disc);
  double largest = 0;
  LitheIndex at[3];
  lth_sparse_grid_cell(s->grid, s->cell_slot[cell], at);
  for (int q = 0; q < 1 << s->dim; q++) {
    double x[3], value[3], offset[3] = {q & 1, q >> 1 & 1, s->dim == 2 ? 0.5 : q >> 2};
    if (!has_corner(body, s->cell_slot[cell], q)) continue;
    lth_sparse_grid_place(s->grid, at, offset, x);
    lth_disc_sample(body->disc, cell, u, x, value);
    largest = fmax(largest, lth_v3_norm(value));
  }
  return largest;
}

/// |u| at the middle of each cell (n_cells).
static void lengths_at_centers(LitheCtx *ctx, const LthBody *body, const double *u,
                               double *length) {
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex c = 0; c < body->disc->n_cells; c++) {
    double x[3], value[3];
    lth_body_cell_center(body, c, x);
    lth_disc_sample(body->disc, c, u, x, value);
    length[c] = lth_v3_norm(value);
  }
}

LitheStatus lth_measure_grid_displacement(LitheCtx *ctx, const LthBody *body, double *max,
                                          double *integral) {
  const double *u = lth_body_displacement(body);
  LitheIndex n = body->disc->n_cells;
  double *length = NULL, largest = 0;
  LTH_NEW(ctx, length, n);
  lengths_at_centers(ctx, body, u, length);
  for (LitheIndex c = 0; c < n; c++) {
    double volume = lth_body_cell_volume(body, c);
    if (!(volume > 0)) length[c] = 0; // a held side beyond the surface
    largest = fmax(largest, length[c]);
    *integral += volume * length[c];
  }
  // corners move no more than twice as far as the middle of a cell where fields are resolved at all
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex c = 0; c < n; c++)
    if (length[c] >= largest / 2 && lth_body_cell_volume(body, c) > 0)
      length[c] = fmax(length[c], largest_at_corners(body, c, u));
  for (LitheIndex c = 0; c < n; c++) *max = fmax(*max, length[c]);
  lth_free(ctx, length);
  return LITHE_OK;
}

static void stress_at(const LthBody *body, LitheIndex cell, double x[3], double stress[6]) {
  lth_body_cell_center(body, cell, x);
  body->disc->table->stress(body->disc, cell, lth_body_position(body), x, stress);
}

LitheStatus lth_measure_grid_stress(LitheCtx *ctx, const LthBody *body, double **von_mises) {
  LitheIndex n = body->disc->n_cells, n_half = 0;
  LTH_NEW(ctx, *von_mises, n);
  for (LitheIndex c = 0; c < n; c++) n_half += lth_grid_cell_fraction(body, c) >= HALF;
  double least = n_half > 0 ? HALF : 1e-300;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex c = 0; c < n; c++) {
    double x[3], stress[6];
    (*von_mises)[c] = NAN;
    if (!(lth_grid_cell_fraction(body, c) >= least)) continue;
    stress_at(body, c, x, stress);
    (*von_mises)[c] = lth_von_mises(stress);
  }
  return LITHE_OK;
}

double lth_grid_cell_fraction(const LthBody *body, LitheIndex cell) {
  return (double)body->staggered->filled[lth_staggered_of(body->disc)->cell_slot[cell]];
}

LitheStatus lth_add_grid_reactions(LitheCtx *ctx, const LthBody *body, const double *imbalance,
                                   double *reaction) {
  const LthStaggeredBody *s = body->staggered;
  double *of_hold = NULL;
  if (s->n_holds == 0 || !imbalance) return LITHE_OK; // weak rollers alone
  LTH_NEW(ctx, of_hold, 3 * (LitheCount)s->n_holds);
  lth_staggered_add_reactions(body->disc, imbalance + body->first, of_hold);
  for (LitheIndex k = 0; k < s->n_holds; k++)
    lth_v3_axpy(1, of_hold + 3 * (LitheCount)k, reaction + 3 * (LitheCount)s->hold_of[k]);
  lth_free(ctx, of_hold);
  return LITHE_OK;
}

// --- errors ---

/// Free unknowns inside the shape.
static void add_unknowns(const LthBody *body, const double *u, LthErrorFigures *sum) {
  const LthStaggered *s = lth_staggered_of(body->disc);
  double t = lth_simulation_time(body->sim), w = lth_sparse_grid_cell_volume(s->grid);
  for (LitheCount k = 0; k < body->disc->n_dofs; k++) {
    double x[3], exact[3];
    if (s->held[k]) continue;
    lth_staggered_place(s, (LitheIndex)(k / 3), (int)(k % 3), x);
    if (lth_shape_value(&body->def->shape, x) > 1e-9 * body->size) continue;
    lth_exact_displacement(body->scene, x, t, exact);
    double e = fabs(u[k] - exact[k % 3]);
    sum->l1 += w * e;
    sum->l2 += w * e * e;
    sum->linf = fmax(sum->linf, e);
  }
}

/// Gradients of displacement at middles of cells, by their volume of material.
static void add_gradients(const LthBody *body, const double *u, LthErrorFigures *sum) {
  double t = lth_simulation_time(body->sim);
  for (LitheIndex c = 0; c < body->disc->n_cells; c++) {
    double x[3], g[9], exact[9], volume = lth_body_cell_volume(body, c);
    if (!(volume > 0)) continue;
    lth_body_cell_center(body, c, x);
    lth_disc_mean_gradient(body->disc, c, u, g);
    lth_exact_gradient(body->scene, x, t, 6e-6 * body->size, exact);
    for (int i = 0; i < 9; i++)
      if (body->scene->dimension == 3 || (i % 3 < 2 && i < 6))
        sum->h1 += volume * (g[i] - exact[i]) * (g[i] - exact[i]);
  }
}

static void add_stresses(const LthBody *body, LthErrorFigures *sum) {
  for (LitheIndex c = 0; c < body->disc->n_cells; c++) {
    double x[3], stress[6], fraction = lth_grid_cell_fraction(body, c);
    if (!(fraction > 0)) continue;
    stress_at(body, c, x, stress);
    double square = lth_stress_error2(body->scene, x, lth_simulation_time(body->sim), stress);
    sum->stress_l2 += lth_body_cell_volume(body, c) * square;
    if (fraction >= HALF) sum->stress_linf = fmax(sum->stress_linf, sqrt(square));
  }
}

void lth_measure_grid_error(const LthBody *body, LthErrorFigures *sum) {
  const double *u = lth_body_displacement(body);
  if (body->scene->has_exact_displacement) {
    add_unknowns(body, u, sum);
    add_gradients(body, u, sum);
  }
  if (body->scene->has_exact_stress) add_stresses(body, sum);
}
