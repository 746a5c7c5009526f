/// YAML into nodes: places, aliases, and documents that are refused.
#include "check.h"
#include "scene/yaml.h"

#include <string.h>

typedef struct Document {
  LitheCtx *ctx;
  LthArena arena;
  LthReport report;
  LthSceneErrors errors;
  LthNode *root;
} Document;

static Document *parse_bytes(const char *text, size_t length) {
  static Document d;
  d = (Document){.ctx = test_ctx()};
  d.arena.ctx = d.ctx;
  d.report = (LthReport){.arena = &d.arena, .file = "s.yaml"};
  d.root = lth_yaml_parse(&d.report, text, length, NULL);
  CHECK_OK(d.ctx, lth_report_finish(&d.report, d.ctx, &d.errors));
  return &d;
}

static Document *parse(const char *text) { return parse_bytes(text, strlen(text)); }

static void end(Document *d) {
  lth_scene_errors_free(&d->errors);
  lth_arena_free(&d->arena);
  assert_int_equal(lth_alloc_bytes(d->ctx), 0);
  lithe_ctx_destroy(&d->ctx);
}

static void check_refused(const char *text, const char *line) {
  Document *d = parse(text);
  if (d->errors.n != 1) fail_msg("%d errors for: %s", d->errors.n, text);
  assert_string_equal(d->errors.lines[0], line);
  end(d);
}

static void keeps_the_place_of_every_value(void **state) {
  (void)state;
  Document *d = parse("a: 1\nb:\n  - {c: \"q\", 'd': [1, 22]}\n  -  x\n");
  const LthNode *c = lth_node_find(lth_node_at(lth_node_find(d->root, "b"), 0), "c");
  assert_string_equal(c->text, "q");
  assert_false(c->plain);
  assert_int_equal(c->line, 3);
  assert_int_equal(c->column, 9);
  assert_int_equal(c->key_column, 6);
  const LthNode *n = lth_node_at(lth_node_find(c->parent, "d"), 1);
  assert_string_equal(n->text, "22");
  assert_int_equal(n->column, 23);
  assert_string_equal(lth_node_path(&d->arena, n, NULL), "b.0.d.1");
  const LthNode *x = lth_node_at(lth_node_find(d->root, "b"), 1);
  assert_int_equal(x->line, 4);
  assert_int_equal(x->column, 6);
  end(d);
}

static void reads_json(void **state) {
  (void)state;
  Document *d = parse("{\"a\": [1, 2.5, null, true], \"b\": {\"c\": \"\\u00e9\"}}");
  assert_int_equal(d->errors.n, 0);
  assert_int_equal(lth_node_find(d->root, "a")->n_children, 4);
  assert_true(lth_node_is_null(lth_node_at(lth_node_find(d->root, "a"), 2)));
  assert_string_equal(lth_node_find(lth_node_find(d->root, "b"), "c")->text, "é");
  end(d);
}

static void copies_what_an_alias_means(void **state) {
  (void)state;
  Document *d = parse("a: &v [1, {b: 2}]\nc: *v\n");
  const LthNode *copy = lth_node_find(d->root, "c");
  assert_int_equal(copy->n_children, 2);
  assert_string_equal(lth_node_path(&d->arena, lth_node_find(lth_node_at(copy, 1), "b"), NULL),
                      "c.1.b");
  assert_ptr_not_equal(copy, lth_node_find(d->root, "a"));
  end(d);
}

static void refuses_what_is_not_one_document(void **state) {
  (void)state;
  check_refused("a: [1, 2\n",
                "s.yaml:2:1: not YAML: flow sequence without a closing bracket; expected "
                "YAML 1.2 or JSON");
  check_refused("a: \"x\n",
                "s.yaml:1:5: not YAML: double-quoted scalar without closing quote; expected "
                "YAML 1.2 or JSON");
  check_refused("a: 1\n---\nb: 2\n",
                "s.yaml:2:1: a second document begins, got ---; expected one document");
  check_refused("a: 1\nb: 2\na: 3\n",
                "s.yaml:3:1: a: the key is given twice, got it first in line 1; expected it once");
  check_refused("a: *b\n",
                "s.yaml:1:4: an alias (*) without its anchor (&); expected the anchor before it");
  check_refused("a: &b [*b]\n",
                "s.yaml:1:8: an alias (*) inside its own anchor (&); expected one that is "
                "complete");
  check_refused("[1]: 2\n",
                "s.yaml:1:1: a key must be a word, got a list or a mapping; expected `key: value`");
  check_refused(
      "a: !!str 5\n",
      "s.yaml:1:10: a YAML tag (!...) has no meaning in a scene; expected a value without it");
  check_refused("a: 'x''''y'\n",
                "s.yaml:1:4: several '' in a row in a single-quoted text; expected double "
                "quotes around it");
  check_refused("a: \"x\\0y\"\n", "s.yaml:1:4: a zero byte in a text, got \\0; expected letters");
}

static void refuses_bytes_that_are_no_text(void **state) {
  (void)state;
  check_refused("a: 1\nb: \xff\n", "s.yaml:2:4: not UTF-8, got byte 0xff; expected UTF-8 text");
  check_refused("a: \xc0\x80\n", "s.yaml:1:4: not UTF-8, got byte 0xc0; expected UTF-8 text");
  check_refused("a: \x01\n", "s.yaml:1:4: a control character, got byte 0x01; expected UTF-8 text");
  Document *d = parse_bytes("a\0b", 3);
  assert_string_equal(d->errors.lines[0],
                      "s.yaml:1:2: a control character, got byte 0x00; expected UTF-8 text");
  end(d);
}

static void refuses_depth_and_growth_without_end(void **state) {
  (void)state;
  char deep[200];
  memset(deep, '[', sizeof deep - 1);
  deep[sizeof deep - 1] = 0;
  check_refused(deep, "s.yaml:1:49: nested too deep, got more than 48 levels; expected a scene");
  // ten copies of ten copies of ...: 1e9 values in 200 bytes
  char bomb[1000] = "a0: &a0 [1,1,1,1,1,1,1,1,1,1]\n";
  for (int i = 1; i < 9; i++) {
    char line[100];
    snprintf(line, sizeof line, "a%d: &a%d [*a%d,*a%d,*a%d,*a%d,*a%d,*a%d,*a%d,*a%d,*a%d,*a%d]\n",
             i, i, i - 1, i - 1, i - 1, i - 1, i - 1, i - 1, i - 1, i - 1, i - 1, i - 1);
    strcat(bomb, line);
  }
  Document *d = parse(bomb);
  assert_null(d->root);
  assert_int_equal(d->errors.n, 1);
  assert_non_null(strstr(d->errors.lines[0], "aliases make the document too large or too deep"));
  end(d);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(keeps_the_place_of_every_value),
      cmocka_unit_test(reads_json),
      cmocka_unit_test(copies_what_an_alias_means),
      cmocka_unit_test(refuses_what_is_not_one_document),
      cmocka_unit_test(refuses_bytes_that_are_no_text),
      cmocka_unit_test(refuses_depth_and_growth_without_end),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
