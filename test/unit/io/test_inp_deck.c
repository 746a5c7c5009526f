/// Keyword decks: cards, parameters and data lines as CalculiX and Abaqus read them.
#include "check.h"
#include "io/inp_deck.h"
#include "scratch_folder.h"

static LthInpDeck *parse(LitheCtx *ctx, const char *text) {
  LthInpDeck *deck = NULL;
  CHECK_OK(ctx, lth_inp_deck_parse(ctx, "d.inp", text, strlen(text), &deck));
  return deck;
}

static void cards_have_keywords_parameters_and_lines(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthInpDeck *deck = parse(ctx, "** a comment\r\n"
                                "*Heading\r\n"
                                " any text, of the user\r\n"
                                "*Solid  Section, elset = \"Part 1\", MATERIAL=Steel,\r\n"
                                "  orientation\r\n"
                                "\r\n"
                                "** in between\r\n"
                                "1., , 2.5D-3 ,name,\r\n"
                                " * Step\r\n");
  assert_int_equal(deck->n_cards, 3);
  const LthInpCard *section = &deck->cards[1];
  assert_true(lth_inp_is(&deck->cards[0], "heading"));
  assert_true(lth_inp_is(section, "SOLID SECTION"));
  assert_false(lth_inp_is(section, "SOLID"));
  assert_false(lth_inp_is(section, "SOLID SECTIONS"));
  assert_true(lth_inp_is(&deck->cards[2], "STEP"));
  assert_string_equal(section->keyword, "SOLIDSECTION");
  assert_string_equal(lth_inp_parameter(section, "ELSET"), "Part 1");
  assert_string_equal(lth_inp_parameter(section, "MATERIAL"), "Steel");
  assert_string_equal(lth_inp_parameter(section, "ORIENTATION"), "");
  assert_null(lth_inp_parameter(section, "NSET"));
  assert_int_equal(section->line, 4);
  assert_int_equal(deck->cards[0].n_rows, 1);
  assert_int_equal(section->n_rows, 1);
  assert_int_equal(deck->cards[2].n_rows, 0);

  LthInpRow row;
  double x = 0;
  LitheCount k = 0;
  CHECK_OK(ctx, lth_inp_row(ctx, deck, section->first_row, &row));
  assert_int_equal(row.n_fields, 4);
  assert_int_equal(row.line, 8);
  CHECK_OK(ctx, lth_inp_row_number(&row, 0, "a", &x));
  CHECK_NEAR(x, 1, 0);
  CHECK_OK(ctx, lth_inp_row_number(&row, 2, "c", &x));
  CHECK_NEAR(x, 2.5e-3, 0);
  assert_true(lth_inp_row_is_blank(&row, 1));
  assert_true(lth_inp_row_is_blank(&row, 4));
  assert_int_equal(lth_inp_row_integer(&row, 3, "the count", &k), LITHE_BAD_INPUT);
  assert_string_equal(lithe_ctx_message(ctx), "d.inp:8: the count is 'name', expected an integer");
  assert_int_equal(lth_inp_row_number(&row, 1, "b", &x), LITHE_BAD_INPUT);
  assert_string_equal(lithe_ctx_message(ctx),
                      "d.inp:8: b is missing, expected a number as entry 2 of the line");
  lth_inp_card_fail(ctx, section, "no");
  assert_string_equal(lithe_ctx_message(ctx), "d.inp:4: *SOLIDSECTION: no");
  lth_inp_deck_destroy(ctx, &deck);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void write_text(const char *name, const char *text) {
  char path[128];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  FILE *stream = fopen(path, "w");
  fputs(text, stream);
  fclose(stream);
}

/// Lines of an included file belong to the card before, and so do those that follow the include.
static void includes_stand_in_their_place(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthInpDeck *deck = NULL;
  LthInpRow row;
  char path[128];
  write_text("main.inp", "*NODE\n1,0\n*INCLUDE,INPUT=more.txt\n4,0\n*STEP\n");
  write_text("more.txt", "2,0\n**\n3,0\n*ELEMENT\n");
  snprintf(path, sizeof path, "%s/main.inp", folder);
  CHECK_OK(ctx, lth_inp_deck_read(ctx, path, &deck));
  assert_int_equal(deck->n_cards, 3);
  assert_int_equal(deck->cards[0].n_rows, 3);
  assert_int_equal(deck->cards[1].n_rows, 1);
  CHECK_OK(ctx, lth_inp_row(ctx, deck, 2, &row));
  assert_int_equal(row.line, 3);
  assert_non_null(strstr(row.file, "more.txt"));
  assert_non_null(strstr(deck->cards[1].file, "more.txt"));
  assert_non_null(strstr(deck->cards[2].file, "main.inp"));
  lth_inp_deck_destroy(ctx, &deck);

  write_text("more.txt", "*INCLUDE,INPUT=main.inp\n");
  assert_int_equal(lth_inp_deck_read(ctx, path, &deck), LITHE_BAD_INPUT);
  assert_non_null(strstr(lithe_ctx_message(ctx), "includes itself"));
  write_text("more.txt", "*INCLUDE\n");
  assert_int_equal(lth_inp_deck_read(ctx, path, &deck), LITHE_BAD_INPUT);
  assert_non_null(strstr(lithe_ctx_message(ctx), "more.txt:1: *INCLUDE: names no file"));
  write_text("more.txt", "*INCLUDE,INPUT=nowhere.inp\n");
  assert_int_equal(lth_inp_deck_read(ctx, path, &deck), LITHE_BAD_INPUT);
  assert_non_null(strstr(lithe_ctx_message(ctx), "nowhere.inp: cannot be read"));
  assert_null(deck);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void what_is_not_a_deck_is_refused(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthInpDeck *deck = NULL;
  assert_int_equal(lth_inp_deck_parse(ctx, "d.inp", "\n1,2\n", 5, &deck), LITHE_BAD_INPUT);
  assert_string_equal(lithe_ctx_message(ctx),
                      "d.inp:2: data '1,2' stand before the first keyword, expected *KEYWORD");
  assert_int_equal(lth_inp_deck_parse(ctx, "d.inp", "* \n", 3, &deck), LITHE_BAD_INPUT);
  assert_non_null(strstr(lithe_ctx_message(ctx), "a star without a keyword"));
  const char *alone = "*NODE\n*INCLUDE,INPUT=a.inp";
  assert_int_equal(lth_inp_deck_parse(ctx, "d.inp", alone, strlen(alone), &deck), LITHE_BAD_INPUT);
  deck = parse(ctx, "");
  assert_int_equal(deck->n_cards, 0);
  lth_inp_deck_destroy(ctx, &deck);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(cards_have_keywords_parameters_and_lines),
      cmocka_unit_test(includes_stand_in_their_place),
      cmocka_unit_test(what_is_not_a_deck_is_refused),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
