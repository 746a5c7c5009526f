/// The thesis' studies, one function each.
#pragma once

#include "study/dolny.h"

LitheStatus lth_study_table_5_1(LthStudyRun *run);
LitheStatus lth_study_table_5_2(LthStudyRun *run);
LitheStatus lth_study_error_maps(LthStudyRun *run);      ///< Fig. 5.1
LitheStatus lth_study_condition(LthStudyRun *run);       ///< Fig. 5.4
LitheStatus lth_study_free_boundaries(LthStudyRun *run); ///< what the tables hide
LitheStatus lth_study_expansion(LthStudyRun *run);       ///< Fig. 5.5 ...
LitheStatus lth_study_compression(LthStudyRun *run);
LitheStatus lth_study_shear(LthStudyRun *run);
LitheStatus lth_study_gravity(LthStudyRun *run);
LitheStatus lth_study_circle(LthStudyRun *run);
LitheStatus lth_study_silhouette(LthStudyRun *run);
LitheStatus lth_study_rotation(LthStudyRun *run); ///< Fig. 5.11
