/// Geomview OFF text with its relatives COFF, NOFF, STOFF: colours and normals are skipped.
#include "io/soup_builder.h"

#include <string.h>

/// Go to the next line that holds a word.
static LitheStatus next_filled_line(LthText *text, const char *what) {
  LthWord word;
  while (lth_text_next_line(text)) {
    LthText ahead = *text;
    if (lth_text_word(&ahead, &word)) {
      *text = ahead;
      text->at = word.at;
      return LITHE_OK;
    }
  }
  return lth_text_fail(text, "the file ends before %s", what);
}

/// "OFF" behind any of ST, C, N; others (4OFF, nOFF: other dimensions) are refused.
static bool is_off_keyword(LthWord word) {
  if (word.length >= 2 && memcmp(word.at, "ST", 2) == 0) word.at += 2, word.length -= 2;
  while (word.length > 3 && (*word.at == 'C' || *word.at == 'N')) word.at++, word.length--;
  return lth_word_is(word, "OFF");
}

/// The header up to the counts; the keyword may be missing or share the line with the counts.
static LitheStatus read_header(LthText *text, LitheCount *n_points, LitheCount *n_polys) {
  LthWord word;
  if (!lth_text_word_across(text, &word))
    return lth_text_fail(text, "the file is empty, expected OFF text");
  LitheCount number = 0;
  if (lth_word_integer(word, &number)) {
    text->at = word.at;
  } else if (!is_off_keyword(word)) {
    return lth_text_fail(text, "the file begins with '%.*s', expected OFF, COFF, NOFF or STOFF",
                         word.length < 40 ? (int)word.length : 40, word.at);
  } else {
    LthText ahead = *text;
    if (!lth_text_word(&ahead, &word))
      LITHE_TRY(next_filled_line(text, "the counts"));
    else if (lth_word_is(word, "BINARY"))
      return lth_text_fail(text, "binary OFF is not supported; save it as text or as binary PLY");
  }
  LITHE_TRY(lth_text_integer(text, "number of vertices", n_points));
  return lth_text_integer(text, "number of faces", n_polys);
}

/// A vertex needs at least 6 characters, a face 2.
static LitheStatus check_counts(const LthText *text, LitheCount n_points, LitheCount n_polys) {
  LitheCount left = text->end - text->at;
  if (n_points < 0 || n_polys < 0 || n_points > INT32_MAX || n_polys > INT32_MAX ||
      6 * n_points + 2 * n_polys > left + 2)
    return lth_text_fail(text, "%lld vertices and %lld faces do not fit into the file's %lld bytes",
                         (long long)n_points, (long long)n_polys, (long long)left);
  return LITHE_OK;
}

static LitheStatus read_face(LthSoupBuilder *b, LthText *text) {
  LitheCount n = 0, point = 0;
  LITHE_TRY(next_filled_line(text, "its last face"));
  LITHE_TRY(lth_text_integer(text, "number of corners", &n));
  if (n < 1) return lth_text_fail(text, "face has %lld corners, expected at least 1", (long long)n);
  for (LitheCount i = 0; i < n; i++) {
    LITHE_TRY(lth_text_integer(text, "vertex index", &point));
    if (point < 0 || point >= b->soup->n_points)
      return lth_text_fail(text, "vertex index %lld is out of range, expected 0 to %d",
                           (long long)point, b->soup->n_points - 1);
    if (n >= 3) LITHE_TRY(lth_soup_add_corner(b, (LitheIndex)point, -1));
  }
  return n >= 3 ? lth_soup_end_polygon(b) : LITHE_OK; // OFF writes points and lines as faces too
}

LitheStatus lth_off_parse(LthSoupBuilder *b, const char *data, size_t size) {
  LthText text = lth_text(b->ctx, b->name, data, size);
  text.comment = '#';
  LitheCount n_points = 0, n_polys = 0;
  LITHE_TRY(read_header(&text, &n_points, &n_polys));
  LITHE_TRY(check_counts(&text, n_points, n_polys));
  for (LitheCount i = 0; i < n_points; i++) {
    double x[3];
    LITHE_TRY(next_filled_line(&text, "its last vertex"));
    for (int j = 0; j < 3; j++) LITHE_TRY(lth_text_number(&text, "vertex coordinate", &x[j]));
    LITHE_TRY(lth_soup_add_point(b, x));
  }
  for (LitheCount i = 0; i < n_polys; i++) LITHE_TRY(read_face(b, &text));
  return LITHE_OK;
}
