/// Several bodies as one system: creation, assembly, loads.
#include "system/system_priv.h"

#include <math.h>
#include <string.h>

static const LthDisc *disc_of(const LthSystem *s, LitheIndex b) { return s->bodies[b].disc; }

static bool never_changes(const LthLoad *load) {
  for (int i = 0; i < 3; i++)
    if (load->value[i].eval) return false;
  for (int i = 0; i < 9; i++)
    if (load->stress[i].eval) return false;
  return !lth_load_follows(load);
}

static LitheStatus add_loads(LitheCtx *ctx, const LthSystem *s, bool fixed, double t,
                             const double *x, double *f) {
  for (LitheIndex b = 0; b < s->n_bodies; b++) {
    const LthSystemBody *body = s->bodies + b;
    for (LitheIndex i = 0; i < body->n_loads; i++)
      if (never_changes(&body->loads[i]) == fixed)
        LITHE_TRY(lth_disc_add_load(ctx, body->disc, &body->loads[i], t, x + s->dof_first[b],
                                    f + s->dof_first[b]));
  }
  return LITHE_OK;
}

double lth_system_fade_left(const LthSystem *s, double t) {
  double left = s->fade ? exp(-fmax(t - s->fade_start, 0) / s->fade_decay) : 0;
  return left > 1e-3 ? left : 0;
}

LitheStatus lth_system_external_force(LitheCtx *ctx, LthSystem *s, double t, const double *x,
                                      double *f) {
  memcpy(f, s->f_fixed, sizeof *f * (size_t)s->n);
  return add_loads(ctx, s, false, t, x, f);
}

/// Where each body's rows and unknowns begin.
static LitheStatus lay_out(LitheCtx *ctx, LthSystem *s) {
  LTH_NEW(ctx, s->row_first, (LitheCount)s->n_bodies + 1);
  LTH_NEW(ctx, s->dof_first, (LitheCount)s->n_bodies + 1);
  for (LitheIndex b = 0; b < s->n_bodies; b++) {
    s->row_first[b + 1] = s->row_first[b] + disc_of(s, b)->n_rows;
    s->dof_first[b + 1] = s->dof_first[b] + disc_of(s, b)->n_dofs;
    s->warped |= s->bodies[b].warped;
  }
  s->n_rows = s->row_first[s->n_bodies];
  s->n = s->dof_first[s->n_bodies];
  LTH_NEW(ctx, s->row_body, s->n_rows);
  for (LitheIndex b = 0; b < s->n_bodies; b++)
    for (LitheIndex row = s->row_first[b]; row < s->row_first[b + 1]; row++) s->row_body[row] = b;
  return LITHE_OK;
}

static LitheStatus check_held(LitheCtx *ctx, const LthSystem *s) {
  for (LitheIndex b = 0; b < s->n_bodies; b++)
    if (s->bodies[b].held && !s->bodies[b].prescribe)
      LITHE_FAIL(ctx, LITHE_BAD_INPUT,
                 "strongly held unknowns need a function that prescribes their motion");
  return LITHE_OK;
}

/// Which unknowns of all are held, and which rows have such.
static LitheStatus gather_held(LitheCtx *ctx, LthSystem *s) {
  LITHE_TRY(check_held(ctx, s));
  for (LitheIndex b = 0; b < s->n_bodies; b++)
    for (LitheCount i = 0; s->bodies[b].held && i < disc_of(s, b)->n_dofs; i++)
      s->has_held |= s->bodies[b].held[i] != 0;
  if (!s->has_held) return LITHE_OK;
  LTH_NEW(ctx, s->held, s->n);
  LTH_NEW(ctx, s->row_held, s->n_rows);
  for (LitheIndex b = 0; b < s->n_bodies; b++) {
    const LthDisc *disc = disc_of(s, b);
    if (!s->bodies[b].held) continue;
    memcpy(s->held + s->dof_first[b], s->bodies[b].held, (size_t)disc->n_dofs);
    for (LitheIndex row = 0; row < disc->n_rows; row++)
      for (LitheCount i = 3 * (LitheCount)disc->row_func[row];
           i < 3 * (LitheCount)disc->row_func[row + 1]; i++)
        s->row_held[s->row_first[b] + row] |= s->bodies[b].held[i];
  }
  return LITHE_OK;
}

/// Forces that are not linear in the position: warped bodies, loads and couplings that turn with them.
static bool find_nonlinear(const LthSystem *s) {
  bool found = s->warped;
  for (LitheIndex b = 0; b < s->n_bodies; b++)
    for (LitheIndex i = 0; i < s->bodies[b].n_loads; i++)
      found |= lth_load_follows(&s->bodies[b].loads[i]);
  for (LitheIndex c = 0; c < s->n_couplings; c++) found |= s->couplings[c].is_nonlinear;
  return found;
}

static LitheStatus prepare_forces(LitheCtx *ctx, LthSystem *s) {
  LTH_NEW(ctx, s->one, s->n / 3);
  LTH_NEW(ctx, s->f_fixed, s->n);
  for (LitheIndex b = 0; b < s->n_bodies; b++) {
    const LthDisc *disc = disc_of(s, b);
    disc->table->one(disc, s->one + s->dof_first[b] / 3);
    disc->table->add_gravity(disc, s->gravity, s->f_fixed + s->dof_first[b]);
  }
  double *rest;
  LTH_NEW(ctx, rest, s->n);
  lth_system_rest(s, rest);
  LitheStatus status = add_loads(ctx, s, true, 0, rest, s->f_fixed);
  lth_free(ctx, rest);
  return status;
}

/// Tell each contact where its bodies stand in vectors, and in the diagonal blocks of all rows.
static void place_contacts(const LthSystem *s, const LthSystemContact *contacts) {
  for (LitheIndex c = 0; c < s->n_contacts; c++)
    for (int side = 0; side < lth_contact_sides(contacts[c].contact); side++) {
      LitheCount block = 0;
      for (LitheIndex b = 0; b < contacts[c].body[side]; b++)
        for (LitheIndex r = 0; r < disc_of(s, b)->n_rows; r++) {
          LitheCount m = 3 * (disc_of(s, b)->row_func[r + 1] - disc_of(s, b)->row_func[r]);
          block += m * m;
        }
      LitheIndex b = contacts[c].body[side];
      lth_contact_place(s->contacts[c], side, s->row_first[b], s->dof_first[b], block);
    }
}

const LthDiscSolver *lth_system_solver(const LthSystem *s) {
  bool alone = s->n_bodies == 1 && s->n_couplings == 0;
  return alone && !s->warped ? disc_of(s, 0)->table->solver : NULL;
}

static LitheStatus copy_def(LitheCtx *ctx, const LthSystemDef *def, LthSystem *s) {
  s->n_bodies = def->n_bodies;
  s->n_couplings = def->n_couplings;
  s->n_contacts = def->n_contacts;
  LTH_NEW(ctx, s->bodies, def->n_bodies);
  LTH_NEW(ctx, s->couplings, def->n_couplings);
  LTH_NEW(ctx, s->contacts, def->n_contacts);
  LTH_NEW(ctx, s->part, def->n_bodies);
  for (LitheIndex b = 0; b < def->n_bodies; b++) s->bodies[b] = def->bodies[b];
  for (LitheIndex c = 0; c < def->n_couplings; c++) s->couplings[c] = def->couplings[c];
  for (LitheIndex c = 0; c < def->n_contacts; c++) s->contacts[c] = def->contacts[c].contact;
  memcpy(s->gravity, def->gravity, sizeof s->gravity);
  return LITHE_OK;
}

LitheStatus lth_system_create(LitheCtx *ctx, const LthSystemDef *def, LthSystem **system) {
  LitheStatus status = LITHE_OK;
  LthSystem *s = NULL;
  *system = NULL;
  LTH_NEW_OR(done, ctx, s, 1);
  LITHE_TRY_OR(done, copy_def(ctx, def, s));
  LITHE_TRY_OR(done, lay_out(ctx, s));
  place_contacts(s, def->contacts);
  LITHE_TRY_OR(done, gather_held(ctx, s));
  s->is_nonlinear = find_nonlinear(s);
  LITHE_TRY_OR(done, prepare_forces(ctx, s));
  *system = s;
  s = NULL;
done:
  lth_system_destroy(ctx, &s);
  return status;
}

void lth_system_destroy(LitheCtx *ctx, LthSystem **system) {
  LthSystem *s = *system;
  if (!s) return;
  lth_system_parts_free(ctx, s);
  void *blocks[] = {s->bodies, s->couplings, s->contacts, s->row_first, s->dof_first, s->row_body,
                    s->held,   s->row_held,  s->one,      s->f_fixed,   s->fade,      s->part,
                    s};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
  *system = NULL;
}

void lth_system_rest(const LthSystem *s, double *x0) {
  for (LitheIndex b = 0; b < s->n_bodies; b++)
    disc_of(s, b)->table->rest(disc_of(s, b), x0 + s->dof_first[b]);
}

void lth_system_update_rotations(LthSystem *s, const double *x) {
  for (LitheIndex b = 0; b < s->n_bodies; b++)
    disc_of(s, b)->table->update_rotations(s->bodies[b].disc, x ? x + s->dof_first[b] : NULL);
  for (LitheIndex c = 0; c < s->n_couplings; c++)
    if (s->couplings[c].update_rotations) s->couplings[c].update_rotations(s->couplings[c].self, x);
}

void lth_system_assemble_load(LthSystem *s, double t, double *f0) {
  for (LitheIndex b = 0; b < s->n_bodies; b++)
    disc_of(s, b)->table->assemble_load(s->bodies[b].disc, t, f0 + s->dof_first[b]);
  for (LitheIndex c = 0; c < s->n_couplings; c++)
    s->couplings[c].add_load(s->couplings[c].self, t, f0);
}

double lth_system_energy(LthSystem *s, double t, const double *x) {
  double sum = 0;
  for (LitheIndex b = 0; b < s->n_bodies; b++)
    sum += disc_of(s, b)->table->energy(s->bodies[b].disc, t, x + s->dof_first[b]);
  for (LitheIndex c = 0; c < s->n_couplings; c++)
    sum += s->couplings[c].energy(s->couplings[c].self, t, x);
  return sum;
}

void lth_system_apply_body_mass(const LthSystem *s, LitheIndex b, const double *v, double *y) {
  disc_of(s, b)->table->apply_mass(disc_of(s, b), v + s->dof_first[b], y + s->dof_first[b]);
}

void lth_system_apply_mass(const LthSystem *s, const double *v, double *y) {
  for (LitheIndex b = 0; b < s->n_bodies; b++) lth_system_apply_body_mass(s, b, v, y);
}

void lth_system_mass_diagonal(const LthSystem *s, double *mass) {
  for (LitheIndex b = 0; b < s->n_bodies; b++)
    disc_of(s, b)->table->mass_diagonal(disc_of(s, b), mass + s->dof_first[b]);
}

LitheStatus lth_system_prescribe(const LthSystem *s, double t, double *x) {
  for (LitheIndex b = 0; b < s->n_bodies; b++)
    if (s->bodies[b].held)
      LITHE_TRY(s->bodies[b].prescribe(s->bodies[b].prescribe_self, t, x + s->dof_first[b]));
  return LITHE_OK;
}

void lth_system_zero_held(const LthSystem *s, double *y) {
  for (LitheCount i = 0; s->has_held && i < s->n; i++)
    if (s->held[i]) y[i] = 0;
}
