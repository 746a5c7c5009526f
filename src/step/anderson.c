/// Anderson (1965) acceleration in the difference form of Walker and Ni (2011).
#include "step/anderson.h"

#include "la/krylov.h"

#include <math.h>
#include <string.h>

#define DEPTH LTH_ANDERSON_DEPTH
#define DEPENDENT 1e-14 // pivot over diagonal of the normal equations: the difference adds nothing

struct LthAnderson {
  LitheCount n;
  int count, newest; // differences held
  bool has_last;
  double *dx[DEPTH], *dg[DEPTH], *last_x, *last_g; // (n)
};

LitheStatus lth_anderson_create(LitheCtx *ctx, LitheCount n, LthAnderson **out) {
  LitheStatus status = LITHE_OK;
  LthAnderson *a = NULL;
  *out = NULL;
  LTH_NEW_OR(done, ctx, a, 1);
  a->n = n;
  LTH_NEW_OR(done, ctx, a->last_x, n);
  LTH_NEW_OR(done, ctx, a->last_g, n);
  for (int k = 0; k < DEPTH; k++) {
    LTH_NEW_OR(done, ctx, a->dx[k], n);
    LTH_NEW_OR(done, ctx, a->dg[k], n);
  }
  *out = a;
  a = NULL;
done:
  lth_anderson_destroy(ctx, &a);
  return status;
}

void lth_anderson_destroy(LitheCtx *ctx, LthAnderson **anderson) {
  if (!anderson || !*anderson) return;
  lth_free(ctx, (*anderson)->last_x);
  lth_free(ctx, (*anderson)->last_g);
  for (int k = 0; k < DEPTH; k++) {
    lth_free(ctx, (*anderson)->dx[k]);
    lth_free(ctx, (*anderson)->dg[k]);
  }
  lth_free(ctx, *anderson);
  *anderson = NULL;
}

void lth_anderson_reset(LthAnderson *a) {
  a->count = 0;
  a->has_last = false;
}

static void remember(LthAnderson *a, const double *x, const double *g) {
  if (a->has_last) {
    a->newest = (a->newest + 1) % DEPTH;
    a->count = a->count < DEPTH ? a->count + 1 : DEPTH;
    for (LitheCount i = 0; i < a->n; i++) {
      a->dx[a->newest][i] = x[i] - a->last_x[i];
      a->dg[a->newest][i] = g[i] - a->last_g[i];
    }
  }
  memcpy(a->last_x, x, sizeof *x * (size_t)a->n);
  memcpy(a->last_g, g, sizeof *g * (size_t)a->n);
  a->has_last = true;
}

/// Solve the normal equations N w = b of `count` unknowns by Cholesky; dependent ones get zero.
static void solve_normal(int count, double N[DEPTH][DEPTH], double *w) {
  for (int k = 0; k < count; k++) {
    double diagonal = N[k][k];
    for (int j = 0; j < k; j++) N[k][k] -= N[k][j] * N[k][j];
    bool dependent = !(N[k][k] > DEPENDENT * diagonal);
    N[k][k] = dependent ? 0 : sqrt(N[k][k]);
    for (int i = k + 1; i < count; i++) {
      for (int j = 0; j < k; j++) N[i][k] -= N[i][j] * N[k][j];
      N[i][k] = dependent ? 0 : N[i][k] / N[k][k];
    }
  }
  for (int k = 0; k < count; k++) {
    for (int j = 0; j < k; j++) w[k] -= N[k][j] * w[j];
    w[k] = N[k][k] > 0 ? w[k] / N[k][k] : 0;
  }
  for (int k = count - 1; k >= 0; k--) {
    for (int j = k + 1; j < count; j++) w[k] -= N[j][k] * w[j];
    w[k] = N[k][k] > 0 ? w[k] / N[k][k] : 0;
  }
}

void lth_anderson_step(LthAnderson *a, int threads, const double *g, double *x) {
  double N[DEPTH][DEPTH], w[DEPTH];
  const double *dx[DEPTH], *dg[DEPTH];
  remember(a, x, g);

  // newest first, so that older differences are the ones dropped as dependent
  for (int k = 0; k < a->count; k++) {
    int slot = (a->newest + DEPTH - k) % DEPTH;
    dx[k] = a->dx[slot];
    dg[k] = a->dg[slot];
  }
  for (int k = 0; k < a->count; k++) {
    for (int j = 0; j <= k; j++) N[k][j] = lth_dot(threads, a->n, dg[k], dg[j]);
    w[k] = lth_dot(threads, a->n, dg[k], g);
  }
  solve_normal(a->count, N, w);
  for (LitheCount i = 0; i < a->n; i++) x[i] += g[i];
  for (int k = 0; k < a->count; k++)
    for (LitheCount i = 0; i < a->n; i++) x[i] -= w[k] * (dx[k][i] + dg[k][i]);
}
