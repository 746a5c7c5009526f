/// Data lines of keyword cards: fields between commas, numbers as Fortran writes them, messages with a place.
#include "io/inp_deck.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

/// Without blanks, then without quotes around it.
static LthWord trim(const char *at, size_t length) {
  while (length > 0 && is_blank(at[0])) at++, length--;
  while (length > 0 && is_blank(at[length - 1])) length--;
  if (length > 1 && at[0] == '"' && at[length - 1] == '"') at++, length -= 2;
  return (LthWord){at, length};
}

LitheStatus lth_inp_row(LitheCtx *ctx, const LthInpDeck *deck, LitheIndex row, LthInpRow *fields) {
  const LthInpLine *line = &deck->lines[row];
  *fields = (LthInpRow){.ctx = ctx, .file = deck->files[line->file].path, .line = line->line};
  const char *at = line->at, *end = at + line->length;
  while (at < end) {
    const char *comma = memchr(at, ',', (size_t)(end - at)), *stop = comma ? comma : end;
    if (fields->n_fields == LTH_INP_FIELDS_MAX)
      return lth_inp_row_fail(fields, "more than %d entries on a line", LTH_INP_FIELDS_MAX);
    fields->field[fields->n_fields++] = trim(at, (size_t)(stop - at));
    at = comma ? comma + 1 : end;
  }
  return LITHE_OK;
}

bool lth_inp_row_is_blank(const LthInpRow *row, int i) {
  return i >= row->n_fields || row->field[i].length == 0;
}

static LitheStatus missing(const LthInpRow *row, int i, const char *what, const char *expected) {
  return lth_inp_row_fail(row, "%s is missing, expected %s as entry %d of the line", what, expected,
                          i + 1);
}

static LitheStatus wrong(const LthInpRow *row, int i, const char *what, const char *expected) {
  LthWord word = row->field[i];
  return lth_inp_row_fail(row, "%s is '%.*s', expected %s", what,
                          word.length < 40 ? (int)word.length : 40, word.at, expected);
}

/// Fortran's double precision exponent: 1.5D3.
static bool fortran_number(LthWord word, double *value) {
  char copy[64];
  if (word.length >= sizeof copy) return false;
  memcpy(copy, word.at, word.length);
  for (size_t i = 0; i < word.length; i++)
    if (copy[i] == 'd' || copy[i] == 'D') copy[i] = 'e';
  return lth_word_number((LthWord){copy, word.length}, value);
}

LitheStatus lth_inp_row_number(const LthInpRow *row, int i, const char *what, double *value) {
  if (lth_inp_row_is_blank(row, i)) return missing(row, i, what, "a number");
  if (!lth_word_number(row->field[i], value) && !fortran_number(row->field[i], value))
    return wrong(row, i, what, "a number");
  if (!isfinite(*value)) return wrong(row, i, what, "a finite number");
  return LITHE_OK;
}

LitheStatus lth_inp_row_integer(const LthInpRow *row, int i, const char *what, LitheCount *value) {
  if (lth_inp_row_is_blank(row, i)) return missing(row, i, what, "an integer");
  if (!lth_word_integer(row->field[i], value)) return wrong(row, i, what, "an integer");
  return LITHE_OK;
}

LitheStatus lth_inp_row_fail(const LthInpRow *row, const char *format, ...) {
  char message[512];
  va_list args;
  va_start(args, format);
  vsnprintf(message, sizeof message, format, args);
  va_end(args);
  LITHE_FAIL(row->ctx, LITHE_BAD_INPUT, "%s:%d: %s", row->file, row->line, message);
}

LitheStatus lth_inp_card_fail(LitheCtx *ctx, const LthInpCard *card, const char *format, ...) {
  char message[512];
  va_list args;
  va_start(args, format);
  vsnprintf(message, sizeof message, format, args);
  va_end(args);
  LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s:%d: *%s: %s", card->file, card->line, card->keyword,
             message);
}
