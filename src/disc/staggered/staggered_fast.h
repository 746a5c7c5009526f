/// A level of the staggered multigrid as the fast kernels see it: blocks, single precision, no indices inside.
/// docs/theory/staggered-multigrid.md, "Kernels".
#pragma once

#include "base/isa.h"
#include "disc/staggered/staggered_hierarchy.h"

/// What a block holds. Inside a uniform one all samples that its unknowns touch have one material and all its
/// unknowns are free: its kernel has constant coefficients.
typedef enum LthBlockKind { LTH_BLOCK_EMPTY, LTH_BLOCK_UNIFORM, LTH_BLOCK_GENERAL } LthBlockKind;

typedef struct LthFastKernels LthFastKernels; // below

/// Vectors of a level hold rows of `side` cells along x in which some unknown is alive, component after component: that of
/// cell i stands at [row stride + a side + i]. Row 0 is of zeros, and stands for all that is not there.
typedef struct LthFastVector {
  float *at;
  LitheCount stride; ///< from row to row
} LthFastVector;

/// Coefficients are those of (cm M + ck K) / unit; unit is the same on all levels.
typedef struct LthFastLevel {
  const LthFastKernels *kernels; ///< of the widest instruction set that there is
  const LthStaggeredLevel *level;
  const LthSparseGrid *grid;
  double ratio[3];     ///< h_x / h_a
  double stiff, inert; ///< |cell| ck / (h_x^2 unit), |cell| cm / unit
  double stiffest;     ///< bound on the eigenvalues of K times the inverse of its diagonal
  double greatest;     ///< the same for the operator
  LitheIndex n_active; ///< blocks with unknowns that are not dead
  LitheIndex *active;  ///< ascending                                       (n_active)
  uint8_t *kind;       ///< LthBlockKind                                    (n_blocks)
  uint64_t *alive;     ///< rows of a block with unknowns that are alive            (n_blocks)
  LitheIndex n_rows;   ///< of vectors, with row 0
  LitheIndex *row;     ///< in vectors, of rows of slots                     (n_slots / side)
  LitheIndex *first;   ///< rows of vectors before those of a block          (n_blocks + 1)
  uint8_t *local;      ///< place of a row of vectors in its block           (n_rows)
  LitheIndex *number;  ///< rows of general blocks before those of a general one, else -1 (n_blocks)
  LitheIndex n_general;
  float *constant; ///< stiff lambda, stiff mu, inert rho of first rows        (n_blocks x 3)
  float *
      sample; ///< stiff (lambda, mu, shear xy, yz, zx) of the level's rows ((level->n_rows + 1) x 5 or 3 x side)
  float *inertia; ///< inert mass of unknowns, NULL where cm stays 0       (n_general x dim x side)
  float *inverse; ///< of the diagonal, 0 where not free                   (n_general x dim x side)
  LitheIndex
      *scaled; ///< rows with `scale` before those of a block that has one, else -1 (n_blocks)
  LitheIndex n_scaled;
  float *same_scale; ///< of all interpolated values of the other blocks    (n_blocks)
  float *pull;  ///< weight of unknowns in interpolation to a finer level, a vector; NULL: all alike
                ///<                                                (n_rows x dim x side)
  float *scale; ///< of interpolated values: 1 / sum of the weights that count, 0 where not free
                ///<                                                 (n_scaled x dim x side)
  LthFastVector x, y, b; ///< iterate, the one before, right-hand side
} LthFastLevel;

/// Sort the blocks of a level: enough for LthFastKernels.apply.
LitheStatus lth_fast_level_analyse(LitheCtx *ctx, const LthStaggeredLevel *level,
                                   LthFastLevel *fast);
/// Find out what rows and blocks hold, and number them: part of lth_fast_level_analyse().
LitheStatus lth_fast_level_sort(LitheCtx *ctx, LthFastLevel *fast);
/// Make room for coefficients, once; `with_mass`: cm may differ from 0. Vectors are the caller's.
LitheStatus lth_fast_level_reserve(LitheCtx *ctx, LthFastLevel *fast, bool with_mass);
void lth_fast_level_free(LitheCtx *ctx, LthFastLevel *fast);
/// Set coefficients for cm M + ck K.
void lth_fast_level_set(LitheCtx *ctx, LthFastLevel *fast, double cm, double ck, double unit);
/// Scales of the interpolation from a coarser level, once; both levels' x are overwritten.
LitheStatus lth_fast_level_link(LitheCtx *ctx, LthFastLevel *fast, LthFastLevel *coarse);
/// Forget them: there is no coarser level.
void lth_fast_level_unlink(LitheCtx *ctx, LthFastLevel *fast);
/// Zeros in all vectors.
void lth_fast_level_clear(LitheCtx *ctx, LthFastLevel *fast);
LitheCount lth_fast_level_bytes(const LthFastLevel *fast);

/// Values of a sample's row.
static inline int lth_fast_samples(const LthFastLevel *L) { return L->grid->dim == 3 ? 5 : 3; }
/// Values of a row of vectors.
static inline LitheIndex lth_fast_width(const LthFastLevel *L) {
  return L->grid->dim * L->grid->side;
}

/// Where component a of a slot stands in vectors without gaps; in row 0 where nothing of its row is alive.
static inline LitheCount lth_fast_place(const LthFastLevel *L, LitheCount slot, int a) {
  const int bits = L->grid->dim == 3 ? 3 : 4; // log2 of the cells along a row
  return L->row[slot >> bits] * (LitheCount)lth_fast_width(L) + (a << bits) +
         (slot & ((1 << bits) - 1));
}
static inline float *lth_fast_value(const LthFastLevel *L, LthFastVector v, LitheCount slot,
                                    int a) {
  const int bits = L->grid->dim == 3 ? 3 : 4;
  return v.at + L->row[slot >> bits] * v.stride + (a << bits) + (slot & ((1 << bits) - 1));
}

/// The slot of the first cell of row q of vectors, which is in a block.
static inline LitheCount lth_fast_slot(const LthFastLevel *L, LitheIndex block, LitheIndex q) {
  return (LitheCount)block * L->grid->block_cells + L->local[q] * (LitheCount)L->grid->side;
}

/// Place of the samples of a block's first row: those of all its rows in a uniform one.
static inline LitheCount lth_fast_constant(const LthFastLevel *L, LitheIndex block) {
  const LitheIndex side = L->grid->side, rows = L->grid->block_cells / side;
  return (LitheCount)L->level->row[block * (LitheCount)rows] * side;
}

/// One step of a polynomial smoother.
typedef struct LthFastStep {
  float momentum, length; ///< y <- x + momentum (x - y) + length D^-1 (b - A x)
  bool fresh;             ///< y counts as zero
  bool product;           ///< b . (new y) is wanted
} LthFastStep;

/// Kernels on one block; the same for 2D and 3D.
struct LthFastKernels {
  /// A step; returns b . (new y), or 0.
  double (*smooth)(const LthFastLevel *L, LitheIndex block, LthFastStep step);
  /// x = length D^-1 b.
  void (*start)(const LthFastLevel *L, LitheIndex block, float length);
  /// y = scale (b - A x), and y = scale b: ready to be restricted.
  void (*residual)(const LthFastLevel *L, LitheIndex block);
  void (*weigh)(const LthFastLevel *L, LitheIndex block);
  /// Right-hand side of a coarse block from the fine level's y.
  void (*restrict_to)(const LthFastLevel *fine, const LthFastLevel *coarse,
                      LitheIndex coarse_block);
  /// x += P x_coarse (or x = ...) in the fine blocks below a coarse one.
  void (*prolong_from)(const LthFastLevel *fine, const LthFastLevel *coarse,
                       LitheIndex coarse_block, bool add);
  /// q = (cm M + ck K) p in double precision, unit not taken out; both without gaps. 0 where not free, or
  /// (`held`) where dead. Returns p . q.
  double (*apply)(const LthFastLevel *L, LitheIndex block, double cm, double ck, bool held,
                  const double *p, double *q);
};

/// Those of an instruction set, NULL where this processor does not have it.
const LthFastKernels *lth_fast_kernels_for(int dim, LthIsa isa);
