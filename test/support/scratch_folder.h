/// A folder of a test's own: made before a group of tests, removed after it.
#pragma once

#include "check.h"

#include <string.h>
#include <unistd.h>

static char folder[64];

static inline int make_folder(void **state) {
  (void)state;
  strcpy(folder, "/tmp/lithe_test_XXXXXX");
  return mkdtemp(folder) ? 0 : -1;
}

static inline int remove_folder(void **state) {
  (void)state;
  char command[128];
  snprintf(command, sizeof command, "rm -rf '%s'", folder);
  return system(command);
}
