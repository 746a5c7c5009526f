/// The thesis' own measure: errors at the nodes of the grid, each the mean of two staggered values.
#include "study/dolny.h"

#include "disc/staggered/staggered.h"

/// Displacement's error of component a at the low face across a of cell (i, j). Unknowns that are not solved for have
/// none.
static double unknown_error(const LthStaggered *s, const LthWorld *world, const double *x, int a,
                            LitheIndex i, LitheIndex j) {
  LitheCount slot = lth_sparse_grid_slot(s->grid, i, j, 0);
  if (slot < 0 || s->func[slot] < 0) return 0;
  LitheCount k = 3 * (LitheCount)s->func[slot] + a;
  double at[3];
  if (s->held[k]) return 0;
  lth_staggered_place(s, s->func[slot], a, at);
  double t = lth_simulation_time(world->sim), want = lth_value_at(&world->scene->exact[a], at, t);
  return x[k] - (world->scene->exact_is_position ? want : at[a] + want);
}

/// Exact component a of the displacement at a place.
static double exact_at(const LthWorld *world, int a, const double x[3]) {
  double want = lth_value_at(&world->scene->exact[a], x, lth_simulation_time(world->sim));
  return world->scene->exact_is_position ? want - x[a] : want;
}

/// Error at the low corner of cell (i, j): mean of the values below and above (left and right) minus the exact one.
static double node_error(const LthStaggered *s, const LthWorld *world, const double *x, int a,
                         LitheIndex i, LitheIndex j) {
  double mean = 0, at[3] = {0}, node[3];
  int b = 1 - a;
  LitheIndex cell[3] = {i, j, 0};
  lth_sparse_grid_place(s->grid, cell, (const double[3]){0, 0, 0.5}, node);
  for (int side = -1; side <= 0; side++) {
    LitheIndex n[2] = {i, j};
    n[b] += side;
    at[a] = node[a];
    at[b] = node[b] + (side + 0.5) * s->grid->h[b];
    mean += (exact_at(world, a, at) + unknown_error(s, world, x, a, n[0], n[1])) / 2;
  }
  node[2] = 0;
  return mean - exact_at(world, a, node);
}

LitheStatus lth_node_errors_look(void *user, LitheCtx *ctx, const LthWorld *world,
                                 LitheIndex frame) {
  LthNodeErrors *errors = user;
  const LthBody *body = world->bodies[0];
  const LthStaggered *s = lth_staggered_of(body->disc);
  const double *x = lth_body_position(body);
  const LthSparseGrid *g = s->grid;
  (void)ctx;
  (void)frame;
  errors->l1 = errors->linf = 0;
  for (LitheIndex j = 0; j <= g->n[1]; j++)
    for (LitheIndex i = 0; i <= g->n[0]; i++) {
      double px = g->origin[0] + i * g->h[0], py = g->origin[1] + j * g->h[1], r = hypot(px, py);
      if (!(r > errors->inner && r < errors->outer)) continue;
      for (int a = 0; a < 2; a++) {
        double e = fabs(node_error(s, world, x, a, i, j));
        errors->l1 += e * g->h[0] * g->h[1];
        errors->linf = fmax(errors->linf, e);
      }
    }
  return LITHE_OK;
}
