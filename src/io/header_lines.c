/// Lines of a text header in front of binary data.
#include "io/header_lines.h"

LitheStatus lth_header_line(LthHeaderLines *p, bool *is_there) {
  size_t n = 0;
  *is_there = p->at < p->size;
  if (!*is_there) return LITHE_OK;
  p->line++;
  while (p->at < p->size && p->data[p->at] != '\n') {
    if (n + 1 == sizeof p->text)
      LTH_FAIL_LINE(p, "a line longer than %d bytes", LTH_HEADER_LINE - 1);
    p->text[n++] = p->data[p->at++];
  }
  p->at++;
  while (n > 0 && (p->text[n - 1] == '\r' || p->text[n - 1] == ' ')) n--;
  p->text[n] = 0;
  return LITHE_OK;
}
