/// Reading words and numbers from text in memory: bounds-checked, line by line, without the locale.
#pragma once

#include "base/ctx.h"

/// A place in a text. Lines end with LF, CR LF or CR; words are separated by blanks and tabs.
typedef struct LthText {
  LitheCtx *ctx;
  const char *name; ///< of the file, for messages
  const char *at;   ///< next character
  const char *end;
  LitheCount line;  ///< of `at`, from 1
  char comment;     ///< a word that begins with it ends the line; 0 for none
  bool joins_lines; ///< a backslash before the line end continues the line
} LthText;

/// A word of a text, not 0-terminated.
typedef struct LthWord {
  const char *at;
  size_t length;
} LthWord;

LthText lth_text(LitheCtx *ctx, const char *name, const char *data, size_t size);

/// The next word of this line; false at its end.
bool lth_text_word(LthText *text, LthWord *word);
/// The next word of the text, on this line or a later one; false at the end of the text.
bool lth_text_word_across(LthText *text, LthWord *word);
/// What is left of this line without surrounding blanks (comments are part of it).
LthWord lth_text_rest(LthText *text);
/// Go to the start of the next line; false if there is none.
bool lth_text_next_line(LthText *text);

bool lth_word_is(LthWord word, const char *text);          ///< equal
bool lth_word_is_any_case(LthWord word, const char *text); ///< equal but for upper and lower case

/// A decimal number, correctly rounded; false if the word is not one (or has over 500 characters).
bool lth_word_number(LthWord word, double *value);
/// A decimal integer that fits; false if the word is not one.
bool lth_word_integer(LthWord word, LitheCount *value);

/// The calling thread's locale before lth_text_locale_begin().
typedef struct LthTextLocale {
  void *before;
} LthTextLocale;

/// Between these two, printf() of this thread writes numbers with a point, whatever the program's locale.
LthTextLocale lth_text_locale_begin(void);
void lth_text_locale_end(LthTextLocale before);

/// LITHE_BAD_INPUT with "name:line: " in front.
LitheStatus lth_text_fail(const LthText *text, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/// The next word of this line as a finite number or an integer; `what` names it in the message.
LitheStatus lth_text_number(LthText *text, const char *what, double *value);
LitheStatus lth_text_integer(LthText *text, const char *what, LitheCount *value);
