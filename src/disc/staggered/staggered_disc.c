/// Building and freeing the staggered discretisation, and its table.
#include "disc/staggered/staggered_finite.h"
#include "disc/staggered/staggered_loose.h"
#include "disc/staggered/staggered_priv.h"

#define LEAST_FRACTION 1e-4

static void destroy(LitheCtx *ctx, LthDisc *disc) {
  LthStaggered *s = disc->self;
  lth_staggered_finite_free(ctx, s);
  lth_rollers_destroy(ctx, s);
  lth_mixed_solver_destroy(ctx, s);
  lth_mixed_state_destroy(ctx, s);
  lth_staggered_solver_destroy(ctx, s);
  lth_staggered_level_free(ctx, &s->level);
  void *blocks[] = {s->func, s->slot,    s->cell, s->cell_slot, s->held,     s->hold, s->beyond,
                    s->f0,   s->partial, s->sums, s->degree,    s->row_func, s};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
}

/// Rotations do not exist in a linear body; pressures of nu = 0.5 follow.
static void update_rotations(LthDisc *disc, const double *x) {
  (void)x;
  lth_mixed_state_linearise(lth_staggered_of(disc));
}

static const LthDiscTable table = {.name = "staggered",
                                   .eval = lth_staggered_eval,
                                   .eval_gradient = lth_staggered_eval_gradient,
                                   .mean_gradient = lth_staggered_mean_gradient,
                                   .find_cell = lth_staggered_find_cell,
                                   .turn = lth_staggered_turn,
                                   .parts = lth_staggered_parts,
                                   .rest = lth_staggered_rest,
                                   .one = lth_staggered_one,
                                   .project = lth_staggered_project,
                                   .matrix_create = lth_staggered_matrix_create,
                                   .update_rotations = update_rotations,
                                   .assemble = lth_staggered_assemble,
                                   .assemble_load = lth_staggered_assemble_load,
                                   .energy = lth_staggered_energy,
                                   .add_mass = lth_staggered_add_mass,
                                   .apply_mass = lth_staggered_apply_mass,
                                   .mass_diagonal = lth_staggered_mass_diagonal,
                                   .add_load = lth_staggered_add_load,
                                   .add_gravity = lth_staggered_add_gravity,
                                   .reactions = lth_rollers_reactions,
                                   .stress = lth_staggered_stress,
                                   .archive = lth_mixed_state_archive,
                                   .destroy = destroy};

void lth_staggered_slot_place(const LthStaggered *s, LitheCount slot, int a, double x[3]) {
  LitheIndex cell[3];
  double offset[3] = {0.5, 0.5, 0.5};
  offset[a] = a < s->dim ? 0 : 0.5;
  lth_sparse_grid_cell(s->grid, slot, cell);
  lth_sparse_grid_place(s->grid, cell, offset, x);
}

void lth_staggered_place(const LthStaggered *s, LitheIndex func, int a, double x[3]) {
  lth_staggered_slot_place(s, s->slot[func], a, x);
}

/// Give numbers to slots with an unknown that is alive, and to live cells.
static LitheStatus number(LitheCtx *ctx, LthStaggered *s) {
  LitheCount n_funcs = 0, n_cells = 0;
  for (LitheCount slot = 0; slot < s->grid->n_slots; slot++) {
    bool alive = false;
    for (int a = 0; a < s->dim; a++) alive |= lth_staggered_slot_alive(s, a, slot);
    bool live = lth_level_is_live(&s->level, slot);
    s->func[slot] = alive ? (LitheIndex)n_funcs : -1;
    s->cell[slot] = live ? (LitheIndex)n_cells : -1;
    n_funcs += alive;
    n_cells += live;
  }
  if (n_cells == 0)
    LITHE_FAIL(
        ctx, LITHE_BAD_INPUT,
        "nothing of the body is left on the grid: the shape is thinner than two cells or lies "
        "beside them; use smaller cells");
  if (n_funcs > INT32_MAX / 3)
    LITHE_FAIL(ctx, LITHE_UNSUPPORTED, "%lld unknowns are too many for one body",
               (long long)(3 * n_funcs));
  LTH_NEW(ctx, s->slot, n_funcs);
  LTH_NEW(ctx, s->cell_slot, n_cells);
  for (LitheCount slot = 0; slot < s->grid->n_slots; slot++) {
    if (s->func[slot] >= 0) s->slot[s->func[slot]] = (LitheIndex)slot;
    if (s->cell[slot] >= 0) s->cell_slot[s->cell[slot]] = (LitheIndex)slot;
  }
  s->disc.n_funcs = s->disc.n_rows = (LitheIndex)n_funcs;
  s->disc.n_dofs = 3 * n_funcs;
  s->disc.n_cells = (LitheIndex)n_cells;
  return LITHE_OK;
}

static LitheStatus describe(LitheCtx *ctx, LthStaggered *s) {
  LTH_NEW(ctx, s->row_func, (LitheCount)s->disc.n_rows + 1);
  LTH_NEW(ctx, s->degree, s->disc.n_cells);
  for (LitheIndex i = 0; i <= s->disc.n_rows; i++) s->row_func[i] = i;
  memset(s->degree, 1, (size_t)s->disc.n_cells);
  s->disc.row_func = s->row_func;
  s->disc.cell_degree = s->degree;
  return LITHE_OK;
}

static void copy_def(LitheCtx *ctx, const LthStaggeredDef *def, LthStaggered *s) {
  s->table = table;
  s->disc.table = &s->table;
  s->disc.is_split = true;
  s->disc.self = s;
  s->ctx = ctx;
  s->dim = def->fractions->grid->dim;
  s->fractions = def->fractions;
  s->shape = def->shape;
  s->grid = def->fractions->grid;
  s->material = def->material;
  s->model = def->model;
  s->formulation = def->formulation;
  s->holds = def->holds;
  s->n_holds = def->n_holds;
  s->roller = def->rollers;
  s->n_rollers = def->n_rollers;
  s->own = def->own;
}

/// Rule A, and no cell that hangs loose.
static LitheStatus settle(LitheCtx *ctx, LthStaggered *s) {
  LthLoose loose;
  lth_staggered_rule_a(ctx, &s->level);
  LITHE_TRY(lth_staggered_drop_loose(ctx, &s->level, &loose));
  lth_staggered_drop_unread(s);
  double whole = 0, left = 0;
  for (LitheCount slot = 0; slot < s->grid->n_slots; slot++) {
    whole += s->level.volume[slot];
    if (!lth_level_is_live(&s->level, slot)) s->level.volume[slot] = 0;
    left += s->level.volume[slot];
  }
  if (loose.n_cells > 0)
    lth_warn(ctx,
             "%lld cells (%.2g %% of the body) are left out: they hang on by features thinner than "
             "two cells, as near (%g, %g, %g); smaller cells would resolve these",
             (long long)loose.n_cells, 100 * (whole - left) / whole, loose.place[0], loose.place[1],
             loose.place[2]);
  return LITHE_OK;
}

/// Both forms have the same displacements: where lambda is not large next to mu anywhere, pressures are of no use.
static void drop_pressures(LitheCtx *ctx, LthStaggered *s) {
  LthStaggeredLevel *l = &s->level;
  for (LitheCount slot = 0; l->compliance && slot < s->grid->n_slots; slot++)
    if (l->volume[slot] > 0 &&
        (l->compliance[slot] == 0 || l->lambda[slot] > LTH_STIFFEST * l->mu[slot]))
      return;
  lth_free(ctx, l->compliance);
  l->compliance = NULL;
}

static LitheStatus build(LitheCtx *ctx, const LthStaggeredDef *def, LthStaggered *s) {
  copy_def(ctx, def, s);
  if (s->grid->n_slots > INT32_MAX)
    LITHE_FAIL(ctx, LITHE_UNSUPPORTED, "%lld cells in blocks of the grid are too many for one body",
               (long long)s->grid->n_slots);
  LITHE_TRY(lth_staggered_level_alloc(ctx, s->grid, &s->level));
  LTH_NEW(ctx, s->level.volume, s->grid->n_slots);
  if (s->formulation == LTH_FORM_MIXED) LTH_NEW(ctx, s->level.compliance, s->grid->n_slots);
  LTH_NEW(ctx, s->func, s->grid->n_slots);
  LTH_NEW(ctx, s->cell, s->grid->n_slots);
  LTH_NEW(ctx, s->partial, s->grid->n_blocks);
  LTH_NEW(ctx, s->sums, s->grid->n_blocks);
  LITHE_TRY(
      lth_staggered_weigh(ctx, s, def->least_fraction > 0 ? def->least_fraction : LEAST_FRACTION));
  lth_staggered_mark_held(s);
  LITHE_TRY(lth_staggered_stiffen_walls(ctx, s));
  LITHE_TRY(settle(ctx, s));
  LITHE_TRY(number(ctx, s));
  LITHE_TRY(describe(ctx, s));
  LITHE_TRY(lth_staggered_build_holds(ctx, s));
  LITHE_TRY(lth_staggered_build_beyond(ctx, s));
  drop_pressures(ctx, s);
  LITHE_TRY(lth_mixed_state_create(ctx, s));
  LITHE_TRY(lth_rollers_create(ctx, s));
  if (s->model != LTH_MATERIAL_LINEAR) return lth_staggered_finite_attach(ctx, s);
  LITHE_TRY(lth_staggered_level_pack(ctx, &s->level));
  if (lth_rollers_act(s)) return LITHE_OK; // their terms are in the matrix alone
  return s->mixed ? lth_mixed_solver_create(ctx, s) : lth_staggered_solver_create(ctx, s);
}

LitheStatus lth_staggered_create(LitheCtx *ctx, const LthStaggeredDef *def, LthDisc **disc) {
  LthStaggered *s = NULL;
  *disc = NULL;
  LTH_NEW(ctx, s, 1);
  *disc = &s->disc;
  LitheStatus status = build(ctx, def, s);
  if (status != LITHE_OK) lth_disc_destroy(ctx, disc);
  return status;
}
