/// Tables as comma-separated text that is valid after every row: history.csv and probes.csv.
#pragma once

#include "base/archive.h"

typedef struct LthCsv LthCsv;

/// Create the file with a header line of `n` column names (quoted where they need it; copied).
LitheStatus lth_csv_open(LitheCtx *ctx, const char *path, int n, const char *const *names,
                         LthCsv **csv);

/// Open a file that an interrupted run left, to go on at the row where lth_csv_archive() was told to write.
/// LITHE_BAD_INPUT: it is not there.
LitheStatus lth_csv_reopen(LitheCtx *ctx, const char *path, int n, LthCsv **csv);

/// The length of the file up to its last whole row. Reading cuts a reopened file there; LITHE_BAD_INPUT in
/// the archive: it has become shorter.
void lth_csv_archive(LthCsv *csv, LthArchive *archive);

/// Append a row of n numbers (NaN and infinities become empty fields) and hand it to the system, so that
/// an interrupted file ends with a whole row. LITHE_NO_SPACE: cannot write; a torn row is taken back.
LitheStatus lth_csv_row(LitheCtx *ctx, LthCsv *csv, const double *values);

/// Close and clear the pointer. Accepts a pointer to NULL.
LitheStatus lth_csv_close(LitheCtx *ctx, LthCsv **csv);
