/// The open struct of the multilevel preconditioner, shared by the files ml_*.c.
#pragma once

#include "la/multilevel.h"

#define LTH_ML_MODES 6   ///< rigid motions: the most unknowns of an aggregate
#define LTH_ML_PADDED 8  ///< doubles of a padded row of up to LTH_ML_MODES columns
#define LTH_ML_STEPS 2   ///< of the prolongation's smoothing
#define LTH_ML_LEVELS 16 ///< more than any mesh in memory needs
#define LTH_ML_ROW 105   ///< most unknowns of a block row: degree 4, three components

/// Prolongation between two levels: blocks by row, and the same blocks listed by column.
typedef struct LthTransfer {
  LitheIndex n_rows, n_cols;
  LitheCount *row_off,
      *col_off;          ///< first scalar row, column of a block    (n_rows + 1), (n_cols + 1)
  LitheCount *block_off; ///< blocks of a row                        (n_rows + 1)
  LitheIndex *block_col; ///< ascending in a row                     (n_blocks)
  LitheCount *value_off; ///< (n_blocks + 1)
  float *values; ///< row-major blocks; every matrix below is that of the rounded prolongation
  LitheCount *twin_off; ///< blocks of a column                     (n_cols + 1)
  LitheCount *twin;     ///< block index, rows ascending            (n_blocks)
  LitheIndex *twin_row; ///< its row                                (n_blocks)
} LthTransfer;

/// Rows in colours: no two of one colour are coupled.
typedef struct LthColours {
  int count;
  int *colour;     ///< of a row             (n_rows)
  LitheIndex *off; ///< rows of a colour     (count + 1)
  LitheIndex *row; ///< ascending in a colour (n_rows)
} LthColours;

typedef struct LthLevel {
  LitheIndex n_aggregates;
  const LthBlockMatrix *A;
  LthBlockMatrix *own; ///< A, but on the finest level
  LthBlockJacobi *jacobi;
  const LthBlockMatrix *touch; ///< what the next level has beside A, or NULL
  int size;                    ///< unknowns of a block row, 0 where they differ
  const double *extra;         ///< added to the diagonal blocks of A, or NULL; borrowed
  LitheCount *extra_off;       ///< its blocks                                 (n_rows + 1)
  LthColours colours;
  uint8_t *held;                        ///< unknowns without coupling                  (n)
  double *near;                         ///< rigid motions, row-major                   (n x 6)
  LitheIndex *aggregate;                ///< of a block row; -1: in none                (n_rows)
  LitheIndex *member_off, *member;      ///< block rows of an aggregate, ascending
  double *tentative;                    ///< orthonormal rigid motions of each aggregate (n x 6)
  LthTransfer *stage[LTH_ML_STEPS + 1]; ///< tentative prolongation, smoothed once, ...
  LthTransfer *P;    ///< from the next level: the last stage; NULL: leading unknowns
  LitheIndex *lead;  ///< leading unknowns of a row that the next level has, or NULL (n_rows)
  double *x, *b, *r; ///< (n)
  double *q, *h, *v, *s, *t, *e; ///< of the polynomial smoother             (n)
} LthLevel;

/// Scratch of the products, kept for updates.
typedef struct LthGalerkin {
  int threads;
  LitheIndex n_rows,
      most; ///< rows of the largest fine level; most rows that a column's product has
  LitheIndex *slot, *list; ///< (threads x n_rows), (threads x most)
  double *product;         ///< (threads x most x block)
  LitheCount block;        ///< doubles of one row's block of a product
} LthGalerkin;

struct LthMultilevel {
  LthMultilevelDef def;
  int n_levels;
  int degree; ///< of the polynomial smoother; 0: sweeps
  LthLevel level[LTH_ML_LEVELS];
  LthOperator added; ///< to A, in residuals of the finest level instead of extra; apply NULL: none
  double *dense;     ///< Cholesky factor of the coarsest level, row-major
  LthGalerkin galerkin;
  LitheCount bytes;
};

static inline int lth_ml_size(const LthBlockMatrix *A, LitheIndex row) {
  return (int)(A->row_off[row + 1] - A->row_off[row]);
}

// ml_aggregate.c

/// Split the block rows into aggregates of strongly coupled ones; rows without coupling belong to none. Where aggregates have
/// fewer than `least_rows` rows on the mean, weaker couplings count as strong.
LitheStatus lth_ml_aggregate(LitheCtx *ctx, const LthBlockMatrix *A, LitheIndex least_rows,
                             LitheIndex *aggregate, LitheIndex *n_aggregates);

// ml_smooth.c

LitheStatus lth_ml_colour(LitheCtx *ctx, const LthBlockMatrix *A, LthColours *colours);
void lth_ml_free_colours(LitheCtx *ctx, LthColours *colours);

/// x = one sweep of block Gauss-Seidel from zero, r = b - A x.
void lth_ml_smooth_down(const LthLevel *level, int threads, const double *b, double *x, double *r);

/// The sweep in the opposite order, from x.
void lth_ml_smooth_up(const LthLevel *level, int threads, const double *b, double *x);

/// `degree` steps of Chebyshev's iteration on A preconditioned by symmetric Gauss-Seidel; down: from zero and
/// r = b - A x; up: from x.
void lth_ml_polynomial_down(const LthLevel *level, int threads, int degree, const double *b,
                            double *x, double *r);
void lth_ml_polynomial_up(const LthLevel *level, int threads, int degree, const double *b,
                          double *x);

/// Largest eigenvalue of D^-1 A, D the diagonal blocks, from below by a few power steps.
double lth_ml_spectral_radius(LthLevel *level, int threads);

// ml_transfer.c

/// Patterns: one block in every row of an aggregate; and that of A times another. Owned by the caller also
/// after a failure.
LitheStatus lth_ml_transfer_create(LitheCtx *ctx, const LthLevel *fine, const LitheCount *col_off,
                                   LthTransfer **P);
LitheStatus lth_ml_transfer_spread(LitheCtx *ctx, const LthBlockMatrix *A, const LthTransfer *in,
                                   LthTransfer **P);
LitheIndex lth_ml_transfer_widest(const LthTransfer *P); ///< most blocks of a row
void lth_ml_transfer_destroy(LitheCtx *ctx, LthTransfer **P);

/// b_coarse = P^T r and x += P e.
void lth_ml_restrict(const LthTransfer *P, int threads, const double *r, double *b);
void lth_ml_prolong(const LthTransfer *P, int threads, const double *e, double *x);

// ml_prolongator.c

/// List the members of aggregates, find their unknowns on the next level: col_off (n_aggregates + 1).
LitheStatus lth_ml_tentative_create(LitheCtx *ctx, LthLevel *fine, LitheCount *col_off);

/// Orthonormal motions into fine->tentative, their coordinates into `near` of the next level (n x 6).
void lth_ml_tentative(LthLevel *fine, int threads, const LitheCount *col_off, double *near);

/// P = the polynomial in D^-1 A of the tentative prolongation, stage after stage.
void lth_ml_smooth_prolongator(LthLevel *fine, const LthGalerkin *g);

// ml_padded.c

/// to (m x 8) = B (m x n), zeros behind.
void lth_ml_pad(int m, int n, const float *B, double *to);

/// W (m x 8) += B Q, Q (n x 8); B_rk is B[r * row_stride + k * col_stride].
void lth_ml_add_product(int m, int n, const double *B, LitheCount row_stride, LitheCount col_stride,
                        const double *Q, double *W);

// ml_galerkin.c

/// An empty matrix with the pattern of P^T (A + touch) P; makes scratch as large as this level needs.
LitheStatus lth_ml_galerkin_create(LitheCtx *ctx, const LthLevel *fine, LthGalerkin *g,
                                   LthBlockMatrix **coarse);
void lth_ml_galerkin_free(LitheCtx *ctx, LthGalerkin *g);

/// coarse = P^T (A + touch) P.
void lth_ml_galerkin(const LthLevel *fine, const LthGalerkin *g, LthBlockMatrix *coarse);

/// The leading unknowns `lead` of every row (n_rows): pattern, and values.
LitheStatus lth_ml_leading_create(LitheCtx *ctx, const LthLevel *fine, LthBlockMatrix **coarse);
void lth_ml_leading(const LthLevel *fine, int threads, LthBlockMatrix *coarse);

// ml_dense.c

/// Lower Cholesky factor of A as a full row-major matrix (n x n); false: not definite.
bool lth_ml_dense_factor(const LthBlockMatrix *A, double *L);
void lth_ml_dense_solve(LitheCount n, const double *L, const double *b, double *x);
