/// Norms of the difference to a known solution, by quadrature over every element.
#include "scene/measure_staggered.h"

#include "base/tensor.h"

void lth_exact_displacement(const LthScene *scene, const double x[3], double t, double u[3]) {
  for (int a = 0; a < 3; a++)
    u[a] = lth_value_at(scene->exact + a, x, t) - (scene->exact_is_position ? x[a] : 0);
}

void lth_exact_gradient(const LthScene *scene, const double x[3], double t, double h, double g[9]) {
  for (int b = 0; b < 3; b++) {
    double up[3], down[3], y[3];
    lth_v3_copy(x, y);
    y[b] = x[b] + h;
    lth_exact_displacement(scene, y, t, up);
    y[b] = x[b] - h;
    lth_exact_displacement(scene, y, t, down);
    for (int a = 0; a < 3; a++) g[3 * a + b] = (up[a] - down[a]) / (2 * h);
  }
}

static void add_displacement(const LthBody *body, LitheIndex cell, const double *coef,
                             const double x[3], double w, LthErrorFigures *sum) {
  double t = lth_simulation_time(body->sim), u[3], exact[3], gradient[9], exact_g[9];
  lth_disc_sample(body->disc, cell, coef, x, u);
  lth_exact_displacement(body->scene, x, t, exact);
  double e = lth_v3_distance(u, exact);
  sum->l1 += w * e;
  sum->l2 += w * e * e;
  sum->linf = fmax(sum->linf, e);

  // third root of the rounding unit balances rounding and truncation
  lth_disc_sample_gradient(body->disc, cell, coef, x, gradient);
  lth_exact_gradient(body->scene, x, t, 6e-6 * body->size, exact_g);
  for (int i = 0; i < 9; i++)
    sum->h1 += w * (gradient[i] - exact_g[i]) * (gradient[i] - exact_g[i]);
}

double lth_stress_error2(const LthScene *scene, const double x[3], double t,
                         const double stress[6]) {
  static const int entry[6] = {0, 4, 8, 5, 2, 1}; // xx yy zz yz zx xy in a row-major tensor
  double square = 0;
  for (int i = 0; i < 6; i++) {
    if (scene->dimension == 2 && i >= 2 && i <= 4) continue;
    double e = stress[i] - lth_value_at(scene->exact_stress + entry[i], x, t);
    square += (i < 3 ? 1 : 2) * e * e;
  }
  return square;
}

static void add_stress(const LthBody *body, LitheIndex cell, const double x[3], double w,
                       LthErrorFigures *sum) {
  double stress[6], t = lth_simulation_time(body->sim);
  body->disc->table->stress(body->disc, cell, lth_body_position(body), x, stress);
  double square = lth_stress_error2(body->scene, x, t, stress);
  sum->stress_l2 += w * square;
  sum->stress_linf = fmax(sum->stress_linf, sqrt(square));
}

static LitheStatus add_cell(LitheCtx *ctx, const LthBody *body, LitheIndex c,
                            LthErrorFigures *figures) {
  const double *coef = lth_body_displacement(body);
  LitheIndex n;
  double *points, *weights;
  LITHE_TRY(lth_dg_cell_quadrature(ctx, body->mesh, c, 2 * body->disc->cell_degree[c] + 2, &n,
                                   &points, &weights));
  for (LitheIndex q = 0; q < n; q++) {
    const double *x = points + 3 * (LitheCount)q;
    if (body->scene->has_exact_displacement)
      add_displacement(body, c, coef, x, weights[q], figures);
    if (body->scene->has_exact_stress) add_stress(body, c, x, weights[q], figures);
  }
  lth_free(ctx, points);
  lth_free(ctx, weights);
  return LITHE_OK;
}

static void add(const LthErrorFigures *part, LthErrorFigures *sum) {
  sum->l1 += part->l1;
  sum->l2 += part->l2;
  sum->h1 += part->h1;
  sum->linf = fmax(sum->linf, part->linf);
  sum->stress_l2 += part->stress_l2;
  sum->stress_linf = fmax(sum->stress_linf, part->stress_linf);
}

/// Cell by cell on all cores, summed in their order.
static LitheStatus add_body(LitheCtx *ctx, const LthBody *body, LthErrorFigures *figures) {
  LitheStatus status = LITHE_OK;
  LthErrorFigures *part = NULL;
  LitheStatus *ended = NULL;
  if (body->staggered) {
    lth_measure_grid_error(body, figures);
    return LITHE_OK;
  }
  LTH_NEW_OR(done, ctx, part, body->mesh->n_cells);
  LTH_NEW_OR(done, ctx, ended, body->mesh->n_cells);
#pragma omp parallel for schedule(dynamic, 16) num_threads(lth_threads(ctx))
  for (LitheIndex c = 0; c < body->mesh->n_cells; c++) ended[c] = add_cell(ctx, body, c, part + c);
  for (LitheIndex c = 0; c < body->mesh->n_cells && status == LITHE_OK; c++) {
    status = ended[c];
    add(part + c, figures);
  }
done:
  lth_free(ctx, part);
  lth_free(ctx, ended);
  return status;
}

LitheStatus lth_measure_error(LitheCtx *ctx, LitheIndex n, LthBody *const *bodies,
                              LthErrorFigures *figures) {
  *figures = (LthErrorFigures){0};
  for (LitheIndex b = 0; b < n; b++) LITHE_TRY(add_body(ctx, bodies[b], figures));

  // weights of non-convex elements may be negative: a sum of nothing but rounding may be too
  figures->l2 = sqrt(fmax(figures->l2, 0));
  figures->h1 = sqrt(fmax(figures->h1, 0));
  figures->stress_l2 = sqrt(fmax(figures->stress_l2, 0));
  return LITHE_OK;
}
