/// The studies of "Flexible simulation of deformable models using discontinuous Galerkin FEM" (Kaufmann et al. 2009).
#include "study/kaufmann_studies.h"

const LthStudy lth_studies_kaufmann[] = {
    {"kaufmann/fig1", "Consistency of IP, inconsistency of BZ",
     "Is x^2 found by quadratic functions, whatever the penalty?", lth_study_consistency},
    {"kaufmann/fig2", "Convergence and condition numbers in the plane",
     "What are the orders and condition numbers of CG, IP and BZ, and does BZ converge?",
     lth_study_convergence},
    {0}};
