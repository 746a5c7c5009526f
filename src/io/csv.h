/// Tables as comma-separated text that is valid after every row: history.csv and probes.csv.
#pragma once

#include "base/ctx.h"

typedef struct LthCsv LthCsv;

/// Create the file with a header line of `n` column names (quoted where they need it; copied).
LitheStatus lth_csv_open(LitheCtx *ctx, const char *path, int n, const char *const *names,
                         LthCsv **csv);

/// Append a row of n numbers (NaN and infinities become empty fields) and hand it to the system, so that
/// an interrupted file ends with a whole row. LITHE_NO_SPACE: cannot write; a torn row is taken back.
LitheStatus lth_csv_row(LitheCtx *ctx, LthCsv *csv, const double *values);

/// Close and clear the pointer. Accepts a pointer to NULL.
LitheStatus lth_csv_close(LitheCtx *ctx, LthCsv **csv);
