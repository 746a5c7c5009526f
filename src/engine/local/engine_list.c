/// The engines of this build.
#include "engine/local/engine_local.h"

#include <string.h>

static const LthEngine *const engines[] = {&lth_engine_cholmod};

int lth_engine_count(void) { return (int)(sizeof engines / sizeof engines[0]); }

const LthEngine *lth_engine_at(int i) {
  return i >= 0 && i < lth_engine_count() ? engines[i] : NULL;
}

const LthEngine *lth_engine_find(const char *name) {
  for (int i = 0; i < lth_engine_count(); i++)
    if (strcmp(engines[i]->name, name) == 0) return engines[i];
  return NULL;
}
