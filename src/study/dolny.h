/// The studies of Dolny 2025, "Staggered variational elasticity": what its figures and tables share.
#pragma once

#include "study/study_run.h"

/// A row of Tables 5.1 and 5.2: L1 and Linf error with N cells over a domain of 2.
typedef struct LthPrintedError {
  int cells;
  double l1, linf;
} LthPrintedError;

#define LTH_PRINTED_ROWS 14

extern const LthPrintedError
    lth_dolny_table_5_1[LTH_PRINTED_ROWS]; ///< traction outside, held inside
extern const LthPrintedError lth_dolny_table_5_2[LTH_PRINTED_ROWS]; ///< held on both sides

/// A problem whose solution is known, in the words of a scene: x and y are the place at rest [m]. Texts live in the
/// run's arena.
typedef struct LthExactCase {
  const char *shape;           ///< the body, as a scene says it
  const char *held;            ///< `where` of its held boundary
  const char *displacement[2]; ///< [m]
  const char *stress[4];       ///< xx xy yx yy [Pa]; NULL: the rest of the boundary is free
  const char *body_force[2];   ///< [N/m^3]; NULL: none
  double young, poisson;
} LthExactCase;

/// Equations (5.1) and what goes before them: mu = lambda = 1 Pa, an annulus from 0.325 to 0.8.
/// phi = (cos 2 pi x cos 2 pi y, sin 2 pi x sin 2 pi y); `is_held_outside`: Table 5.2, else 5.1.
LthExactCase lth_exact_manufactured(bool is_held_outside);

/// Lame's ring: the inner circle is pushed out by 1 m, the outer one is free. Plane strain, E = 1 Pa.
LthExactCase lth_exact_ring(LthStudyRun *run, double poisson);

/// Kirsch's hole (radius 0.325 m about (cx, cy)) in a plate pulled by 1 Pa along x; the plate's rim, a square of 2 m,
/// moves as in the infinite one. Plane strain, E = 1 Pa.
LthExactCase lth_exact_hole(LthStudyRun *run, double poisson, double cx, double cy);

/// A ring cut out of a rotating disc (rho omega^2 = 1 N/m^4, radius 0.8 m): held at 0.325 m, free outside. Plane strain,
/// E = 1 Pa.
LthExactCase lth_exact_rotating(LthStudyRun *run, double poisson);

/// How a case is discretised.
typedef struct LthExactMethod {
  int cells;             ///< N over a domain of 2 m
  double shift[2];       ///< of the grid, in cells
  const char *fractions; ///< as a scene says it: "exact", "smooth", "{samples: 8}"
  const char *more;      ///< further keys of the method, ", formulation: mixed", or ""
  const char *held_too;  ///< a further constraint's `where` that reaches inside, or NULL
} LthExactMethod;

/// The whole scene of a case.
const char *lth_exact_scene(LthStudyRun *run, const char *title, const LthExactCase *which,
                            const LthExactMethod *method);

/// Errors at grid nodes as the thesis takes them: a node's value is the mean of its two neighbouring unknowns. L1 is the sum
/// of |e_x| + |e_y| times h^2, Linf the largest component.
typedef struct LthNodeErrors {
  double inner, outer; ///< radii about the origin between which nodes count, widened by half a cell
  bool only_whole; ///< leave out nodes that have not all their unknowns (beyond a free boundary)
  double l1, linf; ///< filled by lth_node_errors_look()
} LthNodeErrors;

/// An LthRunLook: `user` is an LthNodeErrors. Unknowns that are held or not there count with
/// their exact value.
LitheStatus lth_node_errors_look(void *user, LitheCtx *ctx, const LthWorld *world,
                                 LitheIndex frame);
