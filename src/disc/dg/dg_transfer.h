/// Positions and velocities from the elements before a change of the mesh to those after it, and planes from
/// deformed space back to rest (docs/theory/dg.md, section "When elements change").
#pragma once

#include "disc/dg/dg_space.h"
#include "mesh/piece.h"

/// Coefficients (nb x 3) of one cell's polynomial in the basis of a cell of another space, whose degree is not
/// lower: the same polynomial, wherever the two cells lie. Cells with the same basis get the same bits.
void lth_dg_translate(const LthDgSpace *from, LitheIndex from_cell, const double *coef,
                      const LthDgSpace *to, LitheIndex to_cell, double *out);

/// A change of elements as the pieces that old and new ones have in common: atoms, each a part (or the whole) of one old cell
/// and of one new one. After splits the atoms are the new cells, before merges the old ones. Cells that are what they were need
/// none.
typedef struct LthDgTransfer {
  const LthDgSpace *from, *to;
  const LthMesh *atoms;
  LitheIndex n_atoms;
  const LitheIndex *from_cell; ///< old cell of an atom                     (n_atoms)
  const LitheIndex *to_cell;   ///< new cell of an atom, -1: taken away; those of a new cell fill it
  const LitheIndex
      *atom; ///< cell of `atoms` that it is, -1: its old cell; NULL: of the same number
  const LitheIndex
      *same; ///< by new cell: the old cell, of the same basis, that it is, -1: another; NULL: all
} LthDgTransfer;

/// Transfer a field: coefficients `coef` of the old space to `out` of the new. A new cell with one atom whose degree is
/// not lower gets the old cell's polynomial: values stay as they are, to rounding. Others get the L2 projection of what is on
/// their atoms, which keeps int v and int X x v, and does not raise int |v|^2. Cells without atoms are not written.
LitheStatus lth_dg_transfer(LitheCtx *ctx, const LthDgTransfer *transfer, const double *coef,
                            double *out);

/// The atoms of new cell c are atom[off[c]] ... atom[off[c + 1] - 1]. The caller frees both, also after a failure.
LitheStatus lth_dg_sort_atoms(LitheCtx *ctx, const LthDgTransfer *transfer, LitheIndex **off,
                              LitheIndex **atom);

/// Places and velocities before and after a transfer, and the density of old cells; those of new ones are the means.
typedef struct LthDgMotion {
  const LthDgTransfer *transfer;
  const double *density_from; ///< (cells of `from`)
  const double *x_from, *v_from, *x_to;
  double *v_to;
} LthDgMotion;

/// New cells that were projected get the momentum, and the angular momentum about the centre of mass, of what they are made of: by a
/// translation and a turn of each. Projections alone miss *int rho (x - Px) x (v - Pv)* of the latter, and where densities differ some
/// of the former. The kinetic energy stays at most what it was, but for what a turn with less inertia needs: where it would grow, the
/// rest of the motion is slowed down.
LitheStatus lth_dg_keep_motion(LitheCtx *ctx, const LthDgMotion *motion);

/// The plane in rest space that a cell's map (positions x) takes to `deformed`: exactly for affine maps; for others
/// the plane that touches its preimage in the point next to the cell's centroid (docs/theory/dg.md). False where
/// the map is flat across the plane.
bool lth_dg_plane_to_rest(const LthDgSpace *space, LitheIndex cell, const double *x,
                          const LthPlane *deformed, LthPlane *rest);
