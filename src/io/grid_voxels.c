/// Cells of a sparse grid as voxels whose corners have moved: VTK hexahedra or quadrilaterals.
#include "io/file.h"
#include "io/grid_cells.h"

#include <string.h>

#define VTK_QUAD 9
#define VTK_HEXAHEDRON 12

static int corners_of(const LthSparseGrid *grid) { return grid->dim == 3 ? 8 : 4; }

/// Slot whose low corner is corner k of a cell. Every cell's neighbours have slots.
static LitheCount corner_slot(const LthSparseGrid *grid, LitheCount slot, int k) {
  static const int step[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                 {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  return k == 0 ? slot : lth_sparse_grid_step(grid, slot, step[k]);
}

/// Number the corners as the cells come.
static LitheStatus number_corners(LitheCtx *ctx, const LthGridCells *c, LitheIndex *number,
                                  LthGridCorners *to) {
  const LthSparseGrid *grid = c->grid;
  const int m = corners_of(grid);
  LTH_NEW(ctx, to->corner, m * (LitheCount)c->n_cells);
  for (LitheIndex i = 0; i < c->n_cells; i++)
    for (int k = 0; k < m; k++) {
      LitheCount slot = corner_slot(grid, c->cell_slot[i], k);
      LITHE_ASSERT(slot >= 0);
      if (number[slot] == 0) number[slot] = ++to->n;
      to->corner[m * (LitheCount)i + k] = number[slot] - 1;
    }
  return LITHE_OK;
}

static LitheStatus place_corners(LitheCtx *ctx, const LthGridCells *c, LthGridCorners *to) {
  const LthSparseGrid *grid = c->grid;
  static const double low[3] = {0, 0, 0}, flat[3] = {0, 0, 0.5};
  const int m = corners_of(grid);
  LTH_NEW(ctx, to->owner, to->n);
  LTH_NEW(ctx, to->rest, 3 * (LitheCount)to->n);
  for (LitheIndex i = c->n_cells - 1; i >= 0; i--)
    for (int k = 0; k < m; k++) {
      LitheIndex corner = to->corner[m * (LitheCount)i + k], at[3];
      to->owner[corner] = i;
      lth_sparse_grid_cell(grid, corner_slot(grid, c->cell_slot[i], k), at);
      lth_sparse_grid_place(grid, at, grid->dim == 3 ? low : flat,
                            to->rest + 3 * (LitheCount)corner);
    }
  return LITHE_OK;
}

LitheStatus lth_grid_corners_create(LitheCtx *ctx, const LthGridCells *cells,
                                    LthGridCorners **corners) {
  LitheStatus status = LITHE_OK;
  LitheIndex *number = NULL;
  LTH_NEW_OR(done, ctx, *corners, 1);
  LTH_NEW_OR(done, ctx, number, cells->grid->n_slots);
  LITHE_TRY_OR(done, number_corners(ctx, cells, number, *corners));
  LITHE_TRY_OR(done, place_corners(ctx, cells, *corners));
done:
  lth_free(ctx, number);
  if (status != LITHE_OK) lth_grid_corners_destroy(ctx, corners);
  return status;
}

void lth_grid_corners_destroy(LitheCtx *ctx, LthGridCorners **corners) {
  if (!*corners) return;
  lth_free(ctx, (*corners)->corner);
  lth_free(ctx, (*corners)->owner);
  lth_free(ctx, (*corners)->rest);
  lth_free(ctx, *corners);
  *corners = NULL;
}

/// What the connectivity of all cells is made from, piece by piece.
typedef struct Topology {
  const LthGridCorners *corners;
  int m;
} Topology;

static void fill_connectivity(const void *self, LitheCount first, LitheCount n, unsigned char *to) {
  const Topology *t = self;
  for (LitheCount i = first / 8; i < (first + n) / 8; i++, to += 8) {
    int64_t corner = t->corners->corner[i];
    memcpy(to, &corner, 8);
  }
}

static void fill_offsets(const void *self, LitheCount first, LitheCount n, unsigned char *to) {
  const Topology *t = self;
  for (LitheCount i = first / 8; i < (first + n) / 8; i++, to += 8) {
    int64_t offset = t->m * (i + 1);
    memcpy(to, &offset, 8);
  }
}

static void fill_types(const void *self, LitheCount first, LitheCount n, unsigned char *to) {
  const Topology *t = self;
  (void)first;
  memset(to, t->m == 8 ? VTK_HEXAHEDRON : VTK_QUAD, (size_t)n);
}

/// Blocks in the order of the file: points, their arrays, those of the cells, connectivity, offsets, types.
static LitheStatus encode(LitheCtx *ctx, const LthGridCells *c, const LthGridCorners *corners,
                          const LthVtuArray *points, int n_arrays, const LthVtuArray *arrays,
                          LthVtuBlock *blocks) {
  Topology topology = {corners, corners_of(c->grid)};
  LitheCount n = c->n_cells;
  LITHE_TRY(lth_vtk_encode_array(ctx, corners->n, points, blocks++));
  for (int i = 0; i < n_arrays; i++)
    LITHE_TRY(lth_vtk_encode_array(ctx, corners->n, &arrays[i], blocks++));
  for (int i = 0; i < c->n_arrays; i++)
    LITHE_TRY(lth_vtk_encode_array(ctx, n, &c->arrays[i], blocks++));
  LITHE_TRY(lth_vtu_block_stream(ctx, fill_connectivity, &topology, 8 * n * topology.m, blocks++));
  LITHE_TRY(lth_vtu_block_stream(ctx, fill_offsets, &topology, 8 * n, blocks++));
  return lth_vtu_block_stream(ctx, fill_types, &topology, n, blocks);
}

static void put_head(FILE *out, const LthGridCells *c, LitheIndex n_points, int n_arrays,
                     const LthVtuArray *arrays, const LthVtuBlock *blocks) {
  LitheCount offset = 0;
  lth_vtk_put_opening(out, "UnstructuredGrid");
  fputs("  <UnstructuredGrid>\n", out);
  lth_vtk_put_time(out, c->time);
  fprintf(out, "    <Piece NumberOfPoints=\"%d\" NumberOfCells=\"%d\">\n      <Points>\n", n_points,
          c->n_cells);
  lth_vtk_put_array(out, "Float32", "Points", 3, blocks++, &offset);
  fputs("      </Points>\n", out);
  lth_vtk_put_arrays(out, "PointData", n_arrays, arrays, blocks, &offset);
  blocks += n_arrays;
  lth_vtk_put_arrays(out, "CellData", c->n_arrays, c->arrays, blocks, &offset);
  blocks += c->n_arrays;
  fputs("      <Cells>\n", out);
  lth_vtk_put_array(out, "Int64", "connectivity", 1, blocks, &offset);
  lth_vtk_put_array(out, "Int64", "offsets", 1, blocks + 1, &offset);
  lth_vtk_put_array(out, "UInt8", "types", 1, blocks + 2, &offset);
  fputs("      </Cells>\n    </Piece>\n  </UnstructuredGrid>\n", out);
  lth_vtk_put_appended(out);
}

LitheStatus lth_grid_voxels_write(LitheCtx *ctx, const char *path, const LthGridCells *cells,
                                  const LthGridCorners *corners, const LthVtuArray *points,
                                  int n_arrays, const LthVtuArray *arrays) {
  LitheStatus status = LITHE_OK;
  LthFileWriter writer;
  LthVtuBlock *blocks = NULL;
  int n_blocks = 1 + n_arrays + cells->n_arrays + 3;
  LTH_NEW_OR(done, ctx, blocks, n_blocks);
  LITHE_TRY_OR(done, encode(ctx, cells, corners, points, n_arrays, arrays, blocks));
  LITHE_TRY_OR(done, lth_file_open(ctx, path, &writer));
  put_head(writer.stream, cells, corners->n, n_arrays, arrays, blocks);
  for (int i = 0; i < n_blocks; i++) lth_vtk_put_block(writer.stream, blocks + i);
  lth_vtk_put_end(writer.stream);
  status = lth_file_commit(ctx, &writer);

done:
  for (int i = 0; blocks && i < n_blocks; i++) lth_vtu_block_free(ctx, blocks + i);
  lth_free(ctx, blocks);
  return status;
}
