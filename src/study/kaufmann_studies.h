/// The studies of Kaufmann et al. 2009, one function a figure or table.
#pragma once

#include "study/study_run.h"

LitheStatus lth_study_consistency(LthStudyRun *run); ///< Fig. 1
LitheStatus lth_study_convergence(LthStudyRun *run); ///< Fig. 2
LitheStatus lth_study_limits(LthStudyRun *run);      ///< Fig. 3
LitheStatus lth_study_integration(LthStudyRun *run); ///< Fig. 4
LitheStatus lth_study_smoothness(LthStudyRun *run);  ///< Fig. 5
LitheStatus lth_study_contact(LthStudyRun *run);     ///< Fig. 6
LitheStatus lth_study_ears(LthStudyRun *run);        ///< Fig. 7
LitheStatus lth_study_slices(LthStudyRun *run);      ///< Fig. 7
LitheStatus lth_study_pencil(LthStudyRun *run);      ///< Fig. 10, left
LitheStatus lth_study_carve(LthStudyRun *run);       ///< Fig. 10, right
LitheStatus lth_study_slivers(LthStudyRun *run);     ///< section 9.6
LitheStatus lth_study_table_1(LthStudyRun *run);
LitheStatus lth_study_refinement(LthStudyRun *run); ///< Fig. 8
LitheStatus lth_study_locking(LthStudyRun *run);    ///< Fig. 9
LitheStatus lth_study_small(LthStudyRun *run);      ///< Fig. 11
LitheStatus lth_study_thin(LthStudyRun *run);       ///< Fig. 12
LitheStatus lth_study_warping(LthStudyRun *run);    ///< of the video
