/// Decks of keyword cards, the `.inp` files of CalculiX and Abaqus: cards with parameters, and their data lines.
#pragma once

#include "io/text.h"

/// NAME=VALUE of a card.
typedef struct LthInpParameter {
  char *name;  ///< upper case without blanks
  char *value; ///< as written, without blanks and quotes around it; "" where there is none
} LthInpParameter;

/// `*KEYWORD, NAME=VALUE, ...` and the data lines up to the next one.
typedef struct LthInpCard {
  char *keyword; ///< upper case without the star and without blanks: "SOLIDSECTION"
  LthInpParameter *parameters;
  int n_parameters;
  LitheIndex first_row, n_rows; ///< data lines, for lth_inp_row()
  const char *file;             ///< where the keyword stands
  LitheIndex line;
} LthInpCard;

/// A data line. Borrowed from the deck.
typedef struct LthInpLine {
  const char *at;
  int32_t length, file;
  LitheIndex line;
} LthInpLine;

/// A file of the deck: the first one, or one that *INCLUDE names.
typedef struct LthInpFile {
  char *path, *data;
  size_t size;
} LthInpFile;

/// A whole deck in the order of its lines, includes in their place; comments and blank lines are left out.
typedef struct LthInpDeck {
  LthInpCard *cards;
  LitheIndex n_cards;
  LthInpLine *lines;
  LitheIndex n_lines;
  LthInpFile *files;
  int n_files;
  LitheCount card_cap, line_cap, file_cap; ///< room in the arrays
} LthInpDeck;

/// Read a deck and the files it includes (relative to its own folder); free it with lth_inp_deck_destroy().
LitheStatus lth_inp_deck_read(LitheCtx *ctx, const char *path, LthInpDeck **deck);

/// The same from memory (copied); an *INCLUDE is an error.
LitheStatus lth_inp_deck_parse(LitheCtx *ctx, const char *name, const void *data, size_t size,
                               LthInpDeck **deck);

void lth_inp_deck_destroy(LitheCtx *ctx, LthInpDeck **deck);

/// Whether a card's keyword is `keyword`; blanks and upper or lower case do not matter.
bool lth_inp_is(const LthInpCard *card, const char *keyword);

/// The value of a parameter ("" where it has none), NULL where the card does not have it. `name`: upper case.
const char *lth_inp_parameter(const LthInpCard *card, const char *name);

/// Fields of a data line: what stands between its commas, without blanks and quotes around it. A comma at the end
/// of a line opens no further field; a field may be empty.
#define LTH_INP_FIELDS_MAX 64
typedef struct LthInpRow {
  LitheCtx *ctx;
  const char *file;
  LitheIndex line;
  int n_fields;
  LthWord field[LTH_INP_FIELDS_MAX];
} LthInpRow;

/// Split row `row` (first_row <= row < first_row + n_rows of a card) into fields.
LitheStatus lth_inp_row(LitheCtx *ctx, const LthInpDeck *deck, LitheIndex row, LthInpRow *fields);

/// True where field i is missing or empty.
bool lth_inp_row_is_blank(const LthInpRow *row, int i);

/// Field i as a finite number (1.5, 1.5e3, 1.5D3) or as an integer; `what` names it in the message.
LitheStatus lth_inp_row_number(const LthInpRow *row, int i, const char *what, double *value);
LitheStatus lth_inp_row_integer(const LthInpRow *row, int i, const char *what, LitheCount *value);

/// LITHE_BAD_INPUT with "file:line: " in front.
LitheStatus lth_inp_row_fail(const LthInpRow *row, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
/// LITHE_BAD_INPUT with "file:line: *KEYWORD: " in front.
LitheStatus lth_inp_card_fail(LitheCtx *ctx, const LthInpCard *card, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
