/// Matrix Market files, as SciPy, MATLAB and Julia read them.
#pragma once

#include "la/block_matrix.h"

/// Write the lower triangle of a symmetric matrix, zeros of its blocks included, with all digits. Atomic.
/// LITHE_NO_SPACE: cannot write.
LitheStatus lth_matrix_market_write(LitheCtx *ctx, const char *path, const LthBlockMatrix *A);
