/// NRRD files: lines "field: value" up to an empty line, then the values or the name of their file.
#include "io/header_lines.h"
#include "io/volume_data.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

typedef struct Nrrd {
  LthHeaderLines in;
  LthVolumeHeader h;
  int n_dims;
  char *value; ///< within in.text
  bool has_sizes, has_type, has_encoding, has_endian;
  double axes[9], origin[3], spacing[3], unit; ///< a column of `axes` to each voxel axis
  bool has_axes, has_spacing;
} Nrrd;

static bool is_word(const char *text, const char *const *words) {
  for (int i = 0; words[i]; i++)
    if (strcasecmp(text, words[i]) == 0) return true;
  return false;
}

/// Up to `n` numbers, separated by blanks, commas and brackets; returns how many there were.
static int read_numbers(const char *text, int n, double *numbers) {
  int count = 0;
  while (*text) {
    text += strspn(text, " \t(),");
    if (!*text) break;
    char *end;
    double value = strtod(text, &end);
    if (end == text || (*end && !strchr(" \t(),", *end))) return -1;
    if (count < n) numbers[count] = value;
    count++;
    text = end;
  }
  return count;
}

static LitheStatus read_type(Nrrd *p) {
  static const char *const names[LTH_VOXEL_TYPES][10] = {
      {"signed char", "int8", "int8_t", NULL},
      {"uchar", "unsigned char", "uint8", "uint8_t", NULL},
      {"short", "short int", "signed short", "signed short int", "int16", "int16_t", NULL},
      {"ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t", NULL},
      {"int", "signed int", "int32", "int32_t", NULL},
      {"uint", "unsigned int", "uint32", "uint32_t", NULL},
      {"longlong", "long long", "long long int", "signed long long", "signed long long int",
       "int64", "int64_t", NULL},
      {"ulonglong", "unsigned long long", "unsigned long long int", "uint64", "uint64_t", NULL},
      {"float", NULL},
      {"double", NULL}};
  for (int t = 0; t < LTH_VOXEL_TYPES; t++)
    if (is_word(p->value, names[t])) {
      p->h.type = (LthVoxelType)t;
      p->has_type = true;
      return LITHE_OK;
    }
  LTH_FAIL_LINE(&p->in, "values of type \"%.40s\" are not read, expected integers, float or double",
                p->value);
}

static LitheStatus read_encoding(Nrrd *p) {
  static const char *const raw[] = {"raw", NULL}, *const zip[] = {"gzip", "gz", NULL},
                           *const text[] = {"ascii", "text", "txt", NULL};
  p->has_encoding = true;
  if (is_word(p->value, raw))
    p->h.coding = LTH_CODING_RAW;
  else if (is_word(p->value, zip))
    p->h.coding = LTH_CODING_ZLIB;
  else if (is_word(p->value, text))
    p->h.coding = LTH_CODING_TEXT;
  else
    LTH_FAIL_LINE(&p->in, "the encoding \"%.40s\" is not read, expected raw, gzip or ascii",
                  p->value);
  return LITHE_OK;
}

static LitheStatus read_directions(Nrrd *p) {
  double v[9];
  if (strstr(p->value, "none"))
    LTH_FAIL_LINE(&p->in, "an axis without direction, got %.100s; expected three vectors",
                  p->value);
  if (read_numbers(p->value, 9, v) != 9)
    LTH_FAIL_LINE(&p->in, "the axes are %.100s, expected (x,y,z) (x,y,z) (x,y,z)", p->value);
  for (int j = 0; j < 3; j++)
    for (int i = 0; i < 3; i++) p->axes[3 * i + j] = v[3 * j + i];
  p->has_axes = true;
  return LITHE_OK;
}

static LitheStatus read_units(Nrrd *p) {
  static const struct {
    const char *name;
    double factor;
  } units[] = {{"mm", 1e-3}, {"cm", 1e-2}, {"um", 1e-6}, {"microns", 1e-6}, {"m", 1}};
  char word[16] = "";
  if (sscanf(p->value, " \"%15[^\"]\"", word) != 1) sscanf(p->value, "%15s", word);
  for (size_t i = 0; i < sizeof units / sizeof *units; i++)
    if (strcmp(word, units[i].name) == 0) {
      p->unit = units[i].factor;
      return LITHE_OK;
    }
  LTH_FAIL_LINE(&p->in, "the unit \"%s\" is not known, expected mm, cm, um or m", word);
}

static LitheStatus read_count(Nrrd *p, const char *what, double *count) {
  if (read_numbers(p->value, 1, count) != 1 || !(fabs(*count) <= 1e9) || *count != floor(*count))
    LTH_FAIL_LINE(&p->in, "%s is \"%.60s\", expected a whole number", what, p->value);
  return LITHE_OK;
}

static LitheStatus read_skip(Nrrd *p) {
  double skip;
  LITHE_TRY(read_count(p, "byte skip", &skip));
  if (skip < -1) LTH_FAIL_LINE(&p->in, "byte skip is %g, expected 0 or more, or -1", skip);
  p->h.is_last = skip < 0;
  p->h.skip = skip > 0 ? (size_t)skip : 0;
  return LITHE_OK;
}

static LitheStatus read_field(Nrrd *p, const char *key) {
  double number;
  if (strcasecmp(key, "type") == 0) return read_type(p);
  if (strcasecmp(key, "encoding") == 0) return read_encoding(p);
  if (strcasecmp(key, "space directions") == 0) return read_directions(p);
  if (strcasecmp(key, "space units") == 0 || strcasecmp(key, "units") == 0) return read_units(p);
  if (strcasecmp(key, "byte skip") == 0 || strcasecmp(key, "byteskip") == 0) return read_skip(p);
  if (strcasecmp(key, "dimension") == 0) {
    LITHE_TRY(read_count(p, "dimension", &number));
    if (number != 3) LTH_FAIL_LINE(&p->in, "%g dimensions, expected 3", number);
  } else if (strcasecmp(key, "sizes") == 0) {
    if (read_numbers(p->value, 3, p->h.n) != 3)
      LTH_FAIL_LINE(&p->in, "sizes are \"%.60s\", expected three numbers", p->value);
    p->has_sizes = true;
  } else if (strcasecmp(key, "spacings") == 0) {
    if (read_numbers(p->value, 3, p->spacing) != 3)
      LTH_FAIL_LINE(&p->in, "spacings are \"%.60s\", expected three numbers", p->value);
    p->has_spacing = true;
  } else if (strcasecmp(key, "space origin") == 0) {
    if (read_numbers(p->value, 3, p->origin) != 3)
      LTH_FAIL_LINE(&p->in, "the origin is \"%.60s\", expected (x,y,z)", p->value);
  } else if (strcasecmp(key, "endian") == 0) {
    p->h.is_big_endian = strcasecmp(p->value, "big") == 0;
    p->has_endian = true;
  } else if (strcasecmp(key, "line skip") == 0 || strcasecmp(key, "lineskip") == 0) {
    LITHE_TRY(read_count(p, "line skip", &number));
    if (number != 0) LTH_FAIL_LINE(&p->in, "line skip is %g, expected 0", number);
  } else if (strcasecmp(key, "data file") == 0 || strcasecmp(key, "datafile") == 0) {
    if (strcasecmp(p->value, "LIST") == 0 || strchr(p->value, '%'))
      LTH_FAIL_LINE(&p->in, "values in many files are not read, expected one file");
    snprintf(p->h.data_file, sizeof p->h.data_file, "%s", p->value);
  }
  return LITHE_OK; // other fields do not change what is read
}

static LitheStatus read_header(Nrrd *p) {
  bool is_there;
  LITHE_TRY(lth_header_line(&p->in, &is_there));
  if (!is_there || strncmp(p->in.text, "NRRD", 4) != 0)
    LITHE_FAIL(p->in.ctx, LITHE_BAD_INPUT, "%s:1: no NRRD file, expected NRRD0001 to NRRD0005",
               p->h.name);
  for (;;) {
    LITHE_TRY(lth_header_line(&p->in, &is_there));
    if (!is_there || !p->in.text[0]) return LITHE_OK;
    if (p->in.text[0] == '#' || strstr(p->in.text, ":=")) continue;
    char *colon = strchr(p->in.text, ':');
    if (!colon)
      LTH_FAIL_LINE(&p->in, "no field, got \"%.60s\"; expected \"name: value\"", p->in.text);
    *colon = 0;
    p->value = colon + 1 + strspn(colon + 1, " \t");
    LITHE_TRY(read_field(p, p->in.text));
  }
}

static LitheStatus check_fields(Nrrd *p) {
  const char *missing = !p->has_type       ? "type"
                        : !p->has_sizes    ? "sizes"
                        : !p->has_encoding ? "encoding"
                                           : NULL;
  if (!missing && p->h.coding != LTH_CODING_TEXT && !p->has_endian &&
      lth_voxel_bytes(p->h.type) > 1)
    missing = "endian";
  if (missing)
    LITHE_FAIL(p->in.ctx, LITHE_BAD_INPUT, "%s: its header ends at line %d without the field %s",
               p->h.name, p->in.line, missing);
  if (p->h.is_last && p->h.coding != LTH_CODING_RAW)
    LITHE_FAIL(p->in.ctx, LITHE_BAD_INPUT, "%s: byte skip -1 goes with raw encoding only",
               p->h.name);
  return LITHE_OK;
}

/// Directions, else spacings; in space's own axes.
static void make_map(Nrrd *p) {
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      double axis = i != j ? 0 : p->has_spacing && isfinite(p->spacing[j]) ? p->spacing[j] : 1;
      p->h.to_world[4 * i + j] = p->unit * (p->has_axes ? p->axes[3 * i + j] : axis);
    }
    p->h.to_world[4 * i + 3] = p->unit * p->origin[i];
  }
}

LitheStatus lth_nrrd_parse(LitheCtx *ctx, const char *name, const char *path, const char *data,
                           size_t size, LthVolume **volume) {
  Nrrd p = {.in = {.ctx = ctx, .name = name, .data = data, .size = size},
            .h = {.name = name, .path = path, .slope = 1},
            .unit = 1e-3};
  *volume = NULL;
  LITHE_TRY(read_header(&p));
  LITHE_TRY(check_fields(&p));
  make_map(&p);
  if (p.in.at > size) p.in.at = size;
  return lth_volume_from_data(ctx, &p.h, data + p.in.at, size - p.in.at, volume);
}
