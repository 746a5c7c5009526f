/// Loads as forces on nodes: integrals of the shape functions over boundary pieces and elements.
#include "disc/cg/cg_priv.h"

typedef struct LoadTarget {
  const LthCgDisc *d;
  const LthLoad *load;
  double t, factor, area; ///< factor: 1, or 1 / area of a total force
  const double *x;
  double *f;
} LoadTarget;

static void stress_traction(const LthLoad *load, const double at[3], double t, const double n[3],
                            double force[3]) {
  for (int a = 0; a < 3; a++) {
    force[a] = 0;
    for (int b = 0; b < 3; b++) force[a] += lth_value_at(&load->stress[3 * a + b], at, t) * n[b];
  }
}

/// Area vector after deformation: cof F n dA (Nanson).
static void follow(const LoadTarget *target, const LthCgPoint *point, double area[3]) {
  double before[3] = {area[0], area[1], area[2]};
  const LthCgDisc *d = target->d;
  const LitheIndex *node = lth_cg_nodes(d, point->element);
  double F[9] = {0}, C[9];
  for (int i = 0; i < lth_cg_kind(d, point->element)->n; i++)
    for (int k = 0; k < 9; k++)
      F[k] += target->x[3 * (LitheCount)node[i] + k / 3] * point->dphi[3 * i + k % 3];
  lth_m3_cofactor(F, C);
  lth_m3_apply(C, before, area);
}

/// Force on a boundary point, its weight included.
static void point_force(const LoadTarget *target, const LthCgPoint *point, double force[3]) {
  const LthLoad *load = target->load;
  double area[3];
  lth_v3_copy(point->normal, area);
  lth_v3_scale(point->weight, area);
  if (load->kind == LTH_LOAD_STRESS) {
    stress_traction(load, point->at, target->t, area, force);
  } else if (load->kind == LTH_LOAD_PRESSURE) {
    if (load->follower) follow(target, point, area);
    double pressure = lth_value_at(&load->value[0], point->at, target->t);
    for (int a = 0; a < 3; a++) force[a] = -pressure * area[a];
  } else {
    double weight = target->factor * point->weight;
    for (int a = 0; a < 3; a++)
      force[a] = weight * lth_value_at(&load->value[a], point->at, target->t);
  }
  lth_load_release(load, point->normal, force);
}

static void add_point(void *self, const LthCgPoint *point) {
  LoadTarget *target = self;
  const LitheIndex *node = lth_cg_nodes(target->d, point->element);
  double force[3];
  point_force(target, point, force);
  for (int i = 0; i < lth_cg_kind(target->d, point->element)->n; i++)
    lth_v3_axpy(point->phi[i], force, target->f + 3 * (LitheCount)node[i]);
}

static void add_area(void *self, const LthCgPoint *point) {
  ((LoadTarget *)self)->area += point->weight;
}

static LitheStatus add_boundary(LitheCtx *ctx, LoadTarget *target) {
  const LthPatches *patches = target->load->patches;
  if (target->load->kind == LTH_LOAD_TOTAL_FORCE) {
    target->area = target->load->area;
    for (LitheIndex i = 0; i < patches->n && target->load->area == 0; i++)
      lth_cg_visit_patch(target->d, patches, i, add_area, target);
    if (!(target->area > 0))
      LITHE_FAIL(ctx, LITHE_BAD_INPUT,
                 "total_force: the selection has no area; choose a `where` that selects boundary");
    target->factor = 1 / target->area;
  }
  for (LitheIndex i = 0; i < patches->n; i++)
    lth_cg_visit_patch(target->d, patches, i, add_point, target);
  return LITHE_OK;
}

/// Nodal forces of one element (n x 3) from a body force by the rule of the mass.
static void element_forces(const LoadTarget *target, LitheIndex e, const LthCgRule *rule,
                           double *f) {
  const LthCgDisc *d = target->d;
  int n = lth_cg_kind(d, e)->n;
  memset(f, 0, sizeof *f * 3 * (size_t)n);
  for (int q = 0; q < rule->n; q++) {
    double X[3], J[9], phi[LTH_CG_MAX], dphi[3 * LTH_CG_MAX], force[3];
    lth_cg_map(d, e, rule->xi[q], X, J, phi, dphi);
    for (int a = 0; a < 3; a++) force[a] = lth_value_at(&target->load->value[a], X, target->t);
    double w = rule->weight[q] * lth_m3_det(J) * d->fill[e];
    for (int i = 0; i < n; i++) lth_v3_axpy(w * phi[i], force, f + 3 * i);
  }
}

static void add_volume(const LoadTarget *target) {
  const LthCgDisc *d = target->d;
  LthCgRule rule = {0};
  int of = -1;
  for (LitheIndex e = 0; e < d->elements->n_elements; e++) {
    double f[3 * LTH_CG_MAX];
    if (d->elements->kind[e] != of) {
      of = d->elements->kind[e];
      lth_cg_mass_rule((LthElementKind)of, &rule);
    }
    element_forces(target, e, &rule, f);
    const LitheIndex *node = lth_cg_nodes(d, e);
    for (int i = 0; i < lth_cg_kind(d, e)->n; i++)
      lth_v3_axpy(1, f + 3 * i, target->f + 3 * (LitheCount)node[i]);
  }
}

LitheStatus lth_cg_add_load(LitheCtx *ctx, const LthDisc *disc, const LthLoad *load, double t,
                            const double *x, double *f) {
  LoadTarget target = {.d = lth_cg_of(disc), .load = load, .t = t, .factor = 1, .x = x, .f = f};
  if (load->kind != LTH_LOAD_BODY_FORCE) return add_boundary(ctx, &target);
  add_volume(&target);
  return LITHE_OK;
}

void lth_cg_add_gravity(const LthDisc *disc, const double gravity[3], double *f) {
  const LthCgDisc *d = lth_cg_of(disc);
#pragma omp parallel for schedule(static) num_threads(lth_cg_threads(d))
  for (LitheIndex row = 0; row < disc->n_rows; row++)
    for (LitheIndex k = d->node_off[row]; k < d->node_off[row + 1]; k++) {
      LitheIndex e = d->node_element[k];
      const double *load = lth_cg_tables(d, d->class_of[e]).load;
      lth_v3_axpy(d->density[e] * load[d->node_local[k]], gravity, f + 3 * (LitheCount)row);
    }
}
