/// Face tables: products of traces by in-plane moments, and the list of inner faces.
#include "disc/dg/dg_store_priv.h"

/// A face is a needle below this share of the square about it.
#define NEEDLE 0.02

/// Coordinates of a face: x = origin + h (s t1 + t t2).
typedef struct FaceFrame {
  double origin[3], t1[3], t2[3], h;
} FaceFrame;

/// Turn the axes of a needle along it: sums of monomials across them would cancel.
static void turn_frame(const LthFaceView *piece, FaceFrame *frame) {
  double m[6], t1[3];
  lth_face_moments(2, frame->origin, frame->t1, frame->t2, frame->h, piece, m);
  if (!(m[0] < NEEDLE * frame->h * frame->h)) return;
  double angle = 0.5 * atan2(2 * m[4], m[3] - m[5]), c = cos(angle), s = sin(angle);
  for (int a = 0; a < 3; a++) t1[a] = c * frame->t1[a] + s * frame->t2[a];
  for (int a = 0; a < 3; a++) frame->t2[a] = c * frame->t2[a] - s * frame->t1[a];
  lth_v3_copy(t1, frame->t1);
}

static FaceFrame face_frame(const LthFaceView *piece, const double centroid[3]) {
  FaceFrame frame = {.h = 0};
  lth_v3_copy(centroid, frame.origin);
  lth_face_frame(piece->normal, frame.t1, frame.t2);
  for (LitheIndex p = piece->loop_off[0]; p < piece->loop_off[piece->n_loops]; p++)
    frame.h = fmax(frame.h, lth_v3_distance(piece->points + 3 * piece->loop_point[p], centroid));
  turn_frame(piece, &frame);
  return frame;
}

/// out = in * (p[0] + p[1] s + p[2] t), in of degree d in graded order.
static void times_linear(int d, const double *in, const double p[3], double *out) {
  memset(out, 0, sizeof *out * (size_t)lth_monomials2(d + 1));
  for (int n = 0, q = 0; n <= d; n++)
    for (int j = 0; j <= n; j++, q++) {
      out[q] += p[0] * in[q];
      out[q + n + 1] += p[1] * in[q];
      out[q + n + 2] += p[2] * in[q];
    }
}

/// Traces of a cell's functions as polynomials of (s, t): trace (nb x lth_monomials2(k)).
static void cell_trace(const LthDgSpace *space, LitheIndex cell, const FaceFrame *frame,
                       double *trace) {
  int nb = lth_dg_funcs(space, cell), k = space->degree[cell], n2 = lth_monomials2(k);
  const int(*exponent)[3] = lth_monomial3_exponents();
  const double *center = space->center + 3 * (LitheCount)cell;
  const double *axes = space->axes + 9 * (LitheCount)cell;

  // xi_a on the face is linear in (s, t); every monomial is a smaller one times one of them
  double linear[3][3], monomial[LTH_DG_MAX_FUNCS][LTH_DG_MAX_TRACE] = {{1}};
  double offset[3];
  lth_v3_sub(frame->origin, center, offset);
  for (int a = 0; a < 3; a++) {
    linear[a][0] = lth_v3_dot(axes + 3 * a, offset);
    linear[a][1] = frame->h * lth_v3_dot(axes + 3 * a, frame->t1);
    linear[a][2] = frame->h * lth_v3_dot(axes + 3 * a, frame->t2);
  }
  for (int q = 1; q < nb; q++) {
    int e[3] = {exponent[q][0], exponent[q][1], exponent[q][2]};
    int axis = e[0] ? 0 : e[1] ? 1 : 2, degree = e[0] + e[1] + e[2];
    e[axis]--;
    times_linear(degree - 1, monomial[lth_monomial3_index(e[0], e[1], e[2])], linear[axis],
                 monomial[q]);
  }
  const double *basis = space->basis[cell];
  memset(trace, 0, sizeof *trace * (size_t)(nb * n2));
  for (int i = 0; i < nb; i++)
    for (int q = 0; q <= i; q++)
      for (int c = 0; c < n2; c++) trace[i * n2 + c] += basis[i * nb + q] * monomial[q][c];
}

/// mass[i][j] += sign int u_i v_j from the traces u (nu rows) and v (nv rows) of degrees ku and kv.
static void trace_products(int nu, int ku, const double *u, int nv, int kv, const double *v,
                           const double *moments, double sign, double *mass) {
  const int(*exponent)[2] = lth_monomial2_exponents();
  int mu = lth_monomials2(ku), mv = lth_monomials2(kv);
  double M[LTH_DG_MAX_TRACE][LTH_DG_MAX_TRACE];
  for (int p = 0; p < mu; p++)
    for (int q = 0; q < mv; q++) {
      int i = exponent[p][0] + exponent[q][0], j = exponent[p][1] + exponent[q][1];
      M[p][q] = sign * moments[(i + j) * (i + j + 1) / 2 + j];
    }
  for (int i = 0; i < nu; i++) {
    double row[LTH_DG_MAX_TRACE] = {0};
    for (int p = 0; p < mu; p++)
      for (int q = 0; q < mv; q++) row[q] += u[i * mu + p] * M[p][q];
    for (int j = 0; j < nv; j++) {
      double sum = 0;
      for (int q = 0; q < mv; q++) sum += row[q] * v[j * mv + q];
      mass[i * nv + j] += sum;
    }
  }
}

void lth_dg_add_face_mass(const LthDgSpace *space, LitheIndex cell, const LthFaceView *piece,
                          const double centroid[3], double *mass) {
  double trace[LTH_DG_MAX_FUNCS * LTH_DG_MAX_TRACE], moments[LTH_DG_MAX_TRACE2];
  int nb = lth_dg_funcs(space, cell), k = space->degree[cell];
  FaceFrame frame = face_frame(piece, centroid);
  lth_face_moments(2 * k, frame.origin, frame.t1, frame.t2, frame.h, piece, moments);
  cell_trace(space, cell, &frame, trace);
  trace_products(nb, k, trace, nb, k, trace, moments, 1, mass);
}

void lth_dg_add_face_mean(const LthDgSpace *space, LitheIndex cell, const LthFaceView *piece,
                          const double centroid[3], double *mean) {
  double trace[LTH_DG_MAX_FUNCS * LTH_DG_MAX_TRACE], moments[LTH_DG_MAX_TRACE2];
  int nb = lth_dg_funcs(space, cell), k = space->degree[cell], n2 = lth_monomials2(k);
  FaceFrame frame = face_frame(piece, centroid);
  lth_face_moments(k, frame.origin, frame.t1, frame.t2, frame.h, piece, moments);
  cell_trace(space, cell, &frame, trace);
  for (int i = 0; i < nb; i++)
    for (int q = 0; q < n2; q++) mean[i] += trace[i * n2 + q] * moments[q];
}

/// slope tables: g[b][i][j] = sum_l mixed[..][l] slope_b[..][l] (the sign of the jump is in `mixed`).
static void face_slopes(const LthDgOperator *op, const LthDgFace *face, const LthDgFaceTables *t) {
  int n0 = lth_dg_funcs(op->space, face->cell[0]), n1 = lth_dg_funcs(op->space, face->cell[1]);
  int l0 = lth_dg_lower(op->space, face->cell[0]), l1 = lth_dg_lower(op->space, face->cell[1]);
  const double *slope0 = lth_dg_slope(op, face->cell[0]), *slope1 = lth_dg_slope(op, face->cell[1]);
  for (int b = 0; b < 3; b++)
    for (int i = 0; i < n0; i++)
      for (int j = 0; j < n1; j++) {
        double minus = 0, plus = 0;
        for (int l = 0; l < l1; l++)
          minus -= t->full.mixed[i * n1 + l] * slope1[(b * n1 + j) * l1 + l];
        for (int l = 0; l < l0; l++)
          plus += t->full.mixed[l * n1 + j] * slope0[(b * n0 + i) * l0 + l];
        t->slope[1][(b * n0 + i) * n1 + j] = minus;
        t->slope[0][(b * n0 + i) * n1 + j] = plus;
      }
}

/// Orthonormal polynomials psi_l of degree p in the face as rows of `psi` (coefficients of the graded
/// monomials, lower-triangular), by Gram-Schmidt with their moments.
static void face_polynomials(int p, const double *moments,
                             double psi[LTH_DG_MAX_LOW][LTH_DG_MAX_LOW]) {
  const int(*exponent)[2] = lth_monomial2_exponents();
  int r = lth_monomials2(p);
  double M[LTH_DG_MAX_LOW][LTH_DG_MAX_LOW];
  for (int i = 0; i < r; i++)
    for (int j = 0; j < r; j++) {
      int a = exponent[i][0] + exponent[j][0], b = exponent[i][1] + exponent[j][1];
      M[i][j] = moments[(a + b) * (a + b + 1) / 2 + b];
    }
  memset(psi, 0, sizeof(double) * LTH_DG_MAX_LOW * LTH_DG_MAX_LOW);
  for (int l = 0; l < r; l++) {
    double v[LTH_DG_MAX_LOW] = {0}, size = 0;
    v[l] = 1;
    for (int round = 0; round < 2; round++)
      for (int m = 0; m < l; m++) {
        double dot = 0;
        for (int i = 0; i <= l; i++)
          for (int j = 0; j <= m; j++) dot += v[i] * M[i][j] * psi[m][j];
        for (int j = 0; j <= m; j++) v[j] -= dot * psi[m][j];
      }
    for (int i = 0; i <= l; i++)
      for (int j = 0; j <= l; j++) size += v[i] * M[i][j] * v[j];
    // a needle so thin that rounding decides has no such polynomial
    for (int i = 0; i <= l && size > 1e-12 * M[l][l]; i++) psi[l][i] = v[i] / sqrt(size);
  }
}

/// low (r x n): int psi_l phi_i from a trace of degree k.
static void low_moments(int r, double psi[LTH_DG_MAX_LOW][LTH_DG_MAX_LOW], int n, int k,
                        const double *trace, const double *moments, double *low) {
  const int(*exponent)[2] = lth_monomial2_exponents();
  int n2 = lth_monomials2(k);
  for (int l = 0; l < r; l++) {
    double row[LTH_DG_MAX_TRACE] = {0};
    for (int i = 0; i <= l; i++)
      for (int q = 0; q < n2; q++) {
        int a = exponent[i][0] + exponent[q][0], b = exponent[i][1] + exponent[q][1];
        row[q] += psi[l][i] * moments[(a + b) * (a + b + 1) / 2 + b];
      }
    for (int i = 0; i < n; i++) {
      low[l * n + i] = 0;
      for (int q = 0; q < n2; q++) low[l * n + i] += row[q] * trace[i * n2 + q];
    }
  }
}

/// table += sign u^T v
static void low_products(int r, int nu, const double *u, int nv, const double *v, double sign,
                         double *table) {
  for (int l = 0; l < r; l++)
    for (int i = 0; i < nu; i++)
      for (int j = 0; j < nv; j++) table[i * nv + j] += sign * u[l * nu + i] * v[l * nv + j];
}

void lth_dg_integrate_face(LthDgOperator *op, LthDgFace *face) {
  const LthDgSpace *space = op->space;
  LthDgFaceTables t = lth_dg_face_tables(op, face);
  double trace[2][LTH_DG_MAX_FUNCS * LTH_DG_MAX_TRACE], moments[LTH_DG_MAX_TRACE2];
  LthFaceView view = lth_mesh_face(space->mesh, face->face);
  FaceFrame frame = face_frame(&view, space->mesh->face_centroid + 3 * (LitheCount)face->face);
  int n[2], k[2];
  for (int s = 0; s < 2; s++) {
    n[s] = lth_dg_funcs(space, face->cell[s]);
    k[s] = space->degree[face->cell[s]];
    cell_trace(space, face->cell[s], &frame, trace[s]);
  }
  int degree = 2 * (k[0] > k[1] ? k[0] : k[1]);
  lth_face_moments(degree, frame.origin, frame.t1, frame.t2, frame.h, &view, moments);
  for (int s = 0; s < 2; s++)
    trace_products(n[s], k[s], trace[s], n[s], k[s], trace[s], moments, 1, t.full.mass[s]);
  trace_products(n[0], k[0], trace[0], n[1], k[1], trace[1], moments, -1, t.full.mixed);
  double psi[LTH_DG_MAX_LOW][LTH_DG_MAX_LOW], low[2][LTH_DG_MAX_LOW * LTH_DG_MAX_FUNCS];
  face_polynomials(degree / 2 - 1, moments, psi);
  for (int s = 0; s < 2; s++)
    low_moments(lth_monomials2(degree / 2 - 1), psi, n[s], k[s], trace[s], moments, low[s]);
  // the first rows belong to the lower degrees
  for (int p = 0; p < t.n_low; p++) {
    int r = lth_monomials2(k[p] - 1);
    for (int s = 0; s < 2; s++) low_products(r, n[s], low[s], n[s], low[s], 1, t.low[p].mass[s]);
    low_products(r, n[0], low[0], n[1], low[1], -1, t.low[p].mixed);
  }
  if (op->flux == LTH_FLUX_IP) face_slopes(op, face, &t);
  lth_dg_inner_penalty(op, face);
}

/// Does a face stand behind face f of the mesh, which has the same owner? By neighbour, then by record: the order in which the
/// faces of a pair are summed outlives changes elsewhere.
static bool is_behind(const LthDgOperator *op, const LthDgRecords *records, const LthDgFace *face,
                      LitheIndex f) {
  LitheIndex other = op->space->mesh->face_cell[2 * f + 1];
  if (face->cell[1] != other) return face->cell[1] > other;
  return records && records->face[face->face] > records->face[f];
}

/// Counting sort of the inner faces by owner, then by neighbour within each owner.
static void order_faces(LthDgOperator *op, const LthDgRecords *records) {
  const LthMesh *mesh = op->space->mesh;
  LitheIndex *next = op->own_face_off; // shifted by one while filling
  for (LitheIndex f = 0; f < mesh->n_faces; f++) {
    LitheIndex owner = mesh->face_cell[2 * f], other = mesh->face_cell[2 * f + 1];
    if (other < 0) continue;
    LitheIndex at = next[owner + 1]++;
    while (at > next[owner] && op->faces[at - 1].cell[0] == owner &&
           is_behind(op, records, op->faces + at - 1, f)) {
      op->faces[at] = op->faces[at - 1];
      at--;
    }
    LthDgFace *face = &op->faces[at];
    face->face = f, face->cell[0] = owner, face->cell[1] = other;
    face->area = mesh->face_area[f];
    lth_v3_copy(mesh->face_normal + 3 * (LitheCount)f, face->normal);
  }
}

/// own_face_off[c + 1] = first slot of owner c, side_off likewise counted; both prefix sums.
static void count_faces(LthDgOperator *op) {
  const LthMesh *mesh = op->space->mesh;
  LitheIndex n_cells = mesh->n_cells, start = 0;
  for (LitheIndex f = 0; f < mesh->n_faces; f++) {
    if (mesh->face_cell[2 * f + 1] < 0) continue;
    op->own_face_off[mesh->face_cell[2 * f] + 1]++;
    for (int s = 0; s < 2; s++) op->side_off[mesh->face_cell[2 * f + s] + 1]++;
  }
  for (LitheIndex c = 0; c < n_cells; c++) {
    LitheIndex count = op->own_face_off[c + 1];
    op->own_face_off[c + 1] = start;
    start += count;
    op->side_off[c + 1] += op->side_off[c];
  }
}

/// Sides of every cell in the order of the faces.
static LitheStatus list_sides(LitheCtx *ctx, LthDgOperator *op) {
  LitheIndex *filled = NULL;
  LTH_NEW(ctx, filled, op->space->n_cells);
  for (LitheIndex f = 0; f < op->n_faces; f++)
    for (int s = 0; s < 2; s++) {
      LitheIndex cell = op->faces[f].cell[s];
      op->sides[op->side_off[cell] + filled[cell]++] = (LthDgSide){.face = f, .side = s};
    }
  lth_free(ctx, filled);
  return LITHE_OK;
}

LitheStatus lth_dg_list_faces(LitheCtx *ctx, const LthDgRecords *records, LthDgOperator *op) {
  const LthMesh *mesh = op->space->mesh;
  for (LitheIndex f = 0; f < mesh->n_faces; f++) op->n_faces += mesh->face_cell[2 * f + 1] >= 0;
  LTH_NEW(ctx, op->faces, op->n_faces);
  LTH_NEW(ctx, op->own_face_off, mesh->n_cells + 1);
  LTH_NEW(ctx, op->side_off, mesh->n_cells + 1);
  LTH_NEW(ctx, op->sides, 2 * (LitheCount)op->n_faces);
  count_faces(op);
  order_faces(op, records);
  return list_sides(ctx, op);
}
