/// Cells of a sparse grid as VTK ImageData.
#include "io/file.h"
#include "io/grid_cells.h"
#include "io/number_text.h"

#include <string.h>

#define IMAGE_CELLS_MAX 4e9 // of a box; beyond, files that have no voxels to speak of take minutes

/// The box of all cells, from low to high (not among them).
typedef struct Box {
  LitheIndex low[3], high[3];
} Box;

static Box box_of(const LthGridCells *c) {
  Box box = {{0}, {1, 1, 1}};
  for (LitheIndex i = 0; i < c->n_cells; i++) {
    LitheIndex at[3];
    lth_sparse_grid_cell(c->grid, c->cell_slot[i], at);
    for (int a = 0; a < 3; a++) {
      if (i == 0 || at[a] < box.low[a]) box.low[a] = at[a];
      if (i == 0 || at[a] + 1 > box.high[a]) box.high[a] = at[a] + 1;
    }
  }
  return box;
}

/// An array of the image, of which pieces are made when they are needed.
typedef struct Source {
  const LthGridCells *cells;
  const LthVtuArray *array;
  Box box;
} Source;

/// Values of `n` cells on a line along x of the image, beginning with one that has a slot or a run of cells that have none;
/// returns how many cells these are. `row` NULL: nothing is there.
static LitheCount next_cells(const Source *s, LitheCount at, double room[LTH_VTK_COMPONENTS],
                             const double **row) {
  const LthGridCells *c = s->cells;
  const LitheCount nx = s->box.high[0] - s->box.low[0], ny = s->box.high[1] - s->box.low[1];
  const LitheIndex x = s->box.low[0] + (LitheIndex)(at % nx), side = c->grid->side;
  const LitheCount slot =
      lth_sparse_grid_slot(c->grid, x, s->box.low[1] + (LitheIndex)(at / nx % ny),
                           s->box.low[2] + (LitheIndex)(at / nx / ny));
  *row = NULL;
  if (slot < 0) { // nor have the others of its block
    const LitheIndex end = (x / side + 1) * side;
    return (end < s->box.high[0] ? end : s->box.high[0]) - x;
  }
  if (c->cell[slot] >= 0) *row = lth_vtk_row(s->array, c->cell[slot], room);
  return 1;
}

/// Floats of the image from number `first` on: x fastest, then y, then z, components together.
static void fill(const void *self, LitheCount first, LitheCount n, unsigned char *to) {
  const Source *s = self;
  const int m = s->array->components;
  LitheCount number = first / (LitheCount)sizeof(float);
  const LitheCount end = (first + n) / (LitheCount)sizeof(float);
  memset(to, 0, (size_t)n);
  while (number < end) {
    double room[LTH_VTK_COMPONENTS];
    const double *row;
    LitheCount next = (number / m + next_cells(s, number / m, room, &row)) * m;
    if (next > end) next = end;
    for (LitheCount i = number; row && i < next; i++) {
      const float value = (float)row[lth_vtk_component(m, (int)(i % m))];
      memcpy(to + (i - number) * (LitheCount)sizeof value, &value, sizeof value);
    }
    to += (next - number) * (LitheCount)sizeof(float);
    number = next;
  }
}

static void put_numbers(FILE *out, const char *name, const double v[3]) {
  char text[3][LTH_NUMBER_TEXT_MAX];
  fprintf(out, " %s=\"%s %s %s\"", name, lth_number_text(v[0], text[0]),
          lth_number_text(v[1], text[1]), lth_number_text(v[2], text[2]));
}

/// In 2D the image is one layer of points, so that its cells are squares.
static void put_head(FILE *out, const LthGridCells *c, const Box *box, const LthVtuBlock *blocks) {
  const LthSparseGrid *g = c->grid;
  LitheCount offset = 0;
  double low[3];
  char extent[120];
  LitheIndex n[3];
  for (int a = 0; a < 3; a++) {
    low[a] = g->origin[a] + g->h[a] * box->low[a];
    n[a] = box->high[a] - box->low[a];
  }
  if (g->dim == 2) low[2] = 0, n[2] = 0;
  snprintf(extent, sizeof extent, "0 %d 0 %d 0 %d", n[0], n[1], n[2]);
  lth_vtk_put_opening(out, "ImageData");
  fprintf(out, "  <ImageData WholeExtent=\"%s\"", extent);
  put_numbers(out, "Origin", low);
  put_numbers(out, "Spacing", g->h);
  fputs(">\n", out);
  lth_vtk_put_time(out, c->time);
  fprintf(out, "    <Piece Extent=\"%s\">\n", extent);
  lth_vtk_put_arrays(out, "CellData", c->n_arrays, c->arrays, blocks, &offset);
  fputs("    </Piece>\n  </ImageData>\n", out);
  lth_vtk_put_appended(out);
}

static LitheStatus put_file(LitheCtx *ctx, const char *path, const LthGridCells *c, const Box *box,
                            const LthVtuBlock *blocks) {
  LthFileWriter writer;
  LITHE_TRY(lth_file_open(ctx, path, &writer));
  put_head(writer.stream, c, box, blocks);
  for (int i = 0; i < c->n_arrays; i++) lth_vtk_put_block(writer.stream, blocks + i);
  lth_vtk_put_end(writer.stream);
  return lth_file_commit(ctx, &writer);
}

LitheStatus lth_grid_image_write(LitheCtx *ctx, const char *path, const LthGridCells *c) {
  LitheStatus status = LITHE_OK;
  LthVtuBlock *blocks = NULL;
  Box box = box_of(c);
  double n = 1;
  for (int a = 0; a < 3; a++) n *= box.high[a] - box.low[a];
  if (n > IMAGE_CELLS_MAX)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s: an image of %d x %d x %d cells, most of them empty, is too large to look at; "
               "use `fields: vtu`, "
               "which holds those with material alone",
               path, box.high[0] - box.low[0], box.high[1] - box.low[1], box.high[2] - box.low[2]);
  LTH_NEW_OR(done, ctx, blocks, c->n_arrays);
  for (int i = 0; i < c->n_arrays; i++) {
    Source source = {c, c->arrays + i, box};
    LitheCount bytes = (LitheCount)n * c->arrays[i].components * (LitheCount)sizeof(float);
    LITHE_TRY_OR(done, lth_vtu_block_stream(ctx, fill, &source, bytes, blocks + i));
  }
  status = put_file(ctx, path, c, &box, blocks);

done:
  for (int i = 0; blocks && i < c->n_arrays; i++) lth_vtu_block_free(ctx, blocks + i);
  lth_free(ctx, blocks);
  return status;
}
