/// Two DG bodies tied where their boundaries meet at x = 0, as one system.
#pragma once

#include "couple/tie.h"
#include "disc/dg/dg_disc.h"
#include "manufactured.h"

typedef struct TiedPair {
  LitheCtx *ctx; ///< of the tie and the system; each body has its own
  TestBody body[2];
  LthDisc *disc[2];
  double *density[2];
  LthPatches *joint[2];
  LthTieDef def;
  LthTie *tie;
  LthSystem *system;
  LthBlockMatrix *A;
  double *f0, *x; ///< (system->n)
} TiedPair;

static inline bool test_at_joint(const double c[3], const double n[3]) {
  return fabs(c[0]) < 1e-3 && fabs(n[0]) > 0.9;
}
static inline bool test_off_joint(const double c[3], const double n[3]) {
  return !test_at_joint(c, n);
}

/// Operators, discretisations and the tie of two bodies that are filled in. Returns what the tie says.
static inline LitheStatus tied_pair_build(TiedPair *p, TestWhere where) {
  LitheIndex row = 0;
  LitheCount dof = 0;
  p->ctx = test_ctx();
  p->def.place = "tie.0";
  for (int s = 0; s < 2; s++) {
    TestBody *b = &p->body[s];
    test_assemble(b, 0);
    p->density[s] = lth_alloc(b->ctx, b->space->n_cells, sizeof(double));
    for (LitheIndex c = 0; c < b->space->n_cells; c++) p->density[s][c] = 1;
    LthDgDiscDef def = {.space = b->space, .op = b->op, .density = p->density[s]};
    CHECK_OK(b->ctx, lth_dg_disc_create(b->ctx, &def, &p->disc[s]));
    p->joint[s] = test_patches(b->ctx, b->mesh, where);
    p->def.side[s] = (LthTieSide){.name = s ? "right" : "left",
                                  .disc = p->disc[s],
                                  .patches = p->joint[s],
                                  .young = b->young,
                                  .poisson = b->poisson,
                                  .space = p->def.side[s].name ? NULL : b->space,
                                  .flux = b->def.flux,
                                  .penalty = b->def.penalty,
                                  .eta = b->def.eta,
                                  .warped = b->def.warped,
                                  .first_row = row,
                                  .first_dof = dof};
    row += p->disc[s]->n_rows;
    dof += p->disc[s]->n_dofs;
  }
  return lth_tie_create(p->ctx, &p->def, &p->tie);
}

static inline void tied_pair_system(TiedPair *p) {
  LthSystemBody bodies[2] = {{.disc = p->disc[0], .warped = p->body[0].def.warped},
                             {.disc = p->disc[1], .warped = p->body[1].def.warped}};
  LthSystemDef def = {.bodies = bodies,
                      .n_bodies = 2,
                      .couplings = p->tie->coupling,
                      .n_couplings = p->tie->n_couplings};
  CHECK_OK(p->ctx, lth_system_create(p->ctx, &def, &p->system));
}

/// Assemble the system at rest and solve it for the bodies' loads (f of each).
static inline void tied_pair_solve(TiedPair *p) {
  tied_pair_system(p);
  LitheCount n = p->system->n;
  p->f0 = lth_alloc(p->ctx, n, sizeof(double));
  p->x = lth_alloc(p->ctx, n, sizeof(double));
  CHECK_OK(p->ctx, lth_system_matrix_create(p->ctx, p->system, &p->A));
  lth_system_update_rotations(p->system, NULL);
  lth_system_assemble(p->system, 0, p->A, p->f0);
  for (int s = 0; s < 2; s++)
    for (LitheCount i = 0; i < p->disc[s]->n_dofs; i++)
      p->f0[p->system->dof_first[s] + i] += p->body[s].f[i];
  const LthEngine *engine = lth_engine_find("cholesky");
  LthFactor *factor = NULL;
  CHECK_OK(p->ctx, engine->analyse(p->ctx, p->A, &factor));
  CHECK_OK(p->ctx, engine->factorize(p->ctx, factor, p->A));
  CHECK_OK(p->ctx, engine->solve(p->ctx, factor, p->f0, p->x));
  engine->destroy(p->ctx, &factor);
  for (int s = 0; s < 2; s++)
    memcpy(p->body[s].x, p->x + p->system->dof_first[s],
           sizeof(double) * (size_t)p->disc[s]->n_dofs);
}

static inline void tied_pair_free(TiedPair *p) {
  LthBlockMatrix *A = p->A;
  lth_free(p->ctx, p->f0);
  lth_free(p->ctx, p->x);
  lth_system_destroy(p->ctx, &p->system); // ends what the matrix lent
  lth_block_matrix_destroy(p->ctx, &A);
  lth_tie_destroy(p->ctx, &p->tie);
  for (int s = 0; s < 2; s++) {
    LitheCtx *ctx = p->body[s].ctx;
    lth_disc_destroy(ctx, &p->disc[s]);
    lth_free(ctx, p->density[s]);
    test_free_patches(ctx, p->joint[s]);
    test_body_free(&p->body[s]);
  }
  assert_int_equal(lth_alloc_bytes(p->ctx), 0);
  lithe_ctx_destroy(&p->ctx);
}
