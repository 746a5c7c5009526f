/// Staggered bodies for tests: fractions of a shape or a function, one material, what is held, a matrix and vectors.
#pragma once

#include "check.h"

#include "base/tensor.h"
#include "disc/staggered/staggered.h"
#include "geometry/fractions.h"
#include "la/engine.h"

#include <string.h>

typedef struct SgDef {
  int dim;
  double low[3], high[3]; // of the grid
  LitheIndex n[3];        // cells
  LthPartFunction part;   // fraction of a part; or NULL: by `shape` and `method`
  const void *part_self;
  const LthShape *shape; // may be NULL
  LthFractionDef method;
  double young, poisson, density; // 0: 1000 Pa, 0.3, 1 kg/m^3; nu = 0 as a tiny number
  LthMaterialField material;      // instead of them
  LthFormulation formulation;
  const LthStaggeredHold *holds;
  LitheIndex n_holds;
  double least;
} SgDef;

typedef struct SgBody {
  SgDef def;
  LitheCtx *ctx;
  LthFractions *fractions;
  LthDisc *disc;
  LthStaggered *s;
  LthBlockMatrix *K;
  double *rest, *x, *f0, *f, *r;
} SgBody;

static inline void sg_material(const void *self, const double x[3], double *young, double *poisson,
                               double *density) {
  const SgDef *d = self;
  (void)x;
  *young = d->young > 0 ? d->young : 1000;
  *poisson = d->poisson != 0 ? d->poisson : 0.3;
  *density = d->density > 0 ? d->density : 1;
}

/// Everything is full.
static inline double sg_full(const void *self, const double low[3], const double size[3]) {
  (void)self, (void)low, (void)size;
  return 1;
}

static inline void sg_fractions(SgBody *b) {
  const SgDef *d = &b->def;
  double h[3] = {1, 1, 1};
  for (int a = 0; a < d->dim; a++) h[a] = (d->high[a] - d->low[a]) / d->n[a];
  if (d->part)
    CHECK_OK(b->ctx, lth_fractions_from(b->ctx, d->dim, d->low, h, d->n, d->part, d->part_self,
                                        &b->fractions));
  else
    CHECK_OK(b->ctx, lth_fractions_create(b->ctx, d->shape, d->dim, d->low, h, d->n, &d->method,
                                          &b->fractions));
}

static inline LitheStatus sg_try(SgBody *b) {
  LthStaggeredDef def = {.fractions = b->fractions,
                         .shape = b->def.shape,
                         .material = b->def.material,
                         .formulation = b->def.formulation,
                         .holds = b->def.holds,
                         .n_holds = b->def.n_holds,
                         .least_fraction = b->def.least};
  return lth_staggered_create(b->ctx, &def, &b->disc);
}

/// `b` keeps its place: the material points into it.
static inline void sg_create(SgBody *b, const SgDef *def) {
  *b = (SgBody){.def = *def, .ctx = test_ctx()};
  if (!b->def.material.eval)
    b->def.material = (LthMaterialField){.eval = sg_material, .self = &b->def, .is_uniform = true};
  sg_fractions(b);
  CHECK_OK(b->ctx, sg_try(b));
  b->s = lth_staggered_of(b->disc);
  LitheCount n = b->disc->n_dofs;
  b->rest = lth_alloc(b->ctx, n, sizeof *b->rest);
  b->x = lth_alloc(b->ctx, n, sizeof *b->x);
  b->f0 = lth_alloc(b->ctx, n, sizeof *b->f0);
  b->f = lth_alloc(b->ctx, n, sizeof *b->f);
  b->r = lth_alloc(b->ctx, n, sizeof *b->r);
  b->disc->table->rest(b->disc, b->rest);
  memcpy(b->x, b->rest, sizeof *b->x * (size_t)n);
}

static inline void sg_assemble(SgBody *b) {
  CHECK_OK(b->ctx, b->disc->table->matrix_create(b->ctx, b->disc, &b->K));
  b->disc->table->assemble(b->disc, 0, b->K, b->f0);
}

static inline void sg_free(SgBody *b) {
  lth_block_matrix_destroy(b->ctx, &b->K);
  double *vectors[] = {b->rest, b->x, b->f0, b->f, b->r};
  for (int i = 0; i < 5; i++) lth_free(b->ctx, vectors[i]);
  lth_disc_destroy(b->ctx, &b->disc);
  lth_fractions_destroy(b->ctx, &b->fractions);
  LitheCount left = lth_alloc_bytes(b->ctx);
  lithe_ctx_destroy(&b->ctx);
  assert_int_equal(left, 0);
}

/// y = K x - f0: the internal force.
static inline void sg_force(const SgBody *b, const double *x, double *y) {
  lth_block_matrix_apply(b->K, 1, x, y);
  for (LitheCount i = 0; i < b->disc->n_dofs; i++) y[i] -= b->f0[i];
}

static inline double sg_largest(LitheCount n, const double *y) {
  double most = 0;
  for (LitheCount i = 0; i < n; i++) most = fmax(most, fabs(y[i]));
  return most;
}

static inline bool sg_is_free(const SgBody *b, LitheCount k) {
  return lth_staggered_held(b->disc)[k] == LTH_NOT_HELD;
}

/// Rows and columns of what is held or absent become those of the identity.
static inline void sg_hold(SgBody *b) {
  for (LitheIndex row = 0; row < b->K->n_rows; row++)
    for (LitheCount e = b->K->block_off[row]; e < b->K->block_off[row + 1]; e++)
      for (int k = 0; k < 9; k++) {
        LitheCount i = 3 * (LitheCount)row + k / 3, j = 3 * (LitheCount)b->K->block_col[e] + k % 3;
        if (sg_is_free(b, i) && sg_is_free(b, j)) continue;
        b->K->values[b->K->value_off[e] + k] = i == j;
      }
}

/// x = equilibrium under the forces f with held unknowns where they are prescribed; b->r, f0 and K are overwritten.
/// LITHE_NOT_CONVERGED: the matrix is not definite.
static inline LitheStatus sg_solve(SgBody *b) {
  const LthEngine *engine = lth_engine_find("cholesky");
  LthFactor *factor = NULL;
  LitheCount n = b->disc->n_dofs;
  CHECK_OK(b->ctx, lth_staggered_prescribe(b->disc, 0, b->x));
  sg_force(b, b->x, b->r);
  for (LitheCount i = 0; i < n; i++) b->r[i] = sg_is_free(b, i) ? b->f[i] - b->r[i] : 0;
  sg_hold(b);
  LitheStatus status = engine->analyse(b->ctx, b->K, &factor);
  if (status == LITHE_OK) status = engine->factorize(b->ctx, factor, b->K);
  if (status == LITHE_OK) status = engine->solve(b->ctx, factor, b->r, b->f0);
  for (LitheCount i = 0; status == LITHE_OK && i < n; i++)
    if (sg_is_free(b, i)) b->x[i] += b->f0[i];
  engine->destroy(b->ctx, &factor);
  return status;
}

/// Values of a field at the unknowns.
static inline void sg_project(const SgBody *b,
                              void (*field)(const void *self, const double x[3], double value[3]),
                              const void *self, double *coef) {
  CHECK_OK(b->ctx, b->disc->table->project(b->ctx, b->disc, field, self, coef));
}
