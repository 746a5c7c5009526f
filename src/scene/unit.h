/// Units of numbers: SI with prefixes, a few others, and products of their powers.
#pragma once

#include <stdbool.h>
#include <stddef.h>

/// Powers of the base units; the angle counts as one, so that Hz and rad/s are told apart.
typedef enum LthBaseUnit {
  LTH_UNIT_M,
  LTH_UNIT_KG,
  LTH_UNIT_S,
  LTH_UNIT_RAD,
  LTH_BASE_UNITS
} LthBaseUnit;

typedef struct LthUnit {
  double factor; ///< one of it in SI
  int power[LTH_BASE_UNITS];
} LthUnit;

/// Parse "GPa", "g/cm^3", "m/s^2", "1/s", "kg m^-3", "N*m", "" and "1" (no dimension). False where a name is unknown; then
/// `bad` (may be NULL) and `bad_length` say which.
bool lth_unit_parse(const char *text, LthUnit *unit, const char **bad, size_t *bad_length);

bool lth_unit_same(const LthUnit *a, const LthUnit *b); ///< the same dimension

/// "a length", "a pressure", or NULL for dimensions without a common name.
const char *lth_unit_quantity(const LthUnit *unit);

/// The known name nearest to a wrong one, NULL if none is near.
const char *lth_unit_nearest(const char *name);
