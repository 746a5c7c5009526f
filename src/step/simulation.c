/// Bodies that move: creation, state and report.
#include "step/simulation_priv.h"

#include <math.h>
#include <string.h>

LthStepOptions lth_step_options_default(void) {
  return (LthStepOptions){.linear = LTH_LINEAR_AUTO,
                          .tolerance = 1e-8,
                          .newton_tolerance = 1e-8,
                          .newton_iterations = 200};
}

static LitheStatus check_options(LitheCtx *ctx, const LthStepOptions *o) {
  if (!(o->tolerance > 0 && o->tolerance < 1))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "solver.tolerance: expected a number between 0 and 1, got %g",
               o->tolerance);
  if (!(o->newton_tolerance > 0 && o->newton_tolerance < 1))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "solver.newton.tolerance: expected a number between 0 and 1, got %g",
               o->newton_tolerance);
  return LITHE_OK;
}

static LitheStatus set_up_solvers(LitheCtx *ctx, LthSimulation *s) {
  LTH_NEW(ctx, s->cm, s->system->n_bodies);
  LTH_NEW(ctx, s->ck, s->system->n_bodies);
  if (s->own && s->has_contact && s->own->stiffen) { // its block rows are functions
    s->n_extra = 3 * s->n;
    LTH_NEW(ctx, s->extra, s->n_extra);
  }
  if (s->own) return LITHE_OK;
  LITHE_TRY(lth_system_matrix_create(ctx, s->system, &s->A));
  LITHE_TRY(lth_block_jacobi_create(ctx, s->A, &s->jacobi));
  LITHE_TRY(lth_reduction_create(ctx, s->A, s->jacobi, &s->reduction));
  LITHE_TRY(lth_cg_create(ctx, s->n, &s->cg));
  LITHE_TRY(lth_step_volume_create(ctx, s));
  for (LitheIndex row = 0; row < s->A->n_rows; row++) {
    LitheCount m = s->A->row_off[row + 1] - s->A->row_off[row];
    s->n_extra += m * m;
  }
  if (s->has_contact) LTH_NEW(ctx, s->extra, s->n_extra);
  return LITHE_OK;
}

/// Mass of what each function moves when all move alike: M 1.
static void sum_rows_of_mass(LthSimulation *s) {
  for (LitheCount i = 0; i < s->n; i++) s->scratch[i] = s->system->one[i / 3];
  lth_system_apply_mass(s->system, s->scratch, s->row_mass);
}

LitheStatus lth_simulation_create(LitheCtx *ctx, LthSystem *system, const LthStepOptions *options,
                                  LthSimulation **sim) {
  LitheStatus status = LITHE_OK;
  LthSimulation *s = NULL;
  *sim = NULL;
  LITHE_TRY(check_options(ctx, options));
  LTH_NEW_OR(done, ctx, s, 1);
  s->system = system;
  s->options = *options;
  s->solver = LTH_LINEAR_PCG;
  s->n = system->n;
  s->report = (LthStepReport){.converged = true, .linear = "pcg", .linear_reason = "as asked"};
  s->has_contact = system->n_contacts > 0;
  if (lth_step_needs_no_matrix(system, options)) s->own = lth_system_solver(system);
  if (s->options.max_iterations <= 0)
    s->options.max_iterations =
        (LitheIndex)(10 * sqrt((double)s->n)) + (system->n_contacts > 0 ? 5000 : 1000);
  LITHE_TRY_OR(done, lth_step_vectors_create(ctx, s));
  LITHE_TRY_OR(done, set_up_solvers(ctx, s));
  lth_system_rest(system, s->x);
  if (s->x_rest) memcpy(s->x_rest, s->x, sizeof *s->x * (size_t)s->n);
  if (s->mass) lth_system_mass_diagonal(system, s->mass);
  if (!s->own) sum_rows_of_mass(s);
  *sim = s;
  s = NULL;
done:
  lth_simulation_destroy(ctx, &s);
  return status;
}

void lth_simulation_free_solvers(LitheCtx *ctx, LthSimulation *s) {
  lth_step_volume_free(ctx, s->volume);
  s->volume = NULL;
  lth_free(ctx, s->touch_first);
  s->touch_first = NULL;
  lth_block_matrix_destroy(ctx, &s->touch);
  lth_cg_destroy(ctx, &s->cg);
  lth_reduction_destroy(ctx, &s->reduction);
  lth_multilevel_destroy(ctx, &s->levels);
  lth_block_jacobi_destroy(ctx, &s->jacobi);
  if (s->engine) s->engine->destroy(ctx, &s->factor);
  lth_block_matrix_destroy(ctx, &s->A);
}

void lth_simulation_destroy(LitheCtx *ctx, LthSimulation **sim) {
  if (!sim || !*sim) return;
  LthSimulation *s = *sim;
  lth_step_vectors_free(ctx, s);
  double *blocks[] = {s->extra, s->cm,          s->ck,   s->levels_x, s->rate,
                      s->faded, s->faded_start, s->best, s->start,    s->f_before};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
  lth_stage_free(ctx, &s->stage);
  lth_rigid_free(ctx, &s->rigid);
  lth_anderson_destroy(ctx, &s->anderson);
  lth_newton_free(ctx, s->newton);
  lth_simulation_free_solvers(ctx, s);
  lth_free(ctx, s);
  *sim = NULL;
}

double *lth_simulation_position(LthSimulation *s) { return s->x; }
double *lth_simulation_velocity(LthSimulation *s) { return s->v; }
double lth_simulation_time(const LthSimulation *s) { return s->t; }
void lth_simulation_set_time(LthSimulation *sim, double t) { sim->t = t; }
const LthBlockMatrix *lth_simulation_matrix(const LthSimulation *s) { return s->A; }
const LthStepReport *lth_simulation_report(const LthSimulation *s) { return &s->report; }

const double *lth_simulation_displacement(LthSimulation *s) {
  const double *rest = s->x_rest ? s->x_rest : s->u;
  if (!s->x_rest) lth_system_rest(s->system, s->u);
  for (LitheCount i = 0; i < s->n; i++) s->u[i] = s->x[i] - rest[i];
  return s->u;
}
