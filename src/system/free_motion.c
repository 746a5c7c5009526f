/// Rigid motions that no constraint resists: the null space of K on the six of every connected part.
#include "system/free_motion.h"

#include "base/disjoint_sets.h"
#include "base/eigen.h"
#include "base/tensor.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define NOTHING 1e-16 // squared force of a unit motion over squared stiffness: rounding gives 1e-28
#define SAME 1e-3     // how exactly an axis must fit to be called x, y or z

/// One connected part of the bodies.
typedef struct Part {
  double center[3], size; // [m]
  double gram[36];        // sum over its unknowns of (K r_a)(K r_b) / stiffness^2
  double weight;          // of the points in `center`
  LitheIndex first;       // block row
  LitheCount rows;
} Part;

/// Rows and unknowns of all bodies.
typedef struct Rows {
  LitheIndex n;
  LitheCount *off;     // first unknown of a row                       (n + 1)
  LitheIndex *part_of; // (n)
} Rows;

/// Unite the rows of each connected part of a body that knows its parts; otherwise they couple through blocks.
static void unite_known(const LthSystem *s, LitheIndex b, LitheIndex *scratch, Rows *rows) {
  const LthDisc *disc = s->bodies[b].disc;
  LitheIndex first = s->row_first[b], n = disc->table->parts(disc, scratch);
  LitheIndex *root = scratch + disc->n_rows; // first row of each part
  for (LitheIndex k = 0; k < n; k++) root[k] = -1;
  for (LitheIndex row = 0; row < disc->n_rows; row++) {
    LitheIndex *r = root + scratch[row];
    if (*r < 0) *r = row;
    lth_sets_unite(rows->part_of, first + *r, first + row);
  }
}

static void unite_coupled(const LthSystem *s, const LthBlockMatrix *K, Rows *rows) {
  for (LitheIndex row = 0; row < rows->n; row++)
    for (LitheCount e = K->block_off[row]; e < K->block_off[row + 1]; e++) {
      LitheIndex col = K->block_col[e], b = s->row_body[row];
      if (b == s->row_body[col] && s->bodies[b].disc->table->parts) continue;
      lth_sets_unite(rows->part_of, row, col);
    }
}

/// Number parts as their roots, their lowest rows, come.
static LitheIndex number_parts(Rows *rows) {
  LitheIndex n = 0, *part_of = rows->part_of;
  for (LitheIndex c = 0; c < rows->n; c++) part_of[c] = lth_sets_root(part_of, c);
  for (LitheIndex c = 0; c < rows->n; c++)
    part_of[c] = part_of[c] == c ? -1 - n++ : part_of[part_of[c]];
  for (LitheIndex c = 0; c < rows->n; c++) part_of[c] = -1 - part_of[c];
  return n;
}

/// Find the connected parts; `K` NULL: the only body knows them.
static LitheStatus find_parts(LitheCtx *ctx, const LthSystem *s, const LthBlockMatrix *K,
                              Rows *rows, LitheIndex *n) {
  LitheIndex *scratch = NULL;
  LTH_NEW(ctx, scratch, 2 * (LitheCount)rows->n);
  lth_sets_reset(rows->part_of, rows->n);
  for (LitheIndex b = 0; b < s->n_bodies; b++)
    if (s->bodies[b].disc->table->parts) unite_known(s, b, scratch, rows);
  if (K) unite_coupled(s, K, rows);
  lth_free(ctx, scratch);
  *n = number_parts(rows);
  return LITHE_OK;
}

static LitheStatus lay_out_rows(LitheCtx *ctx, const LthSystem *s, Rows *rows) {
  rows->n = s->n_rows;
  LTH_NEW(ctx, rows->off, (LitheCount)s->n_rows + 1);
  LTH_NEW(ctx, rows->part_of, s->n_rows);
  for (LitheIndex b = 0; b < s->n_bodies; b++)
    for (LitheIndex r = 0; r < s->bodies[b].disc->n_rows; r++)
      rows->off[s->row_first[b] + r + 1] =
          s->dof_first[b] + 3 * (LitheCount)s->bodies[b].disc->row_func[r + 1];
  return LITHE_OK;
}

/// Place of function i less its share of the part's centre: what turns with the part.
static void arm(const LthSystem *s, const Part *p, const double *rest, LitheCount i, double x[3]) {
  for (int a = 0; a < 3; a++) x[a] = rest[3 * i + a] - s->one[i] * p->center[a];
}

static void measure_parts(const LthSystem *s, const Rows *rows, const double *rest, LitheIndex n,
                          Part *parts) {
  for (LitheIndex i = 0; i < n; i++) parts[i].first = -1;
  for (LitheIndex row = 0; row < rows->n; row++) {
    Part *p = &parts[rows->part_of[row]];
    if (p->first < 0) p->first = row;
    p->rows += rows->off[row + 1] - rows->off[row];
    for (LitheCount i = rows->off[row] / 3; i < rows->off[row + 1] / 3; i++) {
      lth_v3_axpy(s->one[i], rest + 3 * i, p->center);
      p->weight += s->one[i] * s->one[i];
    }
  }
  for (LitheIndex i = 0; i < n; i++) lth_v3_scale(1 / parts[i].weight, parts[i].center);
  for (LitheIndex row = 0; row < rows->n; row++) {
    Part *p = &parts[rows->part_of[row]];
    for (LitheCount i = rows->off[row] / 3; i < rows->off[row + 1] / 3; i++) {
      double x[3];
      arm(s, p, rest, i, x);
      p->size = fmax(p->size, lth_v3_norm(x));
    }
  }
}

/// Coefficients of motion 0-2 (translations) or 3-5 (rotations, of size one at the part's rim), from
/// those of the rest positions: both are linear in the place. Overwrites `arms`.
static void rigid_motion(const LthSystem *s, const Rows *rows, const Part *parts, int mode,
                         const double *rest, double *arms, double *r) {
  for (LitheIndex row = 0; row < rows->n; row++) {
    const Part *p = &parts[rows->part_of[row]];
    for (LitheCount i = rows->off[row] / 3; i < rows->off[row + 1] / 3; i++) {
      arm(s, p, rest, i, arms + 3 * i);
      lth_v3_scale(p->size > 0 ? 1 / p->size : 0, arms + 3 * i);
      for (int a = 0; a < 3; a++) r[3 * i + a] = a == mode ? s->one[i] : 0;
    }
  }
  for (LitheIndex b = 0; b < s->n_bodies && mode >= 3; b++)
    lth_disc_turn(s->bodies[b].disc, mode - 3, arms + s->dof_first[b], r + s->dof_first[b]);
}

/// What resists a motion at unknown i: the force on it, or where the unknown is held the motion itself.
static void resist(const LthSystem *s, LitheCount n, const double *motion, double *force,
                   double *stiffness) {
  for (LitheCount i = 0; s->has_held && i < n; i++) {
    if (s->held[i] != LTH_HELD) continue;
    force[i] = motion[i];
    stiffness[i] = 1;
  }
}

/// Sum of |K_ij| over a row: what K could do to a motion of size one.
static void row_stiffness(const LthBlockMatrix *K, double *sum) {
  for (LitheIndex row = 0; row < K->n_rows; row++)
    for (LitheCount e = K->block_off[row]; e < K->block_off[row + 1]; e++) {
      LitheIndex col = K->block_col[e];
      LitheCount m = K->row_off[row + 1] - K->row_off[row],
                 n = K->row_off[col + 1] - K->row_off[col];
      for (LitheCount k = 0; k < m * n; k++)
        sum[K->row_off[row] + k / n] += fabs(K->values[K->value_off[e] + k]);
    }
}

static void add_gram(const Rows *rows, const double *stiffness, double *const force[6],
                     Part *parts) {
  for (LitheIndex c = 0; c < rows->n; c++) {
    double *gram = parts[rows->part_of[c]].gram;
    for (LitheCount i = rows->off[c]; i < rows->off[c + 1]; i++)
      for (int a = 0; a < 6 && stiffness[i] > 0; a++)
        for (int b = 0; b < 6; b++)
          gram[6 * a + b] += force[a][i] / stiffness[i] * (force[b][i] / stiffness[i]);
  }
}

static void append(char text[LTH_FREE_MOTION_TEXT], const char *more) {
  size_t length = strlen(text);
  snprintf(text + length, LTH_FREE_MOTION_TEXT - length, "%s%s", length ? ", " : "", more);
}

/// "x", "y", "z" or "(a, b, c)".
static void name_axis(const double axis[3], char name[64]) {
  for (int a = 0; a < 3; a++)
    if (fabs(axis[a]) > 1 - SAME * SAME) {
      snprintf(name, 64, "%c", 'x' + a);
      return;
    }
  snprintf(name, 64, "(%.3g, %.3g, %.3g)", axis[0], axis[1], axis[2]);
}

/// Motion q = (translation, rotation) of a part in words.
static void describe(const Part *p, const double q[6], char text[LTH_FREE_MOTION_TEXT]) {
  double axis[3], shift[3];
  char name[64], words[192];
  lth_v3_copy(q + 3, axis);
  double turn = lth_v3_normalize(axis);
  if (turn < SAME) {
    lth_v3_copy(q, axis);
    lth_v3_normalize(axis);
    name_axis(axis, name);
    snprintf(words, sizeof words, "translation along %s", name);
  } else {
    // velocity t + w x (x - c), w = turn axis / size, vanishes across the axis at c + w x t / |w|^2
    name_axis(axis, name);
    lth_v3_cross(axis, q, shift);
    lth_v3_scale(p->size / turn, shift);
    lth_v3_add(shift, p->center, shift);
    snprintf(words, sizeof words, "rotation about %s through (%.4g, %.4g, %.4g)", name, shift[0],
             shift[1], shift[2]);
  }
  append(text, words);
}

/// Take direction q out of the projector N onto the null space (N := N - N q q^T N / q^T N q).
static void take_out(double N[36], const double q[6]) {
  double Nq[6] = {0}, along = 0;
  for (int i = 0; i < 6; i++)
    for (int j = 0; j < 6; j++) Nq[i] += N[6 * i + j] * q[j];
  for (int i = 0; i < 6; i++) along += q[i] * Nq[i];
  for (int i = 0; i < 36; i++) N[i] -= Nq[i / 6] * Nq[i % 6] / along;
}

/// Number of free motions of a part, named: first translations, then pure rotations about the axes
/// through the centre, then whatever is left.
static int name_free_motions(const Part *p, char text[LTH_FREE_MOTION_TEXT]) {
  double A[36], value[6], V[36], N[36] = {0};
  int count = 0;
  memcpy(A, p->gram, sizeof A);
  lth_symmetric_eigen(6, A, value, V);
  for (int k = 0; k < 6; k++) {
    if (value[k] > NOTHING * (double)p->rows) continue;
    count++;
    for (int i = 0; i < 36; i++) N[i] += V[6 * (i / 6) + k] * V[6 * (i % 6) + k];
  }
  int named = 0;
  for (int k = 0; k < 6; k++) {
    double q[6] = {0};
    q[k] = 1;
    if (N[7 * k] < 1 - SAME * SAME) continue;
    describe(p, q, text);
    take_out(N, q);
    named++;
  }
  for (; named < count; named++) {
    int column = 0;
    for (int k = 1; k < 6; k++)
      if (N[7 * k] > N[7 * column]) column = k;
    double q[6], norm = sqrt(N[7 * column]);
    for (int i = 0; i < 6; i++) q[i] = N[6 * i + column] / norm;
    describe(p, q, text);
    take_out(N, q);
  }
  return count;
}

static void summarize(const LthSystem *s, const Rows *rows, const double *rest, Part *parts,
                      LitheIndex n, LthFreeMotions *result) {
  *result = (LthFreeMotions){.n_components = n, .body = -1};
  for (LitheIndex i = 0; i < n; i++) {
    char text[LTH_FREE_MOTION_TEXT] = "";
    int count = name_free_motions(&parts[i], text);
    if (count == 0 || result->n_free++ > 0) continue;
    result->body = s->row_body[parts[i].first];
    lth_v3_copy(rest + rows->off[parts[i].first], result->at);
    result->count = count;
    memcpy(result->text, text, sizeof text);
  }
}

/// A motion that no unknown can make, as out of a plane, is not free.
static void bar_missing(const LthSystem *s, const Rows *rows, int mode, const double *motion,
                        double *most, LitheIndex n, Part *parts) {
  memset(most, 0, sizeof *most * (size_t)n);
  for (LitheIndex row = 0; row < rows->n; row++)
    for (LitheCount i = rows->off[row]; i < rows->off[row + 1]; i++)
      if (!s->has_held || s->held[i] != LTH_ABSENT)
        most[rows->part_of[row]] = fmax(most[rows->part_of[row]], fabs(motion[i]));
  for (LitheIndex k = 0; k < n; k++)
    if (most[k] == 0) parts[k].gram[7 * mode] += 1;
}

/// K as a matrix, or as what the only body does without one; and a bound of what it could do to a motion of size one.
typedef struct Stiffness {
  LthBlockMatrix *K;
  const LthDiscSolver *own;
} Stiffness;

static LitheStatus make_stiffness(LitheCtx *ctx, LthSystem *s, double *f0, double *size,
                                  Stiffness *k) {
  const LthDisc *disc = s->bodies[0].disc;
  k->own = lth_system_solver(s);
  lth_system_update_rotations(s, NULL);
  if (k->own && disc->table->parts) {
    k->own->diagonal(disc, 0, 1, size);
    return LITHE_OK;
  }
  k->own = NULL;
  LITHE_TRY(lth_system_matrix_create(ctx, s, &k->K));
  lth_system_assemble(s, 0, k->K, f0);
  row_stiffness(k->K, size);
  return LITHE_OK;
}

static void apply_stiffness(const LitheCtx *ctx, const LthSystem *s, const Stiffness *k,
                            const double *x, double *y) {
  if (k->own)
    k->own->apply(s->bodies[0].disc, lth_threads(ctx), 0, 1, x, y);
  else
    lth_block_matrix_apply(k->K, lth_threads(ctx), x, y);
}

LitheStatus lth_free_motions(LitheCtx *ctx, LthSystem *s, LthFreeMotions *result) {
  LitheStatus status = LITHE_OK;
  Stiffness k = {0};
  Rows rows = {0};
  Part *parts = NULL;
  LitheIndex n;
  double *rest = NULL, *motion = NULL, *arms = NULL, *stiffness = NULL, *most = NULL,
         *force[6] = {0};
  LITHE_TRY_OR(done, lay_out_rows(ctx, s, &rows));
  LTH_NEW_OR(done, ctx, rest, s->n);
  LTH_NEW_OR(done, ctx, motion, s->n);
  LTH_NEW_OR(done, ctx, arms, s->n);
  LTH_NEW_OR(done, ctx, stiffness, s->n);
  for (int a = 0; a < 6; a++) LTH_NEW_OR(done, ctx, force[a], s->n);
  LITHE_TRY_OR(done, make_stiffness(ctx, s, motion, stiffness, &k));
  LITHE_TRY_OR(done, find_parts(ctx, s, k.K, &rows, &n));
  LTH_NEW_OR(done, ctx, parts, n);
  LTH_NEW_OR(done, ctx, most, n);
  lth_system_rest(s, rest);
  measure_parts(s, &rows, rest, n, parts);
  for (int a = 0; a < 6; a++) {
    rigid_motion(s, &rows, parts, a, rest, arms, motion);
    apply_stiffness(ctx, s, &k, motion, force[a]);
    resist(s, s->n, motion, force[a], stiffness);
    bar_missing(s, &rows, a, motion, most, n, parts);
  }
  add_gram(&rows, stiffness, force, parts);
  summarize(s, &rows, rest, parts, n, result);
done:
  lth_block_matrix_destroy(ctx, &k.K);
  lth_free(ctx, rows.off);
  lth_free(ctx, rows.part_of);
  lth_free(ctx, parts);
  lth_free(ctx, rest);
  lth_free(ctx, motion);
  lth_free(ctx, arms);
  lth_free(ctx, stiffness);
  lth_free(ctx, most);
  for (int a = 0; a < 6; a++) lth_free(ctx, force[a]);
  return status;
}
