/// From fractions of parts and the material to weighted coefficients of cells, edges and faces.
/// Means of elastic constants are harmonic and over material only: docs/theory/staggered.md.
#include "disc/staggered/staggered_priv.h"

#include <math.h>

#define MAX_LATTICE 4913 // (2 x 8 + 1)^3; (2 x 16 + 1)^2 is less

/// Parts of a block and of the low halves of the cells before it, x fastest: what control volumes at its slots
/// are made of.
typedef struct Lattice {
  LitheStatus status;
  int width[3];
  double v[MAX_LATTICE], lambda[MAX_LATTICE], mu[MAX_LATTICE], density[MAX_LATTICE];
} Lattice;

typedef struct Weigher {
  LitheCtx *ctx;
  LthStaggered *s;
  double least;
  double lambda, mu, density; ///< where the material is uniform
} Weigher;

/// What the parts of a control volume add up to.
typedef struct Mean {
  double V, lambda, mu; ///< fraction; V lambda, V mu
  double compliance;    ///< V / lambda, 0 at nu = 0.5
  double density;       ///< V rho
} Mean;

static LitheStatus read_material(const Weigher *w, const double x[3], double *lambda, double *mu,
                                 double *density) {
  double young, poisson;
  const LthMaterialField *m = &w->s->material;
  m->eval(m->self, x, &young, &poisson, density);
  if (!(young > 0) || !isfinite(young))
    LITHE_FAIL(w->ctx, LITHE_BAD_INPUT,
               "Young's modulus must be a positive number of Pa, got %g at (%g, %g, %g)", young,
               x[0], x[1], x[2]);
  bool mixed = w->s->formulation == LTH_FORM_MIXED;
  if (mixed ? !(poisson > 0 && poisson <= 0.5) : !(poisson > -1 && poisson < 0.5))
    LITHE_FAIL(w->ctx, LITHE_BAD_INPUT, "Poisson's ratio must lie %s, got %g at (%g, %g, %g)",
               mixed ? "above 0 and at most at 0.5 in the mixed formulation"
                     : "between -1 and 0.5 (excluded; `formulation: mixed` takes 0.5)",
               poisson, x[0], x[1], x[2]);
  if (!(*density >= 0) || !isfinite(*density))
    LITHE_FAIL(w->ctx, LITHE_BAD_INPUT,
               "the density must be a number of kg/m^3, 0 or more, got %g at (%g, %g, %g)",
               *density, x[0], x[1], x[2]);
  lth_lame(young, poisson, lambda, mu);
  if (poisson == 0.5) *lambda = INFINITY;
  return LITHE_OK;
}

static int lattice_at(const Lattice *t, int x, int y, int z) {
  return x + t->width[0] * (y + t->width[1] * z);
}

/// Fraction and, where it is not uniform, material of the part at lattice place p (from 0, the last half of the
/// cells before the block).
static LitheStatus read_part(const Weigher *w, const LthHalo *halo, LitheIndex block,
                             const int p[3], Lattice *t) {
  const LthFractions *f = w->s->fractions;
  const LthSparseGrid *g = f->grid;
  int at = 0, q = 0, cell[3], bit[3];
  for (int a = 0; a < g->dim; a++) {
    cell[a] = (p[a] + 1) / 2; // 0 is the cell before the block
    bit[a] = (p[a] + 1) % 2;
    at += cell[a] * halo->stride[a];
    q |= bit[a] << a;
  }
  LitheCount slot = halo->slot[at];
  int k = lattice_at(t, p[0], p[1], p[2]);
  t->v[k] = slot < 0 ? 0 : lth_fractions_part(f, slot, q);
  if (t->v[k] == 0 || w->s->material.is_uniform) return LITHE_OK;
  const LitheIndex *place = g->place + 3 * (LitheCount)block;
  double x[3] = {0};
  for (int a = 0; a < g->dim; a++)
    x[a] = g->origin[a] + g->h[a] * (place[a] * g->side + cell[a] - 1 + 0.25 + 0.5 * bit[a]);
  return read_material(w, x, &t->lambda[k], &t->mu[k], &t->density[k]);
}

static LitheStatus fill_lattice(const Weigher *w, const LthHalo *halo, LitheIndex block,
                                Lattice *t) {
  const LthSparseGrid *g = w->s->grid;
  for (int a = 0; a < 3; a++) t->width[a] = a < g->dim ? 2 * g->side + 1 : 1;
  for (int z = 0; z < t->width[2]; z++)
    for (int y = 0; y < t->width[1]; y++)
      for (int x = 0; x < t->width[0]; x++)
        LITHE_TRY(read_part(w, halo, block, (int[3]){x, y, z}, t));
  return LITHE_OK;
}

/// Harmonic means of what differs from part to part. Where some lambda is not positive, that of 3 lambda + 2 mu
/// stands in for lambda's, which keeps the mean definite.
static void average(const Lattice *t, const int *part, int n, Mean *m) {
  double v = 0, soft = 0, volume_soft = 0, bulk_soft = 0, mass = 0, least = INFINITY;
  for (int i = 0; i < n; i++) {
    int k = part[i];
    if (t->v[k] == 0) continue;
    v += t->v[k];
    soft += t->v[k] / t->mu[k];
    volume_soft += t->v[k] / t->lambda[k];
    bulk_soft += t->v[k] / (3 * t->lambda[k] + 2 * t->mu[k]);
    mass += t->v[k] * t->density[k];
    least = fmin(least, t->lambda[k]);
  }
  *m = (Mean){.V = v / n};
  if (v == 0) return;
  m->mu = m->V * (v / soft);
  m->compliance = volume_soft / n;
  m->lambda = least > 0 ? m->V * (v / volume_soft) : (m->V * (v / bulk_soft) - 2 * m->mu) / 3;
  if (isinf(m->lambda)) m->lambda = LTH_PENALTY * m->mu / m->V;
  m->density = mass / n;
}

/// Mean over the parts of a cell moved by half a cell down the axes that `half` says. (x, y, z) is the cell in
/// the block.
static void mean_at(const Weigher *w, const Lattice *t, const int cell[3], const int half[3],
                    Mean *m) {
  int part[8], n = 0, dim = w->s->dim, low[3] = {0};
  for (int a = 0; a < dim; a++) low[a] = 2 * cell[a] + 1 - half[a];
  for (int z = 0; z <= (dim == 3); z++)
    for (int y = 0; y <= 1; y++)
      for (int x = 0; x <= 1; x++) part[n++] = lattice_at(t, low[0] + x, low[1] + y, low[2] + z);
  if (!w->s->material.is_uniform) {
    average(t, part, n, m);
    return;
  }
  double v = 0;
  for (int i = 0; i < n; i++) v += t->v[part[i]];
  v /= n;
  double lambda = isinf(w->lambda) ? (v > 0 ? LTH_PENALTY * w->mu : 0) : v * w->lambda;
  *m = (Mean){v, lambda, v * w->mu, v / w->lambda, v * w->density};
}

static void weigh_slot(const Weigher *w, const Lattice *t, const int cell[3], LitheCount slot) {
  LthStaggered *s = w->s;
  LthStaggeredLevel *level = &s->level;
  Mean m;
  mean_at(w, t, cell, (int[3]){0, 0, 0}, &m);
  bool live = m.V > w->least;
  level->volume[slot] = live ? m.V : 0;
  level->lambda[slot] = live ? m.lambda : 0;
  level->mu[slot] = live ? m.mu : 0;
  if (level->compliance) level->compliance[slot] = live ? m.compliance : 0;
  for (int a = 0; a < s->dim; a++) {
    mean_at(w, t, cell, (int[3]){a == 0, a == 1, a == 2}, &m);
    level->mass[a][slot] = m.density;
  }
  for (int e = lth_staggered_first_edge(s); e < 3; e++) {
    mean_at(w, t, cell, (int[3]){e != 0, e != 1, e != 2}, &m);
    level->shear[e][slot] = m.mu;
  }
}

/// All parts of a block and of those before it are full.
static bool is_full(const LthStaggered *s, LitheIndex block) {
  const LthSparseGrid *g = s->grid;
  for (int z = 0; z <= (g->dim == 3); z++)
    for (int y = 0; y <= 1; y++)
      for (int x = 0; x <= 1; x++) {
        LitheIndex b = g->neighbor[(LitheCount)block * g->n_neighbors + 9 * z + 3 * y + x];
        if (b < 0) return false;
        const uint16_t *cell = s->fractions->cell + (LitheCount)b * g->block_cells;
        for (LitheIndex k = 0; k < g->block_cells; k++)
          if (cell[k] != LTH_CELL_FULL) return false;
      }
  return true;
}

static void fill_full(const Weigher *w, LitheIndex block) {
  LthStaggered *s = w->s;
  LthStaggeredLevel *level = &s->level;
  LitheCount first = (LitheCount)block * s->grid->block_cells;
  for (LitheCount slot = first; slot < first + s->grid->block_cells; slot++) {
    level->volume[slot] = 1;
    level->lambda[slot] = isinf(w->lambda) ? LTH_PENALTY * w->mu : w->lambda;
    level->mu[slot] = w->mu;
    if (level->compliance) level->compliance[slot] = 1 / w->lambda;
    for (int a = 0; a < s->dim; a++) level->mass[a][slot] = w->density;
    for (int e = lth_staggered_first_edge(s); e < 3; e++) level->shear[e][slot] = w->mu;
  }
}

static LitheStatus weigh_block(const Weigher *w, LitheIndex block, Lattice *t) {
  const LthSparseGrid *g = w->s->grid;
  if (w->s->material.is_uniform && is_full(w->s, block)) {
    fill_full(w, block);
    return LITHE_OK;
  }
  LthHalo halo;
  lth_halo_fill(g, block, &halo);
  LITHE_TRY(fill_lattice(w, &halo, block, t));
  for (LitheIndex local = 0; local < g->block_cells; local++) {
    int cell[3] = {local % g->side, local / g->side % g->side, local / (g->side * g->side)};
    weigh_slot(w, t, cell, (LitheCount)block * g->block_cells + local);
  }
  return LITHE_OK;
}

/// Uniform constants are read at the grid's centre.
static LitheStatus read_uniform(Weigher *w) {
  const LthSparseGrid *g = w->s->grid;
  if (!w->s->material.is_uniform) return LITHE_OK;
  double x[3];
  for (int a = 0; a < 3; a++) x[a] = g->origin[a] + 0.5 * g->h[a] * g->n[a];
  return read_material(w, x, &w->lambda, &w->mu, &w->density);
}

LitheStatus lth_staggered_weigh(LitheCtx *ctx, LthStaggered *s, double least) {
  LitheStatus status = LITHE_OK;
  Weigher w = {.ctx = ctx, .s = s, .least = least};
  Lattice *lattice = NULL;
  int threads = lth_threads(ctx);
  LITHE_TRY(read_uniform(&w));
  LTH_NEW(ctx, lattice, threads);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (int thread = 0; thread < threads; thread++) {
    Lattice *own = &lattice[thread];
    LitheCount n = s->grid->n_blocks, end = n * (thread + 1) / threads;
    for (LitheCount k = n * thread / threads; k < end && own->status == LITHE_OK; k++)
      own->status = weigh_block(&w, (LitheIndex)k, own);
  }
  for (int thread = 0; thread < threads && status == LITHE_OK; thread++)
    status = lattice[thread].status;
  lth_free(ctx, lattice);
  return status;
}
