/// Matrix Market files (Boisvert, Pozo and Remington, NISTIR 5935, 1996).
#include "io/matrix_market.h"

#include "io/file.h"
#include "io/number_text.h"

static LitheCount block_size(const LthBlockMatrix *A, LitheIndex row) {
  return A->row_off[row + 1] - A->row_off[row];
}

/// Entries of the lower triangle.
static LitheCount count_lower(const LthBlockMatrix *A) {
  LitheCount n = 0;
  for (LitheIndex row = 0; row < A->n_rows; row++)
    for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1]; e++) {
      LitheCount m = block_size(A, row), k = block_size(A, A->block_col[e]);
      if (A->block_col[e] < row) n += m * k;
      if (A->block_col[e] == row) n += m * (m + 1) / 2;
    }
  return n;
}

/// Row r of a block row, up to the diagonal.
static void write_row(const LthBlockMatrix *A, LitheIndex row, LitheCount r, FILE *out) {
  char text[LTH_NUMBER_TEXT_MAX];
  for (LitheCount e = A->block_off[row]; e < A->block_off[row + 1] && A->block_col[e] <= row; e++) {
    LitheIndex col = A->block_col[e];
    LitheCount n = block_size(A, col), end = col < row ? n : r + 1;
    for (LitheCount c = 0; c < end; c++)
      fprintf(out, "%lld %lld %s\n", (long long)(A->row_off[row] + r + 1),
              (long long)(A->row_off[col] + c + 1),
              lth_number_text(A->values[A->value_off[e] + r * n + c], text));
  }
}

LitheStatus lth_matrix_market_write(LitheCtx *ctx, const char *path, const LthBlockMatrix *A) {
  LthFileWriter writer;
  LITHE_TRY(lth_file_open(ctx, path, &writer));
  fprintf(writer.stream, "%%%%MatrixMarket matrix coordinate real symmetric\n%lld %lld %lld\n",
          (long long)A->n, (long long)A->n, (long long)count_lower(A));
  for (LitheIndex row = 0; row < A->n_rows && !ferror(writer.stream); row++)
    for (LitheCount r = 0; r < block_size(A, row); r++) write_row(A, row, r, writer.stream);
  return lth_file_commit(ctx, &writer);
}
