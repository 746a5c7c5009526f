/// Fields of staggered bodies as files.
#include "scene/observe_grid.h"

#include "base/tensor.h"
#include "io/grid_cells.h"
#include "io/nifti_write.h"
#include "scene/measure_staggered.h"

struct LthGridFields {
  LitheIndex n;            // cells with material; 0 before the first frame
  LitheIndex *disc_cell;   // (n)
  LitheIndex *cell;        // of a slot, or -1                                (n_slots)
  LitheCount *slot;        // (n)
  LthGridCorners *corners; // of voxels, once they are written
  const LthBody *body;     // whose state is written,
  const double *u, *v, *x; // and that
};

/// Cells that the shape fills in part at least: held sides beyond the surface are no material.
static LitheStatus list_cells(LitheCtx *ctx, const LthBody *body, LthGridFields *f) {
  const LthStaggered *s = lth_staggered_of(body->disc);
  f->n = lth_body_elements(body);
  LTH_NEW(ctx, f->disc_cell, f->n);
  LTH_NEW(ctx, f->slot, f->n);
  LTH_NEW(ctx, f->cell, s->grid->n_slots);
  for (LitheCount k = 0; k < s->grid->n_slots; k++) f->cell[k] = -1;
  LitheIndex n = 0;
  for (LitheIndex c = 0; c < body->disc->n_cells; c++) {
    if (!(lth_grid_cell_fraction(body, c) > 0)) continue;
    f->disc_cell[n] = c;
    f->slot[n] = s->cell_slot[c];
    f->cell[s->cell_slot[c]] = n++;
  }
  return LITHE_OK;
}

LitheStatus lth_grid_fields_open(LitheCtx *ctx, LthGridFields **fields) {
  LTH_NEW(ctx, *fields, 1);
  return LITHE_OK;
}

void lth_grid_fields_close(LitheCtx *ctx, LthGridFields **fields) {
  LthGridFields *f = *fields;
  if (!f) return;
  lth_grid_corners_destroy(ctx, &f->corners);
  lth_free(ctx, f->disc_cell);
  lth_free(ctx, f->cell);
  lth_free(ctx, f->slot);
  lth_free(ctx, f);
  *fields = NULL;
}

LitheStatus lth_grid_fields_begin(LitheCtx *ctx, LthGridFields *f, const LthBody *body) {
  if (!f->cell) LITHE_TRY(list_cells(ctx, body, f));
  f->body = body;
  f->u = lth_body_displacement(body);
  f->v = lth_body_velocity(body);
  f->x = lth_body_position(body);
  return LITHE_OK;
}

// --- rows of arrays ---

static void fraction_of(const void *self, LitheCount cell, double *to) {
  const LthGridFields *f = self;
  *to = lth_grid_cell_fraction(f->body, f->disc_cell[cell]);
}

static void sample_at_center(const LthGridFields *f, LitheCount cell, const double *coef,
                             double *to) {
  double at[3];
  lth_body_cell_center(f->body, f->disc_cell[cell], at);
  lth_disc_sample(f->body->disc, f->disc_cell[cell], coef, at, to);
}

static void displacement_of(const void *self, LitheCount cell, double *to) {
  sample_at_center(self, cell, ((const LthGridFields *)self)->u, to);
}

static void velocity_of(const void *self, LitheCount cell, double *to) {
  sample_at_center(self, cell, ((const LthGridFields *)self)->v, to);
}

static void stress_of(const void *self, LitheCount cell, double *to) {
  const LthGridFields *f = self;
  double at[3];
  lth_body_cell_center(f->body, f->disc_cell[cell], at);
  f->body->disc->table->stress(f->body->disc, f->disc_cell[cell], f->x, at, to);
}

static void von_mises_of(const void *self, LitheCount cell, double *to) {
  double stress[6];
  stress_of(self, cell, stress);
  *to = lth_von_mises(stress);
}

/// Label of the scan where there is one, else the material's number in its list.
static void label_of(const void *self, LitheCount cell, double *to) {
  const LthGridFields *f = self;
  const LthShape *shape = &f->body->def->shape;
  double at[3];
  lth_body_cell_center(f->body, f->disc_cell[cell], at);
  *to = shape->kind == LTH_SHAPE_IMAGE ? lth_image_label(shape->image, at)
                                       : lth_body_entry(f->body, f->disc_cell[cell]);
}

#define CELL_ARRAYS 6

/// Cell arrays in the order of the file; those of a body at rest have no velocity.
static LthGridCells cells_of(const LthGridFields *f, LthVtuArray arrays[CELL_ARRAYS]) {
  const LthBody *body = f->body;
  const LthStaggered *s = lth_staggered_of(body->disc);
  int n = 0;
  arrays[n++] = (LthVtuArray){"fraction", 1, NULL, fraction_of, f};
  arrays[n++] = (LthVtuArray){"displacement", 3, NULL, displacement_of, f};
  if (body->scene->time_kind == LTH_TIME_DYNAMIC)
    arrays[n++] = (LthVtuArray){"velocity", 3, NULL, velocity_of, f};
  arrays[n++] = (LthVtuArray){"stress", 6, NULL, stress_of, f};
  arrays[n++] = (LthVtuArray){"von_mises", 1, NULL, von_mises_of, f};
  arrays[n++] = (LthVtuArray){"label", 1, NULL, label_of, f};
  return (LthGridCells){.grid = s->grid,
                        .n_cells = f->n,
                        .cell = f->cell,
                        .cell_slot = f->slot,
                        .arrays = arrays,
                        .n_arrays = n,
                        .time = lth_simulation_time(body->sim)};
}

LitheStatus lth_grid_fields_image(LitheCtx *ctx, const LthGridFields *f, const char *path) {
  LthVtuArray arrays[CELL_ARRAYS];
  LthGridCells cells = cells_of(f, arrays);
  return lth_grid_image_write(ctx, path, &cells);
}

// --- corners of voxels ---

static void sample_at_corner(const LthGridFields *f, LitheCount corner, const double *coef,
                             double *to) {
  lth_disc_sample(f->body->disc, f->disc_cell[f->corners->owner[corner]], coef,
                  f->corners->rest + 3 * corner, to);
}

static void corner_displacement(const void *self, LitheCount corner, double *to) {
  sample_at_corner(self, corner, ((const LthGridFields *)self)->u, to);
}

static void corner_velocity(const void *self, LitheCount corner, double *to) {
  sample_at_corner(self, corner, ((const LthGridFields *)self)->v, to);
}

static void corner_place(const void *self, LitheCount corner, double *to) {
  const LthGridFields *f = self;
  double moved[3];
  sample_at_corner(f, corner, f->u, moved);
  lth_v3_add(f->corners->rest + 3 * corner, moved, to);
}

LitheStatus lth_grid_fields_voxels(LitheCtx *ctx, LthGridFields *f, const char *path) {
  LthVtuArray arrays[CELL_ARRAYS];
  LthGridCells cells = cells_of(f, arrays);
  const LthVtuArray points = {"Points", 3, NULL, corner_place, f};
  const LthVtuArray at_points[] = {{"displacement", 3, NULL, corner_displacement, f},
                                   {"velocity", 3, NULL, corner_velocity, f}};
  if (!f->corners) LITHE_TRY(lth_grid_corners_create(ctx, &cells, &f->corners));
  return lth_grid_voxels_write(ctx, path, &cells, f->corners, &points,
                               f->body->scene->time_kind == LTH_TIME_DYNAMIC ? 2 : 1, at_points);
}

// --- over a scan ---

const char *lth_grid_fields_volume_name(int what) {
  static const char *const names[LTH_GRID_VOLUMES] = {"displacement", "stress", "von_mises"};
  return names[what];
}

#define SAME 1e-6 ///< of a cell: a voxel's middle is that of the cell

/// A cell with material that a place lies in, -1 where there is none; a place at its middle becomes that to the bit.
static LitheIndex cell_at(const LthGridFields *f, const LthStaggered *s, double x[3]) {
  LitheIndex at[3] = {0};
  bool is_middle = true;
  for (int a = 0; a < s->dim; a++) {
    double place = (x[a] - s->grid->origin[a]) / s->grid->h[a], low = floor(place);
    if (!(low >= 0 && low < s->grid->n[a])) return -1;
    is_middle = is_middle && fabs(place - low - 0.5) < SAME;
    at[a] = (LitheIndex)low;
  }
  LitheCount slot = lth_sparse_grid_slot(s->grid, at[0], at[1], at[2]);
  const LitheIndex cell = slot < 0 ? -1 : f->cell[slot];
  if (cell >= 0 && is_middle) lth_body_cell_center(f->body, f->disc_cell[cell], x);
  return cell;
}

/// Components of a field at x, in the order of our tensors.
static void sample_voxel(const LthGridFields *f, int what, double x[3], double value[6]) {
  const LthDisc *disc = f->body->disc;
  const LitheIndex i = cell_at(f, lth_staggered_of(disc), x);
  for (int k = 0; k < 6; k++) value[k] = 0;
  if (i < 0) return;
  if (what == 0)
    lth_disc_sample(disc, f->disc_cell[i], f->u, x, value);
  else
    disc->table->stress(disc, f->disc_cell[i], f->x, x, value);
  if (what == 2) value[0] = lth_von_mises(value);
}

static void sample_voxels(LitheCtx *ctx, const LthGridFields *f, const LthVolume *v, int what,
                          int components, float *values) {
  const double *A = v->to_world;
  LitheCount n = lth_volume_size(v);
#pragma omp parallel for schedule(dynamic, 1) num_threads(lth_threads(ctx))
  for (LitheIndex k = 0; k < v->n[2]; k++)
    for (LitheIndex j = 0; j < v->n[1]; j++)
      for (LitheIndex i = 0; i < v->n[0]; i++) {
        double x[3], value[6];
        for (int a = 0; a < 3; a++)
          x[a] = A[4 * a] * i + A[4 * a + 1] * j + A[4 * a + 2] * k + A[4 * a + 3];
        sample_voxel(f, what, x, value);
        for (int c = 0; c < components; c++)
          values[c * n + lth_volume_index(v, i, j, k)] = (float)value[c];
      }
}

LitheStatus lth_grid_fields_volume(LitheCtx *ctx, const LthGridFields *f, int what,
                                   const char *path) {
  const LthVolume *v = f->body->def->shape.image->volume;
  const int components = what == 0 ? 3 : what == 1 ? 6 : 1;
  float *values = NULL;
  LTH_NEW(ctx, values, components * lth_volume_size(v));
  sample_voxels(ctx, f, v, what, components, values);
  LthNiftiField field = {lth_grid_fields_volume_name(what), components, values};
  LitheStatus status = lth_nifti_write(ctx, path, v->n, v->of_file, &field);
  lth_free(ctx, values);
  return status;
}
