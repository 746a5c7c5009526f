/// Numbers as text that reads back to the same bits, whatever the locale says of decimal points.
#pragma once

#include "base/ctx.h"

#define LTH_NUMBER_TEXT_MAX 32

/// Shortest of 15 to 17 digits that reads back to `value`; "nan", "inf" and "-inf" for the others.
/// Returns `text`.
const char *lth_number_text(double value, char text[LTH_NUMBER_TEXT_MAX]);
