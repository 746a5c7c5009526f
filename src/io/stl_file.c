/// STL, text and binary. Binary files that begin with "solid" are common, so size and contents decide.
#include "io/bytes.h"
#include "io/soup_builder.h"

#include <math.h>
#include <string.h>
#include <strings.h>

#define STL_HEADER 84
#define STL_TRIANGLE 50

static LitheStatus add_triangle(LthSoupBuilder *b, const double corners[9]) {
  for (int i = 0; i < 3; i++) {
    LITHE_TRY(lth_soup_add_point(b, corners + 3 * i));
    LITHE_TRY(lth_soup_add_corner(b, b->soup->n_points - 1, -1));
  }
  return lth_soup_end_polygon(b);
}

static LitheStatus parse_binary(LthSoupBuilder *b, const char *data, size_t size) {
  if (size < STL_HEADER)
    LITHE_FAIL(
        b->ctx, LITHE_BAD_INPUT,
        "%s: has %zu bytes, expected STL: text that begins with 'solid', or at least %d bytes",
        b->name, size, STL_HEADER);
  size_t n = lth_bytes_u32(data + STL_HEADER - 4, false);
  size_t held = (size - STL_HEADER) / STL_TRIANGLE;
  if (n > held)
    LITHE_FAIL(b->ctx, LITHE_BAD_INPUT,
               "%s: byte 80: the header announces %zu triangles but the file ends after %zu; it is "
               "cut short or not an STL file",
               b->name, n, held);
  if (size != STL_HEADER + n * STL_TRIANGLE)
    lth_warn(b->ctx, "%s: %zu bytes after the last triangle ignored", b->name,
             size - STL_HEADER - n * STL_TRIANGLE);
  for (size_t t = 0; t < n; t++) {
    const char *at = data + STL_HEADER + t * STL_TRIANGLE + 12;
    double corners[9];
    for (int i = 0; i < 9; i++) {
      corners[i] = lth_bytes_f32(at + 4 * i, false);
      if (!isfinite(corners[i]))
        LITHE_FAIL(b->ctx, LITHE_BAD_INPUT,
                   "%s: byte %zu: coordinate of triangle %zu is %g, expected a finite number",
                   b->name, (size_t)(at + 4 * i - data), t, corners[i]);
    }
    LITHE_TRY(add_triangle(b, corners));
  }
  return LITHE_OK;
}

static LitheStatus expect_word(LthText *text, const char *expected) {
  LthWord word = {"the end of the file", 19};
  if (lth_text_word_across(text, &word) && lth_word_is_any_case(word, expected)) return LITHE_OK;
  return lth_text_fail(text, "found '%.*s', expected '%s'",
                       word.length < 40 ? (int)word.length : 40, word.at, expected);
}

/// The rest of a facet after the word "facet".
static LitheStatus read_facet(LthSoupBuilder *b, LthText *text) {
  LthWord word;
  double corners[9];
  // the normal is recomputed where it is needed; many programs write nan for a needle's
  LITHE_TRY(expect_word(text, "normal"));
  for (int i = 0; i < 3; i++)
    if (!lth_text_word_across(text, &word)) return lth_text_fail(text, "the file ends in a normal");
  LITHE_TRY(expect_word(text, "outer"));
  LITHE_TRY(expect_word(text, "loop"));
  for (int i = 0; i < 3; i++) {
    LITHE_TRY(expect_word(text, "vertex"));
    for (int j = 0; j < 3; j++)
      LITHE_TRY(lth_text_number(text, "vertex coordinate", &corners[3 * i + j]));
  }
  LITHE_TRY(expect_word(text, "endloop"));
  LITHE_TRY(expect_word(text, "endfacet"));
  return add_triangle(b, corners);
}

static LitheStatus parse_text(LthSoupBuilder *b, const char *data, size_t size) {
  LthText text = lth_text(b->ctx, b->name, data, size);
  LthWord word;
  bool in_solid = false;
  while (lth_text_word_across(&text, &word)) {
    if (lth_word_is_any_case(word, "solid")) {
      in_solid = true;
      LITHE_TRY(lth_soup_set_group(b, lth_text_rest(&text)));
    } else if (lth_word_is_any_case(word, "endsolid")) {
      in_solid = false;
      lth_text_rest(&text);
    } else if (in_solid && lth_word_is_any_case(word, "facet")) {
      LITHE_TRY(read_facet(b, &text));
    } else {
      return lth_text_fail(&text, "found '%.*s', expected 'facet', 'solid' or 'endsolid'",
                           word.length < 40 ? (int)word.length : 40, word.at);
    }
  }
  if (in_solid) return lth_text_fail(&text, "the file ends without 'endsolid': it is cut short");
  return LITHE_OK;
}

/// A binary file has exactly the size that its count demands; else the first line's end decides:
/// text goes on with "facet" or "endsolid".
static bool is_binary(const char *data, size_t size) {
  if (size >= STL_HEADER &&
      size == STL_HEADER + (size_t)lth_bytes_u32(data + STL_HEADER - 4, false) * STL_TRIANGLE)
    return true;
  LthText text = lth_text(NULL, "", data, size);
  LthWord word;
  if (!lth_text_word_across(&text, &word) || !lth_word_is_any_case(word, "solid")) return true;
  if (!lth_text_next_line(&text)) return size >= STL_HEADER && memchr(data, 0, STL_HEADER);
  if (!lth_text_word_across(&text, &word)) return false;
  if (lth_word_is_any_case(word, "facet") || lth_word_is_any_case(word, "endsolid")) return false;
  return size >= STL_HEADER && memchr(data, 0, size) != NULL;
}

LitheStatus lth_stl_parse(LthSoupBuilder *b, const char *data, size_t size) {
  return is_binary(data, size) ? parse_binary(b, data, size) : parse_text(b, data, size);
}
