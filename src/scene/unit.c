/// A table of names, and a reader of products of powers.
#include "scene/unit.h"

#include "scene/report.h"

#include <string.h>
#include <strings.h>

typedef struct Name {
  const char *name;
  bool takes_prefix;
  LthUnit unit; ///< factor; powers of m, kg, s, rad
} Name;

#define DEGREE 0.017453292519943295769

static const Name names[] = {
    {"m", true, {1, {1, 0, 0, 0}}},        {"g", true, {1e-3, {0, 1, 0, 0}}},
    {"s", true, {1, {0, 0, 1, 0}}},        {"N", true, {1, {1, 1, -2, 0}}},
    {"Pa", true, {1, {-1, 1, -2, 0}}},     {"J", true, {1, {2, 1, -2, 0}}},
    {"W", true, {1, {2, 1, -3, 0}}},       {"Hz", true, {1, {0, 0, -1, 0}}},
    {"rad", true, {1, {0, 0, 0, 1}}},      {"deg", false, {DEGREE, {0, 0, 0, 1}}},
    {"°", false, {DEGREE, {0, 0, 0, 1}}},  {"t", false, {1e3, {0, 1, 0, 0}}},
    {"min", false, {60, {0, 0, 1, 0}}},    {"h", false, {3600, {0, 0, 1, 0}}},
    {"L", true, {1e-3, {3, 0, 0, 0}}},     {"l", true, {1e-3, {3, 0, 0, 0}}},
    {"bar", true, {1e5, {-1, 1, -2, 0}}},  {"in", false, {0.0254, {1, 0, 0, 0}}},
    {"ft", false, {0.3048, {1, 0, 0, 0}}},
};

static const struct {
  const char *name;
  double factor;
} prefixes[] = {
    {"T", 1e12}, {"G", 1e9},  {"M", 1e6},  {"k", 1e3},  {"h", 1e2},  {"da", 1e1}, {"d", 1e-1},
    {"c", 1e-2}, {"m", 1e-3}, {"u", 1e-6}, {"µ", 1e-6}, {"μ", 1e-6}, {"n", 1e-9}, {"p", 1e-12},
};

static const struct {
  const char *name;
  int power[LTH_BASE_UNITS];
} quantities[] = {
    {"a number without unit", {0, 0, 0, 0}},
    {"a length", {1, 0, 0, 0}},
    {"an area", {2, 0, 0, 0}},
    {"a volume", {3, 0, 0, 0}},
    {"a mass", {0, 1, 0, 0}},
    {"a time", {0, 0, 1, 0}},
    {"an angle", {0, 0, 0, 1}},
    {"a rate", {0, 0, -1, 0}},
    {"a velocity", {1, 0, -1, 0}},
    {"an acceleration", {1, 0, -2, 0}},
    {"a force", {1, 1, -2, 0}},
    {"a pressure", {-1, 1, -2, 0}},
    {"an energy", {2, 1, -2, 0}},
    {"a power", {2, 1, -3, 0}},
    {"a density", {-3, 1, 0, 0}},
    {"a force per volume", {-2, 1, -2, 0}},
    {"a pressure per length", {-2, 1, -2, 0}},
};

#define COUNT(table) (sizeof(table) / sizeof(table)[0])

static const Name *find_name(const char *text, size_t length) {
  for (size_t i = 0; i < COUNT(names); i++)
    if (strlen(names[i].name) == length && memcmp(names[i].name, text, length) == 0)
      return &names[i];
  return NULL;
}

/// A name with or without prefix; whole names go first ("min" is a minute, not a milli-inch).
static bool parse_name(const char *text, size_t length, LthUnit *unit) {
  const Name *name = find_name(text, length);
  if (name) {
    *unit = name->unit;
    return true;
  }
  for (size_t i = 0; i < COUNT(prefixes); i++) {
    size_t n = strlen(prefixes[i].name);
    if (n >= length || memcmp(prefixes[i].name, text, n) != 0) continue;
    name = find_name(text + n, length - n);
    if (!name || !name->takes_prefix) continue;
    *unit = name->unit;
    unit->factor *= prefixes[i].factor;
    return true;
  }
  return false;
}

/// `^3`, `^-2`, `3` behind a name: 1 where there is none. -100 for what is no power.
static int parse_power(const char **text) {
  const char *c = *text;
  bool has_caret = *c == '^';
  if (has_caret) c++;
  bool is_negative = has_caret && *c == '-';
  if (is_negative) c++;
  if (*c < '0' || *c > '9') return has_caret ? -100 : 1;
  int power = *c++ - '0';
  *text = c;
  return *c >= '0' && *c <= '9' ? -100 : is_negative ? -power : power;
}

static void multiply(LthUnit *unit, const LthUnit *by, int power) {
  for (int i = 0; i < LTH_BASE_UNITS; i++) unit->power[i] += power * by->power[i];
  for (int i = 0; i < power; i++) unit->factor *= by->factor;
  for (int i = 0; i > power; i--) unit->factor /= by->factor;
}

/// Bytes of a name: up to a space, an operator, a digit or the dot "·" (two bytes).
static size_t name_length(const char *c) {
  size_t n = 0;
  while (c[n] && !strchr(" \t*/^-0123456789()", c[n]) && strncmp(c + n, "·", 2) != 0) n++;
  return n;
}

static bool fail_at(const char *at, size_t length, const char **bad, size_t *bad_length) {
  if (bad) {
    *bad = at;
    *bad_length = length ? length : strlen(at);
  }
  return false;
}

bool lth_unit_parse(const char *text, LthUnit *unit, const char **bad, size_t *bad_length) {
  *unit = (LthUnit){.factor = 1};
  const char *c = text + strspn(text, " \t");
  if (strcmp(c, "1") == 0 || !*c) return true;
  int sign = 1, n_factors = 0;
  if (strncmp(c, "1/", 2) == 0) c += 2, sign = -1;
  while (*c) {
    size_t length = name_length(c);
    LthUnit factor;
    if (++n_factors > 8 || length == 0 || !parse_name(c, length, &factor))
      return fail_at(c, length, bad, bad_length);
    const char *start = c;
    c += length;
    int power = parse_power(&c);
    if (power == -100) return fail_at(start, 0, bad, bad_length);
    multiply(unit, &factor, sign * power);

    // a slash turns the next factor only; a star, a dot or a space none
    c += strspn(c, " \t");
    sign = *c == '/' ? -1 : 1;
    const char *operator_at = c;
    if (*c == '/' || *c == '*')
      c++;
    else if (strncmp(c, "·", strlen("·")) == 0)
      c += strlen("·");
    c += strspn(c, " \t");
    if (c != operator_at && !*c) return fail_at(operator_at, 0, bad, bad_length);
  }
  return true;
}

bool lth_unit_same(const LthUnit *a, const LthUnit *b) {
  return memcmp(a->power, b->power, sizeof a->power) == 0;
}

const char *lth_unit_quantity(const LthUnit *unit) {
  for (size_t i = 0; i < COUNT(quantities); i++)
    if (memcmp(unit->power, quantities[i].power, sizeof unit->power) == 0)
      return quantities[i].name;
  return NULL;
}

const char *lth_unit_nearest(const char *name) {
  static const char *const common[] = {"m",   "mm",  "cm", "um", "km", "g",   "kg",  "t",   "s",
                                       "ms",  "min", "h",  "N",  "kN", "MN",  "mN",  "Pa",  "kPa",
                                       "MPa", "GPa", "J",  "W",  "Hz", "kHz", "rad", "deg", "bar"};
  const char *nearest = NULL;
  int best = 2;
  for (size_t i = 0; i < COUNT(common); i++) {
    // names of one letter are near to any other: only their case may be wrong
    bool is_short = strlen(common[i]) < 2 && strlen(name) < 2;
    int distance = strcasecmp(name, common[i]) == 0 ? 0
                   : is_short                       ? 2
                                                    : lth_word_distance(name, common[i], 1);
    if (distance < best) {
      best = distance;
      nearest = common[i];
    }
  }
  return nearest;
}
