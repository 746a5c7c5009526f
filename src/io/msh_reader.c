/// Values of a Gmsh file, and the physical groups that it speaks of.
#include "io/msh_reader.h"

#include "io/bytes.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void lth_msh_reader_free(LthMshReader *r) {
  LitheCtx *ctx = r->b->ctx;
  lth_hash_free(ctx, &r->name_of);
  lth_hash_free(ctx, &r->entity_of);
  lth_hash_free(ctx, &r->volume_of);
  lth_free(ctx, r->names);
  lth_free(ctx, r->physical_off);
  lth_free(ctx, r->physical);
}

LitheStatus lth_msh_fail(const LthMshReader *r, const char *format, ...) {
  char message[512];
  va_list args;
  va_start(args, format);
  vsnprintf(message, sizeof message, format, args);
  va_end(args);
  if (!r->is_binary) return lth_text_fail(&r->text, "%s", message);
  LITHE_FAIL(r->b->ctx, LITHE_BAD_INPUT, "%s: byte %lld: %s", r->b->file,
             (long long)(r->text.at - r->data), message);
}

static LitheStatus ends_before(const LthMshReader *r, const char *what) {
  return lth_msh_fail(r, "the file ends in $%s before %s: it is cut short", r->section, what);
}

/// The next word of a text file.
static LitheStatus next_word(LthMshReader *r, const char *what, LthWord *word) {
  return lth_text_word_across(&r->text, word) ? LITHE_OK : ends_before(r, what);
}

static LitheStatus not_a_number(const LthMshReader *r, const char *what, LthWord word) {
  return lth_msh_fail(r, "%s is '%.*s' in $%s, expected a number", what,
                      word.length < 40 ? (int)word.length : 40, word.at, r->section);
}

/// The next `n` bytes of a binary file.
static LitheStatus next_bytes(LthMshReader *r, const char *what, int n, const char **bytes) {
  if (r->text.end - r->text.at < n) return ends_before(r, what);
  *bytes = r->text.at;
  r->text.at += n;
  return LITHE_OK;
}

static LitheStatus whole_number(LthMshReader *r, const char *what, int n_bytes, LitheCount *value) {
  if (!r->is_binary) {
    LthWord word;
    LITHE_TRY(next_word(r, what, &word));
    return lth_word_integer(word, value) ? LITHE_OK : not_a_number(r, what, word);
  }
  const char *bytes = NULL;
  LITHE_TRY(next_bytes(r, what, n_bytes, &bytes));
  uint64_t raw = lth_bytes_unsigned(bytes, n_bytes, r->is_big);
  *value = n_bytes == 4 ? (int32_t)(uint32_t)raw : (LitheCount)raw;
  return LITHE_OK;
}

LitheStatus lth_msh_int(LthMshReader *r, const char *what, LitheIndex *value) {
  LitheCount wide = 0;
  LITHE_TRY(whole_number(r, what, 4, &wide));
  if (wide < INT32_MIN || wide > INT32_MAX)
    return lth_msh_fail(r, "%s is %lld, which is out of range", what, (long long)wide);
  *value = (LitheIndex)wide;
  return LITHE_OK;
}

LitheStatus lth_msh_size(LthMshReader *r, const char *what, LitheCount *value) {
  LITHE_TRY(whole_number(r, what, r->size_bytes, value));
  if (*value < 0) return lth_msh_fail(r, "%s is %lld, expected 0 or more", what, (long long)*value);
  return LITHE_OK;
}

LitheStatus lth_msh_double(LthMshReader *r, const char *what, double *value) {
  if (r->is_binary) {
    const char *bytes = NULL;
    LITHE_TRY(next_bytes(r, what, 8, &bytes));
    *value = lth_bytes_f64(bytes, r->is_big);
  } else {
    LthWord word;
    LITHE_TRY(next_word(r, what, &word));
    if (!lth_word_number(word, value)) return not_a_number(r, what, word);
  }
  if (!isfinite(*value)) return lth_msh_fail(r, "%s is %g, expected a finite number", what, *value);
  return LITHE_OK;
}

LitheStatus lth_msh_name(LthMshReader *r, LitheIndex dimension, LitheIndex tag, LthWord name) {
  LitheIndex kept = 0;
  LTH_RESERVE(r->b->ctx, r->names, r->cap_names, r->n_names + 1);
  r->names[r->n_names] = name;
  LITHE_TRY(
      lth_hash_insert(r->b->ctx, &r->name_of, lth_hash_pair(dimension, tag), 0, r->n_names, &kept));
  r->n_names++;
  return LITHE_OK;
}

LitheStatus lth_msh_entity(LthMshReader *r, LitheIndex dimension, LitheIndex tag) {
  LitheIndex kept = 0;
  LTH_RESERVE(r->b->ctx, r->physical_off, r->cap_off, r->n_entities + 2);
  LITHE_TRY(lth_hash_insert(r->b->ctx, &r->entity_of, lth_hash_pair(dimension, tag), 0,
                            r->n_entities, &kept));
  r->n_entities++;
  r->physical_off[r->n_entities] = r->n_physical;
  return LITHE_OK;
}

LitheStatus lth_msh_entity_group(LthMshReader *r, LitheIndex group) {
  if (r->n_physical == INT32_MAX)
    return lth_msh_fail(r, "the file has more physical groups than can be counted");
  LTH_RESERVE(r->b->ctx, r->physical, r->cap_physical, r->n_physical + 1);
  // a negative number turns the entity round; the group is the same
  r->physical[r->n_physical++] = group == INT32_MIN ? 0 : abs(group);
  r->physical_off[r->n_entities] = r->n_physical;
  return LITHE_OK;
}

LitheIndex lth_msh_groups_of(const LthMshReader *r, LitheIndex dimension, LitheIndex tag,
                             const LitheIndex **groups) {
  LitheIndex e = lth_hash_find(&r->entity_of, lth_hash_pair(dimension, tag), 0);
  if (e < 0) return 0;
  *groups = r->physical + r->physical_off[e];
  return r->physical_off[e + 1] - r->physical_off[e];
}
