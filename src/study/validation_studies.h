/// The cases of the validation book, one function each.
#pragma once

#include "study/validation_case.h"

/// The unit cube with cells that are crooked inside and straight on its sides.
extern const LthBlockModel lth_crooked_cube;

LitheStatus lth_study_patch_test(LthStudyRun *run);
LitheStatus lth_study_tension(LthStudyRun *run);    ///< constant strain by a load
LitheStatus lth_study_cantilever(LthStudyRun *run); ///< Timoshenko
LitheStatus lth_study_cook(LthStudyRun *run);
LitheStatus lth_study_cylinder(LthStudyRun *run); ///< Lame
LitheStatus lth_study_sphere(LthStudyRun *run);   ///< Lame
LitheStatus lth_study_kirsch(LthStudyRun *run);
LitheStatus lth_study_le1(LthStudyRun *run);  ///< NAFEMS
LitheStatus lth_study_le10(LthStudyRun *run); ///< NAFEMS
LitheStatus lth_study_hertz(LthStudyRun *run);
LitheStatus lth_study_bar(LthStudyRun *run); ///< free vibration
