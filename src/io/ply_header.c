/// Reading the header of a PLY file.
#include "io/ply_header.h"

#include <string.h>

static const struct {
  const char *name, *other_name;
  int size;
} types[] = {
    [LTH_PLY_INT8] = {"char", "int8", 1},        [LTH_PLY_UINT8] = {"uchar", "uint8", 1},
    [LTH_PLY_INT16] = {"short", "int16", 2},     [LTH_PLY_UINT16] = {"ushort", "uint16", 2},
    [LTH_PLY_INT32] = {"int", "int32", 4},       [LTH_PLY_UINT32] = {"uint", "uint32", 4},
    [LTH_PLY_FLOAT32] = {"float", "float32", 4}, [LTH_PLY_FLOAT64] = {"double", "float64", 8},
};

int lth_ply_type_size(LthPlyType type) { return types[type].size; }

static int shown(LthWord word) { return word.length < 40 ? (int)word.length : 40; }

static LitheStatus read_word(LthText *text, const char *what, LthWord *word) {
  if (lth_text_word(text, word)) return LITHE_OK;
  return lth_text_fail(text, "%s is missing", what);
}

static LitheStatus read_name(LthText *text, const char *what, char name[LTH_PLY_NAME_MAX]) {
  LthWord word;
  LITHE_TRY(read_word(text, what, &word));
  if (word.length >= LTH_PLY_NAME_MAX)
    return lth_text_fail(text, "%s has %zu characters, expected at most %d", what, word.length,
                         LTH_PLY_NAME_MAX - 1);
  memcpy(name, word.at, word.length);
  name[word.length] = 0;
  return LITHE_OK;
}

static LitheStatus read_type(LthText *text, LthPlyType *type) {
  LthWord word;
  LITHE_TRY(read_word(text, "type of the property", &word));
  for (int i = 0; i < (int)(sizeof types / sizeof types[0]); i++) {
    if (!lth_word_is(word, types[i].name) && !lth_word_is(word, types[i].other_name)) continue;
    *type = (LthPlyType)i;
    return LITHE_OK;
  }
  return lth_text_fail(text,
                       "type of the property is '%.*s', expected char, uchar, short, ushort, "
                       "int, uint, float or double",
                       shown(word), word.at);
}

static LitheStatus read_format(LthText *text, LthPlyHeader *header) {
  LthWord word, version;
  LITHE_TRY(read_word(text, "format", &word));
  if (lth_word_is(word, "ascii"))
    header->format = LTH_PLY_TEXT;
  else if (lth_word_is(word, "binary_little_endian"))
    header->format = LTH_PLY_LITTLE;
  else if (lth_word_is(word, "binary_big_endian"))
    header->format = LTH_PLY_BIG;
  else
    return lth_text_fail(text,
                         "format is '%.*s', expected ascii, binary_little_endian or "
                         "binary_big_endian",
                         shown(word), word.at);
  LITHE_TRY(read_word(text, "version of the format", &version));
  if (!lth_word_is(version, "1.0"))
    return lth_text_fail(text, "version of the format is '%.*s', expected 1.0", shown(version),
                         version.at);
  return LITHE_OK;
}

static LitheStatus read_element(LthText *text, LthPlyHeader *header) {
  if (header->n_elements == LTH_PLY_ELEMENTS_MAX)
    return lth_text_fail(text, "there are more than %d elements", LTH_PLY_ELEMENTS_MAX);
  LthPlyElement *element = &header->elements[header->n_elements];
  *element = (LthPlyElement){.first_property = header->n_properties};
  LITHE_TRY(read_name(text, "name of the element", element->name));
  LITHE_TRY(lth_text_integer(text, "number of the element's rows", &element->count));
  if (element->count < 0 || element->count > INT32_MAX)
    return lth_text_fail(text, "element %s has %lld rows, expected 0 to %d", element->name,
                         (long long)element->count, INT32_MAX);
  for (int i = 0; i < header->n_elements; i++)
    if (strcmp(header->elements[i].name, element->name) == 0)
      return lth_text_fail(text, "there are two elements %s", element->name);
  header->n_elements++;
  return LITHE_OK;
}

static LitheStatus read_property(LthText *text, LthPlyHeader *header) {
  if (header->n_elements == 0) return lth_text_fail(text, "property before the first element");
  if (header->n_properties == LTH_PLY_PROPERTIES_MAX)
    return lth_text_fail(text, "there are more than %d properties", LTH_PLY_PROPERTIES_MAX);
  LthPlyProperty *property = &header->properties[header->n_properties];
  *property = (LthPlyProperty){0};
  LthText ahead = *text;
  LthWord word;
  if (lth_text_word(&ahead, &word) && lth_word_is(word, "list")) {
    *text = ahead;
    property->is_list = true;
    LITHE_TRY(read_type(text, &property->count_type));
  }
  LITHE_TRY(read_type(text, &property->type));
  LITHE_TRY(read_name(text, "name of the property", property->name));
  header->n_properties++;
  header->elements[header->n_elements - 1].n_properties++;
  return LITHE_OK;
}

LitheStatus lth_ply_header_parse(LthText *text, LthPlyHeader *header) {
  LthWord word;
  bool has_format = false;
  header->n_elements = header->n_properties = 0;
  if (!lth_text_word(text, &word) || !lth_word_is(word, "ply"))
    return lth_text_fail(text, "the file does not begin with 'ply', so it is not a PLY file");
  while (lth_text_next_line(text)) {
    if (!lth_text_word(text, &word)) continue;
    if (lth_word_is(word, "comment") || lth_word_is(word, "obj_info")) continue;
    if (lth_word_is(word, "format")) {
      LITHE_TRY(read_format(text, header));
      has_format = true;
    } else if (lth_word_is(word, "element")) {
      LITHE_TRY(read_element(text, header));
    } else if (lth_word_is(word, "property")) {
      LITHE_TRY(read_property(text, header));
    } else if (lth_word_is(word, "end_header")) {
      if (!has_format) return lth_text_fail(text, "the header has no line 'format'");
      lth_text_next_line(text);
      return LITHE_OK;
    } else {
      return lth_text_fail(text,
                           "found '%.*s', expected format, element, property, comment or "
                           "end_header",
                           shown(word), word.at);
    }
  }
  return lth_text_fail(text, "the file ends before 'end_header'");
}
