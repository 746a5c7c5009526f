/// Momentum of free bodies is known before a step is solved.
#include "base/tensor.h"
#include "step/simulation_priv.h"

#include <math.h>
#include <string.h>

/// T^T A T for the three translations T of some rows; `size` is the sum of the absolute terms.
static void translation_matrix(const LthSimulation *s, LitheIndex first, LitheIndex last,
                               double E[9], double *size) {
  const LthBlockMatrix *A = s->A;
  memset(E, 0, 9 * sizeof *E);
  *size = 0;
  for (LitheIndex row = first; row < last; row++)
    for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++) {
      const double *B = A->values + A->value_off[e];
      LitheCount r = A->row_off[row], c = A->row_off[A->block_col[e]];
      LitheCount m = A->row_off[row + 1] - r, n = A->row_off[A->block_col[e] + 1] - c;
      for (LitheCount i = 0; i < m * n; i++) {
        LitheCount p = r + i / n, q = c + i % n;
        double value = s->system->one[p / 3] * s->system->one[q / 3] * B[i];
        E[3 * (p % 3) + q % 3] += value;
        *size += fabs(value);
      }
    }
}

/// Bodies [first, last) that move together, and what of their momentum a step leaves out.
typedef struct Group {
  LitheIndex first, last;
  double inertia; // of the system matrix under a translation: sum of cm mass
  double missing[3];
} Group;

/// True where nothing but inertia resists translations, so that momentum is kept. Found once: which
/// constraints there are does not change.
static bool is_free(LthSimulation *s, const Group *g) {
  const LitheIndex *rows = s->system->row_first;
  if (s->freedom[g->first] == 0) {
    double E[9], size, rest = 0;
    translation_matrix(s, rows[g->first], rows[g->last], E, &size);
    for (int k = 0; k < 9; k++) rest = fmax(rest, fabs(E[k] - (k % 4 == 0 ? g->inertia : 0)));
    s->freedom[g->first] = rest <= 1e-11 * size ? 1 : -1;
  }
  return s->freedom[g->first] > 0;
}

/// Momentum that (1 + H a) P1 = P^ + H F asks for and the solution has not. `change` is M v^ + H F less the
/// inertia of the solution, per unknown.
static void add_missing(const LthSimulation *s, const double *change, Group *g) {
  const LthSystem *system = s->system;
  for (LitheIndex b = g->first; b < g->last; b++)
    for (LitheCount i = system->dof_first[b] / 3; i < system->dof_first[b + 1] / 3; i++) {
      if (system->one[i] == 0) continue;
      lth_v3_axpy(system->one[i], change + 3 * i, g->missing);
      g->inertia += s->cm[b] * system->one[i] * s->row_mass[i];
    }
}

void lth_stage_balance(LthSimulation *s) {
  const LthSystem *system = s->system;
  const LthStage *g = &s->stage;
  if (system->has_held || s->contact_on) return;
  double *change = s->scratch, *inertia = s->rhs;
  lth_system_apply_mass(system, s->solution, inertia);
  for (LitheIndex b = 0; b < system->n_bodies; b++)
    for (LitheCount i = system->dof_first[b]; i < system->dof_first[b + 1]; i++)
      change[i] = g->p[i] + g->H * s->f_ext[i] - s->cm[b] * inertia[i];
  bool coupled = system->n_couplings > 0;
  for (LitheIndex b = 0; b < system->n_bodies; b = coupled ? system->n_bodies : b + 1) {
    Group group = {.first = b, .last = coupled ? system->n_bodies : b + 1};
    add_missing(s, change, &group);
    if (!is_free(s, &group)) continue;
    for (LitheCount i = system->dof_first[group.first] / 3; i < system->dof_first[group.last] / 3;
         i++)
      lth_v3_axpy(system->one[i] / group.inertia, group.missing, s->solution + 3 * i);
  }
}
