/// The program: chooses the command.
#include "lithe/base.h"

#include <stdio.h>

int main(void) {
  printf("lithe %s\n", lithe_version());
  return 0;
}
