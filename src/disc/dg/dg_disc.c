/// The discontinuous Galerkin method as a discretisation among others.
#include "disc/dg/dg_disc.h"

#include "disc/dg/dg_load.h"

#include <string.h>

typedef struct DgDisc {
  LthDisc disc;
  LthDgDiscDef def;
  LitheCtx *ctx;
  LitheCount *at; ///< of the last matrix' blocks in def.kept, or NULL
} DgDisc;

static const LthDgDiscDef *def_of(const LthDisc *disc) {
  const DgDisc *d = disc->self;
  return &d->def;
}

static int list_funcs(const LthDgSpace *space, LitheIndex cell, LitheIndex *func) {
  int n = lth_dg_funcs(space, cell);
  for (int i = 0; i < n; i++) func[i] = space->func_off[cell] + i;
  return n;
}

static int eval(const LthDisc *disc, LitheIndex cell, const double x[3], LitheIndex *func,
                double *phi) {
  int n = list_funcs(def_of(disc)->space, cell, func);
  lth_dg_eval(def_of(disc)->space, cell, x, phi);
  lth_disc_spread(n, 1, phi);
  return n;
}

static int eval_gradient(const LthDisc *disc, LitheIndex cell, const double x[3], LitheIndex *func,
                         double *dphi) {
  int n = list_funcs(def_of(disc)->space, cell, func);
  lth_dg_eval_gradient(def_of(disc)->space, cell, x, dphi);
  lth_disc_spread(n, 3, dphi);
  return n;
}

static int mean_gradient(const LthDisc *disc, LitheIndex cell, LitheIndex *func, double *dphi) {
  const LthDgSpace *space = def_of(disc)->space;
  int n = list_funcs(space, cell, func);
  memcpy(dphi, space->mean_gradient + 3 * (LitheCount)func[0], sizeof *dphi * 3 * (size_t)n);
  lth_disc_spread(n, 3, dphi);
  return n;
}

static void rest(const LthDisc *disc, double *x0) { lth_dg_rest(def_of(disc)->space, x0); }

static void one(const LthDisc *disc, double *one) {
  const LthDgSpace *space = def_of(disc)->space;
  memset(one, 0, sizeof *one * (size_t)space->n_funcs);
  for (LitheIndex c = 0; c < space->n_cells; c++) one[space->func_off[c]] = 1;
}

static LitheStatus project(LitheCtx *ctx, const LthDisc *disc,
                           void (*field)(const void *self, const double x[3], double value[3]),
                           const void *self, double *coef) {
  const LthDgSpace *space = def_of(disc)->space;
  return lth_dg_project(ctx, space, field, self, 2 * space->max_degree + 2, coef);
}

static LitheStatus matrix_create(LitheCtx *ctx, const LthDisc *disc, LthBlockMatrix **K) {
  DgDisc *d = disc->self;
  LITHE_TRY(lth_dg_pattern_create(ctx, disc->mesh, d->def.space->func_off, K));
  if (!d->def.kept) return LITHE_OK;
  lth_free(ctx, d->at);
  d->at = NULL;
  LTH_NEW(ctx, d->at, (*K)->block_off[(*K)->n_rows]);
  lth_dg_kept_find(d->def.kept, d->def.cell_record, *K, d->at);
  return LITHE_OK;
}

static void update_rotations(LthDisc *disc, const double *x) {
  if (x)
    lth_dg_update_rotations(def_of(disc)->op, x);
  else
    lth_dg_reset_rotations(def_of(disc)->op);
}

static void assemble(LthDisc *disc, double t, LthBlockMatrix *K, double *f0) {
  const DgDisc *d = disc->self;
  if (!d->at) {
    lth_dg_assemble(d->def.op, t, K, f0);
    return;
  }
  lth_dg_kept_copy(d->ctx, d->def.kept, d->at, K);
  lth_dg_assemble_load(d->def.op, t, f0);
}

static void assemble_load(LthDisc *disc, double t, double *f0) {
  lth_dg_assemble_load(def_of(disc)->op, t, f0);
}

static double energy(LthDisc *disc, double t, const double *x) {
  return lth_dg_energy(def_of(disc)->op, t, x);
}

/// Mass of a function: density |K|, for the basis is orthogonal.
static double mass_of_cell(const LthDgDiscDef *def, LitheIndex cell) {
  return def->density[cell] * def->space->mesh->cell_volume[cell];
}

static void add_mass(const LthDisc *disc, double c, LthBlockMatrix *K) {
  const LthDgDiscDef *def = def_of(disc);
  for (LitheIndex row = 0; row < K->n_rows; row++) {
    LitheCount m = K->row_off[row + 1] - K->row_off[row];
    double *B = K->values + K->value_off[K->diagonal[row]];
    double mass = c * mass_of_cell(def, row);
    for (LitheCount i = 0; i < m; i++) B[i * m + i] += mass;
  }
}

static void apply_mass(const LthDisc *disc, const double *v, double *y) {
  const LthDgDiscDef *def = def_of(disc);
  for (LitheIndex c = 0; c < def->space->n_cells; c++) {
    double mass = mass_of_cell(def, c);
    LitheCount last = 3 * (LitheCount)def->space->func_off[c + 1];
    for (LitheCount i = 3 * (LitheCount)def->space->func_off[c]; i < last; i++) y[i] = mass * v[i];
  }
}

static void mass_diagonal(const LthDisc *disc, double *mass) {
  lth_dg_mass(def_of(disc)->space, def_of(disc)->density, mass);
  lth_disc_spread(disc->n_funcs, 1, mass);
}

static LitheStatus add_load(LitheCtx *ctx, const LthDisc *disc, const LthLoad *load, double t,
                            const double *x, double *f) {
  return lth_dg_add_load(ctx, def_of(disc)->space, load, t, x, f);
}

static void add_gravity(const LthDisc *disc, const double gravity[3], double *f) {
  lth_dg_add_gravity(def_of(disc)->space, def_of(disc)->density, gravity, f);
}

static void reactions(LthDisc *disc, double t, const double *x, double *reaction) {
  lth_dg_reactions(def_of(disc)->op, t, x, reaction);
}

static void stress(const LthDisc *disc, LitheIndex cell, const double *x, const double at[3],
                   double stress[6]) {
  lth_dg_stress(def_of(disc)->op, cell, x, at, stress);
}

static void destroy(LitheCtx *ctx, LthDisc *disc) {
  DgDisc *d = disc->self;
  lth_free(ctx, d->at);
  lth_free(ctx, d);
}

static const LthDiscTable table = {
    .name = "dg",
    .eval = eval,
    .eval_gradient = eval_gradient,
    .mean_gradient = mean_gradient,
    .rest = rest,
    .one = one,
    .project = project,
    .matrix_create = matrix_create,
    .update_rotations = update_rotations,
    .assemble = assemble,
    .assemble_load = assemble_load,
    .energy = energy,
    .add_mass = add_mass,
    .apply_mass = apply_mass,
    .mass_diagonal = mass_diagonal,
    .add_load = add_load,
    .add_gravity = add_gravity,
    .reactions = reactions,
    .stress = stress,
    .destroy = destroy,
};

LitheStatus lth_dg_disc_create(LitheCtx *ctx, const LthDgDiscDef *def, LthDisc **disc) {
  DgDisc *d;
  *disc = NULL;
  LTH_NEW(ctx, d, 1);
  d->def = *def;
  d->ctx = ctx;
  d->disc = (LthDisc){.table = &table,
                      .mesh = def->space->mesh,
                      .n_cells = def->space->n_cells,
                      .n_funcs = def->space->n_funcs,
                      .n_rows = def->space->n_cells,
                      .n_dofs = def->space->n_dofs,
                      .row_func = def->space->func_off,
                      .cell_degree = def->space->degree,
                      .n_weak = def->n_weak,
                      .weak = def->weak,
                      .self = d};
  *disc = &d->disc;
  return LITHE_OK;
}
