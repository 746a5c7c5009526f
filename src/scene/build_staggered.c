/// Staggered bodies: shape and resolution -> grid -> fractions -> discretisation.
#include "scene/staggered_body.h"

#include "base/tensor.h"
#include "geometry/fractions_complete.h"

#define CELLS_MAX 1e11  // of the grid, material or not
#define MIXED_FROM 0.45 // Poisson's ratio

/// The grid as the scene asks for it.
typedef struct Frame {
  int dim;
  double origin[3], h[3];
  LitheIndex n[3];
} Frame;

static LitheIndex at_least_one(double cells) {
  if (!(cells > 1)) return 1;
  return cells < 1e9 ? (LitheIndex)cells : 1000000000;
}

static void set_axis(Frame *f, int a, double low, double high, LitheIndex n) {
  f->origin[a] = low;
  f->n[a] = n;
  f->h[a] = (high - low) / n;
}

/// In 2D one layer, 1 m thick, about z = 0.
static void set_thickness(Frame *f) {
  if (f->dim == 3) return;
  f->origin[2] = -0.5;
  f->n[2] = 1;
  f->h[2] = 1;
}

static void frame_by_resolution(const LthResolution *r, const double low[3], const double high[3],
                                Frame *f) {
  double longest = 0;
  for (int a = 0; a < f->dim; a++) longest = fmax(longest, high[a] - low[a]);
  for (int a = 0; a < f->dim; a++) {
    double side = high[a] - low[a];
    LitheIndex n = r->cells[a];
    if (r->cell_size > 0) // rounding of a whole number of cells is forgiven
      n = at_least_one(ceil(side / r->cell_size * (1 - 1e-9)));
    else if (r->cells[1] == 0)
      n = at_least_one(floor(side / longest * r->cells[0] + 0.5));
    set_axis(f, a, low[a], high[a], n);
  }
}

/// The voxel axis along each axis of the scene; false where they do not agree.
static bool match_axes(const LthVolume *v, int dim, int axis[3]) {
  for (int a = 0; a < dim; a++) {
    axis[a] = -1;
    for (int j = 0; j < 3; j++) {
      double off = 0, along = fabs(v->to_world[4 * a + j]);
      for (int i = 0; i < dim; i++)
        if (i != a) off = fmax(off, fabs(v->to_world[4 * i + j]));
      if (along > 0 && off <= 1e-6 * along) axis[a] = j;
    }
    if (axis[a] < 0) return false;
  }
  return true;
}

/// The voxels of an image themselves where they lie along the axes, else cubes of their shortest edge.
static void frame_by_voxels(const LthVolume *v, const double low[3], const double high[3],
                            Frame *f) {
  int axis[3];
  if (!match_axes(v, f->dim, axis)) {
    LthResolution r = {.cell_size = INFINITY};
    for (int j = 0; j < f->dim; j++) {
      const double *A = v->to_world;
      r.cell_size =
          fmin(r.cell_size, sqrt(A[j] * A[j] + A[4 + j] * A[4 + j] + A[8 + j] * A[8 + j]));
    }
    frame_by_resolution(&r, low, high, f);
    return;
  }
  for (int a = 0; a < f->dim; a++) {
    double step = v->to_world[4 * a + axis[a]], h = fabs(step), first = v->to_world[4 * a + 3];
    double rim = (step > 0 ? first : first + step * (v->n[axis[a]] - 1)) - h / 2;
    double begin = floor((low[a] - rim) / h + 1e-6), end = ceil((high[a] - rim) / h - 1e-6);
    set_axis(f, a, rim + h * begin, rim + h * end, at_least_one(end - begin));
    f->h[a] = h;
  }
}

static bool has_resolution(const LthResolution *r) {
  return r->cells[0] > 0 || r->cell_size > 0 || r->has_grid;
}

static void frame_by_grid(const LthGrid *g, Frame *f) {
  for (int a = 0; a < f->dim; a++) set_axis(f, a, g->min[a], g->max[a], g->cells[a]);
}

static LitheStatus make_frame(LitheCtx *ctx, const LthBody *body, const double low[3],
                              const double high[3], Frame *f) {
  const LthSceneBody *def = body->def;
  double n = 1;
  *f = (Frame){.dim = body->scene->dimension};
  if (def->resolution.has_grid)
    frame_by_grid(&def->resolution.grid, f);
  else if (!has_resolution(&def->resolution) && def->shape.kind == LTH_SHAPE_IMAGE)
    frame_by_voxels(def->shape.image->volume, low, high, f);
  else
    frame_by_resolution(&def->resolution, low, high, f);
  set_thickness(f);
  for (int a = 0; a < 3; a++) n *= f->n[a];
  if (n > CELLS_MAX)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s.method: a grid of %d x %d x %d cells is more than this version takes (1e11); "
               "use fewer cells",
               def->place, f->n[0], f->n[1], f->n[2]);
  return LITHE_OK;
}

/// Smooth fractions reach beyond the body: cells for them, in addition to those that were asked for.
static void make_room(const LthFractionDef *def, Frame *f) {
  double widest = 0;
  if (def->method != LTH_FRACTIONS_SMOOTH) return;
  for (int a = 0; a < f->dim; a++) widest = fmax(widest, f->h[a]);
  for (int a = 0; a < f->dim; a++) {
    LitheIndex more = (LitheIndex)ceil(lth_fraction_half_width(def) * widest / f->h[a] - 1e-9);
    f->origin[a] -= more * f->h[a];
    f->n[a] += 2 * more;
  }
}

/// A grid of its own has to hold the body: it would be cut off at its rim.
static LitheStatus check_covers(LitheCtx *ctx, const LthBody *body, const double low[3],
                                const double high[3], const Frame *f) {
  double end[3];
  bool covers = true, meets = true;
  for (int a = 0; a < 3; a++) {
    double rounding = 1e-9 * (high[a] - low[a]);
    end[a] = f->origin[a] + f->n[a] * f->h[a];
    if (a >= f->dim) continue;
    covers = covers && low[a] >= f->origin[a] - rounding && high[a] <= end[a] + rounding;
    meets = meets && low[a] < end[a] && high[a] > f->origin[a];
  }
  if (covers || !body->def->resolution.has_grid) return LITHE_OK;
  LITHE_FAIL(ctx, LITHE_BAD_INPUT,
             "%s.method.grid: it %s the body, which reaches from (%g, %g, %g) to (%g, %g, %g); got "
             "a grid from (%g, %g, %g) to (%g, %g, %g)",
             body->def->place, meets ? "does not hold" : "misses", low[0], low[1], low[2], high[0],
             high[1], high[2], f->origin[0], f->origin[1], f->origin[2], end[0], end[1], end[2]);
}

/// The message of a failure with the body's place in front.
static LitheStatus blame(LitheCtx *ctx, const LthBody *body, const char *key, LitheStatus status) {
  char *why = NULL;
  if (status != LITHE_BAD_INPUT) return status;
  LITHE_TRY(lth_copy_text(ctx, lithe_ctx_message(ctx), &why));
  status = lth_fail(ctx, LITHE_BAD_INPUT, "%s.%s: %s", body->def->place, key, why);
  lth_free(ctx, why);
  return status;
}

static LitheStatus keep_filled(LitheCtx *ctx, LthStaggeredBody *s) {
  LitheCount n = s->fractions->grid->n_slots;
  if (!s->filled) LTH_NEW(ctx, s->filled, n);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheCount slot = 0; slot < n; slot++)
    s->filled[slot] = (float)lth_fractions_cell(s->fractions, slot);
  return LITHE_OK;
}

static void measure(LthBody *body, const double low[3], const double high[3], const Frame *f) {
  LthStaggeredBody *s = body->staggered;
  double volume = 1, sum = 0;
  s->h = INFINITY;
  for (int a = 0; a < f->dim; a++) {
    body->box[a] = fmax(low[a], f->origin[a]);
    body->box[3 + a] = fmin(high[a], f->origin[a] + f->n[a] * f->h[a]);
    body->size = fmax(body->size, body->box[3 + a] - body->box[a]);
    s->h = fmin(s->h, f->h[a]);
    volume *= f->h[a];
    sum += f->h[a] * f->h[a];
  }
  s->diagonal = sqrt(sum);
  body->cell_size = f->dim == 3 ? cbrt(volume) : sqrt(volume);
}

LitheStatus lth_build_fractions(LitheCtx *ctx, LthBody *body) {
  const LthSceneBody *def = body->def;
  double low[3], high[3];
  Frame f;
  LTH_NEW(ctx, body->staggered, 1);
  lth_shape_bounds(&def->shape, low, high);
  if (body->scene->dimension == 2) low[2] = high[2] = 0;
  LITHE_TRY(make_frame(ctx, body, low, high, &f));
  LITHE_TRY(check_covers(ctx, body, low, high, &f));
  make_room(&def->fractions, &f);
  LITHE_TRY(blame(ctx, body, "shape",
                  lth_fractions_create(ctx, &def->shape, f.dim, f.origin, f.h, f.n, &def->fractions,
                                       &body->staggered->fractions)));
  measure(body, low, high, &f);
  LITHE_TRY(keep_filled(ctx, body->staggered));
  if (def->fractions.method == LTH_FRACTIONS_SMOOTH) {
    LITHE_TRY(lth_staggered_mirror_sides(ctx, body));
    LITHE_TRY(keep_filled(ctx, body->staggered));
  }
  body->staggered->volume = body->staggered->fractions->volume;
  return LITHE_OK;
}

// --- places ---

LitheStatus lth_staggered_where(LitheCtx *ctx, const LthBody *body, const LthWhere *where,
                                bool all_inside, LthWhereSolid *ready) {
  const LthSceneBody *def = body->def;
  double resolution = def->shape_resolution > 0 ? def->shape_resolution : body->staggered->h / 2;
  return lth_where_solid_prepare(ctx, where, body->scene->dimension, &def->shape, def->shape.bvh,
                                 resolution, all_inside, ready);
}

bool lth_staggered_is_deep(const LthStaggeredBody *s, const double x[3]) {
  const LthSparseGrid *g = s->fractions->grid;
  LitheIndex low[3] = {0}, high[3] = {0};
  for (int a = 0; a < g->dim; a++) {
    double t = (x[a] - g->origin[a]) / g->h[a];
    low[a] = (LitheIndex)floor(t - 1e-6);
    high[a] = (LitheIndex)floor(t + 1e-6);
  }
  for (LitheIndex k = low[2]; k <= high[2]; k++)
    for (LitheIndex j = low[1]; j <= high[1]; j++)
      for (LitheIndex i = low[0]; i <= high[0]; i++) {
        LitheCount slot = lth_sparse_grid_slot(g, i, j, k);
        if (slot < 0 || s->filled[slot] < 1) return false;
      }
  return true;
}

bool lth_staggered_boundary_place(const LthBody *body, const double x[3], double depth,
                                  LthPlace *place) {
  const LthStaggeredBody *s = body->staggered;
  LthFoot foot;
  if (lth_staggered_is_deep(s, x) || !lth_shape_foot(&body->def->shape, x, s->h, &foot))
    return false;
  if (foot.distance < -depth - 1e-6 * s->h || foot.distance > 1.5 * s->diagonal) return false;
  *place = (LthPlace){.is_boundary = true};
  lth_v3_copy(x, place->x);
  lth_v3_copy(foot.point, place->point);
  lth_v3_copy(foot.normal, place->normal);
  return true;
}

void lth_staggered_cell(const LthBody *body, LitheIndex cell, double center[3], double *volume,
                        double *fraction) {
  static const double middle[3] = {0.5, 0.5, 0.5};
  const LthStaggered *s = lth_staggered_of(body->disc);
  LitheCount slot = s->cell_slot[cell];
  LitheIndex at[3];
  lth_sparse_grid_cell(s->grid, slot, at);
  lth_sparse_grid_place(s->grid, at, middle, center);
  *fraction = (double)body->staggered->filled[slot];
  *volume = *fraction * lth_sparse_grid_cell_volume(s->grid);
}

// --- the discretisation ---

/// Largest Poisson's ratio at centres of cells.
static double largest_poisson(const LthBody *body) {
  static const double middle[3] = {0.5, 0.5, 0.5};
  const LthStaggeredBody *s = body->staggered;
  const LthSparseGrid *g = s->fractions->grid;
  double largest = -1, x[3];
  for (LitheCount slot = 0; slot < g->n_slots; slot++) {
    LitheIndex at[3];
    if (!(s->filled[slot] > 0)) continue;
    lth_sparse_grid_cell(g, slot, at);
    lth_sparse_grid_place(g, at, middle, x);
    LitheIndex entry = lth_field_entry(body, x);
    if (entry >= 0)
      largest = fmax(largest, lth_value_at(&body->def->materials[entry].material.poisson, x, 0));
  }
  return largest;
}

LthFormulation lth_body_formulation(const LthBody *body) {
  const LthSceneBody *def = body->def;
  bool varies = false;
  double largest = -1;
  if (def->formulation == LTH_FORMULATION_MIXED) return LTH_FORM_MIXED;
  if (def->formulation == LTH_FORMULATION_DISPLACEMENT) return LTH_FORM_DISPLACEMENT;
  if (def->materials[0].material.model != LTH_MATERIAL_LINEAR) return LTH_FORM_DISPLACEMENT;
  for (LitheIndex i = 0; i < def->n_materials; i++) {
    varies = varies || def->materials[i].material.poisson.eval;
    largest = fmax(largest, def->materials[i].material.poisson.constant);
  }
  if (varies) largest = largest_poisson(body);
  return largest >= MIXED_FROM ? LTH_FORM_MIXED : LTH_FORM_DISPLACEMENT;
}

static LitheStatus build_disc(LitheCtx *ctx, LthBody *body, const LthMaterialField *field) {
  const LthStaggeredBody *s = body->staggered;
  LthStaggeredDef def = {.fractions = s->fractions,
                         .shape = &body->def->shape,
                         .material = *field,
                         .model = body->def->materials[0].material.model,
                         .formulation = s->formulation,
                         .holds = s->holds,
                         .n_holds = s->n_holds,
                         .rollers = s->rollers,
                         .n_rollers = s->n_rollers,
                         .own = s->own.cell ? &s->own : NULL};
  return blame(ctx, body, "method", lth_staggered_create(ctx, &def, &body->disc));
}

/// Mean over a cell, empty parts included, as the unknowns' masses have it.
static double mean_density(const LthBody *body, LitheIndex cell) {
  const LthStaggeredBody *s = body->staggered;
  const LthFractions *f = s->own.cell ? &s->own : s->fractions;
  LitheCount slot = lth_staggered_of(body->disc)->cell_slot[cell];
  LitheIndex at[3];
  double x[3], sum = 0;
  lth_sparse_grid_cell(f->grid, slot, at);
  for (int q = 0; q < f->n_parts; q++) {
    double v = lth_fractions_part(f, slot, q), middle[3];
    for (int a = 0; a < 3; a++) middle[a] = a < f->grid->dim ? 0.25 + 0.5 * (q >> a & 1) : 0.5;
    lth_sparse_grid_place(f->grid, at, middle, x);
    if (v > 0) sum += v * lth_field_density(body, x);
  }
  return sum / f->n_parts;
}

static LitheStatus weigh(LitheCtx *ctx, LthBody *body) {
  double *density, volume = lth_sparse_grid_cell_volume(body->staggered->fractions->grid);
  LTH_NEW(ctx, density, body->disc->n_cells);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex c = 0; c < body->disc->n_cells; c++) density[c] = mean_density(body, c);
  for (LitheIndex c = 0; c < body->disc->n_cells; c++) body->mass += volume * density[c];
  lth_free(ctx, density);
  if (!(body->mass > 0))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s.method: its cells show nothing of the body, which is thinner than one of them, "
               "got an edge of %g m; use smaller cells",
               body->def->place, body->staggered->h);
  return LITHE_OK;
}

LitheStatus lth_build_staggered(LitheCtx *ctx, LthBody *body) {
  LthMaterialField field;
  LITHE_TRY(lth_build_field(ctx, body, &field));
  LITHE_TRY(lth_staggered_check_field(ctx, body));
  LITHE_TRY(lth_staggered_hold_sides(ctx, body));
  LITHE_TRY(build_disc(ctx, body, &field));
  LITHE_TRY(lth_staggered_check_holds(ctx, body));
  LITHE_TRY(weigh(ctx, body));
  return lth_build_grid_loads(ctx, body);
}

static void free_wheres(LitheCtx *ctx, LitheIndex n, LthWhereSolid *where) {
  for (LitheIndex i = 0; where && i < n; i++) lth_where_solid_free(ctx, &where[i]);
  lth_free(ctx, where);
}

void lth_staggered_body_destroy(LitheCtx *ctx, LthStaggeredBody **body) {
  LthStaggeredBody *s = *body;
  if (!s) return;
  lth_fractions_forget(ctx, &s->own);
  lth_fractions_destroy(ctx, &s->fractions);
  lth_free(ctx, s->filled);
  free_wheres(ctx, s->n_constraints, s->constraint_where);
  free_wheres(ctx, s->n_materials, s->material_where);
  free_wheres(ctx, s->n_loads, s->load_where);
  lth_free(ctx, s->holds);
  lth_free(ctx, s->hold_place);
  lth_free(ctx, s->hold_of);
  lth_free(ctx, s->is_oblique);
  lth_free(ctx, s->rollers);
  lth_free(ctx, s->roller_place);
  lth_free(ctx, s);
  *body = NULL;
}
