/// Loads as vectors of coefficients: exactly where they are constant, by quadrature where they vary.
#include "disc/dg/dg_load.h"

#include "disc/dg/dg_priv.h"
#include "geometry/quadrature.h"

/// What a quadrature over a piece of boundary or a cell adds to.
typedef struct LoadTarget {
  const LthDgSpace *space;
  const LthLoad *load;
  LitheIndex cell;
  const double *normal; ///< NULL in the volume
  const double *x;      ///< position, for followers
  double t, factor;     ///< factor: 1, or 1 / area of a total force
  double *f;            ///< of the cell (nb x 3)
} LoadTarget;

/// cof F n = det F F^-T n: what the area vector becomes.
static void deformed_normal(const double F[9], const double n[3], double r[3]) {
  double C[9];
  lth_m3_cofactor(F, C);
  lth_m3_apply(C, n, r);
}

/// Density of what acts, whatever the boundary holds.
static void whole_density(const LoadTarget *target, const double at[3], double force[3]) {
  const LthLoad *load = target->load;
  double n[3];
  switch (load->kind) {
  case LTH_LOAD_TRACTION:
  case LTH_LOAD_TOTAL_FORCE:
  case LTH_LOAD_BODY_FORCE:
  case LTH_LOAD_POINT_FORCE: // never come here
    for (int a = 0; a < 3; a++)
      force[a] = target->factor * lth_value_at(&load->value[a], at, target->t);
    break;
  case LTH_LOAD_PRESSURE:
    lth_v3_copy(target->normal, n);
    if (load->follower) {
      double F[9];
      lth_dg_sample_gradient(target->space, target->cell, target->x, at, F);
      deformed_normal(F, target->normal, n);
    }
    for (int a = 0; a < 3; a++) force[a] = -lth_value_at(&load->value[0], at, target->t) * n[a];
    break;
  case LTH_LOAD_STRESS:
    for (int a = 0; a < 3; a++) {
      force[a] = 0;
      for (int b = 0; b < 3; b++)
        force[a] += lth_value_at(&load->stress[3 * a + b], at, target->t) * target->normal[b];
    }
    break;
  }
}

/// Force density at a point.
static void density_at(const LoadTarget *target, const double at[3], double force[3]) {
  whole_density(target, at, force);
  if (target->normal) lth_load_release(target->load, target->normal, force);
}

static bool is_constant(const LthLoad *load) {
  if (load->kind == LTH_LOAD_STRESS) {
    for (int i = 0; i < 9; i++)
      if (load->stress[i].eval) return false;
    return true;
  }
  if (load->kind == LTH_LOAD_PRESSURE) return !load->value[0].eval && !load->follower;
  return !load->value[0].eval && !load->value[1].eval && !load->value[2].eval;
}

/// f_i += weight force(at) phi_i(at)
static void add_point(void *self, const double at[3], double weight) {
  const LoadTarget *target = self;
  double phi[LTH_DG_MAX_FUNCS], force[3];
  lth_dg_eval(target->space, target->cell, at, phi);
  density_at(target, at, force);
  int nb = lth_dg_funcs(target->space, target->cell);
  for (int i = 0; i < nb; i++) lth_v3_axpy(weight * phi[i], force, target->f + 3 * i);
}

/// The signed triangles of a piece of boundary.
static void visit_piece(const LthFaceView *piece, const LthSimplexRule *rule, LthDgPointFn visit,
                        void *self) {
  LitheIndex t[3];
  for (LthFan fan = lth_fan(piece); lth_fan_next(&fan, t);) {
    const double *corner[3];
    double u[3], v[3], w[3];
    for (int i = 0; i < 3; i++) corner[i] = piece->points + 3 * (LitheCount)t[i];
    lth_v3_sub(corner[1], corner[0], u);
    lth_v3_sub(corner[2], corner[0], v);
    lth_v3_cross(u, v, w);
    double area = 0.5 * lth_v3_dot(w, piece->normal);
    for (int q = 0; area != 0 && q < lth_simplex_rule_points(rule); q++) {
      double bary[4], at[3] = {0};
      double weight = lth_simplex_rule_point(rule, q, bary);
      for (int c = 0; c < 3; c++) lth_v3_axpy(bary[c], corner[c], at);
      visit(self, at, area * weight);
    }
  }
}

/// The whole force of a constant density: int phi_i over the piece is exact.
static void add_constant(LoadTarget *target, const LthFaceView *piece, const double centroid[3]) {
  double mean[LTH_DG_MAX_FUNCS] = {0}, force[3];
  density_at(target, centroid, force);
  lth_dg_add_face_mean(target->space, target->cell, piece, centroid, mean);
  int nb = lth_dg_funcs(target->space, target->cell);
  for (int i = 0; i < nb; i++) lth_v3_axpy(mean[i], force, target->f + 3 * i);
}

/// cof F has degree 2 (k - 1), a varying density is taken as of degree k + 2.
static int load_degree(const LthDgSpace *space, const LthLoad *load) {
  int k = space->max_degree, smooth = 2 * k + 2;
  return load->follower && 3 * k > smooth ? 3 * k : smooth;
}

/// A total force over the area that it is spread on.
static LitheStatus spread_total(LitheCtx *ctx, LoadTarget *target) {
  const LthPatches *patches = target->load->patches;
  double area = target->load->area;
  if (target->load->kind != LTH_LOAD_TOTAL_FORCE) return LITHE_OK;
  for (LitheIndex p = 0; p < patches->n && target->load->area == 0; p++) area += patches->area[p];
  if (!(area > 0))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "total_force: the selection has no area; choose a `where` that selects boundary");
  target->factor = 1 / area;
  return LITHE_OK;
}

static LitheStatus add_boundary(LitheCtx *ctx, LoadTarget *target, double *f) {
  const LthPatches *patches = target->load->patches;
  const LthMesh *mesh = target->space->mesh;
  LthSimplexRule rule;
  LITHE_TRY(lth_simplex_rule(ctx, 2, load_degree(target->space, target->load), &rule));
  LITHE_TRY(spread_total(ctx, target));
  bool constant = is_constant(target->load);
  for (LitheIndex p = 0; p < patches->n; p++) {
    LitheIndex face = patches->face[p];
    LthFaceView view = lth_patches_view(mesh, patches, p);
    target->cell = mesh->face_cell[2 * face];
    target->normal = mesh->face_normal + 3 * (LitheCount)face;
    target->f = f + 3 * (LitheCount)target->space->func_off[target->cell];
    if (constant)
      add_constant(target, &view, patches->centroid + 3 * (LitheCount)p);
    else
      visit_piece(&view, &rule, add_point, target);
  }
  return LITHE_OK;
}

static LitheStatus add_volume(LitheCtx *ctx, const LoadTarget *target, double *f) {
  const LthDgSpace *space = target->space;
  const LthMesh *mesh = space->mesh;
  LthSimplexRule rule;
  LITHE_TRY(lth_simplex_rule(ctx, 3, load_degree(space, target->load), &rule));
  bool constant = is_constant(target->load);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex c = 0; c < space->n_cells; c++) {
    LoadTarget cell = *target;
    cell.cell = c;
    cell.f = f + 3 * (LitheCount)space->func_off[c];
    if (constant) { // phi_i has no mean for i > 0
      double force[3];
      density_at(&cell, space->center + 3 * (LitheCount)c, force);
      lth_v3_axpy(mesh->cell_volume[c], force, cell.f);
      continue;
    }
    lth_dg_visit_cell(&rule, mesh, c, add_point, &cell);
  }
  return LITHE_OK;
}

LitheStatus lth_dg_add_load(LitheCtx *ctx, const LthDgSpace *space, const LthLoad *load, double t,
                            const double *x, double *f) {
  LoadTarget target = {.space = space, .load = load, .x = x, .t = t, .factor = 1};
  if (load->kind == LTH_LOAD_BODY_FORCE) return add_volume(ctx, &target, f);
  return add_boundary(ctx, &target, f);
}

/// Pieces of a load by face: the first one, and the one after each; -1: none.
typedef struct PieceList {
  LitheIndex *first, *next;
} PieceList;

/// A visit of all loads on boundary: where it is, and what of others acts there as well.
typedef struct TractionVisit {
  const LoadTarget *targets; ///< one a load
  const PieceList *lists;
  LitheIndex load, n_loads, face;
  LthDgTractionFn visit;
  void *self;
} TractionVisit;

static LitheStatus list_pieces(LitheCtx *ctx, const LthMesh *mesh, const LthPatches *patches,
                               PieceList *list) {
  LTH_NEW(ctx, list->first, mesh->n_faces);
  LTH_NEW(ctx, list->next, patches->n);
  for (LitheIndex f = 0; f < mesh->n_faces; f++) list->first[f] = -1;
  for (LitheIndex p = patches->n - 1; p >= 0; p--) {
    list->next[p] = list->first[patches->face[p]];
    list->first[patches->face[p]] = p;
  }
  return LITHE_OK;
}

/// Whether a piece holds a point of its plane: its triangles count with their signs.
static bool holds(const LthFaceView *piece, const double at[3]) {
  LitheIndex t[3];
  int count = 0;
  for (LthFan fan = lth_fan(piece); lth_fan_next(&fan, t);) {
    int n_left = 0;
    for (int i = 0; i < 3; i++) {
      double u[3], v[3], w[3];
      lth_v3_sub(piece->points + 3 * (LitheCount)t[(i + 1) % 3],
                 piece->points + 3 * (LitheCount)t[i], u);
      lth_v3_sub(at, piece->points + 3 * (LitheCount)t[i], v);
      lth_v3_cross(u, v, w);
      n_left += lth_v3_dot(w, piece->normal) > 0;
    }
    count += n_left == 3 ? 1 : n_left == 0 ? -1 : 0;
  }
  return count > 0;
}

static void visit_traction(void *self, const double at[3], double weight) {
  const TractionVisit *v = self;
  const LoadTarget *target = v->targets + v->load;
  double force[3], later[3] = {0};
  density_at(target, at, force);
  for (LitheIndex l = v->load + 1; l < v->n_loads; l++) {
    if (!v->lists[l].first) continue;
    for (LitheIndex p = v->lists[l].first[v->face]; p >= 0; p = v->lists[l].next[p]) {
      LthFaceView view = lth_patches_view(target->space->mesh, v->targets[l].load->patches, p);
      LoadTarget other = v->targets[l];
      double more[3];
      if (!holds(&view, at)) continue;
      other.cell = target->cell, other.normal = target->normal;
      density_at(&other, at, more);
      lth_v3_add(later, more, later);
      break;
    }
  }
  v->visit(v->self, target->cell, target->normal, at, weight, force, later);
}

static LitheStatus visit_loads(LitheCtx *ctx, LoadTarget *targets, TractionVisit *v) {
  const LthMesh *mesh = targets->space->mesh;
  for (v->load = 0; v->load < v->n_loads; v->load++) {
    LoadTarget *target = targets + v->load;
    const LthPatches *patches = target->load->patches;
    LthSimplexRule rule;
    if (!patches) continue;
    LITHE_TRY(lth_simplex_rule(ctx, 2, load_degree(target->space, target->load), &rule));
    for (LitheIndex p = 0; p < patches->n; p++) {
      LthFaceView view = lth_patches_view(mesh, patches, p);
      v->face = patches->face[p];
      target->cell = mesh->face_cell[2 * v->face];
      target->normal = mesh->face_normal + 3 * (LitheCount)v->face;
      visit_piece(&view, &rule, visit_traction, v);
    }
  }
  return LITHE_OK;
}

LitheStatus lth_dg_visit_tractions(LitheCtx *ctx, const LthDgSpace *space, LitheIndex n_loads,
                                   const LthLoad *loads, double t, const double *x,
                                   LthDgTractionFn visit, void *self) {
  LitheStatus status = LITHE_OK;
  LoadTarget *targets = NULL;
  PieceList *lists = NULL;
  LTH_NEW_OR(done, ctx, targets, n_loads);
  LTH_NEW_OR(done, ctx, lists, n_loads);
  for (LitheIndex l = 0; l < n_loads; l++) {
    targets[l] = (LoadTarget){.space = space, .load = loads + l, .x = x, .t = t, .factor = 1};
    if (!loads[l].patches) continue;
    LITHE_TRY_OR(done, spread_total(ctx, targets + l));
    LITHE_TRY_OR(done, list_pieces(ctx, space->mesh, loads[l].patches, lists + l));
  }
  TractionVisit v = {targets, lists, 0, n_loads, 0, visit, self};
  if (n_loads > 0) LITHE_TRY_OR(done, visit_loads(ctx, targets, &v));
done:
  for (LitheIndex l = 0; lists && l < n_loads; l++) {
    lth_free(ctx, lists[l].first);
    lth_free(ctx, lists[l].next);
  }
  lth_free(ctx, lists);
  lth_free(ctx, targets);
  return status;
}

void lth_dg_add_gravity(const LthDgSpace *space, const double *density, const double gravity[3],
                        double *f) {
  for (LitheIndex c = 0; c < space->n_cells; c++)
    lth_v3_axpy(density[c] * space->mesh->cell_volume[c], gravity,
                f + 3 * (LitheCount)space->func_off[c]);
}

void lth_dg_mass(const LthDgSpace *space, const double *density, double *mass) {
  for (LitheIndex c = 0; c < space->n_cells; c++)
    for (LitheIndex i = space->func_off[c]; i < space->func_off[c + 1]; i++)
      mass[i] = density[c] * space->mesh->cell_volume[c];
}
