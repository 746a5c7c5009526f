/// Fields of staggered bodies as files.
#include "scene/observe_grid.h"

#include "base/tensor.h"
#include "io/grid_cells.h"
#include "io/nifti_write.h"
#include "scene/measure_staggered.h"

struct LthGridFields {
  LitheIndex n;          // cells with material
  LitheIndex *disc_cell; // (n)
  LitheIndex *cell;      // of a slot, or -1                                (n_slots)
  LitheCount *slot;      // (n)
  double *fraction, *displacement, *velocity, *stress, *von_mises, *label;
  LthGridCorners *corners; // of voxels, once they are written
  double *points, *moved, *speed;
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

/// Label of the scan where there is one, else the material's number in its list.
static double label_of(const LthBody *body, LitheIndex cell, const double x[3]) {
  const LthShape *shape = &body->def->shape;
  return shape->kind == LTH_SHAPE_IMAGE ? lth_image_label(shape->image, x)
                                        : lth_body_entry(body, cell);
}

LitheStatus lth_grid_fields_open(LitheCtx *ctx, const LthBody *body, LthGridFields **fields) {
  LTH_NEW(ctx, *fields, 1);
  LthGridFields *f = *fields;
  LITHE_TRY(list_cells(ctx, body, f));
  LTH_NEW(ctx, f->fraction, f->n);
  LTH_NEW(ctx, f->displacement, 3 * (LitheCount)f->n);
  LTH_NEW(ctx, f->velocity, 3 * (LitheCount)f->n);
  LTH_NEW(ctx, f->stress, 6 * (LitheCount)f->n);
  LTH_NEW(ctx, f->von_mises, f->n);
  LTH_NEW(ctx, f->label, f->n);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex i = 0; i < f->n; i++) {
    double x[3];
    lth_body_cell_center(body, f->disc_cell[i], x);
    f->fraction[i] = lth_grid_cell_fraction(body, f->disc_cell[i]);
    f->label[i] = label_of(body, f->disc_cell[i], x);
  }
  return LITHE_OK;
}

void lth_grid_fields_close(LitheCtx *ctx, LthGridFields **fields) {
  LthGridFields *f = *fields;
  if (!f) return;
  void *blocks[] = {f->disc_cell, f->cell,      f->slot,  f->fraction, f->displacement, f->velocity,
                    f->stress,    f->von_mises, f->label, f->points,   f->moved,        f->speed};
  lth_grid_corners_destroy(ctx, &f->corners);
  for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) lth_free(ctx, blocks[i]);
  lth_free(ctx, f);
  *fields = NULL;
}

void lth_grid_fields_sample(LitheCtx *ctx, LthGridFields *f, const LthBody *body) {
  const double *u = lth_body_displacement(body), *v = lth_body_velocity(body),
               *x = lth_body_position(body);
  bool moves = body->scene->time_kind == LTH_TIME_DYNAMIC;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex i = 0; i < f->n; i++) {
    LitheIndex c = f->disc_cell[i];
    double at[3];
    lth_body_cell_center(body, c, at);
    lth_disc_sample(body->disc, c, u, at, f->displacement + 3 * (LitheCount)i);
    if (moves) lth_disc_sample(body->disc, c, v, at, f->velocity + 3 * (LitheCount)i);
    body->disc->table->stress(body->disc, c, x, at, f->stress + 6 * (LitheCount)i);
    f->von_mises[i] = lth_von_mises(f->stress + 6 * (LitheCount)i);
  }
}

#define CELL_ARRAYS 6

/// Cell arrays in the order of the file; those of a body at rest have no velocity.
static LthGridCells cells_of(const LthGridFields *f, const LthBody *body,
                             LthVtuArray arrays[CELL_ARRAYS]) {
  const LthStaggered *s = lth_staggered_of(body->disc);
  int n = 0;
  arrays[n++] = (LthVtuArray){"fraction", 1, f->fraction};
  arrays[n++] = (LthVtuArray){"displacement", 3, f->displacement};
  if (body->scene->time_kind == LTH_TIME_DYNAMIC)
    arrays[n++] = (LthVtuArray){"velocity", 3, f->velocity};
  arrays[n++] = (LthVtuArray){"stress", 6, f->stress};
  arrays[n++] = (LthVtuArray){"von_mises", 1, f->von_mises};
  arrays[n++] = (LthVtuArray){"label", 1, f->label};
  return (LthGridCells){.grid = s->grid,
                        .n_cells = f->n,
                        .cell = f->cell,
                        .cell_slot = f->slot,
                        .arrays = arrays,
                        .n_arrays = n,
                        .time = lth_simulation_time(body->sim)};
}

LitheStatus lth_grid_fields_image(LitheCtx *ctx, const LthGridFields *f, const LthBody *body,
                                  const char *path) {
  LthVtuArray arrays[CELL_ARRAYS];
  LthGridCells cells = cells_of(f, body, arrays);
  return lth_grid_image_write(ctx, path, &cells);
}

static LitheStatus number_corners(LitheCtx *ctx, LthGridFields *f, const LthGridCells *cells) {
  if (f->corners) return LITHE_OK;
  LITHE_TRY(lth_grid_corners_create(ctx, cells, &f->corners));
  LTH_NEW(ctx, f->points, 3 * (LitheCount)f->corners->n);
  LTH_NEW(ctx, f->moved, 3 * (LitheCount)f->corners->n);
  LTH_NEW(ctx, f->speed, 3 * (LitheCount)f->corners->n);
  return LITHE_OK;
}

LitheStatus lth_grid_fields_voxels(LitheCtx *ctx, LthGridFields *f, const LthBody *body,
                                   const char *path) {
  LthVtuArray arrays[CELL_ARRAYS];
  LthGridCells cells = cells_of(f, body, arrays);
  const double *u = lth_body_displacement(body), *v = lth_body_velocity(body);
  LITHE_TRY(number_corners(ctx, f, &cells));
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex i = 0; i < f->corners->n; i++) {
    LitheIndex c = f->disc_cell[f->corners->owner[i]];
    const double *rest = f->corners->rest + 3 * (LitheCount)i;
    lth_disc_sample(body->disc, c, u, rest, f->moved + 3 * (LitheCount)i);
    lth_disc_sample(body->disc, c, v, rest, f->speed + 3 * (LitheCount)i);
    lth_v3_add(rest, f->moved + 3 * (LitheCount)i, f->points + 3 * (LitheCount)i);
  }
  const LthVtuArray at_points[] = {{"displacement", 3, f->moved}, {"velocity", 3, f->speed}};
  return lth_grid_voxels_write(ctx, path, &cells, f->corners, f->points,
                               body->scene->time_kind == LTH_TIME_DYNAMIC ? 2 : 1, at_points);
}

// --- over a scan ---

const char *lth_grid_fields_volume_name(int what) {
  static const char *const names[LTH_GRID_VOLUMES] = {"displacement", "stress", "von_mises"};
  return names[what];
}

#define SAME 1e-6 ///< of a cell: a voxel's middle is that of the cell

/// A cell with material that a place lies in, -1 where there is none; *is_middle: at its middle.
static LitheIndex cell_at(const LthGridFields *f, const LthStaggered *s, const double x[3],
                          bool *is_middle) {
  LitheIndex at[3] = {0};
  *is_middle = true;
  for (int a = 0; a < s->dim; a++) {
    double place = (x[a] - s->grid->origin[a]) / s->grid->h[a], low = floor(place);
    if (!(low >= 0 && low < s->grid->n[a])) return -1;
    *is_middle = *is_middle && fabs(place - low - 0.5) < SAME;
    at[a] = (LitheIndex)low;
  }
  LitheCount slot = lth_sparse_grid_slot(s->grid, at[0], at[1], at[2]);
  return slot < 0 ? -1 : f->cell[slot];
}

/// Components of a field at x, in the order of our tensors; scans whose voxels are the grid's cells have them already.
static void sample_voxel(const LthGridFields *f, const LthBody *body, const double *u, int what,
                         const double x[3], double value[6]) {
  bool is_middle;
  LitheIndex i = cell_at(f, lth_staggered_of(body->disc), x, &is_middle);
  for (int k = 0; k < 6; k++) value[k] = 0;
  if (i < 0) return;
  if (what == 0) {
    if (is_middle)
      lth_v3_copy(f->displacement + 3 * (LitheCount)i, value);
    else
      lth_disc_sample(body->disc, f->disc_cell[i], u, x, value);
    return;
  }
  if (is_middle)
    for (int k = 0; k < 6; k++) value[k] = f->stress[6 * (LitheCount)i + k];
  else
    body->disc->table->stress(body->disc, f->disc_cell[i], lth_body_position(body), x, value);
  if (what == 2) value[0] = lth_von_mises(value);
}

static void sample_voxels(LitheCtx *ctx, const LthGridFields *f, const LthBody *body,
                          const LthVolume *v, int what, int components, float *values) {
  const double *A = v->to_world, *u = lth_body_displacement(body);
  LitheCount n = lth_volume_size(v);
#pragma omp parallel for schedule(dynamic, 1) num_threads(lth_threads(ctx))
  for (LitheIndex k = 0; k < v->n[2]; k++)
    for (LitheIndex j = 0; j < v->n[1]; j++)
      for (LitheIndex i = 0; i < v->n[0]; i++) {
        double x[3], value[6];
        for (int a = 0; a < 3; a++)
          x[a] = A[4 * a] * i + A[4 * a + 1] * j + A[4 * a + 2] * k + A[4 * a + 3];
        sample_voxel(f, body, u, what, x, value);
        for (int c = 0; c < components; c++)
          values[c * n + lth_volume_index(v, i, j, k)] = (float)value[c];
      }
}

LitheStatus lth_grid_fields_volume(LitheCtx *ctx, const LthGridFields *f, const LthBody *body,
                                   int what, const char *path) {
  const LthVolume *v = body->def->shape.image->volume;
  const int components = what == 0 ? 3 : what == 1 ? 6 : 1;
  float *values = NULL;
  LTH_NEW(ctx, values, components * lth_volume_size(v));
  sample_voxels(ctx, f, body, v, what, components, values);
  LthNiftiField field = {lth_grid_fields_volume_name(what), components, values};
  LitheStatus status = lth_nifti_write(ctx, path, v->n, v->of_file, &field);
  lth_free(ctx, values);
  return status;
}
