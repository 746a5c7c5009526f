/// Building and freeing the conforming discretisation, and its table.
#include "disc/cg/cg_priv.h"

#include "material/material.h"

static void get_rest(const LthDisc *disc, double *x0) {
  const LthElementMesh *m = lth_cg_of(disc)->elements;
  memcpy(x0, m->nodes, sizeof *x0 * 3 * (size_t)m->n_nodes);
}

static void get_one(const LthDisc *disc, double *one) {
  for (LitheIndex i = 0; i < disc->n_funcs; i++) one[i] = 1;
}

/// Interpolation at the nodes.
static LitheStatus project(LitheCtx *ctx, const LthDisc *disc,
                           void (*field)(const void *self, const double x[3], double value[3]),
                           const void *self, double *coef) {
  const LthCgDisc *d = lth_cg_of(disc);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex i = 0; i < disc->n_funcs; i++)
    field(self, lth_cg_node(d, i), coef + 3 * (LitheCount)i);
  return LITHE_OK;
}

static void destroy(LitheCtx *ctx, LthDisc *disc) {
  LthCgDisc *d = disc->self;
  void *blocks[] = {d->cell_lambda,
                    d->cell_mu,
                    d->lambda,
                    d->mu,
                    d->density,
                    d->fill,
                    d->rotation,
                    d->classes,
                    d->class_of,
                    d->exact,
                    d->tables,
                    d->node_off,
                    d->node_element,
                    d->node_local,
                    d->block_off,
                    d->block_col,
                    d->slot_off,
                    d->slot,
                    d->order,
                    d->face,
                    d->row_func,
                    d->degree,
                    d->weak,
                    d->hold_off,
                    d->holds,
                    d->hold_data,
                    d->hold_matrix_off,
                    d->hold_matrix,
                    d->hold_load,
                    d->partial,
                    d};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
}

static const LthDiscTable table = {.name = "cg",
                                   .eval = lth_cg_eval,
                                   .eval_gradient = lth_cg_eval_gradient,
                                   .mean_gradient = lth_cg_mean_gradient,
                                   .rest = get_rest,
                                   .one = get_one,
                                   .project = project,
                                   .matrix_create = lth_cg_matrix_create,
                                   .update_rotations = lth_cg_update_rotations,
                                   .assemble = lth_cg_assemble,
                                   .assemble_load = lth_cg_assemble_load,
                                   .energy = lth_cg_energy,
                                   .add_mass = lth_cg_add_mass,
                                   .apply_mass = lth_cg_apply_mass,
                                   .mass_diagonal = lth_cg_mass_diagonal,
                                   .add_load = lth_cg_add_load,
                                   .add_gravity = lth_cg_add_gravity,
                                   .reactions = lth_cg_reactions,
                                   .stress = lth_cg_stress,
                                   .destroy = destroy};

static LitheStatus check_def(LitheCtx *ctx, const LthCgDef *def) {
  const LthElementMesh *m = def->elements;
  if (!def->cell_element && def->mesh->n_cells != m->n_elements)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "cg: %d elements, but %d cells", m->n_elements,
               def->mesh->n_cells);
  for (LitheIndex e = 0; e < m->n_elements; e++)
    if (m->kind[e] == LTH_POLYHEDRON)
      LITHE_FAIL(ctx, LITHE_BAD_INPUT,
                 "element %lld is a polyhedron, which conforming elements cannot be; expected "
                 "tetrahedra, hexahedra, wedges or pyramids; use `method.kind: dg`",
                 (long long)(m->element_id ? m->element_id[e] : e + 1));
  for (LitheIndex c = 0; c < def->mesh->n_cells; c++) {
    double E = def->young[c], nu = def->poisson[c];
    if (!(E > 0) || !isfinite(E))
      LITHE_FAIL(ctx, LITHE_BAD_INPUT,
                 "element %d: Young's modulus must be a positive number of Pa, got %g", c, E);
    if (!(nu > -1 && nu < 0.5))
      LITHE_FAIL(ctx, LITHE_BAD_INPUT,
                 "element %d: Poisson's ratio must lie between -1 and 0.5 (excluded), got %g", c,
                 nu);
  }
  return LITHE_OK;
}

/// Kinds that occur, and the rules of their faces.
static void prepare_kinds(LthCgDisc *d) {
  for (LitheIndex e = 0; e < d->elements->n_elements; e++) {
    LthElementKind kind = d->elements->kind[e];
    if (!d->kind[kind].shape) lth_cg_kind_init(kind, &d->kind[kind]);
  }
  for (int degree = 1; degree <= 2; degree++)
    for (int corners = 3; corners <= 4; corners++)
      lth_cg_plane_rule(corners, degree + 2, &d->plane[degree - 1][corners - 3]);
  for (int order = 1; order <= 2; order++) lth_cg_plane_rule(3, order, &d->small[order - 1]);
}

static LitheStatus copy_weak(LitheCtx *ctx, const LthCgDef *def, LthCgDisc *d) {
  LTH_NEW(ctx, d->weak, def->n_weak);
  for (LitheIndex w = 0; w < def->n_weak; w++) d->weak[w] = def->weak[w];
  d->disc.n_weak = def->n_weak;
  d->disc.weak = d->weak;
  return LITHE_OK;
}

static LitheStatus allocate(LitheCtx *ctx, LthCgDisc *d) {
  LitheIndex n_cells = d->disc.mesh->n_cells, n = d->elements->n_elements;
  LTH_NEW(ctx, d->cell_lambda, n_cells);
  LTH_NEW(ctx, d->cell_mu, n_cells);
  LTH_NEW(ctx, d->degree, n_cells);
  LTH_NEW(ctx, d->lambda, n);
  LTH_NEW(ctx, d->mu, n);
  LTH_NEW(ctx, d->density, n);
  LTH_NEW(ctx, d->fill, n);
  LTH_NEW(ctx, d->rotation, 9 * (LitheCount)n);
  LTH_NEW(ctx, d->exact, n);
  LTH_NEW(ctx, d->partial, n);
  LTH_NEW(ctx, d->hold_off, n + 1);
  LTH_NEW(ctx, d->row_func, d->elements->n_nodes + 1);
  return LITHE_OK;
}

/// What elements count with: the constants of their cell, or the mean of those of several by volume, the
/// rest of the element being empty.
static LitheStatus set_materials(LitheCtx *ctx, const LthCgDef *def, LthCgDisc *d) {
  const LthMesh *mesh = def->mesh;
  for (LitheIndex c = 0; c < mesh->n_cells; c++) {
    LitheIndex e = lth_cg_element(d, c);
    double share = 1;
    if (d->cell_element) share = mesh->cell_volume[c] / d->classes[d->class_of[e]].volume_exact;
    lth_lame(def->young[c], def->poisson[c], &d->cell_lambda[c], &d->cell_mu[c]);
    d->lambda[e] += share * d->cell_lambda[c];
    d->mu[e] += share * d->cell_mu[c];
    d->density[e] += share * def->density[c];
    d->fill[e] += share;
    d->degree[c] = (uint8_t)lth_cg_kind(d, e)->shape->degree;
  }
  for (LitheIndex e = 0; e < d->elements->n_elements; e++)
    if (!(d->fill[e] > 0)) LITHE_FAIL(ctx, LITHE_BAD_INPUT, "cg: element %d holds no cell", e);
  return LITHE_OK;
}

static LitheStatus build(LitheCtx *ctx, const LthCgDef *def, LthCgDisc *d) {
  LitheIndex n_nodes = def->elements->n_nodes;
  d->ctx = ctx;
  d->elements = def->elements;
  d->cell_element = def->cell_element;
  d->warped = def->warped;
  d->disc.table = &table;
  d->disc.mesh = def->mesh;
  d->disc.n_cells = def->mesh->n_cells;
  d->disc.self = d;
  LITHE_TRY(check_def(ctx, def));
  LITHE_TRY(allocate(ctx, d));
  prepare_kinds(d);
  d->disc.n_funcs = d->disc.n_rows = n_nodes;
  d->disc.n_dofs = 3 * (LitheCount)n_nodes;
  for (LitheIndex i = 0; i <= n_nodes; i++) d->row_func[i] = i;
  d->disc.row_func = d->row_func;
  d->disc.cell_degree = d->degree;
  LITHE_TRY(copy_weak(ctx, def, d));
  LITHE_TRY(lth_cg_build_rows(ctx, d));
  LITHE_TRY(lth_cg_build_faces(ctx, d));
  lth_cg_find_held(d);
  LITHE_TRY(lth_cg_build_classes(ctx, d));
  LITHE_TRY(set_materials(ctx, def, d));
  LITHE_TRY(lth_cg_build_holds(ctx, d));
  lth_cg_update_rotations(&d->disc, NULL);
  return LITHE_OK;
}

LitheStatus lth_cg_disc_create(LitheCtx *ctx, const LthCgDef *def, LthDisc **disc) {
  LthCgDisc *d = NULL;
  *disc = NULL;
  LTH_NEW(ctx, d, 1);
  *disc = &d->disc;
  LitheStatus status = build(ctx, def, d);
  if (status != LITHE_OK) lth_disc_destroy(ctx, disc);
  return status;
}
