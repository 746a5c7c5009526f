/// The studies of Kaufmann et al. 2009, one function a figure or table.
#pragma once

#include "study/study_run.h"

LitheStatus lth_study_consistency(LthStudyRun *run); ///< Fig. 1
LitheStatus lth_study_convergence(LthStudyRun *run); ///< Fig. 2
