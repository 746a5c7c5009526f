/// Which blocks of the stiffness matrix there are: cells and their neighbours through faces.
#include "disc/dg/dg_operator.h"

#include "base/order.h"

#include <stdlib.h>
#include <string.h>

/// Neighbours of a cell through faces and the cell itself, ascending, without repetition.
static LitheIndex neighbours(const LthMesh *mesh, LitheIndex cell, LitheIndex *list) {
  LitheIndex n = 0;
  list[n++] = cell;
  for (LitheIndex k = mesh->cell_face_off[cell]; k < mesh->cell_face_off[cell + 1]; k++) {
    const LitheIndex *pair = mesh->face_cell + 2 * (LitheCount)mesh->cell_face[k];
    LitheIndex other = pair[0] == cell ? pair[1] : pair[0];
    if (other >= 0) list[n++] = other;
  }
  return lth_sort_unique(list, n);
}

LitheStatus lth_dg_pattern_create(LitheCtx *ctx, const LthMesh *mesh, const LitheIndex *func_off,
                                  LthBlockMatrix **K) {
  LitheStatus status = LITHE_OK;
  LitheIndex n = mesh->n_cells, *list = NULL, *col = NULL;
  LitheCount *row_off = NULL, *block_off = NULL;
  *K = NULL;
  LTH_NEW_OR(done, ctx, row_off, n + 1);
  LTH_NEW_OR(done, ctx, block_off, n + 1);
  LTH_NEW_OR(done, ctx, list, (LitheCount)mesh->cell_face_off[n] + 1);
  LTH_NEW_OR(done, ctx, col, (LitheCount)mesh->cell_face_off[n] + n);
  for (LitheIndex c = 0; c < n; c++) {
    LitheIndex kept = neighbours(mesh, c, list);
    memcpy(col + block_off[c], list, sizeof *list * (size_t)kept);
    block_off[c + 1] = block_off[c] + kept;
    row_off[c + 1] = 3 * (LitheCount)func_off[c + 1];
  }
  LITHE_TRY_OR(done, lth_block_matrix_create_rough(ctx, n, row_off, block_off, col, K));

done:
  lth_free(ctx, list);
  lth_free(ctx, col);
  lth_free(ctx, row_off);
  lth_free(ctx, block_off);
  return status;
}
