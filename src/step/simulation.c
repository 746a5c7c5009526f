/// A body that moves: creation, state and report.
#include "step/simulation_priv.h"

#include <math.h>
#include <string.h>

LthStepOptions lth_step_options_default(void) {
  return (LthStepOptions){.linear = LTH_LINEAR_AUTO,
                          .tolerance = 1e-8,
                          .newton_tolerance = 1e-8,
                          .newton_iterations = 200};
}

static bool never_changes(const LthLoad *load) {
  for (int i = 0; i < 3; i++)
    if (load->value[i].eval) return false;
  for (int i = 0; i < 9; i++)
    if (load->stress[i].eval) return false;
  return !(load->kind == LTH_LOAD_PRESSURE && load->follower);
}

static LitheStatus add_loads(LitheCtx *ctx, LthSimulation *s, bool fixed, double t, double *f) {
  for (LitheIndex i = 0; i < s->body.n_loads; i++)
    if (never_changes(&s->body.loads[i]) == fixed)
      LITHE_TRY(lth_dg_add_load(ctx, s->body.space, &s->body.loads[i], t, s->x, f));
  return LITHE_OK;
}

LitheStatus lth_step_external_force(LitheCtx *ctx, LthSimulation *s, double t) {
  memcpy(s->f_ext, s->f_fixed, sizeof *s->f_ext * (size_t)s->n);
  return add_loads(ctx, s, false, t, s->f_ext);
}

static LitheStatus check_options(LitheCtx *ctx, const LthBodyDef *body, const LthStepOptions *o) {
  if (!(o->tolerance > 0 && o->tolerance < 1))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "solver.tolerance: expected a number between 0 and 1, got %g",
               o->tolerance);
  if (!(o->newton_tolerance > 0 && o->newton_tolerance < 1))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "solver.newton.tolerance: expected a number between 0 and 1, got %g",
               o->newton_tolerance);
  if (body->strong && !body->prescribe)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "strongly held cells need a function that prescribes their motion");
  return LITHE_OK;
}

static LitheStatus allocate_vectors(LitheCtx *ctx, LthSimulation *s) {
  double **vectors[] = {&s->x_rest,   &s->x,      &s->v,      &s->u,    &s->f_fixed,
                        &s->f_ext,    &s->f0,     &s->force,  &s->base, &s->rhs,
                        &s->solution, &s->driven, &s->scratch};
  for (size_t i = 0; i < sizeof vectors / sizeof vectors[0]; i++) LTH_NEW(ctx, *vectors[i], s->n);
  LTH_NEW(ctx, s->mass, s->body.space->n_funcs);
  return LITHE_OK;
}

static LitheStatus set_up_solvers(LitheCtx *ctx, LthSimulation *s) {
  LITHE_TRY(lth_dg_matrix_create(ctx, s->body.op, &s->A));
  LITHE_TRY(lth_block_jacobi_create(ctx, s->A, &s->jacobi));
  LITHE_TRY(lth_reduction_create(ctx, s->A, s->jacobi, &s->reduction));
  LITHE_TRY(lth_cg_create(ctx, s->n, &s->cg));
  for (LitheIndex cell = 0; cell < s->A->n_rows; cell++) {
    LitheCount m = s->A->row_off[cell + 1] - s->A->row_off[cell];
    s->n_extra += m * m;
    s->has_strong |= lth_is_strong(s, cell);
  }
  if (s->body.contact) LTH_NEW(ctx, s->extra, s->n_extra);
  return LITHE_OK;
}

LitheStatus lth_simulation_create(LitheCtx *ctx, const LthBodyDef *body,
                                  const LthStepOptions *options, LthSimulation **sim) {
  LitheStatus status = LITHE_OK;
  LthSimulation *s = NULL;
  *sim = NULL;
  LITHE_TRY(check_options(ctx, body, options));
  LTH_NEW_OR(done, ctx, s, 1);
  s->body = *body;
  s->options = *options;
  s->n = body->space->n_dofs;
  s->report = (LthStepReport){.converged = true, .linear = "pcg", .linear_reason = "as asked"};
  if (s->options.max_iterations <= 0)
    s->options.max_iterations = (LitheIndex)(10 * sqrt((double)s->n)) + 1000;
  LITHE_TRY_OR(done, allocate_vectors(ctx, s));
  LITHE_TRY_OR(done, set_up_solvers(ctx, s));
  lth_dg_rest(body->space, s->x_rest);
  memcpy(s->x, s->x_rest, sizeof *s->x * (size_t)s->n);
  lth_dg_mass(body->space, body->density, s->mass);
  lth_dg_add_gravity(body->space, body->density, body->gravity, s->f_fixed);
  LITHE_TRY_OR(done, add_loads(ctx, s, true, 0, s->f_fixed));
  *sim = s;
  s = NULL;
done:
  lth_simulation_destroy(ctx, &s);
  return status;
}

void lth_simulation_destroy(LitheCtx *ctx, LthSimulation **sim) {
  if (!sim || !*sim) return;
  LthSimulation *s = *sim;
  double *vectors[] = {s->x_rest,  s->x,     s->v,     s->u,    s->f_fixed,  s->f_ext,
                       s->f0,      s->force, s->base,  s->rhs,  s->solution, s->driven,
                       s->scratch, s->mass,  s->extra, s->best, s->start,    s->f_before};
  for (size_t i = 0; i < sizeof vectors / sizeof vectors[0]; i++) lth_free(ctx, vectors[i]);
  lth_anderson_destroy(ctx, &s->anderson);
  lth_cg_destroy(ctx, &s->cg);
  lth_reduction_destroy(ctx, &s->reduction);
  lth_block_jacobi_destroy(ctx, &s->jacobi);
  if (s->engine) s->engine->destroy(ctx, &s->factor);
  lth_block_matrix_destroy(ctx, &s->A);
  lth_free(ctx, s);
  *sim = NULL;
}

double *lth_simulation_position(LthSimulation *s) { return s->x; }
double *lth_simulation_velocity(LthSimulation *s) { return s->v; }
double lth_simulation_time(const LthSimulation *s) { return s->t; }
void lth_simulation_set_time(LthSimulation *sim, double t) { sim->t = t; }
const LthBlockMatrix *lth_simulation_matrix(const LthSimulation *s) { return s->A; }
const LthStepReport *lth_simulation_report(const LthSimulation *s) { return &s->report; }

LitheStatus lth_simulation_imbalance(LitheCtx *ctx, LthSimulation *s, const double **force) {
  *force = s->force;
  return lth_step_assemble(ctx, s, s->t);
}

const double *lth_simulation_displacement(LthSimulation *s) {
  for (LitheCount i = 0; i < s->n; i++) s->u[i] = s->x[i] - s->x_rest[i];
  return s->u;
}
