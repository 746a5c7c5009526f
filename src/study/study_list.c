/// The list of all studies, group by group.
#include "study/study_list.h"

#include <string.h>

static const LthStudy *const groups[] = {lth_studies_kaufmann, lth_studies_adapt, lth_studies_dolny,
                                         lth_studies_validation};

const LthStudy *lth_study_at(LitheIndex i) {
  if (i < 0) return NULL;
  for (size_t g = 0; g < sizeof groups / sizeof groups[0]; g++)
    for (const LthStudy *study = groups[g]; study->name; study++)
      if (i-- == 0) return study;
  return NULL;
}

bool lth_study_is_meant(const LthStudy *study, const char *word) {
  size_t length = strlen(word);
  if (strcmp(word, "all") == 0 || strcmp(word, study->name) == 0) return true;
  return strncmp(study->name, word, length) == 0 && study->name[length] == '/';
}
