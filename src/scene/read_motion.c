/// Motion of colliders: expressions of time, or a table of places that is linear between its rows.
#include "scene/reader.h"

#include "base/tensor.h"
#include "io/file.h"
#include "io/text.h"

#include <string.h>

/// Rows (t, x, y, z) with rising t.
typedef struct KeyTable {
  LitheIndex n;
  double *rows; ///< (n x 4)
} KeyTable;

/// One column of a table as a value of time.
typedef struct KeyColumn {
  const KeyTable *table;
  int column;
} KeyColumn;

static double eval_key(const void *self, const double x[3], double t) {
  (void)x;
  const KeyColumn *c = self;
  const double *rows = c->table->rows;
  LitheIndex low = 0, high = c->table->n - 1;
  if (t <= rows[0]) return rows[c->column];
  if (t >= rows[4 * (size_t)high]) return rows[4 * (size_t)high + (size_t)c->column];
  while (high - low > 1) {
    LitheIndex middle = low + (high - low) / 2;
    if (rows[4 * (size_t)middle] <= t)
      low = middle;
    else
      high = middle;
  }
  const double *a = rows + 4 * (size_t)low, *b = rows + 4 * (size_t)high;
  return a[c->column] + (t - a[0]) / (b[0] - a[0]) * (b[c->column] - a[c->column]);
}

/// "0.5, 0, 0.1, 0" or with blanks; commas were turned into blanks before.
static LitheStatus parse_row(LthText *text, int dim, double row[4]) {
  static const char *const names[] = {"t", "x", "y", "z"};
  row[3] = 0;
  for (int i = 0; i <= dim; i++) LITHE_TRY(lth_text_number(text, names[i], &row[i]));
  LthWord more;
  if (lth_text_word(text, &more))
    return lth_text_fail(text, dim == 3 ? "more than four columns; expected t, x, y, z"
                                        : "more than three columns; expected t, x, y");
  return LITHE_OK;
}

/// Does the line begin with a number? Else it is the header or empty.
static bool is_row(LthText line) {
  LthWord word;
  double number;
  return lth_text_word(&line, &word) && lth_word_number(word, &number);
}

static bool is_blank(LthText line) {
  LthWord word;
  return !lth_text_word(&line, &word);
}

static LitheStatus parse_table(LthReader *r, LthText *text, KeyTable *table) {
  LitheCount cap = 0;
  double *rows = NULL;
  LitheStatus status = LITHE_OK;
  for (bool is_first = true, has_line = true; has_line; has_line = lth_text_next_line(text)) {
    if (is_blank(*text)) continue;
    if (is_first && !is_row(*text)) {
      is_first = false;
      continue;
    }
    is_first = false;
    LTH_RESERVE_OR(done, r->ctx, rows, cap, 4 * (LitheCount)(table->n + 1));
    double *row = rows + 4 * (size_t)table->n;
    LITHE_TRY_OR(done, parse_row(text, r->scene->dimension, row));
    if (table->n > 0 && !(row[0] > row[-4])) {
      status = lth_text_fail(text, "time %g does not come after %g; expected rising times", row[0],
                             row[-4]);
      goto done;
    }
    table->n++;
  }
  if (table->n == 0) {
    status = lth_text_fail(text, "no rows; expected lines of t, x, y%s",
                           r->scene->dimension == 3 ? ", z" : "");
    goto done;
  }
  table->rows = lth_arena_take(r->arena, 4 * (size_t)table->n * sizeof *rows);
  if (table->rows) memcpy(table->rows, rows, 4 * (size_t)table->n * sizeof *rows);
  if (!table->rows)
    status = lth_fail(r->ctx, LITHE_NO_MEMORY, "out of memory while reading the scene");

done:
  lth_free(r->ctx, rows);
  return status;
}

static LitheStatus read_table(LthReader *r, const LthNode *keys, KeyTable *table) {
  const char *path = NULL;
  char *data = NULL;
  size_t size = 0;
  *table = (KeyTable){0};
  if (!r->opens_files) return LITHE_OK;
  LITHE_TRY(lth_find_file(r, keys, &path));
  if (!path) return LITHE_OK;
  LitheStatus status = lth_file_read(r->ctx, path, &data, &size);
  if (status == LITHE_OK) {
    for (size_t i = 0; i < size; i++)
      if (data[i] == ',' || data[i] == ';') data[i] = ' ';
    LthText text = lth_text(r->ctx, keys->text, data, size);
    text.comment = '#';
    status = parse_table(r, &text, table);
  }
  lth_free(r->ctx, data);
  if (status != LITHE_BAD_INPUT) return status;
  table->rows = NULL;
  lth_report(r->report, keys, "%s", lithe_ctx_message(r->ctx));
  return LITHE_OK;
}

static LitheStatus read_keys(LthReader *r, const LthNode *keys, LthCollider *collider) {
  KeyTable *table = lth_arena_take(r->arena, sizeof *table);
  KeyColumn *columns = lth_arena_take(r->arena, 3 * sizeof *columns);
  if (!table || !columns)
    LITHE_FAIL(r->ctx, LITHE_NO_MEMORY, "out of memory while reading the scene");
  LITHE_TRY(read_table(r, keys, table));
  for (int i = 0; i < 3 && table->rows; i++) {
    columns[i] = (KeyColumn){table, i + 1};
    collider->translation[i] = (LthValue){.eval = eval_key, .self = &columns[i]};
  }
  return LITHE_OK;
}

static void read_list(const LthNode *list, LthValue v[3]) {
  int i = 0;
  for (const LthNode *item = list->first; item && i < 3; item = item->next, i++)
    v[i] = item->has_value ? item->value : (LthValue){0};
}

LitheStatus lth_read_motion(LthReader *r, const LthNode *motion, LthCollider *collider) {
  collider->axis[2] = 1;
  if (!motion) return LITHE_OK;
  if (motion->kind == LTH_NODE_LIST) {
    read_list(motion, collider->translation);
    return LITHE_OK;
  }
  lth_read_values(motion, "translate", collider->translation);
  const LthNode *rotate = lth_node_get(motion, "rotate");
  bool has_axis =
      r->scene->dimension == 2 || (rotate && lth_read_direction(r, rotate, "axis", collider->axis));
  if (rotate && has_axis) {
    collider->angle = lth_read_value(rotate, "angle");
    lth_read_vector(rotate, "pivot", collider->pivot);
  }
  const LthNode *keys = lth_node_get(motion, "keys");
  return keys ? read_keys(r, keys, collider) : LITHE_OK;
}
