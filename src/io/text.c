/// Words and numbers of a text in memory.
#define _GNU_SOURCE // strtod_l
#include "io/text.h"

#include <locale.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define NUMBER_MAX 500

LthText lth_text(LitheCtx *ctx, const char *name, const char *data, size_t size) {
  // editors on Windows put a byte order mark in front of UTF-8
  size_t mark = size >= 3 && memcmp(data, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
  return (LthText){.ctx = ctx, .name = name, .at = data + mark, .end = data + size, .line = 1};
}

static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
static bool is_line_end(char c) { return c == '\n' || c == '\r'; }

/// Length of the line end at `at`: 0, 1 or 2 characters.
static int line_end_length(const char *at, const char *end) {
  if (at == end || !is_line_end(*at)) return 0;
  return *at == '\r' && end - at > 1 && at[1] == '\n' ? 2 : 1;
}

/// Length of a backslash with its line end, 0 where there is none.
static int joint_length(const LthText *text) {
  if (!text->joins_lines || text->at == text->end || *text->at != '\\') return 0;
  int length = line_end_length(text->at + 1, text->end);
  return length ? length + 1 : 0;
}

static void skip_blanks(LthText *text) {
  while (text->at < text->end) {
    int joint = joint_length(text);
    if (joint) {
      text->at += joint;
      text->line++;
    } else if (is_blank(*text->at)) {
      text->at++;
    } else {
      break;
    }
  }
}

bool lth_text_word(LthText *text, LthWord *word) {
  skip_blanks(text);
  const char *start = text->at;
  if (start == text->end || is_line_end(*start) || (text->comment && *start == text->comment))
    return false;
  while (text->at < text->end && !is_blank(*text->at) && !is_line_end(*text->at) &&
         !joint_length(text))
    text->at++;
  *word = (LthWord){start, (size_t)(text->at - start)};
  return true;
}

bool lth_text_word_across(LthText *text, LthWord *word) {
  while (!lth_text_word(text, word))
    if (!lth_text_next_line(text)) return false;
  return true;
}

LthWord lth_text_rest(LthText *text) {
  skip_blanks(text);
  const char *start = text->at;
  while (text->at < text->end && !is_line_end(*text->at)) text->at++;
  const char *stop = text->at;
  while (stop > start && is_blank(stop[-1])) stop--;
  return (LthWord){start, (size_t)(stop - start)};
}

bool lth_text_next_line(LthText *text) {
  while (text->at < text->end && !is_line_end(*text->at)) {
    int joint = joint_length(text);
    if (joint) text->line++;
    text->at += joint ? joint : 1;
  }
  int length = line_end_length(text->at, text->end);
  text->at += length;
  text->line += length > 0;
  return text->at < text->end;
}

bool lth_word_is(LthWord word, const char *text) {
  return strlen(text) == word.length && memcmp(word.at, text, word.length) == 0;
}

bool lth_word_is_any_case(LthWord word, const char *text) {
  return strlen(text) == word.length && strncasecmp(word.at, text, word.length) == 0;
}

static locale_t c_locale;
static void make_c_locale(void) { c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0); }

static locale_t get_c_locale(void) {
  static pthread_once_t once = PTHREAD_ONCE_INIT;
  pthread_once(&once, make_c_locale);
  return c_locale;
}

LthTextLocale lth_text_locale_begin(void) { return (LthTextLocale){uselocale(get_c_locale())}; }
void lth_text_locale_end(LthTextLocale before) { uselocale((locale_t)before.before); }

/// The library's conversion in the C locale, for numbers that the short way cannot round exactly.
static bool number_slow(LthWord word, double *value) {
  locale_t locale = get_c_locale();
  char copy[NUMBER_MAX + 1], *stop = NULL;
  if (word.length > NUMBER_MAX) return false;
  memcpy(copy, word.at, word.length);
  copy[word.length] = 0;
  *value = locale ? strtod_l(copy, &stop, locale) : strtod(copy, &stop);
  return stop == copy + word.length;
}

/// Clinger's exact case: at most 15 digits and a power of ten that is itself exact.
static bool number_fast(LthWord word, double *value) {
  static const double powers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                  1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                  1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
  const char *at = word.at, *end = at + word.length;
  bool negative = at < end && *at == '-';
  if (at < end && (*at == '-' || *at == '+')) at++;
  int64_t digits = 0;
  int n = 0, shift = 0;
  bool in_fraction = false;
  for (; at < end; at++) {
    if (*at == '.' && !in_fraction) {
      in_fraction = true;
    } else if (*at >= '0' && *at <= '9') {
      if (++n > 15) return false;
      digits = 10 * digits + (*at - '0');
      shift -= in_fraction;
    } else {
      return false;
    }
  }
  if (n == 0) return false;
  *value = (double)digits / powers[-shift];
  if (negative) *value = -*value;
  return true;
}

bool lth_word_number(LthWord word, double *value) {
  return number_fast(word, value) || number_slow(word, value);
}

bool lth_word_integer(LthWord word, LitheCount *value) {
  const char *at = word.at, *end = at + word.length;
  bool negative = at < end && *at == '-';
  if (at < end && (*at == '-' || *at == '+')) at++;
  if (at == end) return false;
  LitheCount n = 0;
  for (; at < end; at++) {
    if (*at < '0' || *at > '9') return false;
    if (__builtin_mul_overflow(n, 10, &n) || __builtin_add_overflow(n, *at - '0', &n)) return false;
  }
  *value = negative ? -n : n;
  return true;
}

LitheStatus lth_text_fail(const LthText *text, const char *format, ...) {
  char message[512];
  va_list args;
  va_start(args, format);
  vsnprintf(message, sizeof message, format, args);
  va_end(args);
  LITHE_FAIL(text->ctx, LITHE_BAD_INPUT, "%s:%lld: %s", text->name, (long long)text->line, message);
}

/// As much of a word as fits into a message.
static int shown_length(LthWord word) { return word.length < 40 ? (int)word.length : 40; }

LitheStatus lth_text_number(LthText *text, const char *what, double *value) {
  LthWord word;
  if (!lth_text_word(text, &word))
    return lth_text_fail(text, "%s is missing, expected a number", what);
  if (!lth_word_number(word, value))
    return lth_text_fail(text, "%s is '%.*s', expected a number", what, shown_length(word),
                         word.at);
  if (!isfinite(*value))
    return lth_text_fail(text, "%s is '%.*s', expected a finite number", what, shown_length(word),
                         word.at);
  return LITHE_OK;
}

LitheStatus lth_text_integer(LthText *text, const char *what, LitheCount *value) {
  LthWord word;
  if (!lth_text_word(text, &word))
    return lth_text_fail(text, "%s is missing, expected an integer", what);
  if (!lth_word_integer(word, value))
    return lth_text_fail(text, "%s is '%.*s', expected an integer", what, shown_length(word),
                         word.at);
  return LITHE_OK;
}
