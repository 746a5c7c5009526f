/// Small staggered bodies of any material for tests: a block of cells, all or some of its parts full.
#pragma once

#include "check.h"

#include "base/tensor.h"
#include "disc/staggered/staggered_finite.h"

#include <stdlib.h>
#include <string.h>

typedef struct FiniteBody {
  LitheCtx *ctx;
  LthFractions *fractions;
  LthDisc *disc;
  LthStaggered *s;
  LthBlockMatrix *K;
  double *x0, *x, *f0, *f; ///< rest, position, load, force (n_dofs)
  double young, poisson;
  double size[3]; ///< for holds [m]
  LthStaggeredHold hold[4];
  LitheIndex n_holds;
  LitheCount n;
} FiniteBody;

static inline void finite_material(const void *self, const double x[3], double *young,
                                   double *poisson, double *density) {
  const FiniteBody *b = self;
  (void)x;
  *young = b->young, *poisson = b->poisson, *density = 1000;
}

static inline double finite_full(const void *self, const double low[3], const double size[3]) {
  (void)self, (void)low, (void)size;
  return 1;
}

/// A round body with parts of any fraction at its rim, in the unit square or cube.
static inline double finite_round(const void *self, const double low[3], const double size[3]) {
  double r2 = 0;
  (void)self;
  for (int a = 0; a < 3; a++)
    if (size[a] > 0) r2 += (low[a] + 0.5 * size[a] - 0.5) * (low[a] + 0.5 * size[a] - 0.5);
  return fmin(1, fmax(0, 6 * (0.48 - sqrt(r2))));
}

static inline double *finite_zeros(LitheCount n) {
  if (n < 0) abort();
  return calloc((size_t)n, sizeof(double));
}

/// Cells of 1 / n[0] from the origin on. Set `hold` and `n_holds` before.
static inline void finite_body_create(FiniteBody *b, LthMaterialModel model, int dim,
                                      const LitheIndex n[3], LthPartFunction part) {
  double origin[3] = {0}, h[3] = {1.0 / n[0], 1.0 / n[0], dim == 3 ? 1.0 / n[0] : 1};
  b->ctx = test_ctx();
  lth_set_threads(b->ctx, 1); // bodies are small, and cores may be busy
  if (!b->young) b->young = 1e4, b->poisson = 0.3;
  CHECK_OK(b->ctx, lth_fractions_from(b->ctx, dim, origin, h, n, part ? part : finite_full, b,
                                      &b->fractions));
  LthStaggeredDef def = {.fractions = b->fractions,
                         .material = {finite_material, b, true},
                         .model = model,
                         .holds = b->hold,
                         .n_holds = b->n_holds};
  CHECK_OK(b->ctx, lth_staggered_create(b->ctx, &def, &b->disc));
  b->s = lth_staggered_of(b->disc);
  b->n = b->disc->n_dofs;
  CHECK_OK(b->ctx, b->disc->table->matrix_create(b->ctx, b->disc, &b->K));
  double **vectors[] = {&b->x0, &b->x, &b->f0, &b->f};
  for (int i = 0; i < 4; i++) *vectors[i] = finite_zeros(b->n);
  b->disc->table->rest(b->disc, b->x0);
  memcpy(b->x, b->x0, sizeof *b->x * (size_t)b->n);
}

static inline void finite_body_destroy(FiniteBody *b) {
  double *vectors[] = {b->x0, b->x, b->f0, b->f};
  for (int i = 0; i < 4; i++) free(vectors[i]);
  lth_block_matrix_destroy(b->ctx, &b->K);
  lth_disc_destroy(b->ctx, &b->disc);
  lth_fractions_destroy(b->ctx, &b->fractions);
  lithe_ctx_destroy(&b->ctx);
}

/// True of unknowns that live, held or not.
static inline bool finite_lives(const FiniteBody *b, LitheCount i) {
  int a = (int)(i % 3);
  return a < b->s->dim && b->s->level.state[a][b->s->slot[i / 3]] != LTH_UNKNOWN_DEAD;
}

/// x of living unknowns = component of map(place).
static inline void finite_deform(FiniteBody *b,
                                 void (*map)(const void *self, const double X[3], double x[3]),
                                 const void *self) {
  for (LitheCount i = 0; i < b->n; i++) {
    double X[3], x[3];
    if (!finite_lives(b, i)) continue;
    lth_staggered_place(b->s, (LitheIndex)(i / 3), (int)(i % 3), X);
    map(self, X, x);
    b->x[i] = x[i % 3];
  }
}

/// x = F X with a row-major 3x3 F.
static inline void finite_linear_map(const void *self, const double X[3], double x[3]) {
  lth_m3_apply(self, X, x);
}

/// Rotation by so many degrees about z, or in 3D about an oblique axis.
static inline void finite_turn(int dim, double degrees, double R[9]) {
  double oblique[3] = {0.48, 0.6, 0.64}, z[3] = {0, 0, 1};
  lth_m3_rotation(dim == 3 ? oblique : z, degrees * 3.14159265358979323846 / 180, R);
}

/// K and f0 at x, f = K x - f0.
static inline void finite_assemble(FiniteBody *b) {
  b->disc->table->update_rotations(b->disc, b->x);
  b->disc->table->assemble(b->disc, 0, b->K, b->f0);
  lth_block_matrix_apply(b->K, 1, b->x, b->f);
  for (LitheCount i = 0; i < b->n; i++) b->f[i] -= b->f0[i];
}

static inline double finite_energy(FiniteBody *b, const double *x) {
  return b->disc->table->energy(b->disc, 0, x);
}

static inline double finite_norm(LitheCount n, const double *y) {
  double sum = 0;
  for (LitheCount i = 0; i < n; i++) sum += y[i] * y[i];
  return sqrt(sum);
}

/// Dense rows and columns of K of the unknowns listed (n x n).
static inline double *finite_dense(const FiniteBody *b, LitheIndex n, const LitheCount *dof) {
  double *A = finite_zeros((LitheCount)n * n);
  for (LitheIndex i = 0; i < n; i++)
    for (LitheIndex j = 0; j < n; j++) {
      LitheCount e =
          lth_block_matrix_find(b->K, (LitheIndex)(dof[i] / 3), (LitheIndex)(dof[j] / 3));
      if (e >= 0)
        A[(LitheCount)i * n + j] = b->K->values[b->K->value_off[e] + 3 * (dof[i] % 3) + dof[j] % 3];
    }
  return A;
}
