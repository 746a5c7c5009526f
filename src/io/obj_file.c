/// Wavefront OBJ: points, texture coordinates, polygons with any kind of index, groups and objects.
#include "io/soup_builder.h"

/// Turn an index of the file (from 1, or negative from the end) into one from 0.
static LitheStatus resolve_index(const LthText *text, const char *what, LitheCount given,
                                 LitheIndex n, LitheIndex *index) {
  LitheCount found = given < 0 ? n + given : given - 1;
  if (given == 0 || found < 0 || found >= n)
    return lth_text_fail(text, "%s index %lld is out of range, the file has %d so far", what,
                         (long long)given, n);
  *index = (LitheIndex)found;
  return LITHE_OK;
}

/// Split "v", "v/t", "v//n" or "v/t/n" at its next slash; the rest stays in `word`.
static LthWord next_field(LthWord *word) {
  size_t n = 0;
  while (n < word->length && word->at[n] != '/') n++;
  LthWord field = {word->at, n};
  size_t used = n < word->length ? n + 1 : n;
  word->at += used;
  word->length -= used;
  return field;
}

static LitheStatus bad_corner(const LthText *text, LthWord corner) {
  return lth_text_fail(text, "face corner is '%.*s', expected v, v/t, v//n or v/t/n with integers",
                       corner.length < 40 ? (int)corner.length : 40, corner.at);
}

static LitheStatus read_corner(LthSoupBuilder *b, const LthText *text, LthWord corner) {
  LthWord rest = corner, point_field = next_field(&rest), uv_field = next_field(&rest),
          normal_field = next_field(&rest);
  LitheCount given = 0;
  LitheIndex point = 0, uv = -1;
  if (!lth_word_integer(point_field, &given) || rest.length > 0) return bad_corner(text, corner);
  LITHE_TRY(resolve_index(text, "vertex", given, b->soup->n_points, &point));
  if (uv_field.length > 0) {
    if (!lth_word_integer(uv_field, &given)) return bad_corner(text, corner);
    LITHE_TRY(resolve_index(text, "texture coordinate", given, b->soup->n_uvs, &uv));
  }
  // normals are not kept, so their range does not matter
  if (normal_field.length > 0 && !lth_word_integer(normal_field, &given))
    return bad_corner(text, corner);
  return lth_soup_add_corner(b, point, uv);
}

static LitheStatus read_face(LthSoupBuilder *b, LthText *text) {
  LthWord word;
  int n = 0;
  for (; lth_text_word(text, &word); n++) LITHE_TRY(read_corner(b, text, word));
  if (n < 3) return lth_text_fail(text, "face has %d corners, expected at least 3", n);
  return lth_soup_end_polygon(b);
}

static LitheStatus read_point(LthSoupBuilder *b, LthText *text) {
  double x[3];
  for (int i = 0; i < 3; i++) LITHE_TRY(lth_text_number(text, "vertex coordinate", &x[i]));
  return lth_soup_add_point(b, x);
}

static LitheStatus read_uv(LthSoupBuilder *b, LthText *text) {
  double uv[2] = {0, 0};
  LthWord word;
  LITHE_TRY(lth_text_number(text, "texture coordinate", &uv[0]));
  // the second one is optional in the format
  LthText ahead = *text;
  if (lth_text_word(&ahead, &word)) LITHE_TRY(lth_text_number(text, "texture coordinate", &uv[1]));
  return lth_soup_add_uv(b, uv);
}

static LitheStatus read_statement(LthSoupBuilder *b, LthText *text) {
  LthWord word;
  if (!lth_text_word(text, &word)) return LITHE_OK;
  if (lth_word_is(word, "v")) return read_point(b, text);
  if (lth_word_is(word, "f")) return read_face(b, text);
  if (lth_word_is(word, "vt")) return read_uv(b, text);
  if (lth_word_is(word, "g") || lth_word_is(word, "o"))
    return lth_soup_set_group(b, lth_text_rest(text));
  return LITHE_OK; // normals, materials, lines and curves have no part in a solid
}

LitheStatus lth_obj_parse(LthSoupBuilder *b, const char *data, size_t size) {
  LthText text = lth_text(b->ctx, b->name, data, size);
  text.comment = '#';
  text.joins_lines = true;
  if (size == 0) return lth_text_fail(&text, "the file is empty, expected OBJ text");
  do LITHE_TRY(read_statement(b, &text));
  while (lth_text_next_line(&text));
  return LITHE_OK;
}
