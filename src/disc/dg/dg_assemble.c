/// The warped stiffness matrix and its load: every block row is written by one thread only.
///
/// While a block is summed its rows are kept planar, row (i, a) = [b][j], so that the inner loops run
/// over j; at the end each row is interleaved to columns 3 j + b.
#include "disc/dg/dg_priv.h"

#include "base/clones.h"
#include "base/quad.h"

/// block += R D R^T for all (i, j); D laid out [i][a][b][j].
LTH_QUAD_INLINE void rotate_cell(int nb, const double *restrict D, const double R[9],
                                 double *restrict block) {
  for (int i = 0; i < nb; i++)
    for (int a = 0; a < 3; a++) {
      double half[3 * LTH_DG_MAX_FUNCS];
      for (int d = 0; d < 3; d++)
        lth_row_combine3(nb, R + 3 * a, D + (i * 9 + d) * nb, 3 * nb, half + d * nb);
      for (int b = 0; b < 3; b++)
        lth_row_combine3(nb, R + 3 * b, half, nb, block + ((i * 3 + a) * 3 + b) * nb);
    }
}

/// block[i][a][b][j] += full_ab mass_ij + part_ab low_ij
LTH_QUAD_INLINE void add_mass(int nu, int nv, const double *restrict mass, const double full[9],
                              const double *restrict low, const double part[9],
                              double *restrict block) {
  for (int i = 0; i < nu; i++)
    for (int ab = 0; ab < 9; ab++)
      lth_row_add2(nv, full[ab], mass + i * nv, part[ab], low + i * nv, block + (i * 9 + ab) * nv);
}

/// block[i][a][b][j] += part_ab low_ij
LTH_QUAD_INLINE void add_low(int nu, int nv, const double *restrict low, const double part[9],
                             double *restrict block) {
  for (int i = 0; i < nu; i++)
    for (int ab = 0; ab < 9; ab++)
      lth_row_add(nv, part[ab], low + i * nv, block + (i * 9 + ab) * nv);
}

/// One side's flux on the block of owner rows and neighbour columns; n = R_s n, g' = R_s g_ij:
///   side -: += lambda n_a g'_b + mu (g'_a n_b + delta_ab n.g'), and its transpose for side +.
/// lambda and mu carry the factor -1/2.
LTH_QUAD_INLINE void add_flux(int nu, int nv, const double *restrict g, const double R[9],
                              const double n[3], double lambda, double mu, int transposed,
                              double *restrict block) {
  for (int i = 0; i < nu; i++) {
    double r[3 * LTH_DG_MAX_FUNCS], ng[LTH_DG_MAX_FUNCS];
    for (int b = 0; b < 3; b++) lth_row_combine3(nv, R + 3 * b, g + i * nv, nu * nv, r + b * nv);
    lth_row_combine3(nv, n, r, nv, ng);
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++) {
        double *row = block + ((i * 3 + a) * 3 + b) * nv;
        double ca = (transposed ? mu : lambda) * n[a], cb = (transposed ? lambda : mu) * n[b];
        lth_row_add2(nv, ca, r + b * nv, cb, r + a * nv, row);
        if (a == b) lth_row_add(nv, mu, ng, row);
      }
  }
}

/// Rows [b][j] -> [3 j + b].
LTH_QUAD_INLINE void interleave(int rows, int nv, double *restrict block) {
  for (int r = 0; r < rows; r++) {
    double planar[3 * LTH_DG_MAX_FUNCS], *row = block + r * 3 * nv;
    memcpy(planar, row, sizeof *row * 3 * (size_t)nv);
    for (int j = 0; j < nv; j++)
      for (int b = 0; b < 3; b++) row[3 * j + b] = planar[b * nv + j];
  }
}

/// Penalty matrices of a face with the rotations as they stand.
typedef struct FacePenalty {
  double full[9], low[2][9], n[2][3];
} FacePenalty;

/// What one face adds to a block of owner rows and neighbour columns.
typedef struct PairTerms {
  const double *mixed, *low[2], *slope[2], *R[2];
  int n_low;
  FacePenalty penalty;
  double lambda[2], mu[2];
} PairTerms;

LTH_QUAD_INLINE void pair_rows(int nu, int nv, int flux, const PairTerms *t, double *block) {
  const FacePenalty *p = &t->penalty;
  add_mass(nu, nv, t->mixed, p->full, t->low[0], p->low[0], block);
  if (t->n_low > 1) add_low(nu, nv, t->low[1], p->low[1], block);
  if (!flux) return;
  add_flux(nu, nv, t->slope[1], t->R[1], p->n[1], t->lambda[1], t->mu[1], 0, block);
  add_flux(nu, nv, t->slope[0], t->R[0], p->n[0], t->lambda[0], t->mu[0], 1, block);
}

// clang-format off: it takes the macros for declarations
// the common sizes are compiled with constant trip counts
#define BY_SIZE(n, call)                                                                           \
  switch (n) {                                                                                     \
  case 4:                                                                                          \
    call(4);                                                                                       \
    break;                                                                                         \
  case 10:                                                                                         \
    call(10);                                                                                      \
    break;                                                                                         \
  case 20:                                                                                         \
    call(20);                                                                                      \
    break;                                                                                         \
  case 35:                                                                                         \
    call(35);                                                                                      \
    break;                                                                                         \
  default:                                                                                         \
    call(n);                                                                                       \
    break;                                                                                         \
  }

LTH_CLONES static void rotate_cell_sized(int nb, const double *D, const double R[9], double *block){
#define CALL(n) rotate_cell(n, D, R, block)
    BY_SIZE(nb, CALL)
#undef CALL
}

LTH_CLONES static void add_mass_sized(int nb, const double *mass, const double full[9],
                                      const double *low, const double part[9], double *block){
#define CALL(n) add_mass(n, n, mass, full, low, part, block)
    BY_SIZE(nb, CALL)
#undef CALL
}

LTH_CLONES
    static void add_low_sized(int nb, const double *low, const double part[9], double *block){
#define CALL(n) add_low(n, n, low, part, block)
        BY_SIZE(nb, CALL)
#undef CALL
    }

LTH_CLONES static void pair_rows_sized(int nu, int nv, int flux, const PairTerms *t, double *block){
#define CALL(n) pair_rows(nu, n, flux, t, block)
    BY_SIZE(nv, CALL)
#undef CALL
}

LTH_CLONES static void interleave_sized(int rows, int nv, double *block) {
#define CALL(n) interleave(rows, n, block)
  BY_SIZE(nv, CALL)
#undef CALL
}
// clang-format on

static FacePenalty face_penalty(const LthDgOperator *op, const LthDgFace *face, int n_low) {
  FacePenalty f;
  for (int s = 0; s < 2; s++)
    lth_m3_apply(op->rotation + 9 * (LitheCount)face->cell[s], face->normal, f.n[s]);
  const LthDgPenalty *p = &face->penalty;
  lth_dg_penalty_matrix(p->full_iso, p->full_normal, f.n[0], f.n[1], f.full);
  for (int q = 0; q < n_low; q++)
    lth_dg_penalty_matrix(p->low_iso[q], p->low_normal[q], f.n[0], f.n[1], f.low[q]);
  return f;
}

/// block_ij += P R B_ij R^T + (P R B_ji R^T)^T + P R Q_ij R^T P of a hold that leaves components free.
static void add_partial_hold(const LthDgOperator *op, const LthDgHold *hold, double *block) {
  int nb = lth_dg_funcs(op->space, hold->cell);
  const double *R = op->rotation + 9 * (LitheCount)hold->cell;
  const double *flux = op->hold_data + hold->table, *penalty = flux + 9 * nb * nb;
  double PR[9], Rt[9], RtP[9], T[9], M[9];
  lth_m3_mul(hold->P, R, PR);
  lth_m3_transpose(PR, RtP);
  lth_m3_transpose(R, Rt);
  for (int i = 0; i < nb; i++)
    for (int j = 0; j < nb; j++) {
      double B[9], Q[9];
      for (int ab = 0; ab < 9; ab++) {
        B[ab] = flux[(i * 9 + ab) * nb + j];
        Q[ab] = penalty[(i * 9 + ab) * nb + j];
      }
      lth_m3_mul(PR, B, T);
      lth_m3_mul(T, Rt, M);
      for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) {
          block[((i * 3 + a) * 3 + b) * nb + j] += M[3 * a + b];
          block[((j * 3 + b) * 3 + a) * nb + i] += M[3 * a + b];
        }
      lth_m3_mul(PR, Q, T);
      lth_m3_mul(T, RtP, M);
      for (int ab = 0; ab < 9; ab++) block[(i * 9 + ab) * nb + j] += M[ab];
    }
}

/// The same for a roller, P = n n^T: rows n (x) v_ij with v_ij = R B_ij^T R^T n, and q_ij n (x) n.
static void add_roller(const LthDgOperator *op, const LthDgHold *hold, double *block) {
  int nb = lth_dg_funcs(op->space, hold->cell), nl = lth_dg_lower(op->space, hold->cell);
  const LthDgGroup *group = &op->groups[hold->first_group];
  const double *R = op->rotation + 9 * (LitheCount)hold->cell, *n = group->normal;
  const double *mass = op->group_data + group->table, *slope = lth_dg_slope(op, hold->cell);
  bool ip = op->flux == LTH_FLUX_IP;
  double turned[3], lambda = -op->lambda[hold->cell], mu = -op->mu[hold->cell];
  lth_m3_apply(R, n, turned);
  double cosine = lth_v3_dot(n, turned);
  const LthDgPenalty *p = &group->penalty;
  double full = p->full_iso + p->full_normal[0] * cosine * cosine;
  double mean = (p->low_iso[0] + p->low_normal[0][0] * cosine * cosine) / group->area;

  for (int i = 0; i < nb; i++)
    for (int j = 0; j < nb; j++) {
      double g[3] = {0}, v[3], r[3] = {0};
      for (int b = 0; ip && b < 3; b++)
        for (int l = 0; l < nl; l++) g[b] += mass[i * nb + l] * slope[(b * nb + j) * nl + l];
      if (ip) lth_m3_apply(R, g, r);
      double ng = lth_v3_dot(n, g), nr = lth_v3_dot(n, r);
      double q = full * mass[i * nb + j] + mean * mass[i] * mass[j];
      for (int b = 0; b < 3; b++) v[b] = lambda * cosine * r[b] + mu * (nr * turned[b] + ng * n[b]);
      for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) {
          block[((i * 3 + a) * 3 + b) * nb + j] += n[a] * (v[b] + q * n[b]);
          block[((j * 3 + b) * 3 + a) * nb + i] += n[a] * v[b];
        }
    }
}

void lth_dg_assemble_diagonal(const LthDgOperator *op, LitheIndex cell, double *block) {
  int nb = lth_dg_funcs(op->space, cell);
  rotate_cell_sized(nb, op->cell_data[cell], op->rotation + 9 * (LitheCount)cell, block);
  for (LitheIndex s = op->side_off[cell]; s < op->side_off[cell + 1]; s++) {
    const LthDgFace *face = &op->faces[op->sides[s].face];
    LthDgFaceTables tables = lth_dg_face_tables(op, face);
    FacePenalty p = face_penalty(op, face, tables.n_low);
    int side = op->sides[s].side;
    add_mass_sized(nb, tables.full.mass[side], p.full, tables.low[0].mass[side], p.low[0], block);
    if (tables.n_low > 1) add_low_sized(nb, tables.low[1].mass[side], p.low[1], block);
  }
  for (LitheIndex h = op->hold_off[cell]; h < op->hold_off[cell + 1]; h++)
    if (op->holds[h].roller)
      add_roller(op, &op->holds[h], block);
    else if (!op->holds[h].whole)
      add_partial_hold(op, &op->holds[h], block);
  interleave_sized(3 * nb, nb, block);
}

static void add_face_to_pair(const LthDgOperator *op, const LthDgFace *face, double *block) {
  int nu = lth_dg_funcs(op->space, face->cell[0]), nv = lth_dg_funcs(op->space, face->cell[1]);
  LthDgFaceTables tables = lth_dg_face_tables(op, face);
  PairTerms t = {.mixed = tables.full.mixed,
                 .low = {tables.low[0].mixed, tables.low[1].mixed},
                 .n_low = tables.n_low,
                 .penalty = face_penalty(op, face, tables.n_low)};
  for (int s = 0; s < 2; s++) {
    t.slope[s] = tables.slope[s];
    t.R[s] = op->rotation + 9 * (LitheCount)face->cell[s];
    t.lambda[s] = -face->weight[s] * op->lambda[face->cell[s]];
    t.mu[s] = -face->weight[s] * op->mu[face->cell[s]];
  }
  pair_rows_sized(nu, nv, op->flux == LTH_FLUX_IP, &t, block);
}

static void transpose_block(int rows, int cols, const double *block, double *transposed) {
  for (int r = 0; r < rows; r++)
    for (int c = 0; c < cols; c++) transposed[c * rows + r] = block[r * cols + c];
}

LitheIndex lth_dg_assemble_pair(const LthDgOperator *op, LitheIndex f, double *block,
                                double *mirror) {
  LitheIndex cell = op->faces[f].cell[0], other = op->faces[f].cell[1];
  LitheIndex end = op->own_face_off[cell + 1];
  int nu = lth_dg_funcs(op->space, cell), nv = lth_dg_funcs(op->space, other);
  memset(block, 0, sizeof *block * 9 * (size_t)(nu * nv));
  for (; f < end && op->faces[f].cell[1] == other; f++) add_face_to_pair(op, &op->faces[f], block);
  interleave_sized(3 * nu, nv, block);
  transpose_block(3 * nu, 3 * nv, block, mirror);
  return f;
}

/// The blocks of a cell with the neighbours it owns the faces to, both triangles.
static void assemble_pairs(const LthDgOperator *op, LitheIndex cell, LthBlockMatrix *K) {
  LitheIndex f = op->own_face_off[cell], end = op->own_face_off[cell + 1];
  while (f < end) {
    LitheIndex other = op->faces[f].cell[1];
    f = lth_dg_assemble_pair(op, f, K->values + K->value_off[lth_block_matrix_find(K, cell, other)],
                             K->values + K->value_off[lth_block_matrix_find(K, other, cell)]);
  }
}

void lth_dg_assemble(LthDgOperator *op, double t, LthBlockMatrix *K, double *f0) {
#pragma omp parallel for schedule(static) num_threads(lth_dg_threads(op))
  for (LitheIndex cell = 0; cell < op->space->n_cells; cell++) {
    lth_dg_assemble_diagonal(op, cell, K->values + K->value_off[K->diagonal[cell]]);
    assemble_pairs(op, cell, K);
  }
  lth_dg_assemble_load(op, t, f0);
}

/// f0_i = R_K load_i - sum_f w_L kappa_L R_L n int phi_i  + constraints: what the reference shape holds.
void lth_dg_assemble_cell_load(const LthDgOperator *op, LitheIndex cell, double t, double *f0) {
  int nb = lth_dg_funcs(op->space, cell);
  const double *R = op->rotation + 9 * (LitheCount)cell;
  const double *own = op->cell_load + 3 * (LitheCount)op->space->func_off[cell];
  for (int i = 0; i < nb; i++) lth_m3_apply(R, own + 3 * i, f0 + 3 * i);
  if (op->flux == LTH_FLUX_IP)
    for (LitheIndex s = op->side_off[cell]; s < op->side_off[cell + 1]; s++) {
      const LthDgFace *face = &op->faces[op->sides[s].face];
      int side = op->sides[s].side;
      LitheIndex other = face->cell[1 - side];
      double kappa = 3 * op->lambda[other] + 2 * op->mu[other], n[3];
      lth_m3_apply(op->rotation + 9 * (LitheCount)other, face->normal, n);
      const double *mean = lth_dg_face_tables(op, face).full.mass[side];
      double factor = (side == 0 ? -kappa : kappa) * face->weight[1 - side];
      for (int i = 0; i < nb; i++) lth_v3_axpy(factor * mean[i], n, f0 + 3 * i);
    }
  for (LitheIndex h = op->hold_off[cell]; h < op->hold_off[cell + 1]; h++)
    lth_dg_hold_load(op, &op->holds[h], t, f0);
}

void lth_dg_assemble_load(LthDgOperator *op, double t, double *f0) {
#pragma omp parallel for schedule(static) num_threads(lth_dg_threads(op))
  for (LitheIndex cell = 0; cell < op->space->n_cells; cell++)
    lth_dg_assemble_cell_load(op, cell, t, f0 + 3 * (LitheCount)op->space->func_off[cell]);
}
