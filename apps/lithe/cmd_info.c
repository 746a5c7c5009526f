/// `lithe info`: version, build options, engines, licence.
#include "app.h"

#include <stdio.h>

int cmd_info(const Args *args) {
  (void)args;
  char text[4096];
  lithe_info(text, sizeof text);
  fputs(text, stdout);
  return fflush(stdout) == 0 ? 0 : lithe_status_exit(LITHE_NO_SPACE);
}
