/// Springs between two surfaces: points of the finer one follow the nearest cell of the other.
///
/// A point is evaluated in both bodies at its own place, the other's functions carried on across the gap: so it
/// starts unstretched, and its two forces act in one point and keep both momenta, however the bodies turn.
#include "base/tensor.h"
#include "couple/tie_priv.h"
#include "material/material.h"

#include <stdlib.h>

#define FACING -0.5 ///< largest cosine between the normals of tied surfaces
#define STIFFNESS                                                                                  \
  50 ///< over that of the softer layer of cells: each tie yields like a fiftieth of it

typedef struct Spring {
  LitheIndex cell[2];
  double x[3], stiffness; ///< [m], [N/m]
} Spring;

typedef struct TieSprings {
  Spring *spring;
  LitheIndex n;
  LitheCount cap;
  LitheIndex *row_of[2]; ///< block row of the body of each function         (n_funcs of a body)
  LitheIndex *local[2];  ///< row of the matrix of each row of a body, -1    (n_rows of a body)
  LthTieMatrix matrix;
  double *y, *at; ///< scratch                                          (K->n)
} TieSprings;

/// Whether a piece at distance2 from x lies in front of it rather than beside it. Nearest points on an edge are in
/// front where the way to them is within 60 degrees of the normal, or no longer than rounding.
static bool is_in_front(const LthFaceView *view, double area, const double x[3], double distance2) {
  double d[3];
  lth_v3_sub(x, view->points + 3 * (size_t)view->loop_point[view->loop_off[0]], d);
  double height = lth_v3_dot(d, view->normal);
  return distance2 <= fmax(4 * height * height, 1e-12 * area);
}

/// A search for the piece of the other body that faces a point.
typedef struct Seeker {
  const LthTieSide *other;
  const double *normal; ///< NULL: whatever way it faces
} Seeker;

static double piece_distance2(void *self, LitheIndex i, const double x[3], double limit) {
  const Seeker *s = self;
  LthFaceView view = lth_patches_view(s->other->disc->mesh, s->other->patches, i);
  (void)limit;
  if (s->normal && lth_v3_dot(s->normal, view.normal) > FACING) return INFINITY;
  double distance2 = lth_face_distance2(&view, x);
  bool faces = !s->normal || is_in_front(&view, s->other->patches->area[i], x, distance2);
  return faces ? distance2 : INFINITY;
}

/// What the springs of one tie have in common.
typedef struct Job {
  LitheCtx *ctx;
  const LthTieDef *def;
  LthTie *tie;
  TieSprings *out;
  int fine; ///< whose points
  LthBvh *tree;
  double reach, gap;
  int degree;
} Job;

/// Stiffness per area of a layer of cells [Pa/m].
static double layer(const LthTieSide *side, LitheIndex cell) {
  double lambda, mu;
  lth_lame(side->young[cell], side->poisson[cell], &lambda, &mu);
  return (lambda + 2 * mu) / cbrt(side->disc->mesh->cell_volume[cell]);
}

static LitheStatus add_spring(Job *job, LitheIndex piece, const double x[3], const double *normal,
                              double area) {
  const LthTieSide *mine = &job->def->side[job->fine], *other = &job->def->side[1 - job->fine];
  Seeker seeker = {other, NULL};
  double d2 = job->gap * job->gap;
  if (lth_bvh_nearest(job->tree, x, piece_distance2, &seeker, &d2) >= 0) job->gap = sqrt(d2);
  seeker.normal = normal;
  d2 = job->reach * job->reach;
  LitheIndex hit = lth_bvh_nearest(job->tree, x, piece_distance2, &seeker, &d2);
  if (hit < 0) return LITHE_OK;
  TieSprings *t = job->out;
  LTH_RESERVE(job->ctx, t->spring, t->cap, (LitheCount)t->n + 1);
  Spring *s = &t->spring[t->n++];
  s->cell[job->fine] = lth_tie_cell(mine, piece);
  s->cell[1 - job->fine] = lth_tie_cell(other, hit);
  lth_v3_copy(x, s->x);
  s->stiffness = STIFFNESS * area *
                 fmin(layer(mine, s->cell[job->fine]), layer(other, s->cell[1 - job->fine]));
  job->tie->tied[job->fine][piece] = job->tie->tied[1 - job->fine][hit] = 1;
  job->tie->spring_area += area;
  return LITHE_OK;
}

/// Springs of one piece at the points of a rule on its convex parts, where no weight is negative.
static LitheStatus add_piece(Job *job, LitheIndex piece, LthPieces *parts) {
  const LthTieSide *mine = &job->def->side[job->fine];
  LthFaceView view = lth_patches_view(mine->disc->mesh, mine->patches, piece);
  double size = sqrt(mine->patches->area[piece]);
  parts->n = parts->n_loops = parts->n_points = 0;
  LITHE_TRY(lth_convex_parts(job->ctx, &view, 1e-9 * size, parts));
  for (LitheIndex i = 0; i < parts->n; i++) {
    LthFaceView part = lth_pieces_view(parts, i, view.normal);
    LitheIndex n;
    double *points = NULL, *weights = NULL;
    LITHE_TRY(lth_patch_quadrature(job->ctx, &part, job->degree, &n, &points, &weights));
    LitheStatus status = LITHE_OK;
    for (LitheIndex q = 0; q < n && status == LITHE_OK; q++)
      if (weights[q] > 0)
        status = add_spring(job, piece, points + 3 * (size_t)q, view.normal, weights[q]);
    lth_free(job->ctx, points);
    lth_free(job->ctx, weights);
    LITHE_TRY(status);
  }
  return LITHE_OK;
}

static double mean_area(const LthPatches *p) {
  double sum = 0;
  for (LitheIndex i = 0; i < p->n; i++) sum += p->area[i];
  return sum / p->n;
}

static int largest_degree(const LthDisc *disc) {
  int degree = 1;
  for (LitheIndex c = 0; c < disc->mesh->n_cells; c++)
    degree = disc->cell_degree[c] > degree ? disc->cell_degree[c] : degree;
  return degree;
}

static LitheStatus find_springs(Job *job) {
  const LthTieSide *side = job->def->side;
  LthPieces parts = {0};
  LitheStatus status = LITHE_OK;
  job->fine = mean_area(side[0].patches) <= mean_area(side[1].patches) ? 0 : 1;
  int a = largest_degree(side[0].disc), b = largest_degree(side[1].disc);
  job->degree = 2 * (a > b ? a : b);
  job->reach = lth_tie_reach(side);
  job->gap = INFINITY;
  uint8_t *by_faces = NULL; // springs mark pieces, too
  const LthPatches *mine = side[job->fine].patches;
  LTH_NEW_OR(done, job->ctx, by_faces, mine->n);
  memcpy(by_faces, job->tie->tied[job->fine], (size_t)mine->n);
  LITHE_TRY_OR(done, lth_patches_tree(job->ctx, side[1 - job->fine].patches, &job->tree));
  for (LitheIndex i = 0; i < mine->n; i++)
    if (!by_faces[i]) LITHE_TRY_OR(done, add_piece(job, i, &parts));
done:
  lth_free(job->ctx, by_faces);
  lth_pieces_free(job->ctx, &parts);
  lth_bvh_destroy(job->ctx, &job->tree);
  return status;
}

/// Functions of both bodies at a spring with their signed values; returns how many.
static int spring_functions(const LthTieDef *def, const Spring *s, int side[], LitheIndex func[],
                            double value[]) {
  int n = 0;
  for (int k = 0; k < 2; k++) {
    const LthDisc *disc = def->side[k].disc;
    double phi[3 * LTH_DISC_MAX_FUNCS];
    int m = disc->table->eval(disc, s->cell[k], s->x, func + n, phi);
    for (int i = 0; i < m; i++) {
      side[n + i] = k;
      value[n + i] = k == 1 ? -phi[3 * i] : phi[3 * i];
    }
    n += m;
  }
  return n;
}

#define FUNCS_MAX (2 * LTH_DISC_MAX_FUNCS)

/// Block row here of each function of a spring.
static void spring_rows(const TieSprings *t, int n, const int *side, const LitheIndex *func,
                        LitheIndex *row) {
  for (int i = 0; i < n; i++) row[i] = t->local[side[i]][t->row_of[side[i]][func[i]]];
}

static LitheStatus map_functions(LitheCtx *ctx, const LthTieDef *def, TieSprings *t) {
  for (int k = 0; k < 2; k++) {
    const LthDisc *disc = def->side[k].disc;
    LTH_NEW(ctx, t->row_of[k], disc->n_funcs);
    LTH_NEW(ctx, t->local[k], disc->n_rows);
    for (LitheIndex r = 0; r < disc->n_rows; r++) {
      t->local[k][r] = -1;
      for (LitheIndex f = disc->row_func[r]; f < disc->row_func[r + 1]; f++) t->row_of[k][f] = r;
    }
  }
  return LITHE_OK;
}

/// Number the rows that any spring touches, those of the first body first, each body's in order.
static LitheStatus number_rows(LitheCtx *ctx, const LthTieDef *def, TieSprings *t,
                               LitheIndex *n_rows) {
  for (LitheIndex i = 0; i < t->n; i++) {
    int side[FUNCS_MAX];
    LitheIndex func[FUNCS_MAX];
    double value[FUNCS_MAX];
    int n = spring_functions(def, &t->spring[i], side, func, value);
    for (int k = 0; k < n; k++) t->local[side[k]][t->row_of[side[k]][func[k]]] = 0;
  }
  *n_rows = 0;
  for (int k = 0; k < 2; k++)
    for (LitheIndex r = 0; r < def->side[k].disc->n_rows; r++)
      if (t->local[k][r] == 0) t->local[k][r] = (*n_rows)++;
  LTH_NEW(ctx, t->matrix.row, *n_rows);
  LTH_NEW(ctx, t->matrix.dof, *n_rows);
  for (int k = 0; k < 2; k++)
    for (LitheIndex r = 0; r < def->side[k].disc->n_rows; r++) {
      LitheIndex local = t->local[k][r];
      if (local < 0) continue;
      t->matrix.row[local] = def->side[k].first_row + r;
      t->matrix.dof[local] =
          def->side[k].first_dof + 3 * (LitheCount)def->side[k].disc->row_func[r];
    }
  return LITHE_OK;
}

typedef struct Pair {
  LitheIndex row, col;
} Pair;

static int compare_pairs(const void *a, const void *b) {
  const Pair *p = a, *q = b;
  if (p->row != q->row) return p->row < q->row ? -1 : 1;
  return (p->col > q->col) - (p->col < q->col);
}

static LitheIndex keep_distinct(Pair *pairs, LitheIndex n) {
  LitheIndex kept = 0;
  qsort(pairs, (size_t)n, sizeof *pairs, compare_pairs);
  for (LitheIndex i = 0; i < n; i++)
    if (i == 0 || compare_pairs(&pairs[i], &pairs[kept - 1]) != 0) pairs[kept++] = pairs[i];
  return kept;
}

/// All pairs of rows that a spring couples, each with itself, in order.
static LitheStatus list_pairs(LitheCtx *ctx, const LthTieDef *def, const TieSprings *t,
                              Pair **pairs, LitheIndex *n_pairs) {
  LitheCount cap = 0;
  LitheIndex n = 0, sorted = 0;
  for (LitheIndex i = 0; i < t->n; i++) {
    int side[FUNCS_MAX];
    LitheIndex func[FUNCS_MAX], row[FUNCS_MAX];
    double value[FUNCS_MAX];
    int m = spring_functions(def, &t->spring[i], side, func, value);
    spring_rows(t, m, side, func, row);
    LTH_RESERVE(ctx, *pairs, cap, (LitheCount)n + m * m);
    for (int a = 0; a < m; a++)
      for (int b = 0; b < m; b++)
        if ((a == 0 || row[a] != row[a - 1]) && (b == 0 || row[b] != row[b - 1]))
          (*pairs)[n++] = (Pair){row[a], row[b]};
    if (n > 2 * sorted + 100000) n = sorted = keep_distinct(*pairs, n); // bounded memory
  }
  *n_pairs = keep_distinct(*pairs, n);
  return LITHE_OK;
}

static LitheStatus create_matrix(LitheCtx *ctx, const LthTieDef *def, TieSprings *t,
                                 LitheIndex n_rows) {
  LitheStatus status = LITHE_OK;
  Pair *pairs = NULL;
  LitheIndex n_pairs = 0, *col = NULL;
  LitheCount *row_off = NULL, *block_off = NULL;
  LITHE_TRY_OR(done, list_pairs(ctx, def, t, &pairs, &n_pairs));
  LTH_NEW_OR(done, ctx, col, n_pairs);
  LTH_NEW_OR(done, ctx, row_off, (LitheCount)n_rows + 1);
  LTH_NEW_OR(done, ctx, block_off, (LitheCount)n_rows + 1);
  for (LitheIndex i = 0; i < n_pairs; i++) {
    col[i] = pairs[i].col;
    block_off[pairs[i].row + 1] = i + 1;
  }
  for (int k = 0; k < 2; k++) {
    const LthDisc *disc = def->side[k].disc;
    for (LitheIndex r = 0; r < disc->n_rows; r++)
      if (t->local[k][r] >= 0)
        row_off[t->local[k][r] + 1] = 3 * (disc->row_func[r + 1] - disc->row_func[r]);
  }
  for (LitheIndex r = 0; r < n_rows; r++) row_off[r + 1] += row_off[r];
  LITHE_TRY_OR(done, lth_block_matrix_create(ctx, n_rows, row_off, block_off, col, &t->matrix.K));
done:
  lth_free(ctx, pairs);
  lth_free(ctx, col);
  lth_free(ctx, row_off);
  lth_free(ctx, block_off);
  return status;
}

/// K = sum of stiffness (phi_a - phi_b) (phi_a - phi_b)^T x I.
static void fill_matrix(const LthTieDef *def, const TieSprings *t) {
  LthBlockMatrix *K = t->matrix.K;
  for (LitheIndex i = 0; i < t->n; i++) {
    int side[FUNCS_MAX];
    LitheIndex func[FUNCS_MAX], row[FUNCS_MAX], place[FUNCS_MAX];
    double value[FUNCS_MAX];
    int m = spring_functions(def, &t->spring[i], side, func, value);
    spring_rows(t, m, side, func, row);
    for (int a = 0; a < m; a++)
      place[a] = func[a] - def->side[side[a]].disc->row_func[t->row_of[side[a]][func[a]]];
    for (int a = 0; a < m; a++) {
      LitheCount block = -1;
      for (int b = 0; b < m; b++) {
        if (b == 0 || row[b] != row[b - 1]) block = lth_block_matrix_find(K, row[a], row[b]);
        LitheCount n = K->row_off[row[b] + 1] - K->row_off[row[b]];
        double *v = K->values + K->value_off[block], k = t->spring[i].stiffness;
        for (int d = 0; d < 3; d++)
          v[(3 * place[a] + d) * n + 3 * place[b] + d] += k * value[a] * value[b];
      }
    }
  }
}

static void add(void *self, double t, LthBlockMatrix *A, double *f0) {
  const TieSprings *springs = self;
  (void)t, (void)f0; // nothing is stretched at rest
  lth_tie_matrix_add(&springs->matrix, A);
}

static void add_load(void *self, double t, double *f0) { (void)self, (void)t, (void)f0; }

static double energy(void *self, double t, const double *x) {
  const TieSprings *s = self;
  const LthBlockMatrix *K = s->matrix.K;
  double sum = 0;
  (void)t;
  for (LitheIndex r = 0; r < K->n_rows; r++)
    memcpy(s->at + K->row_off[r], x + s->matrix.dof[r],
           sizeof *x * (size_t)(K->row_off[r + 1] - K->row_off[r]));
  lth_block_matrix_apply(K, 1, s->at, s->y);
  for (LitheCount i = 0; i < K->n; i++) sum += 0.5 * s->at[i] * s->y[i];
  return sum;
}

static LitheStatus create(Job *job, LthCoupling *coupling) {
  TieSprings *t = job->out;
  LitheIndex n_rows;
  LITHE_TRY(find_springs(job));
  job->tie->n_springs = t->n;
  if (t->n == 0) return LITHE_OK;
  LITHE_TRY(map_functions(job->ctx, job->def, t));
  LITHE_TRY(number_rows(job->ctx, job->def, t, &n_rows));
  LITHE_TRY(create_matrix(job->ctx, job->def, t, n_rows));
  LTH_NEW(job->ctx, t->y, t->matrix.K->n);
  LTH_NEW(job->ctx, t->at, t->matrix.K->n);
  fill_matrix(job->def, t);
  return lth_tie_matrix_list(job->ctx, &t->matrix, coupling);
}

static void destroy(LitheCtx *ctx, void *self) {
  TieSprings *t = self;
  lth_tie_matrix_free(ctx, &t->matrix);
  for (int k = 0; k < 2; k++) {
    lth_free(ctx, t->row_of[k]);
    lth_free(ctx, t->local[k]);
  }
  lth_free(ctx, t->spring);
  lth_free(ctx, t->y);
  lth_free(ctx, t->at);
  lth_free(ctx, t);
}

LitheStatus lth_tie_springs_create(LitheCtx *ctx, const LthTieDef *def, LthTie *tie,
                                   LthCoupling *coupling, double *gap, double *reach) {
  TieSprings *t = NULL;
  LTH_NEW(ctx, t, 1);
  *coupling = (LthCoupling){
      .self = t, .add = add, .add_load = add_load, .energy = energy, .destroy = destroy};
  Job job = {.ctx = ctx, .def = def, .tie = tie, .out = t};
  LITHE_TRY(create(&job, coupling));
  *gap = job.gap;
  *reach = job.reach;
  if (t->n > 0) return LITHE_OK;
  destroy(ctx, t);
  *coupling = (LthCoupling){0};
  return LITHE_OK;
}
