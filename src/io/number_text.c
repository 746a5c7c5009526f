/// Numbers as text that reads back to the same bits, whatever the locale says of decimal points.
#include "io/number_text.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *lth_number_text(double value, char text[LTH_NUMBER_TEXT_MAX]) {
  if (isnan(value)) return strcpy(text, "nan");
  if (isinf(value)) return strcpy(text, value > 0 ? "inf" : "-inf");
  for (int digits = 15; digits <= 17; digits++) {
    snprintf(text, LTH_NUMBER_TEXT_MAX, "%.*g", digits, value);
    if (strtod(text, NULL) == value) break;
  }

  // a user's program may have set a locale with a decimal comma
  char *comma = strchr(text, ',');
  if (comma) *comma = '.';
  return text;
}
