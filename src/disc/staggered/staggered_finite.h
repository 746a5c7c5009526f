/// Corotated and neo-Hookean bodies on the staggered grid: what the staggered_finite*.c files share.
/// docs/theory/staggered-finite.md.
#pragma once

#include "disc/staggered/staggered.h"
#include "material/finite.h"

#define LTH_FINITE_DOFS 30    ///< unknowns that a cell reads (2D: 12)
#define LTH_FINITE_ENTRIES 27 ///< entries of F in a cell (2D: 10)
#define LTH_FINITE_NODES 22   ///< slots that those unknowns stand at

/// Entry of F: component a differenced along b, (hi - lo) / h_b; diagonal at the centre, others at the edges along the
/// third axis.
typedef struct LthFiniteEntry {
  int a, b;
  int lo, hi;    ///< unknowns of the cell
  int edge;      ///< axis of its edge, -1 on the diagonal
  int offset[3]; ///< slot of the edge, from the cell's
  int kin[4];    ///< entries of the same a, b, this one among them
  int n_kin;
  int turned; ///< the first entry of b, a
} LthFiniteEntry;

/// What is the same for all cells of a dimension.
typedef struct LthFiniteLayout {
  int dim, n_dofs, n_entries, n_parts, n_nodes;
  int component[LTH_FINITE_DOFS], node[LTH_FINITE_DOFS]; ///< of unknowns
  int offset[LTH_FINITE_NODES][3];                       ///< of a node's slot from the cell's
  LthFiniteEntry entry[LTH_FINITE_ENTRIES];
  int part[8][9]; ///< entries that a part pairs, row-major (dim x dim)
} LthFiniteLayout;

/// What `nonlinear` of LthStaggered points to.
typedef struct LthStaggeredFinite {
  LthDiscTable table; ///< the linear body's, and calls of these files
  LthFiniteLayout layout;
  double *x;             ///< of the linearisation (n_dofs)
  double *partial;       ///< energies of cells (n_cells)
  int n_colors;          ///< cells of a colour share no unknown ...
  LitheIndex *color_off; ///<                                    (n_colors + 1)
  LitheIndex *color;     ///< ... so that each adds its own blocks (n_cells)
} LthStaggeredFinite;

/// One cell at a state: its unknowns, F of its parts, and how much each part weighs.
typedef struct LthFiniteCell {
  const LthStaggered *s;
  const LthFiniteLayout *layout;
  LitheIndex func[LTH_FINITE_NODES]; ///< function of a node, -1 where there is none
  bool alive[LTH_FINITE_DOFS];
  double u[LTH_FINITE_DOFS];
  int n_from[LTH_FINITE_ENTRIES]; ///< an entry is share times the sum of others, or itself
  int from[LTH_FINITE_ENTRIES][4];
  double share[LTH_FINITE_ENTRIES];
  double value[LTH_FINITE_ENTRIES];
  double weight[8]; ///< volume of a part [m^3]
  double volume;    ///< their sum
  unsigned loose[8];
  double lambda;
  LthFinite material;
} LthFiniteCell;

static inline LthStaggeredFinite *lth_staggered_finite_of(const LthStaggered *s) {
  return s->nonlinear;
}

// staggered_finite_layout.c

void lth_finite_lay_out(int dim, LthFiniteLayout *layout);

// staggered_finite_cell.c

/// A cell at the state x.
void lth_finite_cell_read(const LthStaggered *s, LitheIndex cell, const double *x,
                          LthFiniteCell *c);

/// F of a part (dim x dim).
void lth_finite_cell_gradient(const LthFiniteCell *c, int part, double *F);

/// Mean of v over the parts.
double lth_finite_cell_volume(const LthFiniteCell *c);

double lth_finite_cell_energy(const LthFiniteCell *c);

/// f (n_dofs of the layout) = d energy / du.
void lth_finite_cell_force(const LthFiniteCell *c, double *f);

/// K (n_dofs x n_dofs) = its tangent, semi-definite unless the body's `is_exact` is set.
void lth_finite_cell_tangent(const LthFiniteCell *c, double *K);

/// Mean Cauchy stress: xx yy zz yz zx xy [Pa].
void lth_finite_cell_stress(const LthFiniteCell *c, double stress[6]);

// staggered_finite_assemble.c

LitheStatus lth_finite_matrix_create(LitheCtx *ctx, const LthDisc *disc, LthBlockMatrix **K);
void lth_finite_assemble(LthDisc *disc, double t, LthBlockMatrix *K, double *f0);
void lth_finite_assemble_load(LthDisc *disc, double t, double *f0);

// staggered_finite.c

/// Make a built linear body one of s->model, with a table of its own in s->disc.
LitheStatus lth_staggered_finite_attach(LitheCtx *ctx, LthStaggered *s);
void lth_staggered_finite_free(LitheCtx *ctx, LthStaggered *s);
