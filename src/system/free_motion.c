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

/// Number of connected parts; part_of[row] is the part of a block row. Rows couple through blocks.
static LitheIndex find_parts(const LthBlockMatrix *K, LitheIndex *part_of) {
  lth_sets_reset(part_of, K->n_rows);
  for (LitheIndex row = 0; row < K->n_rows; row++)
    for (LitheCount e = K->block_off[row]; e < K->block_off[row + 1]; e++)
      lth_sets_unite(part_of, row, K->block_col[e]);
  // the root of a part is its lowest row: number parts as their roots come
  LitheIndex n = 0;
  for (LitheIndex c = 0; c < K->n_rows; c++) part_of[c] = lth_sets_root(part_of, c);
  for (LitheIndex c = 0; c < K->n_rows; c++)
    part_of[c] = part_of[c] == c ? -1 - n++ : part_of[part_of[c]];
  for (LitheIndex c = 0; c < K->n_rows; c++) part_of[c] = -1 - part_of[c];
  return n;
}

/// Place of function i less its share of the part's centre: what turns with the part.
static void arm(const LthSystem *s, const Part *p, const double *rest, LitheCount i, double x[3]) {
  for (int a = 0; a < 3; a++) x[a] = rest[3 * i + a] - s->one[i] * p->center[a];
}

static void measure_parts(const LthSystem *s, const LthBlockMatrix *K, const LitheIndex *part_of,
                          const double *rest, LitheIndex n, Part *parts) {
  for (LitheIndex i = 0; i < n; i++) parts[i].first = -1;
  for (LitheIndex row = 0; row < K->n_rows; row++) {
    Part *p = &parts[part_of[row]];
    if (p->first < 0) p->first = row;
    p->rows += K->row_off[row + 1] - K->row_off[row];
    for (LitheCount i = K->row_off[row] / 3; i < K->row_off[row + 1] / 3; i++) {
      lth_v3_axpy(s->one[i], rest + 3 * i, p->center);
      p->weight += s->one[i] * s->one[i];
    }
  }
  for (LitheIndex i = 0; i < n; i++) lth_v3_scale(1 / parts[i].weight, parts[i].center);
  for (LitheIndex row = 0; row < K->n_rows; row++) {
    Part *p = &parts[part_of[row]];
    for (LitheCount i = K->row_off[row] / 3; i < K->row_off[row + 1] / 3; i++) {
      double x[3];
      arm(s, p, rest, i, x);
      p->size = fmax(p->size, lth_v3_norm(x));
    }
  }
}

/// Coefficients of motion 0-2 (translations) or 3-5 (rotations, of size one at the part's rim), from
/// those of the rest positions: both are linear in the place.
static void rigid_motion(const LthSystem *s, const LthBlockMatrix *K, const LitheIndex *part_of,
                         const Part *parts, int mode, const double *rest, double *r) {
  for (LitheIndex row = 0; row < K->n_rows; row++) {
    const Part *p = &parts[part_of[row]];
    for (LitheCount i = K->row_off[row] / 3; i < K->row_off[row + 1] / 3; i++) {
      double x[3], *v = r + 3 * i;
      arm(s, p, rest, i, x);
      memset(v, 0, 3 * sizeof *v);
      if (mode < 3) {
        v[mode] = s->one[i];
      } else {
        int b = (mode - 3 + 1) % 3, d = (mode - 3 + 2) % 3;
        v[b] = -x[d] / p->size;
        v[d] = x[b] / p->size;
      }
    }
  }
}

/// What resists a motion at unknown i: the force on it, or where the unknown is held the motion itself.
static void resist(const LthSystem *s, LitheCount n, const double *motion, double *force,
                   double *stiffness) {
  for (LitheCount i = 0; s->has_held && i < n; i++) {
    if (!s->held[i]) continue;
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

static void add_gram(const LthBlockMatrix *K, const LitheIndex *part_of, const double *stiffness,
                     double *const force[6], Part *parts) {
  for (LitheIndex c = 0; c < K->n_rows; c++) {
    double *gram = parts[part_of[c]].gram;
    for (LitheCount i = K->row_off[c]; i < K->row_off[c + 1]; i++)
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

static void summarize(const LthSystem *s, const LthBlockMatrix *K, const double *rest, Part *parts,
                      LitheIndex n, LthFreeMotions *result) {
  *result = (LthFreeMotions){.n_components = n, .body = -1};
  for (LitheIndex i = 0; i < n; i++) {
    char text[LTH_FREE_MOTION_TEXT] = "";
    int count = name_free_motions(&parts[i], text);
    if (count == 0 || result->n_free++ > 0) continue;
    result->body = s->row_body[parts[i].first];
    lth_v3_copy(rest + K->row_off[parts[i].first], result->at);
    result->count = count;
    memcpy(result->text, text, sizeof text);
  }
}

LitheStatus lth_free_motions(LitheCtx *ctx, LthSystem *s, LthFreeMotions *result) {
  LitheStatus status = LITHE_OK;
  LthBlockMatrix *K = NULL;
  LitheIndex *part_of = NULL;
  Part *parts = NULL;
  double *rest = NULL, *motion = NULL, *stiffness = NULL, *force[6] = {0};
  LITHE_TRY_OR(done, lth_system_matrix_create(ctx, s, &K));
  LTH_NEW_OR(done, ctx, part_of, K->n_rows);
  LTH_NEW_OR(done, ctx, rest, s->n);
  LTH_NEW_OR(done, ctx, motion, s->n);
  LTH_NEW_OR(done, ctx, stiffness, s->n);
  for (int a = 0; a < 6; a++) LTH_NEW_OR(done, ctx, force[a], s->n);
  LitheIndex n = find_parts(K, part_of);
  LTH_NEW_OR(done, ctx, parts, n);
  lth_system_rest(s, rest);
  measure_parts(s, K, part_of, rest, n, parts);

  lth_system_update_rotations(s, NULL);
  lth_system_assemble(s, 0, K, motion);
  row_stiffness(K, stiffness);
  for (int a = 0; a < 6; a++) {
    rigid_motion(s, K, part_of, parts, a, rest, motion);
    lth_block_matrix_apply(K, lth_threads(ctx), motion, force[a]);
    resist(s, s->n, motion, force[a], stiffness);
  }
  add_gram(K, part_of, stiffness, force, parts);
  summarize(s, K, rest, parts, n, result);
done:
  lth_block_matrix_destroy(ctx, &K);
  lth_free(ctx, part_of);
  lth_free(ctx, parts);
  lth_free(ctx, rest);
  lth_free(ctx, motion);
  lth_free(ctx, stiffness);
  for (int a = 0; a < 6; a++) lth_free(ctx, force[a]);
  return status;
}
