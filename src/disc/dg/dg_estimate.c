/// The parts of the residual: volume, faces, boundary, jumps.
#include "disc/dg/dg_estimate.h"

#include "disc/dg/dg_load.h"
#include "disc/dg/dg_priv.h"

/// Poincare's constant of a convex element is its length over pi.
#define VOLUME_FACTOR (1 / (M_PI * M_PI))
/// |v - mean|^2 on a face of a cube is at most so much times its edge times |grad v|^2 inside:
/// (a^2 + 2 a) / pi^2 + ... for the distance a = 1 of the face from the opposite one.
#define FACE_FACTOR 0.3

/// Stress of an element, turned: R sigma = sum_l P_l phi_l.
typedef struct CellStress {
  int n;
  double P[9 * LTH_DG_MAX_LOWER];
} CellStress;

static void cell_stress(const LthDgOperator *op, LitheIndex cell, const double *x, CellStress *s) {
  double S[9 * LTH_DG_MAX_LOWER];
  lth_dg_stress_coefficients(op, cell, x, S);
  s->n = lth_dg_lower(op->space, cell);
  for (int l = 0; l < s->n; l++)
    lth_m3_mul(op->rotation + 9 * (LitheCount)cell, S + 9 * l, s->P + 9 * l);
}

/// Tractions P_l n (n x 3).
static void tractions(const CellStress *s, const double n[3], double *T) {
  for (int l = 0; l < s->n; l++) lth_m3_apply(s->P + 9 * l, n, T + 3 * l);
}

/// Length of an element: the longest edge of its box.
static double length_of(const LthDgSpace *space, LitheIndex cell) {
  const double *box = space->mesh->cell_box + 6 * (LitheCount)cell;
  return fmax(box[3] - box[0], fmax(box[4] - box[1], box[5] - box[2]));
}

static double face_scale(const LthDgOperator *op, LitheIndex cell) {
  return FACE_FACTOR * length_of(op->space, cell) / (op->space->degree[cell] * op->mu[cell]);
}

static bool is_held(const LthDgOperator *op, LitheIndex cell) {
  if (!op->held) return false;
  for (LitheCount i = 3 * (LitheCount)op->space->func_off[cell];
       i < 3 * (LitheCount)op->space->func_off[cell + 1]; i++)
    if (op->held[i] != LTH_HELD) return false;
  return true;
}

/// r += div P: d_b phi_l is a combination of the functions again.
static void add_divergence(const LthDgOperator *op, LitheIndex cell, const CellStress *s,
                           double *r) {
  int nb = lth_dg_funcs(op->space, cell);
  const double *slope = lth_dg_slope(op, cell);
  for (int l = 1; l < s->n; l++)
    for (int m = 0; m < s->n; m++)
      for (int b = 0; b < 3; b++) {
        double d = slope[(b * nb + l) * s->n + m];
        for (int a = 0; a < 3; a++) r[3 * m + a] += d * s->P[9 * l + 3 * a + b];
      }
}

/// (h / pi k)^2 / mu int |b + div P - rho a|^2, loads b by their projection `force` (n_dofs) [N].
static double volume_part(const LthDgEstimateDef *def, LitheIndex cell, const CellStress *s,
                          const double *force) {
  const LthDgOperator *op = def->op;
  LitheCount first = 3 * (LitheCount)op->space->func_off[cell];
  int n = 3 * lth_dg_funcs(op->space, cell);
  double r[3 * LTH_DG_MAX_FUNCS], volume = op->space->mesh->cell_volume[cell], sum = 0;
  double length = length_of(op->space, cell) / op->space->degree[cell];
  for (int i = 0; i < n; i++) r[i] = force[first + i] / volume;
  for (int a = 0; def->density && a < 3; a++) r[a] += def->density[cell] * def->gravity[a];
  for (int i = 0; def->density && def->acceleration && i < n; i++)
    r[i] -= def->density[cell] * def->acceleration[first + i];
  add_divergence(op, cell, s, r);
  for (int i = 0; i < n; i++) sum += r[i] * r[i];
  return VOLUME_FACTOR * length * length / op->mu[cell] * volume * sum;
}

/// int |sum_i A_i phi_i|^2 from the mass of the traces (row length `stride`).
static double square(int n, const double *A, const double *mass, int stride) {
  double sum = 0;
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) sum += mass[i * stride + j] * lth_v3_dot(A + 3 * i, A + 3 * j);
  return sum;
}

/// int |[P n]|^2 over an inner face.
static double traction_jump(const LthDgOperator *op, const LthDgFace *face, const double *x) {
  LthDgFaceTables t = lth_dg_face_tables(op, face);
  double T[2][3 * LTH_DG_MAX_LOWER], sum = 0;
  int nb[2], n[2];
  for (int s = 0; s < 2; s++) {
    CellStress stress;
    cell_stress(op, face->cell[s], x, &stress);
    tractions(&stress, face->normal, T[s]);
    nb[s] = lth_dg_funcs(op->space, face->cell[s]), n[s] = stress.n;
  }
  for (int s = 0; s < 2; s++) sum += square(n[s], T[s], t.full.mass[s], nb[s]);
  for (int i = 0; i < n[0]; i++)
    for (int j = 0; j < n[1]; j++)
      sum += 2 * t.full.mixed[i * nb[1] + j] * lth_v3_dot(T[0] + 3 * i, T[1] + 3 * j);
  return fmax(sum, 0);
}

/// The share of a face's jump of traction that side s answers for: tests weigh its functions by 1 - w_s.
static double faces_part(const LthDgEstimateDef *def, LitheIndex cell) {
  const LthDgOperator *op = def->op;
  double sum = 0;
  for (LitheIndex i = op->side_off[cell]; i < op->side_off[cell + 1]; i++) {
    const LthDgFace *face = op->faces + op->sides[i].face;
    double share = 1 - face->weight[op->sides[i].side];
    sum += share * share * traction_jump(op, face, def->x);
  }
  return face_scale(op, cell) * sum;
}

/// int |P n|^2 over the boundary that no constraint holds, or only its free components.
static double free_traction(const LthDgOperator *op, LitheIndex cell, const CellStress *s) {
  const LthMesh *mesh = op->space->mesh;
  int nb = lth_dg_funcs(op->space, cell);
  double T[3 * LTH_DG_MAX_LOWER], sum = 0;
  for (LitheIndex k = mesh->cell_face_off[cell]; k < mesh->cell_face_off[cell + 1]; k++) {
    LitheIndex f = mesh->cell_face[k];
    double mass[LTH_DG_MAX_FUNCS * LTH_DG_MAX_FUNCS];
    LthFaceView view = lth_mesh_face(mesh, f);
    if (mesh->face_cell[2 * f + 1] >= 0) continue;
    memset(mass, 0, sizeof *mass * (size_t)(nb * nb));
    lth_dg_add_face_mass(op->space, cell, &view, mesh->face_centroid + 3 * (LitheCount)f, mass);
    tractions(s, mesh->face_normal + 3 * (LitheCount)f, T);
    sum += square(s->n, T, mass, nb);
  }
  for (LitheIndex h = op->hold_off[cell]; h < op->hold_off[cell + 1]; h++)
    for (LitheIndex g = 0; g < op->holds[h].n_groups; g++) {
      const LthDgGroup *group = op->groups + op->holds[h].first_group + g;
      double held[3 * LTH_DG_MAX_LOWER];
      tractions(s, group->normal, T);
      for (int l = 0; l < s->n; l++) lth_m3_apply(op->holds[h].P, T + 3 * l, held + 3 * l);
      sum -= square(s->n, held, op->group_data + group->table, nb);
    }
  return sum;
}

/// Sums over loaded boundary: int |t|^2 - 2 t . P n per element.
typedef struct LoadSums {
  const LthDgEstimateDef *def;
  double *sum; ///< (n_cells)
} LoadSums;

static void add_loaded(void *self, LitheIndex cell, const double *normal, const double at[3],
                       double weight, const double force[3], const double later[3]) {
  const LoadSums *sums = self;
  CellStress s;
  double phi[LTH_DG_MAX_FUNCS], T[3 * LTH_DG_MAX_LOWER], r[3] = {0};
  cell_stress(sums->def->op, cell, sums->def->x, &s);
  tractions(&s, normal, T);
  lth_dg_eval(sums->def->op->space, cell, at, phi);
  for (int l = 0; l < s.n; l++) lth_v3_axpy(-2 * phi[l], T + 3 * l, r);
  lth_v3_axpy(1, force, r);
  lth_v3_axpy(2, later, r);
  sums->sum[cell] += weight * lth_v3_dot(force, r);
}

/// Twice the penalty's energy; a face's is shared by its two sides.
static double jumps_part(const LthDgEstimateDef *def, LitheIndex cell) {
  const LthDgOperator *op = def->op;
  double sum = 0;
  for (LitheIndex i = op->side_off[cell]; i < op->side_off[cell + 1]; i++)
    sum += lth_dg_face_penalty_energy(op, op->faces + op->sides[i].face, def->x);
  for (LitheIndex h = op->hold_off[cell]; h < op->hold_off[cell + 1]; h++)
    sum += 2 * lth_dg_hold_penalty_energy(op, op->holds + h, def->t, def->x);
  return fmax(sum, 0);
}

static void estimate_cell(const LthDgEstimateDef *def, LitheIndex cell, const double *force,
                          double loaded, double *parts) {
  CellStress s;
  if (is_held(def->op, cell)) return;
  cell_stress(def->op, cell, def->x, &s);
  parts[LTH_ESTIMATE_VOLUME] = volume_part(def, cell, &s, force);
  parts[LTH_ESTIMATE_FACES] = faces_part(def, cell);
  // rounding may leave less than nothing where traction and load are the same
  parts[LTH_ESTIMATE_BOUNDARY] =
      face_scale(def->op, cell) * fmax(free_traction(def->op, cell, &s) + loaded, 0);
  parts[LTH_ESTIMATE_JUMPS] = jumps_part(def, cell);
}

LitheStatus lth_dg_estimate(LitheCtx *ctx, const LthDgEstimateDef *def, double *parts) {
  LitheStatus status = LITHE_OK;
  const LthDgSpace *space = def->op->space;
  double *force = NULL, *loaded = NULL;
  LTH_NEW_OR(done, ctx, force, space->n_dofs);
  LTH_NEW_OR(done, ctx, loaded, space->n_cells);
  LoadSums sums = {def, loaded};
  for (LitheIndex l = 0; l < def->n_loads; l++)
    if (def->loads[l].kind == LTH_LOAD_BODY_FORCE)
      LITHE_TRY_OR(done, lth_dg_add_load(ctx, space, def->loads + l, def->t, def->x, force));
  LITHE_TRY_OR(done, lth_dg_visit_tractions(ctx, space, def->n_loads, def->loads, def->t, def->x,
                                            add_loaded, &sums));
  memset(parts, 0, sizeof *parts * LTH_ESTIMATE_PARTS * (size_t)space->n_cells);
#pragma omp parallel for schedule(static) num_threads(lth_dg_threads(def->op))
  for (LitheIndex c = 0; c < space->n_cells; c++)
    estimate_cell(def, c, force, loaded[c], parts + LTH_ESTIMATE_PARTS * (LitheCount)c);
done:
  lth_free(ctx, force);
  lth_free(ctx, loaded);
  return status;
}

/// Squared mean of the gradient of R^T x - X that the functions first ... last - 1 of a cell have.
static double gradient_square(const LthDgOperator *op, LitheIndex cell, const double *x, int first,
                              int last) {
  int nb = lth_dg_funcs(op->space, cell), nl = lth_dg_lower(op->space, cell);
  const double *slope = lth_dg_slope(op, cell);
  const double *xc = x + 3 * (LitheCount)op->space->func_off[cell];
  double sum = 0;
  for (int l = 0; l < nl; l++) {
    double F[9] = {0}, Rt[9], H[9];
    for (int j = first; j < last; j++)
      for (int i = 0; i < 9; i++) F[i] += slope[(i % 3 * nb + j) * nl + l] * xc[3 * j + i / 3];
    lth_m3_transpose(op->rotation + 9 * (LitheCount)cell, Rt);
    lth_m3_mul(Rt, F, H);
    for (int i = 0; first == 1 && l == 0 && i < 9; i += 4) H[i] -= 1;
    for (int i = 0; i < 9; i++) sum += H[i] * H[i];
  }
  return sum;
}

double lth_dg_roughness(const LthDgOperator *op, LitheIndex cell, const double *x) {
  int k = op->space->degree[cell];
  if (k == 1) return 0;
  double top = gradient_square(op, cell, x, lth_monomials3(k - 1), lth_monomials3(k)),
         below = gradient_square(op, cell, x, lth_monomials3(k - 2), lth_monomials3(k - 1));
  return below > 0 ? sqrt(top / below) : 0;
}
