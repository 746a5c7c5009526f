/// Grid cells that are full enough to stand for a solid.
#include "mesh/grid_fill.h"

#include "base/disjoint_sets.h"

/// Cells of the grid and, for each, the connected part of the solid that fills most of it.
typedef struct Fill {
  const LthGrid *grid;
  LitheIndex n, n_parts;
  double *volume;     ///< filled                                         (n)
  LitheIndex *part;   ///< of the solid, -1                               (n)
  LitheIndex *group;  ///< set of marked cells that share faces           (n)
  LitheIndex *weight; ///< cells of a group                               (n)
  LitheIndex *best;   ///< largest group of a part of the solid, -1       (mesh cells)
} Fill;

static LitheIndex cell_along(const LthGrid *grid, int axis, double x) {
  double step = (grid->max[axis] - grid->min[axis]) / grid->cells[axis];
  double k = (x - grid->min[axis]) / step;
  if (!(k > 0)) return 0;
  return k < grid->cells[axis] ? (LitheIndex)k : grid->cells[axis] - 1;
}

void lth_grid_cells(const LthGrid *grid, const LthMesh *mesh, LitheIndex *grid_cell) {
  for (LitheIndex c = 0; c < mesh->n_cells; c++) {
    const double *box = mesh->cell_box + 6 * (LitheCount)c;
    LitheIndex at[3];
    for (int a = 0; a < 3; a++) at[a] = cell_along(grid, a, 0.5 * (box[a] + box[3 + a]));
    grid_cell[c] = at[0] + grid->cells[0] * (at[1] + grid->cells[1] * at[2]);
  }
}

static LitheStatus allocate(LitheCtx *ctx, const LthGrid *grid, const LthMesh *mesh, Fill *f) {
  f->grid = grid;
  f->n = grid->cells[0] * grid->cells[1] * grid->cells[2];
  LTH_NEW(ctx, f->volume, f->n);
  LTH_NEW(ctx, f->part, f->n);
  LTH_NEW(ctx, f->group, f->n);
  LTH_NEW(ctx, f->weight, f->n);
  LTH_NEW(ctx, f->best, mesh->n_cells);
  return LITHE_OK;
}

/// Filled volumes and parts.
static LitheStatus measure(LitheCtx *ctx, const LthMesh *mesh, Fill *f) {
  LitheStatus status = LITHE_OK;
  LitheIndex *cell = NULL, *set = NULL;
  double *largest = NULL;
  LTH_NEW_OR(done, ctx, cell, mesh->n_cells);
  LTH_NEW_OR(done, ctx, set, mesh->n_cells);
  LTH_NEW_OR(done, ctx, largest, f->n);
  lth_sets_reset(set, mesh->n_cells);
  for (LitheIndex i = 0; i < mesh->n_faces; i++)
    if (mesh->face_cell[2 * i + 1] >= 0)
      lth_sets_unite(set, mesh->face_cell[2 * i], mesh->face_cell[2 * i + 1]);
  lth_grid_cells(f->grid, mesh, cell);
  for (LitheIndex k = 0; k < f->n; k++) f->part[k] = -1;
  for (LitheIndex c = 0; c < mesh->n_cells; c++) {
    f->volume[cell[c]] += mesh->cell_volume[c];
    if (mesh->cell_volume[c] <= largest[cell[c]]) continue;
    largest[cell[c]] = mesh->cell_volume[c];
    f->part[cell[c]] = lth_sets_root(set, c);
  }
done:
  lth_free(ctx, cell);
  lth_free(ctx, set);
  lth_free(ctx, largest);
  return status;
}

/// Marked cells that share faces become one group.
static void group_cells(const uint8_t *keep, Fill *f) {
  const LitheIndex *n = f->grid->cells;
  LitheIndex step[3] = {1, n[0], n[0] * n[1]};
  lth_sets_reset(f->group, f->n);
  for (LitheIndex k = 0; k < f->n; k++) {
    LitheIndex at[3] = {k % n[0], k / n[0] % n[1], k / (n[0] * n[1])};
    for (int a = 0; a < 3; a++)
      if (keep[k] && at[a] + 1 < n[a] && keep[k + step[a]])
        lth_sets_unite(f->group, k, k + step[a]);
  }
  for (LitheIndex k = 0; k < f->n; k++)
    if (keep[k]) f->weight[lth_sets_root(f->group, k)]++;
}

static void drop_hinges(LitheIndex n_mesh_cells, uint8_t *keep, LitheIndex *dropped, Fill *f) {
  for (LitheIndex c = 0; c < n_mesh_cells; c++) f->best[c] = -1;
  for (LitheIndex k = 0; k < f->n; k++) {
    if (!keep[k]) continue;
    LitheIndex root = lth_sets_root(f->group, k), *best = &f->best[f->part[k]];
    if (*best < 0 || f->weight[root] > f->weight[*best]) *best = root;
  }
  for (LitheIndex k = 0; k < f->n; k++) {
    if (!keep[k] || lth_sets_root(f->group, k) == f->best[f->part[k]]) continue;
    keep[k] = 0;
    ++*dropped;
  }
}

LitheStatus lth_grid_voxels(LitheCtx *ctx, const LthGrid *grid, const LthMesh *mesh, uint8_t *keep,
                            LitheIndex *dropped) {
  LitheStatus status = LITHE_OK;
  Fill f = {0};
  double full = 1;
  *dropped = 0;
  LITHE_TRY_OR(done, allocate(ctx, grid, mesh, &f));
  LITHE_TRY_OR(done, measure(ctx, mesh, &f));
  for (int a = 0; a < 3; a++) full *= (grid->max[a] - grid->min[a]) / grid->cells[a];
  // rounding of a cell that is exactly half full counts for it
  for (LitheIndex k = 0; k < f.n; k++) keep[k] = f.volume[k] >= 0.5 * full * (1 - 1e-9);
  group_cells(keep, &f);
  drop_hinges(mesh->n_cells, keep, dropped, &f);
done:
  lth_free(ctx, f.volume);
  lth_free(ctx, f.part);
  lth_free(ctx, f.group);
  lth_free(ctx, f.weight);
  lth_free(ctx, f.best);
  return status;
}
