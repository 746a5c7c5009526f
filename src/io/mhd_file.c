/// MetaImage files: lines "Key = value", the last of which says where the values are.
#include "io/header_lines.h"
#include "io/volume_data.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

typedef struct Meta {
  LthHeaderLines in;
  LthVolumeHeader h;
  char *value;                           ///< within in.text
  double axes[9], origin[3], spacing[3]; ///< a row of `axes` to each voxel axis
  bool has_sizes, has_type, has_end;
} Meta;

static LitheStatus read_numbers(Meta *p, const char *key, int n, double *numbers) {
  const char *at = p->value;
  int count = 0;
  for (char *end; *(at += strspn(at, " \t")); at = end, count++) {
    double value = strtod(at, &end);
    if (end == at || (*end && *end != ' ' && *end != '\t')) break;
    if (count < n) numbers[count] = value;
  }
  if (*at || count != n)
    LTH_FAIL_LINE(&p->in, "%s is \"%.100s\", expected %d numbers", key, p->value, n);
  return LITHE_OK;
}

static LitheStatus read_type(Meta *p) {
  static const char *const names[LTH_VOXEL_TYPES] = {
      "MET_CHAR", "MET_UCHAR",     "MET_SHORT",      "MET_USHORT", "MET_INT",
      "MET_UINT", "MET_LONG_LONG", "MET_ULONG_LONG", "MET_FLOAT",  "MET_DOUBLE"};
  const char *type = p->value;
  // a long has four bytes in these files
  if (strcmp(type, "MET_LONG") == 0) type = "MET_INT";
  if (strcmp(type, "MET_ULONG") == 0) type = "MET_UINT";
  for (int t = 0; t < LTH_VOXEL_TYPES; t++)
    if (strcmp(type, names[t]) == 0) {
      p->h.type = (LthVoxelType)t;
      p->has_type = true;
      return LITHE_OK;
    }
  LTH_FAIL_LINE(&p->in,
                "values of type \"%.40s\" are not read, expected MET_UCHAR, MET_SHORT, MET_FLOAT "
                "or another single number",
                p->value);
}

static bool is_true(const char *text) { return text[0] == 'T' || text[0] == 't' || text[0] == '1'; }

static bool is_one_of(const char *key, const char *a, const char *b, const char *c) {
  return strcmp(key, a) == 0 || strcmp(key, b) == 0 || strcmp(key, c) == 0;
}

static LitheStatus read_data_file(Meta *p) {
  p->has_end = true;
  if (strcmp(p->value, "LIST") == 0 || strchr(p->value, '%'))
    LTH_FAIL_LINE(&p->in, "values in many files are not read, expected one file");
  if (strcasecmp(p->value, "LOCAL") != 0)
    snprintf(p->h.data_file, sizeof p->h.data_file, "%s", p->value);
  return LITHE_OK;
}

static LitheStatus read_field(Meta *p, const char *key) {
  double number;
  if (strcmp(key, "ElementType") == 0) return read_type(p);
  if (strcmp(key, "ElementDataFile") == 0) return read_data_file(p);
  if (strcmp(key, "NDims") == 0) {
    LITHE_TRY(read_numbers(p, key, 1, &number));
    if (number != 3) LTH_FAIL_LINE(&p->in, "%g dimensions, expected 3", number);
  } else if (strcmp(key, "DimSize") == 0) {
    p->has_sizes = true;
    return read_numbers(p, key, 3, p->h.n);
  } else if (strcmp(key, "ElementSpacing") == 0) {
    return read_numbers(p, key, 3, p->spacing);
  } else if (is_one_of(key, "Offset", "Position", "Origin")) {
    return read_numbers(p, key, 3, p->origin);
  } else if (is_one_of(key, "TransformMatrix", "Rotation", "Orientation")) {
    return read_numbers(p, key, 9, p->axes);
  } else if (strcmp(key, "CompressedData") == 0) {
    p->h.coding = is_true(p->value) ? LTH_CODING_ZLIB : LTH_CODING_RAW;
  } else if (is_one_of(key, "BinaryDataByteOrderMSB", "ElementByteOrderMSB", "")) {
    p->h.is_big_endian = is_true(p->value);
  } else if (strcmp(key, "BinaryData") == 0) {
    if (!is_true(p->value))
      LTH_FAIL_LINE(&p->in, "values as text are not read, expected BinaryData = True");
  } else if (strcmp(key, "ElementNumberOfChannels") == 0) {
    LITHE_TRY(read_numbers(p, key, 1, &number));
    if (number != 1) LTH_FAIL_LINE(&p->in, "%g numbers to a voxel, expected one", number);
  } else if (strcmp(key, "HeaderSize") == 0) {
    LITHE_TRY(read_numbers(p, key, 1, &number));
    if (!(number >= -1 && number <= 1e9))
      LTH_FAIL_LINE(&p->in, "HeaderSize is %g, expected -1 or more", number);
    p->h.is_last = number < 0;
    p->h.skip = number > 0 ? (size_t)number : 0;
  }
  return LITHE_OK; // other keys do not change what is read
}

static LitheStatus read_header(Meta *p) {
  bool is_there = true;
  while (!p->has_end) {
    LITHE_TRY(lth_header_line(&p->in, &is_there));
    if (!is_there)
      LITHE_FAIL(p->in.ctx, LITHE_BAD_INPUT,
                 "%s: its header ends at line %d without ElementDataFile", p->h.name, p->in.line);
    char *equals = strchr(p->in.text, '=');
    if (!p->in.text[0]) continue;
    if (!equals)
      LTH_FAIL_LINE(&p->in, "no field, got \"%.60s\"; expected \"Key = value\"", p->in.text);
    p->value = equals + 1 + strspn(equals + 1, " \t");
    while (equals > p->in.text && (equals[-1] == ' ' || equals[-1] == '\t')) equals--;
    *equals = 0;
    LITHE_TRY(read_field(p, p->in.text));
  }
  if (!p->has_sizes || !p->has_type)
    LITHE_FAIL(p->in.ctx, LITHE_BAD_INPUT, "%s: its header ends at line %d without %s", p->h.name,
               p->in.line, p->has_sizes ? "ElementType" : "DimSize");
  if (p->h.is_last && p->h.coding != LTH_CODING_RAW)
    LITHE_FAIL(p->in.ctx, LITHE_BAD_INPUT, "%s: HeaderSize -1 goes with uncompressed data only",
               p->h.name);
  return LITHE_OK;
}

LitheStatus lth_mhd_parse(LitheCtx *ctx, const char *name, const char *path, const char *data,
                          size_t size, LthVolume **volume) {
  Meta p = {.in = {.ctx = ctx, .name = name, .data = data, .size = size},
            .h = {.name = name, .path = path, .slope = 1},
            .axes = {1, 0, 0, 0, 1, 0, 0, 0, 1},
            .spacing = {1, 1, 1}};
  *volume = NULL;
  LITHE_TRY(read_header(&p));
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) p.h.to_world[4 * i + j] = 1e-3 * p.axes[3 * j + i] * p.spacing[j];
    p.h.to_world[4 * i + 3] = 1e-3 * p.origin[i];
  }
  if (p.in.at > size) p.in.at = size;
  return lth_volume_from_data(ctx, &p.h, data + p.in.at, size - p.in.at, volume);
}
