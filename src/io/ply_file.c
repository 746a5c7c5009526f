/// PLY, text and binary of both byte orders: any order and type of properties, others are skipped.
#include "io/bytes.h"
#include "io/ply_header.h"
#include "io/soup_builder.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/// Where the reader is: values come one by one, whatever the format.
typedef struct PlyReader {
  LthSoupBuilder *builder;
  const LthPlyHeader *header;
  const char *data; ///< start of the file, for byte offsets
  LthText text;     ///< `at` is the next byte, also of binary data
  LitheCount n_vertices;
} PlyReader;

/// A message with the line of a text file or the byte of a binary one.
__attribute__((format(printf, 2, 3))) static LitheStatus fail_here(const PlyReader *r,
                                                                   const char *format, ...) {
  char message[256];
  va_list args;
  va_start(args, format);
  vsnprintf(message, sizeof message, format, args);
  va_end(args);
  if (r->header->format == LTH_PLY_TEXT) return lth_text_fail(&r->text, "%s", message);
  LITHE_FAIL(r->text.ctx, LITHE_BAD_INPUT, "%s: byte %lld: %s", r->text.name,
             (long long)(r->text.at - r->data), message);
}

static double decode(const char *at, LthPlyType type, bool big) {
  switch (type) {
  case LTH_PLY_INT8:
    return (int8_t)lth_bytes_unsigned(at, 1, big);
  case LTH_PLY_UINT8:
    return (uint8_t)lth_bytes_unsigned(at, 1, big);
  case LTH_PLY_INT16:
    return (int16_t)lth_bytes_unsigned(at, 2, big);
  case LTH_PLY_UINT16:
    return (uint16_t)lth_bytes_unsigned(at, 2, big);
  case LTH_PLY_INT32:
    return (int32_t)lth_bytes_unsigned(at, 4, big);
  case LTH_PLY_UINT32:
    return (uint32_t)lth_bytes_unsigned(at, 4, big);
  case LTH_PLY_FLOAT32:
    return lth_bytes_f32(at, big);
  case LTH_PLY_FLOAT64:
    return lth_bytes_f64(at, big);
  }
  return NAN;
}

/// The next value; every type of PLY fits into a double exactly.
static LitheStatus read_value(PlyReader *r, LthPlyType type, const char *what, double *value) {
  LthText *text = &r->text;
  if (r->header->format == LTH_PLY_TEXT) {
    LthWord word;
    if (!lth_text_word_across(text, &word)) return fail_here(r, "the file ends before %s", what);
    if (lth_word_number(word, value)) return LITHE_OK;
    return fail_here(r, "%s is '%.*s', expected a number", what,
                     word.length < 40 ? (int)word.length : 40, word.at);
  }
  int size = lth_ply_type_size(type);
  if (text->end - text->at < size) return fail_here(r, "the file ends before %s", what);
  *value = decode(text->at, type, r->header->format == LTH_PLY_BIG);
  text->at += size;
  return LITHE_OK;
}

static LitheStatus read_list_length(PlyReader *r, const LthPlyProperty *property, LitheCount *n) {
  double value = 0;
  LITHE_TRY(read_value(r, property->count_type, property->name, &value));
  if (!(value >= 0 && value <= INT32_MAX && value == floor(value)))
    return fail_here(r, "length of the list %s is %g, expected an integer from 0", property->name,
                     value);
  *n = (LitheCount)value;
  return LITHE_OK;
}

static LitheStatus skip_property(PlyReader *r, const LthPlyProperty *property) {
  double value;
  LitheCount n = 1;
  if (property->is_list) LITHE_TRY(read_list_length(r, property, &n));
  for (LitheCount i = 0; i < n; i++)
    LITHE_TRY(read_value(r, property->type, property->name, &value));
  return LITHE_OK;
}

static LitheStatus read_polygon(PlyReader *r, const LthPlyProperty *property) {
  LitheCount n = 0;
  LITHE_TRY(read_list_length(r, property, &n));
  for (LitheCount i = 0; i < n; i++) {
    double value = 0;
    LITHE_TRY(read_value(r, property->type, "a vertex index", &value));
    if (!(value >= 0 && value < (double)r->n_vertices && value == floor(value)))
      return fail_here(r, "vertex index %.10g is out of range, expected 0 to %lld", value,
                       (long long)r->n_vertices - 1);
    // points and lines are no part of a surface
    if (n >= 3) LITHE_TRY(lth_soup_add_corner(r->builder, (LitheIndex)value, -1));
  }
  return n >= 3 ? lth_soup_end_polygon(r->builder) : LITHE_OK;
}

static const char *axis_names[] = {"x", "y", "z"};

static int axis_of(const LthPlyProperty *property) {
  for (int i = 0; i < 3; i++)
    if (!property->is_list && strcmp(property->name, axis_names[i]) == 0) return i;
  return -1;
}

static LitheStatus read_vertex(PlyReader *r, const LthPlyElement *element) {
  double x[3] = {0};
  for (int i = 0; i < element->n_properties; i++) {
    const LthPlyProperty *property = &r->header->properties[element->first_property + i];
    int axis = axis_of(property);
    if (axis < 0) {
      LITHE_TRY(skip_property(r, property));
      continue;
    }
    LITHE_TRY(read_value(r, property->type, "a vertex coordinate", &x[axis]));
    if (!isfinite(x[axis]))
      return fail_here(r, "vertex coordinate is %g, expected a finite number", x[axis]);
  }
  return lth_soup_add_point(r->builder, x);
}

static bool is_polygon_list(const LthPlyProperty *property) {
  return property->is_list && (strcmp(property->name, "vertex_indices") == 0 ||
                               strcmp(property->name, "vertex_index") == 0);
}

static LitheStatus read_face(PlyReader *r, const LthPlyElement *element) {
  for (int i = 0; i < element->n_properties; i++) {
    const LthPlyProperty *property = &r->header->properties[element->first_property + i];
    LITHE_TRY(is_polygon_list(property) ? read_polygon(r, property) : skip_property(r, property));
  }
  return LITHE_OK;
}

/// The fewest bytes that a row can have.
static LitheCount least_row(const PlyReader *r, const LthPlyElement *element) {
  LitheCount bytes = 0;
  for (int i = 0; i < element->n_properties; i++) {
    const LthPlyProperty *property = &r->header->properties[element->first_property + i];
    bytes += r->header->format == LTH_PLY_TEXT
                 ? 2
                 : lth_ply_type_size(property->is_list ? property->count_type : property->type);
  }
  return bytes;
}

static LitheStatus read_rows(PlyReader *r, const LthPlyElement *element) {
  if (element->n_properties == 0) return LITHE_OK;
  LitheCount left = r->text.end - r->text.at;
  if (element->count * least_row(r, element) > left + 1)
    return fail_here(r,
                     "the header announces %lld rows of %s, which do not fit into the %lld bytes "
                     "left: the file is cut short",
                     (long long)element->count, element->name, (long long)left);
  bool is_vertex = strcmp(element->name, "vertex") == 0;
  bool is_face = strcmp(element->name, "face") == 0;
  for (LitheCount row = 0; row < element->count; row++) {
    if (is_vertex)
      LITHE_TRY(read_vertex(r, element));
    else if (is_face)
      LITHE_TRY(read_face(r, element));
    else
      for (int i = 0; i < element->n_properties; i++)
        LITHE_TRY(skip_property(r, &r->header->properties[element->first_property + i]));
  }
  return LITHE_OK;
}

static const LthPlyElement *find_element(const LthPlyHeader *header, const char *name) {
  for (int i = 0; i < header->n_elements; i++)
    if (strcmp(header->elements[i].name, name) == 0) return &header->elements[i];
  return NULL;
}

/// There must be exactly one x, y and z, and one list of polygons.
static LitheStatus check_header(const PlyReader *r) {
  const LthPlyHeader *header = r->header;
  const LthPlyElement *vertex = find_element(header, "vertex"),
                      *face = find_element(header, "face");
  int found[3] = {0}, lists = 0;
  if (!vertex) return lth_text_fail(&r->text, "the header has no element 'vertex'");
  for (int i = 0; i < vertex->n_properties; i++) {
    int axis = axis_of(&header->properties[vertex->first_property + i]);
    if (axis >= 0) found[axis]++;
  }
  for (int i = 0; i < 3; i++)
    if (found[i] != 1)
      return lth_text_fail(&r->text, "element 'vertex' has %d properties '%s', expected one",
                           found[i], axis_names[i]);
  if (!face)
    return lth_text_fail(&r->text, "the header has no element 'face'%s",
                         find_element(header, "tristrips") ? "; triangle strips are not supported, "
                                                             "save the file with faces"
                                                           : ", expected a surface");
  for (int i = 0; i < face->n_properties; i++)
    lists += is_polygon_list(&header->properties[face->first_property + i]);
  if (lists != 1)
    return lth_text_fail(&r->text, "element 'face' has %d lists 'vertex_indices', expected one",
                         lists);
  return LITHE_OK;
}

LitheStatus lth_ply_parse(LthSoupBuilder *b, const char *data, size_t size) {
  LitheStatus status = LITHE_OK;
  LthPlyHeader *header = NULL;
  PlyReader reader = {.builder = b, .data = data, .text = lth_text(b->ctx, b->name, data, size)};
  LTH_NEW(b->ctx, header, 1);
  reader.header = header;
  LITHE_TRY_OR(done, lth_ply_header_parse(&reader.text, header));
  LITHE_TRY_OR(done, check_header(&reader));
  reader.n_vertices = find_element(header, "vertex")->count;
  for (int i = 0; i < header->n_elements; i++)
    LITHE_TRY_OR(done, read_rows(&reader, &header->elements[i]));
done:
  lth_free(b->ctx, header);
  return status;
}
