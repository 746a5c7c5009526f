/// Decks of keyword cards: lines sorted into cards, continued keyword lines joined, includes in their place.
#include "io/inp_deck.h"

#include "io/file.h"

#include <ctype.h>
#include <string.h>

/// Includes within includes; a file that includes itself ends here.
#define DEPTH_MAX 16
#define FILES_MAX 10000

static void free_card(LitheCtx *ctx, LthInpCard *card) {
  for (int p = 0; p < card->n_parameters; p++) {
    lth_free(ctx, card->parameters[p].name);
    lth_free(ctx, card->parameters[p].value);
  }
  lth_free(ctx, card->keyword);
  lth_free(ctx, card->parameters);
}

void lth_inp_deck_destroy(LitheCtx *ctx, LthInpDeck **deck) {
  if (!deck || !*deck) return;
  LthInpDeck *d = *deck;
  for (LitheIndex c = 0; c < d->n_cards; c++) free_card(ctx, &d->cards[c]);
  for (int f = 0; f < d->n_files; f++) {
    lth_free(ctx, d->files[f].path);
    lth_free(ctx, d->files[f].data);
  }
  lth_free(ctx, d->cards);
  lth_free(ctx, d->lines);
  lth_free(ctx, d->files);
  lth_free(ctx, d);
  *deck = NULL;
}

/// The next thing between commas of a keyword line, without blanks around it; false at the line's end.
static bool next_item(LthWord *rest, LthWord *item) {
  if (rest->length == 0) return false;
  const char *comma = memchr(rest->at, ',', rest->length);
  *item = (LthWord){rest->at, comma ? (size_t)(comma - rest->at) : rest->length};
  size_t used = item->length + (comma != NULL);
  rest->at += used;
  rest->length -= used;
  while (item->length > 0 && isspace((unsigned char)item->at[0])) item->at++, item->length--;
  while (item->length > 0 && isspace((unsigned char)item->at[item->length - 1])) item->length--;
  return true;
}

/// A name in upper case without any blanks.
static LitheStatus copy_name(LitheCtx *ctx, LthWord word, char **copy) {
  LTH_NEW(ctx, *copy, (LitheCount)word.length + 1);
  size_t n = 0;
  for (size_t i = 0; i < word.length; i++)
    if (!isspace((unsigned char)word.at[i]))
      (*copy)[n++] = (char)toupper((unsigned char)word.at[i]);
  return LITHE_OK;
}

/// A value as it is written, without blanks and quotes around it.
static LitheStatus copy_value(LitheCtx *ctx, LthWord word, char **copy) {
  while (word.length > 0 && (isspace((unsigned char)word.at[0]) || word.at[0] == '"'))
    word.at++, word.length--;
  while (word.length > 0 &&
         (isspace((unsigned char)word.at[word.length - 1]) || word.at[word.length - 1] == '"'))
    word.length--;
  LTH_NEW(ctx, *copy, (LitheCount)word.length + 1);
  if (word.length > 0) memcpy(*copy, word.at, word.length);
  return LITHE_OK;
}

static LitheStatus add_parameter(LitheCtx *ctx, LthInpCard *card, LitheCount *cap, LthWord item) {
  const char *equal = item.length > 0 ? memchr(item.at, '=', item.length) : NULL;
  size_t n_name = equal ? (size_t)(equal - item.at) : item.length;
  LTH_RESERVE(ctx, card->parameters, *cap, card->n_parameters + 1);
  LthInpParameter *p = &card->parameters[card->n_parameters++];
  size_t n_value = equal ? item.length - n_name - 1 : 0;
  LITHE_TRY(copy_name(ctx, (LthWord){item.at, n_name}, &p->name));
  return copy_value(ctx, (LthWord){equal ? equal + 1 : item.at, n_value}, &p->value);
}

/// Fill a card from its keyword line, the star left out.
static LitheStatus parse_card(LitheCtx *ctx, LthWord line, LthInpCard *card) {
  LthWord item = {line.at, 0};
  LitheCount cap = 0;
  next_item(&line, &item);
  LITHE_TRY(copy_name(ctx, item, &card->keyword));
  while (next_item(&line, &item))
    if (item.length > 0) LITHE_TRY(add_parameter(ctx, card, &cap, item));
  return LITHE_OK;
}

bool lth_inp_is(const LthInpCard *card, const char *keyword) {
  const char *a = card->keyword;
  for (const char *b = keyword; *b; b++) {
    if (*b == ' ') continue;
    if (*a++ != (char)toupper((unsigned char)*b)) return false;
  }
  return *a == 0;
}

const char *lth_inp_parameter(const LthInpCard *card, const char *name) {
  for (int p = 0; p < card->n_parameters; p++)
    if (strcmp(card->parameters[p].name, name) == 0) return card->parameters[p].value;
  return NULL;
}

/// Where the reader is: one open file.
typedef struct DeckReader {
  LitheCtx *ctx;
  LthInpDeck *deck;
  LthText text;
  int file, depth;
} DeckReader;

/// The line at `text` without blanks around it; false for a comment or a blank line.
static bool current_line(DeckReader *r, LthWord *line) {
  *line = lth_text_rest(&r->text);
  return line->length > 0 && !(line->length > 1 && line->at[0] == '*' && line->at[1] == '*');
}

/// A keyword line and, while it ends in a comma and no other card begins, the lines that continue it.
static LitheStatus join_keyword(DeckReader *r, LthWord line, char **joined, LitheCount *length) {
  LitheCount cap = 0;
  for (;;) {
    LTH_RESERVE(r->ctx, *joined, cap, *length + (LitheCount)line.length + 1);
    memcpy(*joined + *length, line.at, line.length);
    *length += (LitheCount)line.length;
    if ((*joined)[*length - 1] != ',') return LITHE_OK;
    LthText ahead = r->text;
    if (!lth_text_next_line(&ahead)) return LITHE_OK;
    LthWord next = lth_text_rest(&ahead);
    if (next.length == 0 || next.at[0] == '*') return LITHE_OK;
    r->text = ahead;
    line = next;
  }
}

static LitheStatus read_file(DeckReader *outer, const char *path, int depth);

/// Everything up to the last slash of a path.
static LitheStatus folder_of(LitheCtx *ctx, const char *path, char **folder) {
  const char *slash = strrchr(path, '/');
  LITHE_TRY(lth_copy_text(ctx, slash ? path : "", folder));
  if (slash) (*folder)[slash - path + 1] = 0;
  return LITHE_OK;
}

static LitheStatus include(DeckReader *r, const LthInpCard *card) {
  const char *input = lth_inp_parameter(card, "INPUT");
  if (!input || !*input)
    return lth_inp_card_fail(r->ctx, card, "names no file, expected INPUT=file");
  if (r->depth == 0)
    return lth_inp_card_fail(r->ctx, card, "'%s' cannot be followed from here", input);
  if (r->depth >= DEPTH_MAX || r->deck->n_files >= FILES_MAX)
    return lth_inp_card_fail(r->ctx, card,
                             "'%s' is included over %d levels deep: a file includes itself", input,
                             DEPTH_MAX);
  char *folder = NULL, *path = NULL;
  LitheStatus status = LITHE_OK;
  LITHE_TRY_OR(done, folder_of(r->ctx, r->deck->files[0].path, &folder));
  LITHE_TRY_OR(done, lth_path_join(r->ctx, folder, input, &path));
  LITHE_TRY_OR(done, read_file(r, path, r->depth + 1));
done:
  lth_free(r->ctx, folder);
  lth_free(r->ctx, path);
  return status;
}

/// Enter the card at `line`, or the file it includes.
static LitheStatus read_card(DeckReader *r, LthWord line) {
  LitheStatus status = LITHE_OK;
  LthInpDeck *d = r->deck;
  char *joined = NULL;
  LitheCount length = 0;
  LTH_RESERVE(r->ctx, d->cards, d->card_cap, d->n_cards + 1);
  LthInpCard *card = &d->cards[d->n_cards];
  *card = (LthInpCard){.file = d->files[r->file].path, .line = (LitheIndex)r->text.line};
  d->n_cards++; // from here on it is freed with the deck
  LITHE_TRY_OR(done, join_keyword(r, line, &joined, &length));
  LITHE_TRY_OR(done, parse_card(r->ctx, (LthWord){joined + 1, (size_t)length - 1}, card));
  card->first_row = d->n_lines;
  if (card->keyword[0] == 0)
    LITHE_TRY_OR(done, lth_inp_card_fail(r->ctx, card, "a star without a keyword"));
  if (!lth_inp_is(card, "INCLUDE")) goto done;

  // the lines of the file belong to the card before: the include itself is taken out again
  LthInpCard taken = *card;
  d->n_cards--;
  status = include(r, &taken);
  free_card(r->ctx, &taken);
done:
  lth_free(r->ctx, joined);
  return status;
}

static LitheStatus add_line(DeckReader *r, LthWord line) {
  LthInpDeck *d = r->deck;
  if (d->n_cards == 0)
    return lth_text_fail(&r->text, "data '%.*s' stand before the first keyword, expected *KEYWORD",
                         line.length < 40 ? (int)line.length : 40, line.at);
  if (line.length > INT32_MAX || d->n_lines == INT32_MAX || r->text.line >= INT32_MAX)
    return lth_text_fail(&r->text, "the deck has more lines than can be counted");
  LTH_RESERVE(r->ctx, d->lines, d->line_cap, d->n_lines + 1);
  d->lines[d->n_lines++] =
      (LthInpLine){line.at, (int32_t)line.length, r->file, (LitheIndex)r->text.line};
  d->cards[d->n_cards - 1].n_rows++;
  return LITHE_OK;
}

static LitheStatus read_lines(DeckReader *r) {
  LthWord line;
  do {
    if (!current_line(r, &line)) continue;
    LITHE_TRY(line.at[0] == '*' ? read_card(r, line) : add_line(r, line));
  } while (lth_text_next_line(&r->text));
  return LITHE_OK;
}

/// Take over a file's contents and read its lines.
static LitheStatus read_data(LitheCtx *ctx, LthInpDeck *deck, const char *path, char **data,
                             size_t size, int depth) {
  LTH_RESERVE(ctx, deck->files, deck->file_cap, deck->n_files + 1);
  LthInpFile *file = &deck->files[deck->n_files];
  *file = (LthInpFile){.size = size};
  LITHE_TRY(lth_copy_text(ctx, path, &file->path));
  file->data = *data;
  *data = NULL;
  deck->n_files++;
  DeckReader r = {ctx, deck, lth_text(ctx, file->path, file->data, size), deck->n_files - 1, depth};
  return read_lines(&r);
}

static LitheStatus read_file(DeckReader *outer, const char *path, int depth) {
  char *data = NULL;
  size_t size = 0;
  LITHE_TRY(lth_file_read(outer->ctx, path, &data, &size));
  LitheStatus status = read_data(outer->ctx, outer->deck, path, &data, size, depth);
  lth_free(outer->ctx, data);
  return status;
}

LitheStatus lth_inp_deck_read(LitheCtx *ctx, const char *path, LthInpDeck **deck) {
  *deck = NULL;
  LTH_NEW(ctx, *deck, 1);
  DeckReader r = {.ctx = ctx, .deck = *deck};
  LitheStatus status = read_file(&r, path, 1);
  if (status != LITHE_OK) lth_inp_deck_destroy(ctx, deck);
  return status;
}

LitheStatus lth_inp_deck_parse(LitheCtx *ctx, const char *name, const void *data, size_t size,
                               LthInpDeck **deck) {
  LitheStatus status = LITHE_OK;
  char *copy = NULL;
  *deck = NULL;
  LTH_NEW_OR(done, ctx, *deck, 1);
  LTH_NEW_OR(done, ctx, copy, (LitheCount)size + 1);
  if (size > 0) memcpy(copy, data, size);
  LITHE_TRY_OR(done, read_data(ctx, *deck, name, &copy, size, 0));
done:
  lth_free(ctx, copy);
  if (status != LITHE_OK) lth_inp_deck_destroy(ctx, deck);
  return status;
}
