/// The vectors of a simulation: which uses need which, and which share a place.
#include "step/simulation_priv.h"

#include <stddef.h>

/// What a simulation has or does that takes vectors.
typedef enum Trait {
  ALWAYS = 1,
  MATRIX = 2,  ///< some body is solved with one
  STEPS = 4,   ///< it goes on in time
  TOUCHES = 8, ///< contact
  AIMS = 16    ///< a solver of its own that wants to know where positions start from
} Trait;

#define RICH                                                                                       \
  (MATRIX | STEPS | TOUCHES) // what does more than to look for equilibria of one linear body

typedef struct Vector {
  size_t place; // in LthSimulation
  int needs;    // any of these traits
  size_t twin;  // where else it stands without them; 0: nowhere
} Vector;

#define AT(name) offsetof(LthSimulation, name)

// An equilibrium of a linear body without a matrix takes a residual, solves for a correction and adds it. There the residual
// (force) is the right-hand side without contact (base), and the right-hand side of the solver is of no use once it is solved:
// displacements are computed there. The rest position is computed where it is needed.
static const Vector table[] = {
    {AT(x), ALWAYS, 0},        {AT(f_ext), ALWAYS, 0},           {AT(force), ALWAYS, 0},
    {AT(rhs), ALWAYS, 0},      {AT(solution), ALWAYS, 0},        {AT(scratch), ALWAYS, 0},
    {AT(driven), ALWAYS, 0},   {AT(x_rest), RICH | AIMS, 0},     {AT(v), RICH, 0},
    {AT(u), RICH, AT(rhs)},    {AT(base), RICH, AT(force)},      {AT(f0), MATRIX | STEPS, 0},
    {AT(mass), RICH, 0},       {AT(row_mass), MATRIX, AT(mass)}, // that of a grid is diagonal
    {AT(factor_x), MATRIX, 0},
};

#define N_VECTORS (sizeof table / sizeof table[0])

static double **vector_at(LthSimulation *s, size_t place) { return (double **)((char *)s + place); }

static int traits_of(const LthSimulation *s) {
  return ALWAYS | (s->own ? 0 : MATRIX) | (s->options.use == LTH_USE_STEPS ? STEPS : 0) |
         (s->has_contact ? TOUCHES : 0) | (s->own && s->own->aim ? AIMS : 0);
}

LitheStatus lth_step_vectors_create(LitheCtx *ctx, LthSimulation *s) {
  const int traits = traits_of(s);
  for (size_t i = 0; i < N_VECTORS; i++) {
    const Vector *v = &table[i];
    if (traits & v->needs)
      LTH_NEW(ctx, *vector_at(s, v->place), s->n);
    else if (v->twin)
      *vector_at(s, v->place) = *vector_at(s, v->twin);
  }
  for (LitheCount i = 0; s->system->has_held && i < s->n; i++) s->n_held += s->system->held[i] != 0;
  LTH_NEW(ctx, s->held_force, s->n_held);
  return LITHE_OK;
}

void lth_step_vectors_free(LitheCtx *ctx, LthSimulation *s) {
  for (size_t i = 0; i < N_VECTORS; i++) {
    const Vector *v = &table[i];
    double **at = vector_at(s, v->place);
    if (!v->twin || *at != *vector_at(s, v->twin)) lth_free(ctx, *at);
  }
  lth_free(ctx, s->held_force);
}
