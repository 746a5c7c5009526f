/// The list of all studies.
#pragma once

#include "study/study_run.h"

/// Study number i in the order in which they run, or NULL.
const LthStudy *lth_study_at(LitheIndex i);

/// Whether a word names a study: its own name, its group's, or "all".
bool lth_study_is_meant(const LthStudy *study, const char *word);
