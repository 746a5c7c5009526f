/// Weak constraints: the pieces of each are gathered by cell, projector and plane; what they prescribe
/// enters through its moments with the traces only, which loses nothing of Nitsche's data terms.
#include "disc/dg/dg_store_priv.h"

#include <stdlib.h>

/// A piece of a constraint, to be sorted by cell.
typedef struct Piece {
  LitheIndex cell, constraint, patch;
} Piece;

static int compare_pieces(const void *pa, const void *pb) {
  const Piece *a = pa, *b = pb;
  if (a->cell != b->cell) return a->cell < b->cell ? -1 : 1;
  if (a->constraint != b->constraint) return a->constraint < b->constraint ? -1 : 1;
  return a->patch < b->patch ? -1 : a->patch > b->patch;
}

static const double *piece_normal(const LthDgOperator *op, const Piece *piece) {
  LitheIndex face = op->weak[piece->constraint].patches->face[piece->patch];
  return op->space->mesh->face_normal + 3 * (LitheCount)face;
}

/// Parallel to rounding: planes of one surface that differ by more keep their own group.
static bool same_normal(const double a[3], const double b[3]) {
  return lth_v3_distance(a, b) < 1e-12;
}

static bool is_varying(const LthWeakConstraint *weak) {
  int n = weak->normal_only ? 1 : 3;
  for (int a = 0; a < n; a++)
    if ((weak->normal_only || weak->fixed[a]) && weak->value[a].eval) return true;
  return false;
}

static void set_projector(const LthWeakConstraint *weak, const double n[3], LthDgHold *hold) {
  memset(hold->P, 0, sizeof hold->P);
  hold->roller = weak->normal_only;
  hold->varying = is_varying(weak);
  hold->whole = !weak->normal_only && weak->fixed[0] && weak->fixed[1] && weak->fixed[2];
  for (int a = 0; a < 3; a++) {
    if (!weak->normal_only) hold->P[4 * a] = weak->fixed[a];
    for (int b = 0; weak->normal_only && b < 3; b++) hold->P[3 * a + b] = n[a] * n[b];
  }
}

/// The hold among those of the cell that piece belongs to, or -1.
static LitheIndex find_hold(const LthDgOperator *op, LitheIndex first, const Piece *piece) {
  for (LitheIndex h = first; h < op->n_holds; h++) {
    const LthDgHold *hold = &op->holds[h];
    if (hold->constraint != piece->constraint) continue;
    if (!op->weak[piece->constraint].normal_only ||
        same_normal(op->groups[hold->first_group].normal, piece_normal(op, piece)))
      return h;
  }
  return -1;
}

/// The group of a hold with the piece's plane direction, or -1.
static LitheIndex find_group(const LthDgOperator *op, const LthDgHold *hold, const Piece *piece) {
  for (LitheIndex g = 0; g < hold->n_groups; g++)
    if (same_normal(op->groups[hold->first_group + g].normal, piece_normal(op, piece)))
      return hold->first_group + g;
  return -1;
}

/// Put the pieces, sorted by cell and constraint, into holds and groups; group_of[piece] says where.
/// A roller has a hold for every plane; its pieces may come in any order, but with one group each that
/// needs no moving.
static void make_groups(LthDgOperator *op, LitheIndex n, const Piece *pieces,
                        LitheIndex *group_of) {
  LitheIndex first_hold = 0;
  for (LitheIndex i = 0; i < n; i++) {
    const Piece *piece = &pieces[i];
    if (i == 0 || pieces[i - 1].cell != piece->cell) first_hold = op->n_holds;
    LitheIndex h = find_hold(op, first_hold, piece);
    if (h < 0) {
      h = op->n_holds++;
      LthDgHold *made = &op->holds[h];
      *made = (LthDgHold){
          .cell = piece->cell, .constraint = piece->constraint, .first_group = op->n_groups};
      set_projector(&op->weak[piece->constraint], piece_normal(op, piece), made);
    }
    LthDgHold *hold = &op->holds[h];
    LitheIndex g = find_group(op, hold, piece);
    if (g < 0) {
      g = op->n_groups++;
      hold->n_groups++;
      lth_v3_copy(piece_normal(op, piece), op->groups[g].normal);
    }
    group_of[i] = g;
  }
}

/// Give every hold and group its place in the tables.
static LitheStatus place_tables(LitheCtx *ctx, LthDgOperator *op) {
  LitheCount hold_doubles = 0, group_doubles = 0;
  for (LitheIndex h = 0; h < op->n_holds; h++) {
    LthDgHold *hold = &op->holds[h];
    LitheCount nb = lth_dg_funcs(op->space, hold->cell);
    op->hold_off[hold->cell + 1]++;
    hold->table = hold_doubles;
    if (!hold->roller) hold_doubles += 18 * nb * nb;
    for (LitheIndex g = 0; g < hold->n_groups; g++) {
      op->groups[hold->first_group + g].table = group_doubles;
      group_doubles += nb * nb + 3 * nb;
    }
  }
  for (LitheIndex c = 0; c < op->space->n_cells; c++) op->hold_off[c + 1] += op->hold_off[c];
  LTH_NEW(ctx, op->hold_data, hold_doubles);
  LTH_NEW(ctx, op->group_data, group_doubles);
  return LITHE_OK;
}

/// Traces of varying data: points, weights and function values of the pieces of a group, in sequence.
static LitheStatus add_points(LitheCtx *ctx, LthDgOperator *op, const Piece *piece,
                              const LthFaceView *view, LitheCount *used, LitheCount *cap,
                              LthDgGroup *group) {
  LitheStatus status = LITHE_OK;
  LitheIndex n = 0;
  double *points = NULL, *weights = NULL;
  int nb = lth_dg_funcs(op->space, piece->cell), degree = 2 * op->space->degree[piece->cell] + 2;
  LITHE_TRY_OR(done, lth_patch_quadrature(ctx, view, degree, &n, &points, &weights));
  LTH_RESERVE_OR(done, ctx, op->point_data, *cap, *used + (LitheCount)n * (4 + nb));
  if (group->n_points == 0) group->first_point = *used;
  for (LitheIndex q = 0; q < n; q++) {
    double *row = op->point_data + *used;
    lth_v3_copy(points + 3 * q, row);
    row[3] = weights[q];
    lth_dg_eval(op->space, piece->cell, row, row + 4);
    *used += 4 + nb;
  }
  group->n_points += n;
done:
  lth_free(ctx, points);
  lth_free(ctx, weights);
  return status;
}

/// Areas and centroids of the groups.
static void measure_groups(LthDgOperator *op, LitheIndex n, const Piece *pieces,
                           const LitheIndex *order, const LitheIndex *group_of, double *centroid) {
  for (LitheIndex k = 0; k < n; k++) {
    const Piece *piece = &pieces[order[k]];
    LitheIndex g = group_of[order[k]];
    const LthPatches *patches = op->weak[piece->constraint].patches;
    op->groups[g].area += patches->area[piece->patch];
    lth_v3_axpy(patches->area[piece->patch], patches->centroid + 3 * (LitheCount)piece->patch,
                centroid + 3 * (LitheCount)g);
  }
  for (LitheIndex g = 0; g < op->n_groups; g++)
    lth_v3_scale(1 / op->groups[g].area, centroid + 3 * (LitheCount)g);
}

/// Masses of the groups that are not known; points where the data vary. Points of a group must lie
/// together, hence group by group.
static LitheStatus integrate_groups(LitheCtx *ctx, LthDgOperator *op, LitheIndex n,
                                    const Piece *pieces, const LitheIndex *order,
                                    const LitheIndex *group_of, const uint8_t *is_known) {
  LitheCount used = 0, cap = 0;
  for (LitheIndex k = 0; k < n; k++) {
    const Piece *piece = &pieces[order[k]];
    LitheIndex g = group_of[order[k]];
    LthDgGroup *group = &op->groups[g];
    const LthWeakConstraint *weak = &op->weak[piece->constraint];
    LthFaceView view = lth_patches_view(op->space->mesh, weak->patches, piece->patch);
    const double *at = weak->patches->centroid + 3 * (LitheCount)piece->patch;
    if (!is_known[g])
      lth_dg_add_face_mass(op->space, piece->cell, &view, at, op->group_data + group->table);
    if (is_varying(weak)) LITHE_TRY(add_points(ctx, op, piece, &view, &used, &cap, group));
  }
  return LITHE_OK;
}

/// Penalties, and the rest positions' moments  rest_i = sum_j mass_ij X0_j.
static void finish_groups(LthDgOperator *op, const double *centroid, const uint8_t *is_known) {
  for (LitheIndex h = 0; h < op->n_holds; h++) {
    const LthDgHold *hold = &op->holds[h];
    int nb = lth_dg_funcs(op->space, hold->cell);
    const double *X0 = op->rest + 3 * (LitheCount)op->space->func_off[hold->cell];
    double area = 0;
    for (LitheIndex g = 0; g < hold->n_groups; g++) area += op->groups[hold->first_group + g].area;
    for (LitheIndex g = hold->first_group; g < hold->first_group + hold->n_groups; g++) {
      if (is_known[g]) continue;
      lth_dg_boundary_penalty(op, hold->cell, centroid + 3 * (LitheCount)g, area, &op->groups[g]);
      double *mass = op->group_data + op->groups[g].table, *rest = mass + nb * nb;
      for (int i = 0; i < nb; i++)
        for (int j = 0; j < nb; j++) lth_v3_axpy(mass[i * nb + j], X0 + 3 * j, rest + 3 * i);
    }
  }
}

/// All pieces of all constraints, sorted by cell.
static LitheIndex list_pieces(const LthDgOperator *op, Piece *pieces) {
  LitheIndex n = 0;
  for (LitheIndex w = 0; w < op->n_weak; w++)
    for (LitheIndex p = 0; p < op->weak[w].patches->n; p++) {
      LitheIndex face = op->weak[w].patches->face[p];
      if (!(op->weak[w].patches->area[p] > 0)) continue;
      pieces[n++] = (Piece){op->space->mesh->face_cell[2 * face], w, p};
    }
  qsort(pieces, (size_t)n, sizeof *pieces, compare_pieces);
  return n;
}

/// order = pieces by group (counting sort).
static LitheStatus order_by_group(LitheCtx *ctx, LitheIndex n, LitheIndex n_groups,
                                  const LitheIndex *group_of, LitheIndex *order) {
  LitheIndex *next = NULL;
  LTH_NEW(ctx, next, n_groups + 1);
  for (LitheIndex i = 0; i < n; i++) next[group_of[i] + 1]++;
  for (LitheIndex g = 0; g < n_groups; g++) next[g + 1] += next[g];
  for (LitheIndex i = 0; i < n; i++) order[next[group_of[i]]++] = i;
  lth_free(ctx, next);
  return LITHE_OK;
}

LitheStatus lth_dg_build_holds(LitheCtx *ctx, const LthDgRecords *records, LthDgOperator *op) {
  LitheStatus status = LITHE_OK;
  Piece *pieces = NULL;
  LitheIndex *group_of = NULL, *order = NULL, n = 0;
  double *centroid = NULL;
  uint8_t *is_known = NULL;
  for (LitheIndex w = 0; w < op->n_weak; w++) n += op->weak[w].patches->n;
  LTH_NEW_OR(done, ctx, op->hold_off, op->space->n_cells + 1);
  LTH_NEW_OR(done, ctx, pieces, n);
  LTH_NEW_OR(done, ctx, group_of, n);
  LTH_NEW_OR(done, ctx, order, n);
  LTH_NEW_OR(done, ctx, op->holds, n);
  LTH_NEW_OR(done, ctx, op->groups, n);
  n = list_pieces(op, pieces);
  make_groups(op, n, pieces, group_of);
  LITHE_TRY_OR(done, place_tables(ctx, op));
  LTH_NEW_OR(done, ctx, centroid, 3 * (LitheCount)op->n_groups);
  LITHE_TRY_OR(done, order_by_group(ctx, n, op->n_groups, group_of, order));
  LTH_NEW_OR(done, ctx, is_known, op->n_groups);
  measure_groups(op, n, pieces, order, group_of, centroid);
  if (records) lth_dg_store_lend_groups(records, op, is_known);
  LITHE_TRY_OR(done, integrate_groups(ctx, op, n, pieces, order, group_of, is_known));
  finish_groups(op, centroid, is_known);
  if (records) LITHE_TRY_OR(done, lth_dg_store_keep_groups(ctx, records, op, is_known));
done:
  lth_free(ctx, pieces);
  lth_free(ctx, group_of);
  lth_free(ctx, order);
  lth_free(ctx, centroid);
  lth_free(ctx, is_known);
  return status;
}

void lth_dg_free_holds(LitheCtx *ctx, LthDgOperator *op) {
  lth_free(ctx, op->hold_off);
  lth_free(ctx, op->holds);
  lth_free(ctx, op->groups);
  lth_free(ctx, op->hold_data);
  lth_free(ctx, op->group_data);
  lth_free(ctx, op->point_data);
}

/// The prescribed vector at a point: free components 0, a roller's along its normal.
static void prescribed(const LthWeakConstraint *weak, const double n[3], const double x[3],
                       double t, double d[3]) {
  if (weak->normal_only) {
    double value = lth_value_at(&weak->value[0], x, t);
    for (int a = 0; a < 3; a++) d[a] = value * n[a];
    return;
  }
  for (int a = 0; a < 3; a++) d[a] = weak->fixed[a] ? lth_value_at(&weak->value[a], x, t) : 0;
}

/// Data that vary: by the stored points. `shift` times x is added to the value.
static void varying_data(const LthDgOperator *op, const LthWeakConstraint *weak, int nb,
                         const LthDgGroup *group, double t, double shift, double *moments,
                         double *square) {
  for (LitheIndex q = 0; q < group->n_points; q++) {
    const double *row = op->point_data + group->first_point + (LitheCount)q * (4 + nb);
    double d[3];
    prescribed(weak, group->normal, row, t, d);
    lth_v3_axpy(shift, row, d);
    for (int i = 0; i < nb; i++) lth_v3_axpy(row[3] * row[4 + i], d, moments + 3 * i);
    for (int ab = 0; square && ab < 9; ab++) square[ab] += row[3] * d[ab / 3] * d[ab % 3];
  }
}

/// Data that are constant but for `shift` times X: exactly, through the mass of the group.
static void constant_data(const LthDgOperator *op, const LthDgHold *hold, const LthDgGroup *group,
                          double t, double shift, double *moments, double *square) {
  int nb = lth_dg_funcs(op->space, hold->cell);
  const double *X0 = op->rest + 3 * (LitheCount)op->space->func_off[hold->cell];
  const double *mass = op->group_data + group->table, *rest = mass + nb * nb;
  static const double nowhere[3] = {0};
  double d[3];
  prescribed(&op->weak[hold->constraint], group->normal, nowhere, t, d);
  for (int i = 0; i < nb; i++)
    for (int a = 0; a < 3; a++) moments[3 * i + a] = mass[i] * d[a] + shift * rest[3 * i + a];
  if (!square) return;

  // the data's coefficients are d + shift X0_0 and shift X0_j
  for (int i = 0; i < nb; i++)
    for (int ab = 0; ab < 9; ab++)
      square[ab] +=
          moments[3 * i + ab / 3] * (shift * X0[3 * i + ab % 3] + (i == 0 ? d[ab % 3] : 0));
}

void lth_dg_group_data(const LthDgOperator *op, const LthDgHold *hold, const LthDgGroup *group,
                       double t, bool absolute, double *moments, double *square) {
  const LthWeakConstraint *weak = &op->weak[hold->constraint];
  int nb = lth_dg_funcs(op->space, hold->cell);
  double shift = (absolute ? 1 : 0) - (weak->is_position ? 1 : 0); // positions are given as such
  memset(moments, 0, sizeof *moments * 3 * (size_t)nb);
  if (square) memset(square, 0, sizeof *square * 9);
  if (hold->varying)
    varying_data(op, weak, nb, group, t, shift, moments, square);
  else
    constant_data(op, hold, group, t, shift, moments, square);
}

/// r += P R (iso I + normal n n^T) y
static void add_projected(const LthDgHold *hold, const double R[9], double iso, double normal,
                          const double n[3], const double y[3], double r[3]) {
  double v[3], w[3], ny = lth_v3_dot(n, y);
  for (int a = 0; a < 3; a++) v[a] = iso * y[a] + normal * ny * n[a];
  lth_m3_apply(R, v, w);
  lth_m3_apply(hold->P, w, v);
  lth_v3_axpy(1, v, r);
}

/// f0_i -= R [ lambda n_c t_cb + mu (t_bd n_d + n_b t_cc) ],  t_cb = sum_l slope_b[i][l] y_l,c: the
/// data's work on the traction of every function.
static void add_traction_data(const LthDgOperator *op, const LthDgHold *hold,
                              const LthDgGroup *group, const double *y, double *f0) {
  int nb = lth_dg_funcs(op->space, hold->cell), nl = lth_dg_lower(op->space, hold->cell);
  const double *slope = lth_dg_slope(op, hold->cell), *n = group->normal;
  const double *R = op->rotation + 9 * (LitheCount)hold->cell;
  double lambda = op->lambda[hold->cell], mu = op->mu[hold->cell];
  for (int i = 1; i < nb; i++) {
    double T[9] = {0}, v[3], w[3];
    for (int c = 0; c < 3; c++)
      for (int b = 0; b < 3; b++)
        for (int l = 0; l < nl; l++) T[3 * c + b] += slope[(b * nb + i) * nl + l] * y[3 * l + c];
    double trace = T[0] + T[4] + T[8];
    for (int b = 0; b < 3; b++)
      v[b] = lambda * (n[0] * T[b] + n[1] * T[3 + b] + n[2] * T[6 + b]) +
             mu * (lth_v3_dot(T + 3 * b, n) + n[b] * trace);
    lth_m3_apply(R, v, w);
    lth_v3_axpy(-1, w, f0 + 3 * i);
  }
}

/// Load of one group, from the moments of its data.
static void add_group_load(const LthDgOperator *op, const LthDgHold *hold, const LthDgGroup *group,
                           double t, double *f0) {
  int nb = lth_dg_funcs(op->space, hold->cell);
  const double *R = op->rotation + 9 * (LitheCount)hold->cell;
  const double *mass = op->group_data + group->table, *n = group->normal;
  const LthDgPenalty *p = &group->penalty;
  bool ip = op->flux == LTH_FLUX_IP;
  double kappa = 3 * op->lambda[hold->cell] + 2 * op->mu[hold->cell], y[3 * LTH_DG_MAX_FUNCS];
  lth_dg_group_data(op, hold, group, t, true, y, NULL);
  for (int i = 0; i < nb; i++) { // y = R^T P data
    double v[3];
    lth_m3_apply(hold->P, y + 3 * i, v);
    lth_m3_apply_t(R, v, y + 3 * i);
  }
  if (ip) add_traction_data(op, hold, group, y, f0);
  for (int i = 0; i < nb; i++) {
    double mean = mass[i] / group->area;
    if (ip) add_projected(hold, R, -kappa * mass[i], 0, n, n, f0 + 3 * i);
    add_projected(hold, R, p->full_iso, p->full_normal[0], n, y + 3 * i, f0 + 3 * i);
    add_projected(hold, R, mean * p->low_iso[0], mean * p->low_normal[0][0], n, y, f0 + 3 * i);
  }
}

/// Load of data that are X + d or d with constant d, through the hold's matrices: cost by the cell, not by
/// its pieces.  f0_i += P R B_ij X0_j + R B_ji^T y_j + P R Q_ij y_j,  y_j = R^T P XD_j.
static void add_constant_load(const LthDgOperator *op, const LthDgHold *hold, double t,
                              double *f0) {
  const LthWeakConstraint *weak = &op->weak[hold->constraint];
  int nb = lth_dg_funcs(op->space, hold->cell);
  const double *R = op->rotation + 9 * (LitheCount)hold->cell;
  const double *X0 = op->rest + 3 * (LitheCount)op->space->func_off[hold->cell];
  const double *flux = op->hold_data + hold->table, *penalty = flux + 9 * nb * nb;
  static const double nowhere[3] = {0};
  double d[3], y[4][3], v[3], w[3];
  prescribed(weak, nowhere, nowhere, t, d);
  for (int j = 0; j < 4; j++) { // X0 and constants have no more coefficients
    for (int a = 0; a < 3; a++)
      v[a] = (weak->is_position ? 0 : X0[3 * j + a]) + (j == 0 ? d[a] : 0);
    lth_m3_apply(hold->P, v, w);
    lth_m3_apply_t(R, w, y[j]);
  }
  for (int i = 0; i < nb; i++) {
    double projected[3] = {0}, free[3] = {0};
    for (int j = 0; j < 4; j++)
      for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) {
          projected[a] += flux[((i * 3 + a) * 3 + b) * nb + j] * X0[3 * j + b] +
                          penalty[((i * 3 + a) * 3 + b) * nb + j] * y[j][b];
          free[a] += flux[((j * 3 + b) * 3 + a) * nb + i] * y[j][b];
        }
    lth_m3_apply(R, projected, v);
    lth_m3_apply(hold->P, v, w);
    lth_v3_axpy(1, w, f0 + 3 * i);
    lth_m3_apply(R, free, v);
    lth_v3_axpy(1, v, f0 + 3 * i);
  }
}

void lth_dg_hold_load(const LthDgOperator *op, const LthDgHold *hold, double t, double *f0) {
  if (!hold->roller && !hold->varying) {
    add_constant_load(op, hold, t, f0);
    return;
  }
  for (LitheIndex g = 0; g < hold->n_groups; g++)
    add_group_load(op, hold, &op->groups[hold->first_group + g], t, f0);
}
